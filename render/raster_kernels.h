// SPDX-License-Identifier: MIT
//
// The loops over pixels of the built-in rasteriser, compiled for four floats at a time and once more for the
// eight of AVX2. Both give the same bits (lanes.h). Used inside of render/ only.
#pragma once

#include <cstddef>
#include <cstdint>

#include "render/shape_batch.h"
#include "render/surface.h"

namespace skerry::render {

struct RasterKernels {
  /// Instances of one program, in their order. @param corners of ShapeBatches
  void (*shapes)(const Surface& surface, Program program, const ShapeInstance* shapes, std::size_t count,
                 const float* corners);
  /// A rectangle inside of the picture, x0..x1-1 by y0..y1-1, in one colour that covers each pixel alike.
  void (*fill)(const Surface& surface, int x0, int y0, int x1, int y1, Color color, float cover);
  /// Blends `color` by a table of coverages, 0 to 1, whose rows are padded with zeros to `stride`, a multiple
  /// of kLeastWidth. The table without its padding lies inside of the picture.
  void (*cover)(const Surface& surface, int x0, int y0, const float* covers, int stride, int width,
                int height, Color color);
  /// A row of RGBA to one plane of video. @return the first pixel that is left to do
  int (*weigh_row)(const std::uint8_t* from, std::uint8_t* to, int width, const int (&weight)[3], int offset);
  /// The same to luma.
  int (*luma_row)(const std::uint8_t* from, std::uint8_t* to, int width);
  /// Two rows of RGBA to colour of half the width, `width`. @return the first that is left to do
  int (*halve_rows)(const std::uint8_t* upper, const std::uint8_t* lower, std::uint8_t* cb, std::uint8_t* cr,
                    int width);
};

/// What this processor does fastest. @param avx2 false: as if it had no AVX2
const RasterKernels& raster_kernels(bool avx2 = true);

extern const RasterKernels kFourLanes;
extern const RasterKernels* const kEightLanes;  ///< null where there is no AVX2 to compile for

}  // namespace skerry::render
