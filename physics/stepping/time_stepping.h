// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "physics/stepping/one_piece_rule.h"
#include "physics/stepping/stepper.h"

namespace skerry {

/// One step of an island on velocity level.
///
/// The step is cut at impacts (found as times of contact under constant acceleration, so flight is exact). A
/// piece of length h solves, with geometry at its midpoint m,
///
///   v1 = v0 + h a + M^-1 J_m' lambda,   0 <= J_m (v0 + v1)  perp  lambda_n >= 0,   Coulomb friction,
///   q1 = q0 + h (v0 + v1) / 2,
///
/// for contacts that rest; then positions and velocities are projected on the constraints that carried load
/// [Moreau 1988; Stewart & Trinkle 1996; for the midpoint and the projections Hairer, Lubich & Wanner 2006,
/// sec. VII.1]. Impacts use the world's impact law on the velocities before the force acts.
///
/// With `WorldConfig::accuracy` the step is made of inner steps of the length that step doubling finds
/// (step_doubling.h).
void step_island_by_time_stepping(WorldState& state, const Island& island, double h, IslandResult& result);

/// The method itself: from one time of the step to another [s], without error control.
/// @param ends  if given, when its pieces ended is added [s]
/// @param part_of  a time [s] of which this is a part: pieces are no shorter for stability than its own would
/// be
/// @return where it came to: it may give up as the rule says
double advance_island(WorldState& state, const Island& island, const OnePieceRule& rule, double from,
                      double to, IslandResult& result, std::vector<double>* ends = nullptr,
                      double part_of = 0);

}  // namespace skerry
