// SPDX-License-Identifier: MIT
//
// Draws a DrawList with OpenGL 3.3 core.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>

#include "render/camera.h"
#include "render/draw_list.h"
#include "render/target.h"

namespace skerry::render {

/// What the last draw() did.
struct DrawStats {
  int shapes = 0;  ///< instances sent
  int culled = 0;  ///< items outside of the picture, or not finite
  int draw_calls = 0;
};

/// Draws each shape as one instanced quad whose fragment shader evaluates the signed distance to the shape:
/// antialiasing is analytic, sharp at every zoom, and the same on every driver up to rounding.
///
/// Outlines lie inside of the shape, so bodies that touch do not cover each other's edge. Blending is
/// premultiplied, in sRGB. Coordinates are subtracted from the camera in double; shapes much larger than the
/// picture are cut to it first, so that a ground of 1e9 m keeps a sharp edge. Items with a coordinate that is
/// not finite are left out.
class GlRenderer {
 public:
  /// Compiles the programs in the current context.
  /// @throws EnvironmentError with the driver's log
  GlRenderer();
  ~GlRenderer();
  GlRenderer(const GlRenderer&) = delete;
  GlRenderer& operator=(const GlRenderer&) = delete;

  /// Clears `target` to the background and draws every layer on the fine picture, then resolves it.
  /// @throws std::invalid_argument for a bad camera, or one whose size differs from the target's
  DrawStats draw(const DrawList& list, const Camera& camera, Target& target);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Width of `text` in pixels at `size_px` in the font of the labels (DejaVu Sans): to place labels and
/// legends.
[[nodiscard]] double text_width(std::string_view text, double size_px);

}  // namespace skerry::render
