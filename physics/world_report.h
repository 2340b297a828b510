// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "physics/world_state.h"

namespace skerry {

/// Fills the step report from the islands (in their canonical order) and the contact table, makes the contact
/// events, and sets the joints' reactions.
void write_report(WorldState& state, double h, const std::vector<const Island*>& islands,
                  const std::vector<IslandResult*>& results, const std::vector<Contact>& lost);

}  // namespace skerry
