// SPDX-License-Identifier: MIT
//
// Who gets which part of the picture: a header, a footer with legends, a column of panels, and the scene in
// what is left. Lengths are pixels of the style (720 lines) unless said.
#pragma once

#include <string>
#include <vector>

#include "render/camera.h"
#include "render/draw_list.h"
#include "render/style.h"
#include "sandbox/demo.h"

namespace skerry::sandbox {

inline constexpr double kMarginPx = 14;
inline constexpr double kHeaderPx = 78;  ///< title and two lines of lesson
inline constexpr double kFooterPx = 40;  ///< legends and the length scale
inline constexpr double kLegendRowPx = 21;
inline constexpr double kColumnPx = 404;  ///< panels
/// Pictures with fewer lines show the scene alone: words would be larger than what they are about.
inline constexpr int kLeastLinesForWords = 160;

/// Places the camera so that `view` fills the part of the picture that header, footer and columns leave free.
/// @param columns of panels at the right
/// @param footer  height of what stands below the scene
/// @param header  height of what stands above it
render::Camera place_camera(const View& view, int width_px, int height_px, int columns,
                            double footer = kFooterPx, double header = kHeaderPx);

/// A view around all bodies of the world that have a size, for demos that do not say.
View fitted_view(const World& world);

/// Width of a view around x = `centre` that shows all dynamic bodies [m].
double moving_width(const World& world, double centre);

/// Gives every panel its place in columns at the right, the first one at the edge. Each panel asks for the
/// greatest height that it may need and keeps its column, so the scene has the same room in every frame.
class PanelLayout {
 public:
  /// @param footer height of what stands below the scene
  PanelLayout(int width_px, int height_px, double footer = kFooterPx);

  /// Reserves room. @param height greatest height, frame included
  /// @return number of the panel, or -1 if there is no room left; so also in pictures that are too narrow for
  ///         a column and a scene, or too low for words or for the panel
  int reserve(double height);
  int columns() const { return static_cast<int>(used_.size()); }
  /// Right edge of what the columns leave for the scene [px of the picture].
  double scene_right() const;

  /// Begins a frame: columns are empty again.
  void begin_frame();

  struct Position {
    double x, y;  ///< top left corner [px of the picture]
  };
  /// The place of panel `index` below those that were placed before it in its column.
  /// @param height now, frame included
  Position place(int index, double height);

  double scale() const { return scale_; }  ///< pixels of the picture per pixel of the style

 private:
  double width_, scale_, room_;
  std::size_t most_columns_;
  std::vector<double> used_, next_;  ///< by column
  std::vector<std::size_t> column_;  ///< by panel
};

/// A part of the picture [px].
struct PixelBox {
  double left, top, right, bottom;
};

/// Entries from left to right along the lower edge; each shows what a colour or an arrow's length means.
class Legend {
 public:
  /// @param scene_right where panels begin: lines above the first end there [px of the picture]
  /// @param below       height of what stands below the legend [px of the style]
  Legend(const render::Camera& camera, const render::Style& style, render::DrawLayer& layer,
         double scene_right, double below = 0);

  void arrow(render::Color color, double length_px, const std::string& text);
  void marker(render::Color fill, render::Color outline, const std::string& text);
  void swatch(render::Paint paint, const std::string& text);
  /// A bar between two ticks: what so many pixels mean.
  void bar(render::Color color, double length_px, const std::string& text);
  /// A bar of `metres` at the right edge; entries that would run into it begin a second line above the first.
  void length_bar(double metres, double right_edge_px);

  double top() const { return y_ - kLegendRowPx * 0.5 * scale_; }  ///< of the highest line [px]
  /// What an overlay shows above the lines.
  void occupy(const PixelBox& box) { boxes_.push_back(box); }
  /// What all entries cover, but for the length bar.
  const std::vector<PixelBox>& boxes() const { return boxes_; }

 private:
  render::Point at(double x, double y) const { return camera_.to_world({x, y}); }
  void make_room(double width);
  void text(const std::string& text);
  void ticked(double left, double right, double y, render::Color color);

  std::vector<PixelBox> boxes_;
  double scene_right_;
  const render::Camera& camera_;
  const render::Style& style_;
  render::DrawLayer& layer_;
  double scale_;
  double x_, y_;      ///< where the next mark or text begins, and the middle line [px of the picture]
  double begin_ = 0;  ///< of the entry
  double right_;      ///< where entries have to end
  double bottom_;     ///< middle line of the first line
};

/// A round amount with its unit: "0.5 N", but "5 mN" and "100 kN", as labels have them.
std::string round_amount(double amount, const char* unit);

/// The largest of 1, 2, 5 times a power of ten that is not above `value` > 0.
double round_down_125(double value);
/// The same with 1, 1.5, 2, 3, 5, 7: for scales that nobody reads but that should change seldom.
double round_down(double value);

}  // namespace skerry::sandbox
