// SPDX-License-Identifier: MIT
//
// 256 colours for a GIF.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/image.h"

namespace skerry::render {

/// A palette of at most 256 colours and the map into it, by median cut [Heckbert 1982] over 32768 cells: flat
/// colours, which cover most of our pictures, keep their exact value.
class Palette {
 public:
  Palette() = default;

  /// Chooses the colours for `image`.
  explicit Palette(const Image& image);

  /// Writes the index of the nearest colour for each pixel.
  /// @param indices  width * height bytes, top row first
  /// @return share of the pixels that are visibly wrong (more than 16 levels off): time for a new palette
  double map(const Image& image, std::uint8_t* indices, std::ptrdiff_t stride);

  [[nodiscard]] const std::array<Color, 256>& colors() const { return colors_; }
  [[nodiscard]] int size() const { return size_; }

 private:
  [[nodiscard]] std::uint8_t nearest(int r, int g, int b) const;

  std::array<Color, 256> colors_{};
  int size_ = 0;
  std::vector<std::int16_t> cells_;  // palette index by 15-bit colour; -1: not looked up yet
};

}  // namespace skerry::render
