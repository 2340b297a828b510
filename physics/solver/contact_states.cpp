// SPDX-License-Identifier: MIT
#include "physics/solver/contact_states.h"

#include <algorithm>
#include <cmath>

#include "physics/solver/wedging.h"
#include "physics/spare.h"

namespace skerry {
namespace {

// Residual of sweeps that no rounding explains.
constexpr double kFarFromRounding = 1e-4;

/// Normal impulse that scales the bounds of a row; 0 for rows with bounds of their own.
double scaling_impulse(const Row& row, const std::vector<double>& lambda) {
  return is_scaled(row) ? lambda[static_cast<std::size_t>(row.normal)] : 0;
}

double clamp_and_judge(const ContactProblem& problem, std::vector<double>& lambda) {
  clamp_to_bounds(problem.rows, lambda);
  return natural_map_residual(problem, lambda);
}

/// What rounding explains. Impulses that nothing calls for are no excuse: they could be as large as it takes.
double excusable(const IslandSystem& system, const std::vector<double>& lambda) {
  return residual_floor(system, lambda) / std::max(1.0, self_made_share(system, lambda) / kMostSelfMade);
}
double excusable(const ContactProblem& problem, const std::vector<double>& lambda) {
  return residual_floor(problem, lambda);
}

template <typename Problem>
void judge(const Problem& problem, const SolveOptions& options, Solution& solution) {
  solution.lambda.resize(problem.rows.size(), 0.0);
  solution.residual = clamp_and_judge(problem, solution.lambda);
  if (!std::isfinite(solution.residual)) {
    // Impulses so large that the velocities overflow: the clamped zero is the only answer left.
    std::fill(solution.lambda.begin(), solution.lambda.end(), 0.0);
    solution.residual = clamp_and_judge(problem, solution.lambda);
    solution.status = SolveStatus::Failed;
    return;
  }
  const bool exact =
      solution.residual <= options.tolerance ||
      (solution.residual <= kHighestFloor && solution.residual <= 16 * excusable(problem, solution.lambda));
  solution.status = exact ? SolveStatus::Solved : SolveStatus::Inexact;
}

}  // namespace

void clamp_to_bounds(const std::vector<Row>& rows, std::vector<double>& lambda) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!std::isfinite(lambda[i])) lambda[i] = 0;
    const ImpulseBounds bounds = impulse_bounds(rows[i], scaling_impulse(rows[i], lambda));
    lambda[i] = std::clamp(lambda[i], bounds.lower, bounds.upper);
  }
}

std::vector<double> starting_impulses(const std::vector<Row>& rows, std::span<const double> warm_start) {
  std::vector<double> lambda = take_spare<std::vector<double>>();
  lambda.assign(rows.size(), 0.0);
  if (warm_start.size() == rows.size()) std::copy(warm_start.begin(), warm_start.end(), lambda.begin());
  clamp_to_bounds(rows, lambda);
  return lambda;
}

std::vector<RowState> states_from_impulses(const std::vector<Row>& rows, const std::vector<double>& lambda,
                                           double slack) {
  const double scale = largest_magnitude(lambda);
  std::vector<RowState> states(rows.size(), RowState::Free);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows[i];
    const double normal_impulse = scaling_impulse(row, lambda);
    const bool open = is_scaled(row) && normal_impulse <= slack * scale;
    if (open) continue;
    const ImpulseBounds bounds = impulse_bounds(row, normal_impulse);
    const double near = slack * (is_scaled(row) ? bounds.upper : scale);
    if (lambda[i] <= bounds.lower + near) states[i] = RowState::Lower;
    // Without friction both bounds are zero: the row is at either, and Lower will do.
    else if (lambda[i] >= bounds.upper - near)
      states[i] = RowState::Upper;
  }
  return states;
}

std::vector<RowState> all_sticking(const std::vector<Row>& rows) {
  std::vector<RowState> states(rows.size(), RowState::Free);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (is_scaled(rows[i]) && rows[i].mu == 0) states[i] = RowState::Lower;
  }
  return states;
}

void count_states(const std::vector<Row>& rows, const std::vector<RowState>& states, SolveIteration& entry) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].kind != RowKind::Normal) continue;
    const bool open = states[i] == RowState::Lower;
    bool slips = false;
    for (std::size_t k = i + 1; k < rows.size() && rows[k].normal == static_cast<int>(i); ++k) {
      slips = slips || (rows[k].kind == RowKind::Friction && states[k] != RowState::Free);
    }
    ++(open ? entry.open : slips ? entry.slip : entry.stick);
  }
}

void conclude(const IslandSystem& system, const SolveOptions& options, Solution& solution) {
  judge(system, options, solution);
}

void conclude(const IslandSystem& system, double violation, const SolveOptions& options, Solution& solution) {
  const double residual = violation / residual_scale(largest_magnitude(system.b));
  if (!(residual > std::max(options.tolerance, kFarFromRounding))) return conclude(system, options, solution);
  clamp_to_bounds(system.rows, solution.lambda);
  solution.residual = residual;
  solution.status = SolveStatus::Inexact;
}

void conclude(const ContactProblem& problem, const SolveOptions& options, Solution& solution) {
  judge(problem, options, solution);
}

Solution solve_in_contact_space(ContactSolveFn solve, const IslandSystem& system,
                                std::span<const double> warm_start, const SolveOptions& options,
                                std::unique_ptr<SolverMemory>* memory) {
  Solution solution = solve(contact_problem(system), warm_start, options, memory);
  const bool judged = solution.status == SolveStatus::Solved || solution.status == SolveStatus::Inexact;
  if (judged) {
    conclude(system, options, solution);
  } else {
    solution.residual = natural_map_residual(system, solution.lambda);
  }
  return solution;
}

}  // namespace skerry
