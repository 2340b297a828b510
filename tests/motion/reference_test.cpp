// SPDX-License-Identifier: MIT
//
// Published results for time stepping at 60 Hz; the tolerance is what the method deserves in each.
#include <cmath>
#include <gtest/gtest.h>

#include "tests/support/worlds.h"

namespace skerry {
namespace reference_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;
using test::weightless;

constexpr double kStep = 1.0 / 60;

TEST(Incline, BoxSlidesWithGSinMinusMuGCos) {
  const double angle = kPi / 6, mu = 0.3, g = 9.81;
  World world;
  add_ground(world, rough(make_disc(1), mu), -angle);
  const Rot q = Rot::from_angle(-angle);
  const auto box = add(world, rotate(q, {0, 0.5}), rough(make_box({1, 1}), mu), 1, {}, 0, -angle);
  for (int i = 0; i < 120; ++i) world.step(kStep);
  const double exact = 0.5 * g * (std::sin(angle) - mu * std::cos(angle)) * 4;
  EXPECT_NEAR(dot(world.position(box), rotate(q, {1, 0})), exact, 1e-6 * exact);
}

TEST(Incline, BoxSticksBelowTheFrictionAngleWithoutDrift) {
  const double angle = kPi / 6;
  World world;
  add_ground(world, rough(make_disc(1), 0.6), -angle);
  const Rot q = Rot::from_angle(-angle);
  const Vec2 start = rotate(q, {0, 0.5});
  const auto box = add(world, start, rough(make_box({1, 1}), 0.6), 1, {}, 0, -angle);
  for (int i = 0; i < 600; ++i) world.step(kStep);
  EXPECT_LE(length(world.position(box) - start), 1e-9);
}

TEST(Incline, DiscRollsWithTwoThirdsAndSlidesWhenTheSlopeIsTooSteep) {
  for (const auto& [angle, mu] : {std::pair(kPi / 6, 0.5), std::pair(kPi / 3, 0.2)}) {
    World world;
    add_ground(world, rough(make_disc(1), mu), -angle);
    const Rot q = Rot::from_angle(-angle);
    const auto disc = add(world, rotate(q, {0, 0.5}), rough(make_disc(0.5), mu), 1);
    for (int i = 0; i < 120; ++i) world.step(kStep);
    const bool rolls = std::tan(angle) <= 3 * mu;
    const double a =
        rolls ? 2.0 / 3 * 9.81 * std::sin(angle) : 9.81 * (std::sin(angle) - mu * std::cos(angle));
    const double alpha = rolls ? a / 0.5 : 2 * mu * 9.81 * std::cos(angle) / 0.5;
    EXPECT_NEAR(dot(world.position(disc), rotate(q, {1, 0})), 2 * a, 1e-6 * 2 * a);
    EXPECT_NEAR(world.omega(disc), -2 * alpha, 1e-6 * 2 * alpha);
  }
}

TEST(Bowling, SlidingDiscRollsInTheEndWithTwoThirdsOfItsSpeed) {
  World world;
  add_ground(world, rough(make_disc(1), 0.2));
  const auto disc = add(world, {0, 0.5}, rough(make_disc(0.5), 0.2), 1, {3, 0});
  for (int i = 0; i < 120; ++i) world.step(kStep);
  // The onset of rolling falls inside one step, which is cut there.
  EXPECT_NEAR(world.velocity(disc).x, 2, 1e-12);
  EXPECT_NEAR(world.omega(disc), -4, 1e-12);
}

TEST(Ladder, SmoothLadderFollowsEnergyUntilItLeavesTheWall) {
  // Uniform ladder on smooth floor and wall: leaves the wall at sin t = (2/3) sin t0, t the angle to the
  // floor.
  World world;
  const double t0 = 1.0;
  const auto fixed = world.create_body({.type = BodyType::Static});
  world.add_shape(fixed, smooth(make_half_plane({0, 0}, {0, 1})));
  world.add_shape(fixed, smooth(make_half_plane({0, 0}, {1, 0})));
  const double half = 1, r = 1e-4;
  const auto ladder = world.create_body({.position = {half * std::cos(t0) + r, half * std::sin(t0) + r},
                                         .angle = kPi - t0,
                                         .mass = 1.0,
                                         .inertia = 1.0 / 3});
  world.add_shape(ladder, smooth(make_capsule({-half, 0}, {half, 0}, r)));
  double leaving = 0;
  for (int i = 0; i < 2000 && leaving == 0; ++i) {
    world.step(1e-3);
    const double x = world.position(ladder).x, y = world.position(ladder).y;
    if (x - r - half * std::abs(std::cos(world.angle(ladder))) > 1e-7) leaving = (y - r) / half;
  }
  EXPECT_NEAR(leaving, 2.0 / 3 * std::sin(t0), 5e-3);
}

TEST(RockingBlock, LosesHousnersShareAtEachImpact) {
  for (const auto& [slender, ratio] : {std::pair(2.0, 0.7), std::pair(4.0, 0.91176470588)}) {
    World world;
    add_ground(world, rough(make_disc(1), 10));
    const double b = 0.5, h = b * slender;
    const double tilt = 0.02;
    // The block stands on its right corner, leaning to the right... pivot at the origin.
    const Rot q = Rot::from_angle(-tilt);
    const auto block = add(world, rotate(q, {-b, h}), rough(make_box({2 * b, 2 * h}), 10), 1, {}, 0, -tilt);
    double before = 0, after = 0;
    for (int i = 0; i < 400 && after == 0; ++i) {
      const double w = world.omega(block);
      const StepReport& report = world.step(1.0 / 240);
      if (report.impacts > 0 && w > 0.01) {
        before = w;
        after = world.omega(block);
      }
    }
    EXPECT_NEAR(after / before, ratio, 0.03) << slender;
  }
}

TEST(Galperin, CollisionsCountTheDigitsOfPi) {
  for (const auto& [ratio, count] : {std::pair(1.0, 3), std::pair(100.0, 31), std::pair(1e4, 314)}) {
    World world(weightless());
    const auto wall = world.create_body({.type = BodyType::Static});
    world.add_shape(wall, smooth(make_half_plane({0, 0}, {1, 0}), 1));
    add(world, {1, 0}, smooth(make_box({0.5, 0.5}), 1), 1);
    add(world, {3, 0}, smooth(make_box({1, 1}), 1), ratio, {-1, 0});
    int impacts = 0;
    for (int i = 0; i < 6000; ++i) impacts += world.step(1.0 / 600).impacts;
    EXPECT_EQ(impacts, count) << "mass ratio " << ratio;
  }
}

TEST(Restitution, BouncesFollowESquared) {
  World world;
  add_ground(world, smooth(make_disc(1), 0.8));
  const auto ball = add(world, {0, 2.5}, smooth(make_disc(0.5), 0.8));
  int bounces = 0;
  while (bounces < 5) bounces += world.step(kStep).impacts;
  const double v = world.velocity(ball).y;
  EXPECT_NEAR(world.position(ball).y - 0.5 + v * v / (2 * 9.81), 2 * std::pow(0.64, 5), 1e-9);
}

TEST(Restitution, BallComesToRestAtTheZenoTime) {
  World world;
  add_ground(world, smooth(make_disc(1), 0.5));
  const auto ball = add(world, {0, 1.5}, smooth(make_disc(0.5), 0.5));
  const double rest = std::sqrt(2 / 9.81) * (1 + 0.5) / (1 - 0.5);
  double stopped = 0;
  for (int i = 0; i < 200 && stopped == 0; ++i) {
    world.step(kStep);
    if (world.velocity(ball).y == 0 || std::abs(world.velocity(ball).y) < 1e-9) stopped = world.time();
  }
  EXPECT_NEAR(stopped, rest, kStep + 1e-6);
  EXPECT_NEAR(world.position(ball).y, 0.5, 1e-9);
}

TEST(Garwin, DiscOnARoughFloorSticksOrSlipsInTheImpact) {
  for (const double e : {0.0, 0.5, 1.0}) {
    for (const double ut : {0.5, 2.0, 8.0}) {
      const double mu = 0.3;
      World world(weightless());
      add_ground(world, rough(make_disc(1), mu, e));
      const auto disc = add(world, {0, 0.5}, rough(make_disc(0.5), mu, e), 1, {ut, -1});
      world.step(1e-6);
      const double limit = 3 * mu * (1 + e);
      const double expected = ut <= limit ? ut * 2 / 3 : ut - mu * (1 + e);
      EXPECT_NEAR(world.velocity(disc).x, expected, 1e-12) << "e " << e << " ut " << ut;
      EXPECT_NEAR(world.velocity(disc).y, e, 1e-12);
    }
  }
}

class StackOf : public testing::TestWithParam<int> {};

TEST_P(StackOf, StandsForTenSecondsWithoutDrift) {
  const int count = GetParam();
  // Solved at every step, though nothing moves.
  WorldConfig config;
  config.sleep = false;
  config.reuse_resting = false;
  World world(config);
  add_ground(world, rough(make_disc(1), 0.5));
  std::vector<BodyId> boxes;
  for (int i = 0; i < count; ++i) boxes.push_back(add(world, {0, i + 0.5}, rough(make_box({1, 1}), 0.5)));
  for (int i = 0; i < 600; ++i) {
    const StepReport& report = world.step(kStep);
    ASSERT_EQ(report.inexact_islands, 0) << "step " << i << " residual " << report.worst_residual;
    ASSERT_EQ(report.islands_at_rest, 0);
    ASSERT_LE(report.worst_penetration, 1e-9) << "step " << i;
  }
  for (int i = 0; i < count; ++i) {
    EXPECT_LE(length(world.position(boxes[i]) - Vec2{0, i + 0.5}), 1e-6);
    EXPECT_LE(std::abs(world.angle(boxes[i])), 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Stack, StackOf, testing::Values(3, 10, 30));

TEST(MassRatio, HeavyBoxStandsOnTenLightOnes) {
  for (const double ratio : {1e3, 1e6}) {
    World world;
    add_ground(world, rough(make_disc(1), 0.5));
    for (int i = 0; i < 10; ++i) add(world, {0, i + 0.5}, rough(make_box({1, 1}), 0.5));
    const auto heavy = add(world, {0, 10.5}, rough(make_box({1, 1}), 0.5), ratio);
    for (int i = 0; i < 300; ++i) world.step(kStep);
    EXPECT_NEAR(world.position(heavy).y, 10.5, 1e-6) << ratio;
    EXPECT_NEAR(world.position(heavy).x, 0, 1e-6) << ratio;
    EXPECT_LE(world.report().worst_penetration, 1e-9) << ratio;
  }
}

// A light box between the ground and a heavy one: the forces on it balance but for their rounding, which
// moves it by 1e-9 m/s^2 and more. Nobody follows that: not the integration of events, which took 5000 solves
// a step for it, and not the positions.
class MassRatioBy : public testing::TestWithParam<const char*> {};

TEST_P(MassRatioBy, HeavyOnLightIsAtRestToTheBitAtAnyRatio) {
  for (const double ratio : {1e3, 1e6, 1e7, 1e8, 1e9}) {
    for (const int light : {1, 3, 10}) {
      WorldConfig config;
      config.stepper = GetParam();
      config.sleep = false;
      World world(config);
      const ShapeDef box = rough(make_box({1, 1}), 0.5);
      add_ground(world, box);
      std::vector<BodyId> bodies;
      for (int i = 0; i <= light; ++i)
        bodies.push_back(add(world, {0, 0.5 + i}, box, i == light ? ratio : 1));
      int solves = 0;
      for (int step = 0; step < 60; ++step) solves += world.step(kStep).force_solves;
      EXPECT_LT(solves, 400) << "ratio " << ratio << ", " << light << " below";
      EXPECT_EQ(world.report().islands_at_rest, 1) << "ratio " << ratio << ", " << light << " below";
      for (int i = 0; i <= light; ++i) {
        const Vec2 at = world.position(bodies[static_cast<std::size_t>(i)]);
        EXPECT_LT(length(at - Vec2{0, 0.5 + i}), 1e-12) << "ratio " << ratio << ", box " << i;
      }
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Steppers, MassRatioBy, testing::Values("time_stepping", "event_driven", "auto"));

TEST(Overhang, TenPlanksFlipBetween0999And1001OfTheHarmonicLimit) {
  for (const double share : {0.999, 1.001}) {
    World world;
    add_ground(world, rough(make_disc(1), 0.5));
    const int count = 10;
    const double half = 1, height = 0.2;
    // From the top, plank k overhangs the next by half / k; the lowest stands on a fixed table.
    const auto table = world.create_body({.type = BodyType::Static});
    world.add_shape(table, rough(make_box({2 * half, 1}, {-half, 0.5}), 0.5));
    std::vector<BodyId> planks(count);
    double edge = 0;
    for (int k = count; k >= 1; --k) {
      edge += share * half / k;
      planks[k - 1] =
          add(world, {edge - half, 1 + (count - k + 0.5) * height}, rough(make_box({2 * half, height}), 0.5));
    }
    const double top = world.position(planks[0]).y;
    for (int i = 0; i < 600; ++i) world.step(kStep);
    if (share < 1) {
      EXPECT_NEAR(world.position(planks[0]).y, top, 1e-6);
    } else {
      EXPECT_LT(world.position(planks[0]).y, top - 1e-4);
    }
  }
}

}  // namespace reference_test
}  // namespace skerry
