// SPDX-License-Identifier: MIT
#pragma once

#include "physics/stepping/stepper.h"

namespace skerry {

/// Chooses a stepper for each island and step: `event_driven` while that has few events in a step, otherwise
/// `time_stepping`, and back when the contacts have calmed down. What it goes by is kept with the bodies
/// (`StepMemory::busy`), so the choice depends on nothing but the past of the island.
void step_island_by_choice(WorldState& state, const Island& island, double h, IslandResult& result);

}  // namespace skerry
