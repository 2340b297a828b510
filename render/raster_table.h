// SPDX-License-Identifier: MIT
//
// The functions of raster_kernels.h, for the file that includes this.
#pragma once

#include "render/raster_kernels.h"
#include "render/raster_shapes.h"
#include "render/yuv_blocks.h"

namespace skerry::render {
inline namespace SKERRY_LANES {

inline void paint_shapes(const Surface& surface, Program program, const ShapeInstance* shapes,
                         std::size_t count, const float* corners) {
  for (std::size_t i = 0; i < count; ++i) paint_shape(surface, program, shapes[i], corners);
}

inline void fill_box(const Surface& surface, int x0, int y0, int x1, int y1, Color color, float cover) {
  const Ink ink(color);
  for (int y = y0; y < y1; ++y) fill_span(surface, y, x0, x1, ink, cover);
}

inline void cover_box(const Surface& surface, int x0, int y0, const float* covers, int stride, int width,
                      int height, Color color) {
  const Ink ink(color);
  const Brush brush(ink);
  // Beyond the right edge of the picture is its next row, or nothing.
  const int whole = lesser(width, (surface.width - x0) / kLanes * kLanes);
  for (int i = 0; i < height; ++i, covers += stride) {
    std::uint8_t* const row = row_of(surface, y0 + i) + 4 * x0;
    int x = 0;
    for (; x < whole; x += kLanes) {
      const Lanes cover = load(covers + x);
      if (!none_positive(cover)) blend(row + 4 * x, cover, brush);
    }
    for (; x < width; ++x)
      if (covers[x] > 0) blend_one(row + 4 * x, covers[x], ink);
  }
}

inline constexpr RasterKernels kTable{paint_shapes, fill_box, cover_box, weigh_row, luma_row, halve_rows};

}  // namespace SKERRY_LANES
}  // namespace skerry::render
