// SPDX-License-Identifier: MIT
//
// Contact problems of known scenes as plain data, for tests and benchmarks: box on the floor, stack, pyramid,
// brick wall, chain of discs, heap of discs, random small islands. Unit boxes and discs of unit density, SI.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "physics/islands/island_system.h"

namespace skerry::scenes {

enum class MassPattern { Uniform, HeavyOnTop, Alternating, Random };

struct SceneOptions {
  double friction = 0.5;  ///< 0: no friction rows
  double rolling = 0;     ///< [m]; 0: no rolling rows
  double mass_ratio = 1;  ///< heaviest to lightest
  MassPattern pattern = MassPattern::Uniform;
  int points_per_edge = 2;             ///< contact points on an edge, 1 or more
  bool duplicated = false;             ///< every contact twice
  double gravity_impulse = 10.0 / 60;  ///< g h: downward speed that gravity adds in the step [m/s]
  double noise = 0;                    ///< amplitude of random free velocities [m/s], [rad/s]
  double shock = 0;                    ///< sideways speed of the body in the middle [m/s]
  std::uint64_t seed = 1;
};

/// A contact problem with the free velocity it was made from: b = -J v*.
struct Scene {
  IslandSystem system;
  std::vector<std::array<double, 3>> free_velocity;  ///< (vx, vy, omega) a body
};

/// Puts a scene together, body by body and contact by contact.
class SceneBuilder {
 public:
  explicit SceneBuilder(const SceneOptions& options) : options_(options), random_(options.seed) {}

  int body(Vec2 position, double mass, double inertia) {
    scene_.system.bodies.push_back({1 / mass, 1 / inertia});
    scene_.system.positions.push_back(position);
    return static_cast<int>(scene_.system.bodies.size()) - 1;
  }

  /// Adds a contact at `point`; `normal` points from `a` (-1: ground) to `b`.
  void contact(int a, int b, Vec2 point, Vec2 normal) {
    for (int copy = 0; copy < (options_.duplicated ? 2 : 1); ++copy) {
      const std::uint64_t source = next_source_++;
      const int first = scene_.system.size();
      add_row(RowKind::Normal, a, b, point, normal, source);
      if (options_.friction > 0) {
        add_row(RowKind::Friction, a, b, point, perp(normal), source);
        scene_.system.rows.back().normal = first;
        scene_.system.rows.back().mu = options_.friction;
      }
      if (options_.rolling > 0) {
        Row row;
        row.kind = RowKind::Rolling;
        row.a = a;
        row.b = b;
        if (a >= 0) row.Ja = {0, 0, -1};
        if (b >= 0) row.Jb = {0, 0, 1};
        row.normal = first;
        row.mu = options_.rolling;
        row.source = source;
        scene_.system.rows.push_back(row);
      }
    }
  }

  /// Adds `points_per_edge` contacts on the horizontal edge from x0 to x1 at height y.
  void edge(int below, int above, double x0, double x1, double y) {
    const int points = options_.points_per_edge;
    for (int k = 0; k < points; ++k) {
      const double share = points == 1 ? 0.5 : static_cast<double>(k) / (points - 1);
      contact(below, above, {x0 + share * (x1 - x0), y}, {0, 1});
    }
  }

  /// Adds a pin: two joint rows that hold the points of `a` and `b` at `point` together.
  void pin(int a, int b, Vec2 point) {
    const std::uint64_t source = next_source_++;
    for (const Vec2 axis : {Vec2{1, 0}, Vec2{0, 1}}) {
      add_row(RowKind::Joint, a, b, point, axis, source);
      scene_.system.rows.back().lower = -kInfinity;
    }
  }

  /// Adds a weld: a pin, and a row that holds the angle between the two. Welds come before contacts.
  void weld(int a, int b, Vec2 point) {
    pin(a, b, point);
    Row row;
    row.kind = RowKind::Joint;
    row.a = a;
    row.b = b;
    if (a >= 0) row.Ja = {0, 0, -1};
    if (b >= 0) row.Jb = {0, 0, 1};
    row.lower = -kInfinity;
    row.source = scene_.system.rows.back().source;
    scene_.system.rows.push_back(row);
  }

  void add_row(RowKind kind, int a, int b, Vec2 point, Vec2 axis, std::uint64_t source) {
    Row row;
    row.kind = kind;
    row.a = a;
    row.b = b;
    if (a >= 0) {
      row.Ja = {-axis.x, -axis.y, -cross(point - scene_.system.positions[static_cast<std::size_t>(a)], axis)};
    }
    if (b >= 0) {
      row.Jb = {axis.x, axis.y, cross(point - scene_.system.positions[static_cast<std::size_t>(b)], axis)};
    }
    row.source = source;
    scene_.system.rows.push_back(row);
  }

  std::mt19937_64& random() { return random_; }
  Scene& scene() { return scene_; }

  /// Gives every body gravity, noise and the shock, and fills b.
  Scene finish() {
    const std::size_t n = scene_.system.bodies.size();
    if (scene_.free_velocity.empty()) {
      std::uniform_real_distribution<double> noise(-1, 1);
      for (std::size_t k = 0; k < n; ++k) {
        std::array<double, 3> v{0, -options_.gravity_impulse, 0};
        if (options_.noise > 0) {
          for (double& component : v) component += options_.noise * noise(random_);
        }
        scene_.free_velocity.push_back(v);
      }
      if (n > 0 && options_.shock != 0) scene_.free_velocity[n / 2][0] += options_.shock;
    }
    for (const Row& row : scene_.system.rows) {
      double u = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        if (row.a >= 0) u += row.Ja[k] * scene_.free_velocity[static_cast<std::size_t>(row.a)][k];
        if (row.b >= 0) u += row.Jb[k] * scene_.free_velocity[static_cast<std::size_t>(row.b)][k];
      }
      scene_.system.b.push_back(-u);
    }
    return std::move(scene_);
  }

  /// Mass of layer `layer` of `layers` (0 is the lowest).
  double layer_mass(int layer, int layers) {
    const double ratio = options_.mass_ratio;
    switch (options_.pattern) {
      case MassPattern::Uniform:
        return 1;
      case MassPattern::HeavyOnTop:
        return layer == layers - 1 ? ratio : 1;
      case MassPattern::Alternating:
        return layer % 2 ? ratio : 1;
      case MassPattern::Random:
        return std::pow(ratio, std::uniform_real_distribution<double>(0, 1)(random_));
    }
    return 1;
  }

 private:
  SceneOptions options_;
  std::mt19937_64 random_;
  Scene scene_;
  std::uint64_t next_source_ = 0;
};

inline double box_inertia(double mass, double width, double height) {
  return mass * (width * width + height * height) / 12;
}

/// `height` unit boxes on top of each other.
inline Scene stack(int height, const SceneOptions& options = {}) {
  SceneBuilder builder(options);
  for (int k = 0; k < height; ++k) {
    const double mass = builder.layer_mass(k, height);
    const int body = builder.body({0, k + 0.5}, mass, box_inertia(mass, 1, 1));
    builder.edge(body - 1, body, -0.5, 0.5, k);
  }
  return builder.finish();
}

inline Scene box_on_floor(const SceneOptions& options = {}) {
  return stack(1, options);
}

/// A triangle of unit boxes, `base` in the lowest row, 0.1 m between neighbours of a row.
inline Scene pyramid(int base, const SceneOptions& options = {}) {
  SceneBuilder builder(options);
  std::vector<int> below, row;
  for (int layer = 0; layer < base; ++layer) {
    row.clear();
    for (int k = 0; k < base - layer; ++k) {
      const double mass = builder.layer_mass(layer, base);
      const double x = 1.1 * (k + 0.5 * layer);
      const int body = builder.body({x, layer + 0.5}, mass, box_inertia(mass, 1, 1));
      if (layer == 0) {
        builder.edge(-1, body, x - 0.5, x + 0.5, layer);
      } else {
        const auto left = static_cast<std::size_t>(k);
        builder.edge(below[left], body, x - 0.5, x - 0.05, layer);
        builder.edge(below[left + 1], body, x + 0.05, x + 0.5, layer);
      }
      row.push_back(body);
    }
    below = row;
  }
  return builder.finish();
}

/// A wall of bricks 2 m x 1 m in running bond. With `sides`, neighbours of a row touch along their ends.
inline Scene wall(int width, int height, bool sides = false, const SceneOptions& options = {}) {
  SceneBuilder builder(options);
  std::vector<int> below, row;
  for (int layer = 0; layer < height; ++layer) {
    row.clear();
    const double shift = layer % 2 ? 1 : 0;
    for (int k = 0; k < width; ++k) {
      const double mass = builder.layer_mass(layer, height);
      const double x = 2 * k + shift;
      const int body = builder.body({x, layer + 0.5}, mass, box_inertia(mass, 2, 1));
      if (layer == 0) {
        builder.edge(-1, body, x - 1, x + 1, layer);
      } else {
        for (int j = 0; j < width; ++j) {
          const double other = 2 * j + (layer % 2 ? 0 : 1);
          const double x0 = std::max(x, other) - 1, x1 = std::min(x, other) + 1;
          if (x1 > x0) builder.edge(below[static_cast<std::size_t>(j)], body, x0, x1, layer);
        }
      }
      if (sides && k > 0) {
        for (const double y : {0.0, 1.0}) builder.contact(row.back(), body, {x - 1, layer + y}, {1, 0});
      }
      row.push_back(body);
    }
    below = row;
  }
  return builder.finish();
}

/// `count` discs in a row that touch, without friction and without the ground (Newton's cradle); the free
/// velocities are random with amplitude `noise`, or 1 m/s for the first disc when `noise` is zero.
inline Scene chain(int count, SceneOptions options = {}) {
  options.friction = 0;
  SceneBuilder builder(options);
  for (int k = 0; k < count; ++k) {
    const double mass = builder.layer_mass(k, count);
    const int body = builder.body({static_cast<double>(k), 0}, mass, mass / 8);
    if (k > 0) builder.contact(body - 1, body, {k - 0.5, 0}, {1, 0});
  }
  std::uniform_real_distribution<double> noise(-1, 1);
  for (int k = 0; k < count; ++k) {
    const double speed = options.noise > 0 ? options.noise * noise(builder.random()) : (k == 0 ? 1 : 0);
    builder.scene().free_velocity.push_back({speed, 0, 0});
  }
  return builder.finish();
}

/// A triangular heap of discs of diameter 1 in hexagonal packing, `base` discs on the ground.
inline Scene disc_heap(int base, const SceneOptions& options = {}) {
  SceneBuilder builder(options);
  const double rise = std::sqrt(0.75);
  std::vector<int> below, row;
  for (int layer = 0; layer < base; ++layer) {
    row.clear();
    for (int k = 0; k < base - layer; ++k) {
      const double mass = builder.layer_mass(layer, base);
      const Vec2 centre{k + 0.5 * layer, 0.5 + rise * layer};
      const int body = builder.body(centre, mass, mass / 8);
      if (layer == 0) builder.contact(-1, body, {centre.x, 0}, {0, 1});
      if (layer > 0) {
        const auto left = static_cast<std::size_t>(k);
        builder.contact(below[left], body, centre + Vec2{-0.25, -rise / 2}, {0.5, rise});
        builder.contact(below[left + 1], body, centre + Vec2{0.25, -rise / 2}, {-0.5, rise});
      }
      if (k > 0) builder.contact(row.back(), body, centre + Vec2{-0.5, 0}, {1, 0});
      row.push_back(body);
    }
    below = row;
  }
  return builder.finish();
}

/// What a random small island may hold.
struct RandomIsland {
  int bodies = 3;
  int contacts = 4;
  int pins = 0;
  bool ground_only = false;  ///< every contact is with the ground
  double near_copy = 0;      ///< every third contact is the one before, moved by this [m]; 0: never
};

/// Random contacts between random bodies: no geometry, any normal, lever arms up to 1 m.
inline Scene random_island(const RandomIsland& shape, const SceneOptions& options) {
  SceneBuilder builder(options);
  std::mt19937_64& random = builder.random();
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int k = 0; k < shape.bodies; ++k) {
    const double mass = std::pow(options.mass_ratio, 0.5 * (1 + unit(random)));
    builder.body({unit(random), unit(random)}, mass, mass * (0.1 + 0.05 * unit(random)));
  }
  std::uniform_int_distribution<int> any(0, shape.bodies - 1);
  Vec2 point, normal;
  int a = -1, b = 0;
  for (int k = 0; k < shape.contacts + shape.pins; ++k) {
    const bool copy = shape.near_copy > 0 && k % 3 == 2;
    if (copy) {
      point += shape.near_copy * perp(normal);
    } else {
      b = any(random);
      a = shape.ground_only ? -1 : any(random);
      if (a == b) a = -1;
      const SinCos angle = sin_cos(kPi * unit(random));
      normal = {angle.cos, angle.sin};
      point =
          builder.scene().system.positions[static_cast<std::size_t>(b)] + Vec2{unit(random), unit(random)};
    }
    if (k < shape.contacts) {
      builder.contact(a, b, point, normal);
    } else {
      builder.pin(a, b, point);
    }
  }
  return builder.finish();
}

/// Of every kind of row, one of them compliant.
inline IslandSystem mixed_island(unsigned seed) {
  IslandSystem system = random_island({.bodies = 4, .contacts = 6, .pins = 2},
                                      {.friction = 0.3, .rolling = 0.05, .noise = 1, .seed = seed})
                            .system;
  system.compliance.assign(system.rows.size(), 0.0);
  system.compliance.back() = 0.125;
  return system;
}

}  // namespace skerry::scenes
