// SPDX-License-Identifier: MIT
//
// Hierarchical hash sort: as hash sort, but on each axis a box is on the smallest level of cells (powers of
// two) where it covers at most two cells. Large boxes neither fill many lists nor force large cells on small
// ones.
#include "physics/broadphase/interval_hash.h"

namespace skerry {

std::unique_ptr<PairFinder> make_hierarchical_hash_sort(const BroadPhaseOptions& options) {
  return std::make_unique<IntervalHashFinder>(options, IntervalCells::PerOctave);
}

}  // namespace skerry
