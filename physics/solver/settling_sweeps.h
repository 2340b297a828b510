// SPDX-License-Identifier: MIT
//
// Sweeps until the states settle: the last way to cold problems with so many slipping contacts that no Newton
// method and no path finds its way through.
#pragma once

#include "physics/solver/body_space_active_set.h"

namespace skerry {

struct SettlingOptions {
  double tolerance = 1e-10;  ///< relative residual of the polished answer
  int sweeps = 350000;       ///< after so many it is given up; 4 s for 300 discs
};

/// Sweeps from nothing by projected Gauss-Seidel [Moreau 1999]. Where Coulomb's law makes the map of a sweep
/// expand here and contract there, the iterates wander, for thousands of sweeps, from one set of states to
/// the next; sets whose solution repels them are passed by, and one whose solution attracts them ends the
/// walk, if there is one. Once the residual falls below what wandering iterates have, the active set ends
/// with the exact answer. How long that takes is a matter of luck, and grows steeply with the size of what
/// slips; an orbit that does not settle is kicked now and then.
///
/// @param active  its `best` receives every good iterate
/// @return whether the answer is in `active.best()`; false at once for rows other than contacts
bool settle_by_sweeps(const IslandSystem& system, ActiveSet& active, const SettlingOptions& options,
                      const SolveBudget& budget, SolveWork& work, SolveTrace* trace);

/// Whether contacts contradict each other, as where ground that moves squeezes bodies: no velocities open all
/// of them, there are impulses that move nothing and yet always seem wanted, and sweeps from nothing go on
/// along those for ever. Told by two stretches of sweeps that change the impulses alike and the velocities
/// not; where that takes longer to see, or more than the budget, false.
bool contradicts(const IslandSystem& system, const SolveBudget& budget, SolveWork& work);

}  // namespace skerry
