// SPDX-License-Identifier: MIT
//
// Overlays: layers over the picture of a world, each one file and one row of the registry. The command-line
// value, the name in `show{...}`, the help text and the tests follow from the row.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "physics/world.h"
#include "render/camera.h"
#include "render/draw_list.h"
#include "render/style.h"
#include "sandbox/demo.h"
#include "sandbox/history.h"

namespace skerry::render {
class UiHost;
}

namespace skerry::sandbox {

class PanelLayout;
class Legend;

/// What an overlay may look at.
struct OverlayContext {
  const Demo& demo;
  const World& world;
  const History& history;
  const render::Style& style;
  const render::Camera& camera;
  Legend& legend;
};

/// What a panel draws with; null pointers never.
struct PanelContext {
  const OverlayContext& scene;
  render::UiHost& ui;
  PanelLayout& layout;
  double scale;  ///< pixels of the picture per pixel of the style
};

struct Overlay {
  std::string_view name;
  std::string_view summary;
  Observe needs{};  ///< observers it turns on
  /// Adds to the picture, in world coordinates; may be null.
  void (*draw)(const OverlayContext&, render::DrawList&) = nullptr;
  /// Calls ImGui; may be null.
  void (*panel)(const PanelContext&) = nullptr;
  bool column = false;  ///< the panel stands in the column on the right
};

/// All overlays in drawing order.
std::span<const Overlay> overlays();
std::vector<std::string> overlay_names();

}  // namespace skerry::sandbox
