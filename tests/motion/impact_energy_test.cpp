// SPDX-License-Identifier: MIT
//
// Impacts with friction: energy never grows, and momentum is kept.
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace impact_energy_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;
using test::weightless;

TEST(ImpactWithFriction, RodsThatHitARoughFloorNeverGainEnergy) {
  const unsigned seed = 17;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  int impacts = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const double mu = 3 * unit(random), e = trial % 4 == 0 ? 0 : unit(random), t = 1.4 * unit(random) + 0.1;
    World world(weightless());
    add_ground(world, rough(make_disc(1), mu, e));
    const double r = 1e-3;
    const auto rod = world.create_body({.position = {0, std::sin(t) + r},
                                        .angle = t,
                                        .velocity = {4 * unit(random) - 2, -2 * unit(random)},
                                        .omega = 4 * unit(random) - 2,
                                        .mass = 1.0,
                                        .inertia = 1.0 / 3});
    world.add_shape(rod, rough(make_capsule({-1, 0}, {1, 0}, r), mu, e));
    const double before = world.kinetic_energy();
    impacts += world.step(1e-9).impacts;
    EXPECT_LE(world.kinetic_energy(), before * (1 + 1e-13)) << "seed " << seed << " trial " << trial;
    EXPECT_GE(world.velocity_at(rod, {-std::cos(t), 0}).y, -1e-6) << "seed " << seed << " trial " << trial;
  }
  EXPECT_GT(impacts, 150);
}

/// Kane's paradox: a double pendulum strikes a rough floor with its end.
TEST(ImpactWithFriction, KanesPendulumGainsNoEnergy) {
  for (const double mu : {0.0, 0.2, 0.5, 0.8}) {
    for (const double e : {0.0, 0.3, 0.7, 1.0}) {
      World world(weightless());
      const double t1 = kPi / 9, t2 = kPi / 6, r = 1e-3;  // of both rods to the vertical
      const Vec2 hinge{0, std::cos(t1) + std::cos(t2) + r};
      const Vec2 elbow = hinge + Vec2{std::sin(t1), -std::cos(t1)};
      const Vec2 tip = elbow + Vec2{std::sin(t2), -std::cos(t2)};
      add_ground(world, rough(make_disc(1), mu, e));
      const double w1 = -0.1, w2 = -0.2;
      const auto rod = [&](Vec2 from, Vec2 to, Vec2 velocity, double omega) {
        const Vec2 d = to - from;
        const auto body = world.create_body({.position = 0.5 * (from + to),
                                             .angle = std::atan2(d.y, d.x),
                                             .velocity = velocity,
                                             .omega = omega,
                                             .mass = 1.0,
                                             .inertia = 1.0 / 12});
        world.add_shape(body, rough(make_capsule({-0.5, 0}, {0.5, 0}, r), mu, e));
        return body;
      };
      const Vec2 elbow_velocity = w1 * perp(elbow - hinge);
      const auto upper = rod(hinge, elbow, 0.5 * elbow_velocity, w1);
      const auto lower = rod(elbow, tip, elbow_velocity + w2 * perp(0.5 * (tip - elbow)), w2);
      world.create_joint({.kind = JointKind::Revolute, .b = upper, .anchor_a = hinge, .anchor_b = hinge});
      world.create_joint(
          {.kind = JointKind::Revolute, .a = upper, .b = lower, .anchor_a = elbow, .anchor_b = elbow});
      const double before = world.kinetic_energy();
      ASSERT_LT(world.velocity_at(lower, tip).y, 0);
      EXPECT_EQ(world.step(1e-9).impacts, 1);
      EXPECT_LE(world.kinetic_energy(), before * (1 + 1e-12)) << "mu " << mu << " e " << e;
      EXPECT_GE(world.velocity_at(lower, tip).y, -1e-9) << "mu " << mu << " e " << e;
    }
  }
}

TEST(ImpactWithFriction, RandomHeapsLoseEnergyAndKeepMomentum) {
  const unsigned seed = 23;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int trial = 0; trial < test_scale(60); ++trial) {
    World world(weightless());
    const double mu = 1.5 * unit(random);
    const int side = 2 + trial % 3;
    for (int i = 0; i < side * side; ++i) {
      const double e = trial % 3 == 0 ? 0 : trial % 3 == 1 ? 0.5 : unit(random);
      const int column = i % side, row = i / side;
      const Vec2 at{1.0 * column, 1.0 * row};
      add(world, at, i % 2 == 0 ? rough(make_box({1, 1}), mu, e) : rough(make_disc(0.5), mu, e),
          std::pow(10.0, 2 * unit(random) - 1), {2 * unit(random) - 1, 2 * unit(random) - 1},
          2 * unit(random) - 1);
    }
    const double energy = world.kinetic_energy(), angular = world.angular_momentum();
    const Vec2 momentum = world.momentum();
    world.step(1e-9);
    EXPECT_LE(world.kinetic_energy(), energy * (1 + 1e-12)) << "seed " << seed << " trial " << trial;
    EXPECT_NEAR(length(world.momentum() - momentum), 0, 1e-11) << "seed " << seed << " trial " << trial;
    EXPECT_NEAR(world.angular_momentum(), angular, 1e-10) << "seed " << seed << " trial " << trial;
  }
}

/// A press comes down on bodies that bounce: no impulses are right, and none may fling them away.
TEST(ImpactWithFriction, OfWhatIsSqueezedStaysBounded) {
  const double speed = 3;
  for (const char* law : {"reflections", "poisson", "simultaneous"}) {
    for (const char* stepper : {"time_stepping", "event_driven"}) {
      for (const double e : {0.0, 0.7}) {
        WorldConfig config;
        config.impact_law = law;
        config.stepper = stepper;
        World world(config);
        add_ground(world, rough(make_disc(1), 0.5, e));
        std::vector<BodyId> bodies;
        for (int i = 0; i < 3; ++i) {
          bodies.push_back(add(world, {0.9 * i, 0.3}, rough(make_box({0.6, 0.6}), 0.5, e), 1 + 100.0 * i));
          bodies.push_back(add(world, {0.9 * i, 0.85}, rough(make_disc(0.25), 0.5, e), 10));
        }
        const BodyId press =
            world.create_body({.type = BodyType::Kinematic, .position = {0.9, 1.7}, .velocity = {0, -speed}});
        world.add_shape(press, rough(make_box({4, 0.4}), 0.5, e));
        bool squeezed = false;
        for (int step = 0; step < 30; ++step) {
          const StepReport& report = world.step(1.0 / 60);
          squeezed = squeezed || report.inexact_islands + report.islands_in_flow > 0;
          EXPECT_LE(report.impacts, 3000);
          for (const BodyId body : bodies)
            ASSERT_LE(length(world.velocity(body)), 30 * speed)
                << law << ' ' << stepper << " e " << e << " step " << step;
        }
        EXPECT_TRUE(squeezed) << law << ' ' << stepper << " e " << e;
      }
    }
  }
}

/// Share of the energy that a disc has after 5 s in which it is thrown against a wall again and again, by
/// what pulls it to where the wall's surface is, or a little behind that.
double left_by_bounces(const char* stepper, bool by_field, double frequency, double behind) {
  WorldConfig config = weightless();
  config.stepper = stepper;
  World world(config);
  const BodyId wall = world.create_body({.type = BodyType::Static});
  world.add_shape(wall, smooth(make_half_plane({-0.2 - behind, 0}, {1, 0}), 1));
  const BodyId disc = add(world, {0, 0}, smooth(make_disc(0.2), 1), 1, {1, 0});
  const double stiffness = std::pow(2 * kPi * frequency, 2);
  if (by_field)
    world.set_force_field([=](const FieldSample& sample) {
      return Wrench{{-stiffness * sample.position.x, 0}, 0};
    });
  else
    world.create_joint({.kind = JointKind::Spring,
                        .b = disc,
                        .anchor_a = {-2, 0},
                        .anchor_b = {0, 0},
                        .length = 2.0,
                        .stiffness = stiffness});
  const auto energy = [&] {
    const double x = world.position(disc).x;
    return world.kinetic_energy() + 0.5 * stiffness * x * x;
  };
  const double first = energy();
  int impacts = 0;
  for (int k = 0; k < 300; ++k) impacts += world.step(1.0 / 60).impacts;
  EXPECT_GT(impacts, 4 * frequency);
  return energy() / first;
}

TEST(ImpactBesideASpring, KeepsTheEnergy) {
  // A piece that a bounce ends has the forces of its own middle.
  for (const char* stepper : {"time_stepping", "event_driven"}) {
    for (const double frequency : {1.0, 2.0, 4.8}) {
      for (const double behind : {0.0, 0.1 / frequency}) {
        EXPECT_NEAR(left_by_bounces(stepper, false, frequency, behind), 1, 1e-3)
            << stepper << ", " << frequency << " Hz";
        // Fields are of second order, and their errors come and go.
        EXPECT_NEAR(left_by_bounces(stepper, true, frequency, behind), 1, 0.03)
            << stepper << ", " << frequency << " Hz, field";
      }
    }
  }
}

TEST(ImpactUnderAField, GainsNothingWhereTheFieldSwingsTooFastForTheStep) {
  for (const double frequency : {8.0, 10.0, 14.0}) {
    EXPECT_LE(left_by_bounces("time_stepping", true, frequency, 0), 1.1) << frequency << " Hz";
  }
}

}  // namespace impact_energy_test
}  // namespace skerry
