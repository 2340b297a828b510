// SPDX-License-Identifier: MIT
#include "physics/solver/convex_step.h"

#include <algorithm>

#include "physics/solver/body_space.h"
#include "physics/solver/contact_states.h"

namespace skerry {
namespace {

// The same problem with the bounds of scaled rows made constant.
IslandSystem with_fixed_bounds(const IslandSystem& system, std::span<const double> lambda) {
  IslandSystem fixed = system;
  for (Row& row : fixed.rows) {
    if (row.normal < 0) continue;
    const double bound = row.mu * std::max(0.0, lambda[static_cast<std::size_t>(row.normal)]);
    row.kind = RowKind::Motor;
    row.normal = -1;
    row.lower = -bound;
    row.upper = bound;
  }
  return fixed;
}

}  // namespace

Solution solve_convex_step(const IslandSystem& system, std::span<const double> warm_start,
                           const SolveOptions& options, std::unique_ptr<SolverMemory>* memory) {
  const std::size_t n = system.rows.size();
  std::unique_ptr<SolverMemory> local;
  if (!memory) memory = &local;
  SolveWork work;
  std::vector<double> bounds(warm_start.begin(), warm_start.end());
  if (bounds.size() != n) {
    bounds.assign(n, 0.0);
    Solution frictionless = solve_body_space(with_fixed_bounds(system, bounds), {}, options, memory);
    bounds = std::move(frictionless.lambda);
    work = frictionless.work;
  }
  Solution solution = solve_body_space(with_fixed_bounds(system, bounds), bounds, options, memory);
  solution.method = "convex_step";
  solution.work += work;
  const bool exact = solution.status == SolveStatus::Solved;
  if (solution.trace)
    solution.trace->notes.emplace_back(exact ? "convex problem solved"
                                             : "convex problem not solved to the end");
  conclude(system, options, solution);
  return solution;
}

extern const SolverEntry kConvexStepEntry;
const SolverEntry kConvexStepEntry = {
    .name = "convex_step",
    .summary = "friction bounds fixed from the warm start: convex, unique velocities, no energy gained",
    .reference = "Haslinger 1983; Anitescu 2006",
    .exact = false,
    .friction = true,
    .bilateral = true,
    .solve = solve_convex_step,
};

}  // namespace skerry
