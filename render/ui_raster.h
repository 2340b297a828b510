// SPDX-License-Identifier: MIT
//
// Panels without OpenGL: ImGui's triangles blended into a picture in memory. Used inside of render/ only.
#pragma once

#include <cstdint>
#include <vector>

#include "render/raster_kernels.h"

struct ImDrawData;

namespace skerry::render {

/// What an ImTextureID points to: the texture of the driver, and its texels for those who draw without one.
struct UiPixels {
  unsigned name = 0;  ///< of the GL texture
  int width = 0, height = 0;
  int channels = 4;  ///< 1: coverage of white; 4: RGBA
  bool smooth = true;
  std::vector<std::uint8_t> texels;
};

/// @param white_u, white_v  a texel of `fonts` that covers all: solid shapes have it at every corner
void draw_panels(const Surface& surface, const RasterKernels& kernels, const ImDrawData& data,
                 const UiPixels& fonts, float white_u, float white_v);

}  // namespace skerry::render
