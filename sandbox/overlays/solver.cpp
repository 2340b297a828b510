// SPDX-License-Identifier: MIT
//
// How the shown equations were solved: method and reasons, residual by iteration, states of the contacts,
// pivots.
#include <algorithm>
#include <cstdio>

#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/plot.h"
#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {
namespace {

constexpr std::size_t kMostNotes = 4;
constexpr double kPlotPx = 140, kStatesPx = 26;
static_assert((3 + kMostNotes) * kLinePx + kPlotPx + kStatesPx + kLinePx + 16 <= kSolverPx);

// A column an iteration, open above sticking above slipping.
void draw_states(const Panel& panel, const render::Style& style,
                 const std::vector<SolveIteration>& iterations, double y) {
  const double width = panel.width() / static_cast<double>(iterations.size());
  for (std::size_t i = 0; i < iterations.size(); ++i) {
    const SolveIteration& it = iterations[i];
    const int all = it.open + it.stick + it.slip;
    if (all == 0) continue;
    double top = y;
    const std::pair<int, render::Color> parts[] = {
        {it.open, style.panel_border}, {it.stick, style.friction}, {it.slip, style.impulse}};
    for (const auto& [count, color] : parts) {
      const double high = kStatesPx * count / all;
      panel.rect(static_cast<double>(i) * width, top, std::max(width - 1, 0.5), high, color);
      top += high;
    }
  }
}

}  // namespace

void show_solver(const PanelContext& context) {
  const render::Style& style = context.scene.style;
  const SystemRecord* record = context.scene.history.system();
  if (!record) {
    const Panel panel(context, "Solver", 24);
    panel.text(0, 0, style.text_dim, "nothing touches yet");
    return;
  }
  const std::vector<SolveIteration>& iterations = record->iterations;
  const bool curve = iterations.size() > 1;
  const bool states = std::any_of(iterations.begin(), iterations.end(),
                                  [](const SolveIteration& it) { return it.open + it.stick + it.slip > 0; });
  // The last reasons are those of the answer.
  const std::size_t first = record->notes.size() > kMostNotes ? record->notes.size() - kMostNotes : 0;
  const double height = (3 + static_cast<double>(record->notes.size() - first)) * kLinePx +
                        (curve ? kPlotPx : 0) + (states ? kStatesPx + kLinePx + 8 : 0) + 4;
  const Panel panel(context, "Solver", height);
  char text[200];
  std::snprintf(text, sizeof text, "%s, %s, %d rows, %.2f s", record->method.c_str(),
                std::string(to_string(record->status)).c_str(), record->system.size(), record->time);
  panel.fitted(0, 0, panel.width(), style.text, text);
  std::snprintf(text, sizeof text, "residual %.1e (rounding explains %.1e)", record->residual,
                residual_floor(record->system, record->lambda));
  panel.fitted(0, kLinePx, panel.width(), style.text_dim, text);
  double y = 2 * kLinePx;
  for (std::size_t i = first; i < record->notes.size(); ++i, y += kLinePx)
    panel.fitted(0, y, panel.width(), style.text_dim, "\xE2\x86\x92 " + record->notes[i]);
  int pivots = 0;
  for (const SolveIteration& it : iterations) pivots += it.pivots;
  if (iterations.empty())
    std::snprintf(text, sizeof text, "closed form or direct: no iterations");
  else
    std::snprintf(text, sizeof text, "%zu iterations, %d changes of state", iterations.size(), pivots);
  panel.text(0, y, style.text_dim, text);
  y += kLinePx + 4;
  if (curve) {
    Chart chart;
    chart.y_name = "relative residual";
    chart.x_name = "iteration";
    chart.logarithmic = true;
    chart.x_low = 1;
    chart.x_high = static_cast<double>(iterations.size());
    chart.curves.push_back({"", style.impulse, {}, {}});
    for (std::size_t i = 0; i < iterations.size(); ++i) {
      chart.curves[0].x.push_back(static_cast<double>(i + 1));
      chart.curves[0].y.push_back(iterations[i].residual);
    }
    draw_chart(chart, style, panel.at(0, y), panel.width(), kPlotPx, context.scale, context.sheet);
    // No legend: its line is free.
    y += kPlotPx - kLinePx + 2;
  }
  if (!states) return;
  draw_states(panel, style, iterations, y);
  y += kStatesPx + 4;
  const SolveIteration& last = iterations.back();
  double x = 0;
  const std::pair<std::string, render::Color> legend[] = {
      {"open " + std::to_string(last.open), style.panel_border},
      {"stick " + std::to_string(last.stick), style.friction},
      {"slip " + std::to_string(last.slip), style.impulse}};
  for (const auto& [words, color] : legend) {
    panel.rect(x, y + 3, 10, 10, color);
    panel.text(x + 15, y, style.text, words);
    x += 120;
  }
}

}  // namespace skerry::sandbox
