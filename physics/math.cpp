// SPDX-License-Identifier: MIT
#include "physics/math.h"

namespace skerry {
namespace {

// pi/2 in three parts: the first two have 33 significant bits, so that k * part is exact for |k| < 2^20
// [Cody & Waite 1980, ch. 8].
constexpr double kHalfPi1 = 0x1.921fb544p+0;
constexpr double kHalfPi2 = 0x1.0b4611a6p-34;
constexpr double kHalfPi3 = 0x1.3198a2e037073p-69;

// Taylor sums: on |r| <= pi/4 the first neglected term is below 1e-19 of the value.
double sine_kernel(double r) {
  const double z = r * r;
  double sum = 1.0 / 355687428096000.0;  // 1/17!
  sum = sum * z - 1.0 / 1307674368000.0;
  sum = sum * z + 1.0 / 6227020800.0;
  sum = sum * z - 1.0 / 39916800.0;
  sum = sum * z + 1.0 / 362880.0;
  sum = sum * z - 1.0 / 5040.0;
  sum = sum * z + 1.0 / 120.0;
  sum = sum * z - 1.0 / 6.0;
  return r + r * (z * sum);
}

double cosine_kernel(double r) {
  const double z = r * r;
  double sum = 1.0 / 6402373705728000.0;  // 1/18!
  sum = -sum * z + 1.0 / 20922789888000.0;
  sum = sum * z - 1.0 / 87178291200.0;
  sum = sum * z + 1.0 / 479001600.0;
  sum = sum * z - 1.0 / 3628800.0;
  sum = sum * z + 1.0 / 40320.0;
  sum = sum * z - 1.0 / 720.0;
  sum = sum * z + 1.0 / 24.0;
  // 1 - z/2 rounds; what it loses is added back with the small terms.
  const double half = 0.5 * z;
  const double head = 1.0 - half;
  return head + (((1.0 - head) - half) + z * z * sum);
}

}  // namespace

SinCos sin_cos(double angle) {
  if (!std::isfinite(angle)) return {angle - angle, angle - angle};
  // Beyond 2^20 quarter turns the reduction below loses bits; a body that turned so often is reduced exactly
  // first.
  if (!(std::abs(angle) < 1.0e6)) angle = std::remainder(angle, 2 * kPi);
  const double k = std::nearbyint(angle * (2 / kPi));
  const double r = ((angle - k * kHalfPi1) - k * kHalfPi2) - k * kHalfPi3;
  const double s = sine_kernel(r);
  const double c = cosine_kernel(r);
  switch (static_cast<long long>(k) & 3) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

}  // namespace skerry
