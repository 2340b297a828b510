// SPDX-License-Identifier: MIT
//
// The inner loops of yuv.cpp, compiled for each number of lanes (raster_kernels.h): whole numbers, so all
// give the same. See raster.h for what such files may use.
#pragma once

#include <cstdint>

#include "render/lanes.h"

namespace skerry::render {
inline namespace SKERRY_LANES {

// ITU-R BT.709-6, section 3, in 1/256 for 8-bit RGB of full range:
//   Y  =  16 + ( 46.7 R + 157.2 G +  15.9 B) / 256
//   Cb = 128 + (-25.8 R -  86.7 G + 112.4 B) / 256
//   Cr = 128 + (112.4 R - 102.1 G -  10.3 B) / 256
// Rounded so that greys have no colour; the error is below 0.6 of a level.
inline constexpr int kLuma[3] = {47, 157, 16};
inline constexpr int kCb[3] = {-26, -86, 112};
inline constexpr int kCr[3] = {112, -102, -10};

SKERRY_INLINE std::uint8_t combine(const int (&weight)[3], int r, int g, int b, int offset, int shift) {
  const int sum = weight[0] * r + weight[1] * g + weight[2] * b;
  return static_cast<std::uint8_t>((sum + (offset << shift) + (1 << (shift - 1))) >> shift);
}

#if defined(__SSE2__)

// A pixel is a 32-bit lane R G B A. Split into pairs of 16 bits (R, B) and (G, A), a multiply-add gives the
// weighted sum in 32 bits.
#if defined(SKERRY_EIGHT_LANES)

struct Words {
  __m256i v;
};
SKERRY_INLINE Words all_words(int x) {
  return {_mm256_set1_epi32(x)};
}
SKERRY_INLINE Words load_words(const std::uint8_t* from) {
  return {_mm256_loadu_si256(reinterpret_cast<const __m256i*>(from))};
}
SKERRY_INLINE Words even_bytes(Words a) {
  return {_mm256_and_si256(a.v, _mm256_set1_epi32(0x00ff00ff))};
}
SKERRY_INLINE Words odd_bytes(Words a) {
  return {_mm256_srli_epi16(a.v, 8)};
}
SKERRY_INLINE Words add16(Words a, Words b) {
  return {_mm256_add_epi16(a.v, b.v)};
}
SKERRY_INLINE Words weighted(Words rb, Words ga, Words weight_rb, Words weight_ga, Words offset) {
  return {_mm256_add_epi32(
      _mm256_add_epi32(_mm256_madd_epi16(rb.v, weight_rb.v), _mm256_madd_epi16(ga.v, weight_ga.v)),
      offset.v)};
}
template <int kShift>
SKERRY_INLINE Words shifted(Words a) {
  return {_mm256_srai_epi32(a.v, kShift)};
}
/// Even and odd pixels of both, added: each half of the register by itself.
SKERRY_INLINE Words pairs(Words first, Words second) {
  const __m256 f = _mm256_castsi256_ps(first.v), s = _mm256_castsi256_ps(second.v);
  return {_mm256_add_epi16(_mm256_castps_si256(_mm256_shuffle_ps(f, s, _MM_SHUFFLE(2, 0, 2, 0))),
                           _mm256_castps_si256(_mm256_shuffle_ps(f, s, _MM_SHUFFLE(3, 1, 3, 1))))};
}
SKERRY_INLINE __m256i pack(const Words (&four)[4]) {
  return _mm256_packus_epi16(_mm256_packs_epi32(four[0].v, four[1].v),
                             _mm256_packs_epi32(four[2].v, four[3].v));
}
/// The low bytes of 32 words.
SKERRY_INLINE void store_bytes(std::uint8_t* to, const Words (&four)[4]) {
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
                      _mm256_permutevar8x32_epi32(pack(four), _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7)));
}
/// The same for words made by `pairs`.
SKERRY_INLINE void store_paired_bytes(std::uint8_t* to, const Words (&four)[4]) {
  const __m256i packed = pack(four);
  const __m128i low = _mm256_castsi256_si128(packed), high = _mm256_extracti128_si256(packed, 1);
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm_unpacklo_epi16(low, high));
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to + 16), _mm_unpackhi_epi16(low, high));
}

#else

struct Words {
  __m128i v;
};
SKERRY_INLINE Words all_words(int x) {
  return {_mm_set1_epi32(x)};
}
SKERRY_INLINE Words load_words(const std::uint8_t* from) {
  return {_mm_loadu_si128(reinterpret_cast<const __m128i*>(from))};
}
SKERRY_INLINE Words even_bytes(Words a) {
  return {_mm_and_si128(a.v, _mm_set1_epi32(0x00ff00ff))};
}
SKERRY_INLINE Words odd_bytes(Words a) {
  return {_mm_srli_epi16(a.v, 8)};
}
SKERRY_INLINE Words add16(Words a, Words b) {
  return {_mm_add_epi16(a.v, b.v)};
}
SKERRY_INLINE Words weighted(Words rb, Words ga, Words weight_rb, Words weight_ga, Words offset) {
  return {_mm_add_epi32(_mm_add_epi32(_mm_madd_epi16(rb.v, weight_rb.v), _mm_madd_epi16(ga.v, weight_ga.v)),
                        offset.v)};
}
template <int kShift>
SKERRY_INLINE Words shifted(Words a) {
  return {_mm_srai_epi32(a.v, kShift)};
}
/// Even and odd pixels of both, added.
SKERRY_INLINE Words pairs(Words first, Words second) {
  const __m128 f = _mm_castsi128_ps(first.v), s = _mm_castsi128_ps(second.v);
  return {_mm_add_epi16(_mm_castps_si128(_mm_shuffle_ps(f, s, _MM_SHUFFLE(2, 0, 2, 0))),
                        _mm_castps_si128(_mm_shuffle_ps(f, s, _MM_SHUFFLE(3, 1, 3, 1))))};
}
/// The low bytes of 16 words.
SKERRY_INLINE void store_bytes(std::uint8_t* to, const Words (&four)[4]) {
  _mm_storeu_si128(reinterpret_cast<__m128i*>(to), _mm_packus_epi16(_mm_packs_epi32(four[0].v, four[1].v),
                                                                    _mm_packs_epi32(four[2].v, four[3].v)));
}
SKERRY_INLINE void store_paired_bytes(std::uint8_t* to, const Words (&four)[4]) {
  store_bytes(to, four);
}

#endif

struct Weights {
  Words rb, ga;
  SKERRY_INLINE explicit Weights(const int (&w)[3])
      : rb(all_words((w[2] << 16) | (w[0] & 0xffff))), ga(all_words(w[1] & 0xffff)) {}
};

/// As many whole blocks as a row of `width` pixels has. @return the first pixel that is left
inline int weigh_row(const std::uint8_t* from, std::uint8_t* to, int width, const int (&weight)[3],
                     int offset) {
  constexpr int kBlock = 4 * kLanes, kBytes = 4 * kLanes;
  const Weights w(weight);
  const Words add = all_words((offset << 8) + 128);
  int x = 0;
  for (; x + kBlock <= width; x += kBlock) {
    Words sums[4] = {add, add, add, add};
    for (int i = 0; i < 4; ++i) {
      const Words pixels = load_words(from + 4 * x + kBytes * i);
      sums[i] = shifted<8>(weighted(even_bytes(pixels), odd_bytes(pixels), w.rb, w.ga, add));
    }
    store_bytes(to + x, sums);
  }
  return x;
}

/// The same for luma, offset 16.
inline int luma_row(const std::uint8_t* from, std::uint8_t* to, int width) {
#if defined(SKERRY_EIGHT_LANES)
  // Bytes times bytes: one factor has a sign, the other none. With 128 less in each channel all sums fit 16
  // bits, and what that takes away is a constant.
  static_assert(kLuma[0] + kLuma[1] + kLuma[2] == 220);
  const __m256i weight = _mm256_set1_epi32(kLuma[0] | kLuma[1] << 8 | kLuma[2] << 16);
  const __m256i middle = _mm256_set1_epi8(-128), add = _mm256_set1_epi16(220 * 128 + (16 << 8) + 128);
  int x = 0;
  for (; x + 32 <= width; x += 32) {
    const auto sums = [&](int at) SKERRY_INLINE_LAMBDA {
      return _mm256_maddubs_epi16(weight, _mm256_xor_si256(load_words(from + 4 * x + 32 * at).v, middle));
    };
    const __m256i first = _mm256_add_epi16(_mm256_hadd_epi16(sums(0), sums(1)), add),
                  second = _mm256_add_epi16(_mm256_hadd_epi16(sums(2), sums(3)), add);
    const __m256i bytes = _mm256_packus_epi16(_mm256_srli_epi16(first, 8), _mm256_srli_epi16(second, 8));
    _mm256_storeu_si256(reinterpret_cast<__m256i*>(to + x),
                        _mm256_permutevar8x32_epi32(bytes, _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7)));
  }
  return x;
#else
  return weigh_row(from, to, width, kLuma, 16);
#endif
}

/// Colour of 2 x 2 pixels. @param width of cb and cr. @return the first that is left
inline int halve_rows(const std::uint8_t* upper, const std::uint8_t* lower, std::uint8_t* cb,
                      std::uint8_t* cr, int width) {
  constexpr int kBlock = 4 * kLanes, kBytes = 4 * kLanes;
  const Words add = all_words((128 << 10) + 512);
  const Weights wb(kCb), wr(kCr);
  int x = 0;
  for (; x + kBlock <= width; x += kBlock) {
    Words blue[4] = {add, add, add, add}, red[4] = {add, add, add, add};
    for (int i = 0; i < 4; ++i) {
      Words rb[2] = {add, add}, ga[2] = {add, add};
      for (int k = 0; k < 2; ++k) {
        const Words a = load_words(upper + 8 * x + kBytes * (2 * i + k)),
                    b = load_words(lower + 8 * x + kBytes * (2 * i + k));
        rb[k] = add16(even_bytes(a), even_bytes(b));
        ga[k] = add16(odd_bytes(a), odd_bytes(b));
      }
      const Words rb4 = pairs(rb[0], rb[1]), ga4 = pairs(ga[0], ga[1]);
      blue[i] = shifted<10>(weighted(rb4, ga4, wb.rb, wb.ga, add));
      red[i] = shifted<10>(weighted(rb4, ga4, wr.rb, wr.ga, add));
    }
    store_paired_bytes(cb + x, blue);
    store_paired_bytes(cr + x, red);
  }
  return x;
}

#else

inline int weigh_row(const std::uint8_t*, std::uint8_t*, int, const int (&)[3], int) {
  return 0;
}
inline int luma_row(const std::uint8_t*, std::uint8_t*, int) {
  return 0;
}
inline int halve_rows(const std::uint8_t*, const std::uint8_t*, std::uint8_t*, std::uint8_t*, int) {
  return 0;
}

#endif

}  // namespace SKERRY_LANES
}  // namespace skerry::render
