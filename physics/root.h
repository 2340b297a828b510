// SPDX-License-Identifier: MIT
//
// Roots of scalar functions of time.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "physics/math.h"

namespace skerry {

/// First t >= 0 with value + rate t + acceleration t^2 / 2 = 0, given value >= 0; infinite if there is none.
/// A zero at the start that rises from there does not count.
inline double first_root(double value, double rate, double acceleration) {
  if (rate >= 0) {
    if (acceleration >= 0) return kInfinity;
    return (rate + std::sqrt(rate * rate - 2 * acceleration * value)) / -acceleration;
  }
  const double square = rate * rate - 2 * acceleration * value;
  if (square < 0) return kInfinity;
  return 2 * value / (-rate + std::sqrt(square));
}

/// Root of `f` between `low` with f > 0 and `high` with f <= 0, to 1e-14 of `high`: false position with
/// reduced values at the end that stays [Anderson & Bjorck 1973], and bisection where that is slow.
template <class F>
double falling_root(F&& f, double low, double f_low, double high, double f_high) {
  const double width = 1e-14 * high;
  // When the same end moves twice the other's value is reduced, by as much as the last value fell.
  const auto shrink = [](double value, double before) {
    const double fall = 1 - value / before;
    return fall > 0 ? fall : 0.5;
  };
  int side = 0;
  double last = high;
  for (int i = 0; i < 100 && high - low > width && f_high != 0; ++i) {
    const bool bisect = i % 8 == 7 || !std::isfinite(f_low) || !std::isfinite(f_high);
    double t = bisect ? 0.5 * (low + high) : (low * f_high - high * f_low) / (f_high - f_low);
    t = std::clamp(t, low, high);
    if (std::abs(t - last) <= width) return t;
    last = t;
    const double value = f(t);
    if (value > 0) {
      if (t == low) break;
      if (side > 0) f_high *= shrink(value, f_low);
      low = t;
      f_low = value;
      side = 1;
    } else {
      if (t == high) break;
      if (side < 0) f_low *= shrink(value, f_high);
      high = t;
      f_high = value;
      side = -1;
    }
  }
  return high;
}

// A gap that is no rounding of none [m or rad].
constexpr double kParted = 1e-14;
// A time of which there is no millionth part [s].
constexpr double kNoTime = 1e-200;

/// First time in (0, h] at which a gap closes, or none. The gap changes by at most `speed` a second.
/// @param armed  the gap must have been wider than this before it can close; closer starts count as open
///               contacts until then, or until they have sunk in by as much; what parts by less and returns
///               closes where it does, lest it gains speed by what it sinks in
/// @param way  way(t, gap): how far it is to close at least, where it was measured at t
template <class Gap, class Way>
std::optional<double> closing_time(Gap&& gap, Way&& way, double speed, double h, double armed) {
  if (!(h > kNoTime)) return std::nullopt;
  double t = 0, value = gap(0.0);
  if (value <= armed) {
    // The start is a contact that parts: look where it has.
    double parted = 0, by = 0;  // when it was apart at last
    for (double dt = 1e-6 * h;; dt = std::min(2 * dt, h)) {
      t = dt;
      value = gap(t);
      if (value > armed) break;
      if (value <= 0 && by > 0) return falling_root(gap, parted, by, t, value);
      if (value < -armed) return t;
      if (value > kParted) {
        parted = t;
        by = value;
      }
      if (dt >= h) return std::nullopt;
    }
  }
  while (t < h) {
    // A pass that lasts less than a thousandth of the step may go unnoticed; it leaves no depth to speak of.
    const double next = std::min(h, t + std::max(way(t, value) / speed, 1e-3 * h));
    const double then = gap(next);
    if (then <= 0) return falling_root(gap, t, value, next, then);
    t = next;
    value = then;
  }
  return std::nullopt;
}

/// The same of a gap that says how far it is to close.
template <class Gap>
std::optional<double> closing_time(Gap&& gap, double speed, double h, double armed) {
  return closing_time(
      gap, [](double, double value) { return value; }, speed, h, armed);
}

}  // namespace skerry
