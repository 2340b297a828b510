// SPDX-License-Identifier: MIT
//
// Exact contact solver in body space: active set with exact Coulomb states, warm started; interior point with
// a polish for hard cold starts.
#pragma once

#include "physics/solver/solver.h"

namespace skerry {

/// Solves any island (all row kinds, compliance, immobile bodies) to the rounding floor, or says how far it
/// came.
///
/// In turn, until the residual of the answer is within the tolerance or at the rounding floor:
///  1. the warm start is the answer already;
///  2. active set from the states of the last call or of the warm start, with the kept factor where it fits;
///  3. active set from "every touching contact sticks";
///  4. interior point, its central path handing over to the active set;
///  5. proximal continuation from the best iterate;
///  6. from a cold start without `max_iterations`: path following, one state at a time;
///  7. the best iterate is returned as Inexact.
///
/// Impulses of redundant contacts are not unique (velocities are, up to rare multiple solutions of Coulomb's
/// law); from a cold start they are nearly the smallest ones.
///
/// @param options  `max_iterations` bounds the factorisations; `time_budget` bounds the time, then results
///                 depend on the clock
/// @param memory   keeps order, fill, factor and states
Solution solve_body_space(const IslandSystem& system, std::span<const double> warm_start,
                          const SolveOptions& options, std::unique_ptr<SolverMemory>* memory);

}  // namespace skerry
