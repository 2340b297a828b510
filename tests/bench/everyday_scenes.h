// SPDX-License-Identifier: MIT
//
// Large scenes as people make them, beside the well-known ones (`scale_scenes.h`): nothing lies exactly where
// it belongs. They show steps that cost many times what others do.
#pragma once

#include <cmath>
#include <random>

#include "tests/bench/scale_scenes.h"

namespace skerry::scale {

/// Noise in [-1, 1].
class Noise {
 public:
  explicit Noise(unsigned seed) : random_(seed) {}
  double operator()() { return unit_(random_); }
  Vec2 both(double size) {
    const double x = size * (*this)();
    return {x, size * (*this)()};
  }

 private:
  std::mt19937 random_;
  std::uniform_real_distribution<double> unit_{-1, 1};
};

/// What moves gets a little speed of its own, up to 0.05 m/s and 0.1 rad/s: copies of a scene go other ways,
/// and the mean over some says more than one of them.
inline void disturb(Scene& scene, unsigned seed) {
  Noise noise(seed);
  for (Item& item : scene.items) {
    if (item.type != BodyType::Dynamic) continue;
    item.velocity += noise.both(0.05);
    item.omega += 0.1 * noise();
  }
}

/// A box without a lid for `count` bodies. @return how many of them lie beside each other
inline int add_bin(Scene& s, int count) {
  const int wide = static_cast<int>(std::sqrt(2.0 * count));
  const double half = 0.6 * wide;
  add_box(s, {0, -1}, {half + 2, 1}, BodyType::Static);
  for (const double side : {-1.0, 1.0})
    add_box(s, {side * (half + 1), 2 * half}, {1, 2 * half + 2}, BodyType::Static);
  return wide;
}

/// 3000 boxes and discs, each by itself, that fall into a bin.
inline Scene heap(double speed, double spread_of_mass) {
  Scene s;
  const int count = 3000, wide = add_bin(s, count);
  Noise noise(1);
  for (int i = 0; i < count; ++i) {
    const double radius = 0.5 * (1 + 0.1 * noise());
    const int row = i / wide;
    Item item;
    item.at = {1.15 * (i % wide - 0.5 * wide), 1 + 1.15 * row};
    item.velocity = noise.both(speed);
    item.angle = noise();
    item.parts = {{{radius, i % 2 == 0 ? radius : 0}}};
    item.density = std::pow(spread_of_mass, 0.5 + 0.5 * noise());
    s.items.push_back(item);
  }
  return s;
}
inline Scene loose_heap() {
  return heap(0.3, 1);
}
/// Masses from 1 to 1000.
inline Scene heavy_heap() {
  return heap(0.3, 1000);
}
/// Fast, and with restitution 0.8.
inline Scene bouncing_heap() {
  Scene s = heap(10, 1);
  s.restitution = 0.8;
  return s;
}

/// 3003 bricks that fall into place by a hundredth of their height.
inline Scene loose_pyramid() {
  Scene s;
  add_box(s, {0, -1}, {300, 1}, BodyType::Static);
  Noise noise(1);
  constexpr int base = 77;
  for (int row = 0; row < base; ++row) {
    for (int k = 0; k < base - row; ++k) {
      add_box(s, Vec2{k + 0.5 * row - 0.5 * base, 0.5 + 1.01 * row} + Vec2{0.02 * noise(), 0}, {0.49, 0.5});
      s.items.back().velocity = noise.both(0.02);
    }
  }
  return s;
}

/// 20 courses of 100 bricks with gaps.
inline Scene loose_wall() {
  Scene s;
  add_box(s, {0, -1}, {200, 1}, BodyType::Static);
  Noise noise(1);
  for (int row = 0; row < 20; ++row) {
    for (int k = 0; k < 100; ++k)
      add_box(s, {2.0 * (k - 50) + row % 2 + 0.1 * noise(), 0.5 + 1.02 * row}, {0.95, 0.5});
  }
  return s;
}

/// The boxes of the washer drift against each other while they fall.
inline Scene drifting_cloud() {
  Scene s = washer();
  disturb(s, 1);
  return s;
}

/// 60 ropes of 50 links that swing down.
inline Scene ropes() {
  Scene s;
  for (int rope = 0; rope < 60; ++rope) {
    const double x = 60.0 * rope;
    add_box(s, {x, 20}, {0.1, 0.1}, BodyType::Static);
    for (int k = 0; k < 50; ++k) {
      const int last = static_cast<int>(s.items.size()) - 1;
      add_box(s, {x + 0.5 * k + 0.25, 20}, {0.25, 0.075});
      s.hinges.push_back({last, last + 1, {x + 0.5 * k, 20}});
    }
  }
  return s;
}

/// 15 bridges of 100 planks that sag, and 100 boxes that fall onto each.
inline Scene bridges() {
  Scene s;
  Noise noise(1);
  const double pi = std::acos(-1.0);
  constexpr int planks = 100;
  for (int bridge = 0; bridge < 15; ++bridge) {
    Vec2 end{66.0 * bridge, 10};
    add_box(s, end - Vec2{0.6, 0}, {0.3, 0.3}, BodyType::Static);
    for (int k = 0; k < planks; ++k) {
      const double angle = std::atan(-pi / 9 * std::cos(pi * (k + 0.5) / planks));
      const Vec2 along{0.5 * std::cos(angle), 0.5 * std::sin(angle)};
      const int last = static_cast<int>(s.items.size()) - 1;
      add_box(s, end + 0.5 * along, {0.25, 0.1});
      s.items.back().angle = angle;
      s.hinges.push_back({last, last + 1, end});
      end += along;
    }
    const int last = static_cast<int>(s.items.size()) - 1;
    add_box(s, end + Vec2{0.6, 0}, {0.3, 0.3}, BodyType::Static);
    s.hinges.push_back({last, last + 1, end});
    for (int k = 0; k < planks; ++k)
      add_box(s, {66.0 * bridge + 0.45 * k + 0.1 * noise(), 15 + 3 * noise()}, {0.2, 0.2});
  }
  return s;
}

inline const std::vector<Named> kEverydayScenes{{"loose_heap", loose_heap},
                                                {"heavy_heap", heavy_heap},
                                                {"bouncing_heap", bouncing_heap},
                                                {"loose_pyramid", loose_pyramid},
                                                {"loose_wall", loose_wall},
                                                {"drifting_cloud", drifting_cloud},
                                                {"ropes", ropes},
                                                {"bridges", bridges}};

}  // namespace skerry::scale
