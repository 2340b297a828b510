// SPDX-License-Identifier: MIT
//
// From two shapes at their poses to a contact manifold.
#pragma once

#include "physics/narrowphase/manifold.h"
#include "physics/shape.h"

namespace skerry {

/// Finds where shapes `a` and `b` touch, or come within `margin` of each other.
///
/// Separating axes with last step's axis first [Gottschalk 1996; Ericson 2005, sec. 5.2], then clipping of
/// the incident edge against the reference edge. Swapping the arguments mirrors the result exactly.
///
/// If two faces lie on each other, or two axes are equal within 1e-14 of the coordinates, the first one is
/// taken, so the choice does not flicker. A point's feature names a corner and an edge (or two corners, where
/// they face each other within 1e-7 of the edge), so it is the same whichever face was the reference.
///
/// @param margin  largest separation that is still reported [m], >= 0; separated pairs meet at their closest
///                features, so the normal of two corners is the line between them
/// @param cache   kept between steps; may be null; the manifold is the same to the bit with and without it
/// @param stats   counters to add to; may be null
/// @return points with separation <= margin: two for edge on edge; one for vertex on edge, and for two edges
///         that lie on each other by no more than 1e-7 of their length, as where two corners meet; none when
///         farther apart, for two half-planes, or if a position is not finite
/// @pre the rotations are finite
/// @throws std::invalid_argument for a chain (see collide_chain_segment)
Manifold collide(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b,
                 double margin, SatCache* cache = nullptr, NarrowPhaseStats* stats = nullptr);

}  // namespace skerry
