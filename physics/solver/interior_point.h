// SPDX-License-Identifier: MIT
//
// Interior point method for contact problems with Coulomb friction, for starts from which the active set does
// not find its way.
#pragma once

#include "physics/solver/body_space_active_set.h"

namespace skerry {

struct InteriorPointOptions {
  double tolerance = 1e-10;  ///< relative residual of the polished answer (the rounding floor counts as well)
  int max_iterations = 80;   ///< Newton steps, one factorisation each
  bool from_impulses =
      true;  ///< start at the size of the impulses in the active set; otherwise at max|b| / D
};

/// Follows the central path of
///
///   w = a - b,   s1 a = s2 b = tau e,   s1 = lambda - lower,  s2 = upper - lambda       (s1, s2, a, b > 0)
///
/// with friction bounds +-mu lambda_n, by Mehrotra's predictor and corrector [Mehrotra 1992; for friction:
/// Kleinert, Simeon & Obermayr 2014]. Coulomb's law is not the gradient of anything, so the Newton matrix is
/// unsymmetric; where the full step stalls, some steps are taken with the bounds of friction held (symmetric
/// again). Each time tau has fallen far enough, the states that the slacks show are handed to the active set,
/// which ends with the exact answer.
///
/// @param active  holds impulses that set the scale of the start; its `best` receives every good iterate
/// @return whether the answer is in `active.best()`
bool interior_point(BodySpaceModel& model, ActiveSet& active, const InteriorPointOptions& options,
                    const SolveBudget& budget, SolveWork& work, SolveTrace* trace);

}  // namespace skerry
