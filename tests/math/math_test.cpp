// SPDX-License-Identifier: MIT
#include "physics/math.h"

#include <gtest/gtest.h>
#include <random>

namespace skerry {
namespace math_test {

TEST(SinCos, AgreesWithLongDoubleToOneUlp) {
  const unsigned seed = 20261121;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> exponent(-20, 5.9);
  for (int i = 0; i < 200000; ++i) {
    const double angle = std::pow(10.0, exponent(random)) * (i % 2 ? 1 : -1);
    const SinCos sc = sin_cos(angle);
    const long double s = std::sin(static_cast<long double>(angle));
    const long double c = std::cos(static_cast<long double>(angle));
    // Near a zero of the function the reduction's rounding counts against 1, not against the tiny value.
    ASSERT_NEAR(static_cast<double>(sc.sin - s), 0, 1.2e-16 + 1.2e-16 * std::abs(static_cast<double>(s)))
        << angle << " seed " << seed;
    ASSERT_NEAR(static_cast<double>(sc.cos - c), 0, 1.2e-16 + 1.2e-16 * std::abs(static_cast<double>(c)))
        << angle << " seed " << seed;
  }
}

TEST(SinCos, IsExactAtZeroAndOddAndNotANumberForNonFiniteAngles) {
  EXPECT_EQ(sin_cos(0).sin, 0);
  EXPECT_EQ(sin_cos(0).cos, 1);
  EXPECT_EQ(sin_cos(0.7).sin, -sin_cos(-0.7).sin);
  EXPECT_EQ(sin_cos(0.7).cos, sin_cos(-0.7).cos);
  EXPECT_TRUE(std::isnan(sin_cos(kInfinity).sin));
  EXPECT_TRUE(std::isnan(sin_cos(std::nan("")).cos));
}

TEST(SinCos, StaysOnTheUnitCircle) {
  for (double angle = -7; angle < 7; angle += 1e-3) {
    const Rot q = Rot::from_angle(angle);
    ASSERT_NEAR(q.c * q.c + q.s * q.s, 1, 4e-16);
  }
}

TEST(Transform, ToLocalUndoesToWorld) {
  const Transform pose{{3, -2}, Rot::from_angle(0.3)};
  const Vec2 p{0.25, 7};
  EXPECT_NEAR(length(to_local(pose, to_world(pose, p)) - p), 0, 1e-14);
}

TEST(Perp, TurnsCounterClockwise) {
  EXPECT_EQ(perp(Vec2{1, 0}), (Vec2{0, 1}));
  EXPECT_EQ(cross(Vec2{1, 0}, Vec2{0, 1}), 1);
}

}  // namespace math_test
}  // namespace skerry
