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
//   |lambda_t| <= mu lambda_n;  where a contact lands with a speed u > g h: J v1 >= e u
//   q1 = q0 + h v1;  where no impulse acts: q0 + h (v0 + v1) / 2
//
// Then overlaps are taken out of the positions, and energy that came up by that out of the motion.
// J: geometry and all gaps that could close within the step, at its beginning [Stewart & Trinkle 1996]. Those
// that only the impulses of others close join when most of the sweeps are done.
//
// The same problem solved exactly serves large islands that are lightly disturbed or struck: a blow on a wall
// of a thousand bricks, which opens gaps of micrometres all over it, is then neither an impact of all
// contacts from nothing, nor a thousand landings, nor flow. The problem is close to that of the last step,
// whose impulses, states and factor it begins with.
#pragma once

#include "physics/stepping/stepper.h"

namespace skerry {

/// Brings an island in flow through a step, or what is left of it: to `to` [s] since its beginning. In one
/// piece, but where rods, ropes or, in a small world, hinges are so taut that what hangs on them swings
/// faster than that: then in up to 64.
/// @param more  times what it may usually cost
void step_island_in_flow(WorldState& state, const Island& island, double from, double to,
                         IslandResult& result, double more = 1);

/// The same with an exact answer. Where it cannot be had for 30 times the work of flow, the best that was
/// found serves as flow if it leaves no more than 1e-3; else nothing has happened. The work does not count in
/// `IslandResult::work_limit`. @return whether the step was made
bool step_island_exactly(WorldState& state, const Island& island, double from, double to,
                         IslandResult& result);

/// The same, exact or not at all, for a whole step of an island that is but lightly disturbed; after calls
/// that failed the next ones do not try (`wait_after_failure`).
bool step_island_lightly(WorldState& state, const Island& island, double h, IslandResult& result);

}  // namespace skerry
