// SPDX-License-Identifier: MIT
//
// Draws a DrawList in memory, without OpenGL: for machines without a graphics processor.
#pragma once

#include <memory>

#include "render/camera.h"
#include "render/draw_list.h"
#include "render/gl_renderer.h"
#include "render/image.h"
#include "render/surface.h"

namespace skerry::render {

struct RasterKernels;

/// The same shapes as GlRenderer's by the same signed distances: pictures differ by roundings. A driver that
/// shades on the processor pays for blocks of pixels and for their whole shader; this one pays for the pixels
/// along the rim, and fills what is inside of it. One thread, the same bits on every machine.
class Canvas {
 public:
  /// @param width, height  final size [px]
  /// @param ssaa           1 to 4: the scene is drawn so many times finer in each direction, and averaged
  /// @param avx2           false: as if the processor had none; the picture is the same to the bit
  /// @throws std::invalid_argument as Target does
  explicit Canvas(int width, int height, int ssaa = 1, bool avx2 = true);
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  [[nodiscard]] int width() const;
  [[nodiscard]] int height() const;

  /// Starts a new picture: background, every layer.
  /// @throws std::invalid_argument for a bad camera, or one whose size differs from the canvas's
  DrawStats draw(const DrawList& list, const Camera& camera);

  /// The final picture, to draw panels on.
  [[nodiscard]] Surface surface();
  /// What draws on it.
  [[nodiscard]] const RasterKernels& kernels() const;

  /// Hands the picture out. The canvas takes the memory of `image` for the next one: nothing is copied.
  void take(Image& image);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace skerry::render
