// SPDX-License-Identifier: MIT
#include "render/canvas.h"

#include <algorithm>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "render/glyphs.h"
#include "render/raster.h"
#include "render/raster_kernels.h"
#include "render/shape_batch.h"

namespace skerry::render {
namespace {

void paint_glyph(const Surface& surface, const GlyphInstance& glyph, const GlyphAtlas& atlas) {
  const Ink ink(glyph.color);
  const int left = static_cast<int>(glyph.corner[0]), top = static_cast<int>(glyph.corner[1]);
  const int x0 = std::max(left, 0), x1 = std::min(left + glyph.size[0], surface.width);
  const int y0 = std::max(top, 0), y1 = std::min(top + glyph.size[1], surface.height);
  for (int y = y0; y < y1; ++y) {
    const std::size_t v = static_cast<std::size_t>(glyph.texel[1] + y - top);
    const std::uint8_t* from = atlas.texels().data() +
                               2 * (v * GlyphAtlas::kWidth + static_cast<std::size_t>(glyph.texel[0])) +
                               glyph.channel;
    std::uint8_t* row = row_of(surface, y);
    for (int x = x0; x < x1; ++x) {
      const std::uint8_t cover = from[2 * (x - left)];
      if (cover > 0) blend_one(row + 4 * x, static_cast<float>(cover) / 255, ink);
    }
  }
}

}  // namespace

struct Canvas::State {
  int width, height, ssaa;
  const RasterKernels* kernels;
  std::vector<std::uint8_t> fine, final;  // `fine` is empty without ssaa
  GlyphAtlas atlas;
  ShapeBatches frame;
  // The background with its grid as it was drawn last: cameras rest most of the time.
  DrawLayer ground;
  Color ground_color;
  Camera ground_camera;
  DrawStats ground_stats;
  std::vector<std::uint8_t> ground_picture;  // empty: none yet
  std::vector<int> ground_row;               // the first row with the same pixels as each

  // Groups of pixels never leave the picture.
  int stride() const { return std::max(width, kLeastWidth); }
  Surface scene() {
    if (ssaa == 1) return {final.data(), stride(), height};
    return {fine.data(), std::max(width * ssaa, kLeastWidth), height * ssaa};
  }
  void average();
  bool has_ground(const DrawList& list, const Camera& camera) const {
    return !ground_picture.empty() && list.background == ground_color &&
           camera.centre == ground_camera.centre && camera.height == ground_camera.height &&
           list[Layer::Background] == ground;
  }
  void keep_ground(const Surface& from);
  void copy_ground(const Surface& to) const;
  /// Paints what `frame` holds.
  DrawStats paint_frame(const Surface& surface) const;
};

Canvas::Canvas(int width, int height, int ssaa, bool avx2) {
  if (width < 1 || height < 1 || width > 16384 || height > 16384 || ssaa < 1 || ssaa > 4) {
    throw std::invalid_argument("canvas: sides must be 1 to 16384 px and ssaa 1 to 4, got " +
                                std::to_string(width) + " x " + std::to_string(height) + " px, ssaa " +
                                std::to_string(ssaa));
  }
  state_ = std::make_unique<State>();
  State& s = *state_;
  s.width = width;
  s.height = height;
  s.ssaa = ssaa;
  s.kernels = &raster_kernels(avx2);
  s.frame.largest_point = 0;  // squares instead of triangles mean nothing here
  s.final.resize(std::size_t{4} * s.stride() * height);
  if (ssaa > 1)
    s.fine.resize(std::size_t{4} * static_cast<std::size_t>(std::max(width * ssaa, kLeastWidth)) * height *
                  ssaa);
}

Canvas::~Canvas() = default;

int Canvas::width() const {
  return state_->width;
}
int Canvas::height() const {
  return state_->height;
}

const RasterKernels& Canvas::kernels() const {
  return *state_->kernels;
}

Surface Canvas::surface() {
  return {state_->final.data(), state_->stride(), state_->height};
}

/// Mean of ssaa x ssaa pixels.
void Canvas::State::average() {
  const Surface from = scene();
  const int count = ssaa * ssaa;
  for (int y = 0; y < height; ++y) {
    std::uint8_t* to = final.data() + std::size_t{4} * y * stride();
    for (int x = 0; x < width; ++x, to += 4) {
      int sum[3] = {0, 0, 0};
      for (int v = 0; v < ssaa; ++v) {
        const std::uint8_t* p = row_of(from, y * ssaa + v) + 4 * x * ssaa;
        for (int u = 0; u < ssaa; ++u, p += 4)
          for (int k = 0; k < 3; ++k) sum[k] += p[k];
      }
      for (int k = 0; k < 3; ++k) to[k] = static_cast<std::uint8_t>((sum[k] + count / 2) / count);
      to[3] = 255;
    }
  }
}

/// The rows of a grid are few different ones: those stay in the cache, and half of the traffic is saved.
void Canvas::State::keep_ground(const Surface& from) {
  const std::size_t bytes = std::size_t{4} * static_cast<std::size_t>(from.width);
  ground_picture.assign(from.pixels, from.pixels + bytes * static_cast<std::size_t>(from.height));
  ground_row.resize(static_cast<std::size_t>(from.height));
  std::vector<int> different;
  for (int y = 0; y < from.height; ++y) {
    const auto same = std::find_if(different.begin(), different.end(), [&](int other) {
      return std::memcmp(row_of(from, y), row_of(from, other), bytes) == 0;
    });
    ground_row[static_cast<std::size_t>(y)] = same == different.end() ? y : *same;
    if (same == different.end() && different.size() < 16) different.push_back(y);
  }
}

void Canvas::State::copy_ground(const Surface& to) const {
  const std::size_t bytes = std::size_t{4} * static_cast<std::size_t>(to.width);
  for (int y = 0; y < to.height; ++y)
    std::memcpy(
        row_of(to, y),
        ground_picture.data() + bytes * static_cast<std::size_t>(ground_row[static_cast<std::size_t>(y)]),
        bytes);
}

DrawStats Canvas::draw(const DrawList& list, const Camera& camera) {
  State& s = *state_;
  camera.validate();
  if (camera.width_px != s.width || camera.height_px != s.height) {
    throw std::invalid_argument("canvas: the camera is for " + std::to_string(camera.width_px) + " x " +
                                std::to_string(camera.height_px) + " px, the canvas has " +
                                std::to_string(s.width) + " x " + std::to_string(s.height));
  }
  const Surface surface = s.scene();
  const int pixels = surface.width * surface.height;
  if (s.has_ground(list, camera)) {
    s.copy_ground(surface);
  } else {
    const Color c = list.background;
    s.kernels->fill({surface.pixels, pixels, 1}, 0, 0, pixels, 1, Color{c.r, c.g, c.b, 255}, 1);
    constexpr int kGround = static_cast<int>(Layer::Background);
    static_assert(kGround == 0);
    s.frame.build(list, camera, s.ssaa, s.atlas, kGround, kGround + 1);
    s.ground_stats = s.paint_frame(surface);
    s.ground = list[Layer::Background];
    s.ground_color = list.background;
    s.ground_camera = camera;
    s.keep_ground(surface);
  }
  s.frame.build(list, camera, s.ssaa, s.atlas, 1);
  const DrawStats rest = s.paint_frame(surface);
  if (s.ssaa > 1) s.average();
  return {s.ground_stats.shapes + rest.shapes, s.ground_stats.culled + rest.culled,
          s.ground_stats.draw_calls + rest.draw_calls};
}

DrawStats Canvas::State::paint_frame(const Surface& surface) const {
  for (const Batch& batch : frame.batches) {
    if (batch.program == Program::Text) {
      for (std::uint32_t i = 0; i < batch.count; ++i)
        paint_glyph(surface, frame.glyphs[batch.first + i], atlas);
    } else {
      kernels->shapes(surface, batch.program, frame.shapes.data() + batch.first, batch.count,
                      frame.corners.data());
    }
  }
  return {static_cast<int>(frame.shapes.size() + frame.glyphs.size()), frame.culled,
          static_cast<int>(frame.batches.size())};
}

void Canvas::take(Image& image) {
  State& s = *state_;
  image.width = s.width;
  image.height = s.height;
  if (s.width < s.stride()) {
    image.rgba.resize(std::size_t{4} * s.width * s.height);
    for (int y = 0; y < s.height; ++y)
      std::memcpy(image.rgba.data() + std::size_t{4} * y * s.width, row_of(surface(), y),
                  std::size_t{4} * static_cast<std::size_t>(s.width));
    return;
  }
  image.rgba.resize(s.final.size());
  image.rgba.swap(s.final);
}

}  // namespace skerry::render
