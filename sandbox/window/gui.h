// SPDX-License-Identifier: MIT
//
// The controls of the window in Dear ImGui: toolbar with the timeline, list of demos, settings, help.
#pragma once

#include <imgui.h>

#include "render/style.h"
#include "render/ui_host.h"
#include "sandbox/window/window_fit.h"
#include "sandbox/window/workbench.h"

namespace skerry::sandbox {

/// What the controls are drawn with.
struct Gui {
  Workbench& bench;
  render::UiHost& ui;
  const render::Style& style;
  float width, height;  ///< of the window [px]
  WindowFit fit;
  float note_top;  ///< messages stand above this [px]
  float scale = static_cast<float>(fit.scale);
};

/// A colour as ImGui's draw lists take it.
inline ImU32 pack(render::Color color) {
  return IM_COL32(color.r, color.g, color.b, color.a);
}

/// All of them; between `begin_frame` and `end_frame`.
void show_gui(const Gui& gui);

// One file each.
void show_toolbar(const Gui& gui);
void show_demo_list(const Gui& gui);
void show_settings(const Gui& gui);
void show_help(const Gui& gui);

/// A panel at the left edge between header and toolbar. @return whether it is open
bool begin_side_panel(const Gui& gui, const char* title, float width_px);
void end_side_panel();

}  // namespace skerry::sandbox
