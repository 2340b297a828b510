// SPDX-License-Identifier: MIT
//
// The active set on contact states for islands of a few bodies: what `body_space` does there, in fixed-size
// arrays on the stack.
#pragma once

#include <span>

#include "physics/solver/solver.h"

namespace skerry {

inline constexpr int kStateBodies = 16, kStateRows = 96;

/// Searches the states of all rows (open, stick, slip) from those of the warm start, from everything
/// sticking, and from those that a few sweeps end in: at most `kStateBodies` bodies and `kStateRows` rows of
/// any kind without compliance.
/// @param solution  gets the work; the answer only where there is one
/// @return whether there is an answer within the tolerance
bool try_small_states(const IslandSystem& system, std::span<const double> warm_start,
                      const SolveOptions& options, Solution& solution);

}  // namespace skerry
