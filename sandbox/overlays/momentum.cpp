// SPDX-License-Identifier: MIT
//
// Momentum and angular momentum (about the world's origin) of the dynamic bodies over the length of the demo.
#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/plot.h"
#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {

void show_momentum(const PanelContext& context) {
  const render::Style& style = context.scene.style;
  const Panel panel(context, "Momentum", kMomentumPx);
  Chart chart;
  chart.y_name = "[kg m/s]; angular, about the origin [kg m\xC2\xB2/s]";
  chart.x_name = "t [s]";
  chart.x_high = context.scene.demo.seconds();
  chart.curves = {
      {"x", style.friction, {}, {}}, {"y", style.impulse, {}, {}}, {"angular", style.text, {}, {}}};
  for (const LedgerSample& sample : context.scene.history.ledger()) {
    const double values[] = {sample.momentum.x, sample.momentum.y, sample.angular_momentum};
    for (std::size_t k = 0; k < 3; ++k) {
      chart.curves[k].x.push_back(sample.time);
      chart.curves[k].y.push_back(values[k]);
    }
  }
  draw_chart(chart, style, panel.at(0, 0), panel.width(), kMomentumPx, context.scale, context.sheet);
}

}  // namespace skerry::sandbox
