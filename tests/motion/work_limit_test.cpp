// SPDX-License-Identifier: MIT
//
// `SolveOptions::work_limit` bounds all that an island takes in a step: pieces, impacts and projections, what
// is tried and given up, and what is left to do when it is spent.
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <vector>

#include "physics/stepping/island_notes.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace work_limit_test {

using test::add;
using test::add_ground;
using test::rough;

constexpr double kStep = 1.0 / 60;

class WorkLimit : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Steppers, WorkLimit, testing::Values("time_stepping", "event_driven", "auto"),
                         [](const testing::TestParamInfo<const char*>& test) { return test.param; });

/// A box on a hinge that something moves down, and that turns: of its two corners on the ground each may
/// bounce, or stop, by a turn about the hinge, which brings the other one down.
TEST_P(WorkLimit, WhatAHingePressesOntoTheGroundDoesNotRockForEver) {
  for (const double limit : {1e8, 1e6}) {
    SCOPED_TRACE("limit " + std::to_string(limit));
    WorldConfig config;
    config.stepper = GetParam();
    config.solve.work_limit = limit;
    World world(config);
    const ShapeDef box = rough(make_box({1, 0.2}), 0.3, 0.8);
    add_ground(world, box);
    const BodyId hand =
        world.create_body({.type = BodyType::Kinematic, .position = {0, 1}, .velocity = {0, -1}});
    const BodyId pressed = add(world, {0, 0.1}, box, 1, {0, -1}, -3);
    world.create_joint({.kind = JointKind::Revolute, .a = hand, .b = pressed, .anchor_a = {0, 0.1}});
    for (int step = 0; step < 4; ++step) {
      const StepReport& report = world.step(kStep);
      EXPECT_LE(report.reflections, 200) << "step " << step;
      EXPECT_LE(report.work.visits, 1e6) << "step " << step;
      // No velocities keep the hinge and leave the ground in peace, and that is what the report says.
      EXPECT_EQ(report.inexact_islands, 1) << "step " << step;
      EXPECT_GT(report.worst_residual, 1e-3) << "step " << step;
      EXPECT_LT(world.kinetic_energy(), 10) << "step " << step;
    }
  }
}

/// Boxes and discs on hinges and slides between walls that close in.
World random_press(unsigned seed, const char* stepper, double limit) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (random() / 4294967296.0);
  };
  WorldConfig config;
  config.stepper = stepper;
  config.solve.work_limit = limit;
  config.flow_work = 0;
  World world(config);
  const double friction = uniform(0, 1);
  add_ground(world, rough(make_disc(1), friction, uniform(0, 1)));
  std::vector<BodyId> bodies;
  const int count = 8 + static_cast<int>(random() % 5);
  for (const double x : {-3.0, 3.0}) {
    const BodyId wall = world.create_body(
        {.type = BodyType::Kinematic, .position = {x, 2}, .velocity = {-x * uniform(0, 1), 0}});
    world.add_shape(wall, rough(make_box({1, 6}), uniform(0, 1), uniform(0, 1)));
    bodies.push_back(wall);
  }
  for (int i = 0; i < count; ++i) {
    const double x = uniform(-2, 2), y = uniform(0.3, 3), vx = uniform(-10, 10), vy = uniform(-10, 10);
    const double angle = uniform(0, 3), omega = uniform(-5, 5), mu = uniform(0, 1.2), e = uniform(0, 1);
    const double width = uniform(0.2, 1), height = uniform(0.2, 1);
    const Shape shape = i % 2 ? make_box({width, height}) : make_disc(width / 2);
    bodies.push_back(add(world, {x, y}, rough(shape, mu, e), 3000 * width * height, {vx, vy}, omega, angle));
  }
  for (int i = 0; i < count; ++i) {
    const BodyId a = bodies[random() % bodies.size()], b = bodies[2 + random() % (bodies.size() - 2)];
    if (a == b) continue;
    const JointKind kind = i % 3 ? JointKind::Revolute : JointKind::Prismatic;
    world.create_joint(
        {.kind = kind, .a = a, .b = b, .anchor_a = world.position(b), .axis = {uniform(-1, 1), 1}});
  }
  return world;
}

TEST_P(WorkLimit, SmallOnesAreKeptToUpToALastLookAtEverything) {
  // Every solve costs something, and the last piece of a step and its projections take some of them.
  constexpr double kLastLook = 1e6;
  double most = 0;
  int inexact = 0;
  for (const double limit : {1e6, 1e5, 1e4}) {
    for (unsigned seed = 1; seed <= 4; ++seed) {
      SCOPED_TRACE("limit " + std::to_string(limit) + ", seed " + std::to_string(seed));
      World world = random_press(seed, GetParam(), limit);
      for (int step = 0; step < 40; ++step) {
        const StepReport& report = world.step(kStep);
        most = std::max(most, report.work.visits / limit);
        ASSERT_LE(report.work.visits, 1.5 * limit + kLastLook) << "step " << step;
        ASSERT_TRUE(std::isfinite(world.kinetic_energy()));
        inexact += report.inexact_islands;
      }
    }
  }
  // Some of them are spent, and the reports say so.
  EXPECT_GT(most, 1);
  EXPECT_GT(inexact, 0);
}

/// Two boxes on a stiff spring, which takes many inner steps, and a third one beside the first. All drift.
StepReport spring_and_box(double drift, double gap, Vec2 velocity, double limit) {
  WorldConfig config = test::weightless();
  config.stepper = "event_driven";
  config.solve.work_limit = limit;
  World world(config);
  const ShapeDef shape = rough(make_box({1, 1}), 0);
  const BodyId box = add(world, {0, 0}, shape, 1, {drift, 0});
  const BodyId other = add(world, {0, -3}, shape, 1, {drift, 0});
  world.create_joint({.kind = JointKind::Spring,
                      .a = box,
                      .b = other,
                      .anchor_b = {0, -3},
                      .length = 2.99,
                      .stiffness = 1e6});
  add(world, {1 + gap, 0}, shape, 1, Vec2{drift, 0} + velocity);
  return world.step(kStep);
}

TEST(LimitOfWork, WhatGoesAlongTakesFewLooksForLandings) {
  for (const double drift : {0.0, 10.0, 1000.0}) {
    const StepReport report = spring_and_box(drift, 1e-3, {0, 0.01}, 1e5);
    EXPECT_EQ(report.fallbacks, 0) << drift;
    EXPECT_EQ(report.inexact_islands, 0) << drift;
  }
}

TEST(LimitOfWork, LooksForLandingsCount) {
  // 10 um beside it, a hundred times as near, its gap is looked at in up to a thousand places of an inner
  // step.
  EXPECT_EQ(spring_and_box(0, 1e-5, {0, 0.01}, 1e8).fallbacks, 0);
  EXPECT_EQ(spring_and_box(0, 1e-5, {0, 0.01}, 1e5).fallbacks, 1);
}

TEST(LimitOfWork, OneThatIsLongSpentIsNotNone) {
  for (const double spent : {1e4, 1e5, 1e6, 1e7, 1e10}) {
    EXPECT_GT(work_left(1e4, spent), 0) << spent;
    EXPECT_LE(work_left(1e4, spent), 1e4 / 16) << spent;
  }
  EXPECT_EQ(work_left(1e4, 0), 5e3);
  EXPECT_EQ(work_left(0, 1e10), 0);
}

}  // namespace work_limit_test
}  // namespace skerry
