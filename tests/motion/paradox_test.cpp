// SPDX-License-Identifier: MIT
//
// Scenes at the edge of what rigid bodies can do: infinitely many collisions, forces that do not exist.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <iterator>
#include <vector>

#include "tests/support/worlds.h"

namespace skerry {
namespace paradox_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;
using test::weightless;

constexpr double kG = 9.81;

class ParadoxBy : public testing::TestWithParam<const char*> {
 protected:
  static WorldConfig config(WorldConfig base = {}) {
    base.stepper = GetParam();
    return base;
  }
};

// Constantin, Grossman & Mungan 1995: three balls in a line collide infinitely often in a finite time, and
// stay together, iff e < 7 - 4 sqrt 3 = 0.0718. Above, the relative speeds oscillate with an angle whose
// cosine is (1 + e) / (4 sqrt e) and the balls part after a few collisions.
TEST_P(ParadoxBy, ThreeBallsCollapseBelowTheCriticalRestitutionOnly) {
  const double critical = 7 - 4 * std::sqrt(3.0);
  for (const double e : {0.2, 0.1, 0.06, 0.02}) {
    World world(config(weightless()));
    const double speed = 10;
    const auto left = add(world, {-1.5, 0}, smooth(make_disc(0.5), e), 1, {speed, 0});
    const auto middle = add(world, {0, 0}, smooth(make_disc(0.5), e), 1);
    const auto right = add(world, {1.75, 0}, smooth(make_disc(0.5), e), 1, {-speed, 0});
    for (int i = 0; i < 120; ++i) world.step(1.0 / 60);
    // Relative speeds of approach of the pair that collides and of the other, from collision to collision.
    double x = speed, y = speed;
    for (int i = 0; i < 1000 && x > 0; ++i) {
      const double other = -e * x;
      x = y + 0.5 * (1 + e) * x;
      y = other;
    }
    const double apart_left = world.velocity(middle).x - world.velocity(left).x;
    const double apart_right = world.velocity(right).x - world.velocity(middle).x;
    EXPECT_NEAR(world.momentum().x, 0, 1e-13);
    if (e < critical) {
      // Balls nearer than the touch tolerance collide at the same time: that leaves a rest of the motion.
      EXPECT_LT(std::max(apart_left, apart_right), 1e-3 * speed) << e;
      EXPECT_GE(std::min(apart_left, apart_right), -1e-9) << e;
    } else {
      EXPECT_NEAR(std::max(apart_left, apart_right), -std::min(x, y), 1e-9 * speed) << e;
      EXPECT_NEAR(std::min(apart_left, apart_right), -std::max(x, y), 1e-9 * speed) << e;
    }
  }
}

// Painleve 1895: a rod that slides with its lower end ahead of its centre and leans back may have no
// acceleration that Coulomb's law allows, iff mu > (1 + 3 cos^2 t) / (3 sin t cos t). The way out is an
// impulse without a collision [Champneys & Varkonyi 2016].
TEST_P(ParadoxBy, RodInPainlevesParadoxStopsSlidingAtOnceAndGainsNoEnergy) {
  const double t = std::atan(2.0), r = 1e-6;
  const double least = (1 + 3 * std::cos(t) * std::cos(t)) / (3 * std::sin(t) * std::cos(t));
  EXPECT_NEAR(least, 4.0 / 3, 1e-14);
  for (const double mu : {0.5, 1.2, 1.4, 2.0, 10.0}) {
    World world(config());
    add_ground(world, rough(make_disc(1), mu));
    const double speed = 2;
    const auto rod = world.create_body({.position = {std::cos(t), std::sin(t) + r},
                                        .angle = t,
                                        .velocity = {-speed, 0},
                                        .mass = 1.0,
                                        .inertia = 1.0 / 3});
    world.add_shape(rod, rough(make_capsule({-1, 0}, {1, 0}, r), mu));
    double energy = world.kinetic_energy() + world.potential_energy();
    const double start = energy;
    std::vector<MotionEvent> paradoxes;
    for (int i = 0; i < 240; ++i) {
      const StepReport& report = world.step(1.0 / 240);
      const double now = report.kinetic_energy + report.potential_energy;
      EXPECT_LE(now, energy + 1e-4 * start) << "mu " << mu << " step " << i;
      EXPECT_EQ(report.contained, 0);
      const auto is_paradox = [](const MotionEvent& event) { return event.kind == MotionEventKind::Paradox; };
      std::copy_if(report.motion_events.begin(), report.motion_events.end(), std::back_inserter(paradoxes),
                   is_paradox);
      EXPECT_EQ(report.paradoxes,
                std::count_if(report.motion_events.begin(), report.motion_events.end(), is_paradox));
      EXPECT_LE(report.worst_penetration, 1e-6) << "mu " << mu << " step " << i;
      if (i == 0 && mu > least) {
        // All sliding gone in an instant, though the end did not fall onto the floor.
        const Vec2 end = world.position(rod) - rotate(Rot::from_angle(world.angle(rod)), {1, 0});
        EXPECT_NEAR(world.velocity_at(rod, end).x, 0, 10 * r) << "mu " << mu;
      }
      energy = now;
    }
    EXPECT_LE(energy, start);
    // The report names it, once, where it begins.
    EXPECT_EQ(paradoxes.size(), mu > least ? 1u : 0u) << "mu " << mu;
    if (paradoxes.empty()) continue;
    EXPECT_NEAR(paradoxes[0].time, 0, 1e-12) << "mu " << mu;
    EXPECT_EQ(paradoxes[0].body_b, rod) << "mu " << mu;
  }
}

// A rod that slides towards the paradox may jam: its forces grow beyond all bounds before it is there
// [Champneys & Varkonyi 2016]. By events 48 000 force solves were tried in the step in which they do.
TEST_P(ParadoxBy, RodThatJamsIsToldByAFewHundredInnerSteps) {
  for (const double speed : {7.0, 7.1, 7.2, 7.3}) {
    World world(config());
    add_ground(world, rough(make_disc(1), 1.9));
    const double t = 0.525, r = 1e-3, spin = -2.2;
    const Vec2 centre{-std::cos(t), std::sin(t)};
    const auto rod = world.create_body({.position = centre + Vec2{0, r},
                                        .angle = -t,
                                        .velocity = Vec2{speed, 0} + spin * perp(centre),
                                        .omega = spin,
                                        .mass = 1.0,
                                        .inertia = 1.0 / 3});
    world.add_shape(rod, rough(make_capsule({-1, 0}, {1, 0}, r), 1.9));
    double energy = world.kinetic_energy() + world.potential_energy();
    int most = 0;
    for (int i = 0; i < 20; ++i) {
      const StepReport& report = world.step(1.0 / 60);
      const double now = report.kinetic_energy + report.potential_energy;
      EXPECT_LE(now, energy * (1 + 1e-4)) << speed << " step " << i;
      EXPECT_LE(report.worst_penetration, 1e-6) << speed << " step " << i;
      most = std::max(most, report.force_solves);
      energy = now;
    }
    EXPECT_LE(most, 8000) << speed;
    EXPECT_EQ(world.report().contained, 0) << speed;
  }
}

INSTANTIATE_TEST_SUITE_P(Steppers, ParadoxBy, testing::Values("time_stepping", "event_driven", "auto"),
                         [](const auto& stepper) { return std::string(stepper.param); });

// A block on an incline tips before it slides iff mu > width / height, at tan A = width / height.
TEST(Incline, BlockTipsOrSlidesFirstAsItsShapeSays) {
  const double width = 0.5, height = 1;
  for (const double mu : {0.3, 0.8}) {
    for (const double share : {0.99, 1.01}) {
      const double limit = std::min(mu, width / height);
      const double angle = std::atan(share * limit);
      World world;
      add_ground(world, rough(make_disc(1), mu), -angle);
      const Rot q = Rot::from_angle(-angle);
      const Vec2 start = rotate(q, {0, 0.5 * height});
      const auto block = add(world, start, rough(make_box({width, height}), mu), 1, {}, 0, -angle);
      for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
      const double slid = length(world.position(block) - start),
                   turned = std::abs(world.angle(block) + angle);
      if (share < 1) {
        EXPECT_LE(slid, 1e-9) << mu;
        EXPECT_LE(turned, 1e-9) << mu;
      } else if (mu < width / height) {
        const double a = kG * (std::sin(angle) - mu * std::cos(angle));
        EXPECT_NEAR(slid, 0.5 * a, 1e-6 * a) << mu;
        EXPECT_LE(turned, 1e-9) << mu;
      } else {
        EXPECT_GT(turned, 1e-3) << mu;
      }
    }
  }
}

TEST(Bowling, BackspinSendsTheDiscBack) {
  // v = (2 v0 + w0 r) / 3 with w0 in the sense of rolling.
  const double v0 = 1, r = 0.5, mu = 0.3;
  for (const double spin : {4.0, -2.0, -8.0}) {
    WorldConfig config;
    config.stepper = "event_driven";
    World world(config);
    add_ground(world, rough(make_disc(1), mu));
    const auto disc = add(world, {0, r}, rough(make_disc(r), mu), 1, {v0, 0}, -spin);
    for (int i = 0; i < 120; ++i) world.step(1.0 / 60);
    EXPECT_NEAR(world.velocity(disc).x, (2 * v0 + spin * r) / 3, 1e-12) << spin;
  }
}

}  // namespace paradox_test
}  // namespace skerry
