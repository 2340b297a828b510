// SPDX-License-Identifier: MIT
//
// Materials of pairs, filters, and events that go on.
#include "physics/material.h"

#include <gtest/gtest.h>

#include "tests/support/worlds.h"

namespace skerry {
namespace material_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;

TEST(Mixing, FollowsItsRule) {
  EXPECT_EQ(mix(MixingRule::Average, 0.2, 0.8), 0.5);
  EXPECT_EQ(mix(MixingRule::GeometricMean, 0.2, 0.8), 0.4);
  EXPECT_EQ(mix(MixingRule::Minimum, 0.2, 0.8), 0.2);
  EXPECT_EQ(mix(MixingRule::Maximum, 0.2, 0.8), 0.8);
}

/// Speed of rebound of a ball that arrives with 1 m/s at a static one.
double rebound(double e_a, MixingRule rule_a, double e_b, MixingRule rule_b) {
  World world(test::weightless());
  ShapeDef wall = smooth(make_box({1, 4}), e_a), ball = smooth(make_disc(0.5), e_b);
  wall.restitution_rule = rule_a;
  ball.restitution_rule = rule_b;
  world.add_shape(world.create_body({.type = BodyType::Static}), wall);
  const BodyId body = add(world, {1.5, 0}, ball, 1, {-1, 0});
  for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
  return world.velocity(body).x;
}

TEST(Mixing, OfRestitutionTakesTheLargerRuleOfTheTwoWhateverTheirOrder) {
  const auto average = MixingRule::Average, geometric = MixingRule::GeometricMean;
  const auto minimum = MixingRule::Minimum, maximum = MixingRule::Maximum;
  for (const bool exchange : {false, true}) {
    const auto of = [&](MixingRule a, MixingRule b) {
      return exchange ? rebound(0.8, b, 0.2, a) : rebound(0.2, a, 0.8, b);
    };
    EXPECT_NEAR(of(average, average), 0.5, 1e-12);
    EXPECT_NEAR(of(geometric, average), 0.4, 1e-12);
    EXPECT_NEAR(of(minimum, geometric), 0.2, 1e-12);
    EXPECT_NEAR(of(average, maximum), 0.8, 1e-12);
  }
}

TEST(Mixing, OfFrictionDecidesHowFarABlockSlides) {
  // mu g t of speed are lost in time t.
  for (const auto& [rule, mu] : {std::pair{MixingRule::Average, 0.25},
                                 {MixingRule::GeometricMean, 0.2},
                                 {MixingRule::Minimum, 0.1},
                                 {MixingRule::Maximum, 0.4}}) {
    World world;
    ShapeDef ground = rough(make_disc(1), 0.1), block = rough(make_box({1, 0.2}), 0.4);
    ground.friction_rule = block.friction_rule = rule;
    add_ground(world, ground);
    const BodyId body = add(world, {0, 0.1}, block, 1, {5, 0});
    for (int i = 0; i < 30; ++i) world.step(1.0 / 60);
    EXPECT_NEAR(world.velocity(body).x, 5 - mu * 9.81 * 0.5, 1e-9) << static_cast<int>(rule);
  }
}

TEST(Conveyor, CarriesABlockToItsSpeedByFrictionAndNotFaster) {
  World world;
  ShapeDef belt = rough(make_box({100, 1}, {0, -0.5}), 0.3);
  belt.material.surface_velocity = -1.5;  // counter-clockwise is to the left on top
  world.add_shape(world.create_body({.type = BodyType::Static}), belt);
  const BodyId body = add(world, {0, 0.1}, rough(make_box({1, 0.2}), 0.3));
  const double h = 1.0 / 60, catches_up = 1.5 / (0.3 * 9.81);
  for (int i = 1; i <= 60; ++i) {
    world.step(h);
    const double expected = std::min(1.5, 0.3 * 9.81 * i * h);
    if (std::abs(i * h - catches_up) > 2 * h) {
      ASSERT_NEAR(world.velocity(body).x, expected, 1e-9) << i;
    }
  }
}

TEST(Filter, GroupsGoBeforeMasksAndBothMasksMustAgree) {
  const Filter plain;
  EXPECT_TRUE(may_collide(plain, plain));
  EXPECT_TRUE(may_collide({2, 4, 0}, {4, 2, 0}));
  EXPECT_FALSE(may_collide({2, 4, 0}, {4, 1, 0})) << "one mask is not enough";
  EXPECT_TRUE(may_collide({1, 0, 7}, {1, 0, 7})) << "same positive group";
  EXPECT_FALSE(may_collide({1, ~0u, -7}, {1, ~0u, -7})) << "same negative group";
  EXPECT_TRUE(may_collide({1, ~0u, -7}, {1, ~0u, -8})) << "different groups fall back on the masks";
}

TEST(Events, ATouchingPairBeginsPersistsEveryStepAndEnds) {
  World world;
  world.observe({.contacts = true});  // pairs that go on are reported only then
  add_ground(world, smooth(make_disc(1)));
  const BodyId box = add(world, {0, 0.5}, smooth(make_box({1, 1})));
  const auto count = [&](ContactEventKind kind) {
    int n = 0;
    for (const ContactEvent& event : world.step(1.0 / 60).events) n += event.kind == kind ? 1 : 0;
    return n;
  };
  EXPECT_EQ(count(ContactEventKind::Begin), 1);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(count(ContactEventKind::Persist), 1) << i;
  world.set_velocity(box, {0, 3}, 0);
  int ends = 0;
  for (int i = 0; i < 5; ++i) ends += count(ContactEventKind::End);
  EXPECT_EQ(ends, 1);
  EXPECT_EQ(count(ContactEventKind::Persist), 0);
}

TEST(Material, RollingResistanceMayBeThatOfTheGroundOrOfTheWheel) {
  double omega[2] = {0, 0};
  for (const bool of_ground : {true, false}) {
    World world;
    ShapeDef ground = rough(make_disc(1), 0.8), wheel = rough(make_disc(0.5), 0.8);
    (of_ground ? ground : wheel).material.rolling_resistance = 0.02;
    add_ground(world, ground);
    const BodyId body = add(world, {0, 0.5}, wheel, 2, {2, 0}, -4);
    for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
    omega[of_ground ? 1 : 0] = world.omega(body);
  }
  // (3/2) m r^2 alpha = 0.02 m g
  EXPECT_NEAR(omega[0], -4 + 0.02 * 9.81 / (1.5 * 0.25), 1e-3);
  EXPECT_EQ(omega[0], omega[1]);
}

TEST(Events, ATouchingPairPersistsWhetherItSleepsOrNot) {
  for (const bool sleep : {false, true}) {
    World world({.sleep = sleep});
    world.observe({.contacts = true});
    add_ground(world, smooth(make_disc(1)));
    add(world, {0, 0.5}, smooth(make_box({1, 1})));
    world.step(1.0 / 60);
    for (int i = 0; i < 10; ++i) {
      const auto& events = world.step(1.0 / 60).events;
      ASSERT_EQ(events.size(), 1u) << sleep << ", " << i;
      EXPECT_EQ(events[0].kind, ContactEventKind::Persist) << sleep << ", " << i;
    }
    EXPECT_EQ(world.report().islands_at_rest, 1);
    EXPECT_EQ(world.report().islands_asleep, sleep ? 1 : 0);
  }
}

}  // namespace material_test
}  // namespace skerry
