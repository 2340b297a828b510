// SPDX-License-Identifier: MIT
//
// What falls below zero and comes back within an inner step.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace skerry {

/// Values of several functions of time at the stages of an inner step, which cost nothing as they are there.
/// They say where one may have a dip; whether it has one is measured.
class StageValues {
 public:
  /// Forgets those of the step before. @param from, length  of the step [s]
  void begin(double from, double length);
  /// What comes later are no stages, but forces of the continuous output.
  void end() { open_ = false; }
  /// True if values at this time tell something: some stages are next to each other, or of low order.
  bool wants(double t) const;
  /// Where the values of `functions` functions at this time go.
  std::span<double> add(double t, std::size_t functions);

  /// Share of the step, before `before`, at which function `i` is below `-depth` and from which it comes back;
  /// that of the first dip, or nearly so. None if it has none.
  /// @param low  its value at the beginning, above zero
  /// @param end  and that at the end
  /// @param at   it at a share of the step
  std::optional<double> dip(std::size_t i, double low, double end, double before, double depth,
                            const std::function<double(double)>& at) const;

 private:
  struct Stage {
    double theta = 0;
    std::size_t values = 0;  // where they begin
  };
  double from_ = 0, length_ = 0;
  bool open_ = false;
  std::vector<Stage> stages_;  // in the order of their times
  std::vector<double> values_;
};

}  // namespace skerry
