// SPDX-License-Identifier: MIT
#include "render/glyphs.h"

#include <algorithm>
#include <cmath>
#include <stb_truetype.h>

#include "render/error.h"
#include "render/font_data.h"
#include "render/gl_renderer.h"

namespace skerry::render {

char32_t next_code_point(std::string_view text, std::size_t& at) {
  constexpr char32_t kBad = 0xfffd;
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char lead = byte(at++);
  if (lead < 0x80) return lead;
  const int more = lead >= 0xf0 && lead < 0xf8   ? 3
                   : lead >= 0xe0 && lead < 0xf0 ? 2
                   : lead >= 0xc0 && lead < 0xe0 ? 1
                                                 : 0;
  if (more == 0 || at + more > text.size()) return kBad;
  char32_t code = lead & (0x3f >> more);
  for (int i = 0; i < more; ++i) {
    if ((byte(at + i) & 0xc0) != 0x80) return kBad;
    code = code << 6 | (byte(at + i) & 0x3f);
  }
  at += static_cast<std::size_t>(more);
  return code;
}

struct GlyphAtlas::Font {
  stbtt_fontinfo info;
};

GlyphAtlas::GlyphAtlas() : font_(std::make_unique<Font>()) {
  const FontData data = sans_font();
  if (!stbtt_InitFont(&font_->info, data.bytes, stbtt_GetFontOffsetForIndex(data.bytes, 0))) {
    throw EnvironmentError("the font inside of the program is damaged");
  }
  int x0, y0, x1, y1;
  stbtt_GetCodepointBox(&font_->info, 'H', &x0, &y0, &x1, &y1);
  cap_height_ = y1 * static_cast<double>(stbtt_ScaleForMappingEmToPixels(&font_->info, 1));
  texels_.assign(static_cast<std::size_t>(kWidth) * height_ * 2, 0);
}

GlyphAtlas::~GlyphAtlas() = default;

double GlyphAtlas::advance(char32_t code, double size) const {
  int advance = 0, bearing = 0;
  stbtt_GetCodepointHMetrics(&font_->info, static_cast<int>(code), &advance, &bearing);
  return advance * size * static_cast<double>(stbtt_ScaleForMappingEmToPixels(&font_->info, 1));
}

bool GlyphAtlas::place(int width, int height, int& u, int& v) {
  if (shelf_u_ + width > kWidth) {
    shelf_v_ += shelf_height_;
    shelf_u_ = shelf_height_ = 0;
  }
  if (width > kWidth || shelf_v_ + height > height_) return false;
  u = shelf_u_;
  v = shelf_v_;
  shelf_u_ += width;
  shelf_height_ = std::max(shelf_height_, height);
  return true;
}

const Glyph* GlyphAtlas::glyph(char32_t code, double size, int quarter, double halo) {
  const auto eighths = static_cast<std::uint64_t>(std::lround(std::clamp(size, 1.0, kLargest) * 8));
  const auto halo_eighths = static_cast<std::uint64_t>(std::lround(std::clamp(halo, 0.0, 30.0) * 8));
  const std::uint64_t key = static_cast<std::uint64_t>(code) << 32 | eighths << 16 | halo_eighths << 8 |
                            static_cast<std::uint64_t>(quarter);
  if (const auto found = baked_.find(key); found != baked_.end()) return &found->second;

  const float scale = stbtt_ScaleForMappingEmToPixels(&font_->info, static_cast<float>(eighths) / 8.0f);
  const float shift = static_cast<float>(quarter) * 0.25f;
  int x0, y0, x1, y1;
  stbtt_GetCodepointBitmapBoxSubpixel(&font_->info, static_cast<int>(code), scale, scale, shift, 0, &x0, &y0,
                                      &x1, &y1);
  Glyph glyph;
  if (x1 > x0 && y1 > y0) {
    const double radius = static_cast<double>(halo_eighths) / 8;
    const int border = static_cast<int>(std::ceil(radius)) + 1;
    const int w = x1 - x0, h = y1 - y0;
    const int wide = w + 2 * border, tall = h + 2 * border;
    int u, v;
    if (!place(wide, tall, u, v)) return nullptr;
    std::vector<unsigned char> coverage(static_cast<std::size_t>(w) * h);
    stbtt_MakeCodepointBitmapSubpixel(&font_->info, coverage.data(), w, h, w, scale, scale, shift, 0,
                                      static_cast<int>(code));
    // Halo: coverage grown by a disc with a soft rim, each source pixel spreading its own value.
    const auto texel = [&](int x, int y) {
      return &texels_[2 * (static_cast<std::size_t>(v + y) * kWidth + static_cast<std::size_t>(u + x))];
    };
    for (int y = 0; y < tall; ++y) {
      for (int x = 0; x < wide; ++x) texel(x, y)[0] = texel(x, y)[1] = 0;
    }
    for (int y = 0; y < h; ++y) {
      for (int x = 0; x < w; ++x) {
        const int value = coverage[static_cast<std::size_t>(y) * w + x];
        if (value == 0) continue;
        texel(x + border, y + border)[0] = static_cast<std::uint8_t>(value);
        for (int dy = -border; dy <= border; ++dy) {
          for (int dx = -border; dx <= border; ++dx) {
            const double rim =
                std::clamp(radius + 0.5 - std::sqrt(static_cast<double>(dx * dx + dy * dy)), 0.0, 1.0);
            std::uint8_t& to = texel(x + border + dx, y + border + dy)[1];
            to = std::max(to, static_cast<std::uint8_t>(std::lround(value * rim)));
          }
        }
      }
    }
    glyph = {static_cast<std::uint16_t>(u),          static_cast<std::uint16_t>(v),
             static_cast<std::uint16_t>(wide),       static_cast<std::uint16_t>(tall),
             static_cast<std::int16_t>(x0 - border), static_cast<std::int16_t>(y0 - border)};
    if (dirty_.first >= dirty_.last) dirty_ = {v, v + tall};
    dirty_ = {std::min(dirty_.first, v), std::max(dirty_.last, v + tall)};
  }
  return &baked_.emplace(key, glyph).first->second;
}

void GlyphAtlas::clear() {
  baked_.clear();
  height_ = std::min(height_ * 2, kTallest);
  texels_.assign(static_cast<std::size_t>(kWidth) * height_ * 2, 0);
  shelf_u_ = shelf_v_ = shelf_height_ = 0;
  dirty_ = {0, height_};
}

GlyphAtlas::Rows GlyphAtlas::take_dirty_rows() {
  const Rows rows = dirty_;
  dirty_ = {};
  return rows;
}

double text_width(std::string_view text, double size_px) {
  static const GlyphAtlas atlas;
  double width = 0;
  for (std::size_t at = 0; at < text.size();) width += atlas.advance(next_code_point(text, at), size_px);
  return width;
}

}  // namespace skerry::render
