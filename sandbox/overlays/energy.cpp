// SPDX-License-Identifier: MIT
//
// Kinetic and potential energy of the dynamic bodies over the length of the demo, their sum, and what has
// been lost or gained since the start.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/plot.h"
#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {

Chart energy_chart(const OverlayContext& context) {
  const render::Style& style = context.style;
  Chart chart;
  chart.x_name = "t [s]";
  chart.x_high = std::max(context.demo.seconds(), context.demo.time());
  chart.curves = {{"kinetic", style.velocity, {}, {}},
                  {"potential", style.friction, {}, {}},
                  {"sum", style.text, {}, {}}};
  for (const LedgerSample& sample : context.history.ledger()) {
    const double values[] = {sample.kinetic, sample.potential, sample.kinetic + sample.potential};
    for (std::size_t k = 0; k < 3; ++k) {
      chart.curves[k].x.push_back(sample.time);
      chart.curves[k].y.push_back(values[k]);
    }
  }
  return chart;
}

void show_energy(const PanelContext& context) {
  const Panel panel(context, "Energy [J]", kEnergyPx);
  const Chart chart = energy_chart(context.scene);
  draw_chart(chart, context.scene.style, panel.at(0, 0), panel.width(), kEnergyPx - 20, context.scale,
             context.sheet);
  // Contacts and joints do no work at rest: what is missing went into impacts, friction, or came from forces.
  const std::vector<double>& sum = chart.curves[2].y;
  const double change = sum.back() - sum.front();
  constexpr double kRounding = 1e-14;  // of the sum
  const bool rounding = std::abs(change) <= kRounding * std::max(std::abs(sum.back()), std::abs(sum.front()));
  char text[96];
  std::snprintf(text, sizeof text, rounding ? "since the start 0 J" : "since the start %+.4g J", change);
  panel.small(0, kEnergyPx - 16, context.scene.style.text_dim, text);
}

}  // namespace skerry::sandbox
