// SPDX-License-Identifier: MIT
//
// Newton's law at all touching contacts at once: u+ >= -e u- and complementary impulses, one solve of W
// lambda = b [Newton 1687; Moreau 1988]. For three equal discs in a row it gives (-1/3, 2/3, 2/3), and it can
// create energy (a spinning box that lands flat), which is why it is here for teaching and comparison.
#include "physics/solver/impact_laws.h"
#include "physics/solver/impact_tools.h"

namespace skerry::impact {

ImpactResult apply_simultaneous(const ImpactProblem& problem) {
  const IslandSystem& system = problem.system;
  ImpactResult result;
  result.lambda.assign(system.rows.size(), 0);
  result.velocity = problem.velocity;

  const std::vector<int> rows = unilateral_rows(system);
  std::vector<double> targets(rows.size(), 0);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double u = row_velocity(problem, rows[k], problem.velocity);
    if (system.rows[rows[k]].kind == RowKind::Normal && u < -problem.rest_speed) {
      targets[k] = -problem.restitution[rows[k]] * u;
    }
  }
  const std::vector<double> lambda = unilateral(problem, rows, problem.velocity, targets, result);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    result.lambda[rows[k]] = lambda[k];
    apply_row(system, rows[k], lambda[k], result.velocity);
  }
  add_friction(problem, result);
  return result;
}

}  // namespace skerry::impact
