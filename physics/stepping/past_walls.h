// SPDX-License-Identifier: MIT
//
// A step in one piece is of first order, and sweeps leave a part of what they should take: what turns fast,
// or is pressed on by others, may be put into a wall by more than half of its thickness at once, and would be
// pushed out behind.
#pragma once

#include <span>

#include "physics/stepping/stepper.h"
#include "physics/world_state.h"

namespace skerry {

/// What went into or through a shape of a body that no impulse moves, with its middle, on its straight way
/// through a piece, is put where it met it. How deep that was is told by the overlap of the result. Chains
/// are left out (`past_chains.h`).
/// @param start  of each body of the island, where the piece began
/// @param from, to  of the piece, since the beginning of the step [s]
void put_before_walls(WorldState& state, const Island& island, std::span<const Transform> start, double from,
                      double to, IslandResult& result);

/// Whether a way is so long that its body can have gone through a wall with its middle [m].
bool may_pass_walls(const WorldState& state, std::uint32_t body, double way);

}  // namespace skerry
