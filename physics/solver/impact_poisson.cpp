// SPDX-License-Identifier: MIT
//
// Poisson's law: a compression that stops every approach, then an expansion that gives back at least e times
// each compression impulse [Poisson 1835; Glocker & Pfeiffer 1995].
#include "physics/solver/impact_laws.h"
#include "physics/solver/impact_tools.h"

namespace skerry::impact {

ImpactResult apply_poisson(const ImpactProblem& problem) {
  const IslandSystem& system = problem.system;
  ImpactResult result;
  result.lambda.assign(system.rows.size(), 0);
  result.velocity = problem.velocity;

  const std::vector<int> rows = unilateral_rows(system);
  // Compression.
  const std::vector<double> compression = unilateral(problem, rows, result.velocity, {}, result);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    result.lambda[rows[k]] += compression[k];
    apply_row(system, rows[k], compression[k], result.velocity);
  }
  // Expansion: the stored share is released; whatever more is needed keeps the contacts from closing again.
  for (std::size_t k = 0; k < rows.size(); ++k) {
    if (system.rows[rows[k]].kind != RowKind::Normal) continue;
    const double released = problem.restitution[rows[k]] * compression[k];
    result.lambda[rows[k]] += released;
    apply_row(system, rows[k], released, result.velocity);
  }
  const std::vector<double> rest = unilateral(problem, rows, result.velocity, {}, result);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    result.lambda[rows[k]] += rest[k];
    apply_row(system, rows[k], rest[k], result.velocity);
  }
  add_friction(problem, result);
  return result;
}

}  // namespace skerry::impact
