// SPDX-License-Identifier: MIT
#pragma once

#include "physics/stepping/stepper.h"

namespace skerry {

/// One step of an island from event to event.
///
/// Between events it is known which contacts are closed and which of them stick or slide, so the motion is a
/// smooth differential equation, J a + dJ/dt v = 0 with W lambda = b for the forces. It is integrated by a
/// Runge-Kutta pair of order 8 that picks its own steps (`WorldConfig::accuracy`); flight is closed form.
/// Events are roots on its continuous output: releases, landings, onset and end of sliding, ropes that
/// become taut, contacts that pass a corner. Impacts are the world's impact law; bounces too low to matter
/// are summed as the geometric series they are [Pfeiffer & Glocker 1996; Acary & Brogliato 2008, ch. 8].
///
/// With too many events in a step, or without an answer for the forces, the island goes back to the beginning
/// of the step and time_stepping makes it (`StepReport::fallbacks`).
void step_island_by_events(WorldState& state, const Island& island, double h, IslandResult& result);

/// Tries the step; with more than `most_events` impacts and changes of mode, or without an answer, the island
/// is left as it was.
/// @return whether the step was made
bool try_island_by_events(WorldState& state, const Island& island, double h, int most_events,
                          IslandResult& result);

}  // namespace skerry
