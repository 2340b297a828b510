// SPDX-License-Identifier: MIT
//
// Where kinematic bodies are within a step: on a straight way with their velocity, or on the polynomial of
// their prescribed motion.
#pragma once

#include <vector>

#include "physics/stepping/motion_path.h"
#include "physics/stepping/path.h"

namespace skerry {

struct Island;
struct WorldState;

/// The motion of a kinematic (or fixed) body, `elapsed` after the beginning of the step [s].
KinematicState kinematic_state(const WorldState& state, std::uint32_t body, double elapsed);
/// How much of a time `left` [s] from `elapsed` on what an island may meet, and moves as prescribed, stays
/// where its velocity and acceleration foretell it, as landings are looked for along such parabolas: the
/// whole, or a half, a quarter ... of it.
double foreseeable_length(const WorldState& state, const Island& island, double elapsed, double left);
/// Adds the whole step `h` [s] of a kinematic body that is at its end.
void add_kinematic_path(const WorldState& state, std::uint32_t body, double h,
                        std::vector<PathPiece>& pieces);

}  // namespace skerry
