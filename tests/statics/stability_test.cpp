// SPDX-License-Identifier: MIT
//
// Margins of worlds at rest: what counts as weight, what holds, and what the limit load is asked.
#include "physics/statics/stability.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <stdexcept>

#include "tests/support/worlds.h"

namespace skerry::statics::test {
namespace stability_test {

using skerry::test::add;
using skerry::test::add_ground;
using skerry::test::rough;
using skerry::test::smooth;

class StabilityTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!limit_load_available()) GTEST_SKIP() << limit_load_missing();
  }
};

TEST_F(StabilityTest, SpringsAndForcesPressButAreNoWeight) {
  for (const bool by_spring : {true, false}) {
    World world;
    add_ground(world, rough(make_disc(1), 0.3));
    const BodyId block = add(world, {0, 0.5}, rough(make_box({4, 1}), 0.3));
    const double press = 90;
    if (by_spring)
      world.create_joint({.kind = JointKind::Spring,
                          .b = block,
                          .anchor_a = {0, 10.5},
                          .anchor_b = {0, 0.5},
                          .length = 19,
                          .stiffness = press / 9});
    else
      world.apply_force(block, {0, -press}, {0, 0.5});
    const Stability stability = stability_of(analyse_rest(world));
    ASSERT_EQ(stability.status, LimitStatus::Optimal);
    EXPECT_NEAR(stability.margin, 0.3 * (press + 9.81) / 9.81, 1e-9);
    EXPECT_TRUE(stability.slides);
    EXPECT_FALSE(stability.to_left);  // both sides are alike: rounding does not choose
  }
}

TEST_F(StabilityTest, MotorsHoldUpToTheirLimit) {
  World world;
  const BodyId block = add(world, {0, 0}, smooth(make_box({1, 1})));
  JointDef slider{.kind = JointKind::Prismatic, .b = block, .anchor_a = {0, 0}, .axis = {1, 0}};
  slider.motor_speed = 0;
  slider.motor_limit = 5;
  const JointId joint = world.create_joint(slider);
  Stability stability = stability_of(analyse_rest(world));
  ASSERT_EQ(stability.status, LimitStatus::Optimal);
  EXPECT_NEAR(stability.margin, 5 / 9.81, 1e-9);
  EXPECT_EQ(stability.contact, -1);
  slider.motor_limit = kInfinity;
  world.set_joint(joint, slider);
  stability = stability_of(analyse_rest(world));
  EXPECT_EQ(stability.status, LimitStatus::Unbounded);
}

TEST_F(StabilityTest, BodyThatCannotTurnDoesNotTip) {
  // A tall box would tip at 0.1; without turning it slides at 0.5.
  for (const bool turns : {true, false}) {
    World world;
    add_ground(world, rough(make_disc(1), 0.5));
    const BodyId box = add(world, {0, 5}, rough(make_box({1, 10}), 0.5));
    if (!turns) world.set_mass(box, 1, 0);
    const RestAnalysis rest = analyse_rest(world);
    EXPECT_EQ(rest.system.bodies[0].angular > 0, turns);
    const Stability stability = stability_of(rest);
    ASSERT_EQ(stability.status, LimitStatus::Optimal);
    EXPECT_NEAR(stability.margin, turns ? 0.1 : 0.5, 1e-9);
    EXPECT_EQ(stability.slides, !turns);
  }
}

TEST_F(StabilityTest, WithoutGravityThereIsNoMargin) {
  World world(skerry::test::weightless());
  add_ground(world, rough(make_disc(1), 0.5));
  const BodyId box = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5));
  world.apply_force(box, {0, -10}, {0, 0.5});
  const RestAnalysis rest = analyse_rest(world);
  EXPECT_TRUE(rest.stands);
  EXPECT_EQ(stability_of(rest).status, LimitStatus::NoLoad);
}

TEST_F(StabilityTest, WhatSettledOnSpringsOnlyNearlyHasAMargin) {
  // A beam on two springs that are off by a hair: nothing but its motion would balance that.
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  const BodyId beam = add(world, {0, 1}, smooth(make_box({3, 0.2})), 10);
  for (const double x : {-1.0, 1.0}) {
    const BodyId foot = add(world, {x, 0.2}, rough(make_box({0.4, 0.4}), 0.5));
    world.create_joint({.kind = JointKind::Prismatic,
                        .a = foot,
                        .b = beam,
                        .anchor_a = {x, 0.2},
                        .axis = {0, 1},
                        .lower = {},
                        .upper = {},
                        .motor_speed = {}});
    world.create_joint({.kind = JointKind::Spring,
                        .a = foot,
                        .b = beam,
                        .anchor_a = {x, 0.2},
                        .anchor_b = {x, 1},
                        .length = 0.8 + 5 * 9.81 / 2000 * (1 + 1e-9),
                        .stiffness = 2000});
  }
  const RestAnalysis rest = analyse_rest(world);
  EXPECT_TRUE(rest.stands);
  const Stability stability = stability_of(rest);
  ASSERT_EQ(stability.status, LimitStatus::Optimal);
  EXPECT_GT(stability.margin, 0.05);
  EXPECT_LE(stability.margin, 0.5 + 1e-6);
}

TEST_F(StabilityTest, TinyAndMissingLiveLoadsAreToldApart) {
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  add(world, {0, 0.5}, rough(make_box({4, 1}), 0.5));
  const RestAnalysis rest = analyse_rest(world);
  const LimitLoad one = limit_load(rest.system, rest.load, {{1, 0, 0}});
  EXPECT_NEAR(one.factor, 0.5 * 9.81, 1e-9);
  for (const double size : {1e-9, 1e-15, 1e-30}) {
    const LimitLoad tiny = limit_load(rest.system, rest.load, {{size, 0, 0}});
    ASSERT_EQ(tiny.status, LimitStatus::Optimal) << size;
    EXPECT_NEAR(tiny.factor * size, one.factor, 1e-9) << size;
    EXPECT_NEAR(tiny.mechanism[0][0] * size, 1, 1e-9) << size;
  }
  EXPECT_EQ(limit_load(rest.system, rest.load, {{0, 0, 0}}).status, LimitStatus::NoLoad);
  EXPECT_EQ(limit_load(rest.system, {{0, 1, 0}}, {{0, 0, 0}}).status, LimitStatus::Infeasible);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)limit_load(rest.system, {{0, nan, 0}}, {{1, 0, 0}}), std::invalid_argument);
  EXPECT_THROW((void)limit_load(rest.system, rest.load, {{kInfinity, 0, 0}}), std::invalid_argument);
  EXPECT_THROW((void)missing_support(rest.system, {{0, nan, 0}}), std::invalid_argument);
}

TEST_F(StabilityTest, MotorsHoldEitherWayWithAndWithoutADeadLoad) {
  for (const Vec2 gravity : {Vec2{}, Vec2{0, -9.81}}) {
    World world({.gravity = gravity});
    const BodyId block = add(world, {0, 0}, smooth(make_box({1, 1})));
    JointDef slider{.kind = JointKind::Prismatic, .b = block, .anchor_a = {0, 0}, .axis = {1, 0}};
    slider.motor_speed = 0;
    slider.motor_limit = 5;
    world.create_joint(slider);
    const RestAnalysis rest = analyse_rest(world);
    for (const double side : {1.0, -1.0}) {
      const LimitLoad limit = limit_load(rest.system, rest.load, {{side, 0, 0}});
      ASSERT_EQ(limit.status, LimitStatus::Optimal) << side;
      EXPECT_NEAR(limit.factor, 5, 1e-9) << side;
    }
  }
}

TEST_F(StabilityTest, OfCornersThatSlideAlikeTheFirstIsNamed) {
  World world;
  add_ground(world, rough(make_disc(1), 0.3));
  add(world, {0, 0.5}, rough(make_box({4, 1}), 0.3));
  EXPECT_EQ(stability_of(analyse_rest(world)).contact, 0);
}

}  // namespace stability_test
}  // namespace skerry::statics::test
