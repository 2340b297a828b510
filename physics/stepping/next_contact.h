// SPDX-License-Identifier: MIT
//
// When will two shapes of an island touch next?
#pragma once

#include <cstdint>

#include "physics/narrowphase/time_of_impact.h"

namespace skerry {

struct WorldState;

/// What a contact does within a piece of a step.
struct NextContact {
  double t = 0;  ///< first time in (0, h] at which a free point comes down; `h` if none does
  bool sinks =
      false;  ///< a point that touches goes down without having opened: it must take part in the solve
};

/// Looks at the points of the contact that are not in `resting` (bit i: point i of the present manifold).
NextContact next_contact_time(const WorldState& state, std::uint32_t contact, const Motion& a,
                              const Motion& b, std::uint8_t resting, double h);

}  // namespace skerry
