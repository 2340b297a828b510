// SPDX-License-Identifier: MIT
#include "render/ui_raster.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <imgui.h>
#include <utility>

#include "render/raster.h"

namespace skerry::render {
namespace {

struct Clip {
  int left, top, right, bottom;
};

Color to_color(ImU32 packed) {
  return {static_cast<std::uint8_t>(packed >> IM_COL32_R_SHIFT),
          static_cast<std::uint8_t>(packed >> IM_COL32_G_SHIFT),
          static_cast<std::uint8_t>(packed >> IM_COL32_B_SHIFT),
          static_cast<std::uint8_t>(packed >> IM_COL32_A_SHIFT)};
}

/// Straight colour, 0 to 1.
struct Tint {
  float r, g, b, a;
};

/// Two texels and the share of the second, along one axis.
struct Tap {
  int first, second;
  float share;
};
Tap tap(float coordinate, int size, bool smooth) {
  const float at = coordinate * static_cast<float>(size) - (smooth ? 0.5f : 0.0f);
  // Rounded down; beyond the texels the first and the last go on.
  const int low = static_cast<int>(std::clamp(at, -1.0f, static_cast<float>(size)) + 1) - 1;
  const auto texel = [&](int i) { return std::clamp(i, 0, size - 1); };
  const float share = std::clamp(at - static_cast<float>(low), 0.0f, 1.0f);
  return {texel(low), texel(low + 1), smooth ? share : 0};
}

Tint sample(const UiPixels& from, const Tap& u, const Tap& v) {
  const auto channel = [&](int k) {
    const auto at = [&](int x, int y) {
      return static_cast<float>(
          from.texels[static_cast<std::size_t>(from.channels) *
                          (static_cast<std::size_t>(y) * static_cast<std::size_t>(from.width) +
                           static_cast<std::size_t>(x)) +
                      static_cast<std::size_t>(k)]);
    };
    const auto row = [&](int y) {
      const float a = at(u.first, y);
      return u.share > 0 ? a + (at(u.second, y) - a) * u.share : a;
    };
    const float upper = row(v.first);
    return (v.share > 0 ? upper + (row(v.second) - upper) * v.share : upper) / 255;
  };
  if (from.channels == 1) return {1, 1, 1, channel(0)};
  return {channel(0), channel(1), channel(2), channel(3)};
}

void put(std::uint8_t* at, const Tint& tint, const Tint& texel) {
  const float a = tint.a * texel.a;
  if (!(a > 0)) return;
  Ink ink;
  ink.r = 255 * tint.r * texel.r * a;
  ink.g = 255 * tint.g * texel.g * a;
  ink.b = 255 * tint.b * texel.b * a;
  ink.a = a;
  blend_one(at, 1, ink);
}

Tint to_tint(ImU32 packed) {
  const Color c = to_color(packed);
  return {static_cast<float>(c.r) / 255, static_cast<float>(c.g) / 255, static_cast<float>(c.b) / 255,
          static_cast<float>(c.a) / 255};
}

/// Edges lie on 1/256 px, as drivers have them: the nearest, halves away from zero.
std::int64_t on_grid(float edge) {
  const double steps = static_cast<double>(edge * 256);
  return static_cast<std::int64_t>(steps < 0 ? steps - 0.5 : steps + 0.5);
}

/// The first pixel whose centre is not left of `edge`: a pixel belongs to the shape whose left or upper edge
/// goes through its centre.
int first_pixel(float edge) {
  return (static_cast<int>(on_grid(edge)) - 128 + 255) >> 8;
}

/// Whether no centre of a pixel is between the three, ends and roundings included.
bool misses_centres(float a, float b, float c) {
  constexpr float kHair = 1.0f / 128;
  const float low = std::min({a, b, c}) - 0.5f - kHair, high = std::max({a, b, c}) - 0.5f + kHair;
  if (!(std::abs(low) < 1e5f && std::abs(high) < 1e5f)) return false;
  auto centre = static_cast<float>(static_cast<int>(high));  // the last one that is not beyond `high`
  if (centre > high) centre -= 1;
  return centre < low;
}

/// One side of a triangle, from row to row: which pixels are inside of it, in whole numbers.
class Edge {
 public:
  Edge() = default;
  /// From (x0, y0) to (x1, y1) [1/256 px], which runs clockwise on the screen: inside is where
  /// dx (py - y) - dy (px - x) > 0, or = 0 on a left or upper edge. Begins with `row`.
  Edge(std::int64_t x0, std::int64_t y0, std::int64_t x1, std::int64_t y1, int row) {
    const std::int64_t dx = x1 - x0, dy = y1 - y0;
    const bool own = dy < 0 || (dy == 0 && dx > 0);
    const std::int64_t value =
        dx * (row * std::int64_t{256} + 128 - y0) - dy * (128 - x0) - (own ? 0 : 1);  // at pixel 0
    // Pixel px is inside if value - 256 dy px >= 0; the next row has 256 dx more.
    right_ = dy > 0;
    step_ = 256 * (dy < 0 ? -dy : dy);
    if (step_ == 0) {
      rest_ = value;
      rest_more_ = 256 * dx;
      return;
    }
    ratio_ = floor_ratio(value, step_);
    rest_ = value - ratio_ * step_;
    ratio_more_ = floor_ratio(256 * dx, step_);
    rest_more_ = 256 * dx - ratio_more_ * step_;
  }
  /// Cuts a row down to what is inside, and goes on to the next. @return whether nothing of it is
  bool cut(std::int64_t& low, std::int64_t& high) {
    const std::int64_t ratio = ratio_, rest = rest_;
    ratio_ += ratio_more_;
    rest_ += rest_more_;
    if (step_ == 0) return rest < 0;
    if (rest_ >= step_) {
      rest_ -= step_;
      ++ratio_;
    }
    if (right_)
      high = std::min(high, ratio + 1);
    else
      low = std::max(low, -ratio);
    return false;
  }

 private:
  static std::int64_t floor_ratio(std::int64_t a, std::int64_t b) {
    return a >= 0 ? a / b : -((-a + b - 1) / b);
  }

  // The ratio rounded down, and what is left of it.
  std::int64_t step_ = 0, ratio_ = 0, rest_ = 0, ratio_more_ = 0, rest_more_ = 0;
  bool right_ = false;
};

class PanelRaster {
 public:
  PanelRaster(const Surface& surface, const RasterKernels& kernels, const UiPixels& fonts,
              LetterCache& letters, float white_u, float white_v)
      : surface_(surface),
        kernels_(kernels),
        fonts_(fonts),
        letters_(letters),
        white_u_(white_u),
        white_v_(white_v) {}

  void draw(const ImDrawList& list, const ImDrawCmd& command) {
    const ImVec4 c = command.ClipRect;
    clip_ = {std::max(0, static_cast<int>(c.x)), std::max(0, static_cast<int>(c.y)),
             std::min(surface_.width, static_cast<int>(c.z)),
             std::min(surface_.height, static_cast<int>(c.w))};
    if (clip_.left >= clip_.right || clip_.top >= clip_.bottom) return;
    texture_ = static_cast<const UiPixels*>(command.GetTexID());
    const ImDrawVert* corners = list.VtxBuffer.Data + command.VtxOffset;
    const ImDrawIdx* index = list.IdxBuffer.Data + command.IdxOffset;
    for (unsigned i = 0; i + 3 <= command.ElemCount;) {
      const ImDrawIdx* at = index + i;
      if (i + 6 <= command.ElemCount && at[3] == at[0] && at[4] == at[2] &&
          rectangle(corners[at[0]], corners[at[1]], corners[at[2]], corners[at[5]])) {
        i += 6;
        continue;
      }
      triangle(corners[at[0]], corners[at[1]], corners[at[2]]);
      i += 3;
    }
  }

 private:
  bool is_white(const ImDrawVert& v) const {
    return texture_ == &fonts_ && v.uv.x == white_u_ && v.uv.y == white_v_;
  }

  /// Upright rectangles of one colour: backgrounds, cells, letters.
  /// @return false: it is none, nothing was drawn
  bool rectangle(const ImDrawVert& a, const ImDrawVert& b, const ImDrawVert& c, const ImDrawVert& d) {
    if (a.pos.y != b.pos.y || b.pos.x != c.pos.x || c.pos.y != d.pos.y || d.pos.x != a.pos.x) return false;
    if (a.col != b.col || a.col != c.col || a.col != d.col) return false;
    if (!(a.pos.x < c.pos.x) || !(a.pos.y < c.pos.y) || std::abs(a.pos.x) > 1e5f ||
        std::abs(c.pos.x) > 1e5f || std::abs(a.pos.y) > 1e5f || std::abs(c.pos.y) > 1e5f)
      return false;
    const int x0 = std::max(first_pixel(a.pos.x), clip_.left),
              x1 = std::min(first_pixel(c.pos.x), clip_.right);
    const int y0 = std::max(first_pixel(a.pos.y), clip_.top),
              y1 = std::min(first_pixel(c.pos.y), clip_.bottom);
    if (is_white(a) && is_white(b) && is_white(c) && is_white(d)) {
      kernels_.fill(surface_, x0, y0, x1, y1, to_color(a.col), 1);
      return true;
    }
    if (a.uv.y != b.uv.y || b.uv.x != c.uv.x || c.uv.y != d.uv.y || d.uv.x != a.uv.x) return false;
    if (x0 >= x1 || y0 >= y1) return true;
    const float du = (c.uv.x - a.uv.x) / (c.pos.x - a.pos.x), dv = (c.uv.y - a.uv.y) / (c.pos.y - a.pos.y);
    const auto columns = [&] {
      columns_.clear();
      for (int x = x0; x < x1; ++x)
        columns_.push_back(
            tap(a.uv.x + (static_cast<float>(x) + 0.5f - a.pos.x) * du, texture_->width, texture_->smooth));
    };
    const auto line = [&](int y) {
      return tap(a.uv.y + (static_cast<float>(y) + 0.5f - a.pos.y) * dv, texture_->height, texture_->smooth);
    };
    if (texture_ == &fonts_) {
      // Differences of such numbers are exact: the key says all that the coverages follow from.
      const auto left = static_cast<float>(x0), top = static_cast<float>(y0);
      const LetterCache::Key key{a.uv.x,        a.uv.y,         c.uv.x,        c.uv.y,  a.pos.x - left,
                                 a.pos.y - top, c.pos.x - left, c.pos.y - top, x1 - x0, y1 - y0};
      LetterCache::Letter& letter = letters_.at(key);
      if (letter.stride == 0 || !(letter.key == key)) {
        columns();
        letter.key = key;
        letter.stride = (x1 - x0 + kLeastWidth - 1) / kLeastWidth * kLeastWidth;
        letter.covers.assign(static_cast<std::size_t>(letter.stride) * static_cast<std::size_t>(y1 - y0), 0);
        for (int y = y0; y < y1; ++y)
          cover_row(line(y), letter.covers.data() + static_cast<std::ptrdiff_t>(y - y0) * letter.stride);
      }
      kernels_.cover(surface_, x0, y0, letter.covers.data(), letter.stride, x1 - x0, y1 - y0,
                     to_color(a.col));
      return true;
    }
    columns();
    const Tint tint = to_tint(a.col);
    for (int y = y0; y < y1; ++y) {
      const Tap v = line(y);
      std::uint8_t* row = row_of(surface_, y);
      for (int x = x0; x < x1; ++x)
        put(row + 4 * x, tint, sample(*texture_, columns_[static_cast<std::size_t>(x - x0)], v));
    }
    return true;
  }

  /// A row of a letter: coverage between the texels of columns_.
  void cover_row(const Tap& v, float* out) const {
    const auto texels = [&](int y) {
      return texture_->texels.data() +
             static_cast<std::size_t>(y) * static_cast<std::size_t>(texture_->width);
    };
    const std::uint8_t *const upper = texels(v.first), *const lower = texels(v.second);
    const float below = v.share / 255, above = 1.0f / 255 - below;
    for (const Tap& u : columns_) {
      const float first =
          static_cast<float>(upper[u.first]) * above + static_cast<float>(lower[u.first]) * below;
      const float second =
          static_cast<float>(upper[u.second]) * above + static_cast<float>(lower[u.second]) * below;
      *out++ = std::clamp(first + (second - first) * u.share, 0.0f, 1.0f);
    }
  }

  /// Any triangle, by the rule of drivers: pixels whose centres are inside, those on a left or upper edge
  /// too, so that neighbours share none. Edges by whole numbers.
  void triangle(const ImDrawVert& first, const ImDrawVert& second, const ImDrawVert& third) {
    const ImDrawVert* v[3] = {&first, &second, &third};
    // Curves are made of slivers: most lie between the centres of pixels.
    if (misses_centres(first.pos.x, second.pos.x, third.pos.x) ||
        misses_centres(first.pos.y, second.pos.y, third.pos.y))
      return;
    std::int64_t x[3], y[3];
    for (int i = 0; i < 3; ++i) {
      if (!(std::abs(v[i]->pos.x) < 1e5f) || !(std::abs(v[i]->pos.y) < 1e5f)) return;
      x[i] = on_grid(v[i]->pos.x);
      y[i] = on_grid(v[i]->pos.y);
    }
    std::int64_t area = (x[1] - x[0]) * (y[2] - y[0]) - (y[1] - y[0]) * (x[2] - x[0]);
    if (area == 0) return;
    if (area < 0) {
      std::swap(v[1], v[2]);
      std::swap(x[1], x[2]);
      std::swap(y[1], y[2]);
      area = -area;
    }
    const bool white = is_white(first) && is_white(second) && is_white(third);
    const bool flat = first.col == second.col && first.col == third.col;
    const Ink ink(to_color(first.col));
    const Tint tint[3] = {to_tint(v[0]->col), to_tint(v[1]->col), to_tint(v[2]->col)};
    const int top = std::max(clip_.top, static_cast<int>((std::min({y[0], y[1], y[2]}) + 127) >> 8));
    const int bottom =
        std::min(clip_.bottom, static_cast<int>((std::max({y[0], y[1], y[2]}) + 127) >> 8) + 1);
    if (top >= bottom) return;
    Edge edges[3];
    for (int i = 0; i < 3; ++i) {
      const int k = (i + 1) % 3;
      edges[i] = Edge(x[i], y[i], x[k], y[k], top);
    }
    for (int row = top; row < bottom; ++row) {
      const std::int64_t at = row * std::int64_t{256} + 128;
      std::int64_t low = clip_.left, high = clip_.right;  // pixels low..high-1
      bool empty = false;
      for (Edge& edge : edges) empty |= edge.cut(low, high);
      if (empty || low >= high) continue;
      const int x0 = static_cast<int>(low), x1 = static_cast<int>(high);
      if (white && flat) {
        kernels_.fill(surface_, x0, row, x1, row + 1, to_color(first.col), 1);
        continue;
      }
      // Shares of the corners at the centre of a pixel, and their change to the next.
      const float scale = 1 / static_cast<float>(area);
      float share[3], slope[3];
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        const std::int64_t dx = x[k] - x[j], dy = y[k] - y[j];
        const std::int64_t value = dx * (at - y[j]) - dy * (x0 * std::int64_t{256} + 128 - x[j]);
        share[i] = static_cast<float>(value) * scale;
        slope[i] = static_cast<float>(-256 * dy) * scale;
      }
      const auto mix = [&](float p, float q, float r, const float(&w)[3]) {
        return p * w[0] + q * w[1] + r * w[2];
      };
      // Texture coordinates change evenly along a row.
      const float u = mix(v[0]->uv.x, v[1]->uv.x, v[2]->uv.x, share),
                  du = mix(v[0]->uv.x, v[1]->uv.x, v[2]->uv.x, slope),
                  w = mix(v[0]->uv.y, v[1]->uv.y, v[2]->uv.y, share),
                  dw = mix(v[0]->uv.y, v[1]->uv.y, v[2]->uv.y, slope);
      if (flat && texture_->channels == 1 && du == 0 && dw == 0) {
        // An upright line: one texel for all of the row.
        const Tint texel = sample(*texture_, tap(u, texture_->width, texture_->smooth),
                                  tap(w, texture_->height, texture_->smooth));
        if (texel.a > 0) kernels_.fill(surface_, x0, row, x1, row + 1, to_color(first.col), texel.a);
        continue;
      }
      std::uint8_t* at_pixel = row_of(surface_, row) + 4 * x0;
      for (int px = 0; px < x1 - x0; ++px, at_pixel += 4) {
        const auto steps = static_cast<float>(px);
        Tint texel{1, 1, 1, 1};
        if (!white)
          texel = sample(*texture_, tap(u + du * steps, texture_->width, texture_->smooth),
                         tap(w + dw * steps, texture_->height, texture_->smooth));
        if (flat) {
          if (texture_->channels == 1 && texel.a > 0)
            blend_one(at_pixel, texel.a, ink);
          else if (texture_->channels != 1)
            put(at_pixel, tint[0], texel);
          continue;
        }
        const float parts[3] = {share[0] + slope[0] * steps, share[1] + slope[1] * steps,
                                share[2] + slope[2] * steps};
        put(at_pixel,
            {mix(tint[0].r, tint[1].r, tint[2].r, parts), mix(tint[0].g, tint[1].g, tint[2].g, parts),
             mix(tint[0].b, tint[1].b, tint[2].b, parts), mix(tint[0].a, tint[1].a, tint[2].a, parts)},
            texel);
      }
    }
  }

  const Surface& surface_;
  const RasterKernels& kernels_;
  const UiPixels& fonts_;
  LetterCache& letters_;
  const float white_u_, white_v_;
  const UiPixels* texture_ = nullptr;
  Clip clip_{};
  std::vector<Tap> columns_;
};

}  // namespace

LetterCache::Letter& LetterCache::at(const Key& key) {
  // A word on the screen has its letters at many fractions of a pixel; what does not fit is sampled anew.
  constexpr std::size_t kPlaces = 4096;
  if (letters_.empty()) letters_.resize(kPlaces);
  std::uint64_t hash = 0;
  for (const float part : {key.u0, key.v0, key.left, key.top, key.right, key.u1}) {
    std::uint32_t bits;
    std::memcpy(&bits, &part, sizeof bits);
    hash = (hash ^ bits) * 0x9e3779b97f4a7c15u;
    hash ^= hash >> 29;
  }
  return letters_[hash % kPlaces];
}

void draw_panels(const Surface& surface, const RasterKernels& kernels, const ImDrawData& data,
                 const UiPixels& fonts, LetterCache& letters, float white_u, float white_v) {
  PanelRaster raster(surface, kernels, fonts, letters, white_u, white_v);
  for (int n = 0; n < data.CmdListsCount; ++n) {
    const ImDrawList& list = *data.CmdLists[n];
    for (const ImDrawCmd& command : list.CmdBuffer) {
      if (command.UserCallback == nullptr) {
        raster.draw(list, command);
      } else if (command.UserCallback != ImDrawCallback_ResetRenderState) {
        command.UserCallback(&list, &command);
      }
    }
  }
}

}  // namespace skerry::render
