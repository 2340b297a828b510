// SPDX-License-Identifier: MIT
//
// Random shapes and poses, plain and adversarial, and the signed distance of two of them by brute force over
// the Minkowski difference in long double.
#pragma once

#include <random>
#include <stdexcept>
#include <vector>

#include "physics/shape.h"
#include "tests/support/scale.h"

namespace skerry::oracle {

using Real = long double;

struct Point {
  Real x = 0, y = 0;
};
inline Point operator-(Point a, Point b) {
  return {a.x - b.x, a.y - b.y};
}
inline Real dot(Point a, Point b) {
  return a.x * b.x + a.y * b.y;
}
inline Real cross(Point a, Point b) {
  return a.x * b.y - a.y * b.x;
}
inline Real length(Point a) {
  return std::sqrt(dot(a, a));
}

/// Signed distance of two shapes.
struct Distance {
  Real distance = 0;   ///< negative: depth of penetration [m]
  Point normal;        ///< from a to b, world frame
  Real clearance = 0;  ///< by how much the next, different axis is worse [m]; 0 for a vanishing distance
  Real scale = 0;      ///< magnitude of the coordinates relative to a [m]
  Real core = 0;       ///< distance of the cores [m]
};

/// Corners of a core relative to the position of `origin`, in world orientation.
inline std::vector<Point> placed(const Shape& shape, const Transform& pose, Vec2 origin) {
  std::vector<Point> out;
  const Real dx = static_cast<Real>(pose.p.x) - origin.x, dy = static_cast<Real>(pose.p.y) - origin.y;
  const Real c = pose.q.c, s = pose.q.s;
  for (const Vec2 v : shape.vertices) out.push_back({c * v.x - s * v.y + dx, s * v.x + c * v.y + dy});
  return out;
}

/// Signed distance of two cores with corners `pa` and `pb`: closest points if they are apart, otherwise the
/// smallest of all edges' penetrations.
inline Distance core_distance(const std::vector<Point>& pa, const std::vector<Point>& pb) {
  Distance out;
  // Overlap: every edge of either core has points of the other behind it.
  struct Candidate {
    Real separation;
    Point normal;
  };
  std::vector<Candidate> axes;
  const auto add_axes = [&](const std::vector<Point>& own, const std::vector<Point>& other, int sign) {
    const std::size_t n = own.size();
    for (std::size_t i = 0; n > 1 && i < n; ++i) {
      const Point edge = own[(i + 1) % n] - own[i];
      const Real len = length(edge);
      const Point normal{edge.y / len, -edge.x / len};
      Real low = INFINITY;
      for (const Point p : other) low = std::min(low, dot(normal, p - own[i]));
      axes.push_back({low, {sign * normal.x, sign * normal.y}});
    }
  };
  add_axes(pa, pb, 1);
  add_axes(pb, pa, -1);
  Candidate best{-INFINITY, {}};
  for (const Candidate& c : axes) {
    if (c.separation > best.separation) best = c;
  }
  // Outside: the nearest of all corner-edge and corner-corner pairs.
  Real nearest = INFINITY;
  Point direction;
  const auto add_pairs = [&](const std::vector<Point>& corners, const std::vector<Point>& edges, int sign) {
    for (const Point p : corners) {
      for (std::size_t i = 0; i < edges.size(); ++i) {
        const Point e = edges[(i + 1) % edges.size()] - edges[i];
        const Real square = dot(e, e);
        Real t = square > 0 ? dot(p - edges[i], e) / square : 0;
        t = std::min<Real>(1, std::max<Real>(0, t));
        const Point gap = p - Point{edges[i].x + t * e.x, edges[i].y + t * e.y};
        if (length(gap) < nearest) {
          nearest = length(gap);
          direction = {sign * gap.x, sign * gap.y};
        }
      }
    }
  };
  add_pairs(pb, pa, 1);
  add_pairs(pa, pb, -1);
  // Cores without an inside (discs, crossing or collinear capsules) are apart unless they cross.
  const bool apart = axes.empty() || best.separation > 0 || (best.separation == 0 && nearest > 0);
  if (apart) {
    out.core = nearest;
    out.normal = nearest > 0 ? Point{direction.x / nearest, direction.y / nearest} : best.normal;
    out.clearance = nearest;
  } else {
    out.core = best.separation;
    out.normal = best.normal;
    out.clearance = INFINITY;
    for (const Candidate& c : axes) {
      if (std::abs(cross(c.normal, best.normal)) > 1e-9L || dot(c.normal, best.normal) < 0) {
        out.clearance = std::min(out.clearance, best.separation - c.separation);
      }
    }
  }
  return out;
}

inline Real signed_distance(const std::vector<Point>& pa, const std::vector<Point>& pb) {
  return core_distance(pa, pb).core;
}

inline Distance brute_force(const Shape& a, const Transform& pose_a, const Shape& b,
                            const Transform& pose_b) {
  const std::vector<Point> pa = placed(a, pose_a, pose_a.p), pb = placed(b, pose_b, pose_a.p);
  Distance out = core_distance(pa, pb);
  for (const auto& list : {pa, pb}) {
    for (const Point p : list) out.scale = std::max(out.scale, std::abs(p.x) + std::abs(p.y));
  }
  const Real radii = static_cast<Real>(a.radius) + b.radius;
  out.scale += radii;
  out.distance = out.core - radii;
  return out;
}

/// Separation of the cores along a given direction from a to b.
inline Real separation_along(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b,
                             Point normal) {
  Real high = -INFINITY, low = INFINITY;
  for (const Point p : placed(a, pose_a, pose_a.p)) high = std::max(high, dot(normal, p));
  for (const Point p : placed(b, pose_b, pose_a.p)) low = std::min(low, dot(normal, p));
  return low - high;
}

/// A source of shapes and poses.
class Scenes {
 public:
  explicit Scenes(unsigned seed) : random_(seed) {}

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  int below(int n) { return std::uniform_int_distribution<int>(0, n - 1)(random_); }
  std::mt19937_64& generator() { return random_; }

  Vec2 direction() {
    const SinCos sc = sin_cos(uniform(0, 2 * kPi));
    return {sc.cos, sc.sin};
  }

  /// Angles: often multiples of quarter turns, exact zeros, or a hair beside them.
  double angle() {
    const double quarter = below(4) * kPi / 2;
    switch (below(5)) {
      case 0:
        return 0;
      case 1:
        return quarter;
      case 2:
        return quarter + std::pow(10.0, uniform(-16, -6));
      default:
        return uniform(-4, 4);
    }
  }

  /// A convex polygon of about the given size; slivers now and then.
  Shape polygon(double size, int corners, double rounding) {
    while (true) {
      const double aspect = below(4) == 0 ? std::pow(10.0, uniform(-6, 0)) : uniform(0.3, 1);
      const Rot turn = Rot::from_angle(uniform(0, 6));
      const double start = uniform(0, 6);
      std::vector<Vec2> points;
      for (int i = 0; i < corners; ++i) {
        const SinCos sc = sin_cos(start + 2 * kPi * (i + uniform(-0.3, 0.3)) / corners);
        points.push_back(rotate(turn, {0.5 * size * sc.cos, 0.5 * size * aspect * sc.sin}));
      }
      try {
        return make_polygon(points, rounding);
      } catch (const std::invalid_argument&) {
        // Too thin for its number of corners.
      }
    }
  }

  /// Any convex shape of about the given size.
  Shape shape(double size) {
    const double rounding = below(3) == 0 ? size * uniform(0.001, 0.3) : 0;
    switch (below(6)) {
      case 0:
        return make_disc(0.5 * size, below(2) == 0 ? Vec2{} : 0.3 * size * direction());
      case 1:
        return make_capsule(-0.5 * size * direction(), 0.3 * size * direction(), size * uniform(0.01, 0.5));
      case 2:
        return make_box({size, size * uniform(0.1, 1)}, {}, 0, rounding > 0.02 * size ? 0.02 * size : 0);
      case 3:
        return polygon(size, 9 + below(56), rounding);
      default:
        return polygon(size, 3 + below(6), rounding);
    }
  }

  /// Two poses at which shapes of these sizes are close, overlap deeply, or coincide.
  std::pair<Transform, Transform> poses(double size_a, double size_b, double far) {
    const Vec2 base = below(2) == 0 ? Vec2{} : far * direction();
    const double reach = 0.5 * (size_a + size_b);
    Vec2 offset;
    switch (below(6)) {
      case 0:
        break;  // coincident centres
      case 1:
        offset = Vec2{reach, 0} * (below(2) == 0 ? 1.0 : -1.0);
        break;
      case 2:
        offset = {0.5 * reach * static_cast<double>(below(5) - 2),
                  0.5 * reach * static_cast<double>(below(5) - 2)};
        break;
      default:
        offset = uniform(0, 1.3) * reach * direction();
    }
    return {{base, Rot::from_angle(angle())}, {base + offset, Rot::from_angle(angle())}};
  }

  double size() {
    switch (below(4)) {
      case 0:
        return std::pow(10.0, uniform(-6, 6));
      default:
        return uniform(0.5, 2);
    }
  }

 private:
  std::mt19937_64 random_;
};

}  // namespace skerry::oracle
