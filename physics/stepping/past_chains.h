// SPDX-License-Identifier: MIT
//
// Chains have one side, and what is past them is not held by them any more. A step in one piece is of first
// order: what turns fast, or turns with ground that turns, may be put past a segment by more than half of its
// own thickness at once.
#pragma once

#include "physics/stepping/stepper.h"
#include "physics/world_state.h"

namespace skerry {

/// After a step of length `h` [s] of an island: what was in front of a segment of a chain when the step
/// began, and went through it with its middle, is moved back to its face. Where that was so deep is told by
/// the overlap of the result.
void put_in_front_of_chains(WorldState& state, const Island& island, double h, IslandResult& result);

}  // namespace skerry
