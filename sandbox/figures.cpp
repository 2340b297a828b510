// SPDX-License-Identifier: MIT
#include "sandbox/figures.h"

#include <algorithm>
#include <cmath>

#include "render/svg.h"
#include "sandbox/errors.h"
#include "sandbox/names.h"
#include "sandbox/overlays/plot.h"

namespace skerry::sandbox {
namespace {

constexpr int kWidthPx = 720, kChartPx = 320, kSmallChartPx = 190, kTitlePx = 34, kFigureMarginPx = 16;

struct Sources {
  const Demo& demo;
  const History& history;
  const WatchSeries& watches;
  const render::Style& style;
};

Curve ledger_curve(const Sources& from, const char* name, render::Color color,
                   double (*value)(const LedgerSample&)) {
  Curve curve{name, color, {}, {}};
  for (const LedgerSample& sample : from.history.ledger()) {
    curve.x.push_back(sample.time);
    curve.y.push_back(value(sample));
  }
  return curve;
}

std::vector<Chart> energy(const Sources& from) {
  Chart chart;
  chart.y_name = "energy [J]";
  chart.curves = {
      ledger_curve(from, "kinetic", from.style.velocity, [](const LedgerSample& s) { return s.kinetic; }),
      ledger_curve(from, "potential", from.style.friction, [](const LedgerSample& s) { return s.potential; }),
      ledger_curve(from, "sum", from.style.text,
                   [](const LedgerSample& s) { return s.kinetic + s.potential; })};
  return {chart};
}

std::vector<Chart> momentum(const Sources& from) {
  Chart linear;
  linear.y_name = "momentum [kg m/s]";
  linear.curves = {
      ledger_curve(from, "x", from.style.friction, [](const LedgerSample& s) { return s.momentum.x; }),
      ledger_curve(from, "y", from.style.impulse, [](const LedgerSample& s) { return s.momentum.y; })};
  Chart angular;
  angular.y_name = "angular momentum about the origin [kg m\xC2\xB2/s]";
  angular.curves = {
      ledger_curve(from, "", from.style.text, [](const LedgerSample& s) { return s.angular_momentum; })};
  return {linear, angular};
}

std::vector<Chart> residual(const Sources& from) {
  Chart chart;
  chart.y_name = "worst residual of the islands, relative to the largest free velocity";
  chart.logarithmic = true;
  chart.curves = {
      ledger_curve(from, "", from.style.impulse, [](const LedgerSample& s) { return s.residual; })};
  return {chart};
}

std::vector<Chart> watched(const Sources& from) {
  const std::vector<Watch>& watches = from.demo.watches();
  if (watches.empty())
    throw UsageError("--curves watches: " + from.demo.name() + " has no watch(...) to draw");
  // One chart a unit: metres and newtons have no axis in common.
  std::vector<Chart> charts;
  for (std::size_t i = 0; i < watches.size(); ++i) {
    const std::string unit = watches[i].unit.empty() ? "1" : watches[i].unit;
    const std::string axis = "[" + unit + "]";
    auto chart = std::find_if(charts.begin(), charts.end(), [&](const Chart& c) { return c.y_name == axis; });
    if (chart == charts.end()) {
      chart = charts.emplace(charts.end());
      chart->y_name = axis;
    }
    const auto hue = static_cast<long>(6 + chart->curves.size());
    chart->curves.push_back({watches[i].what, render::body_paint(from.style, hue).outline,
                             from.watches.times(), from.watches.values(i)});
  }
  return charts;
}

struct Kind {
  const char* name;
  std::vector<Chart> (*make)(const Sources&);
};
constexpr Kind kKinds[] = {
    {"energy", energy}, {"momentum", momentum}, {"residual", residual}, {"watches", watched}};

std::vector<std::string> names() {
  std::vector<std::string> result;
  for (const Kind& kind : kKinds) result.emplace_back(kind.name);
  return result;
}

}  // namespace

void WatchSeries::add(Demo& demo) {
  times_.push_back(demo.time());
  const std::vector<double> now = demo.watch_values();
  values_.resize(now.size());
  for (std::size_t i = 0; i < now.size(); ++i) values_[i].push_back(now[i]);
}

std::string plot_names() {
  return join(names());
}

void check_plot(const std::string& what) {
  const std::vector<std::string> known = names();
  if (std::find(known.begin(), known.end(), what) == known.end())
    throw UsageError("--curves: no \"" + what + '"' + suggestion(what, known));
}

std::string plot_svg(const std::string& what, const Demo& demo, const History& history,
                     const WatchSeries& watches, const render::Style& style) {
  check_plot(what);
  const auto kind =
      std::find_if(std::begin(kKinds), std::end(kKinds), [&](const Kind& row) { return row.name == what; });
  const std::vector<Chart> charts = kind->make({demo, history, watches, style});
  constexpr double kWidth = kWidthPx - 2 * kFigureMarginPx;
  const auto height_of = [&](const Chart& chart) {
    return (charts.size() == 1 ? kChartPx : kSmallChartPx) +
           static_cast<int>(std::ceil(legend_extra_px(chart, kWidth)));
  };
  int height = kTitlePx;
  for (const Chart& chart : charts) height += height_of(chart) + kFigureMarginPx;
  render::Sheet sheet;
  sheet.text({kFigureMarginPx, 10}, demo.title(), style.text, 18, render::Face::Bold);
  float y = kTitlePx;
  for (Chart chart : charts) {
    chart.x_name = "t [s]";
    chart.x_high = std::max(demo.time(), demo.dt());
    draw_chart(chart, style, {kFigureMarginPx, y}, kWidth, height_of(chart), 1, sheet);
    y += static_cast<float>(height_of(chart) + kFigureMarginPx);
  }
  return render::to_svg(sheet, kWidthPx, height, style.background, demo.title());
}

}  // namespace skerry::sandbox
