// SPDX-License-Identifier: MIT
//
// Sweeps and the interior point on the cone in turn: where many contacts change between sticking, slipping
// and open at once.
#pragma once

#include <span>

#include "physics/solver/body_space_active_set.h"

namespace skerry {

struct ConeRoundsOptions {
  double tolerance = 1e-10;  ///< relative residual of the polished answer
  int rounds = 6;            ///< of sweeps and a path
};

/// Begins with sweeps, joins the central path next to where they came (`ConeInteriorPoint`) and follows it as
/// far as it goes. With Coulomb's law it may fold, and steps get short; then sweeps go on from the best point
/// so far, which smooth what the path left, and the next path begins nearer to its end. Each time that has
/// gone well, the active set is asked for the exact answer.
///
/// @param start  impulses [n], or none
/// @param model  of `system`: a factor of a path counts as one of its own
/// @param active  its `best` receives every good iterate
/// @return whether the answer is in `active.best()`; false at once for rows other than contacts
bool cone_rounds(const IslandSystem& system, std::span<const double> start, const BodySpaceModel& model,
                 ActiveSet& active, const ConeRoundsOptions& options, const SolveBudget& budget,
                 SolveWork& work, SolveTrace* trace);

}  // namespace skerry
