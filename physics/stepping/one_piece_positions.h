// SPDX-License-Identifier: MIT
//
// The positions of a step in one piece (physics/stepping/one_piece.h): overlaps are taken out by the smallest
// shift, in the norm of the masses, with J shift >= -separation at the new geometry.
#pragma once

#include "physics/stepping/stepper.h"

namespace skerry {

/// Makes the manifolds anew where the bodies have come to, and moves the bodies out of each other, and joints
/// together.
/// @param from, to  of the step, since the beginning of the step [s]
/// @param exact  to rounding, in several rounds; else with bounded work, and no body farther than the next
/// step finds
/// @param work   of the whole step in flow, in visits
void take_overlaps_out(WorldState& state, const Island& island, double from, double to, bool exact,
                       double work, IslandResult& result);

}  // namespace skerry
