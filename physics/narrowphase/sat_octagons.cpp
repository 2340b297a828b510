// SPDX-License-Identifier: MIT
//
// Separations of two octagons, four edges in the registers of AVX2 where the processor has them; otherwise
// two edges in those that every processor has. Lane by lane it is the same arithmetic.
#include "physics/narrowphase/avx2.h"
#include "physics/narrowphase/sat_search.h"

namespace skerry::narrow {
namespace {

#if defined(SKERRY_MAY_USE_AVX2)
SKERRY_AVX2_BEGIN
namespace avx2 {
#define SKERRY_FOUR_AVX2 1
#include "physics/narrowphase/four_lanes.h"
#undef SKERRY_FOUR_AVX2

inline Points neighbours(const Vec2* v) {
  return points(&v[0].x, &v[1].x, &v[2].x, &v[3].x);
}

void separations(const Vec2* n, const Vec2* v, const Vec2* corners, double* out) {
  const Points n0 = neighbours(n), n1 = neighbours(n + 4), v0 = neighbours(v), v1 = neighbours(v + 4);
  const Four x = Four::both(corners[0].x), y = Four::both(corners[0].y);
  Four low0 = n0.x * x + n0.y * y, low1 = n1.x * x + n1.y * y;
#pragma GCC unroll 8
  for (int j = 1; j < 8; ++j) {
    const Four cx = Four::both(corners[j].x), cy = Four::both(corners[j].y);
    low0 = lesser(n0.x * cx + n0.y * cy, low0);
    low1 = lesser(n1.x * cx + n1.y * cy, low1);
  }
  (low0 - (n0.x * v0.x + n0.y * v0.y)).store(out);
  (low1 - (n1.x * v1.x + n1.y * v1.y)).store(out + 4);
}

}  // namespace avx2
SKERRY_AVX2_END
#endif

}  // namespace

bool octagon_separations([[maybe_unused]] const Vec2* n, [[maybe_unused]] const Vec2* v,
                         [[maybe_unused]] const Vec2* corners, [[maybe_unused]] double* out) {
#if defined(SKERRY_MAY_USE_AVX2)
  if (has_avx2()) {
    avx2::separations(n, v, corners, out);
    return true;
  }
#endif
  return false;
}

}  // namespace skerry::narrow
