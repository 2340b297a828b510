// SPDX-License-Identifier: MIT
//
// When will two shapes of an island touch next?
#pragma once

#include <cstdint>

#include "physics/narrowphase/time_of_impact.h"

namespace skerry {

struct WorldState;

/// First time in (0, h] at which a point of the contact that is not in `resting` (bit i: point i of the
/// present manifold) reaches separation zero, or `h` if none does.
double next_contact_time(const WorldState& state, std::uint32_t contact, const Motion& a, const Motion& b,
                         std::uint8_t resting, double h);

}  // namespace skerry
