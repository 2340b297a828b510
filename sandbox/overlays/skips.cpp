// SPDX-License-Identifier: MIT
//
// Work that the last step did not have to do, beside the work that it did.
#include <algorithm>

#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {

void show_skips(const PanelContext& context) {
  constexpr double kRowPx = 18;
  const render::Style& style = context.scene.style;
  const StepReport& r = context.scene.world.report();
  struct Line {
    const char* what;
    std::uint64_t skipped, all;
  };
  const auto count = [](auto value) { return static_cast<std::uint64_t>(value); };
  const std::uint64_t axes = r.narrow.axes_skipped + r.narrow.axes_tested;
  const SolveWork& w = r.work;
  const Line lines[] = {
      {"islands asleep, left out", count(r.islands_asleep), count(r.islands)},
      {"islands in flight, closed form", count(r.islands_in_flight), count(r.islands)},
      {"islands at rest, forces kept", count(r.islands_at_rest), count(r.islands)},
      {"pairs out of reach", count(r.pairs_out_of_reach), count(r.pairs)},
      // Of those that the step asked for: most pairs once a round and once a piece of the step.
      {"manifolds kept", count(r.manifolds_reused), count(r.manifolds_reused) + r.narrow.pairs},
      {"separating axes not tested", r.narrow.axes_skipped, axes},
      {"solves with a kept factor", count(w.resolves), count(w.resolves) + count(w.factorisations)},
      {"factorisations in part only", count(w.partial_factorisations),
       count(w.partial_factorisations) + count(w.factorisations)},
      {"orderings and patterns kept", count(w.symbolic_skipped),
       count(w.symbolic_skipped) + count(w.symbolic_analyses)},
  };
  static_assert(kRowPx * (std::size(lines) + 1) <= kSkipsPx);
  const Panel panel(context, "Skipped in this step", kRowPx * (std::size(lines) + 1));
  constexpr double kBarPx = 60, kNumberPx = 100;
  const double right = panel.width();
  panel.small(right, 0, style.text_dim, "skipped / all", render::Align::Right);
  double y = kRowPx;
  for (const Line& line : lines) {
    panel.fitted(0, y, right - kBarPx - kNumberPx - 12, line.all ? style.text : style.text_dim, line.what);
    const double left = right - kBarPx - kNumberPx;
    panel.rect(left, y + 4, kBarPx, kRowPx - 8, render::faded(style.panel_border, 0.6));
    if (line.all > 0) {
      // Sums over islands and rounds of the step need not be parts of each other to the last one.
      const double share = std::min(1.0, static_cast<double>(line.skipped) / static_cast<double>(line.all));
      panel.rect(left, y + 4, kBarPx * share, kRowPx - 8, style.accent);
    }
    panel.text(right, y, line.all ? style.text : style.text_dim,
               std::to_string(line.skipped) + " / " + std::to_string(line.all), render::Face::Regular,
               render::Align::Right);
    y += kRowPx;
  }
}

}  // namespace skerry::sandbox
