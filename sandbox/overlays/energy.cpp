// SPDX-License-Identifier: MIT
//
// Kinetic and potential energy of the dynamic bodies over the length of the demo, and their sum.
#include <algorithm>
#include <cstdio>

#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {
namespace {

constexpr double kPlotPx = 130;
constexpr double kTextPx = 24;

struct Curve {
  const char* name;
  render::Color color;
  double (*value)(const EnergySample&);
};

}  // namespace

void show_energy(const PanelContext& context) {
  const render::Style& style = context.scene.style;
  const std::vector<EnergySample>& samples = context.scene.history.energy();
  const Curve curves[] = {
      {"kinetic", style.velocity, [](const EnergySample& s) { return s.kinetic; }},
      {"potential", style.friction, [](const EnergySample& s) { return s.potential; }},
      {"sum", style.text, [](const EnergySample& s) { return s.kinetic + s.potential; }},
  };
  double low = 0;
  double high = 0;
  for (const EnergySample& sample : samples) {
    for (const Curve& curve : curves) {
      low = std::min(low, curve.value(sample));
      high = std::max(high, curve.value(sample));
    }
  }
  if (high <= low) high = low + 1;

  const Panel panel(context, "Energy [J]", kPlotPx + kTextPx);
  const auto scale = static_cast<float>(context.scale);
  const auto plot = static_cast<float>(kPlotPx) * scale;
  const auto to_y = [&](double value) {
    return panel.y() + plot * static_cast<float>(1 - (value - low) / (high - low));
  };
  panel.draw()->AddLine({panel.x(), to_y(0)}, {panel.x() + panel.width(), to_y(0)}, pack(style.panel_border));

  // As many points as the plot has pixels are enough.
  const std::size_t stride =
      std::max<std::size_t>(1, samples.size() / static_cast<std::size_t>(std::max(panel.width(), 1.0f)));
  float legend = panel.x();
  for (const Curve& curve : curves) {
    std::vector<ImVec2> points;
    for (std::size_t i = 0; i < samples.size(); i += stride) {
      const double share = std::min(1.0, samples[i].time / context.scene.demo.seconds());
      points.push_back(
          {panel.x() + panel.width() * static_cast<float>(share), to_y(curve.value(samples[i]))});
    }
    panel.draw()->AddPolyline(points.data(), static_cast<int>(points.size()), pack(curve.color), 0,
                              1.8f * scale);
    char text[48];
    std::snprintf(text, sizeof text, "%s %.3g", curve.name, curve.value(samples.back()));
    panel.text(legend, panel.y() + plot + 6 * scale, curve.color, text);
    // Columns, unless a long number needs more.
    legend += std::max(panel.width() / 3, ImGui::CalcTextSize(text).x + 10 * scale);
  }
}

}  // namespace skerry::sandbox
