// SPDX-License-Identifier: MIT
#include "sandbox/window/gui.h"

#include <algorithm>
#include <imgui.h>

#include "sandbox/layout.h"

namespace skerry::sandbox {
namespace {

constexpr double kNotePx = 46;  // where a demo's note may be

/// The latest sentence for the user, in the middle above the toolbar.
void show_message(const Gui& gui) {
  if (!gui.bench.message()) return;
  const Message& message = *gui.bench.message();
  ImDrawList* draw = ImGui::GetForegroundDrawList();
  ImFont* font = gui.ui.regular();
  const float wrap = 0.62f * gui.width;
  const ImVec2 size = font->CalcTextSizeA(font->FontSize, wrap, wrap, message.text.c_str());
  const float pad = 12 * gui.scale, bar = 4 * gui.scale;
  const float usual = gui.height - static_cast<float>(gui.fit.toolbar_px() + kFooterPx + kNotePx) * gui.scale;
  const float bottom = std::min(usual, gui.note_top - 6 * gui.scale);
  const ImVec2 low(0.5f * (gui.width - size.x) - pad, bottom - size.y - 2 * pad);
  const ImVec2 high(low.x + size.x + 2 * pad, low.y + size.y + 2 * pad);
  draw->AddRectFilled(low, high, pack(gui.style.panel), 6 * gui.scale);
  draw->AddRect(low, high, pack(gui.style.panel_border), 6 * gui.scale);
  draw->AddRectFilled({low.x, low.y + pad}, {low.x + bar, high.y - pad},
                      pack(message.trouble ? gui.style.warning : gui.style.accent));
  draw->AddText(font, font->FontSize, {low.x + pad, low.y + pad}, pack(gui.style.text), message.text.c_str(),
                nullptr, wrap);
}

}  // namespace

bool begin_side_panel(const Gui& gui, const char* title, float width_px) {
  const float margin = static_cast<float>(kMarginPx) * gui.scale;
  const float top = static_cast<float>(kHeaderPx) * gui.scale;
  // The legend stays readable below it.
  const float bottom = gui.height - static_cast<float>(gui.fit.toolbar_px() + kFooterPx) * gui.scale;
  ImGui::SetNextWindowPos({margin, top});
  ImGui::SetNextWindowSize({width_px * gui.scale, bottom - top});
  ImGui::SetNextWindowBgAlpha(1);
  const bool open = ImGui::Begin(
      title, nullptr,
      ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings);
  ImGui::PushFont(gui.ui.bold());
  ImGui::TextUnformatted(title);
  ImGui::PopFont();
  ImGui::Dummy({0, 2 * gui.scale});
  return open;
}

void end_side_panel() {
  ImGui::End();
}

void show_gui(const Gui& gui) {
  show_toolbar(gui);
  if (gui.bench.panels.demos) show_demo_list(gui);
  if (gui.bench.panels.settings) show_settings(gui);
  if (gui.bench.panels.help) show_help(gui);
  show_message(gui);
}

}  // namespace skerry::sandbox
