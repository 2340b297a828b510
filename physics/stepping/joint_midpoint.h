// SPDX-License-Identifier: MIT
//
// The places half-way through a piece of a step, where joints are closed to loops.
//
// The midpoint rule takes the rows of joints where straight ways lead, and these leave what joints hold by
// something of second order. Rows that depend on each other where the joints hold are independent there, and
// then hold what they never held: a bar that is bolted to another one twice would have to stand still
// half-way, and turn backwards at the end. So rows are taken where the joints hold.
#pragma once

#include <vector>

#include "physics/joint.h"
#include "physics/stepping/stepper.h"

namespace skerry {

/// True if a joint holds something wherever its bodies are; ropes, springs and motors do not.
bool holds_always(const JointDef& def);

/// True if joints that hold something make a loop: two of one pair of bodies, or a closed chain; the ground
/// is one body. The rows of trees of joints never depend on each other.
bool has_loops_of_joints(const WorldState& state, const Island& island);

/// Moves foreseen places of the bodies by the smallest mass-weighted displacements after which joints hold,
/// by Newton's iteration. Leaves them as they are where that does not bring the joints closer.
/// @param elapsed        since the beginning of the step, of these places [s]
/// @param poses, angles  of the island's bodies
void hold_joints(WorldState& state, const Island& island, double elapsed, std::vector<Transform>& poses,
                 std::vector<double>& angles, IslandResult& result);

}  // namespace skerry
