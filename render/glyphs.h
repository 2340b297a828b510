// SPDX-License-Identifier: MIT
//
// Glyphs of the label font, baked on demand into one picture with two channels: coverage, and a halo around
// it.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace skerry::render {

/// Reads the code point at `at` of UTF-8 text and moves `at` behind it; malformed bytes give U+FFFD, one a
/// byte.
char32_t next_code_point(std::string_view text, std::size_t& at);

/// Where a baked glyph is in the atlas, and where it goes relative to the pen on the baseline [px].
struct Glyph {
  std::uint16_t u = 0, v = 0, width = 0, height = 0;  ///< texels, halo included
  std::int16_t left = 0, top = 0;                     ///< of the picture's corner, y down
};

/// DejaVu Sans, drawn by stb_truetype without hinting. Glyphs are placed at whole pixels vertically and
/// quarter pixels horizontally: crisp stems and even spacing.
class GlyphAtlas {
 public:
  GlyphAtlas();
  ~GlyphAtlas();
  GlyphAtlas(const GlyphAtlas&) = delete;
  GlyphAtlas& operator=(const GlyphAtlas&) = delete;

  /// Advance of a code point at em size `size` [px].
  [[nodiscard]] double advance(char32_t code, double size) const;

  /// Height of capitals as a share of the em.
  [[nodiscard]] double cap_height() const { return cap_height_; }

  /// Bakes if needed.
  /// @param size     at most kLargest [px]
  /// @param quarter  horizontal offset in quarter pixels, 0 to 3
  /// @param halo     radius of the halo [px]
  /// @return null if the atlas is full: clear() and start the frame again, or go without when it is at its
  ///         tallest
  const Glyph* glyph(char32_t code, double size, int quarter, double halo);

  /// Forgets all glyphs and doubles the height, up to kTallest.
  void clear();

  static constexpr int kWidth = 1024, kTallest = 8192;
  static constexpr double kLargest = 500;
  [[nodiscard]] int height() const { return height_; }
  /// `kWidth` x height() texels of two bytes: coverage, halo.
  [[nodiscard]] const std::vector<std::uint8_t>& texels() const { return texels_; }
  /// Rows that changed since the last call: [first, last). Empty if first >= last.
  struct Rows {
    int first = 0, last = 0;
  };
  Rows take_dirty_rows();

 private:
  struct Font;
  bool place(int width, int height, int& u, int& v);

  std::unique_ptr<Font> font_;
  double cap_height_ = 0.73;
  int height_ = 512;
  int shelf_u_ = 0, shelf_v_ = 0, shelf_height_ = 0;
  Rows dirty_;
  std::vector<std::uint8_t> texels_;
  std::unordered_map<std::uint64_t, Glyph> baked_;  // only looked up, never walked
};

}  // namespace skerry::render
