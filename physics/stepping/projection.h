// SPDX-License-Identifier: MIT
//
// Drift: brings positions and velocities back onto the constraints after a piece of a step.
#pragma once

#include "physics/stepping/stepper.h"

namespace skerry {

/// Moves the bodies by the smallest mass-weighted displacement after which joints hold, contacts do not
/// penetrate, and contacts that carried load are closed. Velocities are left alone, so no energy of motion is
/// added. Does nothing (and solves nothing) when all errors are at rounding level already.
/// @param elapsed  since the beginning of the step [s]
void project_positions(WorldState& state, const Island& island, double elapsed, IslandResult& result);

/// Removes the velocity that violates joints, loaded contacts and sticking contacts at the present geometry,
/// by the least-energy change; kept only where it makes the violation smaller.
void project_velocities(WorldState& state, const Island& island, double elapsed, IslandResult& result);

}  // namespace skerry
