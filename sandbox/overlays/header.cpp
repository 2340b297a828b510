// SPDX-License-Identifier: MIT
//
// Title and lesson at the top, the time at the right, the script's latest note above the footer.
#include <cstdio>
#include <imgui.h>

#include "render/ui_host.h"
#include "sandbox/layout.h"
#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {
namespace {

constexpr double kNoteSeconds = 3;  // of the video

void show_note(const PanelContext& context, double speed, float width, float height) {
  const std::vector<Note>& notes = context.scene.demo.notes();
  if (notes.empty() || context.scene.demo.time() - notes.back().time > kNoteSeconds * speed) return;
  const render::Style& style = context.scene.style;
  ImDrawList* draw = ImGui::GetBackgroundDrawList();
  ImFont* font = context.ui.bold();
  const std::string& text = notes.back().text;
  const ImVec2 size = font->CalcTextSizeA(font->FontSize, width, 0, text.c_str());
  const float pad = static_cast<float>(8 * context.scale);
  const float bottom = height - static_cast<float>(kFooterPx * context.scale);
  const ImVec2 at(0.5f * (width - size.x), bottom - size.y - 2 * pad);
  draw->AddRectFilled({at.x - pad, at.y - pad}, {at.x + size.x + pad, at.y + size.y + pad}, pack(style.panel),
                      pad);
  draw->AddText(font, font->FontSize, at, pack(style.text), text.c_str());
}

}  // namespace

void show_header(const PanelContext& context, double speed) {
  const OverlayContext& scene = context.scene;
  const auto width = static_cast<float>(scene.camera.width_px);
  const auto height = static_cast<float>(scene.camera.height_px);
  const auto margin = static_cast<float>(kMarginPx * context.scale);
  const auto header = static_cast<float>(kHeaderPx * context.scale);
  ImDrawList* draw = ImGui::GetBackgroundDrawList();
  // A veil keeps the words readable when bodies fly through the header.
  draw->AddRectFilled({0, 0}, {width, header}, pack(render::faded(scene.style.halo, 0.85)));

  char clock[64];
  if (speed == 1)
    std::snprintf(clock, sizeof clock, "t = %.2f s", scene.demo.time());
  else
    std::snprintf(clock, sizeof clock, "t = %.3f s  (speed %g)", scene.demo.time(), speed);
  ImFont* mono = context.ui.mono();
  const ImVec2 clock_size = mono->CalcTextSizeA(mono->FontSize, width, 0, clock);
  draw->AddText(mono, mono->FontSize, {width - margin - clock_size.x, margin}, pack(scene.style.text_dim),
                clock);

  ImFont* title = context.ui.title();
  const auto top = static_cast<float>(8 * context.scale);
  draw->AddText(title, title->FontSize, {margin, top}, pack(scene.style.text), scene.demo.title().c_str());
  ImFont* regular = context.ui.regular();
  draw->AddText(regular, regular->FontSize, {margin, top + 1.25f * title->FontSize},
                pack(scene.style.text_dim), scene.demo.lesson().c_str(), nullptr,
                width - 3 * margin - clock_size.x);
  show_note(context, speed, width, height);
}

}  // namespace skerry::sandbox
