// SPDX-License-Identifier: MIT
//
// Overlays: layers over the picture of a world, each one file and one row of the registry. The command-line
// value, the name in `show{...}`, the hotkey, the help text and the tests follow from the row.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "physics/world.h"
#include "render/camera.h"
#include "render/draw_list.h"
#include "render/sheet.h"
#include "render/style.h"
#include "sandbox/demo.h"
#include "sandbox/history.h"
#include "sandbox/selection.h"

namespace skerry::render {
class UiHost;
}

namespace skerry::sandbox {

class PanelLayout;
class Legend;
class LabelPlacer;

/// What an overlay may look at. Panels may change the selection.
struct OverlayContext {
  const Demo& demo;
  const World& world;
  const History& history;
  const render::Style& style;
  const render::Camera& camera;
  Legend& legend;
  LabelPlacer& labels;  ///< of the scene
  Selection& selection;
};

/// What a panel draws with.
struct PanelContext {
  const OverlayContext& scene;
  render::UiHost& ui;
  PanelLayout& layout;
  render::Sheet& sheet;  ///< takes the marks of all panels
  double scale;          ///< pixels of the picture per pixel of the style
  int place = -1;        ///< of this panel in the layout
};

struct Overlay {
  std::string_view name;
  std::string_view summary;
  char key = 0;     ///< hotkey in the window
  Observe needs{};  ///< observers it turns on
  /// Adds to the picture, in world coordinates; may be null.
  void (*draw)(const OverlayContext&, render::DrawList&) = nullptr;
  /// Fills a panel; may be null.
  void (*panel)(const PanelContext&) = nullptr;
  double panel_px = 0;   ///< greatest height of the panel's content [px of the style]; 0: not in a column
  double footer_px = 0;  ///< room that it takes below the scene
};

/// All overlays in drawing order.
std::span<const Overlay> overlays();
std::vector<std::string> overlay_names();

}  // namespace skerry::sandbox
