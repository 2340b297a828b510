// SPDX-License-Identifier: MIT
//
// A disc that rolls in a cylindrical bowl: T = 2 pi sqrt(3 (R - r) / (2 g)) for small swings. The library has
// no concave arc: the rolling is a gear here (the same equations, without contact), and a chain of straight
// segments.
#include <cmath>
#include <gtest/gtest.h>

#include "tests/support/worlds.h"

namespace skerry {
namespace bowl_test {

using test::add;
using test::rough;
using test::smooth;

constexpr double kG = 9.81;
constexpr double kBowl = 2, kDisc = 0.25, kPath = kBowl - kDisc;

/// Period of a pendulum of this reduced length that swings to `start` [rad].
double period(double start, double reduced = 1.5 * kPath) {
  double a = 1, g = std::cos(start / 2);
  for (int i = 0; i < 20; ++i) {
    const double mean = 0.5 * (a + g);
    g = std::sqrt(a * g);
    a = mean;
  }
  return 2 * kPi / a * std::sqrt(reduced / kG);
}

TEST(Bowl, RollingDiscHasThePeriodOfTheReducedLengthByEvents) {
  // An arm, balanced at its axis, leads the disc's centre round that of the bowl, and an internal gear turns
  // it: angle of the disc = -(R - r)/r angle of the arm. The arm's inertia adds to the reduced length.
  const double start = 0.1, inertia = 0.01;
  WorldConfig config;
  config.stepper = "event_driven";
  World world(config);
  const Vec2 at{kPath * std::sin(start), -kPath * std::cos(start)};
  const auto arm = world.create_body({.position = {0, 0}, .mass = 1.0, .inertia = inertia});
  const auto disc = add(world, at, smooth(make_disc(kDisc)));
  world.create_joint({.b = arm, .anchor_a = {0, 0}});
  world.create_joint({.a = arm, .b = disc, .anchor_a = at});
  world.create_joint({.kind = JointKind::Gear, .a = arm, .b = disc, .ratio = kPath / kDisc});
  // Without the arm, and for small swings, it is the formula.
  EXPECT_NEAR(period(1e-9) / (2 * kPi * std::sqrt(3 * kPath / (2 * kG))), 1, 1e-15);
  const double t = period(start, 1.5 * kPath + inertia / kPath);
  for (int i = 0; i < 100; ++i) ASSERT_EQ(world.step(t / 100).fallbacks, 0) << i;
  EXPECT_NEAR(length(world.position(disc) - at), 0, 1e-11);
  EXPECT_NEAR(length(world.velocity(disc)), 0, 1e-11);
}

/// Error of the period in a bowl of straight segments, each of `angle` [rad].
double segmented(double angle) {
  World world;
  const auto bowl = world.create_body({.type = BodyType::Static});
  // Corners outside the circle by as much as the middles of the segments are inside.
  std::vector<Vec2> corners;
  const double radius = kBowl * 2 / (1 + std::cos(0.5 * angle));
  for (int i = -static_cast<int>(0.6 / angle); i <= static_cast<int>(0.6 / angle); ++i)
    corners.push_back({radius * std::sin((i + 0.5) * angle), -radius * std::cos((i + 0.5) * angle)});
  world.add_shape(bowl, rough(make_chain(corners, false), 1));
  const double start = 0.1;
  const auto disc =
      add(world, {kPath * std::sin(start), -kPath * std::cos(start)}, rough(make_disc(kDisc), 1));
  // The half swing ends where the disc turns back.
  const double h = period(start) / 400;
  double before = 0;
  for (int i = 0; i < 400; ++i) {
    world.step(h);
    const double v = world.velocity(disc).x;
    if (i > 100 && before < 0 && v >= 0) return 2 * (i + before / (before - v)) * h / period(start) - 1;
    before = v;
  }
  return 1;
}

TEST(Bowl, OfStraightSegmentsComesNearThePeriod) {
  const double error = segmented(0.002);
  std::printf("bowl of segments of 2 mrad: relative error of the period %.1e\n", error);
  EXPECT_NEAR(error, 0, 1e-3);
}

}  // namespace bowl_test
}  // namespace skerry
