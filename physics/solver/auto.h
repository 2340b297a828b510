// SPDX-License-Identifier: MIT
//
// The ladder: for each island the cheapest solver that answers it exactly, and an honest answer where none
// does.
#pragma once

#include "physics/solver/solver.h"

namespace skerry {

/// Solves an island by the first rung that fits and succeeds; `Solution::method` names it, notes in the trace
/// say why:
///
///   no rows | one contact: closed_form | no bounds: bilateral | chain without friction: tridiagonal |
///   a few contacts, cold: small_exact | body_space | convex_step | nncg
///
/// The last two are taken only where body_space did not reach the tolerance; of all answers the one of least
/// residual is returned. Every answer is verified by its residual.
///
/// @param options  `work_limit` is the budget in counted work (the same answer on any machine),
/// `max_iterations` that in factorisations, `time_budget` that in seconds; 0: unlimited. Of the first, the
/// exact search takes at most 60 %; the convex step, repeated with the bounds of its own answer while that
/// helps, and the sweeps get at least 25 % and 10 %.
Solution solve_auto(const IslandSystem& system, std::span<const double> warm_start,
                    const SolveOptions& options, std::unique_ptr<SolverMemory>* memory);

/// The same for a problem without bodies: sparse_contact, then lemke where no part of W is too large for it.
Solution solve_auto_contact(const ContactProblem& problem, std::span<const double> warm_start,
                            const SolveOptions& options, std::unique_ptr<SolverMemory>* memory);

}  // namespace skerry
