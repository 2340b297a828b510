// SPDX-License-Identifier: MIT
//
// The convex step: friction bounds held fixed for one solve.
#pragma once

#include "physics/solver/solver.h"

namespace skerry {

/// Solves the island with the friction and rolling bounds fixed at mu times the normal impulses of the warm
/// start (of a frictionless solve, if there is none): the optimality conditions of
///
///   min 1/2 lambda^T W lambda - b^T lambda,   lower <= lambda <= upper      (all bounds constant)
///
/// a convex problem, symmetric, always solvable, with unique velocities, and no energy is gained by it. Taken
/// in several short steps it converges to Coulomb's law [fixed point of Haslinger 1983; in time: Anitescu
/// 2006 for a related convex step].
///
/// The answer is then clamped to +-mu times its own normal impulses, and its residual is that of Coulomb's
/// law: Solved if the bounds were right (nothing slips, or the normal impulses did not change), else Inexact.
Solution solve_convex_step(const IslandSystem& system, std::span<const double> warm_start,
                           const SolveOptions& options, std::unique_ptr<SolverMemory>* memory);

}  // namespace skerry
