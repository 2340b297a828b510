// SPDX-License-Identifier: MIT
//
// Blending into a picture in memory: what shapes (raster_shapes.h) and panels (ui_raster.cpp) share. Used
// inside of render/ only.
//
// Files that are compiled for AVX2 include this. What they take from elsewhere has to vanish into them: a
// function of the standard library that the compiler does not inline would be kept once for all files,
// perhaps in the version that older processors cannot run. Hence functions of our own for the smallest
// things.
#pragma once

#include <cstdint>
#include <cstring>

#include "render/draw_list.h"
#include "render/lanes.h"
#include "render/surface.h"

namespace skerry::render {
inline namespace SKERRY_LANES {

template <class T>
SKERRY_INLINE T lesser(T a, T b) {
  return b < a ? b : a;
}
template <class T>
SKERRY_INLINE T greater(T a, T b) {
  return a < b ? b : a;
}
template <class T>
SKERRY_INLINE T clamped(T a, T low, T high) {
  return a < low ? low : high < a ? high : a;
}

SKERRY_INLINE std::uint8_t* row_of(const Surface& surface, int y) {
  return surface.pixels +
         std::size_t{4} * static_cast<std::size_t>(y) * static_cast<std::size_t>(surface.width);
}

/// Premultiplied colour: r, g, b in 0..255, a in 0..1.
struct Ink {
  float r = 0, g = 0, b = 0, a = 0;
  SKERRY_INLINE Ink() {}
  SKERRY_INLINE Ink(float red, float green, float blue, float alpha) : r(red), g(green), b(blue), a(alpha) {}
  SKERRY_INLINE explicit Ink(Color c)
      : r(c.r * (c.a / 255.0f)), g(c.g * (c.a / 255.0f)), b(c.b * (c.a / 255.0f)), a(c.a / 255.0f) {}
};

/// An ink for all lanes. Made before a loop and kept in registers: bytes that are stored could be part of
/// anything that is only referred to.
struct Brush {
  Lanes r, g, b, a;
  SKERRY_INLINE explicit Brush(const Ink& ink) : r(ink.r), g(ink.g), b(ink.b), a(ink.a) {}
};

/// @param cover of each of the pixels, 0 to 1
SKERRY_INLINE Packed blended(Packed pixels, Lanes cover, const Brush& ink) {
  const Pixels under = unpacked(pixels);
  const Lanes keep = Lanes(1.0f) - cover * ink.a;
  return packed(
      {under.r * keep + cover * ink.r, under.g * keep + cover * ink.g, under.b * keep + cover * ink.b});
}
SKERRY_INLINE void blend(std::uint8_t* at, Lanes cover, const Brush& ink) {
  store_packed(at, blended(load_packed(at), cover, ink));
}

/// Two inks side by side in each pixel.
/// @param more  what the ink inside has more than the one along the rim
SKERRY_INLINE void blend(std::uint8_t* at, Lanes whole, const Brush& rim, Lanes inner, const Brush& more) {
  const Pixels under = unpacked(load_packed(at));
  const Lanes keep = Lanes(1.0f) - (whole * rim.a + inner * more.a);
  store_packed(at, packed({under.r * keep + (whole * rim.r + inner * more.r),
                           under.g * keep + (whole * rim.g + inner * more.g),
                           under.b * keep + (whole * rim.b + inner * more.b)}));
}

/// Rounds to the nearest, halves up, as `packed` does. @param x  0 to 255
SKERRY_INLINE std::uint8_t to_byte(float x) {
  return static_cast<std::uint8_t>(x + 0.5f);  // NOLINT(bugprone-incorrect-roundings): never negative
}

/// One pixel.
SKERRY_INLINE void blend_one(std::uint8_t* at, float cover, const Ink& ink) {
  const float keep = 1 - cover * ink.a;
  at[0] = to_byte(static_cast<float>(at[0]) * keep + cover * ink.r);
  at[1] = to_byte(static_cast<float>(at[1]) * keep + cover * ink.g);
  at[2] = to_byte(static_cast<float>(at[2]) * keep + cover * ink.b);
}

/// Calls `group(x, centres, inside)` for groups of kLanes pixels that hold x0..x1 once each; `inside(value)`
/// is 0 in the lanes that are not among them. All of a group lies in the picture.
template <class Group>
SKERRY_INLINE void by_lanes(int x0, int x1, int width, const Group& group) {
  int x = x0;
  for (; x + kLanes <= x1; x += kLanes)
    group(x, count_from(static_cast<float>(x) + 0.5f),
          [](Lanes value) SKERRY_INLINE_LAMBDA { return value; });
  if (x >= x1) return;
  const int start = lesser(x, width - kLanes);
  const float low = static_cast<float>(x), high = static_cast<float>(x1);
  const Lanes at = count_from(static_cast<float>(start) + 0.5f);
  group(start, at, [&](Lanes value) SKERRY_INLINE_LAMBDA { return within(value, at, low, high); });
}

/// Pixels x0 to x1 of row y, all of them inside of the picture, in one ink.
SKERRY_INLINE void fill_span(const Surface& surface, int y, int x0, int x1, const Ink& ink, float cover = 1) {
  if (x0 >= x1) return;
  std::uint8_t* const row = row_of(surface, y);
  if (ink.a >= 1 && cover >= 1) {
    const std::uint8_t pixel[4] = {to_byte(ink.r), to_byte(ink.g), to_byte(ink.b), 255};
    std::uint32_t word;
    std::memcpy(&word, pixel, 4);
    auto* const words = reinterpret_cast<std::uint32_t*>(row);
    for (int x = x0; x < x1; ++x) words[x] = word;
    return;
  }
  if (!(ink.a > 0)) return;
  const Brush brush(ink);
  // What lies under panels is mostly the same pixels again and again, and so is what becomes of them.
  int x = x0;
  if (x + kLanes <= x1) {
    Packed under = load_packed(row + 4 * x), over = blended(under, cover, brush);
    for (;;) {
      store_packed(row + 4 * x, over);
      x += kLanes;
      if (x + kLanes > x1) break;
      const Packed next = load_packed(row + 4 * x);
      if (same(next, under)) continue;
      under = next;
      over = blended(under, cover, brush);
    }
  }
  // NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding): it vanishes
  by_lanes(x, x1, surface.width, [row, brush, cover](int at, Lanes, const auto& inside) SKERRY_INLINE_LAMBDA {
    blend(row + 4 * at, inside(cover), brush);
  });
}

/// The pixels of a row whose centres lie in low..high, cut to the picture.
struct Span {
  int x0 = 0, x1 = 0;
  [[nodiscard]] SKERRY_INLINE bool empty() const { return x0 >= x1; }
};
/// The first pixel whose centre is beyond `edge`; 0 to `width`, and 0 if `edge` is no number.
SKERRY_INLINE int pixel_after(double edge, int width) {
  if (!(edge > 0)) return 0;
  return static_cast<int>(clamped(edge - 0.5, -1.0, static_cast<double>(width - 1)) + 1);
}
SKERRY_INLINE Span span_of(double low, double high, int width) {
  return {pixel_after(low, width), pixel_after(high, width)};
}

}  // namespace SKERRY_LANES
}  // namespace skerry::render
