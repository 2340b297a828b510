// SPDX-License-Identifier: MIT
#include "physics/stepping/stage_values.h"

#include <algorithm>
#include <cmath>

namespace skerry {
namespace {

// Shares of a step: stages before the first one are of low order, and those so near to each other tell the
// same.
constexpr double kEarliest = 0.1, kApart = 0.05;
// A parabola through three values is looked at if it gets lower than this share of their range.
constexpr double kNear = 0.25;
// Its lowest point is found once it moves by less than this share of the step, or is no lower than what was
// measured by this share of that.
constexpr double kSameTime = 1e-5, kSameValue = 0.1;
constexpr int kMostLooks = 10;

struct Sample {
  double theta = 0, value = 0;
};

/// The lowest point of the parabola through three samples in order, if it lies between them.
std::optional<Sample> lowest_point(const Sample& a, const Sample& b, const Sample& c) {
  const double ab = (b.value - a.value) / (b.theta - a.theta), bc = (c.value - b.value) / (c.theta - b.theta);
  const double curvature = (bc - ab) / (c.theta - a.theta);
  const double theta = 0.5 * (a.theta + b.theta) - 0.5 * ab / curvature;
  if (!(curvature > 0 && theta > a.theta && theta < c.theta)) return std::nullopt;
  return Sample{theta, a.value + (theta - a.theta) * (ab + curvature * (theta - b.theta))};
}

/// Whether the parabola through three samples comes near zero or below before `before`.
bool may_be_below(const Sample& a, const Sample& b, const Sample& c, double before) {
  const std::optional<Sample> guess = lowest_point(a, b, c);
  if (!guess || guess->theta >= before) return false;
  const auto [least, most] = std::minmax({a.value, b.value, c.value});
  return guess->value <= kNear * (most - least);
}

/// Goes down from three samples, of which parabolas say where to look. @return one below `-depth`, or none
std::optional<double> go_down(Sample a, Sample b, Sample c, double depth,
                              const std::function<double(double)>& at) {
  for (int look = 0; look < kMostLooks; ++look) {
    const std::optional<Sample> guess = lowest_point(a, b, c);
    if (!guess || std::abs(guess->theta - b.theta) < kSameTime) return std::nullopt;
    // Those at the stages are not exact: the first guess is measured in any case.
    if (look > 0 && guess->value > (1 - kSameValue) * b.value) return std::nullopt;
    const Sample found{guess->theta, at(guess->theta)};
    if (found.value < -depth) return found.theta;
    const bool left = found.theta < b.theta;
    if (found.value < b.value) {
      (left ? c : a) = b;
      b = found;
    } else {
      (left ? a : c) = found;
    }
  }
  return std::nullopt;
}

}  // namespace

void StageValues::begin(double from, double length) {
  from_ = from;
  length_ = length;
  open_ = true;
  stages_.clear();
  values_.clear();
}

bool StageValues::wants(double t) const {
  if (!open_) return false;
  const double theta = (t - from_) / length_;
  return theta > kEarliest && theta < 1 - kApart &&
         std::none_of(stages_.begin(), stages_.end(),
                      [&](const Stage& stage) { return std::abs(stage.theta - theta) < kApart; });
}

std::span<double> StageValues::add(double t, std::size_t functions) {
  const Stage stage{(t - from_) / length_, values_.size()};
  const auto later =
      std::find_if(stages_.begin(), stages_.end(), [&](const Stage& one) { return one.theta > stage.theta; });
  stages_.insert(later, stage);
  values_.resize(values_.size() + functions);
  return {values_.data() + stage.values, functions};
}

std::optional<double> StageValues::dip(std::size_t i, double low, double end, double before, double depth,
                                       const std::function<double(double)>& at) const {
  const auto sample = [&](std::size_t k) {
    return k < stages_.size() ? Sample{stages_[k].theta, values_[stages_[k].values + i]} : Sample{1, end};
  };
  // What stays below zero from somewhere on is no dip.
  std::size_t last = stages_.size();
  while (last > 0 && sample(last).value < 0) --last;
  Sample a{0, low}, b = sample(0);
  for (std::size_t k = 1; k <= last && a.theta < before; ++k) {
    const Sample c = sample(k);
    if (b.theta < before && b.value < -depth && at(b.theta) < -depth) return b.theta;
    if (may_be_below(a, b, c, before)) {
      const std::optional<double> found = go_down(a, b, c, depth, at);
      if (found && *found < before) return found;
    }
    a = b;
    b = c;
  }
  return std::nullopt;
}

}  // namespace skerry
