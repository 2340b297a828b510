// SPDX-License-Identifier: MIT
//
// What the narrow phase hands to the rest: where two convex shapes touch, or nearly touch.
#pragma once

#include <array>
#include <cstdint>

#include "physics/math.h"

namespace skerry {

/// One contact point.
struct ManifoldPoint {
  Vec2 position;              ///< midway between the two surfaces, world frame [m]
  double separation = 0;      ///< along the normal [m]; negative when the shapes overlap
  std::uint32_t feature = 0;  ///< which features meet; equal from step to step while they do
};

/// Up to two contact points with a common normal.
struct Manifold {
  Vec2 normal;                          ///< unit vector from shape a towards shape b, world frame
  std::array<ManifoldPoint, 2> points;  ///< the first `count` are valid, in the order of their features
  int count = 0;                        ///< 0: farther apart than the margin
};

/// What a pair keeps between steps so that most steps test one axis only.
struct SatCache {
  std::int32_t axis = -1;  ///< edge of a (>= 0), or edge of b as ~edge; -1 with `valid` false: none yet
  bool valid = false;
};

/// Counters of the narrow phase, summed into the step report.
struct NarrowPhaseStats {
  std::uint64_t pairs = 0;  ///< pairs looked at
  std::uint64_t axes_tested = 0;
  std::uint64_t axes_skipped = 0;  ///< axes that the cached one made needless
  std::uint64_t manifolds = 0;     ///< pairs with at least one point
};

}  // namespace skerry
