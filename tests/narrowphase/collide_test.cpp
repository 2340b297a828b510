// SPDX-License-Identifier: MIT
#include "physics/narrowphase/collide.h"

#include <gtest/gtest.h>

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
  const Shape shapes[] = {make_disc(0.5), make_capsule({-0.25, 0}, {0.25, 0}, 0.5), make_box({1, 1}),
                          make_box({1, 1}, {}, 0, 0.1)};
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

}  // namespace collide_test
}  // namespace skerry
