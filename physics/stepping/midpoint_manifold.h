// SPDX-License-Identifier: MIT
//
// A contact half-way through a piece of a step: the points that it has where the piece begins, where they are
// by then, and with the normal of then.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "physics/narrowphase/manifold.h"

namespace skerry {

/// Of a manifold all points.
inline constexpr unsigned kAllPoints = ~0u;

/// Whether a point is a corner of that body; it may be one of both.
inline bool is_corner_of_a(const ManifoldPoint& point) {
  return (point.feature >> 16) % 2 == 0;
}
inline bool is_corner_of_b(const ManifoldPoint& point) {
  return point.feature % 2 == 0;
}

inline bool are_of_one_body(const Manifold& manifold) {
  return std::all_of(manifold.points.begin(), manifold.points.begin() + manifold.count,
                     [](const ManifoldPoint& p) { return is_corner_of_a(p) != is_corner_of_b(p); });
}

/// Of two corners that met, as at the seam of two tiles, one is on a side of the other body half-way.
/// @return false if that is not so
inline bool follow_corner(const Manifold& mid, Manifold& same) {
  if (same.count != 1 || !is_corner_of_a(same.points[0]) || !is_corner_of_b(same.points[0])) return false;
  const ManifoldPoint* nearest = nullptr;
  for (int j = 0; j < mid.count; ++j) {
    const ManifoldPoint& now = mid.points[j];
    const bool follows = now.feature >> 16 == same.points[0].feature >> 16 ||
                         (now.feature & 0xffffu) == (same.points[0].feature & 0xffffu);
    if (follows && (nearest == nullptr || now.separation < nearest->separation)) nearest = &now;
  }
  if (nearest == nullptr) return false;
  same.points[0].position = nearest->position;
  same.normal = mid.normal;
  return true;
}

/// Two corners that touch, both times: the direction from one to the other is noise where no radius keeps
/// them apart. @param radii  of both shapes [m] @param near  corners within this touch [m]
inline bool are_corners_that_touch(const Manifold& mid, const Manifold& same, double radii, double near) {
  const auto touch = [&](const Manifold& manifold) {
    const ManifoldPoint& point = manifold.points[0];
    return manifold.count == 1 && is_corner_of_a(point) && is_corner_of_b(point) &&
           std::abs(point.separation) + radii <= near;
  };
  return touch(mid) && touch(same) && mid.points[0].feature == same.points[0].feature;
}

/// Points keep their numbers. @param all  only all of them
/// @return a bit for each point that is still there; none where the features changed on the way: the old
/// normal serves then
inline unsigned take_geometry(const Manifold& mid, Manifold& same, bool all) {
  unsigned found = 0;
  std::array<int, 2> partner{-1, -1};
  for (int i = 0; i < same.count; ++i) {
    for (int j = 0; j < mid.count; ++j) {
      if (mid.points[j].feature != same.points[i].feature) continue;
      partner[i] = j;
      found |= 1u << i;
    }
  }
  // A corner that passes the end of an edge leaves its place to that end.
  if (!all && same.count == 2 && mid.count == 2 && (found == 1 || found == 2)) {
    partner[found == 1 ? 1 : 0] = 1 - partner[found == 1 ? 0 : 1];
    found = 3;
  }
  if (found == (1u << same.count) - 1) found = kAllPoints;
  if (found == 0 || (all && found != kAllPoints)) return 0;
  for (int i = 0; i < same.count; ++i) {
    if (partner[i] >= 0) same.points[i].position = mid.points[partner[i]].position;
  }
  same.normal = mid.normal;
  return found;
}

}  // namespace skerry
