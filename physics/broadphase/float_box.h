// SPDX-License-Identifier: MIT
//
// Boxes in single precision that are compared with one instruction, and exactly. Subtracting an origin and
// rounding to single precision keeps the order (a <= b gives f(a) <= f(b)), so f(a) < f(b) proves a < b, and
// f(a) > f(b) proves a > b; only ties need the doubles.
#pragma once

#include <cfloat>
#include <cstdint>

#include "physics/cpu.h"
#include "physics/math.h"
#if defined(__x86_64__) && defined(__GNUC__)
#include <immintrin.h>
#define SKERRY_WIDE_TESTS
#elif defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace skerry {

/// A stored box: lower x, lower y, minus upper x, minus upper y, all relative to an origin. Two boxes overlap
/// where no number of one is above the matching limit of the other.
struct alignas(16) FloatBox {
  float v[4];
};

/// Asks the processor to fetch what will be needed soon.
inline void prefetch([[maybe_unused]] const void* address) {
#if defined(__SSE2__)
  _mm_prefetch(static_cast<const char*>(address), _MM_HINT_T0);
#endif
}

/// What a comparison says.
struct FloatOverlap {
  bool maybe;    ///< no number is above its limit: the boxes overlap unless a tie deceives
  bool certain;  ///< all numbers are below their limits: the boxes overlap
};

/// A box that no limit lets pass: the mark of an unused place.
inline constexpr FloatBox kNoFloatBox{
    {float(kInfinity), float(kInfinity), float(kInfinity), float(kInfinity)}};

#if defined(__SSE2__)

/// The numbers of a box, each finite, so that `kNoFloatBox` is above all limits.
inline __m128 float_numbers(const Aabb& box, Vec2 origin) {
  const __m128d o = _mm_set_pd(origin.y, origin.x);
  const __m128 lower = _mm_cvtpd_ps(_mm_sub_pd(_mm_set_pd(box.lower.y, box.lower.x), o));
  const __m128 upper = _mm_cvtpd_ps(_mm_sub_pd(_mm_set_pd(box.upper.y, box.upper.x), o));
  const __m128 numbers = _mm_movelh_ps(lower, _mm_xor_ps(upper, _mm_set1_ps(-0.0f)));
  return _mm_max_ps(_mm_min_ps(numbers, _mm_set1_ps(FLT_MAX)), _mm_set1_ps(-FLT_MAX));
}
inline void store(FloatBox& to, const Aabb& box, Vec2 origin) {
  _mm_store_ps(to.v, float_numbers(box, origin));
}

/// True if a box lies within `outer` for certain.
inline bool is_within(const FloatBox& outer, const FloatBox& box) {
  return _mm_movemask_ps(_mm_cmplt_ps(_mm_load_ps(outer.v), _mm_load_ps(box.v))) == 15;
}
/// Where a box that went from `before` to `now` will be after `steps` more such moves, about.
inline FloatBox ahead_of(const FloatBox& before, const FloatBox& now, float steps) {
  const __m128 here = _mm_load_ps(now.v);
  FloatBox there;
  _mm_store_ps(there.v,
               _mm_add_ps(here, _mm_mul_ps(_mm_set1_ps(steps), _mm_sub_ps(here, _mm_load_ps(before.v)))));
  return there;
}

/// The limits that another box's numbers must keep to overlap this one: upper x, upper y, minus lower x, y.
class FloatLimits {
 public:
  FloatLimits(const Aabb& box, Vec2 origin) : FloatLimits(float_numbers(box, origin)) {}
  explicit FloatLimits(const FloatBox& box) : FloatLimits(_mm_load_ps(box.v)) {}
  FloatOverlap compare(const FloatBox& other) const {
    const __m128 numbers = _mm_load_ps(other.v);
    return {_mm_movemask_ps(_mm_cmple_ps(numbers, limits_)) == 15,
            _mm_movemask_ps(_mm_cmplt_ps(numbers, limits_)) == 15};
  }

  __m128 values() const { return limits_; }

 private:
  explicit FloatLimits(__m128 numbers)
      : limits_(_mm_xor_ps(_mm_shuffle_ps(numbers, numbers, _MM_SHUFFLE(1, 0, 3, 2)), _mm_set1_ps(-0.0f))) {}
  __m128 limits_;
};

#else

inline float float_number(double value) {
  return static_cast<float>(std::clamp(value, double(-FLT_MAX), double(FLT_MAX)));
}
inline void store(FloatBox& to, const Aabb& box, Vec2 origin) {
  to = {{float_number(box.lower.x - origin.x), float_number(box.lower.y - origin.y),
         -float_number(box.upper.x - origin.x), -float_number(box.upper.y - origin.y)}};
}

inline bool is_within(const FloatBox& outer, const FloatBox& box) {
  bool within = true;
  for (int i = 0; i < 4; ++i) within &= outer.v[i] < box.v[i];
  return within;
}
inline FloatBox ahead_of(const FloatBox& before, const FloatBox& now, float steps) {
  FloatBox there;
  for (int i = 0; i < 4; ++i) there.v[i] = now.v[i] + steps * (now.v[i] - before.v[i]);
  return there;
}

class FloatLimits {
 public:
  FloatLimits(const Aabb& box, Vec2 origin) {
    FloatBox numbers;
    store(numbers, box, origin);
    *this = FloatLimits(numbers);
  }
  explicit FloatLimits(const FloatBox& b) : limits_{{-b.v[2], -b.v[3], -b.v[0], -b.v[1]}} {}
  FloatOverlap compare(const FloatBox& other) const {
    bool maybe = true, certain = true;
    for (int i = 0; i < 4; ++i) {
      maybe &= other.v[i] <= limits_.v[i];
      certain &= other.v[i] < limits_.v[i];
    }
    return {maybe, certain};
  }

 private:
  FloatBox limits_;
};

#endif

#if defined(SKERRY_WIDE_TESTS)

/// True if the processor can compare four boxes in one instruction; functions that do so are compiled for it
/// and called only then.
inline bool has_wide_tests() {
  return cpu_has_avx512() && __builtin_cpu_supports("bmi2");
}
/// A bit a box from four bits a box, all of which have to be set.
__attribute__((target("avx512f,avx512vl,bmi2,popcnt"))) inline std::uint32_t all_of_four(__mmask16 bits) {
  std::uint32_t b = bits;
  b &= b >> 1;
  b &= b >> 2;
  return _pext_u32(b, 0x1111);
}

#endif

}  // namespace skerry
