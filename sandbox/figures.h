// SPDX-License-Identifier: MIT
//
// Curves over the time of a demo as figures for papers.
#pragma once

#include <string>
#include <vector>

#include "render/style.h"
#include "sandbox/demo.h"
#include "sandbox/history.h"

namespace skerry::sandbox {

/// The values of a demo's watches after each step.
class WatchSeries {
 public:
  explicit WatchSeries(Demo& demo) { add(demo); }
  void add(Demo& demo);
  const std::vector<double>& times() const { return times_; }
  const std::vector<double>& values(std::size_t watch) const { return values_[watch]; }

 private:
  std::vector<double> times_;
  std::vector<std::vector<double>> values_;
};

/// The kinds of plots, for messages and help: "energy, momentum, residual, watches".
std::string plot_names();
/// @throws UsageError for an unknown kind
void check_plot(const std::string& what);

/// Draws a plot as SVG. @throws UsageError if the demo has no watches to draw
std::string plot_svg(const std::string& what, const Demo& demo, const History& history,
                     const WatchSeries& watches, const render::Style& style);

}  // namespace skerry::sandbox
