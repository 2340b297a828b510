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

/// Welds neighbours of a grid of bodies in blocks of `size` by `size`. @param grid  row by row
inline std::vector<JointId> weld_blocks(World& world, const std::vector<BodyId>& grid, int columns,
                                        int size) {
  std::vector<JointId> welds;
  const int count = static_cast<int>(grid.size());
  const auto weld = [&](int i, int k) {
    const BodyId a = grid[static_cast<std::size_t>(i)], b = grid[static_cast<std::size_t>(k)];
    welds.push_back(world.create_joint({.kind = JointKind::Weld,
                                        .a = a,
                                        .b = b,
                                        .anchor_a = 0.5 * (world.position(a) + world.position(b))}));
  };
  for (int i = 0; i < count; ++i) {
    const int x = i % columns, y = i / columns;
    if (x % size != size - 1 && x + 1 < columns && i + 1 < count) weld(i, i + 1);
    if (y % size != size - 1 && i + columns < count) weld(i, i + columns);
  }
  return welds;
}

/// Boxes and discs of 0.6 m, 0.3 m apart in rows of 14 and turned at random, that are welded to blocks of
/// `size` by `size`.
inline void add_blocks(World& world, int count, int size, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> noise(-1, 1);
  std::vector<BodyId> grid;
  for (int i = 0; i < count; ++i) {
    const int row = i / 14;
    const Vec2 place{-6 + 0.9 * (i % 14) + 0.05 * noise(random), 1 + 0.9 * row};
    const ShapeDef shape = rough(i % 2 == 0 ? make_box({0.6, 0.6}) : make_disc(0.3), 0.5);
    grid.push_back(add(world, place, shape, 1, {}, 0, noise(random)));
  }
  weld_blocks(world, grid, 14, size);
}

}  // namespace skerry::test
