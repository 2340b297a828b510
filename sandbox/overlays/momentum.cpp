// SPDX-License-Identifier: MIT
//
// Momentum and angular momentum (about the world's origin) of the dynamic bodies over the length of the demo.
#include <algorithm>
#include <cmath>

#include "sandbox/lua_args.h"
#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/plot.h"
#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {
namespace {

constexpr double kNegligible = 1e-10;  // share of the other quantity below which one is rounding

/// The power of ten that angular momentum is counted in, so that neither is flat in the chart of a large or a
/// small world; 1 where they are of one size.
double angular_unit(double linear, double angular) {
  if (linear <= kNegligible * angular || angular <= kNegligible * linear) return 1;
  const double exponent = std::log10(angular / linear);
  return std::abs(exponent) < 1 ? 1 : std::pow(10, std::round(exponent));
}

}  // namespace

void show_momentum(const PanelContext& context) {
  const render::Style& style = context.scene.style;
  const Panel panel(context, "Momentum", kMomentumPx);
  const std::vector<LedgerSample>& ledger = context.scene.history.ledger();
  double linear = 0, angular = 0;
  for (const LedgerSample& sample : ledger) {
    linear = std::max({linear, std::abs(sample.momentum.x), std::abs(sample.momentum.y)});
    angular = std::max(angular, std::abs(sample.angular_momentum));
  }
  const double unit = angular_unit(linear, angular);
  Chart chart;
  chart.y_name = "[kg m/s]; angular, about the origin [" + (unit == 1 ? "" : format_number(unit) + ' ') +
                 "kg m\xC2\xB2/s]";
  chart.x_name = "t [s]";
  chart.x_high = std::max(context.scene.demo.seconds(), context.scene.demo.time());
  chart.curves = {
      {"x", style.friction, {}, {}}, {"y", style.impulse, {}, {}}, {"angular", style.text, {}, {}}};
  for (const LedgerSample& sample : ledger) {
    const double values[] = {sample.momentum.x, sample.momentum.y, sample.angular_momentum / unit};
    for (std::size_t k = 0; k < 3; ++k) {
      chart.curves[k].x.push_back(sample.time);
      chart.curves[k].y.push_back(std::abs(values[k]) <= kNegligible * linear ? 0 : values[k]);
    }
  }
  draw_chart(chart, style, panel.at(0, 0), panel.width(), kMomentumPx, context.scale, context.sheet);
}

}  // namespace skerry::sandbox
