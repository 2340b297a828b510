// SPDX-License-Identifier: MIT
#include "physics/stepping/free_flight.h"

#include <vector>

#include "physics/stepping/applied_forces.h"
#include "physics/stepping/path.h"
#include "physics/stepping/stepper.h"
#include "physics/stepping/travel.h"

namespace skerry {

bool is_in_flight(const WorldState& state, const Island& island) {
  return state.config.skips.flight && island.contacts.empty() && island.joints.empty() &&
         !has_varying_forces(state, island);
}

bool fly_freely(WorldState& state, const Island& island, double h, IslandResult& result) {
  if (!is_in_flight(state, island)) return false;
  std::vector<PathEnd> start;
  if (state.observe.paths) start = path_ends(state, island.bodies);
  for (const std::uint32_t body : island.bodies) fly(state, body, 0, h);
  if (state.observe.paths) record_hermite(state, island.bodies, 0, h, start, result);
  result.in_flight = true;
  result.substeps = 1;
  return true;
}

}  // namespace skerry
