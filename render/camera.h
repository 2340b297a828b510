// SPDX-License-Identifier: MIT
//
// Which part of the world is seen, and where it is in the picture.
#pragma once

#include "render/draw_list.h"

namespace skerry::render {

/// Maps the world [m], y up, to pixels, (0, 0) at the top left corner of the top left pixel, y down.
///
/// All in double: the difference to `centre` is taken before anything is rounded, so a scene at 1e9 m is as
/// sharp as one at the origin (as far as the double coordinates themselves are).
struct Camera {
  Point centre;         ///< in the middle of the picture [m]
  double height = 10;   ///< world height of the picture [m]
  int width_px = 1280;  ///< of the picture
  int height_px = 720;

  [[nodiscard]] double pixels_per_metre() const { return height_px / height; }
  [[nodiscard]] double width() const { return height * width_px / height_px; }

  [[nodiscard]] Point to_pixels(Point world) const {
    const double scale = pixels_per_metre();
    return {0.5 * width_px + (world.x - centre.x) * scale, 0.5 * height_px - (world.y - centre.y) * scale};
  }
  [[nodiscard]] Point to_world(Point pixel) const {
    const double scale = 1 / pixels_per_metre();
    return {centre.x + (pixel.x - 0.5 * width_px) * scale, centre.y - (pixel.y - 0.5 * height_px) * scale};
  }

  /// Zooms by `factor` (above 1: closer) so that the world point under `pixel` stays there.
  void zoom_at(Point pixel, double factor);

  /// Moves the world with the pointer by a number of pixels.
  void pan(double dx_px, double dy_px);

  /// Frames the box from `low` to `high` [m] with `margin` (a share of the picture on each side).
  /// A box of no size gets 1 m.
  void frame(Point low, Point high, double margin = 0.06);

  /// @throws std::invalid_argument with the values, unless centre is finite, height positive and finite, and
  /// the
  ///   picture has 1..32768 pixels on each side
  void validate() const;
};

}  // namespace skerry::render
