// SPDX-License-Identifier: MIT
#include "physics/narrowphase/collide.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

namespace skerry {
namespace collide_test {

Transform at(double x, double y, double angle = 0) {
  return {{x, y}, Rot::from_angle(angle)};
}

TEST(Collide, GivesBothPointsOfTwoBoxesFaceToFaceExactly) {
  const Shape box = make_box({1, 1});
  const Manifold m = collide(box, at(0, 0), box, at(0, 0.96875), 0.005);
  ASSERT_EQ(m.count, 2);
  EXPECT_EQ(m.normal, (Vec2{0, 1}));
  EXPECT_EQ(m.points[0].separation, -0.03125);
  EXPECT_EQ(m.points[1].separation, -0.03125);
  EXPECT_EQ(m.points[0].position.y, 0.484375);
  EXPECT_EQ(std::abs(m.points[0].position.x), 0.5);
  EXPECT_EQ(m.points[0].position.x, -m.points[1].position.x);
}

TEST(Collide, GivesOnePointForACornerOnAnEdge) {
  const Shape box = make_box({1, 1});
  const Manifold m = collide(box, at(0, 0), box, at(0.1, 0.5 + std::sqrt(0.5) - 0.01, kPi / 4), 0.005);
  ASSERT_EQ(m.count, 1);
  EXPECT_NEAR(m.points[0].separation, -0.01, 1e-15);
  EXPECT_NEAR(m.points[0].position.x, 0.1, 1e-15);
}

TEST(Collide, ReportsNearPairsByClosestCorners) {
  const Shape box = make_box({1, 1});
  const Manifold m = collide(box, at(0, 0), box, at(1.003, 1.004), 0.01);
  ASSERT_EQ(m.count, 1);
  EXPECT_NEAR(m.points[0].separation, 0.005, 1e-15);
  EXPECT_NEAR(m.normal.x, 0.6, 1e-12);
  EXPECT_NEAR(m.normal.y, 0.8, 1e-12);
}

TEST(Collide, MeetsEveryPairOfKinds) {
  const std::vector<Shape> shapes = {make_disc(0.5), make_capsule({-0.25, 0}, {0.25, 0}, 0.5),
                                     make_box({1, 1}), make_box({1, 1}, {}, 0, 0.1)};
  for (const Shape& a : shapes) {
    for (const Shape& b : shapes) {
      const Manifold m = collide(a, at(3, 0), b, at(3, 0.9), 0);
      ASSERT_GE(m.count, 1);
      EXPECT_EQ(m.normal, (Vec2{0, 1}));
      EXPECT_NEAR(m.points[0].separation, -0.1, 1e-15);
      EXPECT_NEAR(m.points[0].position.y, 0.45, 1e-15);
      EXPECT_EQ(collide(a, at(3, 0), b, at(3, 1.1), 0.05).count, 0);
    }
    const Manifold ground = collide(make_half_plane({0, 0}, {0, 2}), at(0, 1), a, at(7, 1.4), 0);
    ASSERT_GE(ground.count, 1);
    EXPECT_EQ(ground.normal, (Vec2{0, 1}));
    EXPECT_NEAR(ground.points[0].separation, -0.1, 1e-15);
    EXPECT_NEAR(ground.points[0].position.y, 0.95, 1e-15);
  }
}

/// Of a small box that is tilted, its lowest corner 2 mm above the line of the upper side of a large one, and
/// as far beyond its end as `beyond` [m] says.
Manifold meet_at_an_end(double side, double tilt, double beyond, bool exchanged) {
  const Shape large = make_box({0.1, 0.1}), small = make_box({0.03, 0.02});
  const Rot turned = Rot::from_angle(-side * tilt);
  const Vec2 lowest{side * (0.05 + beyond), 0.052};
  const Transform pose{lowest - rotate(turned, {side * 0.015, -0.01}), turned};
  return exchanged ? collide(small, pose, large, {}, 0.006) : collide(large, {}, small, pose, 0.006);
}

TEST(Collide, ACornerThatPassesTheEndOfAnEdgeKeepsTheOtherPointAndTheirOrder) {
  for (const double tilt : {0.02, 0.05, 0.08, 0.12}) {
    for (const double side : {1.0, -1.0}) {
      for (const bool exchanged : {false, true}) {
        const double first = meet_at_an_end(side, tilt, -20e-6, exchanged).points[0].position.x;
        for (int k = -20; k <= 20; ++k) {
          const Manifold there = meet_at_an_end(side, tilt, 1e-6 * k, exchanged);
          ASSERT_EQ(there.count, 2) << tilt << ", " << k;
          EXPECT_NEAR(there.points[0].position.x, first, 1e-3) << tilt << ", " << side << ", " << exchanged;
          if (exchanged) continue;
          const auto [least, most] = std::minmax({there.points[0].separation, there.points[1].separation});
          EXPECT_NEAR(least, 0.002, 1e-6) << tilt << ", " << k;
          EXPECT_NEAR(most, 0.002 + 0.03 * std::sin(tilt), 1e-4) << tilt << ", " << k;
        }
      }
    }
  }
}

/// Where the end of an edge lies on the other's inside by rounding, the normal is that of the other one.
TEST(Collide, ACornerOnAnEdgeNextToItsEndHasTheNormalOfTheEdge) {
  const Shape box = make_box({1, 1});
  for (const double turn : {0.02, 0.1, 0.3, 0.6}) {
    for (const double beyond : {5e-16, 1e-15, 2e-15, 4e-15}) {
      // The lower right corner of the first one is on the left edge of the other, which leans away.
      Transform pose{{0, 0}, Rot::from_angle(-turn)};
      pose.p = Vec2{0.5, -0.5} - rotate(pose.q, {-0.5, -0.5 + beyond});
      const Manifold there = collide(box, {{0, 0}, {}}, box, pose, 0.005);
      ASSERT_GE(there.count, 1);
      EXPECT_LE(length(there.normal - rotate(pose.q, {1, 0})), 1e-12) << turn << ", " << beyond;
    }
  }
}

TEST(Collide, WithACacheAPlankThatTurnsMeetsWhatItsAxisKeptApart) {
  const Shape plank = make_box({20, 0.2}), box = make_box({0.4, 0.4});
  for (const double x : {9.0, -9.0}) {
    for (const bool plank_first : {true, false}) {
      SatCache cache;
      const auto count = [&](double angle) {
        const Transform turned = at(0, 0, angle), there = at(x, 1);
        return plank_first ? collide(plank, turned, box, there, 0.01, &cache).count
                           : collide(box, there, plank, turned, 0.01, &cache).count;
      };
      for (int k = 0; k < 3; ++k) EXPECT_EQ(count(0), 0);
      EXPECT_GT(count(x > 0 ? 0.1 : -0.1), 0) << x << ' ' << plank_first;
    }
  }
}

}  // namespace collide_test
}  // namespace skerry
