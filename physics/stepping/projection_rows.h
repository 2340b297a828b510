// SPDX-License-Identifier: MIT
//
// Rows of projections: which of them are kept closed, and what motion takes their errors away.
#pragma once

#include <vector>

#include "physics/stepping/island_rows.h"
#include "physics/stepping/solver_memories.h"
#include "physics/stepping/stepper.h"

namespace skerry {

/// True for a row with lambda >= 0 that is kept closed: a loaded contact, or a limit that was reached.
bool is_kept_closed(const WorldState& state, const RowOrigin& origin);
/// Lets go of such a row.
void open_row(WorldState& state, const RowOrigin& origin);

/// What the rows of a projection want of the bodies.
/// @param lambda  becomes the impulses that bring it; those of welds may be missing where it is a shift
/// @param motion  velocities, or shifts, of the island's bodies, to which what they do is added
void solve_for_motion(WorldState& state, SolvePurpose purpose, const Assembly& assembly, double floor,
                      IslandResult& result, std::vector<double>& lambda, std::vector<Velocity>& motion);

}  // namespace skerry
