// SPDX-License-Identifier: MIT
//
// Limits that are reached, ropes that become taut and motors that get to their speed within a step: each at a
// moment of its own, and nothing of it depends on where steps begin.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/draw.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace joint_limits_test {

using test::add;
using test::smooth;

constexpr double kStep = 1.0 / 60;

class JointLimits : public testing::TestWithParam<const char*> {
 protected:
  static World make(Vec2 gravity = {0, 0}) {
    WorldConfig config;
    config.gravity = gravity;
    config.stepper = GetParam();
    return World(config);
  }
};
INSTANTIATE_TEST_SUITE_P(By, JointLimits, testing::Values("time_stepping", "event_driven"),
                         [](const auto& test) { return std::string(test.param); });

/// A ball that falls into two slack ropes hangs still in the end, and each step of it is one piece.
TEST_P(JointLimits, OfTwoRopesBringABallToRest) {
  test::Draw draw(1132);
  for (int run = 0; run < 40; ++run) {
    World world = make({0, -9.81});
    const BodyId ball = add(world, {0, 0}, smooth(make_disc(0.1)));
    for (const double side : {-1, 1}) {
      const double angle = side * draw.uniform(0.3, 1.2), length = draw.uniform(0.4, 0.8);
      world.create_joint({.kind = JointKind::Rope,
                          .b = ball,
                          .anchor_a = {length * std::sin(angle), length * std::cos(angle)},
                          .length = length * draw.uniform(1, 1.1)});
    }
    int most = 0;
    while (world.time() < 2) {
      const StepReport& report = world.step(kStep);
      if (world.time() > 1.5) most = std::max(most, report.substeps + report.fallbacks);
    }
    EXPECT_LE(most, 2) << "run " << run;
  }
}

/// Ropes that are taut stay so, whatever rounding leaves of speed along them.
TEST_P(JointLimits, OfRopesUnderLoadDoNotLetGo) {
  test::Draw draw(1133);
  for (int run = 0; run < 40; ++run) {
    World world = make({0, -9.81});
    const double h = 1.0 / (60 << draw.pick(5)), way = draw.uniform(0.02, 0.05), omega = draw.uniform(3, 6);
    BodyId above = world.create_body({.type = BodyType::Kinematic});
    world.set_motion(above, [=](double t) { return Placement{{way * (1 - std::cos(omega * t)), 0}, 0}; });
    Vec2 from{0, 0};
    for (int k = 0; k < 2; ++k) {
      const double angle = draw.uniform(-0.2, 0.2), length = draw.uniform(0.3, 0.8);
      const Vec2 at = from + length * Vec2{std::sin(angle), -std::cos(angle)};
      const BodyId ball = add(world, at, smooth(make_disc(0.05)), draw.uniform(0.5, 2));
      world.create_joint({.kind = JointKind::Rope, .a = above, .b = ball, .anchor_a = from, .anchor_b = at});
      above = ball;
      from = at;
    }
    int events = 0;
    while (world.time() < 2) events += world.step(h).events_found;
    EXPECT_EQ(events, 0) << "run " << run;
  }
}

/// A motor that is switched off is none.
TEST_P(JointLimits, AMotorWithoutForceDoesNothing) {
  const auto angle = [](std::optional<double> motor) {
    World world = make({0, -9.81});
    const BodyId bob = add(world, {1, 0}, smooth(make_disc(0.1)));
    world.create_joint(
        {.kind = JointKind::Revolute, .b = bob, .motor_speed = motor, .motor_limit = motor ? 0 : kInfinity});
    int fallbacks = 0;
    while (world.time() < 2) fallbacks += world.step(kStep).fallbacks;
    EXPECT_EQ(fallbacks, 0);
    return world.angle(bob);
  };
  EXPECT_EQ(angle(-1), angle({}));
}

/// A bar that turns freely about its middle stops where its limit is, and turns on until then.
TEST_P(JointLimits, OfAHingeStopABarWhereTheyAre) {
  World world = make();
  const double omega = 7, upper = 0.4;
  const BodyId bar = add(world, {0, 0}, smooth(make_box({1, 0.1})), 2, {}, omega);
  const JointId hinge =
      world.create_joint({.kind = JointKind::Revolute, .b = bar, .lower = -1, .upper = upper});
  for (int k = 1; k <= 6; ++k) {
    world.step(kStep);
    const double free = k * kStep * omega;
    EXPECT_NEAR(world.joint_position(hinge), std::min(free, upper), 1e-12) << k;
    EXPECT_NEAR(world.omega(bar), free < upper ? omega : 0, 1e-12) << k;
  }
}

/// A ball at the end of a slack rope flies straight on until that is taut, and around its end from then on:
/// what it had along the rope is lost, what it had across stays.
TEST_P(JointLimits, OfARopeTakeWhatIsAlongIt) {
  World world = make();
  const Vec2 from{0, 1}, velocity{4, 0};
  const double rope = 1.25;
  const BodyId ball = add(world, from, smooth(make_disc(0.1)), 2, velocity);
  const JointId joint =
      world.create_joint({.kind = JointKind::Rope, .b = ball, .anchor_b = from, .length = rope});
  // Taut at (0.75, 1): 3/5 of the velocity is along the rope.
  const double across = 0.8 * 4, turn = across / rope, taut = 0.75 / 4;
  for (int k = 1; k <= 40; ++k) {
    const StepReport& report = world.step(kStep);
    const double time = k * kStep;
    if (time < taut - 1e-9) {
      EXPECT_NEAR(world.velocity(ball).x, 4, 1e-12);
      EXPECT_EQ(length(world.joint_force(joint)), 0) << k;
      continue;
    }
    EXPECT_NEAR(length(world.position(ball)), rope, 1e-9) << k;
    EXPECT_NEAR(length(world.velocity(ball)), across, 1e-9) << k;
    const double angle = std::atan2(1, 0.75) - (time - taut) * turn;
    EXPECT_LT(length(world.position(ball) - rope * Vec2{std::cos(angle), std::sin(angle)}), 3e-4) << k;
    // It does not come off, to be caught again.
    if (time < taut + kStep) continue;
    EXPECT_EQ(report.impacts, 0) << k;
    EXPECT_NEAR(length(world.joint_force(joint)), 2 * across * turn, 1e-2) << k;
  }
}

/// A rope that was taut and is slack pulls nothing, and says so.
TEST_P(JointLimits, PullNothingOnceTheyAreLeft) {
  World world = make();
  const BodyId ball = add(world, {1, 0}, smooth(make_disc(0.1)), 2, {0, 3});
  const JointId rope =
      world.create_joint({.kind = JointKind::Rope, .b = ball, .anchor_b = {1, 0}, .length = 1});
  for (int k = 0; k < 10; ++k) world.step(kStep);
  EXPECT_NEAR(length(world.joint_force(rope)), 2 * 3 * 3, 0.1);
  const Vec2 from = world.position(ball), inwards = -1 * from / length(from);
  world.set_velocity(ball, inwards, 0);
  for (int k = 0; k < 10; ++k) {
    world.step(kStep);
    EXPECT_EQ(length(world.joint_force(rope)), 0) << k;
  }
  EXPECT_LT(length(world.position(ball) - (from + 10 * kStep * inwards)), 1e-9);
}

/// Two bodies that slide on each other up to a limit fly on together with what both had.
TEST_P(JointLimits, OfASlideKeepMomentum) {
  World world = make();
  const BodyId a = add(world, {0, 0}, smooth(make_disc(0.2)), 1, {0, 0.5});
  const BodyId b = add(world, {1, 0}, smooth(make_disc(0.2)), 3, {4, 0.5});
  world.create_joint({.kind = JointKind::Prismatic, .a = a, .b = b, .anchor_a = {1, 0}, .upper = 0.3});
  for (int k = 1; k <= 12; ++k) {
    world.step(kStep);
    const bool together = k * kStep > 0.3 / 4;
    EXPECT_NEAR(world.velocity(a).x, together ? 3 : 0, 1e-12) << k;
    EXPECT_NEAR(world.velocity(b).x, together ? 3 : 4, 1e-12) << k;
  }
  EXPECT_NEAR(world.position(b).x - world.position(a).x, 1.3, 1e-12);
}

/// A motor that brakes a wheel against a load that it cannot hold: it pushes backwards with all of its torque
/// down to its speed, and forwards with all of it from then on.
TEST_P(JointLimits, AMotorChangesSidesWhereItPassesItsSpeed) {
  for (const double from : {3.0, 2.5, 2.2}) {
    World world = make();
    const BodyId wheel = add(world, {0, 0}, smooth(make_disc(0.5)), 8, {}, from);
    ASSERT_NEAR(world.inertia(wheel), 1, 1e-12);
    const double speed = 2, torque = 6, load = 20;
    world.create_joint(
        {.kind = JointKind::Revolute, .b = wheel, .motor_speed = speed, .motor_limit = torque});
    const double passes = (from - speed) / (load + torque);
    for (int k = 1; k <= 6; ++k) {
      world.apply_torque(wheel, -load);
      world.step(kStep);
      const double time = k * kStep;
      const double omega =
          time < passes ? from - time * (load + torque) : speed - (time - passes) * (load - torque);
      EXPECT_NEAR(world.omega(wheel), omega, 1e-11) << from << ", " << k;
    }
  }
}

/// What a motor holds at its speed stays there while all else turns.
TEST_P(JointLimits, AMotorKeepsItsSpeedWhileItsBodiesTurn) {
  World world = make();
  const BodyId a = add(world, {0, 0}, smooth(make_disc(0.3)), 2, {0.3, -0.2}, 3);
  const BodyId b = add(world, {0.8, 0.5}, smooth(make_disc(0.3)), 1, {0, 0}, 3);
  const JointId slide = world.create_joint({.kind = JointKind::Prismatic,
                                            .a = a,
                                            .b = b,
                                            .anchor_a = {0.8, 0.5},
                                            .axis = {1, 0.4},
                                            .motor_speed = 0.7,
                                            .motor_limit = 60});
  for (int k = 0; k < 60; ++k) {
    world.step(kStep);
    if (k < 2) continue;
    ASSERT_NEAR(world.joint_speed(slide), 0.7, 1e-9) << k;
  }
}

/// A blow on an arm whose motor has no limit changes how the whole moves, by its mass and inertia, and not
/// how the arm turns on its hub: two bodies on a driven hinge have as many rows as a weld, but go on turning.
TEST_P(JointLimits, AMotorWithoutLimitIsNotStoppedByABlow) {
  World world = make();
  const double speed = 5, e = 0.5, gap = 1e-8;
  const BodyId hub = add(world, {0, 0}, smooth(make_disc(0.2)), 10);
  const BodyId arm = add(world, {0.6, 0}, smooth(make_box({1, 0.1})), 1, {0, 0.6 * speed}, speed);
  const JointId hinge = world.create_joint(
      {.kind = JointKind::Revolute, .a = hub, .b = arm, .anchor_a = {0, 0}, .motor_speed = speed});
  const BodyId ball = add(world, {0.9, 0.15 + gap}, smooth(make_disc(0.1), e), 2, {0, -6});
  ASSERT_EQ(world.step(kStep / 1000).impacts, 1);
  EXPECT_NEAR(world.joint_speed(hinge), speed, 1e-9);
  const double mass = 11, centre = 0.6 / mass;
  const double inertia =
      world.inertia(hub) + world.inertia(arm) + 10 * centre * centre + (0.6 - centre) * (0.6 - centre);
  const double approach = 6 + speed * 0.9, lever = 0.9 - centre;
  const double impulse = (1 + e) * approach / (1.0 / 2 + 1 / mass + lever * lever / inertia);
  EXPECT_NEAR(world.velocity(ball).y, -6 + impulse / 2, 1e-3);
  EXPECT_NEAR(world.omega(hub), -lever * impulse / inertia, 1e-2);
}

/// A motor without a largest force drives its joint to the limit, and no farther; backwards it leaves that.
TEST_P(JointLimits, AMotorWithoutLimitEndsAtThoseOfItsJoint) {
  for (const JointKind kind : {JointKind::Revolute, JointKind::Prismatic}) {
    World world = make({0, -9.81});
    const double speed = 1.9, upper = 0.3;
    const BodyId hub = add(world, {0, 0}, smooth(make_disc(0.2)), 3, {0.4, 1}, 1);
    const BodyId arm = add(world, {0.6, 0}, smooth(make_box({1, 0.1})), 1, {0.4, 1}, 1);
    const JointId joint = world.create_joint({.kind = kind,
                                              .a = hub,
                                              .b = arm,
                                              .anchor_a = {0.6, 0},
                                              .lower = -0.2,
                                              .upper = upper,
                                              .motor_speed = speed});
    for (int k = 1; k <= 30; ++k) {
      const StepReport& report = world.step(kStep);
      const bool there = k * kStep * speed > upper;
      ASSERT_NEAR(world.joint_position(joint), there ? upper : k * kStep * speed, there ? 1e-9 : 1e-6) << k;
      ASSERT_EQ(report.inexact_islands, 0) << k;
      ASSERT_EQ(report.fallbacks, 0) << k;
      ASSERT_NEAR(world.joint_speed(joint), there ? 0 : speed, 1e-9) << k;
    }
    world.set_motor(joint, -speed);
    for (int k = 1; k <= 30; ++k) {
      ASSERT_EQ(world.step(kStep).inexact_islands, 0) << k;
      ASSERT_NEAR(world.joint_position(joint), std::max(-0.2, upper - k * kStep * speed), 1e-6) << k;
    }
    // One that has a largest force from now on is not held there any more.
    world.set_motor(joint, speed, 60.0);
    for (int k = 0; k < 6; ++k) world.step(kStep);
    EXPECT_GT(world.joint_position(joint), -0.19);
  }
}

/// What turns fast around a body that is told to move slowly keeps, as that sees it, the energy that it has.
TEST_P(JointLimits, WhatSwingsAroundAMovingPivotKeepsItsEnergy) {
  for (const Vec2 told : {Vec2{0.3, 0}, Vec2{1, -0.5}, Vec2{3, 0}}) {
    World world = make();
    const BodyId pivot = world.create_body({.type = BodyType::Kinematic, .velocity = told});
    const double omega = 15, arm = 0.4;
    const BodyId bar =
        add(world, {arm, 0}, smooth(make_box({0.6, 0.1})), 1, told + Vec2{0, omega * arm}, omega);
    world.create_joint({.kind = JointKind::Revolute, .a = pivot, .b = bar});
    for (int k = 0; k < 60; ++k) {
      world.step(kStep);
      ASSERT_NEAR(world.omega(bar), omega, 1e-3 * omega) << told.x << ", " << k;
      ASSERT_NEAR(length(world.velocity(bar) - told), omega * arm, 1e-3 * omega * arm) << told.x << ", " << k;
    }
  }
}

/// A slide that a kinematic body turns takes its rider along, however far away that is.
TEST_P(JointLimits, WhatTurnsTakesItsSlideAlong) {
  World world = make();
  const double omega = 2, arm = 8;
  const BodyId table = world.create_body({.type = BodyType::Kinematic, .omega = omega});
  const BodyId rider = add(world, {arm, 0}, smooth(make_disc(0.2)), 1, {0, omega * arm}, omega);
  world.create_joint({.kind = JointKind::Prismatic, .a = table, .b = rider, .anchor_a = {arm, 0}});
  for (int k = 0; k < 60; ++k) world.step(kStep);
  // r'' = omega^2 r from rest.
  const double far = arm * std::cosh(omega * 1), out = omega * arm * std::sinh(omega * 1);
  EXPECT_NEAR(length(world.position(rider)), far, 1e-3 * far);
  EXPECT_NEAR(length(world.velocity(rider)), std::hypot(out, omega * far), 1e-3 * out);
}

/// A pulley holds two bodies that are welded together, too: it says where the whole may go.
TEST_P(JointLimits, APulleyHoldsTwoBodiesThatAreWelded) {
  for (const bool first : {false, true}) {
    World world = make({0, -9.81});
    const BodyId a = add(world, {-0.4, 0}, smooth(make_box({0.3, 0.3})), 1);
    const BodyId b = add(world, {0.5, 0.1}, smooth(make_box({0.3, 0.3})), 2);
    const auto weld = [&] {
      world.create_joint({.kind = JointKind::Weld, .a = a, .b = b, .anchor_a = {0, 0}});
    };
    if (first) weld();
    const JointId pulley = world.create_joint({.kind = JointKind::Pulley,
                                               .a = a,
                                               .b = b,
                                               .anchor_a = {-0.4, 0},
                                               .anchor_b = {0.5, 0.1},
                                               .pulley_a = {-0.6, 2},
                                               .pulley_b = {0.8, 2}});
    if (!first) weld();
    for (int k = 0; k < 30; ++k) {
      world.step(kStep);
      ASSERT_NEAR(world.joint_position(pulley), 0, 1e-9) << first << ", " << k;
    }
  }
}

/// A motor that ends at a limit stays there however accurate the impacts of the last step were, and does not
/// set out for what is left of its way.
TEST_P(JointLimits, AMotorThatHasEndedDoesNotSetOutAgain) {
  World world = make();
  const BodyId arm = add(world, {0.5, 0}, smooth(make_box({1, 0.1})));
  const BodyId blade = add(world, {1, 0.5}, smooth(make_box({0.1, 1})));
  const JointId hinge = world.create_joint(
      {.kind = JointKind::Revolute, .b = arm, .anchor_a = {0, 0}, .lower = 0, .motor_speed = -3});
  world.create_joint({.kind = JointKind::Revolute, .a = arm, .b = blade, .anchor_a = {1, 0}});
  world.step(kStep);
  for (const BodyId body : {arm, blade}) {
    const double off = 1e-7;
    world.set_pose(body, rotate(Rot::from_angle(off), world.position(body)), world.angle(body) + off);
  }
  EXPECT_EQ(world.step(kStep).impacts, 0);
  EXPECT_GT(world.joint_position(hinge), -1e-12);
  EXPECT_LT(world.joint_position(hinge), 1e-7 + 1e-12);
  EXPECT_LT(world.kinetic_energy(), 1e-12);
}

/// A motor without a largest force has its speed at once, however far out it takes its bodies.
TEST_P(JointLimits, AMotorDrivesALargeArmAtOnceAsWell) {
  for (const double size : {0.05, 1.0, 20.0, 400.0}) {
    World world = make();
    const double omega = 2;
    const BodyId arm = add(world, {size, 0}, smooth(make_box({2 * size, 0.1 * size})));
    world.create_joint({.kind = JointKind::Revolute, .b = arm, .anchor_a = {0, 0}, .motor_speed = omega});
    world.step(kStep);
    EXPECT_NEAR(world.omega(arm), omega, 1e-9) << size;
    EXPECT_NEAR(world.angle(arm), omega * kStep, 1e-5) << size;
    EXPECT_NEAR(world.position(arm).y, size * std::sin(omega * kStep), 1e-5 * size) << size;
  }
}

/// Two bars that turn fast against each other, of any size: an angle is near its limit where its ends are. In
/// small ones a limit was not looked at beside a hinge that was pulled together, and both got in each other's
/// way.
TEST_P(JointLimits, StopSmallBarsAsWellAsLargeOnes) {
  const auto way = [](double size, double upper) {
    WorldConfig config;
    config.gravity = {0, 0};
    config.stepper = GetParam();
    config.contact_margin *= size;
    config.touch_tolerance *= size;
    config.rest_speed *= size;
    World world(config);
    const BodyId left = add(world, {-0.3 * size, 0}, smooth(make_box({0.6 * size, 0.1 * size})), 2, {}, -22);
    const BodyId right = add(world, {0.3 * size, 0}, smooth(make_box({0.6 * size, 0.1 * size})), 1, {}, 20);
    world.create_joint({.kind = JointKind::Revolute, .a = left, .b = right, .lower = -4, .upper = upper});
    std::vector<Vec2> places;
    for (int k = 0; k < 4; ++k) {
      world.step(kStep);
      for (const BodyId body : {left, right}) places.push_back((1 / size) * world.position(body));
    }
    return places;
  };
  for (int k = 0; k < 40; ++k) {
    const double upper = 0.6 + 0.005 * k;
    const std::vector<Vec2> metres = way(1, upper);
    for (const double size : {1.0 / 256, 1.0 / 16, 16.0}) {
      const std::vector<Vec2> other = way(size, upper);
      for (std::size_t i = 0; i < metres.size(); ++i)
        ASSERT_LT(length(other[i] - metres[i]), 1e-6) << size << ", " << upper << ", step " << i / 2;
    }
  }
}

}  // namespace joint_limits_test
}  // namespace skerry
