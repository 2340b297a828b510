// SPDX-License-Identifier: MIT
//
// Axes of projection for the methods that sort or hash intervals.
#pragma once

#include <vector>

#include "physics/broadphase/broadphase.h"

namespace skerry {

/// A closed interval on an axis [m].
struct Interval {
  double lower;
  double upper;
};

constexpr bool overlap(Interval a, Interval b) {
  return a.lower <= b.upper && b.lower <= a.upper;
}

/// A unit direction.
struct Axis {
  Vec2 direction;

  /// The interval of a box. It is monotone in the box even after rounding, so boxes with a common point have
  /// intervals with a common point.
  Interval project(const Aabb& box) const {
    const Vec2 d = direction;
    // A coordinate without weight is left out: it may be infinite in a query.
    const double x0 = d.x == 0 ? 0 : d.x * (d.x > 0 ? box.lower.x : box.upper.x);
    const double x1 = d.x == 0 ? 0 : d.x * (d.x > 0 ? box.upper.x : box.lower.x);
    const double y0 = d.y == 0 ? 0 : d.y * (d.y > 0 ? box.lower.y : box.upper.y);
    const double y1 = d.y == 0 ? 0 : d.y * (d.y > 0 ? box.upper.y : box.lower.y);
    return {x0 + y0, x1 + y1};
  }
};

/// The axes that the options name; by default two orthogonal ones at 29.7 degrees to x and y. Boxes pile up
/// in rows and columns, and all boxes of a column share one x interval: an axis along x proposes the whole
/// column as pairs, and its equal end points change places at every tremble. An oblique axis, whose slope is
/// not close to a ratio of small integers, puts the boxes of a row or column one after another.
inline std::vector<Axis> make_axes(const std::vector<double>& angles) {
  constexpr double kDefaultAngle = 0.518;
  std::vector<Axis> axes;
  for (const double angle : angles.empty() ? std::vector{kDefaultAngle, kDefaultAngle + kPi / 2} : angles) {
    const SinCos sc = sin_cos(angle);
    axes.push_back({{sc.cos, sc.sin}});
  }
  return axes;
}

}  // namespace skerry
