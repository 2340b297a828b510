// SPDX-License-Identifier: MIT
//
// Joints against their formulas, by both steppers.
#include <cmath>
#include <gtest/gtest.h>

#include "tests/support/worlds.h"

namespace skerry {
namespace joint_kinds_test {

using test::add;
using test::smooth;
using test::weightless;

constexpr double kG = 9.81;

WorldConfig by(const std::string& stepper, WorldConfig config = {}) {
  config.stepper = stepper;
  return config;
}

void run(World& world, double seconds, double h = 1.0 / 60) {
  const int steps = static_cast<int>(std::lround(seconds / h));
  for (int i = 0; i < steps; ++i) world.step(h);
}

class Joint : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(By, Joint, testing::Values("time_stepping", "event_driven"),
                         [](const auto& stepper) { return stepper.param; });

TEST_P(Joint, AtwoodsMachineFallsByTheDifferenceOverTheSum) {
  World world(by(GetParam()));
  const double m1 = 3, m2 = 2;
  const auto heavy = add(world, {-1, 0}, smooth(make_disc(0.2)), m1);
  const auto light = add(world, {1, 0}, smooth(make_disc(0.2)), m2);
  const auto pulley = world.create_joint({.kind = JointKind::Pulley,
                                          .a = heavy,
                                          .b = light,
                                          .anchor_a = {-1, 0},
                                          .anchor_b = {1, 0},
                                          .pulley_a = {-1, 3},
                                          .pulley_b = {1, 3}});
  run(world, 1);
  const double a = kG * (m1 - m2) / (m1 + m2);
  EXPECT_NEAR(world.position(heavy).y, -0.5 * a, 1e-11);
  EXPECT_NEAR(world.position(light).y, 0.5 * a, 1e-11);
  EXPECT_NEAR(world.joint_force(pulley).y, 2 * m1 * m2 * kG / (m1 + m2), 1e-9);
}

TEST_P(Joint, PulleyMovesItsEndsInItsRatio) {
  World world(by(GetParam()));
  const double r = 3;
  const auto a = add(world, {-1, 0}, smooth(make_disc(0.2)), 1);
  const auto b = add(world, {1, 0}, smooth(make_disc(0.2)), 2);
  world.create_joint({.kind = JointKind::Pulley,
                      .a = a,
                      .b = b,
                      .anchor_a = {-1, 0},
                      .anchor_b = {1, 0},
                      .ratio = r,
                      .pulley_a = {-1, 3},
                      .pulley_b = {1, 3}});
  run(world, 0.5);
  // T = lambda on a and r lambda on b; y_a'' + r y_b'' = 0.
  const double tension = (1 + r) * kG / (1 + r * r / 2);
  EXPECT_NEAR(world.position(a).y, 0.125 * (tension - kG), 1e-11);
  EXPECT_NEAR(world.position(a).y + r * world.position(b).y, 0, 1e-11);
}

TEST_P(Joint, SlidersGoDownAnInclineWithoutTurning) {
  World world(by(GetParam()));
  const double angle = 0.4;
  const Vec2 along{std::cos(angle), std::sin(angle)};
  const auto box = add(world, {0, 0}, smooth(make_box({1, 0.5})), 2);
  const auto slider = world.create_joint({.kind = JointKind::Prismatic, .b = box, .axis = along});
  run(world, 1);
  EXPECT_NEAR(world.joint_position(slider), -0.5 * kG * std::sin(angle), 1e-11);
  EXPECT_NEAR(world.joint_speed(slider), -kG * std::sin(angle), 1e-11);
  EXPECT_NEAR(world.angle(box), 0, 1e-13);
  EXPECT_NEAR(length(world.joint_force(slider)), 2 * kG * std::cos(angle), 1e-9);
}

TEST_P(Joint, MotorOfASliderLiftsAtItsSpeedWithTheForceOfTheIncline) {
  World world(by(GetParam()));
  const double angle = 0.4;
  const Vec2 along{std::cos(angle), std::sin(angle)};
  const auto box = add(world, {0, 0}, smooth(make_box({1, 0.5})), 2);
  const auto slider = world.create_joint(
      {.kind = JointKind::Prismatic, .b = box, .axis = along, .motor_speed = 1.5, .motor_limit = 100});
  run(world, 2);
  EXPECT_NEAR(world.joint_speed(slider), 1.5, 1e-11);
  EXPECT_NEAR(dot(world.joint_force(slider), along), 2 * kG * std::sin(angle), 1e-9);
  // It took (100 - m g sin a) / m to get there.
  const double a = (100 - 2 * kG * std::sin(angle)) / 2;
  const double lost = 1.5 * 1.5 / (2 * a);
  const double tolerance = GetParam() == "event_driven" ? 1e-10 : 0.01;
  EXPECT_NEAR(world.joint_position(slider), 3 - lost, tolerance);
}

TEST_P(Joint, MotorTurnsAFlywheelWithItsLargestTorqueUntilItsSpeed) {
  World world(by(GetParam(), weightless()));
  const auto wheel = add(world, {0, 0}, smooth(make_disc(1)), 2);  // inertia 1
  const auto motor =
      world.create_joint({.kind = JointKind::Revolute, .b = wheel, .motor_speed = 10, .motor_limit = 4});
  run(world, 1);
  EXPECT_NEAR(world.omega(wheel), 4, 1e-11);
  EXPECT_NEAR(world.angle(wheel), 2, 1e-11);
  EXPECT_NEAR(world.joint_torque(motor), 4, 1e-9);
  run(world, 2);
  EXPECT_NEAR(world.omega(wheel), 10, 1e-11);
  EXPECT_NEAR(world.joint_torque(motor), 0, 1e-9);
  const double tolerance = GetParam() == "event_driven" ? 1e-10 : 0.1;
  EXPECT_NEAR(world.angle(wheel), 10 * 10 / 8.0 + 0.5 * 10, tolerance);
  world.set_motor({motor}, -10);
  run(world, 10);
  EXPECT_NEAR(world.omega(wheel), -10, 1e-11);
}

TEST_P(Joint, MotorThatIsTooWeakForItsArmStalls) {
  // m g l = 2 * 9.81 * 0.5 at the horizontal; the motor gives 0.9 of it and begins below.
  for (const double share : {0.9, 1.1}) {
    World world(by(GetParam()));
    const auto arm = add(world, {0, -0.5}, smooth(make_box({0.1, 1})), 2);
    const auto hinge = world.create_joint({.kind = JointKind::Revolute,
                                           .b = arm,
                                           .anchor_a = {0, 0},
                                           .motor_speed = 0.5,
                                           .motor_limit = share * 2 * kG * 0.5});
    double highest = 0;
    for (int i = 0; i < 600; ++i) {
      world.step(1.0 / 60);
      highest = std::max(highest, world.joint_position(hinge));
      ASSERT_LE(std::abs(world.joint_torque(hinge)), share * kG * (1 + 1e-9));
    }
    // Quasi-static: where m g l sin(angle) is the motor's torque; a little beyond with the speed it has.
    if (share < 1) {
      const double stall = std::asin(0.9);
      const double inertia = world.inertia(arm) + 2 * 0.25;
      EXPECT_GT(highest, stall);
      // I w^2 / 2 is what lifts it further.
      const auto work = [&](double x) { return kG * (std::cos(stall) - std::cos(x) - 0.9 * (x - stall)); };
      EXPECT_NEAR(work(highest), 0.5 * inertia * 0.25, 2e-3);
    } else {
      EXPECT_NEAR(highest, 0.5 * 10, 0.02);
    }
  }
}

TEST_P(Joint, LimitStopsAPendulumPlasticallyAndCarriesItThen) {
  World world(by(GetParam()));
  const auto rod = add(world, {0.5, 0}, smooth(make_box({1, 0.05})), 1);
  const auto hinge = world.create_joint(
      {.kind = JointKind::Revolute, .b = rod, .anchor_a = {0, 0}, .lower = -0.3, .upper = 0.2});
  for (int i = 0; i < 120; ++i) {
    world.step(1.0 / 60);
    ASSERT_GE(world.joint_position(hinge), -0.3 - 1e-11);
  }
  EXPECT_NEAR(world.joint_position(hinge), -0.3, 1e-11);
  EXPECT_NEAR(world.omega(rod), 0, 1e-11);
  EXPECT_NEAR(world.joint_torque(hinge), kG * 0.5 * std::cos(0.3), 1e-9);
}

TEST(Limit, IsReachedWhenTheFormulaSays) {
  World world(by("event_driven"));
  const auto box = add(world, {0, 0}, smooth(make_box({1, 1})), 1);
  world.create_joint({.kind = JointKind::Prismatic, .b = box, .axis = {0, 1}, .lower = -0.25});
  double reached = -1;
  for (int i = 0; i < 30; ++i) {
    for (const MotionEvent& event : world.step(1.0 / 60).motion_events)
      if (event.kind == MotionEventKind::Limit) reached = event.time;
  }
  EXPECT_NEAR(reached, std::sqrt(0.5 / kG), 1e-12);
  EXPECT_EQ(world.report().fallbacks, 0);
}

TEST_P(Joint, CantileverIsHeldByForceAndMoment) {
  World world(by(GetParam()));
  const double l = 0.7;
  const auto beam = add(world, {l, 0}, smooth(make_box({1.4, 0.1})), 3);
  const auto weld = world.create_joint({.kind = JointKind::Weld, .b = beam, .anchor_a = {0, 0}});
  run(world, 0.5);
  EXPECT_NEAR(world.joint_force(weld).y, 3 * kG, 1e-9);
  EXPECT_NEAR(world.joint_torque(weld), 3 * kG * l, 1e-9);
  EXPECT_NEAR(world.angle(beam), 0, 1e-13);
  EXPECT_NEAR(world.position(beam).y, 0, 1e-13);
}

TEST_P(Joint, GearKeepsItsRatioAndSharesTheTorque) {
  World world(by(GetParam(), weightless()));
  const double r = 2.5;  // radius of a over radius of b
  const auto a = add(world, {0, 0}, smooth(make_disc(1)), 4);
  const auto b = add(world, {2, 0}, smooth(make_disc(0.4)), 1);
  world.create_joint({.kind = JointKind::Revolute, .b = a, .anchor_a = {0, 0}});
  world.create_joint({.kind = JointKind::Revolute, .b = b, .anchor_a = {2, 0}});
  const auto gear = world.create_joint({.kind = JointKind::Gear, .a = a, .b = b, .ratio = r});
  const double torque = 3, inertia = world.inertia(a) + r * r * world.inertia(b);
  for (int i = 0; i < 60; ++i) {
    world.apply_torque(a, torque);
    world.step(1.0 / 60);
    ASSERT_NEAR(world.angle(b), -r * world.angle(a), 1e-12);
  }
  EXPECT_NEAR(world.omega(a), torque / inertia, 1e-12);
  EXPECT_NEAR(world.omega(b), -r * world.omega(a), 1e-12);
  EXPECT_NEAR(world.joint_torque(gear), -r * world.inertia(b) * torque / inertia, 1e-9);
}

TEST_P(Joint, RackMovesByThePitchRadiusForEachRadian) {
  World world(by(GetParam()));
  const auto pinion = add(world, {0, 1}, smooth(make_disc(0.5)), 2);
  const auto bar = add(world, {0, 0}, smooth(make_box({2, 0.2})), 3);
  world.create_joint({.kind = JointKind::Revolute, .b = pinion, .anchor_a = {0, 1}});
  world.create_joint({.kind = JointKind::Prismatic, .b = bar, .axis = {0, 1}});
  world.create_joint({.kind = JointKind::Rack, .a = pinion, .b = bar, .axis = {0, 1}, .ratio = 0.5});
  run(world, 1);
  // m y'' = -m g + f, I w' = -r f
  const double a = -3 * kG / (3 + world.inertia(pinion) / 0.25);
  EXPECT_NEAR(world.position(bar).y, 0.5 * a, 1e-11);
  EXPECT_NEAR(world.angle(pinion), world.position(bar).y / 0.5, 1e-11);
}

/// x(t) of m x'' + c x' + k x = 0 from rest at 1.
double damped(double m, double c, double k, double t) {
  const double d = c / (2 * m), w = std::sqrt(k / m - d * d);
  return std::exp(-d * t) * (std::cos(w * t) + d / w * std::sin(w * t));
}

/// Position of a mass on a damped spring after 2 s.
double spring_after(const std::string& stepper, double c, double h, double length) {
  World world(by(stepper, weightless()));
  const auto ball = add(world, {length + 1, 0}, smooth(make_disc(0.1)), 2);
  world.create_joint({.kind = JointKind::Spring,
                      .b = ball,
                      .anchor_b = {length + 1, 0},
                      .length = length,
                      .stiffness = 50,
                      .damping = c});
  run(world, 2, h);
  return world.position(ball).x - length;
}

TEST(Spring, OscillatesAndDecaysAsTheFormulaSays) {
  for (const double length : {0.0, 3.0}) {
    for (const double c : {0.0, 1.5}) {
      const double exact = damped(2, c, 50, 2);
      EXPECT_NEAR(spring_after("event_driven", c, 1.0 / 60, length), exact, 1e-11) << length << " " << c;
      const double coarse = spring_after("time_stepping", c, 1.0 / 60, length) - exact;
      const double fine = spring_after("time_stepping", c, 1.0 / 120, length) - exact;
      EXPECT_NEAR(coarse / fine, 4, 0.1) << length << " " << c << ": " << coarse;
      EXPECT_LT(std::abs(fine), 2e-3);
    }
  }
}

TEST(Spring, WithoutDamperKeepsItsEnergyInTimeSteppingHoweverStiff) {
  for (const double k : {1e-3, 10.0, 1e4, 1e8}) {
    World world(weightless());
    const auto ball = add(world, {1, 0}, smooth(make_disc(0.1)), 1);
    world.create_joint(
        {.kind = JointKind::Spring, .b = ball, .anchor_b = {1, 0}, .length = 0.0, .stiffness = k});
    for (int i = 0; i < 1000; ++i) world.step(1.0 / 60);
    const double energy = world.kinetic_energy() + world.potential_energy();
    EXPECT_NEAR(world.potential_energy(), 0.5 * k * length_squared(world.position(ball)), 1e-12 * k);
    EXPECT_NEAR(energy / (0.5 * k), 1, 1e-9) << k;
  }
}

// The free way of half a step goes past the other anchor, where the spring would pull the other way: a swing
// of 0.5 m grew to 2.7 m.
TEST(Spring, SwingsNoFartherWhereItsFreeWayGoesPastItsAnchor) {
  for (const JointKind kind : {JointKind::Spring, JointKind::Distance}) {
    for (const double swing : {0.3, 0.5, 0.8}) {
      for (const double k : {1e4, 1e5, 1e6}) {
        World world(weightless());
        const auto ball = add(world, {1 + swing, 0}, smooth(make_disc(0.1)), 2);
        world.create_joint(
            {.kind = kind, .b = ball, .anchor_b = {1 + swing, 0}, .length = 1.0, .stiffness = k});
        const double begin = world.potential_energy();
        for (int i = 0; i < 100; ++i) {
          world.step(1.0 / 20);
          ASSERT_NEAR((world.kinetic_energy() + world.potential_energy()) / begin, 1, 1e-9)
              << swing << " " << k;
        }
      }
    }
  }
}

TEST(Spring, PeriodInTimeSteppingIsThatOfTheMidpointRule) {
  // tan(w' h / 2) = w h / 2
  const double h = 1.0 / 60, w = 5;
  World world(weightless());
  const auto ball = add(world, {3, 0}, smooth(make_disc(0.1)), 1);
  world.create_joint(
      {.kind = JointKind::Spring, .b = ball, .anchor_b = {3, 0}, .length = 2.0, .stiffness = w * w});
  const double rate = 2 / h * std::atan(0.5 * w * h);
  for (int i = 1; i <= 300; ++i) {
    world.step(h);
    ASSERT_NEAR(world.position(ball).x, 2 + std::cos(rate * world.time()), 1e-9);
  }
}

TEST_P(Joint, SuspensionSagsByTheWeightOverTheStiffness) {
  World world(by(GetParam()));
  // The wheel hangs on a fixed frame; its damper brings it to rest.
  const auto wheel = add(world, {0, 0}, smooth(make_disc(0.3)), 5);
  const auto strut = world.create_joint(
      {.kind = JointKind::Wheel, .b = wheel, .axis = {0, 1}, .stiffness = 400, .damping = 60});
  run(world, 10);
  EXPECT_NEAR(world.position(wheel).y, -5 * kG / 400, 1e-9);
  EXPECT_NEAR(world.position(wheel).x, 0, 1e-12);
  EXPECT_NEAR(world.joint_force(strut).y, 5 * kG, 1e-6);
  world.set_velocity(wheel, {0, 0}, 3);
  run(world, 1);
  EXPECT_NEAR(world.omega(wheel), 3, 1e-11);  // it turns freely
}

TEST_P(Joint, TorsionSpringSwingsADisc) {
  World world(by(GetParam(), weightless()));
  const auto disc = add(world, {0, 0}, smooth(make_disc(1)), 2, {}, 1);  // inertia 1
  world.create_joint({.kind = JointKind::Revolute, .b = disc, .stiffness = 16});
  run(world, 1, 1.0 / 240);
  EXPECT_NEAR(world.angle(disc), std::sin(4.0) / 4, GetParam() == "event_driven" ? 1e-11 : 1e-4);
}

TEST_P(Joint, BreaksAtTheLoadItWasGivenAndSaysSo) {
  World world(by(GetParam()));
  const auto ball = add(world, {0, 0}, smooth(make_disc(0.1)), 2);
  const auto hook = world.create_joint({.kind = JointKind::Weld, .b = ball, .break_force = 30});
  run(world, 0.5);
  ASSERT_TRUE(world.alive(hook));
  const double more = 30 - 2 * kG;
  world.apply_force(ball, {0, -more * (1 - 1e-9)}, world.position(ball));
  world.step(1.0 / 60);
  ASSERT_TRUE(world.alive(hook));
  world.apply_force(ball, {0, -more * (1 + 1e-9)}, world.position(ball));
  const StepReport& report = world.step(1.0 / 60);
  EXPECT_FALSE(world.alive(hook));
  ASSERT_EQ(report.joint_events.size(), 1u);
  EXPECT_NEAR(report.joint_events[0].force, 30, 1e-6);
  EXPECT_TRUE(report.joint_events[0].joint == hook);
  EXPECT_NEAR(world.position(ball).y, 0, 1e-12);  // it held to the end of that step
  run(world, 0.5);
  EXPECT_NEAR(world.position(ball).y, -0.125 * kG, 1e-9);
}

TEST_P(Joint, BreaksByItsMomentToo) {
  World world(by(GetParam()));
  const auto beam = add(world, {1, 0}, smooth(make_box({2, 0.1})), 1);
  const auto weld =
      world.create_joint({.kind = JointKind::Weld, .b = beam, .anchor_a = {0, 0}, .break_torque = 0.99 * kG});
  world.step(1.0 / 60);
  EXPECT_FALSE(world.alive(weld));
  EXPECT_NEAR(world.report().joint_events.at(0).torque, kG, 1e-9);
}

TEST(Joint, ReportsItsLoadWhicheverOfTheTwoItHolds) {
  for (const bool bob_first : {false, true}) {
    World world({.sleep = false});
    const BodyId wall = world.create_body({.type = BodyType::Static});
    const BodyId bob = add(world, {0, -1}, smooth(make_disc(0.1)), 2);
    const JointId joint = world.create_joint({.kind = JointKind::Distance,
                                              .a = bob_first ? bob : wall,
                                              .b = bob_first ? wall : bob,
                                              .anchor_a = bob_first ? Vec2{0, -1} : Vec2{0, 0},
                                              .anchor_b = bob_first ? Vec2{0, 0} : Vec2{0, -1}});
    for (int i = 0; i < 5; ++i) {
      world.apply_force(bob, {0, -1.0 * i}, world.position(bob));
      world.step(0.01);
      EXPECT_NEAR(length(world.joints()[joint.index].impulse), (2 * 9.81 + i) * 0.01, 1e-9) << bob_first;
    }
    // It breaks by the weight of another one.
    const BodyId load = add(world, {0, -1.2}, smooth(make_disc(0.1)), 3);
    JointDef weak{.kind = JointKind::Distance,
                  .a = bob_first ? load : bob,
                  .b = bob_first ? bob : load,
                  .anchor_a = {0, bob_first ? -1.2 : -1.0},
                  .anchor_b = {0, bob_first ? -1.0 : -1.2}};
    weak.break_force = 20;
    world.create_joint(weak);
    EXPECT_EQ(world.step(0.01).joint_events.size(), 1u);
  }
}

TEST(Joint, OfNoStrengthBreaksByTheFirstLoad) {
  World world(weightless());
  const BodyId body = add(world, {1, 0}, smooth(make_disc(0.1)));
  JointDef glass{.kind = JointKind::Revolute, .b = body, .anchor_a = {0, 0}, .anchor_b = {0, 0}};
  glass.break_force = glass.break_torque = 0;
  world.create_joint(glass);
  for (int i = 0; i < 5; ++i) EXPECT_TRUE(world.step(0.01).joint_events.empty()) << i;
  world.apply_force(body, {-1, 0}, world.position(body));
  EXPECT_EQ(world.step(0.01).joint_events.size(), 1u);
}

}  // namespace joint_kinds_test
}  // namespace skerry
