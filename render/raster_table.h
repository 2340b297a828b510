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

inline void fill_box(const Surface& surface, int x0, int y0, int x1, int y1, Color color) {
  const Ink ink(color);
  for (int y = y0; y < y1; ++y) fill_span(surface, y, x0, x1, ink);
}

inline constexpr RasterKernels kTable{paint_shapes, fill_box, weigh_row, halve_rows};

}  // namespace SKERRY_LANES
}  // namespace skerry::render
