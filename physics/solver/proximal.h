// SPDX-License-Identifier: MIT
//
// Proximal continuation: the globally convergent but slower way to the solution of a contact problem.
#pragma once

#include "physics/solver/body_space_active_set.h"

namespace skerry {

struct ProximalOptions {
  double tolerance = 1e-10;  ///< relative residual of the polished answer
  double eta = 0.1;          ///< first proximal weight relative to D; a large one decides the success
  int max_iterations = 400;  ///< moves of the centre
};

/// Solves a sequence of regularised problems, each with exact Coulomb friction,
///
///   0 in w + eta D (lambda - lambda_k) + N(lambda)      ->  lambda_{k+1}
///
/// [proximal point method: Rockafellar 1976]. For a given velocity v their impulses are explicit, lambda(v) =
/// clamp of lambda_k - u(v) / (eta D), so the unknowns are the velocities of the bodies, and the semismooth
/// Newton method on the momentum balance M v = J^T lambda(v) has a merit function: the imbalance in the norm
/// of inv(M). eta falls while Newton finds its way, and rises where it does not. When a new centre is better
/// by far, the active set tries to end it.
///
/// @param active  its impulses are the first centre; its `best` receives every centre
/// @return whether the answer is in `active.best()`
bool proximal_continuation(BodySpaceModel& model, ActiveSet& active, const ProximalOptions& options,
                           const SolveBudget& budget, SolveWork& work, SolveTrace* trace);

}  // namespace skerry
