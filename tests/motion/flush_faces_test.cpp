// SPDX-License-Identifier: MIT
//
// What slides over floors of boxes side by side, as levels of games are built, meets nothing: not the side of
// the next box, of which rounding leaves 1e-13 m in the way.
#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include "tests/support/draw.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace flush_faces_test {

using test::add;
using test::rough;

constexpr double kG = 9.81;

class FlushFaces : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(By, FlushFaces, testing::Values("time_stepping", "event_driven", "auto"),
                         [](const auto& row) { return std::string(row.param); });

/// Boxes of 1 m side by side, with their tops at `top`.
void add_tiles(World& world, int count, double top, double friction, bool of_one_body) {
  BodyId body;
  for (int i = 0; i < count; ++i) {
    if (i == 0 || !of_one_body)
      body = world.create_body({.type = BodyType::Static, .position = {of_one_body ? 0.0 : i, top - 0.5}});
    world.add_shape(body, rough(make_box({1, 1}, {of_one_body ? i : 0.0, 0}), friction));
  }
}

/// How far from what friction does to it a box is that slides over tiles, in any step.
double error_of_speed(World& world, BodyId box, double friction, double h, double until) {
  double worst = 0;
  while (world.position(box).x < until && world.time() < 1) {
    const double before = world.velocity(box).x;
    world.step(h);
    const double loss = before - world.velocity(box).x;
    worst = std::max(worst, std::abs(loss - std::min(before, friction * kG * h)));
  }
  return worst;
}

TEST_P(FlushFaces, DoNotStopWhatSlidesFromOneToTheNext) {
  test::Draw draw(71);
  for (int run = 0; run < 80; ++run) {
    WorldConfig config;
    config.stepper = GetParam();
    World world(config);
    const double top = run % 2 == 0 ? 0 : draw.uniform(-20, 20), friction = run % 3 == 0 ? 0 : 0.4;
    add_tiles(world, 4, top, friction, run % 4 < 2);
    const double side = draw.uniform(0.3, 0.9), speed = draw.uniform(4, 15);
    BodyDef def;
    def.position = {0, top + 0.5 * side};
    def.velocity = {speed, 0};
    // As characters of games, which do not turn.
    if (run % 5 != 0) def.inertia = 1e12;
    const BodyId box = world.create_body(def);
    world.add_shape(box, rough(make_box({side, side}), friction));
    EXPECT_LT(error_of_speed(world, box, friction, 1.0 / 60, 3), 1e-4) << "run " << run;
    EXPECT_NEAR(world.position(box).y, top + 0.5 * side, 1e-9) << "run " << run;
  }
}

TEST_P(FlushFaces, DoNotStopItWhereTheSeamIsAtTheEndOfAStep) {
  for (const double h : {1.0 / 60, 1.0 / 120, 1.0 / 30}) {
    for (const double speed : {1.3, 3.0, 5.0, 8.0, 12.7, 20.0}) {
      for (const double friction : {0.0, 0.4}) {
        for (const bool turns : {false, true}) {
          WorldConfig config;
          config.stepper = GetParam();
          World world(config);
          add_tiles(world, 50, 0, friction, false);
          // As wide as a tile: it leaves one as it comes to another.
          BodyDef def;
          def.position = {0, 0.5};
          def.velocity = {speed, 0};
          if (!turns) def.inertia = 1e12;
          const BodyId box = world.create_body(def);
          world.add_shape(box, rough(make_box({1, 1}), friction));
          EXPECT_LT(error_of_speed(world, box, friction, h, 40), 2e-3)
              << h << " s, " << speed << " m/s, friction " << friction << (turns ? ", turns" : "");
        }
      }
    }
  }
}

TEST_P(FlushFaces, DoNotHoldWhatSlidesDownAWallOfThem) {
  WorldConfig config;
  config.stepper = GetParam();
  World world(config);
  for (int i = 0; i < 12; ++i) {
    const BodyId tile = world.create_body({.type = BodyType::Static, .position = {-0.5, -i + 0.1 * 3}});
    world.add_shape(tile, rough(make_box({1, 1}), 0));
  }
  // A breath of wind keeps it at the wall.
  const BodyId box = add(world, {0.3, 0}, rough(make_box({0.6, 0.6}), 0), 1);
  for (int step = 0; step < 72; ++step) {
    world.apply_force(box, {-2, 0}, world.position(box));
    world.step(1.0 / 60);
  }
  EXPECT_NEAR(world.velocity(box).y, -kG * 1.2, 1e-6);
  EXPECT_NEAR(world.position(box).x, 0.3, 1e-9);
}

TEST_P(FlushFaces, AStepOfAMicrometreIsOne) {
  WorldConfig config;
  config.stepper = GetParam();
  World world(config);
  const BodyId low = world.create_body({.type = BodyType::Static, .position = {0, -0.5}});
  world.add_shape(low, rough(make_box({1, 1}), 0));
  const BodyId high = world.create_body({.type = BodyType::Static, .position = {1, -0.5 + 1e-6}});
  world.add_shape(high, rough(make_box({1, 1}), 0));
  BodyDef def;
  def.position = {0, 0.2};
  def.velocity = {3, 0};
  def.inertia = 1e12;
  const BodyId box = world.create_body(def);
  world.add_shape(box, rough(make_box({0.4, 0.4}), 0));
  for (int step = 0; step < 30; ++step) world.step(1.0 / 60);
  EXPECT_NEAR(world.position(box).x, 0.3, 1e-6);
  EXPECT_NEAR(world.velocity(box).x, 0, 1e-9);
}

}  // namespace flush_faces_test
}  // namespace skerry
