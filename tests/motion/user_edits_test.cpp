// SPDX-License-Identifier: MIT
//
// What the user does to bodies: puts one into another, gives one more shapes, moves or takes away what they
// lie or hang on. Overlaps go, and joints close, whichever stepper it is, and what swings goes on.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <vector>

#include "tests/support/draw.h"
#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace user_edits_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;

constexpr double kStep = 1.0 / 60;

class UserEdits : public testing::TestWithParam<const char*> {};

TEST_P(UserEdits, WhatIsPutBetweenBodiesAtRestPushesThemApart) {
  WorldConfig config;
  config.stepper = GetParam();
  World world(config);
  add_ground(world, rough(make_disc(1), 0.5));
  add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5));
  const BodyId upper = add(world, {0, 1.5}, rough(make_box({1, 1}), 0.5));
  for (int i = 0; i < 60; ++i) world.step(kStep);
  const BodyId wedge = add(world, {0, 1}, rough(make_box({0.9, 0.3}), 0.5));
  for (int i = 0; i < 120; ++i) world.step(kStep);
  EXPECT_LT(world.report().worst_penetration, 1e-9);
  EXPECT_NEAR(world.position(wedge).y, 1.15, 1e-6);
  EXPECT_NEAR(world.position(upper).y, 1.8, 1e-6);
  // And what grows into another.
  world.add_shape(wedge, rough(make_box({0.9, 0.1}, {0, 0.2}), 0.5));
  for (int i = 0; i < 120; ++i) world.step(kStep);
  EXPECT_LT(world.report().worst_penetration, 1e-9);
  EXPECT_NEAR(world.position(upper).y, 1.9, 1e-6);
}

TEST_P(UserEdits, AForceThatWaitsActsWhereItWasAppliedWhateverShapesCome) {
  WorldConfig config;
  config.stepper = GetParam();
  config.gravity = {0, 0};
  World world(config), other(config);
  const auto make = [](World& w, bool late) {
    const BodyId body = w.create_body({});
    w.add_shape(body, rough(make_box({1, 1}), 0.5));
    if (late) w.apply_force(body, {0, 50}, {0, 0});
    w.add_shape(body, rough(make_box({1, 1}, {1, 0}), 0.5));
    if (!late) w.apply_force(body, {0, 50}, {0, 0});
    return body;
  };
  const BodyId late = make(world, true), early = make(other, false);
  world.step(kStep);
  other.step(kStep);
  EXPECT_LT(other.omega(early), -1e-4);
  EXPECT_NEAR(world.omega(late), other.omega(early), 1e-15);
  EXPECT_NEAR(world.velocity(late).y, other.velocity(early).y, 1e-15);
}

TEST_P(UserEdits, AJointBetweenWhatIsHeldBearsNothing) {
  WorldConfig config;
  config.stepper = GetParam();
  World world(config);
  const BodyId upper = add(world, {0, 3}, rough(make_disc(0.5), 0.5), 10);
  const BodyId lower = add(world, {0, 1}, rough(make_disc(0.5), 0.5), 10);
  world.create_joint({.kind = JointKind::Revolute, .b = upper, .anchor_a = {0, 3}});
  const JointId rod = world.create_joint(
      {.kind = JointKind::Distance, .a = upper, .b = lower, .anchor_a = {0, 3}, .anchor_b = {0, 1}});
  world.step(kStep);
  EXPECT_NEAR(length(world.joint_force(rod)), 98.1, 1e-6);
  world.set_type(lower, BodyType::Static);
  world.step(kStep);
  world.set_type(upper, BodyType::Static);
  for (const double h : {kStep, 0.1 * kStep}) {
    world.step(h);
    EXPECT_EQ(world.joint_force(rod), (Vec2{0, 0}));
  }
}

TEST_P(UserEdits, WhatFliesIsTakenApart) {
  // Few, and so many that they would fly by their own clocks; they part by themselves, but slowly.
  for (const int count : {2, 40}) {
    WorldConfig config = test::weightless();
    config.stepper = GetParam();
    World world(config);
    for (int k = 0; k < count; ++k)
      add(world, {0.7 * k, 0}, rough(k % 3 == 0 ? make_box({1, 1}) : make_disc(0.5), 0.5), 1, {0.01 * k, 0});
    const double energy = world.kinetic_energy();
    for (int i = 0; i < 10; ++i) world.step(kStep);
    EXPECT_LT(world.report().worst_penetration, 1e-9) << count;
    EXPECT_LE(world.kinetic_energy(), energy * (1 + 1e-9)) << count;
  }
}

/// A joint that is made in the place of another one is between other bodies: these are one island now.
TEST_P(UserEdits, JointsInThePlaceOfOthersHold) {
  WorldConfig config = test::weightless();
  config.stepper = GetParam();
  World world(config);
  const BodyId a = add(world, {0, 0}, rough(make_disc(0.5), 0.5), 1, {0, 1});
  const BodyId b = add(world, {2, 0}, rough(make_disc(0.5), 0.5), 1, {0, -1});
  const BodyId c = add(world, {-2, 0}, rough(make_disc(0.5), 0.5), 1, {0, 2});
  const auto rod = [&](BodyId other) {
    return world.create_joint({.kind = JointKind::Distance,
                               .a = a,
                               .b = other,
                               .anchor_a = world.position(a),
                               .anchor_b = world.position(other)});
  };
  const JointId first = rod(b);
  for (int i = 0; i < 10; ++i) world.step(kStep);
  world.destroy(first);
  const JointId second = rod(c);
  ASSERT_EQ(second.index, first.index);
  const double far = length(world.position(c) - world.position(a));
  const Vec2 straight = world.velocity(b);
  const double spin = world.angular_momentum();
  for (int i = 0; i < 60; ++i) {
    EXPECT_EQ(world.step(kStep).islands, 2);
    EXPECT_NEAR(length(world.position(c) - world.position(a)), far, 1e-9) << i;
  }
  EXPECT_EQ(world.velocity(b), straight);
  EXPECT_NEAR(world.angular_momentum(), spin, 1e-12);
}

TEST_P(UserEdits, LeaveNoOverlapsAndNoOpenJoints) {
  const auto trials = static_cast<unsigned>(test_scale(40));
  for (unsigned seed = 1; seed <= trials; ++seed) {
    std::mt19937 random(seed);
    const auto uniform = [&](double low, double high) {
      return low + (high - low) * (random() / 4294967296.0);
    };
    WorldConfig config;
    config.stepper = GetParam();
    World world(config);
    add_ground(world, rough(make_disc(1), 0.5));
    const BodyId table = world.create_body({.type = BodyType::Static, .position = {0, 1}});
    world.add_shape(table, rough(make_box({6, 0.2}), 0.5));
    std::vector<BodyId> bodies;
    double top = 1.1;
    const unsigned high = 2 + random() % 4;
    for (unsigned i = 0; i < high; ++i) {
      const double size = uniform(0.4, 0.9);
      const Shape shape = i + 1 == high && random() % 4 == 0 ? make_disc(size / 2) : make_box({size, size});
      bodies.push_back(add(world, {uniform(-0.1, 0.1), top + size / 2}, rough(shape, 0.5), uniform(0.5, 2)));
      top += size;
    }
    bodies.push_back(add(world, {2, 1.4}, rough(make_box({0.6, 0.6}), 0.5)));
    bodies.push_back(add(world, {5, 0.3}, rough(make_box({0.6, 0.6}), 0.5)));
    const BodyId hook = world.create_body({.type = BodyType::Static, .position = {-6, 5}});
    const BodyId weight = add(world, {-6, 3.5}, rough(make_disc(0.4), 0.5));
    const bool rod = random() % 2 == 0;
    const Vec2 hold = rod ? Vec2{-6, 3.5} : Vec2{-6, 5};
    world.create_joint({.kind = rod ? JointKind::Distance : JointKind::Revolute,
                        .a = hook,
                        .b = weight,
                        .anchor_a = {-6, 5},
                        .anchor_b = hold});
    bodies.push_back(weight);
    for (int i = 0; i < 120; ++i) world.step(kStep);

    const BodyId picked = bodies[random() % bodies.size()];
    const Vec2 way{uniform(-0.4, 0.4), uniform(-0.4, 0.4)};
    const auto edit = random() % 5;
    if (edit == 0) world.set_pose(hook, world.position(hook) + way, 0);
    if (edit == 1) add(world, world.position(picked) + way, rough(make_disc(0.2), 0.5));
    if (edit == 2) world.set_pose(picked, world.position(picked) + way, 0);
    if (edit == 3 && picked != weight) world.add_shape(picked, rough(make_box({0.3, 0.3}, way), 0.5));
    if (edit == 4) world.destroy(table);
    for (int i = 0; i < 300; ++i) world.step(kStep);
    EXPECT_LT(world.report().worst_penetration, 1e-6) << "seed " << seed << ", edit " << edit;
    EXPECT_NEAR(length(world.position(weight) - world.position(hook)), 1.5, 1e-6)
        << "seed " << seed << ", edit " << edit;
  }
}

/// What is off its joints goes where they are, and its speed stays: the height is no work.
TEST_P(UserEdits, ABarSwingsOnWhereItIsPut) {
  enum class Edit { None, StaticHook, KinematicHook, Bar, Motion, Length };
  const auto turns = [&](Edit edit, double up) {
    WorldConfig config;
    config.stepper = GetParam();
    World world(config);
    const BodyId hook = world.create_body(
        {.type = edit == Edit::StaticHook ? BodyType::Static : BodyType::Kinematic, .position = {0, 0}});
    const BodyId bar = add(world, {0.5, 0}, rough(make_box({1, 0.1}), 0.5), 1);
    JointDef def{.kind = JointKind::Revolute, .a = hook, .b = bar};
    if (edit == Edit::Length) def = {.kind = JointKind::Distance, .a = hook, .b = bar, .anchor_b = {0.5, 0}};
    const JointId joint = world.create_joint(def);
    for (int i = 0; i < 15; ++i) world.step(kStep);
    switch (edit) {
      case Edit::None:
        break;
      case Edit::StaticHook:
      case Edit::KinematicHook:
        world.set_pose(hook, {0, up}, 0);
        break;
      case Edit::Bar:
        world.set_pose(bar, world.position(bar) - Vec2{0, up}, world.angle(bar));
        break;
      case Edit::Motion:
        world.set_motion(hook, [=](double) { return Placement{{0, up}, 0}; });
        break;
      case Edit::Length:
        def.length = 0.5 - up;
        world.set_joint(joint, def);
    }
    world.step(kStep);
    const Vec2 arm = world.position(bar) - world.position(hook);
    EXPECT_NEAR(length(arm), edit == Edit::Length ? 0.5 - up : 0.5, 1e-12);
    return edit == Edit::Length ? cross(arm, world.velocity(bar)) / length(arm) : world.omega(bar);
  };
  const double without = turns(Edit::None, 0), on_a_rod = turns(Edit::Length, 0);
  for (const double up : {-0.05, -0.01, 0.01, 0.05}) {
    for (const Edit edit : {Edit::StaticHook, Edit::KinematicHook, Edit::Bar, Edit::Motion}) {
      EXPECT_NEAR(turns(edit, up), without, 0.1 * std::abs(up * without))
          << up << ", edit " << static_cast<int>(edit);
    }
    EXPECT_NEAR(turns(Edit::Length, up), on_a_rod, 0.1 * std::abs(up * on_a_rod)) << up;
  }
}

/// Bars that hang at rest from a hook, one from the other, with limits of their hinges [rad]; 0: none.
struct HungBars {
  HungBars(const char* stepper, int count, double limit) : world(with(stepper)) {
    hook = world.create_body({.type = BodyType::Static});
    BodyId above = hook;
    for (int i = 0; i < count; ++i) {
      ShapeDef bar = rough(make_box({0.1, 0.5}), 0.5);
      bar.filter.mask = 0;
      const BodyId body = add(world, {0, -0.25 - 0.5 * i}, bar, 1);
      JointDef hinge{.a = above, .b = body, .anchor_a = {0, -0.5 * i}, .anchor_b = {0, -0.5 * i}};
      if (limit > 0) {
        hinge.lower = -limit;
        hinge.upper = limit;
      }
      hinges.push_back(world.create_joint(hinge));
      above = body;
      bodies.push_back(body);
    }
    for (int i = 0; i < 5; ++i) world.step(kStep);
  }
  static WorldConfig with(const char* stepper) {
    WorldConfig config;
    config.stepper = stepper;
    return config;
  }
  /// How far anchors are apart [m], or beyond limits [rad].
  double worst(double limit) const {
    double most = 0;
    BodyId above = hook;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const Vec2 lower_end = i == 0 ? Vec2{} : Vec2{0, -0.25};
      most = std::max(
          most, length(to_world(world.pose(above), lower_end) - to_world(world.pose(bodies[i]), {0, 0.25})));
      if (limit > 0) most = std::max(most, std::abs(world.joint_position(hinges[i])) - limit);
      above = bodies[i];
    }
    return most;
  }

  World world;
  BodyId hook;
  std::vector<BodyId> bodies;
  std::vector<JointId> hinges;
};

TEST_P(UserEdits, BarsGoWithAHookThatIsPutFarAway) {
  for (const double limit : {0.0, 0.1, 0.3}) {
    for (const int count : {1, 2, 5}) {
      for (const double way : {0.05, 0.2, 1.0}) {
        // What is turned far comes up against limits one after the other.
        if (limit > 0 && (count > 2 || way > 0.3)) continue;
        for (int k = 0; k < 12; ++k) {
          HungBars bars(GetParam(), count, limit);
          const double angle = 2 * kPi * k / 12;
          bars.world.set_pose(bars.hook, way * Vec2{std::cos(angle), std::sin(angle)}, 0);
          bars.world.step(kStep);
          EXPECT_LT(bars.worst(limit), 1e-9) << limit << " rad, " << count << " bars, " << way << " m, " << k;
        }
      }
    }
  }
}

TEST_P(UserEdits, AChainFollowsItsHookStepByStep) {
  test::Draw draw(1);
  HungBars bars(GetParam(), 20, 0);
  int off = 0;
  Vec2 hook;
  for (int i = 0; i < 60; ++i) {
    const double angle = draw.uniform(0, 2 * kPi);
    hook += 0.05 * Vec2{std::cos(angle), std::sin(angle)};
    bars.world.set_pose(bars.hook, hook, 0);
    bars.world.step(kStep);
    off += bars.worst(0) > 1e-6;
    EXPECT_GT(bars.world.kinetic_energy(), 0) << i;
  }
  EXPECT_EQ(off, 0);
}

TEST_P(UserEdits, ABarIsNotPulledThroughAWall) {
  // The lower end would be behind the wall, beyond what counts as near.
  for (const double thick : {0.01, 0.05}) {
    for (const double gap : {0.0, 0.01, 0.03}) {
      for (const double way : {0.05, 0.1, 0.15}) {
        World world(HungBars::with(GetParam()));
        const BodyId hook = world.create_body({.type = BodyType::Static});
        const BodyId bar = add(world, {0, -0.25}, rough(make_box({0.02, 0.5}), 0.3), 1);
        world.create_joint({.a = hook, .b = bar});
        const BodyId wall =
            world.create_body({.type = BodyType::Static, .position = {-0.01 - gap - 0.5 * thick, -0.5}});
        world.add_shape(wall, rough(make_box({thick, 0.3}), 0.3));
        for (int i = 0; i < 10; ++i) world.step(kStep);
        world.set_pose(hook, {way, 0}, 0);
        for (int i = 0; i < 60; ++i) {
          world.step(kStep);
          EXPECT_GT(to_world(world.pose(bar), {0, -0.25}).x, -0.011 - gap)
              << thick << " m, " << gap << " m, " << way << " m, step " << i;
        }
      }
    }
  }
}

/// A step of many pieces is not one in flow.
TEST_P(UserEdits, ABarKeepsItsSpeedAfterABusyStep) {
  for (const double up : {-0.01, 0.01, 0.03}) {
    World world(HungBars::with(GetParam()));
    add_ground(world, rough(make_disc(1), 0.5));
    const BodyId hook = world.create_body({.type = BodyType::Static, .position = {0, 2}});
    const BodyId bar = add(world, {0.5, 2}, rough(make_box({1, 0.1}), 0.5), 1);
    world.create_joint({.a = hook, .b = bar, .anchor_a = {0, 2}, .anchor_b = {0, 2}});
    // Balls that land in one step, joined by slack ropes.
    for (int i = 0; i < 6; ++i) {
      const Vec2 at{1 + 0.3 * i, 0.3 + 0.003 * i};
      const BodyId ball = add(world, at, rough(make_disc(0.1), 0.5), 0.1);
      world.create_joint(
          {.kind = JointKind::Rope, .a = bar, .b = ball, .anchor_a = {0.5, 2}, .anchor_b = at, .length = 4});
    }
    int most = 0;
    for (int k = 0; k < 60 && most <= 4; ++k) most = world.step(kStep).substeps;
    ASSERT_GT(most, 4);
    const double before = world.kinetic_energy();
    world.set_pose(hook, {0, 2 + up}, 0);
    world.step(1e-6);
    EXPECT_NEAR(world.kinetic_energy(), before, 5 * up * up) << up;
  }
}

/// What is told to stand still is ground like any other.
TEST_P(UserEdits, ADoublePendulumKeepsItsEnergyOnWhatIsToldToStandStill) {
  World world(HungBars::with(GetParam()));
  const BodyId hook = world.create_body({.type = BodyType::Kinematic});
  world.set_motion(hook, [](double) { return Placement{}; });
  BodyId above = hook;
  for (int i = 0; i < 2; ++i) {
    const BodyId bar = add(world, {0.5 + i, 0}, smooth(make_box({1, 0.1})), 1);
    world.create_joint({.a = above, .b = bar, .anchor_a = {1.0 * i, 0}, .anchor_b = {1.0 * i, 0}});
    above = bar;
  }
  const auto energy = [&] { return world.kinetic_energy() + world.potential_energy(); };
  const double before = energy();
  for (int i = 0; i < 300; ++i) world.step(kStep);
  EXPECT_NEAR(energy(), before, 1e-9);
}

TEST(SteppersAfterEdits, ChangeSpeedsAlikeWhereAJointIsMadeFarTooShort) {
  std::vector<double> energies;
  for (const char* stepper : {"time_stepping", "event_driven"}) {
    WorldConfig config = test::weightless();
    config.stepper = stepper;
    World world(config);
    const BodyId near = add(world, {2, 0}, smooth(make_disc(0.1)), 1, {0, 3});
    const BodyId far = add(world, {4, 0}, smooth(make_disc(0.1)), 1, {0, 1});
    world.create_joint(
        {.kind = JointKind::Distance, .a = near, .b = far, .anchor_a = {2, 0}, .anchor_b = {4, 0}});
    world.step(kStep);
    world.create_joint({.kind = JointKind::Distance,
                        .b = near,
                        .anchor_a = {0, 0},
                        .anchor_b = world.position(near),
                        .length = 1});
    world.step(kStep);
    EXPECT_NEAR(length(world.position(near)), 1, 1e-9) << stepper;
    energies.push_back(world.kinetic_energy());
  }
  EXPECT_NEAR(energies[0], energies[1], 1e-5);
}

INSTANTIATE_TEST_SUITE_P(By, UserEdits, testing::Values("time_stepping", "event_driven", "auto"),
                         [](const auto& given) { return std::string(given.param); });

}  // namespace user_edits_test
}  // namespace skerry
