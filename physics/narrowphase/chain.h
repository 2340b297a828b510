// SPDX-License-Identifier: MIT
//
// Contacts with chains of segments (terrain). A chain is met one segment at a time; each segment knows its
// neighbours, so that a body that slides over an inner corner of a flat stretch never feels it.
#pragma once

#include <vector>

#include "physics/narrowphase/manifold.h"
#include "physics/shape.h"

namespace skerry {

/// Number of segments of a chain: its corners, less one if it is open.
int chain_segment_count(const Shape& chain);

/// Returns the box of a segment (world frame). @pre 0 <= segment < chain_segment_count(chain)
Aabb chain_segment_box(const Shape& chain, int segment, const Transform& pose);

/// Finds the segments that may meet `box` (world frame): all that do, and none whose own box does not overlap
/// it. O(log n + hits) for chains whose neighbours in order are neighbours in space, as on terrain.
/// @param out  cleared, then filled, ascending
void chain_segments_near(const Shape& chain, const Transform& pose, const Aabb& box, std::vector<int>& out);

/// Finds where one segment of a chain and a convex shape touch, or come within `margin` of each other.
///
/// Segments are one-sided: they push along their left normal only, and not if the middle of the other shape
/// is on their right, the solid side. A ridge's contact belongs to the segment that ends there; its normal
/// stays between those of the two segments, and the middle may be on the left of either. In a valley and on
/// flat stretches only the segments' own normals occur, and where two segments are collinear, the inner
/// corner is no end of the contact, so it gives no point while the contact goes on beyond it. A sharp corner
/// that is above the other side of a valley, or has sunk into it, within the margin of its bottom, is a point
/// of this side, too: it may come down along the other one. So is the lowest corner above this side of what
/// leans on the ridge where it begins: it lands here when it has turned over.
///
/// @param segment  0 <= segment < chain_segment_count(chain)
/// @param margin   largest separation that is still reported [m], >= 0
/// @return manifold with the normal from the chain to `other`; features speak of the segment as edge 0 with
///         corners 0 and 1. No points for half-planes and chains as `other`.
Manifold collide_chain_segment(const Shape& chain, int segment, const Transform& pose_chain,
                               const Shape& other, const Transform& pose_other, double margin,
                               NarrowPhaseStats* stats = nullptr);

/// The same for the segment as a line without a free side, and without neighbours: what a sensor sees of it,
/// whoever crosses it, from either side, from the first touch to the last.
Manifold cross_chain_segment(const Shape& chain, int segment, const Transform& pose_chain, const Shape& other,
                             const Transform& pose_other, double margin);

}  // namespace skerry
