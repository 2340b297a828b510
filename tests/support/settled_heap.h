// SPDX-License-Identifier: MIT
//
// The contact problem of a heap of discs that came to rest in a box.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include "tests/support/island_scenes.h"
#include "tests/support/worlds.h"

namespace skerry::scenes {

/// Discs of radius 0.3 to 0.6 m and unit density, dropped in loose rows into a box of `width` [m] and left to
/// settle for 8 s without friction. What is then closer than 1 cm touches.
inline Scene settled_discs(int count, double width, const SceneOptions& options = {}) {
  constexpr double kTouching = 0.01;
  World world;
  const ShapeDef ground = test::smooth(make_disc(1));
  test::add_ground(world, ground);
  for (const double side : {0.0, width}) {
    const BodyId wall = world.create_body({.type = BodyType::Static});
    world.add_shape(wall, test::smooth(make_half_plane({side, 0}, {side > 0 ? -1.0 : 1.0, 0})));
  }
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> size(0.3, 0.6);
  const int columns = static_cast<int>(width / 1.25);
  std::vector<double> radius;
  std::vector<BodyId> discs;
  for (int i = 0; i < count; ++i) {
    radius.push_back(size(random));
    const double aside = 0.05 * size(random);
    const int row = i / columns;
    discs.push_back(test::add(world, {0.65 + 1.25 * (i % columns) + aside, 0.65 + 1.25 * row},
                              test::smooth(make_disc(radius.back()))));
  }
  for (int step = 0; step < 480; ++step) world.step(1.0 / 60);

  SceneBuilder builder(options);
  std::vector<Vec2> at;
  for (std::size_t i = 0; i < radius.size(); ++i) {
    const double mass = std::numbers::pi * radius[i] * radius[i];
    at.push_back(world.position(discs[i]));
    builder.body(at[i], mass, mass * radius[i] * radius[i] / 2);
  }
  for (std::size_t i = 0; i < radius.size(); ++i) {
    const int body = static_cast<int>(i);
    const double r = radius[i];
    if (at[i].y - r < kTouching) builder.contact(-1, body, {at[i].x, at[i].y - r}, {0, 1});
    if (at[i].x - r < kTouching) builder.contact(-1, body, {at[i].x - r, at[i].y}, {1, 0});
    if (width - at[i].x - r < kTouching) builder.contact(-1, body, {at[i].x + r, at[i].y}, {-1, 0});
    for (std::size_t j = 0; j < i; ++j) {
      const Vec2 way = at[i] - at[j];
      const double distance = length(way);
      if (distance - r - radius[j] < kTouching)
        builder.contact(static_cast<int>(j), body, at[j] + (radius[j] / distance) * way, way / distance);
    }
  }
  return builder.finish();
}

}  // namespace skerry::scenes
