// SPDX-License-Identifier: MIT
//
// Forces that change within a step: fields by callback, and drag.
#pragma once

#include <array>

#include "physics/islands/island_builder.h"
#include "physics/joint_rows.h"

namespace skerry {

struct WorldState;

/// Whether anything but constant forces acts on the island: then its flight is not a parabola, nor does it
/// rest because it rested.
bool has_varying_forces(const WorldState& state, const Island& island);

/// Whether a contact or joint of the island has a body with a prescribed motion.
bool meets_prescribed_motion(const WorldState& state, const Island& island);

/// Largest acceleration that the applied forces give any point of the island's bodies [m/s^2].
double largest_acceleration(const WorldState& state, const Island& island);

/// Acceleration (linear and angular) of a dynamic body in this motion, by gravity, the user's forces of this
/// step, fields and drag.
/// @param elapsed  since the beginning of the step [s]
/// @throws std::invalid_argument if the field gives a force that is not finite
std::array<double, 3> applied_acceleration(const WorldState& state, std::uint32_t body,
                                           const JointEnd& motion, double elapsed);

}  // namespace skerry
