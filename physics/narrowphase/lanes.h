// SPDX-License-Identifier: MIT
//
// Inside the narrow phase: two doubles side by side. Each lane does exactly what a plain double would, in the
// same order, so results do not depend on whether the processor's registers or the plain version are used.
#pragma once

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace skerry::narrow {

#if defined(__SSE2__)

struct Two {
  __m128d v;
  static Two of(double low, double high) { return {_mm_set_pd(high, low)}; }
  static Two both(double x) { return {_mm_set1_pd(x)}; }
  static Two load(const double* two) { return {_mm_loadu_pd(two)}; }
  void store(double* out) const { _mm_storeu_pd(out, v); }
  friend Two operator+(Two a, Two b) { return {_mm_add_pd(a.v, b.v)}; }
  friend Two operator-(Two a, Two b) { return {_mm_sub_pd(a.v, b.v)}; }
  friend Two operator*(Two a, Two b) { return {_mm_mul_pd(a.v, b.v)}; }
  /// a < b ? a : b
  friend Two lesser(Two a, Two b) { return {_mm_min_pd(a.v, b.v)}; }
  friend Two greater(Two a, Two b) { return {_mm_max_pd(a.v, b.v)}; }
};

#else

struct Two {
  double low, high;
  static Two of(double a, double b) { return {a, b}; }
  static Two both(double x) { return {x, x}; }
  static Two load(const double* two) { return {two[0], two[1]}; }
  void store(double* out) const { out[0] = low, out[1] = high; }
  friend Two operator+(Two a, Two b) { return {a.low + b.low, a.high + b.high}; }
  friend Two operator-(Two a, Two b) { return {a.low - b.low, a.high - b.high}; }
  friend Two operator*(Two a, Two b) { return {a.low * b.low, a.high * b.high}; }
  friend Two lesser(Two a, Two b) {
    return {a.low < b.low ? a.low : b.low, a.high < b.high ? a.high : b.high};
  }
  friend Two greater(Two a, Two b) {
    return {a.low > b.low ? a.low : b.low, a.high > b.high ? a.high : b.high};
  }
};

#endif

}  // namespace skerry::narrow
