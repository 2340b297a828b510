// SPDX-License-Identifier: MIT
//
// When will a contact point pass the end of the edge that it slides along?
#pragma once

#include <cstdint>
#include <optional>

#include "physics/narrowphase/time_of_impact.h"
#include "physics/world_state.h"

namespace skerry {

/// First time in (0, h] at which a point that rests is beyond the features that meet there, if it is at `h`.
/// @param a, b     motions of the bodies
/// @param resting  bit i: point i of the present manifold rests
std::optional<double> next_corner_time(const WorldState& state, const Contact& contact, const Motion& a,
                                       const Motion& b, std::uint8_t resting, double h);

}  // namespace skerry
