// SPDX-License-Identifier: MIT
//
// What bodies meet within a step in one piece: of the faces that keep two of them apart where it begins, the
// one that is passed last [swept separating axes]. Nearest points do not know it: for what slides along a
// floor of boxes side by side the nearest point of the next box is its corner, straight ahead.
#pragma once

#include "physics/world_state.h"

namespace skerry {

/// Contacts that close within the step, while another face keeps the two bodies apart for longer, have that
/// face from now on, with one point.
/// @param h  length of the step [s]
/// @param slow  what closes no faster is left as it is, and what goes no faster to a face that it touches
///              slides along it [m/s]
void foresee_faces(WorldState& state, const Island& island, double elapsed, double h, double slow);

}  // namespace skerry
