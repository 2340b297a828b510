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
constexpr float kPadPx = 26;

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

/// A list with its title. `key`: width of the keys, `width`: of all of it [px of the style].
struct Column {
  const char* title;
  std::vector<Line> lines;
  float key, width;

  float rows() const { return static_cast<float>(lines.size()) + 1.25f; }
};

/// @param scale  of the text, in units of the font's size and of the window's scale
void draw_column(const Gui& gui, const Column& column, float x, float y, float scale) {
  ImDrawList* draw = ImGui::GetWindowDrawList();
  ImFont* font = gui.ui.regular();
  ImFont* bold = gui.ui.bold();
  const float line = scale * kLine * font->FontSize;
  draw->AddText(bold, scale * bold->FontSize, {x, y}, pack(gui.style.accent), column.title);
  y += 1.25f * line;
  for (const Line& each : column.lines) {
    draw->AddText(bold, scale * 0.94f * bold->FontSize, {x, y}, pack(gui.style.text), each.keys.c_str());
    draw->AddText(font, scale * font->FontSize, {x + scale * column.key * gui.scale, y},
                  pack(gui.style.text_dim), each.what.c_str());
    y += line;
  }
}

/// Stacks of columns beside each other.
using Stacks = std::vector<std::vector<const Column*>>;

ImVec2 size_of(const Gui& gui, const Stacks& stacks) {
  const float line = kLine * gui.ui.regular()->FontSize;
  ImVec2 size(2 * kPadPx * gui.scale, 0);
  for (const std::vector<const Column*>& stack : stacks) {
    float width = 0, rows = static_cast<float>(stack.size()) - 1;
    for (const Column* column : stack) {
      width = std::max(width, column->width);
      rows += column->rows();
    }
    size.x += width * gui.scale;
    size.y = std::max(size.y, rows * line + 2 * kPadPx * gui.scale);
  }
  return size;
}

}  // namespace

void show_help(const Gui& gui) {
  const std::vector<Line> general = general_lines();
  const auto half = general.begin() + static_cast<std::ptrdiff_t>((general.size() + 1) / 2);
  const Column time{"Mouse and time", {general.begin(), half}, 112, 360};
  const Column files{"Panels, bodies, files", {half, general.end()}, 76, 462};
  const Column overlay{"Overlays", overlay_lines(), 30, 166};
  // Beside each other, or the first two below each other, whichever leaves the text larger.
  const Stacks wide{{&time}, {&files}, {&overlay}}, narrow{{&time, &files}, {&overlay}};
  const auto fitting = [&](const Stacks& stacks) {
    const ImVec2 size = size_of(gui, stacks);
    return std::min({1.0f, gui.width / size.x, gui.height / size.y});
  };
  const Stacks& stacks = fitting(wide) >= fitting(narrow) ? wide : narrow;
  const float scale = fitting(stacks), line = scale * kLine * gui.ui.regular()->FontSize,
              pad = scale * kPadPx * gui.scale;
  const ImVec2 whole = size_of(gui, stacks), size(scale * whole.x, scale * whole.y);
  ImGui::SetNextWindowPos({0.5f * (gui.width - size.x), std::max(0.0f, 0.45f * (gui.height - size.y))});
  ImGui::SetNextWindowSize(size);
  ImGui::SetNextWindowFocus();
  ImGui::SetNextWindowBgAlpha(1);
  ImGui::Begin("##help", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  const ImVec2 at = ImGui::GetWindowPos();
  float x = at.x + pad;
  for (const std::vector<const Column*>& stack : stacks) {
    float y = at.y + pad, width = 0;
    for (const Column* column : stack) {
      draw_column(gui, *column, x, y, scale);
      y += (column->rows() + 1) * line;
      width = std::max(width, column->width);
    }
    x += scale * width * gui.scale;
  }
  ImGui::End();
}

}  // namespace skerry::sandbox
