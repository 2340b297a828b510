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
  int count;                            ///< 0: farther apart than the margin

  // Written out, as the compiler would clear the whole as a block with an instruction that takes longer than
  // colliding two discs.
  Manifold() : points{ManifoldPoint{{}, 0, 0}, ManifoldPoint{{}, 0, 0}}, count(0) {}
};

/// The manifold of the same contact with the two shapes exchanged.
inline Manifold mirrored(Manifold m) {
  m.normal = -m.normal;
  for (ManifoldPoint& point : m.points) point.feature = mirrored(point.feature);
  return m;
}

/// What a pair keeps between steps so that most steps test one axis or none. Opaque to callers; a
/// default-constructed one is empty. It never changes a manifold, it only saves work.
///
/// Settled: a pair of polygons or capsules in reach of each other. It holds the best axis of the last full
/// search and one that tied with it (faces that lie on each other are the best axis twice), by how much all
/// others were worse, and the relative pose then. While the pair has moved less than that, no other axis can
/// be the best.
///
/// Apart: an axis and how far it separated the pair at the poses then. While the pair has moved less than
/// what is to spare, it is apart, and no axis is looked at.
struct SatCache {
  enum class State : std::uint8_t { Empty, Settled, Apart };
  std::int32_t axis = -1;      ///< edge of a (>= 0), or edge of b as ~edge
  std::int32_t partner = -1;   ///< settled: the second axis, coded in the same way; may be the same
  State state = State::Empty;  ///< what the rest speaks of
  bool exchanged = false;      ///< settled: the search ran with b as its first shape
  double slack = -1;           ///< settled: no other axis can win before the pair has moved by this [m]
                               ///< apart: separation of the cores along the axis; not positive: unknown
  double reach = 0;            ///< settled: largest distances of the corners from the origins, summed [m]
                               ///< apart: what a unit of a's turn can move, at most [m]
  double reach_b = 0;          ///< apart: and of b's
  Vec2 offset;                 ///< settled: position of the second in the first shape's frame [m]
                               ///< apart: position of b less that of a, world frame
  Rot turn;                    ///< settled: rotation of the second in the first shape's frame; apart: of a
  Rot turn_b;                  ///< apart: rotation of b
};

/// Counters of the narrow phase, summed into the step report.
struct NarrowPhaseStats {
  std::uint64_t pairs = 0;  ///< pairs looked at
  std::uint64_t axes_tested = 0;
  std::uint64_t axes_skipped = 0;  ///< axes that the cached one made needless
  std::uint64_t manifolds = 0;     ///< pairs with at least one point

  NarrowPhaseStats& operator+=(const NarrowPhaseStats& other) {
    pairs += other.pairs;
    axes_tested += other.axes_tested;
    axes_skipped += other.axes_skipped;
    manifolds += other.manifolds;
    return *this;
  }
};

}  // namespace skerry
