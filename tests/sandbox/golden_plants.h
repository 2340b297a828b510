// SPDX-License-Identifier: MIT
//
// Regressions to plant in finished frames: whatever a person could break in a picture.
#pragma once

#include <functional>
#include <vector>

#include "render/draw_list.h"
#include "render/image.h"

namespace skerry::sandbox {

/// What a plant may change: the list, and the panels as ImGui windows.
struct Frame {
  render::DrawList& list;
  double px;  ///< a pixel [m]

  render::DrawLayer& operator[](render::Layer layer) const { return list[layer]; }
};

/// One regression.
struct Plant {
  const char* what;
  std::function<bool(const Frame&)> change;  ///< @return false where the scene has nothing of that kind
};

/// A change to the finished picture.
struct ImagePlant {
  const char* what;
  std::function<void(render::Image&)> change;
};

std::vector<Plant> body_plants();
std::vector<Plant> joint_plants();
std::vector<Plant> contact_plants();
std::vector<Plant> label_plants();
std::vector<Plant> panel_plants();
std::vector<ImagePlant> image_plants();

}  // namespace skerry::sandbox
