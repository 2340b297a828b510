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

/// The two halves of `ManifoldPoint::feature`: what of shape a (upper 16 bits) and of shape b (lower 16 bits)
/// meets. A corner has code 2 i, the edge from corner i to i + 1 has 2 i + 1; a disc is corner 0, a
/// half-plane edge 0, a chain's segment edge 0 with corners 0 and 1.
constexpr std::uint32_t corner_code(int i) {
  return 2 * static_cast<std::uint32_t>(i);
}
constexpr std::uint32_t edge_code(int i) {
  return 2 * static_cast<std::uint32_t>(i) + 1;
}
constexpr std::uint32_t make_feature(std::uint32_t code_a, std::uint32_t code_b) {
  return code_a << 16 | code_b;
}
constexpr std::uint32_t mirrored(std::uint32_t feature) {
  return feature << 16 | feature >> 16;
}

/// Up to two contact points with a common normal.
struct Manifold {
  Vec2 normal;                          ///< unit vector from shape a towards shape b, world frame
  std::array<ManifoldPoint, 2> points;  ///< the first `count` are valid, in an order that features decide
  int count = 0;                        ///< 0: farther apart than the margin
};

/// The manifold of the same contact with the two shapes exchanged.
constexpr Manifold mirrored(Manifold m) {
  m.normal = -m.normal;
  for (ManifoldPoint& point : m.points) point.feature = mirrored(point.feature);
  return m;
}

/// What a pair keeps between steps so that most steps test one axis only. Opaque to callers; a
/// default-constructed one is empty. It never changes a manifold, it only saves work.
///
/// For a pair of polygons or capsules it holds the two best axes of the last full search, by how much all
/// others were worse, and the relative pose then. While the pair has moved less than that, no other axis can
/// be the best. Two axes, because faces that lie on each other are the best axis twice.
struct SatCache {
  std::int32_t axis = -1;     ///< edge of a (>= 0), or edge of b as ~edge
  std::int32_t partner = -1;  ///< the second axis, coded in the same way
  bool valid = false;         ///< `axis` is an axis of this pair
  bool exchanged = false;     ///< the search ran with b as its first shape
  double slack = -1;          ///< no other axis can win before the pair has moved by this [m]; < 0: unknown
  double reach = 0;           ///< largest distances of the corners from the bodies' origins, summed [m]
  Vec2 offset;                ///< relative pose of the search: position [m] and rotation of the second in the
  Rot turn;                   ///< first shape's frame
};

/// Counters of the narrow phase, summed into the step report.
struct NarrowPhaseStats {
  std::uint64_t pairs = 0;  ///< pairs looked at
  std::uint64_t axes_tested = 0;
  std::uint64_t axes_skipped = 0;  ///< axes that the cached one made needless
  std::uint64_t manifolds = 0;     ///< pairs with at least one point
};

}  // namespace skerry
