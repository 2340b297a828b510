// SPDX-License-Identifier: MIT
#pragma once

#include "physics/solver/solver.h"

namespace skerry {

/// Solves a chain of contacts that only push, whose bodies ascend along the rows, in one pass and judges it
/// in another. Other islands are known by their first rows, mostly.
/// @return false, and `solution` as it was, where the island is another one or the answer not exact
bool try_chain(const IslandSystem& system, const SolveOptions& options, Solution& solution);

}  // namespace skerry
