// SPDX-License-Identifier: MIT
//
// A strip below the scene: how far the demo is, when bodies hit each other and how hard, the script's notes.
#include <algorithm>
#include <cmath>
#include <imgui.h>

#include "render/gl_renderer.h"
#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {

void show_timeline(const PanelContext& context) {
  const OverlayContext& scene = context.scene;
  const render::Style& style = scene.style;
  render::Sheet& sheet = context.sheet;
  const std::size_t first = sheet.size();
  const double scale = context.scale;
  const double left = (kMarginPx + 42) * scale, right = scene.camera.width_px - (kMarginPx + 56) * scale;
  const double top = scene.camera.height_px - (kTimelinePx - 4) * scale;
  const double bar = top + 18 * scale;  // middle of the bar
  const auto at = [](double x, double y) {
    return render::Pixel{static_cast<float>(x), static_cast<float>(y)};
  };
  const double length = std::max({scene.demo.seconds(), scene.demo.time(), 1e-9});
  const auto to_x = [&](double time) { return left + (right - left) * std::clamp(time / length, 0.0, 1.0); };
  const auto size = static_cast<float>(std::round(kSmallLinePx * scale));
  const auto words = [&](double x, double y, render::Color color, const std::string& text,
                         render::Align align) {
    sheet.text(at(x, y), text, color, size, render::Face::Regular, align);
  };

  sheet.rect(at(0, top), at(scene.camera.width_px, scene.camera.height_px), style.panel);
  sheet.rect(at(left, bar - 2.5 * scale), at(right, bar + 2.5 * scale), style.panel_border,
             static_cast<float>(2.5 * scale));
  const double now = to_x(scene.demo.time());
  sheet.rect(at(left, bar - 2.5 * scale), at(now, bar + 2.5 * scale), style.accent,
             static_cast<float>(2.5 * scale));
  words(left - 8 * scale, bar - 8 * scale, style.text_dim, "0 s", render::Align::Right);
  words(right + 8 * scale, bar - 8 * scale, style.text_dim, si(length, "s"), render::Align::Left);

  // One tick a pixel at most: the hardest impact of those that fall into it.
  double hardest = 0;
  for (const Beat& beat : scene.history.beats()) hardest = std::max(hardest, beat.impulse);
  std::vector<double> columns(static_cast<std::size_t>(std::max(right - left, 1.0)) + 2, 0.0);
  for (const Beat& beat : scene.history.beats()) {
    double& column = columns[static_cast<std::size_t>(to_x(beat.time) - left)];
    column = std::max(column, beat.impulse);
  }
  for (std::size_t i = 0; i < columns.size(); ++i) {
    if (columns[i] <= 0) continue;
    const double high = (3 + 9 * std::sqrt(columns[i] / hardest)) * scale, x = left + static_cast<double>(i);
    sheet.line(at(x, bar - 2.5 * scale - high), at(x, bar - 2.5 * scale), style.impulse,
               static_cast<float>(1.5 * scale));
  }

  // Notes below the bar, where the last one leaves room.
  double free = left;
  for (const Note& note : scene.demo.notes()) {
    const double x = to_x(note.time);
    sheet.line(at(x, bar - 4 * scale), at(x, bar + 10 * scale), style.text, static_cast<float>(1.5 * scale));
    const double width = render::text_width(note.text, kSmallLinePx * render::kSheetEm) * scale;
    if (x < free || x + width + 4 * scale > right) continue;
    words(x + 5 * scale, bar + 5 * scale, style.text, note.text, render::Align::Left);
    free = x + width + 14 * scale;
  }
  sheet.fill(std::vector<render::Pixel>{at(now, bar - 3 * scale), at(now + 5 * scale, bar - 11 * scale),
                                        at(now - 5 * scale, bar - 11 * scale)}
                 .data(),
             3, style.accent);
  render::draw_sheet(sheet, first, sheet.size(), context.ui, *ImGui::GetBackgroundDrawList());
}

}  // namespace skerry::sandbox
