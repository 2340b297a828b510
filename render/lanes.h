// SPDX-License-Identifier: MIT
//
// Four floats at once, for the rasteriser in memory (canvas.h): the same bits on every processor, because
// each operation is rounded by itself.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

// The innermost loops are put together from small functions, which have to vanish.
#if defined(__GNUC__)
#define SKERRY_INLINE [[gnu::always_inline]] inline
#define SKERRY_INLINE_LAMBDA __attribute__((always_inline))
#else
#define SKERRY_INLINE inline
#define SKERRY_INLINE_LAMBDA
#endif

namespace skerry::render {

#if defined(__SSE2__)

struct Lanes {
  __m128 v;
  Lanes(float all) : v(_mm_set1_ps(all)) {}
  Lanes(__m128 four) : v(four) {}
  friend Lanes operator+(Lanes a, Lanes b) { return _mm_add_ps(a.v, b.v); }
  friend Lanes operator-(Lanes a, Lanes b) { return _mm_sub_ps(a.v, b.v); }
  friend Lanes operator*(Lanes a, Lanes b) { return _mm_mul_ps(a.v, b.v); }
};

SKERRY_INLINE Lanes min(Lanes a, Lanes b) {
  return _mm_min_ps(a.v, b.v);
}
SKERRY_INLINE Lanes max(Lanes a, Lanes b) {
  return _mm_max_ps(a.v, b.v);
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

/// Four pixels as three vectors of their channels, in 1/255.
struct Pixels {
  Lanes r, g, b;
};
SKERRY_INLINE Pixels load_pixels(const std::uint8_t* from) {
  const __m128i four = _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
  const __m128i byte = _mm_set1_epi32(255);
  return {_mm_cvtepi32_ps(_mm_and_si128(four, byte)),
          _mm_cvtepi32_ps(_mm_and_si128(_mm_srli_epi32(four, 8), byte)),
          _mm_cvtepi32_ps(_mm_and_si128(_mm_srli_epi32(four, 16), byte))};
}
/// Rounds to the nearest, halves up; opaque.
SKERRY_INLINE void store_pixels(std::uint8_t* to, const Pixels& p) {
  const auto whole = [](Lanes a) { return _mm_cvttps_epi32((a + 0.5f).v); };
  const __m128i low = _mm_or_si128(whole(p.r), _mm_slli_epi32(whole(p.g), 8));
  const __m128i high =
      _mm_or_si128(_mm_slli_epi32(whole(p.b), 16), _mm_set1_epi32(static_cast<int>(0xff000000)));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm_or_si128(low, high));
}

#else

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

/// Four pixels as three vectors of their channels, in 1/255.
struct Pixels {
  Lanes r, g, b;
};
SKERRY_INLINE Pixels load_pixels(const std::uint8_t* from) {
  Pixels p{0.0f, 0.0f, 0.0f};
  for (int i = 0; i < 4; ++i) {
    p.r.v[i] = from[4 * i];
    p.g.v[i] = from[4 * i + 1];
    p.b.v[i] = from[4 * i + 2];
  }
  return p;
}
/// Rounds to the nearest, halves up; opaque.
SKERRY_INLINE void store_pixels(std::uint8_t* to, const Pixels& p) {
  for (int i = 0; i < 4; ++i) {
    to[4 * i] = static_cast<std::uint8_t>(p.r.v[i] + 0.5f);
    to[4 * i + 1] = static_cast<std::uint8_t>(p.g.v[i] + 0.5f);
    to[4 * i + 2] = static_cast<std::uint8_t>(p.b.v[i] + 0.5f);
    to[4 * i + 3] = 255;
  }
}

#endif

}  // namespace skerry::render
