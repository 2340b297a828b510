// SPDX-License-Identifier: MIT
//
// Energy of pendulums and chains, and what a long chain costs.
#include <cmath>
#include <gtest/gtest.h>

#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace joint_energy_test {

using test::add;
using test::rough;
using test::smooth;

WorldConfig by(const std::string& stepper) {
  WorldConfig config;
  config.stepper = stepper;
  return config;
}

/// `count` rods of together 4 m and 4 kg, straight out from a fixed point; they pass through each other.
void add_chain(World& world, int count) {
  const double l = 4.0 / count;
  BodyId last{};
  for (int i = 0; i < count; ++i) {
    ShapeDef rod = smooth(make_box({l, 0.2 * l}));
    rod.filter.group = -1;
    const auto link = add(world, {l * (i + 0.5), 0}, rod, 4.0 / count);
    world.create_joint({.a = last, .b = link, .anchor_a = {l * i, 0}});
    last = link;
  }
}

/// Largest change of the energy in `steps` steps [J]; the swing is about 40 J.
double drift(World& world, int steps, double rate = 60) {
  const double begin = world.kinetic_energy() + world.potential_energy();
  double worst = 0;
  for (int i = 0; i < steps; ++i) {
    const StepReport& report = world.step(1 / rate);
    worst = std::max(worst, std::abs(report.kinetic_energy + report.potential_energy - begin));
    EXPECT_EQ(report.fallbacks, 0);
  }
  return worst;
}

TEST(ChainEnergy, OfADoublePendulumIsKeptByEvents) {
  // 100 s with SKERRY_TEST_SCALE=20.
  World world(by("event_driven"));
  add_chain(world, 2);
  EXPECT_LT(drift(world, test_scale(300)), 1e-8);
  EXPECT_GT(world.kinetic_energy(), 1e-3);
}

TEST(ChainEnergy, IsNotSpentOnWhatJointsDriftBetweenTheSteps) {
  // What a projection leaves of the velocities at the joints, 1e-12 m/s, would cost 1e-11 J.
  World world(by("event_driven"));
  add_chain(world, 12);
  EXPECT_LT(drift(world, 480, 240), 1e-12);
}

TEST(ChainEnergy, OfAHundredLinksIsKeptByEvents) {
  // 100 s with SKERRY_TEST_SCALE=1000. 240 steps a second: where the chain cracks like a whip its tip turns
  // at 1600 rad/s, and a step wants 2000 force solves.
  World world(by("event_driven"));
  add_chain(world, 100);
  EXPECT_LT(drift(world, test_scale(24), 240), 1e-8);
}

TEST(ChainEnergy, IsKeptByTimeSteppingToo) {
  // The midpoint rule keeps it, and what the projections change is given back to the motion.
  for (const auto& [count, seconds, bound] : {std::tuple(2, 20, 1e-6), {10, 5, 1e-4}, {100, 1, 1e-3}}) {
    World world(by("time_stepping"));
    add_chain(world, count);
    const double worst = drift(world, 60 * seconds);
    std::printf("%3d links, time_stepping at 60 Hz: %.1e J of about 40 J in %d s\n", count, worst, seconds);
    EXPECT_LT(worst, bound) << count;
  }
}

TEST(ChainEnergy, PathOfTimeSteppingIsOfSecondOrder) {
  double error[2] = {};
  World exact(by("event_driven"));
  add_chain(exact, 2);
  for (int i = 0; i < 60; ++i) exact.step(1.0 / 60);
  for (const int n : {0, 1}) {
    World world(by("time_stepping"));
    add_chain(world, 2);
    const int steps = 240 << n;
    for (int i = 0; i < steps; ++i) world.step(1.0 / steps);
    error[n] = length(world.bodies().position[1] - exact.bodies().position[1]);
  }
  EXPECT_GT(error[0] / error[1], 3.5) << error[0] << " " << error[1];
  EXPECT_LT(error[1], 1e-3);
}

TEST(ChainEnergy, SparseAndDenseForcesAreTheSame) {
  // Twelve links solve densely; with a second, far chain of the same island they are 60 rows and go the
  // sparse way.
  World alone(by("event_driven")), joined(by("event_driven"));
  add_chain(alone, 12);
  add_chain(joined, 12);
  BodyId last{};
  for (int i = 0; i < 20; ++i) {
    const auto link = add(joined, {100 + i + 0.5, 0}, smooth(make_box({1, 0.1})), 1);
    joined.create_joint({.a = last, .b = link, .anchor_a = {100.0 + i, 0}});
    last = link;
  }
  // A rope that stays slack makes them one island.
  joined.create_joint({.kind = JointKind::Rope, .a = {0, 0}, .b = last, .anchor_b = {120, 0}, .length = 1e3});
  for (int i = 0; i < 12; ++i) {
    alone.step(1.0 / 60);
    joined.step(1.0 / 60);
    ASSERT_EQ(joined.report().islands, 1);
    ASSERT_EQ(joined.report().fallbacks, 0);
    for (std::size_t k = 0; k < 12; ++k)
      ASSERT_NEAR(length(alone.bodies().position[k] - joined.bodies().position[k]), 0, 1e-11) << i;
  }
}

// Boxes fall on a rope bridge. Without flow, steps that are cut too often end with landings that are plastic.
TEST(BridgeEnergy, DoesNotGrowWhereAStepEndsPlastically) {
  for (const int impacts : {1, 4}) {
    WorldConfig config;
    config.flow_work = 0;
    config.max_impacts_per_step = impacts;
    World world(config);
    const int planks = 12;
    const auto post = [&](int i) { return Vec2{1.0 * i, 5 + 0.02 * i * (i - planks)}; };
    BodyId last;
    for (int i = 0; i < planks; ++i) {
      const Vec2 from = post(i), along = post(i + 1) - from;
      const BodyId plank = add(world, from + 0.5 * along, rough(make_box({0.9, 0.2}), 0.8), 5, {}, 0,
                               std::atan2(along.y, along.x));
      world.create_joint({.a = last, .b = plank, .anchor_a = from});
      last = plank;
    }
    world.create_joint({.b = last, .anchor_a = post(planks)});
    for (int i = 1; i < planks; ++i)
      add(world, {i + 0.1 * (i % 3), 5.6 + 0.7 * (i % 2)}, rough(make_box({0.6, 0.6}), 0.8), 1,
          {0.3 * (i % 4) - 0.5, -3}, 1);
    double energy = world.kinetic_energy() + world.potential_energy();
    for (int k = 0; k < 60; ++k) {
      world.step(1.0 / 60);
      const double now = world.kinetic_energy() + world.potential_energy();
      EXPECT_LE(now, energy + 1e-9 * std::abs(energy)) << impacts << " impacts, step " << k;
      energy = now;
    }
  }
}

// A disc whose turning nothing changes drives its centre over rough ground, as a belt would: also beside a
// motor, whose torque it does not feel. The disc was slowed down for the energy that it brought.
TEST(SpringsOfMovingBodies, SwingAsThoseAtRest) {
  // A mass on a spring to a body that goes steadily: by 2 cm to and fro against it, for 5 s.
  for (const char* stepper : {"time_stepping", "event_driven"}) {
    for (const double omega : {15.0, 30.0, 60.0}) {
      for (const double speed : {0.0, 0.02, 0.1, 0.5}) {
        WorldConfig config = by(stepper);
        config.gravity = {};
        World world(config);
        const BodyId carrier =
            world.create_body({.type = BodyType::Kinematic, .position = {0, 0}, .velocity = {speed, 0}});
        const BodyId mass = world.create_body(
            {.position = {1, 0}, .velocity = {speed + 0.02 * omega, 0}, .mass = 1.0, .inertia = 1.0});
        world.create_joint({.kind = JointKind::Spring,
                            .a = carrier,
                            .b = mass,
                            .anchor_a = {0, 0},
                            .anchor_b = {1, 0},
                            .stiffness = omega * omega});
        double amplitude = 0;
        for (int k = 0; k < 300; ++k) {
          EXPECT_EQ(world.step(1.0 / 60).fallbacks, 0);
          if (k < 200) continue;
          const double way = world.position(mass).x - world.position(carrier).x - 1;
          amplitude = std::max(amplitude, std::hypot(way, (world.velocity(mass).x - speed) / omega));
        }
        EXPECT_NEAR(amplitude, 0.02, 2e-4) << stepper << ", " << omega << "/s, " << speed << " m/s";
      }
    }
  }
}

TEST(InfiniteInertia, TurnsOnWhateverAMotorWants) {
  for (const char* stepper : {"time_stepping", "event_driven"}) {
    for (const double wanted : {0.0, 1.0, 2.0}) {
      SCOPED_TRACE(stepper + (" " + std::to_string(wanted)));
      World world(by(stepper));
      test::add_ground(world, rough(make_disc(0.5), 0.5));
      const BodyId disc = world.create_body(
          {.position = {0, 0.5}, .velocity = {1, 0}, .omega = 1, .mass = 1.0, .inertia = 0.0});
      world.add_shape(disc, rough(make_disc(0.5), 0.5));
      const JointId motor = world.create_joint(
          {.kind = JointKind::Motor, .b = disc, .motor_speed = wanted, .motor_limit = 5.0});
      for (int i = 0; i < 60; ++i) {
        ASSERT_EQ(world.step(1.0 / 60).inexact_islands, 0);
        ASSERT_EQ(world.omega(disc), 1);
      }
      EXPECT_NEAR(world.velocity(disc).x, -0.5, 1e-9);
      EXPECT_NEAR(world.joint_torque(motor), wanted > 1 ? 5 : wanted < 1 ? -5 : 0, 1e-9);
    }
  }
}

// A bar of which its joint holds the end or the middle, and what carries it, turned with `omega` about the
// origin.
struct Rotor {
  enum class Kind { Hinged, Welded, Slides };
  Rotor(Kind kind, double speed, const JointDef& axle) {
    world.set_gravity({});
    bar = add(world, {1, 0}, smooth(make_box({0.4, 0.2})), 80);
    JointDef about = axle;
    about.b = bar;
    if (kind != Kind::Hinged) {
      hub = about.b = world.create_body({.mass = 100.0, .inertia = 50.0});
      JointDef arm{.kind = kind == Kind::Welded ? JointKind::Weld : JointKind::Prismatic,
                   .a = hub,
                   .b = bar,
                   .anchor_a = {1, 0}};
      if (kind == Kind::Slides) arm.upper = 0;
      world.create_joint(arm);
    }
    hinge = world.create_joint(about);
    spin(speed);
  }

  void spin(double speed) {
    world.set_velocity(bar, speed * perp(world.position(bar)), speed);
    if (hub) world.set_velocity(hub, {}, speed);
  }

  World world{by("time_stepping")};
  BodyId bar, hub;
  JointId hinge;
};

// The force that holds it is not known before the first step, and another one after a blow. At 130 rad/s it
// went on with 75, at 150 backwards, and at 400 six metres off its hinge; a slide was 41 m past its limit.
TEST(SpinningJoints, KeepTheirEnergyFromTheirFirstStepOn) {
  for (const Rotor::Kind kind : {Rotor::Kind::Hinged, Rotor::Kind::Welded, Rotor::Kind::Slides}) {
    for (const double speed : {40.0, 60.0, 90.0, 130.0, 150.0, 200.0, 300.0, 754.0, 1000.0}) {
      for (const bool warm : {false, true}) {
        Rotor rotor(kind, warm ? 30 : speed, {});
        for (int i = 0; warm && i < 10; ++i) rotor.world.step(1.0 / 60);
        if (warm) rotor.spin(speed);
        for (int i = 0; i < 4; ++i) rotor.world.step(1.0 / 60);
        SCOPED_TRACE(std::to_string(static_cast<int>(kind)) + (warm ? " warm" : ""));
        EXPECT_NEAR(rotor.world.omega(rotor.bar), speed, 1e-6 * speed);
        EXPECT_NEAR(length(rotor.world.position(rotor.bar)), 1, 1e-6);
      }
    }
  }
}

// What turns about its own centre is followed as it is, in one piece.
TEST(SpinningJoints, OfAWheelCutNoStep) {
  World world(by("time_stepping"));
  const BodyId cart = add(world, {0, 1}, smooth(make_box({2, 0.2})));
  const BodyId wheel = add(world, {0.5, 0.5}, smooth(make_disc(0.4)), 1, {}, 500);
  world.create_joint({.b = cart, .anchor_a = {-1, 1}});
  world.create_joint({.a = cart, .b = wheel, .anchor_a = {0.5, 0.5}});
  for (int i = 0; i < 10; ++i) EXPECT_EQ(world.step(1.0 / 60).substeps, 1);
}

// What joints take while they turn is given back to the motion, also where something weak drives or holds it:
// each of these braked by 7 % a second, more than a motor could do about.
TEST(SpinningJoints, AreNotBrakedByWhatBringsNothing) {
  JointDef motor, damper, spring, rope;
  motor.motor_speed = 1e5;
  motor.motor_limit = 1e-3;
  damper.damping = 1e-9;
  spring.stiffness = 1e-6;
  for (const JointDef& axle : {JointDef{}, motor, damper, spring}) {
    Rotor rotor(Rotor::Kind::Welded, 40, axle);
    for (int i = 0; i < 60; ++i) rotor.world.step(1.0 / 60);
    EXPECT_NEAR(rotor.world.omega(rotor.hub), 40, 1e-4);
  }
  Rotor rotor(Rotor::Kind::Welded, 40, {});
  const BodyId kite = rotor.world.create_body({.type = BodyType::Kinematic, .position = {0, 1}});
  rotor.world.create_joint(
      {.kind = JointKind::Rope, .a = kite, .b = rotor.hub, .anchor_a = {0, 1}, .length = 5.0});
  for (int i = 0; i < 60; ++i) rotor.world.step(1.0 / 60);
  EXPECT_NEAR(rotor.world.omega(rotor.hub), 40, 1e-9);
}

TEST(SpinningJoints, OfAMotorGetToItsSpeedAndLetItIdle) {
  JointDef motor;
  motor.motor_speed = 40;
  motor.motor_limit = 200;
  Rotor rotor(Rotor::Kind::Welded, 38, motor);
  double fastest = 0;
  for (int i = 0; i < 120; ++i) {
    rotor.world.step(1.0 / 60);
    fastest = std::max(fastest, rotor.world.omega(rotor.hub));
  }
  EXPECT_NEAR(rotor.world.omega(rotor.hub), 40, 1e-9);
  EXPECT_LT(fastest, 40 + 1e-9);
  // What is left is of second order.
  EXPECT_NEAR(rotor.world.joint_torque(rotor.hinge), 0, 10);
}

}  // namespace joint_energy_test
}  // namespace skerry
