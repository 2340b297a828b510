// SPDX-License-Identifier: MIT
//
// Inside the narrow phase: two doubles side by side. Each lane does exactly what a plain double would, in the
// same order, so results do not depend on whether the processor's registers or the plain version are used.
#pragma once

#include <bit>
#include <cstdint>
#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "physics/math.h"

/// Compiles a function a second time with the instructions of AVX2, which name their result apart from their
/// operands and so need a fifth fewer; the loader picks one. Sums and products are the same, to the bit (no
/// fused multiply-add). Sanitizers start too late for the loader's choice, and clang cannot combine it with
/// the other attributes.
#if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__clang__) && !defined(__AVX2__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define SKERRY_TWICE [[gnu::target_clones("default", "avx2")]]
#else
#define SKERRY_TWICE
#endif

namespace skerry::narrow {

#if defined(__SSE2__)

struct Two {
  __m128d v;
  static Two of(double low, double high) { return {_mm_set_pd(high, low)}; }
  static Two both(double x) { return {_mm_set1_pd(x)}; }
  static Two load(const double* two) { return {_mm_loadu_pd(two)}; }
  void store(double* out) const { _mm_storeu_pd(out, v); }
  /// Lane k of a where bit pattern k of `mask` (from `at_least`) is set, else that of b.
  friend Two chosen(Two mask, Two a, Two b) {
    return {_mm_or_pd(_mm_and_pd(mask.v, a.v), _mm_andnot_pd(mask.v, b.v))};
  }
  friend Two at_least(Two a, Two b) { return {_mm_cmpge_pd(a.v, b.v)}; }
  friend Two below(Two a, Two b) { return {_mm_cmplt_pd(a.v, b.v)}; }
  /// Bit by bit, of masks, or of a mask and numbers: 0 where it is not set.
  friend Two operator&(Two a, Two b) { return {_mm_and_pd(a.v, b.v)}; }
  friend Two operator|(Two a, Two b) { return {_mm_or_pd(a.v, b.v)}; }
  friend Two operator^(Two a, Two b) { return {_mm_xor_pd(a.v, b.v)}; }
  friend Two without(Two a, Two mask) { return {_mm_andnot_pd(mask.v, a.v)}; }
  friend Two root(Two a) { return {_mm_sqrt_pd(a.v)}; }
  /// Whole numbers from 0 on, as 64-bit integers in the same place.
  friend Two as_integers(Two a) {
    return {_mm_castsi128_pd(_mm_unpacklo_epi32(_mm_cvttpd_epi32(a.v), _mm_setzero_si128()))};
  }
  friend unsigned bits(Two mask) { return static_cast<unsigned>(_mm_movemask_pd(mask.v)); }
  friend Two operator+(Two a, Two b) { return {_mm_add_pd(a.v, b.v)}; }
  friend Two operator-(Two a, Two b) { return {_mm_sub_pd(a.v, b.v)}; }
  friend Two operator*(Two a, Two b) { return {_mm_mul_pd(a.v, b.v)}; }
  friend Two operator/(Two a, Two b) { return {_mm_div_pd(a.v, b.v)}; }
  /// a < b ? a : b
  friend Two lesser(Two a, Two b) { return {_mm_min_pd(a.v, b.v)}; }
  friend Two greater(Two a, Two b) { return {_mm_max_pd(a.v, b.v)}; }
  friend Two magnitude(Two a) { return {_mm_andnot_pd(_mm_set1_pd(-0.0), a.v)}; }
  friend Two negated(Two a) { return {_mm_xor_pd(_mm_set1_pd(-0.0), a.v)}; }
  friend Two with_low_negated(Two a) { return {_mm_xor_pd(_mm_set_pd(0.0, -0.0), a.v)}; }
  friend Two with_high_negated(Two a) { return {_mm_xor_pd(_mm_set_pd(-0.0, 0.0), a.v)}; }
  friend Two exchanged(Two a) { return {_mm_shuffle_pd(a.v, a.v, 1)}; }
  /// The sign bits of `mask` flip the signs of a.
  friend Two flipped(Two a, Two mask) { return {_mm_xor_pd(a.v, _mm_and_pd(_mm_set1_pd(-0.0), mask.v))}; }
  /// The first, or the second, of each.
  friend Two lows(Two a, Two b) { return {_mm_unpacklo_pd(a.v, b.v)}; }
  friend Two highs(Two a, Two b) { return {_mm_unpackhi_pd(a.v, b.v)}; }
  double low() const { return _mm_cvtsd_f64(v); }
  double high() const { return _mm_cvtsd_f64(_mm_unpackhi_pd(v, v)); }
};

#else

struct Two {
  double v[2];
  static Two of(double a, double b) { return {{a, b}}; }
  static Two both(double x) { return {{x, x}}; }
  static Two load(const double* two) { return {{two[0], two[1]}}; }
  void store(double* out) const { out[0] = v[0], out[1] = v[1]; }
  friend Two chosen(Two mask, Two a, Two b) {
    return {{mask.v[0] != 0 ? a.v[0] : b.v[0], mask.v[1] != 0 ? a.v[1] : b.v[1]}};
  }
  using Bits = std::uint64_t;
  static double set(bool on) { return std::bit_cast<double>(on ? ~Bits{0} : Bits{0}); }
  template <class Operation>
  static Two by_bits(Two a, Two b, Operation op) {
    const auto one = [&](int i) {
      return std::bit_cast<double>(op(std::bit_cast<Bits>(a.v[i]), std::bit_cast<Bits>(b.v[i])));
    };
    return {{one(0), one(1)}};
  }
  friend Two at_least(Two a, Two b) { return {{set(a.v[0] >= b.v[0]), set(a.v[1] >= b.v[1])}}; }
  friend Two below(Two a, Two b) { return {{set(a.v[0] < b.v[0]), set(a.v[1] < b.v[1])}}; }
  friend Two operator&(Two a, Two b) {
    return by_bits(a, b, [](Bits x, Bits y) { return x & y; });
  }
  friend Two operator|(Two a, Two b) {
    return by_bits(a, b, [](Bits x, Bits y) { return x | y; });
  }
  friend Two operator^(Two a, Two b) {
    return by_bits(a, b, [](Bits x, Bits y) { return x ^ y; });
  }
  friend Two without(Two a, Two mask) {
    return by_bits(a, mask, [](Bits x, Bits y) { return x & ~y; });
  }
  friend Two root(Two a) { return {{std::sqrt(a.v[0]), std::sqrt(a.v[1])}}; }
  friend Two as_integers(Two a) {
    const auto one = [&](int i) { return std::bit_cast<double>(static_cast<Bits>(a.v[i])); };
    return {{one(0), one(1)}};
  }
  friend unsigned bits(Two mask) { return (mask.v[0] != 0 ? 1u : 0u) | (mask.v[1] != 0 ? 2u : 0u); }
  friend Two operator+(Two a, Two b) { return {{a.v[0] + b.v[0], a.v[1] + b.v[1]}}; }
  friend Two operator-(Two a, Two b) { return {{a.v[0] - b.v[0], a.v[1] - b.v[1]}}; }
  friend Two operator/(Two a, Two b) { return {{a.v[0] / b.v[0], a.v[1] / b.v[1]}}; }
  friend Two operator*(Two a, Two b) { return {{a.v[0] * b.v[0], a.v[1] * b.v[1]}}; }
  friend Two lesser(Two a, Two b) {
    return {{a.v[0] < b.v[0] ? a.v[0] : b.v[0], a.v[1] < b.v[1] ? a.v[1] : b.v[1]}};
  }
  friend Two greater(Two a, Two b) {
    return {{a.v[0] > b.v[0] ? a.v[0] : b.v[0], a.v[1] > b.v[1] ? a.v[1] : b.v[1]}};
  }
  friend Two magnitude(Two a) { return {{a.v[0] < 0 ? -a.v[0] : a.v[0], a.v[1] < 0 ? -a.v[1] : a.v[1]}}; }
  friend Two negated(Two a) { return {{-a.v[0], -a.v[1]}}; }
  friend Two with_low_negated(Two a) { return {{-a.v[0], a.v[1]}}; }
  friend Two with_high_negated(Two a) { return {{a.v[0], -a.v[1]}}; }
  friend Two exchanged(Two a) { return {{a.v[1], a.v[0]}}; }
  friend Two flipped(Two a, Two mask) {
    return {{std::signbit(mask.v[0]) ? -a.v[0] : a.v[0], std::signbit(mask.v[1]) ? -a.v[1] : a.v[1]}};
  }
  friend Two lows(Two a, Two b) { return {{a.v[0], b.v[0]}}; }
  friend Two highs(Two a, Two b) { return {{a.v[1], b.v[1]}}; }
  double low() const { return v[0]; }
  double high() const { return v[1]; }
};

#endif

/// The square root; std::sqrt would ask whether it has to set an error number.
inline double root(double x) {
#if defined(__SSE2__)
  return _mm_cvtsd_f64(_mm_sqrt_pd(_mm_set_sd(x)));
#else
  return std::sqrt(x);
#endif
}
inline Two load(const Vec2& v) {
  return Two::load(&v.x);
}
inline Two load(const Rot& q) {
  return Two::load(&q.c);
}
/// A mask for both lanes.
inline Two everywhere(bool on) {
  return Two::both(std::bit_cast<double>(-std::uint64_t{on}));
}
/// One of two places, without a branch; for what cannot be foreseen, where a wrong guess costs more than all
/// of a disc's contact.
template <class T>
[[gnu::always_inline]] inline const T* chosen(bool on, const T* a, const T* b) {
  const auto at_a = reinterpret_cast<std::uintptr_t>(a), at_b = reinterpret_cast<std::uintptr_t>(b);
  return reinterpret_cast<const T*>(at_b ^ ((at_a ^ at_b) & -std::uintptr_t{on}));
}
/// Writes a pair in one piece: one that was written in two cannot be read in one without waiting for both to
/// leave the processor's store buffer.
inline void write_whole(Vec2& v) {
  Two::of(v.x, v.y).store(&v.x);
}
inline void write_whole(Rot& q) {
  Two::of(q.c, q.s).store(&q.c);
}
/// The vector `v` turned by the rotation `q`, to the bit as `rotate`.
inline Two turned(Two q, Two v) {
  const Two x = lows(v, v), y = highs(v, v);
  return x * q + y * with_low_negated(exchanged(q));
}
inline double smallest(Two a) {
  const double low = a.low(), high = a.high();
  return low < high ? low : high;
}
inline double largest(Two a) {
  const double low = a.low(), high = a.high();
  return low > high ? low : high;
}

}  // namespace skerry::narrow
