// SPDX-License-Identifier: MIT
//
// A pit and what falls into it.
#pragma once

#include <random>
#include <vector>

#include "tests/support/worlds.h"

namespace skerry::test {

/// A floor with walls at x = -7 and 7 m.
inline void add_pit(World& world, double bounce = 0) {
  add_ground(world, rough(make_box({1, 1}), 0.5, bounce));
  for (const double x : {-7.5, 7.5}) {
    const BodyId wall = world.create_body({.type = BodyType::Static, .position = {x, 20}});
    world.add_shape(wall, rough(make_box({1, 60}), 0.5, bounce));
  }
}

/// Boxes and discs of 0.6 m in loose rows of 14, turned at random (seed 7).
/// @param heavy  mass of every fifth [kg]; the others have 1 kg
inline std::vector<BodyId> add_pile(World& world, int count, double bounce, Vec2 corner = {-6, 1},
                                    double heavy = 1) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> noise(-1, 1);
  std::vector<BodyId> bodies;
  for (int i = 0; i < count; ++i) {
    const ShapeDef shape = rough(i % 2 == 0 ? make_box({0.6, 0.6}) : make_disc(0.3), 0.5, bounce);
    const int row = i / 14;
    const Vec2 place = corner + Vec2{0.9 * (i % 14) + 0.05 * noise(random), 0.9 * row};
    bodies.push_back(add(world, place, shape, i % 5 == 0 ? heavy : 1, {}, noise(random)));
  }
  return bodies;
}

}  // namespace skerry::test
