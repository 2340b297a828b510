// SPDX-License-Identifier: MIT
#include "render/yuv.h"

#include "render/raster_kernels.h"
#include "render/yuv_blocks.h"

namespace skerry::render {

void to_yuv420(const Image& image, const YuvPlanes& out, bool avx2) {
  const RasterKernels& kernels = raster_kernels(avx2);
  const std::ptrdiff_t row = 4 * static_cast<std::ptrdiff_t>(image.width);
  for (int y = 0; y < image.height; y += 2) {
    const std::uint8_t* upper = image.rgba.data() + y * row;
    const std::uint8_t* lower = upper + row;
    for (int k = 0; k < 2; ++k) {
      const std::uint8_t* from = k == 0 ? upper : lower;
      std::uint8_t* to = out.plane[0] + (y + k) * out.stride[0];
      for (int x = kernels.luma_row(from, to, image.width); x < image.width; ++x)
        to[x] = combine(kLuma, from[4 * x], from[4 * x + 1], from[4 * x + 2], 16, 8);
    }
    std::uint8_t* cb = out.plane[1] + y / 2 * out.stride[1];
    std::uint8_t* cr = out.plane[2] + y / 2 * out.stride[2];
    for (int x = kernels.halve_rows(upper, lower, cb, cr, image.width / 2); x < image.width / 2; ++x) {
      const std::uint8_t *p = upper + 8 * x, *q = lower + 8 * x;
      const int r = p[0] + p[4] + q[0] + q[4], g = p[1] + p[5] + q[1] + q[5], b = p[2] + p[6] + q[2] + q[6];
      cb[x] = combine(kCb, r, g, b, 128, 10);
      cr[x] = combine(kCr, r, g, b, 128, 10);
    }
  }
}

void to_yuv444(const Image& image, const YuvPlanes& out, bool avx2) {
  const RasterKernels& kernels = raster_kernels(avx2);
  const std::ptrdiff_t row = 4 * static_cast<std::ptrdiff_t>(image.width);
  for (int y = 0; y < image.height; ++y) {
    const std::uint8_t* from = image.rgba.data() + y * row;
    for (int k = 0; k < 3; ++k) {
      const auto& weight = k == 0 ? kLuma : k == 1 ? kCb : kCr;
      const int offset = k == 0 ? 16 : 128;
      std::uint8_t* to = out.plane[k] + y * out.stride[k];
      for (int x = kernels.weigh_row(from, to, image.width, weight, offset); x < image.width; ++x)
        to[x] = combine(weight, from[4 * x], from[4 * x + 1], from[4 * x + 2], offset, 8);
    }
  }
}

}  // namespace skerry::render
