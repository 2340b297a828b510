// SPDX-License-Identifier: MIT
//
// Wall time of each stage of the step, mean over about ten steps. The one overlay that differs from run to
// run.
#include <algorithm>
#include <numeric>

#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {

void show_profile(const PanelContext& context) {
  constexpr double kRowPx = 18, kNamePx = 100, kTimePx = 80;
  static_assert(kRowPx * (kStageCount + 1) <= kProfilePx);
  const render::Style& style = context.scene.style;
  const std::array<double, kStageCount>& seconds = context.scene.history.stage_seconds();
  const Panel panel(context, "Time by stage", kRowPx * (kStageCount + 1));
  const double all = std::accumulate(seconds.begin(), seconds.end(), 0.0);
  const double most = *std::max_element(seconds.begin(), seconds.end());
  const double room = panel.width() - kNamePx - kTimePx;
  for (int k = 0; k < kStageCount; ++k) {
    const double y = k * kRowPx, value = seconds[static_cast<std::size_t>(k)];
    panel.text(0, y, style.text, std::string(stage_name(static_cast<Stage>(k))));
    if (most > 0) panel.rect(kNamePx, y + 3, room * value / most, kRowPx - 6, style.accent);
    panel.text(panel.width(), y, style.text, si(value, "s"), render::Face::Regular, render::Align::Right);
  }
  const double y = kStageCount * kRowPx;
  panel.line(0, y, panel.width(), y, style.panel_border);
  panel.text(0, y + 1, style.text_dim, "step");
  panel.text(panel.width(), y + 1, style.text_dim, si(all, "s"), render::Face::Regular, render::Align::Right);
}

}  // namespace skerry::sandbox
