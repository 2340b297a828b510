// SPDX-License-Identifier: MIT
//
// The influence line of one member of a bridge: its force for one unit of load at each place of the deck, and
// where the axles are on it.
#include <algorithm>
#include <cstdio>

#include "sandbox/bridge_view.h"
#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/plot.h"
#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {
namespace {

constexpr int kPoints = 120;

}  // namespace

void show_influence(const PanelContext& context) {
  const render::Style& style = context.scene.style;
  for (const BridgeView& view : context.scene.demo.bridges()) {
    if (!view.influence) continue;
    const statics::Bridge& bridge = *view.bridge;
    const statics::Bridge::Line line = bridge.influence_line(*view.influence, kPoints);
    char text[96];
    std::snprintf(text, sizeof text, "Influence line of member %d", view.influence->index + 1);
    const Panel panel(context, text, kInfluencePx);
    Chart chart;
    chart.x_name = "load at x [m]";
    chart.x_high = bridge.deck_length();
    chart.last_values = false;
    // Axles are strokes from the axis to the line, a curve each: turning round would make needles of them.
    const char* name = "axles";
    chart.curves = {{"force per unit of load", style.friction, line.x, line.value}};
    for (const statics::Bridge::Axle& axle : bridge.axles()) {
      const double x = axle.station;
      if (x < 0 || x > bridge.deck_length()) continue;
      chart.curves.push_back({name, style.force, {x, x}, {0, bridge.influence_at(*view.influence, x)}});
      name = "";
    }
    draw_chart(chart, style, panel.at(0, 0), panel.width(), kInfluencePx - 20, context.scale, context.sheet);
    const statics::MemberState& state = bridge.members()[static_cast<std::size_t>(view.influence->index)];
    const auto [low, high] = std::minmax_element(line.value.begin(), line.value.end());
    std::snprintf(text, sizeof text, "from %.3g to %.3g; now %.1f kN", *low, *high, state.axial / 1e3);
    panel.small(0, kInfluencePx - 16, style.text, text);
  }
}

}  // namespace skerry::sandbox
