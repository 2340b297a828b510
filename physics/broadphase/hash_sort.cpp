// SPDX-License-Identifier: MIT
//
// Hash sort: boxes projected on axes, and on each axis a hash table of equal cells in place of the sorted
// list of sweep and prune. Nothing is sorted, and a teleport costs no more than a small move. On one axis a
// body shares its cells with all that lie above or below it, O(sqrt n) in the plane: a method for some
// thousands of boxes.
#include "physics/broadphase/interval_hash.h"

namespace skerry {

std::unique_ptr<PairFinder> make_hash_sort(const BroadPhaseOptions& options) {
  return std::make_unique<IntervalHashFinder>(options, IntervalCells::Equal);
}

}  // namespace skerry
