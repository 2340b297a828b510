// SPDX-License-Identifier: MIT
//
// Labels in the scene that never cover each other.
#pragma once

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "render/camera.h"
#include "render/draw_list.h"
#include "render/style.h"
#include "sandbox/layout.h"
#include "sandbox/scene_view.h"

namespace skerry::sandbox {

/// Places labels beside their points; one that finds no free side within the picture is left out.
class LabelPlacer {
 public:
  LabelPlacer(const render::Camera& camera, const render::Style& style, render::DrawLayer& layer)
      : camera_(camera), style_(style), layer_(layer), scale_(render::ui_scale(camera.height_px)) {}

  /// @param sides where the label may stand, best first  @param nearest distance from the point [px]
  /// @return whether there was room
  bool add(Vec2 at, const std::string& text, render::Color color,
           std::initializer_list<render::Anchor> sides = {render::Anchor::Right, render::Anchor::Left,
                                                          render::Anchor::Above, render::Anchor::Below},
           float nearest = 10);
  /// The same, below or above the point, else beside it off the horizontal through it.
  bool add_off_edges(Vec2 at, const std::string& text, render::Color color);

  /// Later labels stay off this line, and off this box.
  void avoid(Vec2 from, Vec2 to);
  void avoid(const PixelBox& box) { taken_.push_back(box); }
  /// Later labels stay off this line where there is a place that does.
  void shun(Vec2 from, Vec2 to);

 private:
  /// Where a label may stand: at a side of its point, `offset` from it, moved down by `down` [px of the
  /// style].
  struct Place {
    render::Anchor anchor;
    float offset, down = 0;
  };

  bool add(Vec2 at, const std::string& text, render::Color color, const std::vector<Place>& places);
  bool covered(const PixelBox& box) const;
  bool crossed(const PixelBox& box) const;

  const render::Camera& camera_;
  const render::Style& style_;
  render::DrawLayer& layer_;
  double scale_;
  std::vector<PixelBox> taken_;
  std::vector<std::pair<render::Point, render::Point>> lines_;  ///< that are shunned [px of the picture]
};

}  // namespace skerry::sandbox
