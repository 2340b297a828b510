// SPDX-License-Identifier: MIT
//
// Islands in flow: many contacts, most of which slide, land or part in this very step. What acts at one
// instant is over in the next, so that the exact forces of an instant, found again after each of hundreds of
// landings, are worth less than they cost. Such an island makes its step in one piece, with a bounded amount
// of work for each body (`WorldConfig::flow_work`), and reports the residual that is left.
//
//   v1 = v0 + h a + M^-1 J' lambda,   J v1 >= -max(gap, 0) / h  perp  lambda_n >= 0,
//   |lambda_t| <= mu lambda_n
//   q1 = q0 + h v1;  where no impulse acts: q0 + h (v0 + v1) / 2
//
// Then overlaps are taken out of the positions, and energy that came up by that out of the motion.
// J: geometry and all gaps that could close within the step, at its beginning [Stewart & Trinkle 1996].
#pragma once

#include "physics/stepping/stepper.h"

namespace skerry {

/// `StepMemory::flow` of bodies whose island flows in this step if it may at all.
inline constexpr int kMustFlow = 3;

/// Counts the contact points that touch, or may within the step, those of them that approach or slide faster
/// than the largest force changes a velocity in a step, and those that land in it. An island with more than
/// 30 points is in flow if a fifth of them are fast or more than 8 land; a twentieth or more than 2 are
/// enough if it flowed in the last step, or was cut into more than 4 pieces. After more than 16 pieces more
/// than 8 points will do. What must flow does with more than 30 points. Islands with joints, bouncing
/// contacts or forces that depend on the state never are; with a solver that is not exact all of more than 8
/// points are.
bool is_in_flow(const WorldState& state, const Island& island, double h);

/// Work in visits after which exact forces of an island that may flow are given up; 0 if it may not.
double flow_from_work(const WorldState& state, const Island& island);

/// How often an exact step was cut, as `StepMemory::flow` of the next one: 0 seldom, 1 often, 2 very often.
int restlessness(const IslandResult& result);

/// Brings an island in flow through a step, or what is left of it: to `to` [s] since its beginning.
void step_island_in_flow(WorldState& state, const Island& island, double from, double to,
                         IslandResult& result);

}  // namespace skerry
