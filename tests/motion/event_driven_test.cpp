// SPDX-License-Identifier: MIT
//
// Published results for event-driven stepping: rounding, or what the accuracy of the integration leaves.
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "tests/support/draw.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace event_driven_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;
using test::weightless;

constexpr double kG = 9.81;

WorldConfig by_events(WorldConfig config = {}) {
  config.stepper = "event_driven";
  return config;
}

/// The time of the first event of a kind in the report, or -1.
double time_of(const StepReport& report, MotionEventKind kind) {
  for (const MotionEvent& event : report.motion_events) {
    if (event.kind == kind) return event.time;
  }
  return -1;
}

struct Departure {
  double angle;
  int solves, fallbacks;
};

/// A solid disc (or one without friction) leaves a fixed cylinder; from its ballistic state at the end of the
/// step back to where it left.
Departure roll_off(double mu) {
  const double r = 0.25, length_ = 1 + r, start = 0.1, h = 2;
  World world(by_events());
  const auto cylinder = world.create_body({.type = BodyType::Static});
  world.add_shape(cylinder, rough(make_disc(1), mu));
  const auto disc =
      add(world, {length_ * std::sin(start), length_ * std::cos(start)}, rough(make_disc(r), mu));
  const StepReport& report = world.step(h);
  const double flight = h - time_of(report, MotionEventKind::Release);
  const Vec2 v = world.velocity(disc) - flight * Vec2{0, -kG};
  const Vec2 p = world.position(disc) - flight * v - 0.5 * flight * flight * Vec2{0, -kG};
  Departure out{};
  out.angle = std::atan2(p.x, p.y);
  out.solves = report.force_solves;
  out.fallbacks = report.fallbacks;
  return out;
}

TEST(EventDriven, DiscLeavesACylinderAtTheKnownAngles) {
  const double start = std::cos(0.1);
  for (const auto& [mu, angle] :
       {std::pair(0.0, std::acos(2.0 / 3 * start)), std::pair(1e13, std::acos(4.0 / 7 * start)),
        std::pair(0.2, 0.907687858236848), std::pair(0.5, 0.936306116500060)}) {
    const Departure found = roll_off(mu);
    EXPECT_EQ(found.fallbacks, 0) << "mu " << mu;
    EXPECT_NEAR(found.angle, angle, 1e-12) << "mu " << mu;
    EXPECT_LE(found.solves, 400) << "mu " << mu;
  }
}

TEST(EventDriven, SlidingDiscRollsAfterTheKnownTimeWithTwoThirdsOfItsSpeed) {
  const double mu = 0.2, v0 = 3, r = 0.5;
  World world(by_events());
  add_ground(world, rough(make_disc(1), mu));
  const auto disc = add(world, {0, r}, rough(make_disc(r), mu), 1, {v0, 0});
  const StepReport& report = world.step(1);
  const double time = v0 / (3 * mu * kG), path = 5 * v0 * v0 / (18 * mu * kG);
  EXPECT_EQ(report.fallbacks, 0);
  EXPECT_NEAR(time_of(report, MotionEventKind::Stick), time, 1e-12);
  EXPECT_NEAR(world.velocity(disc).x, 2 * v0 / 3, 1e-12);
  EXPECT_NEAR(world.omega(disc), -2 * v0 / 3 / r, 1e-12);
  EXPECT_NEAR(world.position(disc).x, path + 2 * v0 / 3 * (1 - time), 1e-12);
}

TEST(EventDriven, DiscOnAnInclineRollsOrSlidesByTheLaws) {
  for (const auto& [angle, mu] : {std::pair(kPi / 6, 0.5), std::pair(kPi / 3, 0.2)}) {
    World world(by_events());
    add_ground(world, rough(make_disc(1), mu), -angle);
    const Rot q = Rot::from_angle(-angle);
    const auto disc = add(world, rotate(q, {0, 0.5}), rough(make_disc(0.5), mu));
    for (int i = 0; i < 60; ++i) EXPECT_EQ(world.step(1.0 / 60).fallbacks, 0);
    const bool rolls = std::tan(angle) <= 3 * mu;
    const double a = rolls ? 2.0 / 3 * kG * std::sin(angle) : kG * (std::sin(angle) - mu * std::cos(angle));
    const double alpha = rolls ? a / 0.5 : 2 * mu * kG * std::cos(angle) / 0.5;
    EXPECT_NEAR(dot(world.position(disc), rotate(q, {1, 0})), 0.5 * a, 1e-12);
    EXPECT_NEAR(world.omega(disc), -alpha, 1e-11);
  }
}

TEST(EventDriven, SlidingBlockStopsWhereTheFormulaSays) {
  const double mu = 0.3, v0 = 2;
  World world(by_events());
  add_ground(world, rough(make_disc(1), mu));
  const auto block = add(world, {0, 0.25}, rough(make_box({2, 0.5}), mu), 1, {v0, 0});
  double stopped = -1;
  for (int i = 0; i < 60; ++i) {
    const StepReport& report = world.step(1.0 / 60);
    EXPECT_EQ(report.fallbacks, 0);
    if (stopped < 0) stopped = time_of(report, MotionEventKind::Stick);
  }
  EXPECT_NEAR(stopped, v0 / (mu * kG), 1e-12);
  EXPECT_NEAR(world.position(block).x, v0 * v0 / (2 * mu * kG), 1e-12);
  EXPECT_EQ(world.report().islands_at_rest, 1);
}

TEST(EventDriven, BouncingBallSettlesAtTheZenoTime) {
  for (const double e : {0.3, 0.5, 0.7}) {
    const double drop = 1;
    World world(by_events());
    add_ground(world, smooth(make_disc(1), e));
    const auto ball = add(world, {0, drop + 0.5}, smooth(make_disc(0.5), e));
    double settled = -1;
    for (int i = 0; i < 60 * 4; ++i) {
      const StepReport& report = world.step(1.0 / 60);
      EXPECT_EQ(report.fallbacks, 0);
      if (settled < 0) settled = time_of(report, MotionEventKind::Settle);
    }
    const double exact = std::sqrt(2 * drop / kG) * (1 + e) / (1 - e);
    EXPECT_NEAR(settled, exact, 1e-12);
    EXPECT_NEAR(world.position(ball).y, 0.5, 1e-12);
    EXPECT_EQ(world.velocity(ball).y, 0);
  }
}

/// Time in which the block swings from rest at `tilt` about a corner to upright: the integral of dt / omega
/// with t = tilt (1 - u^2), by Simpson's rule.
double upright_time(double tilt, double slope, double p) {
  const int n = 2000;
  double sum = 0;
  for (int i = 0; i <= n; ++i) {
    const double u = static_cast<double>(i) / n, t = tilt * (1 - u * u);
    // omega^2 / u^2 = 2 p^2 (cos(A - tilt) - cos(A - t)) / u^2, as a product and without cancellation
    const double half = 0.5 * tilt * u * u;
    const double ratio = u > 0 ? std::sin(half) / (u * u) : 0.5 * tilt;
    const double drop = 2 * std::sin(slope - 0.5 * (tilt + t)) * ratio;
    sum += 2 * tilt / std::sqrt(2 * p * p * drop) * (i == 0 || i == n ? 1 : i % 2 == 1 ? 4 : 2);
  }
  return sum / (3 * n);
}

TEST(EventDriven, RockingBlockIsUprightAfterItsQuarterPeriod) {
  for (const double slender : {1.0, 2.0, 4.0}) {
    World world(by_events());
    add_ground(world, rough(make_disc(1), 10));
    const double b = 0.5, h = b * slender, tilt = 0.02;
    const Rot q = Rot::from_angle(-tilt);
    add(world, rotate(q, {-b, h}), rough(make_box({2 * b, 2 * h}), 10), 1, {}, 0, -tilt);
    const double p = std::sqrt(3 * kG / (4 * std::hypot(b, h)));
    double landed = -1;
    for (int i = 0; i < 400 && landed < 0; ++i) {
      const StepReport& report = world.step(1.0 / 240);
      EXPECT_EQ(report.fallbacks, 0) << i;
      landed = time_of(report, MotionEventKind::Landing);
    }
    const double exact = upright_time(tilt, std::atan(1 / slender), p);
    EXPECT_NEAR(landed, exact, 1e-11) << slender;
    // Housner's formula is this for slender blocks.
    EXPECT_NEAR(landed, std::acosh(1 / (1 - tilt / std::atan(1 / slender))) / p, 6e-2 * landed);
  }
}

TEST(EventDriven, RockingBlockLosesHousnersShareInTheImpact) {
  for (const double slender : {1.0, 1.5, 2.0, 4.0}) {
    const double b = 0.5, h = b * slender, w = 1;
    World world(by_events(weightless()));
    add_ground(world, rough(make_disc(1), 10));
    // Upright, still turning about its left corner: the right one hits the floor.
    const auto block = add(world, {0, h}, rough(make_box({2 * b, 2 * h}), 10), 1, {h * w, -b * w}, -w);
    const StepReport& report = world.step(1e-9);
    const double sine = 1 / std::hypot(1.0, slender);
    EXPECT_EQ(report.fallbacks, 0);
    EXPECT_NEAR(world.omega(block) / -w, 1 - 1.5 * sine * sine, 1e-13);
  }
}

TEST(EventDriven, CollisionsCountTheDigitsOfPi) {
  for (const auto& [ratio, count] : {std::pair(1.0, 3), std::pair(100.0, 31), std::pair(1e4, 314)}) {
    World world(by_events(weightless()));
    const auto wall = world.create_body({.type = BodyType::Static});
    world.add_shape(wall, smooth(make_half_plane({0, 0}, {1, 0}), 1));
    add(world, {1, 0}, smooth(make_box({0.5, 0.5}), 1), 1);
    add(world, {3, 0}, smooth(make_box({1, 1}), 1), ratio, {-1, 0});
    int impacts = 0, fallbacks = 0;
    for (int i = 0; i < 6000; ++i) {
      const StepReport& report = world.step(1.0 / 600);
      impacts += report.impacts;
      fallbacks += report.fallbacks;
    }
    EXPECT_EQ(impacts, count) << "mass ratio " << ratio;
    EXPECT_EQ(fallbacks, 0);
    EXPECT_NEAR(world.kinetic_energy(), 0.5 * ratio, 1e-12 * ratio);
  }
}

TEST(EventDriven, SmoothLadderLeavesTheWallAtTwoThirdsOfItsSine) {
  const double t0 = 1, half = 1, r = 1e-4;
  World world(by_events());
  const auto fixed = world.create_body({.type = BodyType::Static});
  world.add_shape(fixed, smooth(make_half_plane({0, 0}, {0, 1})));
  world.add_shape(fixed, smooth(make_half_plane({0, 0}, {1, 0})));
  const auto ladder = world.create_body({.position = {half * std::cos(t0) + r, half * std::sin(t0) + r},
                                         .angle = kPi - t0,
                                         .mass = 1.0,
                                         .inertia = 1.0 / 3});
  world.add_shape(ladder, smooth(make_capsule({-half, 0}, {half, 0}, r)));
  double left = -1;
  for (int i = 0; i < 2000 && left < 0; ++i) {
    const StepReport& report = world.step(1e-3);
    EXPECT_EQ(report.fallbacks, 0) << i;
    left = time_of(report, MotionEventKind::Release);
  }
  ASSERT_GT(left, 0);
  // No force acts along x any more, so x and its velocity tell the angle: x' = sin t t' half with the energy.
  const double sine = 2.0 / 3 * std::sin(t0);
  const double rate = std::sqrt(1.5 * kG / half * (std::sin(t0) - sine));
  EXPECT_NEAR(world.velocity(ladder).x, half * sine * rate, 1e-12);
  const double x = world.position(ladder).x - world.velocity(ladder).x * (world.time() - left) - r;
  EXPECT_NEAR(std::sqrt(1 - x * x), sine, 1e-12);
}

TEST(EventDriven, PendulumKeepsThePeriodOfTheEllipticIntegral) {
  const double reach = 1.0, start = 1.0;
  World world(by_events());
  const auto bob = world.create_body(
      {.position = {reach * std::sin(start), -reach * std::cos(start)}, .mass = 1.0, .inertia = 1e-3});
  world.create_joint({.kind = JointKind::Revolute, .b = bob, .anchor_a = {0, 0}, .anchor_b = {0, 0}});
  double a = 1, g = std::cos(start / 2);
  for (int i = 0; i < 20; ++i) {
    const double mean = 0.5 * (a + g);
    g = std::sqrt(a * g);
    a = mean;
  }
  const double period = 2 * kPi / a * std::sqrt((reach * reach + 1e-3) / (kG * reach));
  for (int i = 0; i < 100; ++i) EXPECT_EQ(world.step(period / 100).fallbacks, 0);
  // At the end of its swing the angle is stationary; the speed tells the phase.
  EXPECT_NEAR(world.angle(bob), 0, 1e-11);
  EXPECT_NEAR(world.omega(bob), 0, 1e-11);
}

// A guess for each step anew would take two inner steps in each.
TEST(EventDriven, StepsBeginWithTheInnerStepThatServedLast) {
  World world(by_events());
  const auto bob = world.create_body({.position = {1, 0}, .mass = 1.0, .inertia = 0.1});
  world.create_joint({.kind = JointKind::Revolute, .b = bob, .anchor_a = {0, 0}, .anchor_b = {0, 0}});
  const int steps = 480;
  int inner = 0, rejected = 0, solves = 0;
  for (int i = 0; i < steps; ++i) {
    const StepReport& report = world.step(1.0 / 240);
    inner += report.inner_steps;
    rejected += report.rejected_steps;
    solves += report.force_solves;
  }
  EXPECT_LE(inner, steps + 4);
  EXPECT_LE(rejected, 2);
  EXPECT_GE(solves, 12 * steps);
  EXPECT_LE(solves, 14 * steps + 100);
}

TEST(EventDriven, DoublePendulumKeepsItsEnergyFor100Seconds) {
  World world(by_events());
  const auto upper = add(world, {0.5, 0}, smooth(make_box({1, 0.1})));
  const auto lower = add(world, {1.5, 0}, smooth(make_box({1, 0.1})));
  world.create_joint({.kind = JointKind::Revolute, .b = upper, .anchor_a = {0, 0}, .anchor_b = {0, 0}});
  world.create_joint(
      {.kind = JointKind::Revolute, .a = upper, .b = lower, .anchor_a = {1, 0}, .anchor_b = {1, 0}});
  const double before = world.kinetic_energy() + world.potential_energy();
  double worst = 0;
  for (int i = 0; i < 6000; ++i) {
    const StepReport& report = world.step(1.0 / 60);
    EXPECT_EQ(report.fallbacks, 0);
    worst = std::max(worst, std::abs(report.kinetic_energy + report.potential_energy - before));
  }
  EXPECT_LE(worst, 1e-8);
}

TEST(EventDriven, StackStandsAndIsNotComputedAgainAtRest) {
  World world(by_events());
  add_ground(world, rough(make_disc(1), 0.5));
  std::vector<BodyId> boxes;
  for (int i = 0; i < 10; ++i) boxes.push_back(add(world, {0, i + 0.5}, rough(make_box({1, 1}), 0.5)));
  int fallbacks = 0;
  for (int i = 0; i < 300; ++i) fallbacks += world.step(1.0 / 60).fallbacks;
  EXPECT_EQ(world.report().islands_at_rest, 1);
  for (int i = 0; i < 10; ++i) EXPECT_LE(length(world.position(boxes[i]) - Vec2{0, i + 0.5}), 1e-9);
}

TEST(EventDriven, WhatRestsGivesWayToWhatIsMovedIntoIt) {
  World world(by_events());
  const BodyId table = world.create_body({.type = BodyType::Static, .position = {0, 1}});
  world.add_shape(table, rough(make_box({4, 0.2}), 0.5));
  const BodyId hook = world.create_body({.type = BodyType::Static, .position = {9, 5}});
  const BodyId disc = add(world, {0, 1.6}, rough(make_disc(0.5), 0.5));
  const BodyId weight = add(world, {9, 4}, rough(make_disc(0.5), 0.5));
  world.create_joint({.a = hook, .b = weight, .anchor_a = {9, 5}});
  for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
  ASSERT_EQ(world.velocity(disc), Vec2{});
  ASSERT_EQ(world.velocity(weight), Vec2{});
  world.set_pose(table, {0, 1.1}, 0);
  world.set_pose(hook, {9, 5.1}, 0);
  for (int i = 0; i < 2; ++i) world.step(1.0 / 60);
  EXPECT_NEAR(world.position(disc).y, 1.7, 1e-9);
  EXPECT_NEAR(world.position(weight).y, 4.1, 1e-9);
}

// What accelerates by little more than the rounding of the forces does move.
TEST(EventDriven, SmallForcesMoveWhatIsAtRestBesideHeavyLoads) {
  World world(by_events());
  ShapeDef box = rough(make_box({1, 1}), 0);
  add_ground(world, box);
  const BodyId light = add(world, {0, 0.5}, box, 1), heavy = add(world, {0, 1.5}, box, 1e6);
  // 16 roundings of 1e7 N on 1 kg are 4e-8 m/s^2; the load, turned by 1e-13, pushes with 1e-6 N.
  const double a = 1e-4;
  for (int step = 0; step < 60; ++step) {
    world.apply_force(light, {a, 0}, world.position(light));
    world.step(1.0 / 60);
  }
  EXPECT_NEAR(world.position(light).x, a / 2, 0.05 * a);
  EXPECT_NEAR(world.position(heavy).x, 0, 1e-9);
}

TEST(EventDriven, LetsGoOfTwoPointsAtOnce) {
  // A field that grows lifts a box, or a capsule, off both points: v = g (A (cos w t0 - cos w t) / w - t +
  // t0).
  for (unsigned seed = 0; seed < 30; ++seed) {
    for (const bool box : {true, false}) {
      test::Draw draw(seed);
      const double share = draw.uniform(1.1, 3), omega = draw.uniform(2, 12), mass = draw.uniform(0.5, 3);
      World world(by_events());
      add_ground(world, rough(make_disc(1), 0.5));
      const BodyId body =
          add(world, {0, box ? 0.25 : 0.2},
              rough(box ? make_box({2, 0.5}) : make_capsule({-0.3, 0}, {0.3, 0}, 0.2), 0.5), mass);
      world.set_force_field([=](const FieldSample& sample) {
        return Wrench{{0, share * mass * kG * std::sin(omega * sample.time)}, 0};
      });
      const double lifted = std::asin(1 / share) / omega;
      int fallbacks = 0;
      while (world.time() < lifted + 2.0 / 60) fallbacks += world.step(1.0 / 60).fallbacks;
      const double up = share / omega * (std::cos(omega * lifted) - std::cos(omega * world.time()));
      EXPECT_NEAR(world.velocity(body).y, kG * (up - world.time() + lifted), 1e-11) << "seed " << seed;
      EXPECT_EQ(fallbacks, 0) << "seed " << seed;
    }
  }
}

TEST(EventDriven, HeapFallsWithoutGainingEnergyOrSinkingIn) {
  World world(by_events());
  add_ground(world, rough(make_disc(1), 0.4, 0.3));
  for (int i = 0; i < 12; ++i) {
    const int row = i / 3;
    const Vec2 at{0.3 * (i % 3) + 0.01 * i, 0.6 + 1.1 * row};
    add(world, {at.x * 3, at.y},
        i % 2 == 0 ? rough(make_disc(0.4), 0.4, 0.3) : rough(make_box({0.8, 0.6}), 0.4, 0.3), 1, {}, 0,
        0.3 * i);
  }
  double energy = world.kinetic_energy() + world.potential_energy();
  int by_events_only = 0;
  for (int i = 0; i < 120; ++i) {
    const StepReport& report = world.step(1.0 / 60);
    const double now = report.kinetic_energy + report.potential_energy;
    // Steps that time_stepping had to make are first order across their events.
    if (report.fallbacks == 0) {
      EXPECT_LE(now, energy + 1e-9) << i;
      ++by_events_only;
    }
    // Nor do they find all that meets, where they flow.
    EXPECT_LE(report.worst_penetration, report.islands_in_flow > 0 ? 0.01 : 1e-6) << i;
    energy = now;
  }
  EXPECT_GT(by_events_only, 10);
}

TEST(EventDriven, GivesTheSameBitsForAnyNumberOfThreads) {
  std::uint64_t hash[2];
  for (int run = 0; run < 2; ++run) {
    WorldConfig config = by_events();
    config.threads = run == 0 ? 1 : 3;
    World world(config);
    add_ground(world, rough(make_disc(1), 0.3, 0.4));
    for (int i = 0; i < 8; ++i) {
      add(world, {2.0 * i, 0.6 + 0.1 * i},
          i % 2 == 0 ? rough(make_disc(0.4), 0.3, 0.4) : rough(make_box({0.8, 0.5}), 0.3, 0.4), 1,
          {1.0 + 0.1 * i, 0}, 0.2 * i);
    }
    for (int i = 0; i < 120; ++i) world.step(1.0 / 60);
    hash[run] = world.state_hash();
  }
  EXPECT_EQ(hash[0], hash[1]);
}

TEST(EventDriven, BusyIslandsAreMadeByTimeStepping) {
  WorldConfig config = by_events();
  config.max_impacts_per_step = 2;
  World world(config);
  add_ground(world, smooth(make_disc(1), 0.9));
  const auto ball = add(world, {0, 0.51}, smooth(make_disc(0.5), 0.9));
  int fallbacks = 0;
  for (int i = 0; i < 10; ++i) fallbacks += world.step(0.5).fallbacks;
  EXPECT_GT(fallbacks, 0);
  EXPECT_NEAR(world.position(ball).y, 0.5, 1e-2);
}

// In a pyramid whose boxes touch side by side forces are shared in many ways: what moves a little has forces
// so rough that error control went on in steps of nanoseconds, up to the largest work (the slowest step took
// 13 738 solves).
TEST(EventDriven, ForcesTooRoughToFollowAreGivenUpSoon) {
  World world(by_events({.gravity = {0, -10}}));
  add_ground(world, rough(make_half_plane({0, 0}, {0, 1}), 0.5));
  std::vector<BodyId> boxes;
  for (int row = 0; row < 5; ++row) {
    for (int i = 0; i < 5 - row; ++i)
      boxes.push_back(add(world, {i + 0.5 * row - 2.5, row + 0.5}, rough(make_box({1, 1}), 0.5)));
  }
  for (const BodyId box : boxes) world.set_mass(box, 1, 1.0 / 6);
  for (const double side : {-1.0, 1.0}) {
    const BodyId wall =
        world.create_body({.type = BodyType::Static, .position = {side * 8, 0}, .angle = side * kPi / 2});
    world.add_shape(wall, rough(make_half_plane({0, 0}, {0, 1}), 0.5));
  }
  std::mt19937 random(3);
  int most = 0;
  for (int i = 0; i <= 64; ++i) {
    if (i <= 60 && i % 4 == 0) {
      const BodyId box = boxes[random() % 15];
      const double angle = random() / 4294967296.0 * 2 * kPi;
      world.apply_impulse(box, 0.1 * Vec2{std::cos(angle), std::sin(angle)}, world.position(box));
    }
    most = std::max(most, world.step(1.0 / 60).force_solves);
  }
  EXPECT_LT(most, 4000);
  EXPECT_GT(most, 100);  // it does try
}

}  // namespace event_driven_test
}  // namespace skerry
