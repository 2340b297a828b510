// SPDX-License-Identifier: MIT
//
// Bodies without shapes: nothing but a mass on its joints. They move as others do, by formula.
#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include "tests/support/worlds.h"

namespace skerry {
namespace shapeless_test {

constexpr double kStep = 1.0 / 60;

class WithoutShapes : public testing::TestWithParam<const char*> {
 protected:
  World world{{.stepper = GetParam()}};

  BodyId wheel(Vec2 at = {}, double omega = 0) {
    return world.create_body({.position = at, .omega = omega, .mass = 2.0, .inertia = 0.1});
  }
  void run_a_second() {
    for (int i = 0; i < 60; ++i) world.step(kStep);
  }
};

TEST_P(WithoutShapes, AWheelOnItsAxleTurnsOn) {
  const BodyId body = wheel({}, 5);
  world.create_joint({.kind = JointKind::Revolute, .b = body});
  run_a_second();
  EXPECT_NEAR(world.angle(body), 5, 1e-12);
  EXPECT_NEAR(world.omega(body), 5, 1e-12);
  EXPECT_FALSE(world.asleep(body));
}

TEST_P(WithoutShapes, AMotorAndATorqueTurnIt) {
  const BodyId driven = wheel(), pushed = wheel({3, 0});
  world.create_joint({.kind = JointKind::Revolute, .b = driven, .motor_speed = 3, .motor_limit = 0.1});
  world.create_joint({.kind = JointKind::Revolute, .b = pushed, .anchor_a = {3, 0}});
  for (int i = 0; i < 60; ++i) {
    world.apply_torque(pushed, 0.1);
    world.step(kStep);
  }
  for (const BodyId body : {driven, pushed}) {
    EXPECT_NEAR(world.angle(body), 0.5, 1e-12);
    EXPECT_NEAR(world.omega(body), 1, 1e-12);
  }
}

TEST_P(WithoutShapes, GearsShareTheirMomentum) {
  const BodyId a = wheel({}, 1), b = wheel({1, 0});
  world.create_joint({.kind = JointKind::Revolute, .b = a});
  world.create_joint({.kind = JointKind::Revolute, .b = b, .anchor_a = {1, 0}});
  world.create_joint({.kind = JointKind::Gear, .a = a, .b = b, .ratio = 2});
  run_a_second();
  EXPECT_NEAR(world.omega(a), 0.2, 1e-12);
  EXPECT_NEAR(world.omega(b), -0.4, 1e-12);
}

TEST_P(WithoutShapes, APendulumKeepsItsEnergy) {
  const BodyId bob = world.create_body({.position = {1, 0}, .mass = 1.0, .inertia = 0.1});
  world.create_joint({.kind = JointKind::Revolute, .b = bob});
  int inexact = 0;
  for (int i = 0; i < 600; ++i) inexact += world.step(kStep).inexact_islands;
  EXPECT_NEAR(world.kinetic_energy() + world.potential_energy(), 0, 1e-10);
  EXPECT_EQ(inexact, 0);
}

TEST_P(WithoutShapes, ARubbingHingeComesToRest) {
  const BodyId bob = world.create_body({.position = {1, 0}, .mass = 1.0, .inertia = 0.1});
  world.create_joint({.kind = JointKind::Revolute, .b = bob, .motor_speed = 0, .motor_limit = 5});
  for (int i = 0; i < 600; ++i) world.step(kStep);
  EXPECT_TRUE(world.asleep(bob));
}

// A point that does not turn, on a rod: it has no size at all.
TEST_P(WithoutShapes, APointOnARodSwings) {
  const BodyId bob = world.create_body({.position = {1, 0}, .mass = 1.0});
  world.create_joint({.kind = JointKind::Distance, .b = bob, .anchor_b = {1, 0}});
  int inexact = 0;
  for (int i = 0; i < 600; ++i) inexact += world.step(kStep).inexact_islands;
  EXPECT_NEAR(world.kinetic_energy() + world.potential_energy(), 0, 1e-10);
  EXPECT_EQ(inexact, 0);
}

INSTANTIATE_TEST_SUITE_P(By, WithoutShapes, testing::Values("time_stepping", "event_driven", "auto"),
                         [](const auto& stepper) { return std::string(stepper.param); });

TEST(ShapeRemoved, ABodyThatLosesItsShapeSwingsOn) {
  World world;
  const BodyId bob = world.create_body({.position = {1, 0}, .mass = 1.0, .inertia = 0.1});
  const ShapeId disc = world.add_shape(bob, {.shape = make_disc(0.1)});
  world.create_joint({.kind = JointKind::Revolute, .b = bob});
  for (int i = 0; i < 60; ++i) world.step(kStep);
  world.destroy(disc);
  for (int i = 0; i < 540; ++i) world.step(kStep);
  EXPECT_NEAR(world.kinetic_energy() + world.potential_energy(), 0, 1e-10);
}

}  // namespace shapeless_test
}  // namespace skerry
