// SPDX-License-Identifier: MIT
//
// Forces of many rows at acceleration level: linear cost for chains and trees.
#pragma once

#include <vector>

#include "physics/solver/body_space_model.h"

namespace skerry {

/// Solves W lambda = b for bilateral rows, some of which bring friction with them, in body space: the fill is
/// that of the body graph, so a chain of n links costs O(n), where the dense matrix of its rows costs O(n^3).
///
/// One factor of M + J' (eta D)^-1 J serves all proximal steps, lambda += (W + eta D)^-1 (b - W lambda),
/// which converge whatever rows repeat each other [Rockafellar 1976].
class SparseForces {
 public:
  /// @param system  the first `unknowns` rows are to keep w = 0. The others have an impulse of `mu` times
  /// that
  ///                of the row `normal`, with either sign.
  /// @param lambda  one value a row of `system`: where to begin, and then the answer, the nearest one where
  ///                rows repeat each other
  /// @return false if there is no answer to 1e-9 of the largest |b|, or the matrix is not regular
  bool solve(const IslandSystem& system, int unknowns, SolveWork& work, std::vector<double>& lambda);

 private:
  BodySpaceModel model_;
};

}  // namespace skerry
