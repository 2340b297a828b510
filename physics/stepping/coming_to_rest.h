// SPDX-License-Identifier: MIT
//
// How an island in flow comes to rest.
#pragma once

#include <cstdint>

#include "physics/stepping/stepper.h"

namespace skerry {

/// What came of a look at an island in flow.
enum class RestLook : std::uint8_t {
  None,   ///< it is not yet time to look, or something moves
  Vain,   ///< nothing moves, and no forces hold it
  Rests,  ///< it rests, and the step is made
};

/// Steps in flow leave small motions and small gaps all over a heap, each of which moves others in the next
/// step: a large one hardly ever comes to rest by itself. Every few steps this looks whether it could:
/// whether there are forces that hold it as it is, with the gaps closed that are as small as what flow leaves
/// (the convex problem of associated sliding answers that, `solver/associated_path.h`). If there are, the
/// bodies stop, and are moved onto each other where they carry load; the next steps are exact.
///
/// Where for a while nothing but forces that are nearly exact is found (what they leave to a body is at most
/// a hundredth of what gravity does in a step: a limb that hangs a little beside its lowest place, a joint
/// that is off, a gap), the bodies stop as they are, and are held by them: the step is inexact and says by
/// how much, but the same each time, so that the island sleeps until something touches it.
///
/// Only where nothing moves faster than that hundredth, either.
/// @return but for `Rests` nothing has happened
RestLook come_to_rest(WorldState& state, const Island& island, double h, IslandResult& result);

/// With `WorldConfig::sleep_speed`: stops an island as it is in which nothing was faster than that for half a
/// second, and holds it with the best forces there are; the step is inexact, and says by how much, but the
/// same each time until something changes what holds it. What rests exactly goes on doing so.
/// @return false, and nothing has happened, for others
bool stop_if_slow(WorldState& state, const Island& island, double h, IslandResult& result);
/// Counts for how long nothing of it has been faster, behind its step.
void note_slowness(const WorldState& state, const Island& island, double h, IslandResult& result);

/// Whether the last step held it so, with less than exact forces, and nothing has moved it since.
bool is_held(const WorldState& state, const Island& island);

}  // namespace skerry
