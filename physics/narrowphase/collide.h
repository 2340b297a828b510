// SPDX-License-Identifier: MIT
//
// From two shapes at their poses to a contact manifold.
#pragma once

#include <vector>

#include "physics/narrowphase/manifold.h"
#include "physics/shape.h"

namespace skerry {

/// Finds where shapes `a` and `b` touch, or come within `margin` of each other.
///
/// Separating axes with last step's axis first [Gottschalk 1996; Ericson 2005, sec. 5.2], then clipping of
/// the incident edge against the reference edge. Swapping the arguments mirrors the result exactly.
///
/// @param margin  largest separation that is still reported [m], >= 0
/// @param cache   kept between steps; may be null
/// @param stats   counters to add to; may be null
/// @return points with separation <= margin: two for edge on edge, one for vertex on edge; none when farther
/// apart
Manifold collide(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b,
                 double margin, SatCache* cache = nullptr, NarrowPhaseStats* stats = nullptr);

}  // namespace skerry
