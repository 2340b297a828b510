// SPDX-License-Identifier: MIT
//
// Joints in loops that hold the same thing twice: what moves under them goes on as if they held it once.
//
// Rows of such joints depend on each other where the joints hold. Half-way through a step, where straight
// ways lead, they did not, and then held what they never held: two bars that were bolted together twice stood
// still half-way, and turned backwards with as much as they had turned before, step after step.
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "tests/support/draw.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace joint_loops_test {

using test::Draw;
using test::smooth;

constexpr double kStep = 1.0 / 60;

/// Two bars that fly and turn as one.
struct Pair {
  World world;
  BodyId a, b;

  explicit Pair(const char* stepper) : world(by(stepper)) {
    a = test::add(world, {0, 0}, smooth(make_box({0.4, 0.3})), 1, {0.3, -1}, kOmega);
    b = test::add(world, {1, 0.1}, smooth(make_box({0.4, 0.3})), 1, Vec2{0.3, -1} + kOmega * Vec2{-0.1, 1},
                  kOmega);
  }

  static WorldConfig by(const char* stepper) {
    WorldConfig config;
    config.stepper = stepper;
    return config;
  }

  void join(JointKind kind, Vec2 at) {
    JointDef joint;
    joint.kind = kind;
    joint.a = a;
    joint.b = b;
    joint.anchor_a = joint.anchor_b = at;
    joint.axis = {1, 0.1};
    joint.ratio = -1;
    if (kind == JointKind::Distance) {
      joint.anchor_a = {0, at.x - 0.6};
      joint.anchor_b = {1, at.x - 0.4};
    }
    world.create_joint(joint);
  }

  static constexpr double kOmega = 2;
};

struct Kind {
  const char* name;
  int rows;
  JointKind kind;
  bool pins;  ///< a point of one to a point of the other
};
constexpr Kind kKinds[] = {
    {"revolute", 2, JointKind::Revolute, true},    {"distance", 1, JointKind::Distance, false},
    {"prismatic", 2, JointKind::Prismatic, false}, {"weld", 3, JointKind::Weld, true},
    {"wheel", 1, JointKind::Wheel, false},         {"gear", 1, JointKind::Gear, false}};

class JointLoops : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(By, JointLoops, testing::Values("time_stepping", "event_driven"),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(JointLoops, WhatIsBoltedTogetherTwiceTurnsAsOneBody) {
  int pairs = 0;
  for (const Kind& first : kKinds) {
    for (const Kind& second : kKinds) {
      // One that pins and another one, or a hinge besides, hold all there is.
      for (const bool hinged : {false, true}) {
        const bool pinned = hinged || first.pins || second.pins;
        if (!pinned || first.rows + second.rows + (hinged ? 2 : 0) < 4) continue;
        SCOPED_TRACE(std::string(first.name) + " and " + second.name + (hinged ? " and a hinge" : ""));
        Pair pair(GetParam());
        pair.join(first.kind, {1, 0.1});
        pair.join(second.kind, {0.5, 0.05});
        if (hinged) pair.join(JointKind::Revolute, {0.7, 0.2});
        const Vec2 middle = 0.5 * (pair.world.position(pair.a) + pair.world.position(pair.b));
        const Vec2 v = 0.5 * (pair.world.velocity(pair.a) + pair.world.velocity(pair.b));
        const double length_before = length(pair.world.position(pair.b) - pair.world.position(pair.a));
        for (int k = 1; k <= 60; ++k) {
          pair.world.step(kStep);
          ASSERT_NEAR(pair.world.omega(pair.a), Pair::kOmega, 2e-4) << "step " << k;
          ASSERT_NEAR(pair.world.omega(pair.b), Pair::kOmega, 2e-4) << "step " << k;
          ASSERT_LT(pair.world.report().worst_residual, 1e-8) << "step " << k;
        }
        const Vec2 flown = middle + v + 0.5 * Vec2{0, -9.81};
        const Vec2 d = pair.world.position(pair.b) - pair.world.position(pair.a);
        EXPECT_LT(length(0.5 * (pair.world.position(pair.a) + pair.world.position(pair.b)) - flown), 1e-9);
        EXPECT_NEAR(length(d), length_before, 1e-9);
        EXPECT_NEAR(std::remainder(std::atan2(d.y, d.x) - std::atan2(0.1, 1) - Pair::kOmega, 2 * kPi), 0,
                    2e-3);
        ++pairs;
      }
    }
  }
  EXPECT_GT(pairs, 40);
}

/// A body on two rails that are parallel, and a platform on three parallel bars, move as on one and on two.
TEST_P(JointLoops, OneJointMoreThanIsNeededChangesNothing) {
  const auto platform = [](int bars) {
    World world(Pair::by(GetParam()));
    ShapeDef thin = smooth(make_box({3, 0.2}));
    thin.filter.mask = 0;
    const Vec2 down{std::sin(0.6), -std::cos(0.6)};
    const BodyId deck = test::add(world, Vec2{0, 5} + 2 * down, thin, 5);
    for (int i = 0; i < bars; ++i) {
      const double x = bars == 2 ? -1.2 + 2.4 * i : -1.2 + 1.2 * i;
      world.create_joint(
          {.kind = JointKind::Distance, .b = deck, .anchor_a = {x, 5}, .anchor_b = Vec2{x, 5} + 2 * down});
    }
    for (int k = 0; k < 120; ++k) world.step(kStep);
    return world.position(deck);
  };
  EXPECT_LT(length(platform(3) - platform(2)), 1e-9);
  const auto slider = [](int rails) {
    World world(Pair::by(GetParam()));
    const BodyId sledge = test::add(world, {0, 0}, smooth(make_box({1, 0.4})), 2);
    for (int i = 0; i < rails; ++i) {
      JointDef rail;
      rail.kind = JointKind::Prismatic;
      rail.b = sledge;
      rail.anchor_a = {-0.3 + 0.6 * i, 0.1};
      rail.axis = {std::cos(0.6), std::sin(0.6)};
      world.create_joint(rail);
    }
    for (int k = 0; k < 120; ++k) world.step(kStep);
    return world.position(sledge);
  };
  EXPECT_LT(length(slider(2) - slider(1)), 1e-9);
}

/// A slider between two bodies that are also welded has nowhere to go, however its motor pushes.
TEST_P(JointLoops, ADriveThatCannotMoveLoadsNothingBeyondItsForce) {
  for (const JointKind kind : {JointKind::Prismatic, JointKind::Wheel}) {
    for (unsigned seed = 0; seed < 60; ++seed) {
      Draw draw(31 * seed);
      World world(Pair::by(GetParam()));
      world.set_gravity({0, 0});
      const auto body = [&](Vec2 at) {
        const Vec2 v{draw.uniform(-2, 2), draw.uniform(-2, 2)};
        return test::add(world, at, smooth(make_box({0.4, 0.2})), 1, v, draw.uniform(-4, 4));
      };
      const BodyId a = body({1.5, 0}), b = body({3, draw.uniform(-1, 1)});
      JointDef drive{.kind = kind, .a = a, .b = b};
      drive.anchor_a = {3 + draw.uniform(-0.3, 0.3), 0.2};
      drive.axis = {draw.uniform(-1, 1), 1};
      drive.motor_speed = 1;
      drive.motor_limit = draw.uniform(1, 30);
      if (kind == JointKind::Wheel) {
        drive.stiffness = 800;
        drive.damping = 10;
      }
      JointDef weld{.kind = JointKind::Weld, .a = a, .b = b};
      weld.anchor_a = {2.5 + draw.uniform(-0.3, 0.3), draw.uniform(-0.3, 0.3)};
      weld.break_force = 1e4;
      world.create_joint(drive);
      world.create_joint(weld);
      for (int k = 0; k < 60; ++k)
        ASSERT_TRUE(world.step(kStep).joint_events.empty()) << "seed " << seed << ", step " << k;
    }
  }
}

TEST_P(JointLoops, ADrawerOnTwoGuidesStrikesItsStopsExactly) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    Draw draw(seed);
    World world(Pair::by(GetParam()));
    const auto body = [&](Vec2 at) {
      const Vec2 v{draw.uniform(-2, 2), draw.uniform(-2, 2)};
      return test::add(world, at, smooth(make_box({0.4, 0.2})), draw.uniform(0.5, 2), v, draw.uniform(-4, 4));
    };
    const BodyId cabinet = body({0, 0}), drawer = body({1, 0.2});
    JointDef guide{.kind = JointKind::Prismatic, .a = cabinet, .b = drawer, .anchor_a = {1, 0.5}};
    guide.axis = {1, draw.uniform(-0.3, 0.3)};
    guide.lower = -0.1;
    guide.upper = 0.1;
    world.create_joint(guide);
    guide.lower.reset();
    guide.upper.reset();
    guide.anchor_a = {1.1, -0.3};
    world.create_joint(guide);
    for (int k = 0; k < 60; ++k)
      ASSERT_EQ(world.step(kStep).inexact_islands, 0) << "seed " << seed << ", step " << k;
  }
}

}  // namespace joint_loops_test
}  // namespace skerry
