// SPDX-License-Identifier: MIT
//
// `WorldConfig::sleep_speed`: what has been slow for half a second is stopped as it is, and nothing else is.
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "physics/snapshot.h"
#include "tests/support/ragdoll.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace slow_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;

constexpr double kStep = 1.0 / 60;

WorldConfig slow_below(double speed) {
  WorldConfig config;
  config.sleep_speed = speed;
  return config;
}

void run(World& world, int steps) {
  for (int i = 0; i < steps; ++i) world.step(kStep);
}

/// A weight of 1 kg on a hinge 1 m above it, `angle` off its lowest place [rad].
struct Pendulum {
  BodyId weight;
  JointId hinge;
};

Pendulum hang(World& world, double angle) {
  Pendulum p;
  p.weight = add(world, {std::sin(angle), 5 - std::cos(angle)}, smooth(make_disc(0.1)), 1, {}, 0, angle);
  p.hinge = world.create_joint({.b = p.weight, .anchor_a = {0, 5}});
  return p;
}

class Slow : public testing::TestWithParam<const char*> {};

TEST_P(Slow, ADiscThatRollsSlowlyStopsAfterHalfASecond) {
  for (const double speed : {0.0, 0.05}) {
    WorldConfig config = slow_below(speed);
    config.stepper = GetParam();
    World world(config);
    add_ground(world, rough(make_disc(1), 0.5));
    const BodyId disc = add(world, {0, 0.5}, rough(make_disc(0.5), 0.5), 1, {0.02, 0}, -0.04);
    run(world, 20);
    EXPECT_NEAR(world.velocity(disc).x, 0.02, 1e-12);
    run(world, 40);
    EXPECT_EQ(world.asleep(disc), speed > 0);
    if (speed == 0) {
      EXPECT_NEAR(world.velocity(disc).x, 0.02, 1e-9);
      continue;
    }
    EXPECT_EQ(world.velocity(disc).x, 0);
    EXPECT_NEAR(world.position(disc).x, 0.01, 1e-3);
    // Forces that hold it there are exact.
    EXPECT_EQ(world.report().inexact_islands, 0);
    // A faster one never stops.
    World other(config);
    add_ground(other, rough(make_disc(1), 0.5));
    const BodyId fast = add(other, {0, 0.5}, rough(make_disc(0.5), 0.5), 1, {0.06, 0}, -0.12);
    run(other, 300);
    EXPECT_NEAR(other.velocity(fast).x, 0.06, 1e-9);
  }
}

TEST_P(Slow, WhatHangsAsideIsHeldThereAndTheReportSaysSo) {
  WorldConfig config = slow_below(0.05);
  config.stepper = GetParam();
  World world(config);
  // It swings at up to 0.03 m/s.
  const Pendulum p = hang(world, 0.01);
  run(world, 120);
  ASSERT_TRUE(world.asleep(p.weight));
  const Vec2 place = world.position(p.weight);
  const double angle = std::atan2(place.x, 5 - place.y);
  EXPECT_LT(std::abs(angle), 0.0101);
  EXPECT_EQ(world.report().inexact_islands, 1);
  // What gravity would do to it, of what it does to a body that falls; a rim goes faster by a tenth.
  EXPECT_NEAR(world.report().worst_residual, 1.1 / 1.005 * std::abs(std::sin(angle)), 2e-4);
  EXPECT_NEAR(world.joints()[p.hinge.index].impulse.y / kStep, 9.81, 0.01);
  run(world, 600);
  EXPECT_EQ(world.position(p.weight), place);
  // A push makes it swing again, as if nothing had been, and stops again half a second after it.
  world.apply_impulse(p.weight, {0.3, 0}, place);
  run(world, 60);
  EXPECT_FALSE(world.asleep(p.weight));
  EXPECT_GT(std::abs(world.velocity(p.weight).x) + std::abs(world.position(p.weight).x), 0.05);
}

TEST_P(Slow, WhatIsHeldFallsWhenItsSupportGoes) {
  for (const int what : {0, 1, 2, 3}) {
    for (const bool sleep : {true, false}) {
      SCOPED_TRACE(what);
      WorldConfig config = slow_below(0.05);
      config.stepper = GetParam();
      config.sleep = config.reuse_resting = sleep;
      World world(config);
      const Pendulum p = hang(world, 0.01);
      run(world, 120);
      ASSERT_EQ(world.velocity(p.weight), Vec2{});
      const Vec2 place = world.position(p.weight);
      if (what == 0) world.destroy(p.hinge);
      if (what == 1) world.set_gravity({3, -9.81});
      if (what == 2) world.apply_force(p.weight, {2, 0}, place);
      if (what == 3) world.set_velocity(p.weight, {0.02, 0}, 0);
      world.step(kStep);
      EXPECT_NE(world.position(p.weight), place);
      if (what < 2) {
        run(world, 20);
        EXPECT_GT(length(world.position(p.weight) - place), 0.1);
      }
    }
  }
}

TEST_P(Slow, WhatLiesOnATableFallsWithItAndIsPushedByIt) {
  for (const double move : {0.0, 0.1, -0.1}) {
    for (const bool sleep : {true, false}) {
      WorldConfig config = slow_below(0.05);
      config.stepper = GetParam();
      config.sleep = config.reuse_resting = sleep;
      World world(config);
      const BodyId table = world.create_body({.type = BodyType::Static, .position = {0, 1}});
      world.add_shape(table, rough(make_box({4, 0.2}), 0.5));
      const BodyId disc = add(world, {0, 1.6}, rough(make_disc(0.5), 0.5), 1, {0.02, 0}, -0.04);
      run(world, 60);
      ASSERT_EQ(world.velocity(disc), Vec2{});
      if (move == 0)
        world.destroy(table);
      else
        world.set_pose(table, {0, 1 + move}, 0);
      run(world, 60);
      if (move == 0)
        EXPECT_LT(world.position(disc).y, -2);
      else
        EXPECT_NEAR(world.position(disc).y, 1.6 + move, 1e-6);
    }
  }
}

TEST_P(Slow, WhatRestsExactlyIsLeftAlone) {
  WorldConfig config = slow_below(0.05);
  config.stepper = GetParam();
  for (const bool reuse : {true, false}) {
    config.reuse_resting = config.sleep = reuse;
    World world(config), plain(WorldConfig{.stepper = GetParam(), .reuse_resting = reuse, .sleep = reuse});
    for (World* w : {&world, &plain}) {
      add_ground(*w, rough(make_disc(1), 0.5));
      for (int i = 0; i < 5; ++i) add(*w, {0, 0.5 + i}, rough(make_box({1, 1}), 0.5));
      run(*w, 100);
    }
    EXPECT_EQ(world.report().state_hash, plain.report().state_hash);
    EXPECT_EQ(world.report().inexact_islands, 0);
    EXPECT_LT(world.report().worst_residual, 1e-10);
  }
}

TEST_P(Slow, WhatNothingHoldsOrWhatIsToldToMoveGoesOn) {
  WorldConfig config = slow_below(0.05);
  config.stepper = GetParam();
  config.gravity = {0, 0};
  World space(config);
  const BodyId one = add(space, {0, 0}, smooth(make_disc(0.5)), 1, {0.02, 0});
  const BodyId a = add(space, {0, 3}, smooth(make_box({1, 1})), 1, {0.02, 0});
  const BodyId b = add(space, {1, 3}, smooth(make_box({1, 1})), 1, {0.02, 0});
  space.create_joint({.kind = JointKind::Weld, .a = a, .b = b, .anchor_a = {0.5, 3}});
  run(space, 300);
  EXPECT_NEAR(space.position(one).x, 0.1, 1e-9);
  EXPECT_NEAR(space.position(b).x, 1.1, 1e-9);

  config.gravity = {0, -9.81};
  std::vector<Vec2> places;
  for (const double speed : {0.05, 0.0}) {
    config.sleep_speed = speed;
    World world(config);
    const BodyId lift =
        world.create_body({.type = BodyType::Kinematic, .position = {0, -0.1}, .velocity = {0.01, 0.02}});
    world.add_shape(lift, rough(make_box({4, 0.2}), 0.5));
    const BodyId box = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5), 1, {0.01, 0.02});
    run(world, 300);
    EXPECT_NEAR(world.position(box).y, 0.6, 1e-6);
    places.push_back(world.position(box));
  }
  EXPECT_EQ(places[0], places[1]);
}

INSTANTIATE_TEST_SUITE_P(By, Slow, testing::Values("time_stepping", "event_driven", "auto"),
                         [](const auto& given) { return std::string(given.param); });

TEST(SlowHeaps, PeopleFallAsleepSooner) {
  constexpr int kSteps = 500;
  int asleep[2] = {}, steps[2] = {};
  for (const bool slow : {false, true}) {
    for (unsigned seed = 1; seed <= 4; ++seed) {
      World world(slow_below(slow ? 0.05 : 0));
      const BodyId pit = add_ground(world, rough(make_box({1, 1}), 0.6));
      for (const double side : {-1.0, 1.0})
        world.add_shape(pit, rough(make_half_plane({2.5 * side, 0}, {-side, 0.2}), 0.6));
      for (int k = 0; k < 20; ++k) {
        const double lean = 0.1 * std::sin(7.0 * k + seed);
        for (const auto& hinge :
             test::add_ragdoll(world, {2.4 * (k % 2) - 1.2 + lean, 2 + 2.8 * std::floor(0.5 * k)}, {0, -3},
                               0.6)
                 .hinges)
          world.set_motor(hinge.joint, 0, 0.002);
      }
      int step = 0;
      while (step < kSteps && world.report().bodies_asleep < 220) {
        world.step(kStep);
        ++step;
      }
      asleep[slow] += world.report().bodies_asleep == 220;
      steps[slow] += step;
    }
  }
  std::printf("%d of 4 asleep, %d steps; without a threshold %d, %d steps\n", asleep[1], steps[1], asleep[0],
              steps[0]);
  EXPECT_GE(asleep[1], 3);
  EXPECT_LT(steps[1], steps[0]);
}

TEST(SlowHeaps, HaveTheSameBitsFromASnapshotAndForAnyThreads) {
  const auto make = [](int threads) {
    WorldConfig config = slow_below(0.05);
    config.threads = threads;
    World world(config);
    add_ground(world, rough(make_disc(1), 0.6));
    for (int k = 0; k < 4; ++k)
      for (const auto& hinge : test::add_ragdoll(world, {0.3 * k, 2 + 2.8 * k}, {0, -3}, 0.6).hinges)
        world.set_motor(hinge.joint, 0, 0.002);
    return world;
  };
  World world = make(1), others = make(4);
  for (int i = 0; i < 400; ++i) {
    const auto hash = world.step(kStep).state_hash;
    ASSERT_EQ(others.step(kStep).state_hash, hash) << i;
    if (i % 50 == 25) others = load_snapshot(save_snapshot(others));
  }
  EXPECT_GT(world.report().bodies_asleep, 0);
}

TEST(SlowHeaps, RefuseAThresholdThatIsNone) {
  for (const double speed :
       {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    EXPECT_THROW(World{slow_below(speed)}, std::invalid_argument) << speed;
}

}  // namespace slow_test
}  // namespace skerry
