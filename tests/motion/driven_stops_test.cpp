// SPDX-License-Identifier: MIT
//
// Motors, limits and ropes that stop what moves: what follows lands on it, what turns on passes dead centres,
// what is pressed stays.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <utility>

#include "tests/support/draw.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace driven_stops_test {

using test::Draw;

constexpr double kStep = 1.0 / 60;

WorldConfig config_for(const char* stepper) {
  WorldConfig config;
  config.stepper = stepper;
  return config;
}

class DrivenStops : public testing::TestWithParam<const char*> {
 protected:
  static World make() { return World(config_for(GetParam())); }
};

INSTANTIATE_TEST_SUITE_P(By, DrivenStops, testing::Values("auto", "event_driven", "time_stepping"),
                         [](const auto& each) { return std::string(each.param); });

/// A plate with a ball close above it falls as fast as that, until its joint is at its end.
TEST_P(DrivenStops, WhatFollowsLandsOnWhatAJointCaught) {
  for (const JointKind kind : {JointKind::Prismatic, JointKind::Rope, JointKind::Distance}) {
    for (unsigned seed = 0; seed < 40; ++seed) {
      SCOPED_TRACE(seed);
      Draw draw(seed);
      const double speed = draw.uniform(1, 8), gap = draw.uniform(0.001, 0.05), way = draw.uniform(0.05, 0.5);
      World world = make();
      const BodyId plate = world.create_body({.velocity = {0, -speed}});
      world.add_shape(plate, {.shape = make_box({1, 0.1})});
      JointDef joint{.kind = kind, .b = plate};
      if (kind == JointKind::Prismatic) {
        joint.axis = {0, 1};
        joint.lower = -way;
      } else if (kind == JointKind::Rope) {
        joint.anchor_a = {0, 0.05};
        joint.length = 0.05 + way;
      } else {
        joint.anchor_a = {0, 1};
        joint.length = 1;
        joint.lower = 0.9;
        joint.upper = 1 + way;
      }
      world.create_joint(joint);
      const BodyId ball = world.create_body({.position = {0, 0.15 + gap}, .velocity = {0, -speed}});
      world.add_shape(ball, {.shape = make_disc(0.1)});
      for (int k = 0; k < 40; ++k) {
        world.step(kStep);
        ASSERT_GT(world.position(ball).y - world.position(plate).y, 0.15 - 1e-6) << "step " << k;
      }
    }
  }
}

/// A crank with a flywheel, a rod, and a rocker whose hinge rubs: at its dead centres the crank has no lever
/// on what holds the rocker.
double flywheel_after(const char* stepper, unsigned seed) {
  Draw draw(seed);
  const double crank = draw.uniform(0.1, 0.3), rod = draw.uniform(0.8, 1.2), rocker = draw.uniform(0.8, 1.2),
               ground = draw.uniform(0.8, 1.2), speed = draw.uniform(2, 10);
  const double inertia = std::pow(10, draw.uniform(0, 2)), friction = std::pow(10, draw.uniform(-2, 0));
  WorldConfig config = config_for(stepper);
  config.gravity = {0, 0};
  World world(config);
  const BodyId wheel = world.create_body({.omega = speed, .mass = inertia, .inertia = inertia});
  world.create_joint({.kind = JointKind::Revolute, .b = wheel});
  const double phase = draw.uniform(0, 2 * kPi);
  const Vec2 a = crank * Vec2{std::cos(phase), std::sin(phase)}, d{ground, 0}, way = d - a;
  const double apart = length(way), along = (apart * apart + rod * rod - rocker * rocker) / (2 * apart);
  const Vec2 c = a + (along / apart) * way + (std::sqrt(rod * rod - along * along) / apart) * perp(way);
  const BodyId link = world.create_body({.position = 0.5 * (a + c), .mass = 1, .inertia = rod * rod / 12});
  const BodyId lever =
      world.create_body({.position = 0.5 * (c + d), .mass = 1, .inertia = rocker * rocker / 12});
  const auto hinge = [&](BodyId one, BodyId other, Vec2 at) {
    world.create_joint({.kind = JointKind::Revolute, .a = one, .b = other, .anchor_a = at, .anchor_b = at});
  };
  hinge(wheel, link, a);
  hinge(link, lever, c);
  world.create_joint({.kind = JointKind::Revolute,
                      .b = lever,
                      .anchor_a = d,
                      .anchor_b = d,
                      .motor_speed = 0,
                      .motor_limit = friction});
  world.step(1e-9);
  for (int k = 0; k < 120; ++k) world.step(kStep);
  return world.omega(wheel);
}

/// A block that a spring pulls, whose other end moves steadily, goes as soon as friction is too little:
/// x = v t - v / w sin(w t) from then on.
TEST(SpringFromWhatMoves, LetsGoWithinAStep) {
  for (const double speed : {0.1, 0.37, 1.0}) {
    World world(config_for("event_driven"));
    test::add_ground(world, test::rough(make_disc(1), 0.3));
    const BodyId block = test::add(world, {0, 0.2}, test::rough(make_box({1, 0.4}), 0.3), 2);
    const BodyId hand =
        world.create_body({.type = BodyType::Kinematic, .position = {3, 0.2}, .velocity = {speed, 0}});
    const double stiffness = 50, omega = std::sqrt(stiffness / 2),
                 start = 0.3 * 2 * 9.81 / (stiffness * speed);
    world.create_joint({.kind = JointKind::Spring,
                        .a = block,
                        .b = hand,
                        .anchor_a = {0, 0.2},
                        .anchor_b = {3, 0.2},
                        .stiffness = stiffness});
    const int steps = static_cast<int>((start + 0.5) / kStep);
    for (int k = 0; k < steps; ++k) world.step(kStep);
    const double t = steps * kStep - start;
    EXPECT_NEAR(world.position(block).x, speed * (t - std::sin(omega * t) / omega), 1e-9) << speed << " m/s";
  }
}

/// Gears and racks turn 1:10 from a wheel that is told to turn at once, or by a motor without limit.
TEST_P(DrivenStops, GearsMakeBodiesFarFasterThanWhatIsTold) {
  for (const bool motor : {false, true}) {
    for (const bool rack : {false, true}) {
      for (const double ratio : {5.0, 10.0}) {
        WorldConfig config = config_for(GetParam());
        config.gravity = {0, 0};
        World world(config);
        const BodyId wheel = motor ? world.create_body({.mass = 1.0, .inertia = 0.01})
                                   : world.create_body({.type = BodyType::Kinematic, .omega = 0.5});
        if (motor)
          world.create_joint(
              {.kind = JointKind::Revolute, .b = wheel, .anchor_a = {0, 0}, .motor_speed = 0.5});
        const BodyId driven = world.create_body({.position = {3, 0}, .mass = 2.0, .inertia = 0.1});
        if (rack) {
          world.create_joint({.kind = JointKind::Prismatic, .b = driven, .anchor_a = {3, 0}, .axis = {1, 0}});
          world.create_joint({.kind = JointKind::Rack,
                              .a = wheel,
                              .b = driven,
                              .anchor_a = {0, 0},
                              .anchor_b = {3, 0},
                              .axis = {1, 0},
                              .ratio = ratio});
        } else {
          world.create_joint({.kind = JointKind::Revolute, .b = driven, .anchor_a = {2, 0}});
          world.create_joint({.kind = JointKind::Gear,
                              .a = wheel,
                              .b = driven,
                              .anchor_a = {0, 0},
                              .anchor_b = {2, 0},
                              .ratio = -ratio});
        }
        for (int k = 0; k < 12; ++k) {
          world.step(kStep);
          const double speed = rack ? world.velocity(driven).x : world.omega(driven);
          EXPECT_NEAR(std::abs(speed), 0.5 * ratio, 1e-6 * ratio)
              << (motor ? "motor, " : "told, ") << (rack ? "rack 1:" : "gear 1:") << ratio << ", step " << k;
        }
      }
    }
  }
}

/// A slack rope to something that goes away, at a constant speed or as told, pulls once it is taut; whether
/// the block it pulls slept makes no difference.
TEST_P(DrivenStops, ASlackRopeWakesWhatItPulls) {
  for (const JointKind kind : {JointKind::Rope, JointKind::Distance, JointKind::Wheel}) {
    for (const int choice : {0, 1, 2, 3, 4, 5, 6, 7}) {
      const bool told = choice & 1, sleeps = choice & 2, winch_first = choice & 4;
      WorldConfig config = config_for(GetParam());
      config.sleep = sleeps;
      World world(config);
      test::add_ground(world, test::rough(make_disc(1), 0.3));
      const BodyId block = test::add(world, {0, 0.2}, test::rough(make_box({2, 0.4}), 0.3), 2);
      const BodyId winch = world.create_body(
          {.type = BodyType::Kinematic, .position = {5, 0.2}, .velocity = told ? Vec2{} : Vec2{1, 0}});
      if (told) world.set_motion(winch, [](double t) { return Placement{{5 + t, 0.2}, 0}; });
      JointDef def{.kind = kind, .a = block, .b = winch, .anchor_a = {0, 0.2}, .anchor_b = {5, 0.2}};
      if (winch_first) {
        std::swap(def.a, def.b);
        std::swap(def.anchor_a, def.anchor_b);
      }
      if (kind == JointKind::Rope) def.length = 5.2;
      if (kind == JointKind::Distance) def.upper = 5.2;
      if (kind == JointKind::Wheel) {
        def.axis = {winch_first ? -1.0 : 1.0, 0};
        def.upper = 0.2;
      }
      world.create_joint(def);
      for (int k = 0; k < 60; ++k) world.step(kStep);
      EXPECT_NEAR(world.position(block).x, 0.8, 1e-6)
          << "joint " << static_cast<int>(kind) << ", choice " << choice;
    }
  }
}

TEST(DeadCentres, DoNotStopWhatRubsAndTurns) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    const double events = flywheel_after("event_driven", seed), steps = flywheel_after("time_stepping", seed);
    EXPECT_NEAR(steps, events, 0.05 * std::max(1.0, std::abs(events))) << "seed " << seed;
  }
}

/// A motor without a largest force has raised a jib to its stop; a load swings on a rope from its end.
TEST_P(DrivenStops, AJibUnderASwingingLoadStaysAtItsStop) {
  for (unsigned seed = 0; seed < 30; ++seed) {
    SCOPED_TRACE(seed);
    Draw draw(seed);
    World world = make();
    const double reach = draw.uniform(0.5, 1.5), from = -draw.uniform(0.05, 0.5), up = draw.uniform(0, 0.6);
    const Vec2 tip = reach * Vec2{std::cos(from), std::sin(from)};
    const BodyId arm = world.create_body({});
    world.add_shape(arm,
                    {.shape = make_capsule({0, 0}, tip, 0.03), .density = std::pow(10, draw.uniform(2, 4))});
    const JointId motor = world.create_joint(
        {.kind = JointKind::Revolute, .b = arm, .upper = up - from, .motor_speed = draw.uniform(0.5, 3)});
    const Vec2 middle = tip + Vec2{draw.uniform(-0.3, 0.3), -draw.uniform(0.4, 1)};
    const BodyId load = world.create_body(
        {.position = middle, .velocity = {draw.uniform(-2, 2), 0}, .omega = draw.uniform(-3, 3)});
    world.add_shape(load, {.shape = make_box({0.2, 0.2}), .density = std::pow(10, draw.uniform(2, 4))});
    world.create_joint({.kind = JointKind::Rope,
                        .a = arm,
                        .b = load,
                        .anchor_a = tip,
                        .anchor_b = middle + Vec2{draw.uniform(-0.1, 0.1), 0.1},
                        .length = length(middle - tip) * draw.uniform(1, 1.3)});
    double least = 0;
    bool raised = false;
    for (int k = 0; k < 180; ++k) {
      world.step(kStep);
      const double left = up - from - world.joint_position(motor);
      const double energy = world.kinetic_energy() + world.potential_energy();
      if (!raised) least = energy;
      raised |= left < 1e-6;
      if (!raised) continue;
      ASSERT_LT(left, 2e-6) << "step " << k;
      ASSERT_LT(energy - least, 0.006 * world.mass(load) * 9.81) << "step " << k;
      least = std::min(least, energy);
    }
    EXPECT_TRUE(raised);
  }
}

/// What hops off its stop by less than contacts are wide, and is pressed back, would gain speed by what it
/// sinks in, and hop again.
TEST_P(DrivenStops, AMotorThatPressesAPlankOnItsStopDoesNotChatter) {
  for (const double torque : {1e3, 1e4, 1e5}) {
    World world = make();
    const BodyId plank = world.create_body({});
    world.add_shape(plank, {.shape = make_box({2, 0.1}), .density = 500, .material = {.friction = 0.7}});
    world.create_joint(
        {.kind = JointKind::Revolute, .b = plank, .lower = -0.1, .motor_speed = -1, .motor_limit = torque});
    const BodyId box = world.create_body({.position = {-0.4, 0.17}, .omega = 0.5});
    world.add_shape(box, {.shape = make_box({0.2, 0.2}), .density = 500, .material = {.friction = 0.7}});
    // Of a box that rocks to rest.
    int impacts = 0;
    for (int k = 0; k < 180; ++k) impacts += world.step(kStep).impacts;
    EXPECT_LE(impacts, 250) << torque;
  }
}

/// A cart whose strong motor reaches its speed, while a box slides to rest on it, in one step.
TEST(StrongMotors, ReachTheirSpeedWhileOthersStop) {
  World world(config_for("time_stepping"));
  const BodyId cart = world.create_body({.position = {0, -0.1}, .velocity = {0.87, 0}, .mass = 7.178});
  world.add_shape(cart, {.shape = make_box({6, 0.2}), .material = {.friction = 0.3368}});
  world.create_joint({.kind = JointKind::Prismatic,
                      .b = cart,
                      .anchor_a = {0, -0.1},
                      .axis = {1, 0},
                      .lower = -0.434,
                      .upper = 0.307,
                      .motor_speed = -2.877,
                      .motor_limit = 5.22e4});
  const BodyId box = world.create_body({.position = {-1, 0.2815}, .velocity = {-1.7006, 0}, .mass = 3.134});
  world.add_shape(box, {.shape = make_box({0.3782, 0.563}), .material = {.friction = 0.036}});
  world.step(kStep);
  // The motor takes m dv / F; before and after it the speeds are known.
  const double start = 7.178 * (0.87 + 2.877) / 5.22e4;
  EXPECT_NEAR(world.position(cart).x, 0.5 * (0.87 - 2.877) * start - 2.877 * (kStep - start), 1e-5);
}

}  // namespace driven_stops_test
}  // namespace skerry
