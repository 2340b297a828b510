// SPDX-License-Identifier: MIT
//
// Who gets which part of the picture: a header, a footer with legends, a column of panels, and the scene in
// what is left. Lengths are pixels of the style (720 lines) unless said.
#pragma once

#include "render/camera.h"
#include "render/draw_list.h"
#include "render/style.h"
#include "sandbox/demo.h"

namespace skerry::sandbox {

inline constexpr double kMarginPx = 14;
inline constexpr double kHeaderPx = 78;   ///< title and two lines of lesson
inline constexpr double kFooterPx = 40;   ///< legends and the length scale
inline constexpr double kColumnPx = 404;  ///< panels

/// Places the camera so that `view` fills the free part of the picture.
render::Camera place_camera(const View& view, int width_px, int height_px, bool column);

/// A view around all bodies of the world that have a size, for demos that do not say.
View fitted_view(const World& world);

/// Stacks panels below each other in the column.
class PanelLayout {
 public:
  PanelLayout(int width_px, double scale)
      : x_(width_px - (kColumnPx + kMarginPx) * scale), y_(kHeaderPx * scale), gap_(kMarginPx * scale) {}

  struct Position {
    double x, y;  ///< top left corner [px of the picture]
  };
  /// The place of the next panel. @param height [px of the picture]
  Position next(double height) {
    const Position position{x_, y_};
    y_ += height + gap_;
    return position;
  }

 private:
  double x_, y_, gap_;
};

/// Entries from left to right along the lower edge; each shows what a colour or an arrow's length means.
class Legend {
 public:
  Legend(const render::Camera& camera, const render::Style& style, render::DrawLayer& layer);

  void arrow(render::Color color, double length_px, const std::string& text);
  void marker(render::Color fill, render::Color outline, const std::string& text);
  void swatch(render::Paint paint, const std::string& text);
  /// A bar of `metres` at the right edge.
  void length_bar(double metres, double right_edge_px);

 private:
  render::Point at(double x, double y) const { return camera_.to_world({x, y}); }
  void text(const std::string& text);

  const render::Camera& camera_;
  const render::Style& style_;
  render::DrawLayer& layer_;
  double scale_;
  double x_, y_;  ///< where the next entry begins, and the middle line [px of the picture]
};

/// The largest of 1, 2, 5 times a power of ten that is not above `value` > 0.
double round_down_125(double value);
/// The same with 1, 1.5, 2, 3, 5, 7: for scales that nobody reads but that should change seldom.
double round_down(double value);

}  // namespace skerry::sandbox
