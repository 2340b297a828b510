// SPDX-License-Identifier: MIT
#include "render/yuv.h"

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace skerry::render {
namespace {

// ITU-R BT.709-6, section 3, in 1/256 for 8-bit RGB of full range:
//   Y  =  16 + ( 46.7 R + 157.2 G +  15.9 B) / 256
//   Cb = 128 + (-25.8 R -  86.7 G + 112.4 B) / 256
//   Cr = 128 + (112.4 R - 102.1 G -  10.3 B) / 256
// Rounded so that greys have no colour; the error is below 0.6 of a level.
constexpr int kLuma[3] = {47, 157, 16};
constexpr int kCb[3] = {-26, -86, 112};
constexpr int kCr[3] = {112, -102, -10};

constexpr std::uint8_t combine(const int (&weight)[3], int r, int g, int b, int offset, int shift) {
  const int sum = weight[0] * r + weight[1] * g + weight[2] * b;
  return static_cast<std::uint8_t>((sum + (offset << shift) + (1 << (shift - 1))) >> shift);
}

void luma_row(const std::uint8_t* from, std::uint8_t* to, int begin, int end) {
  for (int x = begin; x < end; ++x) {
    const std::uint8_t* p = from + 4 * x;
    to[x] = combine(kLuma, p[0], p[1], p[2], 16, 8);
  }
}

void chroma_pair(const std::uint8_t* upper, const std::uint8_t* lower, std::uint8_t* cb, std::uint8_t* cr,
                 int begin, int end) {
  for (int x = begin; x < end; ++x) {
    const std::uint8_t *p = upper + 8 * x, *q = lower + 8 * x;
    const int r = p[0] + p[4] + q[0] + q[4], g = p[1] + p[5] + q[1] + q[5], b = p[2] + p[6] + q[2] + q[6];
    cb[x] = combine(kCb, r, g, b, 128, 10);
    cr[x] = combine(kCr, r, g, b, 128, 10);
  }
}

#if defined(__SSE2__)

// A pixel is a 32-bit lane R G B A. Split into pairs of 16 bits (R, B) and (G, A), a multiply-add gives the
// weighted sum in 32 bits: the same integers as the plain loops, four pixels at a time.
struct Weights {
  __m128i rb, ga;
};

Weights weights(const int (&w)[3]) {
  return {_mm_set1_epi32((w[2] << 16) | (w[0] & 0xffff)), _mm_set1_epi32(w[1] & 0xffff)};
}

__m128i weighted(__m128i rb, __m128i ga, const Weights& w, __m128i offset) {
  return _mm_add_epi32(_mm_add_epi32(_mm_madd_epi16(rb, w.rb), _mm_madd_epi16(ga, w.ga)), offset);
}

__m128i load(const std::uint8_t* from) {
  return _mm_loadu_si128(reinterpret_cast<const __m128i*>(from));
}

__m128i pack(const __m128i (&four)[4]) {
  return _mm_packus_epi16(_mm_packs_epi32(four[0], four[1]), _mm_packs_epi32(four[2], four[3]));
}

/// One weighted sum for each of 16 pixels.
__m128i sixteen(const std::uint8_t* from, const Weights& w, __m128i offset) {
  const __m128i mask = _mm_set1_epi32(0x00ff00ff);
  __m128i sums[4];
  for (int i = 0; i < 4; ++i) {
    const __m128i pixels = load(from + 16 * i);
    const __m128i rb = _mm_and_si128(pixels, mask), ga = _mm_and_si128(_mm_srli_epi16(pixels, 8), mask);
    sums[i] = _mm_srai_epi32(weighted(rb, ga, w, offset), 8);
  }
  return pack(sums);
}

int luma_blocks(const std::uint8_t* from, std::uint8_t* to, int width, const int (&coefficients)[3],
                int offset) {
  const Weights w = weights(coefficients);
  const __m128i add = _mm_set1_epi32((offset << 8) + 128);
  int x = 0;
  for (; x + 16 <= width; x += 16) {
    _mm_storeu_si128(reinterpret_cast<__m128i*>(to + x), sixteen(from + 4 * x, w, add));
  }
  return x;
}

int chroma_blocks(const std::uint8_t* upper, const std::uint8_t* lower, std::uint8_t* cb, std::uint8_t* cr,
                  int width) {
  const __m128i mask = _mm_set1_epi32(0x00ff00ff), add = _mm_set1_epi32((128 << 10) + 512);
  const Weights wb = weights(kCb), wr = weights(kCr);
  int x = 0;
  for (; x + 16 <= width; x += 16) {
    __m128i blue[4], red[4];
    for (int i = 0; i < 4; ++i) {
      const std::uint8_t *p = upper + 8 * x + 32 * i, *q = lower + 8 * x + 32 * i;
      __m128i rb[2], ga[2];
      for (int k = 0; k < 2; ++k) {
        const __m128i a = load(p + 16 * k), b = load(q + 16 * k);
        rb[k] = _mm_add_epi16(_mm_and_si128(a, mask), _mm_and_si128(b, mask));
        ga[k] = _mm_add_epi16(_mm_and_si128(_mm_srli_epi16(a, 8), mask),
                              _mm_and_si128(_mm_srli_epi16(b, 8), mask));
      }
      // Even and odd pixels side by side, then added: four sums of 2 x 2.
      const auto pairs = [](__m128i first, __m128i second) {
        const __m128 f = _mm_castsi128_ps(first), s = _mm_castsi128_ps(second);
        return _mm_add_epi16(_mm_castps_si128(_mm_shuffle_ps(f, s, _MM_SHUFFLE(2, 0, 2, 0))),
                             _mm_castps_si128(_mm_shuffle_ps(f, s, _MM_SHUFFLE(3, 1, 3, 1))));
      };
      const __m128i rb4 = pairs(rb[0], rb[1]), ga4 = pairs(ga[0], ga[1]);
      blue[i] = _mm_srai_epi32(weighted(rb4, ga4, wb, add), 10);
      red[i] = _mm_srai_epi32(weighted(rb4, ga4, wr, add), 10);
    }
    _mm_storeu_si128(reinterpret_cast<__m128i*>(cb + x), pack(blue));
    _mm_storeu_si128(reinterpret_cast<__m128i*>(cr + x), pack(red));
  }
  return x;
}

#else

int luma_blocks(const std::uint8_t*, std::uint8_t*, int, const int (&)[3], int) {
  return 0;
}
int chroma_blocks(const std::uint8_t*, const std::uint8_t*, std::uint8_t*, std::uint8_t*, int) {
  return 0;
}

#endif

}  // namespace

void to_yuv420(const Image& image, const YuvPlanes& out) {
  const std::ptrdiff_t row = 4 * static_cast<std::ptrdiff_t>(image.width);
  for (int y = 0; y < image.height; y += 2) {
    const std::uint8_t* upper = image.rgba.data() + y * row;
    for (int k = 0; k < 2; ++k) {
      std::uint8_t* to = out.plane[0] + (y + k) * out.stride[0];
      luma_row(upper + k * row, to, luma_blocks(upper + k * row, to, image.width, kLuma, 16), image.width);
    }
    std::uint8_t* cb = out.plane[1] + y / 2 * out.stride[1];
    std::uint8_t* cr = out.plane[2] + y / 2 * out.stride[2];
    chroma_pair(upper, upper + row, cb, cr, chroma_blocks(upper, upper + row, cb, cr, image.width / 2),
                image.width / 2);
  }
}

void to_yuv444(const Image& image, const YuvPlanes& out) {
  const std::ptrdiff_t row = 4 * static_cast<std::ptrdiff_t>(image.width);
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* from = image.rgba.data() + y * row;
    for (int k = 0; k < 3; ++k) {
      const auto& weight = k == 0 ? kLuma : k == 1 ? kCb : kCr;
      const int offset = k == 0 ? 16 : 128;
      std::uint8_t* to = out.plane[k] + y * out.stride[k];
      for (int x = luma_blocks(from, to, image.width, weight, offset); x < image.width; ++x) {
        to[x] = combine(weight, from[4 * x], from[4 * x + 1], from[4 * x + 2], offset, 8);
      }
    }
  }
}

}  // namespace skerry::render
