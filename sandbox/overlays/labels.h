// SPDX-License-Identifier: MIT
//
// Labels in the scene that never cover each other.
#pragma once

#include <initializer_list>
#include <string>
#include <vector>

#include "render/camera.h"
#include "render/draw_list.h"
#include "render/style.h"
#include "sandbox/scene_view.h"

namespace skerry::sandbox {

/// Places labels beside their points; one that finds no free side is left out.
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

  /// Later labels stay off this line.
  void avoid(Vec2 from, Vec2 to);

 private:
  struct Box {
    double left, top, right, bottom;
  };

  bool covered(const Box& box) const;

  const render::Camera& camera_;
  const render::Style& style_;
  render::DrawLayer& layer_;
  double scale_;
  std::vector<Box> taken_;
};

}  // namespace skerry::sandbox
