// SPDX-License-Identifier: MIT
//
// Rows that nothing can follow: W_ii = 0, as a motor on a body that does not turn. Their velocity is -b
// whatever the impulses, and their own impulse moves nothing, so that the others need not know of them.
#pragma once

#include <span>
#include <vector>

#include "physics/solver/solver.h"

namespace skerry {

/// An island without such rows.
class StillRows {
 public:
  /// @return false where there are none, without looking at the rows of bodies that can move in every way
  bool find(const IslandSystem& system);

  /// The same island without them. Valid after a `find` that returned true.
  const IslandSystem& others() const { return others_; }
  void restrict(std::span<const double> lambda, std::vector<double>& others) const;

  /// Turns an answer for the others into one for the island: a row that nothing can follow has the bound on
  /// the side of its b, or nothing where it asks for nothing (or has no such bound: then there is no answer).
  void expand(Solution& solution, const SolveOptions& options) const;

 private:
  const IslandSystem* system_ = nullptr;
  IslandSystem others_;
  std::vector<int> place_;  ///< of each row among the others, -1: none
};

}  // namespace skerry
