// SPDX-License-Identifier: MIT
//
// From the forces of a contact mode to what contacts and joints remember of them.
#pragma once

#include "physics/stepping/acceleration.h"

namespace skerry {

/// No contact and no joint of the island carries anything. @param h  length of the step [s]
void clear_forces(WorldState& state, const Island& island, double h);

/// Adds what the forces of a stretch of motion gave, in their directions, to the sums of the step.
/// @param before, after  impulses where it begins and ends; `from`, `to`: forces there
/// @param length         of it [s]
void add_pushes(WorldState& state, const Island& island, const ContactMode& mode,
                const AccelerationProblem::State& before, const AccelerationProblem::State& after,
                const ModeForces& from, const ModeForces& to, double length);

/// Writes the present forces (as impulses of a whole step of length `h`), and adds the impulses in `y` to the
/// sums of the step.
void store_forces(WorldState& state, const Island& island, double h, const ContactMode& mode,
                  const ModeForces& forces, const AccelerationProblem::State& y);

}  // namespace skerry
