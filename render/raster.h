// SPDX-License-Identifier: MIT
//
// Blending into a picture in memory: what shapes (canvas.cpp) and panels (ui_raster.cpp) share. Used inside
// of render/ only.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "render/draw_list.h"
#include "render/lanes.h"

namespace skerry::render {

/// An opaque RGBA8 picture that somebody else owns, at least four pixels wide, top row first, no padding.
struct Surface {
  std::uint8_t* pixels = nullptr;
  int width = 0, height = 0;  ///< [px]
  [[nodiscard]] std::uint8_t* row(int y) const { return pixels + std::size_t{4} * y * width; }
};

/// Premultiplied colour: r, g, b in 0..255, a in 0..1.
struct Ink {
  float r = 0, g = 0, b = 0, a = 0;
  Ink() = default;
  Ink(float red, float green, float blue, float alpha) : r(red), g(green), b(blue), a(alpha) {}
  explicit Ink(Color c)
      : r(c.r * (c.a / 255.0f)), g(c.g * (c.a / 255.0f)), b(c.b * (c.a / 255.0f)), a(c.a / 255.0f) {}
};

/// An ink for four pixels. Made before a loop and kept in registers: bytes that are stored could be part of
/// anything that is only referred to.
struct Brush {
  Lanes r, g, b, a;
  explicit Brush(const Ink& ink) : r(ink.r), g(ink.g), b(ink.b), a(ink.a) {}
};

/// @param cover of each of the four pixels, 0 to 1
SKERRY_INLINE void blend(std::uint8_t* at, Lanes cover, const Brush& ink) {
  const Pixels under = load_pixels(at);
  const Lanes keep = Lanes(1.0f) - cover * ink.a;
  store_pixels(
      at, {under.r * keep + cover * ink.r, under.g * keep + cover * ink.g, under.b * keep + cover * ink.b});
}

/// Two inks side by side in each pixel.
/// @param more  what the ink inside has more than the one along the rim
SKERRY_INLINE void blend(std::uint8_t* at, Lanes whole, const Brush& rim, Lanes inner, const Brush& more) {
  const Pixels under = load_pixels(at);
  const Lanes keep = Lanes(1.0f) - (whole * rim.a + inner * more.a);
  store_pixels(at, {under.r * keep + (whole * rim.r + inner * more.r),
                    under.g * keep + (whole * rim.g + inner * more.g),
                    under.b * keep + (whole * rim.b + inner * more.b)});
}

/// One pixel.
inline void blend_one(std::uint8_t* at, float cover, const Ink& ink) {
  const float keep = 1 - cover * ink.a;
  at[0] = static_cast<std::uint8_t>(static_cast<float>(at[0]) * keep + cover * ink.r + 0.5f);
  at[1] = static_cast<std::uint8_t>(static_cast<float>(at[1]) * keep + cover * ink.g + 0.5f);
  at[2] = static_cast<std::uint8_t>(static_cast<float>(at[2]) * keep + cover * ink.b + 0.5f);
}

/// Calls `four(x, centres, inside)` for groups of four pixels that hold x0..x1 once each; `inside(value)` is
/// 0 in the lanes that are not among them. All of a group lies in the picture.
template <class Four>
SKERRY_INLINE void by_four(int x0, int x1, int width, const Four& four) {
  int x = x0;
  Lanes centres = count_from(static_cast<float>(x0) + 0.5f);
  for (; x + 4 <= x1; x += 4, centres = centres + 4.0f)
    four(x, centres, [](Lanes value) SKERRY_INLINE_LAMBDA { return value; });
  if (x >= x1) return;
  const int start = std::min(x, width - 4);
  const float low = static_cast<float>(x), high = static_cast<float>(x1);
  const Lanes at = count_from(static_cast<float>(start) + 0.5f);
  four(start, at, [&](Lanes value) SKERRY_INLINE_LAMBDA { return within(value, at, low, high); });
}

/// Pixels x0 to x1 of row y, all of them inside of the picture, in one ink.
inline void fill_span(const Surface& surface, int y, int x0, int x1, const Ink& ink) {
  if (x0 >= x1) return;
  std::uint8_t* row = surface.row(y);
  if (ink.a >= 1) {
    std::uint8_t pixel[4] = {static_cast<std::uint8_t>(ink.r + 0.5f), static_cast<std::uint8_t>(ink.g + 0.5f),
                             static_cast<std::uint8_t>(ink.b + 0.5f), 255};
    std::uint32_t word;
    std::memcpy(&word, pixel, 4);
    auto* words = reinterpret_cast<std::uint32_t*>(row);
    std::fill(words + x0, words + x1, word);
    return;
  }
  if (!(ink.a > 0)) return;
  const Brush brush(ink);
  by_four(x0, x1, surface.width, [row, brush](int x, Lanes, const auto& inside) SKERRY_INLINE_LAMBDA {
    blend(row + 4 * x, inside(1.0f), brush);
  });
}

/// The pixels of a row whose centres lie in low..high, cut to the picture.
struct Span {
  int x0 = 0, x1 = 0;
  [[nodiscard]] bool empty() const { return x0 >= x1; }
};
inline Span span_of(double low, double high, int width) {
  const auto after = [&](double edge) {
    return static_cast<int>(std::clamp(edge - 0.5, -1.0, static_cast<double>(width - 1)) + 1);
  };
  return {after(low), after(high)};
}

}  // namespace skerry::render
