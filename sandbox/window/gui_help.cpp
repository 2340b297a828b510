// SPDX-License-Identifier: MIT
//
// All keys on one page, from the tables of actions and overlays.
#include <cctype>
#include <imgui.h>

#include "sandbox/overlays/overlay.h"
#include "sandbox/window/actions.h"
#include "sandbox/window/gui.h"

namespace skerry::sandbox {
namespace {

constexpr float kLine = 1.5f;  // distance of lines in heights of the font

struct Line {
  std::string keys, what;
};

std::vector<Line> general_lines() {
  std::vector<Line> lines{{"Left button", "drag a body, or move the view"},
                          {"Right button", "a new body; drag: move the view"},
                          {"Wheel", "zoom"}};
  for (const KeyAction& action : actions())
    if (!action.keys.empty()) lines.push_back({std::string(action.keys), std::string(action.what)});
  return lines;
}

std::vector<Line> overlay_lines() {
  std::vector<Line> lines;
  for (const Overlay& overlay : overlays()) {
    if (overlay.key == 0) continue;
    lines.push_back(
        {std::string(1, static_cast<char>(std::toupper(overlay.key))), std::string(overlay.name)});
  }
  return lines;
}

void column(const Gui& gui, const char* title, const std::vector<Line>& lines, float x, float y,
            float key_width) {
  ImDrawList* draw = ImGui::GetWindowDrawList();
  ImFont* font = gui.ui.regular();
  ImFont* bold = gui.ui.bold();
  const float line = kLine * font->FontSize;
  draw->AddText(bold, bold->FontSize, {x, y}, pack(gui.style.accent), title);
  y += 1.25f * line;
  for (const Line& each : lines) {
    draw->AddText(bold, 0.94f * bold->FontSize, {x, y}, pack(gui.style.text), each.keys.c_str());
    draw->AddText(font, font->FontSize, {x + key_width, y}, pack(gui.style.text_dim), each.what.c_str());
    y += line;
  }
}

}  // namespace

void show_help(const Gui& gui) {
  const std::vector<Line> general = general_lines(), overlay = overlay_lines();
  const auto half = general.begin() + static_cast<std::ptrdiff_t>((general.size() + 1) / 2);
  const std::vector<Line> first(general.begin(), half), second(half, general.end());
  const float line = kLine * gui.ui.regular()->FontSize, pad = 26 * gui.scale;
  const std::size_t most = std::max(first.size(), overlay.size());
  const float width = 1040 * gui.scale, height = (static_cast<float>(most) + 1.25f) * line + 2 * pad;
  ImGui::SetNextWindowPos({0.5f * (gui.width - width), std::max(0.0f, 0.45f * (gui.height - height))});
  ImGui::SetNextWindowSize({width, height});
  ImGui::SetNextWindowFocus();
  ImGui::SetNextWindowBgAlpha(1);
  ImGui::Begin("##help", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  const ImVec2 at = ImGui::GetWindowPos();
  column(gui, "Mouse and time", first, at.x + pad, at.y + pad, 112 * gui.scale);
  column(gui, "Panels, bodies, files", second, at.x + 386 * gui.scale, at.y + pad, 76 * gui.scale);
  column(gui, "Overlays", overlay, at.x + 848 * gui.scale, at.y + pad, 30 * gui.scale);
  ImGui::End();
}

}  // namespace skerry::sandbox
