// SPDX-License-Identifier: MIT
//
// The step of an island in one piece.
//
// In flow, with many contacts that slide, land or part in this very step, what acts at one instant is over in
// the next, so that the exact forces of an instant, found again after each of hundreds of landings, are worth
// less than they cost. Such an island makes its step in one piece, with a bounded amount of work for each
// body (`WorldConfig::flow_work`), and reports the residual that is left.
//
//   v1 = v0 + h a + M^-1 J' lambda,   J v1 >= -max(gap, 0) / h  perp  lambda_n >= 0,
//   |lambda_t| <= mu lambda_n
//   q1 = q0 + h v1;  where no impulse acts: q0 + h (v0 + v1) / 2
//
// Then overlaps are taken out of the positions, and energy that came up by that out of the motion.
// J: geometry and all gaps that could close within the step, at its beginning [Stewart & Trinkle 1996].
//
// Where all is slow the same problem is solved exactly: a light blow on a wall of a thousand bricks, which
// sends the last bits of all its gaps opening and closing, is then neither a thousand impacts nor flow. The
// problem is close to that of the last step, whose impulses, states and factor it begins with.
#pragma once

#include "physics/stepping/stepper.h"

namespace skerry {

/// Brings an island in flow through a step, or what is left of it: to `to` [s] since its beginning.
void step_island_in_flow(WorldState& state, const Island& island, double from, double to,
                         IslandResult& result);

/// The same, for a whole step, with an exact answer. Where it cannot be had for 30 times the work of flow,
/// nothing has happened.
/// @param patient  after calls that failed the next 1, 2, 4 ... 64 do not try
/// @return whether the step was made
bool step_island_lightly(WorldState& state, const Island& island, double h, bool patient,
                         IslandResult& result);

}  // namespace skerry
