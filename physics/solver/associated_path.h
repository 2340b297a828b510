// SPDX-License-Identifier: MIT
//
// Contacts that hold each other: the convex problem of associated sliding, whose answer is Coulomb's wherever
// nothing slides.
#pragma once

#include <span>

#include "physics/solver/body_space_active_set.h"

namespace skerry {

/// Follows the central path of the associated problem (`ConeInteriorPoint`), which always arrives, in some
/// twenty factors, and asks the active set for the exact answer. Of many states of rest in a heap that is
/// statically indeterminate it finds one, wherever there is one; states that change one after the other or
/// all at once may wander among them. Where something has to slide it gives up as soon as that shows: what
/// sliding takes from the bodies does not fall with the path.
///
/// @param start  impulses [n] to begin next to
/// @param model  of `system`: a factor of the path counts as one of its own
/// @param active  its `best` receives every good iterate
/// @return whether the answer is in `active.best()`; false at once for rolling resistance, or
/// without a contact
bool follow_associated_path(const IslandSystem& system, std::span<const double> start, double tolerance,
                            const BodySpaceModel& model, ActiveSet& active, const SolveBudget& budget,
                            SolveWork& work, SolveTrace* trace);

/// The same by itself: forces that hold everything. @return status Solved where there are
/// @param start  impulses [n] to begin next to, or none. From what flow ends with it takes half as many
/// factors
Solution find_rest(const IslandSystem& system, std::span<const double> start, const SolveOptions& options);

}  // namespace skerry
