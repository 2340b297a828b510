// SPDX-License-Identifier: MIT
//
// Several floats at once, for the rasteriser in memory (canvas.h): the same bits on every processor and for
// any number of lanes, because each operation is rounded by itself.
//
// Eight lanes where a file asks for them (SKERRY_EIGHT_LANES, compiled for AVX2), else four. What depends on
// the number is in a namespace of that name, so that both can be in one program.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#if defined(SKERRY_EIGHT_LANES)
#include <immintrin.h>
#define SKERRY_LANES eight_lanes
#elif defined(__SSE2__)
#include <emmintrin.h>
#define SKERRY_LANES four_lanes
#else
#define SKERRY_LANES plain_lanes
#endif

// The innermost loops are put together from small functions, which have to vanish.
#if defined(__GNUC__)
#define SKERRY_INLINE inline __attribute__((always_inline))
#define SKERRY_INLINE_LAMBDA __attribute__((always_inline))
#else
#define SKERRY_INLINE inline
#define SKERRY_INLINE_LAMBDA
#endif

namespace skerry::render {
inline namespace SKERRY_LANES {

#if defined(SKERRY_EIGHT_LANES)

inline constexpr int kLanes = 8;

struct Lanes {
  __m256 v;
  SKERRY_INLINE Lanes(float all) : v(_mm256_set1_ps(all)) {}
  SKERRY_INLINE Lanes(__m256 eight) : v(eight) {}
  friend SKERRY_INLINE Lanes operator+(Lanes a, Lanes b) { return _mm256_add_ps(a.v, b.v); }
  friend SKERRY_INLINE Lanes operator-(Lanes a, Lanes b) { return _mm256_sub_ps(a.v, b.v); }
  friend SKERRY_INLINE Lanes operator*(Lanes a, Lanes b) { return _mm256_mul_ps(a.v, b.v); }
};

SKERRY_INLINE Lanes min(Lanes a, Lanes b) {
  return _mm256_min_ps(a.v, b.v);
}
SKERRY_INLINE Lanes max(Lanes a, Lanes b) {
  return _mm256_max_ps(a.v, b.v);
}
SKERRY_INLINE Lanes load(const float* from) {
  return _mm256_loadu_ps(from);
}
SKERRY_INLINE Lanes sqrt(Lanes a) {
  return _mm256_sqrt_ps(a.v);
}
SKERRY_INLINE Lanes abs(Lanes a) {
  return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a.v);
}
/// `first`, `first` + 1, ...
SKERRY_INLINE Lanes count_from(float first) {
  return _mm256_add_ps(_mm256_set1_ps(first), _mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7));
}
/// `a` in the lanes where low <= x < high, elsewhere 0.
SKERRY_INLINE Lanes within(Lanes a, Lanes x, float low, float high) {
  return _mm256_and_ps(a.v, _mm256_and_ps(_mm256_cmp_ps(x.v, _mm256_set1_ps(low), _CMP_GE_OQ),
                                          _mm256_cmp_ps(x.v, _mm256_set1_ps(high), _CMP_LT_OQ)));
}
SKERRY_INLINE bool none_positive(Lanes a) {
  return _mm256_movemask_ps(_mm256_cmp_ps(a.v, _mm256_setzero_ps(), _CMP_GT_OQ)) == 0;
}

/// Doubles, half as many as there are lanes.
struct Doubles {
  __m256d v;
  SKERRY_INLINE Doubles(double all) : v(_mm256_set1_pd(all)) {}
  SKERRY_INLINE Doubles(__m256d four) : v(four) {}
  friend SKERRY_INLINE Doubles operator+(Doubles a, Doubles b) { return _mm256_add_pd(a.v, b.v); }
  friend SKERRY_INLINE Doubles operator-(Doubles a, Doubles b) { return _mm256_sub_pd(a.v, b.v); }
  friend SKERRY_INLINE Doubles operator*(Doubles a, Doubles b) { return _mm256_mul_pd(a.v, b.v); }
};
SKERRY_INLINE Doubles min(Doubles a, Doubles b) {
  return _mm256_min_pd(a.v, b.v);
}
SKERRY_INLINE Doubles max(Doubles a, Doubles b) {
  return _mm256_max_pd(a.v, b.v);
}
SKERRY_INLINE Doubles sqrt(Doubles a) {
  return _mm256_sqrt_pd(a.v);
}
SKERRY_INLINE Doubles doubles_from(double first) {
  return _mm256_add_pd(_mm256_set1_pd(first), _mm256_setr_pd(0, 1, 2, 3));
}
/// `a` where low <= x < high, elsewhere `b`.
SKERRY_INLINE Doubles where_between(Doubles x, double low, double high, Doubles a, Doubles b) {
  return _mm256_blendv_pd(b.v, a.v,
                          _mm256_and_pd(_mm256_cmp_pd(x.v, _mm256_set1_pd(low), _CMP_GE_OQ),
                                        _mm256_cmp_pd(x.v, _mm256_set1_pd(high), _CMP_LT_OQ)));
}
/// Towards zero.
SKERRY_INLINE void store_ints(int* to, Doubles a) {
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm256_cvttpd_epi32(a.v));
}

/// As many pixels as lanes, as they are in memory.
struct Packed {
  __m256i v;
};
SKERRY_INLINE Packed load_packed(const std::uint8_t* from) {
  return {_mm256_loadu_si256(reinterpret_cast<const __m256i*>(from))};
}
SKERRY_INLINE void store_packed(std::uint8_t* to, Packed pixels) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), pixels.v);
}
SKERRY_INLINE bool same(Packed a, Packed b) {
  return _mm256_movemask_epi8(_mm256_cmpeq_epi32(a.v, b.v)) == -1;
}

/// The same as three vectors of their channels, in 1/255.
struct Pixels {
  Lanes r, g, b;
};
SKERRY_INLINE Pixels unpacked(Packed pixels) {
  const __m256i byte = _mm256_set1_epi32(255);
  return {_mm256_cvtepi32_ps(_mm256_and_si256(pixels.v, byte)),
          _mm256_cvtepi32_ps(_mm256_and_si256(_mm256_srli_epi32(pixels.v, 8), byte)),
          _mm256_cvtepi32_ps(_mm256_and_si256(_mm256_srli_epi32(pixels.v, 16), byte))};
}
/// Rounds to the nearest, halves up; opaque.
SKERRY_INLINE Packed packed(const Pixels& p) {
  const Lanes half = 0.5f;
  const __m256i r = _mm256_cvttps_epi32((p.r + half).v), g = _mm256_cvttps_epi32((p.g + half).v),
                b = _mm256_cvttps_epi32((p.b + half).v);
  const __m256i low = _mm256_or_si256(r, _mm256_slli_epi32(g, 8));
  const __m256i high =
      _mm256_or_si256(_mm256_slli_epi32(b, 16), _mm256_set1_epi32(static_cast<int>(0xff000000)));
  return {_mm256_or_si256(low, high)};
}

#elif defined(__SSE2__)

inline constexpr int kLanes = 4;

struct Lanes {
  __m128 v;
  SKERRY_INLINE Lanes(float all) : v(_mm_set1_ps(all)) {}
  SKERRY_INLINE Lanes(__m128 four) : v(four) {}
  friend SKERRY_INLINE Lanes operator+(Lanes a, Lanes b) { return _mm_add_ps(a.v, b.v); }
  friend SKERRY_INLINE Lanes operator-(Lanes a, Lanes b) { return _mm_sub_ps(a.v, b.v); }
  friend SKERRY_INLINE Lanes operator*(Lanes a, Lanes b) { return _mm_mul_ps(a.v, b.v); }
};

SKERRY_INLINE Lanes min(Lanes a, Lanes b) {
  return _mm_min_ps(a.v, b.v);
}
SKERRY_INLINE Lanes max(Lanes a, Lanes b) {
  return _mm_max_ps(a.v, b.v);
}
SKERRY_INLINE Lanes load(const float* from) {
  return _mm_loadu_ps(from);
}
SKERRY_INLINE Lanes sqrt(Lanes a) {
  return _mm_sqrt_ps(a.v);
}
SKERRY_INLINE Lanes abs(Lanes a) {
  return _mm_andnot_ps(_mm_set1_ps(-0.0f), a.v);
}
/// `first`, `first` + 1, ...
SKERRY_INLINE Lanes count_from(float first) {
  return _mm_add_ps(_mm_set1_ps(first), _mm_setr_ps(0, 1, 2, 3));
}
/// `a` in the lanes where low <= x < high, elsewhere 0.
SKERRY_INLINE Lanes within(Lanes a, Lanes x, float low, float high) {
  return _mm_and_ps(a.v,
                    _mm_and_ps(_mm_cmpge_ps(x.v, _mm_set1_ps(low)), _mm_cmplt_ps(x.v, _mm_set1_ps(high))));
}
SKERRY_INLINE bool none_positive(Lanes a) {
  return _mm_movemask_ps(_mm_cmpgt_ps(a.v, _mm_setzero_ps())) == 0;
}

/// Doubles, half as many as there are lanes.
struct Doubles {
  __m128d v;
  SKERRY_INLINE Doubles(double all) : v(_mm_set1_pd(all)) {}
  SKERRY_INLINE Doubles(__m128d two) : v(two) {}
  friend SKERRY_INLINE Doubles operator+(Doubles a, Doubles b) { return _mm_add_pd(a.v, b.v); }
  friend SKERRY_INLINE Doubles operator-(Doubles a, Doubles b) { return _mm_sub_pd(a.v, b.v); }
  friend SKERRY_INLINE Doubles operator*(Doubles a, Doubles b) { return _mm_mul_pd(a.v, b.v); }
};
SKERRY_INLINE Doubles min(Doubles a, Doubles b) {
  return _mm_min_pd(a.v, b.v);
}
SKERRY_INLINE Doubles max(Doubles a, Doubles b) {
  return _mm_max_pd(a.v, b.v);
}
SKERRY_INLINE Doubles sqrt(Doubles a) {
  return _mm_sqrt_pd(a.v);
}
SKERRY_INLINE Doubles doubles_from(double first) {
  return _mm_add_pd(_mm_set1_pd(first), _mm_setr_pd(0, 1));
}
/// `a` where low <= x < high, elsewhere `b`.
SKERRY_INLINE Doubles where_between(Doubles x, double low, double high, Doubles a, Doubles b) {
  const __m128d mask = _mm_and_pd(_mm_cmpge_pd(x.v, _mm_set1_pd(low)), _mm_cmplt_pd(x.v, _mm_set1_pd(high)));
  return _mm_or_pd(_mm_and_pd(mask, a.v), _mm_andnot_pd(mask, b.v));
}
/// Towards zero.
SKERRY_INLINE void store_ints(int* to, Doubles a) {
  _mm_storel_epi64(reinterpret_cast<__m128i*>(to), _mm_cvttpd_epi32(a.v));
}

/// As many pixels as lanes, as they are in memory.
struct Packed {
  __m128i v;
};
SKERRY_INLINE Packed load_packed(const std::uint8_t* from) {
  return {_mm_loadu_si128(reinterpret_cast<const __m128i*>(from))};
}
SKERRY_INLINE void store_packed(std::uint8_t* to, Packed pixels) {
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to), pixels.v);
}
SKERRY_INLINE bool same(Packed a, Packed b) {
  return _mm_movemask_epi8(_mm_cmpeq_epi32(a.v, b.v)) == 0xffff;
}

/// The same as three vectors of their channels, in 1/255.
struct Pixels {
  Lanes r, g, b;
};
SKERRY_INLINE Pixels unpacked(Packed pixels) {
  const __m128i byte = _mm_set1_epi32(255);
  return {_mm_cvtepi32_ps(_mm_and_si128(pixels.v, byte)),
          _mm_cvtepi32_ps(_mm_and_si128(_mm_srli_epi32(pixels.v, 8), byte)),
          _mm_cvtepi32_ps(_mm_and_si128(_mm_srli_epi32(pixels.v, 16), byte))};
}
/// Rounds to the nearest, halves up; opaque.
SKERRY_INLINE Packed packed(const Pixels& p) {
  const Lanes half = 0.5f;
  const __m128i r = _mm_cvttps_epi32((p.r + half).v), g = _mm_cvttps_epi32((p.g + half).v),
                b = _mm_cvttps_epi32((p.b + half).v);
  const __m128i low = _mm_or_si128(r, _mm_slli_epi32(g, 8));
  const __m128i high = _mm_or_si128(_mm_slli_epi32(b, 16), _mm_set1_epi32(static_cast<int>(0xff000000)));
  return {_mm_or_si128(low, high)};
}

#else

inline constexpr int kLanes = 4;

struct Lanes {
  float v[4];
  Lanes(float all) : v{all, all, all, all} {}
  Lanes(float a, float b, float c, float d) : v{a, b, c, d} {}
  template <class Operation>
  static Lanes each(Lanes a, Lanes b, Operation operation) {
    return {operation(a.v[0], b.v[0]), operation(a.v[1], b.v[1]), operation(a.v[2], b.v[2]),
            operation(a.v[3], b.v[3])};
  }
  friend Lanes operator+(Lanes a, Lanes b) {
    return each(a, b, [](float x, float y) { return x + y; });
  }
  friend Lanes operator-(Lanes a, Lanes b) {
    return each(a, b, [](float x, float y) { return x - y; });
  }
  friend Lanes operator*(Lanes a, Lanes b) {
    return each(a, b, [](float x, float y) { return x * y; });
  }
};

SKERRY_INLINE Lanes min(Lanes a, Lanes b) {
  return Lanes::each(a, b, [](float x, float y) { return x < y ? x : y; });
}
SKERRY_INLINE Lanes max(Lanes a, Lanes b) {
  return Lanes::each(a, b, [](float x, float y) { return x > y ? x : y; });
}
SKERRY_INLINE Lanes load(const float* from) {
  return {from[0], from[1], from[2], from[3]};
}
SKERRY_INLINE Lanes sqrt(Lanes a) {
  return Lanes::each(a, a, [](float x, float) { return std::sqrt(x); });
}
SKERRY_INLINE Lanes abs(Lanes a) {
  return Lanes::each(a, a, [](float x, float) { return std::abs(x); });
}
/// `first`, `first` + 1, ...
SKERRY_INLINE Lanes count_from(float first) {
  return {first, first + 1, first + 2, first + 3};
}
/// `a` in the lanes where low <= x < high, elsewhere 0.
SKERRY_INLINE Lanes within(Lanes a, Lanes x, float low, float high) {
  return Lanes::each(a, x, [&](float value, float at) { return at >= low && at < high ? value : 0.0f; });
}
SKERRY_INLINE bool none_positive(Lanes a) {
  return !(a.v[0] > 0 || a.v[1] > 0 || a.v[2] > 0 || a.v[3] > 0);
}

/// Doubles, half as many as there are lanes.
struct Doubles {
  double v[2];
  Doubles(double all) : v{all, all} {}
  Doubles(double a, double b) : v{a, b} {}
  friend Doubles operator+(Doubles a, Doubles b) { return {a.v[0] + b.v[0], a.v[1] + b.v[1]}; }
  friend Doubles operator-(Doubles a, Doubles b) { return {a.v[0] - b.v[0], a.v[1] - b.v[1]}; }
  friend Doubles operator*(Doubles a, Doubles b) { return {a.v[0] * b.v[0], a.v[1] * b.v[1]}; }
};
SKERRY_INLINE Doubles min(Doubles a, Doubles b) {
  return {a.v[0] < b.v[0] ? a.v[0] : b.v[0], a.v[1] < b.v[1] ? a.v[1] : b.v[1]};
}
SKERRY_INLINE Doubles max(Doubles a, Doubles b) {
  return {a.v[0] > b.v[0] ? a.v[0] : b.v[0], a.v[1] > b.v[1] ? a.v[1] : b.v[1]};
}
SKERRY_INLINE Doubles sqrt(Doubles a) {
  return {std::sqrt(a.v[0]), std::sqrt(a.v[1])};
}
SKERRY_INLINE Doubles doubles_from(double first) {
  return {first, first + 1};
}
/// `a` where low <= x < high, elsewhere `b`.
SKERRY_INLINE Doubles where_between(Doubles x, double low, double high, Doubles a, Doubles b) {
  const auto one = [&](int i) { return x.v[i] >= low && x.v[i] < high ? a.v[i] : b.v[i]; };
  return {one(0), one(1)};
}
/// Towards zero.
SKERRY_INLINE void store_ints(int* to, Doubles a) {
  to[0] = static_cast<int>(a.v[0]);
  to[1] = static_cast<int>(a.v[1]);
}

/// As many pixels as lanes, as they are in memory.
struct Packed {
  std::uint8_t v[4 * kLanes];
};
SKERRY_INLINE Packed load_packed(const std::uint8_t* from) {
  Packed pixels;
  std::memcpy(pixels.v, from, sizeof pixels.v);
  return pixels;
}
SKERRY_INLINE void store_packed(std::uint8_t* to, Packed pixels) {
  std::memcpy(to, pixels.v, sizeof pixels.v);
}
SKERRY_INLINE bool same(Packed a, Packed b) {
  return std::memcmp(a.v, b.v, sizeof a.v) == 0;
}

/// The same as three vectors of their channels, in 1/255.
struct Pixels {
  Lanes r, g, b;
};
SKERRY_INLINE Pixels unpacked(Packed from) {
  Pixels p{0.0f, 0.0f, 0.0f};
  for (int i = 0; i < kLanes; ++i) {
    p.r.v[i] = from.v[4 * i];
    p.g.v[i] = from.v[4 * i + 1];
    p.b.v[i] = from.v[4 * i + 2];
  }
  return p;
}
/// Rounds to the nearest, halves up; opaque.
SKERRY_INLINE Packed packed(const Pixels& p) {
  Packed to;
  for (int i = 0; i < kLanes; ++i) {
    to.v[4 * i] = static_cast<std::uint8_t>(p.r.v[i] + 0.5f);
    to.v[4 * i + 1] = static_cast<std::uint8_t>(p.g.v[i] + 0.5f);
    to.v[4 * i + 2] = static_cast<std::uint8_t>(p.b.v[i] + 0.5f);
    to.v[4 * i + 3] = 255;
  }
  return to;
}

#endif

}  // namespace SKERRY_LANES
}  // namespace skerry::render
