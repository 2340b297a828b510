// SPDX-License-Identifier: MIT
//
// Large scenes with the counts of the well-known ones, as descriptions from which every engine makes its
// world.
#pragma once

#include <cmath>
#include <vector>

#include "physics/world.h"

namespace skerry::scale {

/// A box, or a disc where `half.y` is zero.
struct Part {
  Vec2 half;
  Vec2 at{};
  double angle = 0;
};
struct Item {
  BodyType type = BodyType::Dynamic;
  Vec2 at{};
  double angle = 0;
  Vec2 velocity{};
  double omega = 0;
  std::vector<Part> parts;
  double density = 1;
};
struct Hinge {
  int a, b;
  Vec2 at;
};
struct Scene {
  Vec2 gravity{0, -10};
  double friction = 0.6, restitution = 0;
  std::vector<Item> items;
  std::vector<Hinge> hinges;
};

/// Where a point of the scene is on one of its bodies.
inline Vec2 anchor_on(const Scene& scene, int item, Vec2 at) {
  const Item& body = scene.items[static_cast<std::size_t>(item)];
  return inverse_rotate(Rot::from_angle(body.angle), at - body.at);
}

inline void add_box(Scene& s, Vec2 at, Vec2 half, BodyType type = BodyType::Dynamic) {
  s.items.push_back({type, at, 0, {}, 0, {{half, {}, 0}}});
}

/// 5050 boxes, 14 950 contact points.
inline Scene large_pyramid() {
  Scene s;
  add_box(s, {0, -1}, {100, 1}, BodyType::Static);
  for (int row = 0; row < 100; ++row) {
    for (int i = 0; i < 100 - row; ++i) add_box(s, {i + 0.5 * row - 50, row + 0.5}, {0.5, 0.5});
  }
  return s;
}

/// 20 shelves with 20 pyramids of base 10 each: 22 000 boxes.
inline Scene many_pyramids() {
  Scene s;
  for (int shelf = 0; shelf < 20; ++shelf) {
    const double y = 13.0 * shelf;
    add_box(s, {120, y - 0.5}, {125, 0.5}, BodyType::Static);
    for (int p = 0; p < 20; ++p) {
      for (int row = 0; row < 10; ++row) {
        for (int i = 0; i < 10 - row; ++i) add_box(s, {12.0 * p + i + 0.5 * row, y + row + 0.5}, {0.5, 0.5});
      }
    }
  }
  return s;
}

/// 100 x 100 discs, hinged to their neighbours, hung up along the top.
inline Scene joint_grid() {
  Scene s;
  constexpr int n = 100;
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < n; ++k) {
      const bool fixed = i == 0 && k % 10 == 0;
      s.items.push_back(
          {fixed ? BodyType::Static : BodyType::Dynamic, {1.0 * k, -1.0 * i}, 0, {}, 0, {{{0.4, 0}}}});
      if (k > 0) s.hinges.push_back({n * i + k - 1, n * i + k, {k - 0.5, -1.0 * i}});
      if (i > 0) s.hinges.push_back({n * (i - 1) + k, n * i + k, {1.0 * k, 0.5 - i}});
    }
  }
  return s;
}

/// A drum that turns with 2025 small boxes in it.
inline Scene tumbler() {
  Scene s;
  Item drum{BodyType::Kinematic, {0, 10}, 0, {}, 25 * std::acos(-1.0) / 180, {}};
  drum.parts = {{{0.5, 10}, {10, 0}}, {{0.5, 10}, {-10, 0}}, {{10, 0.5}, {0, 10}}, {{10, 0.5}, {0, -10}}};
  s.items.push_back(drum);
  for (int i = 0; i < 45; ++i) {
    for (int k = 0; k < 45; ++k) add_box(s, {0.2 * (i - 22) * 2, 10 + 0.2 * (k - 22) * 2}, {0.125, 0.125});
  }
  return s;
}

/// A heavy box flies into 9600 small ones, without gravity.
inline Scene smash() {
  Scene s;
  s.gravity = {};
  s.items.push_back({BodyType::Dynamic, {-20, 0}, 0, {40, 0}, 0, {{{4, 4}}}});
  for (int i = 0; i < 120; ++i) {
    for (int k = 0; k < 80; ++k) add_box(s, {0.4 * i + 4, 0.4 * (k - 40)}, {0.2, 0.2});
  }
  return s;
}

/// Bodies of two crossed planks each, dropped on a floor.
inline Scene compounds() {
  Scene s;
  add_box(s, {0, -1}, {100, 1}, BodyType::Static);
  for (int i = 0; i < 50; ++i) {
    for (int k = 0; k < 20; ++k) {
      s.items.push_back({BodyType::Dynamic,
                         {2.2 * (i - 25) + 0.03 * k, 1.5 + 2.2 * k},
                         0.1 * (i % 7),
                         {},
                         0,
                         {{{1, 0.15}}, {{0.15, 1}}}});
    }
  }
  return s;
}

/// A ring with a bar that turns in it, and 3038 boxes and discs.
inline Scene spinner() {
  Scene s;
  const double pi = std::acos(-1.0);
  for (int i = 0; i < 60; ++i) {
    const double angle = 2 * pi * i / 60;
    s.items.push_back(
        {BodyType::Static, {41 * std::cos(angle), 41 * std::sin(angle)}, angle, {}, 0, {{{0.5, 2.3}}}});
  }
  s.items.push_back({BodyType::Kinematic, {0, -20}, 0, {}, 5, {{{0.4, 19}}}});
  for (int i = 0; i < 3038; ++i) {
    const int row = i / 62;
    const Vec2 at{0.7 * (i % 62) - 21.7, 0.7 * row - 2};
    s.items.push_back({BodyType::Dynamic, at, 0, {}, 0, {{i % 2 == 0 ? Vec2{0.25, 0.25} : Vec2{0.25, 0}}}});
  }
  return s;
}

/// A turning drum with eight paddles and 8100 small boxes.
inline Scene washer() {
  Scene s;
  const double pi = std::acos(-1.0);
  Item drum{BodyType::Kinematic, {0, 10}, 0, {}, 25 * pi / 180, {}};
  for (int i = 0; i < 40; ++i) {
    const double angle = 2 * pi * i / 40;
    drum.parts.push_back({{0.25, 1.5}, {17 * std::cos(angle), 17 * std::sin(angle)}, angle});
    if (i % 5 == 0) drum.parts.push_back({{0.75, 0.2}, {16 * std::cos(angle), 16 * std::sin(angle)}, angle});
  }
  s.items.push_back(drum);
  for (int i = 0; i < 90; ++i) {
    for (int k = 0; k < 90; ++k) add_box(s, {0.21 * (i - 44.5), 10 + 0.21 * (k - 44.5)}, {0.1, 0.1});
  }
  return s;
}

/// 1000 people of 11 bodies each over an uneven floor.
inline Scene ragdolls() {
  Scene s;
  for (int i = 0; i < 100; ++i)
    s.items.push_back({BodyType::Static, {2.0 * i - 100, -1 + 0.3 * (i % 3)}, 0, {}, 0, {{{1, 1}}}});
  for (int n = 0; n < 1000; ++n) {
    const int row = n / 40;
    const Vec2 at{4.0 * (n % 40) - 80, 4 + 3.0 * row};
    const int first = static_cast<int>(s.items.size());
    const auto bone = [&](Vec2 where, Vec2 half) {
      s.items.push_back({BodyType::Dynamic, at + where, 0, {}, 0, {{half}}});
    };
    const auto joint = [&](int a, int b, Vec2 where) {
      s.hinges.push_back({first + a, first + b, at + where});
    };
    bone({0, 0}, {0.15, 0.2});  // hip, torso, head
    bone({0, 0.55}, {0.17, 0.3});
    bone({0, 1.1}, {0.17, 0});
    joint(0, 1, {0, 0.22});
    joint(1, 2, {0, 0.88});
    for (const double side : {-1.0, 1.0}) {  // thigh, shin, upper arm, forearm
      const int k = static_cast<int>(s.items.size()) - first;
      bone({0.1 * side, -0.5}, {0.07, 0.25});
      bone({0.1 * side, -1.05}, {0.06, 0.25});
      bone({0.4 * side, 0.75}, {0.18, 0.05});
      bone({0.8 * side, 0.75}, {0.18, 0.045});
      joint(0, k, {0.1 * side, -0.22});
      joint(k, k + 1, {0.1 * side, -0.77});
      joint(1, k + 2, {0.2 * side, 0.75});
      joint(k + 2, k + 3, {0.6 * side, 0.75});
    }
  }
  return s;
}

struct Named {
  const char* name;
  Scene (*make)();
};
inline const std::vector<Named> kScenes{{"large_pyramid", large_pyramid},
                                        {"many_pyramids", many_pyramids},
                                        {"joint_grid", joint_grid},
                                        {"tumbler", tumbler},
                                        {"spinner", spinner},
                                        {"washer", washer},
                                        {"smash", smash},
                                        {"compounds", compounds},
                                        {"ragdolls", ragdolls}};

}  // namespace skerry::scale
