// SPDX-License-Identifier: MIT
//
// Entries of a trace, for an observer. What is recorded changes nothing of what is solved.
#pragma once

#include <vector>

#include "physics/islands/delassus.h"
#include "physics/solver/block_sweeps.h"
#include "physics/solver/contact_states.h"
#include "physics/solver/solver.h"

namespace skerry {

/// @param lambda  impulses after an iteration
template <typename Problem>
void record_iteration(const Problem& problem, const std::vector<double>& lambda, SolveTrace& trace) {
  SolveIteration entry;
  entry.residual = natural_map_residual(problem, lambda);
  count_states(problem.rows, states_from_impulses(problem.rows, lambda), entry);
  trace.iterations.push_back(entry);
}

/// Sweeps `count` times, as `sweeps.sweep(count)` does, to the bit.
/// @param trace  an entry for each; null: none
/// @return what `sweeps.sweep` does
inline double sweep_and_record(BlockSweeps& sweeps, int count, const IslandSystem& system,
                               SolveTrace* trace) {
  if (trace == nullptr) return sweeps.sweep(count);
  double change = 0;
  std::vector<double> lambda;
  for (int k = 0; k < count; ++k) {
    change = sweeps.sweep();
    sweeps.get(sweeps.impulses(), lambda);
    record_iteration(system, lambda, *trace);
  }
  return change;
}

}  // namespace skerry
