// SPDX-License-Identifier: MIT
//
// RGB to luma and chroma for video: BT.709, limited range (16..235, 16..240), 8 bits.
#pragma once

#include <cstddef>
#include <cstdint>

#include "render/image.h"

namespace skerry::render {

/// Three planes with `stride` bytes from row to row.
struct YuvPlanes {
  std::uint8_t* plane[3] = {nullptr, nullptr, nullptr};
  std::ptrdiff_t stride[3] = {0, 0, 0};
};

/// 4:2:0: one chroma sample for 2 x 2 pixels, their mean, sited in the middle.
/// @pre both sides of the image are even
/// @param avx2 false: as if the processor had none; the result is the same
void to_yuv420(const Image& image, const YuvPlanes& out, bool avx2 = true);

/// 4:4:4: a chroma sample for each pixel.
void to_yuv444(const Image& image, const YuvPlanes& out, bool avx2 = true);

}  // namespace skerry::render
