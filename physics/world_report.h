// SPDX-License-Identifier: MIT
#pragma once

#include "physics/world_state.h"

namespace skerry {

/// Fills the step report from the islands (in their canonical order) and the contact table, makes the contact
/// events, and sets the joints' reactions. Islands that are kept count as they did in the last step.
void write_report(WorldState& state, double h);

}  // namespace skerry
