// SPDX-License-Identifier: MIT
//
// Labels in the scene that never cover each other.
#pragma once

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

  /// @param first the side that is tried first
  /// @return whether there was room
  bool add(Vec2 at, const std::string& text, render::Color color,
           render::Anchor first = render::Anchor::Right);

 private:
  struct Box {
    double left, top, right, bottom;
  };

  const render::Camera& camera_;
  const render::Style& style_;
  render::DrawLayer& layer_;
  double scale_;
  std::vector<Box> taken_;
};

}  // namespace skerry::sandbox
