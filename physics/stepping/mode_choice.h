// SPDX-License-Identifier: MIT
//
// Which contact mode an island is in at one moment of the event-driven stepper.
#pragma once

#include <cstdint>
#include <vector>

#include "physics/stepping/acceleration.h"

namespace skerry {

/// A grip that let go a moment ago and has no speed yet.
struct Onset {
  std::size_t contact = 0;  ///< position in the island's list
  bool rolling = false;
  int sign = 0;
};

/// The largest speed of any point of the island's bodies [m/s].
double speed_bound(const WorldState& state, const Island& island);

/// Second derivative of the gap of a contact's point while nothing but external forces acts [m/s^2]; 0 for
/// features that have none.
double free_gap_acceleration(const WorldState& state, const AccelerationProblem& problem,
                             const Contact& contact, int point, double elapsed,
                             const AccelerationProblem::State& y);

/// Decides which contacts are closed from now on and how, which limits are reached, and how motors compare
/// with their speed; then checks that the forces are of the kind that the mode assumes.
/// @param elapsed  since the beginning of the step [s]; the bodies are where they are then
/// @param onsets   grips that let go since the last choice
/// @param ahead    what closes is decided this much later [s], where the bodies would be by the accelerations
///                 in `forces`: where a load passes from one point to the next, both are at zero now
/// @param forces   of the mode, unless that is free
/// @return false if there is no such mode, or none that can be followed
bool choose_mode(const WorldState& state, const Island& island, const AccelerationProblem& problem,
                 double elapsed, const std::vector<Onset>& onsets, double ahead, ContactMode& mode,
                 ModeForces& forces);

}  // namespace skerry
