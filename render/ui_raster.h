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

/// Letters as they were drawn last: how much of each pixel they cover. Words that stay where they are, or
/// move by whole pixels, are not sampled again. To be emptied when their texels change.
class LetterCache {
 public:
  /// What the coverages follow from: texture coordinates and corners, those from the first pixel on.
  struct Key {
    float u0, v0, u1, v1, left, top, right, bottom;
    int width, height;  ///< [px]
    friend bool operator==(const Key&, const Key&) = default;
  };
  struct Letter {
    Key key{};
    int stride = 0;  ///< 0: empty
    std::vector<float> covers;
  };
  /// The place of a letter; it holds another one, or none, unless its key is the same.
  [[nodiscard]] Letter& at(const Key& key);
  void clear() { letters_.clear(); }

 private:
  std::vector<Letter> letters_;
};

/// @param white_u, white_v  a texel of `fonts` that covers all: solid shapes have it at every corner
void draw_panels(const Surface& surface, const RasterKernels& kernels, const ImDrawData& data,
                 const UiPixels& fonts, LetterCache& letters, float white_u, float white_v);

}  // namespace skerry::render
