// SPDX-License-Identifier: MIT
//
// The part of a ray that a structure has to look at: cut by what the structure knows of the boxes' places,
// and projected on its axes. Everything is wider than the slab test of `RayTest` by more than rounding.
#pragma once

#include <algorithm>
#include <cfloat>
#include <cmath>

#include "physics/broadphase/axis.h"

namespace skerry {

inline constexpr Axis kAxisX{{1, 0}};
inline constexpr Axis kAxisY{{0, 1}};

/// A stretch [t0, t1] of a ray.
class RayReach {
 public:
  explicit RayReach(const Ray& ray) : origin_(ray.origin), direction_(ray.direction), t1_(ray.t_max) {}

  bool is_empty() const { return !(t0_ <= t1_); }

  /// Keeps the stretch whose projection on `axis` is within `range`.
  void clip(const Axis& axis, Interval range) {
    const double along = dot(direction_, axis.direction), size = magnitude(direction_, axis.direction);
    const double start = dot(origin_, axis.direction);
    const double pad =
        kMargin * (magnitude(origin_, axis.direction) + std::abs(range.lower) + std::abs(range.upper)) +
        DBL_MIN;
    if (size == 0) {
      if (start < range.lower - pad || start > range.upper + pad) t1_ = -1;
      return;
    }
    // A ray that is almost perpendicular to the axis tells nothing about t.
    const double error = kMargin * size / std::abs(along);
    if (!(error < 0.01)) return;
    const double a = (range.lower - pad - start) / along, b = (range.upper + pad - start) / along;
    const double from = std::min(a, b), to = std::max(a, b);
    if (std::isfinite(from)) t0_ = std::max(t0_, from - error * std::abs(from));
    if (std::isfinite(to)) t1_ = std::min(t1_, to + error * std::abs(to));
  }

  /// The projection of the stretch; unbounded where it is too large to tell.
  Interval on(const Axis& axis) const {
    const double along = dot(direction_, axis.direction), size = magnitude(direction_, axis.direction);
    const double start = dot(origin_, axis.direction);
    const double pad = kMargin * magnitude(origin_, axis.direction) + DBL_MIN;
    if (size == 0) return {start - pad, start + pad};
    const double a = start + t0_ * along, b = start + t1_ * along;
    const double spread = pad + kMargin * size * t1_;
    if (!std::isfinite(a) || !std::isfinite(b) || !std::isfinite(spread)) return {-kInfinity, kInfinity};
    return {std::min(a, b) - spread, std::max(a, b) + spread};
  }

 private:
  static constexpr double kMargin = 64 * DBL_EPSILON;

  static double magnitude(Vec2 a, Vec2 b) { return std::abs(a.x * b.x) + std::abs(a.y * b.y); }

  Vec2 origin_, direction_;
  double t0_ = 0, t1_;
};

}  // namespace skerry
