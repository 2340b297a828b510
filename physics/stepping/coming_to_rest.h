// SPDX-License-Identifier: MIT
//
// How an island in flow comes to rest.
#pragma once

#include "physics/stepping/stepper.h"

namespace skerry {

/// Steps in flow leave small motions and small gaps all over a heap, each of which moves others in the next
/// step: a large one hardly ever comes to rest by itself. Every few steps this looks whether it could:
/// whether there are forces that hold it as it is, with the gaps closed that are as small as what flow leaves
/// (the convex problem of associated sliding answers that, `solver/associated_path.h`). If there are, the
/// bodies stop, and are moved onto each other where they carry load; the next steps are exact.
///
/// Only where nothing moves faster than a hundredth of what gravity does in a step.
/// @return false, and nothing has happened, where it moves, or cannot rest, or it is not yet time to look
bool come_to_rest(WorldState& state, const Island& island, double h, IslandResult& result);

}  // namespace skerry
