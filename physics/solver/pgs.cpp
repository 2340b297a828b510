// SPDX-License-Identifier: MIT
//
// Projected Gauss-Seidel: preview, comparison, and the inner step of nncg. Converges slowly (the error of a
// stack of n falls by about 1 - 1/n^2 a sweep), but never fails badly.
#include "physics/solver/block_sweeps.h"
#include "physics/solver/gauss_seidel.h"
#include "physics/solver/solver_trace.h"
#include "physics/spare.h"

namespace skerry {
namespace {

constexpr int kDefaultSweeps = 1000;

template <typename Operator>
Solution sweep_until_done(const typename Operator::Problem& problem, std::span<const double> warm_start,
                          const SolveOptions& options) {
  Solution solution;
  solution.method = "pgs";
  solution.lambda = starting_impulses(problem.rows, warm_start);
  Operator op(problem);
  op.restart(solution.lambda);
  const double target = options.tolerance * largest_magnitude(problem.b);
  const int sweeps = options.max_iterations > 0 ? options.max_iterations : kDefaultSweeps;
  if (options.trace) solution.trace = std::make_unique<SolveTrace>();
  const double limit = options.work_limit > 0 ? options.work_limit : kInfinity;
  while (solution.iterations < sweeps && solution.work.visits < limit) {
    const double change = gauss_seidel_sweep(op, solution.lambda);
    ++solution.iterations;
    solution.work.visits += static_cast<double>(solution.lambda.size());
    if (options.trace) record_iteration(problem, solution.lambda, *solution.trace);
    // The change underestimates the residual; half the target leaves the verdict room.
    if (change <= 0.5 * target && natural_map_residual(problem, solution.lambda) <= options.tolerance) break;
  }
  conclude(problem, options, solution);
  return solution;
}

/// The same over blocks. @return false if the island does not fit into them
bool sweep_blocks(const IslandSystem& system, std::span<const double> warm_start, const SolveOptions& options,
                  Solution& solution) {
  Spare<BlockSweeps> sweeps;
  if (!sweeps->assign(system, false, options.threads)) return false;
  solution.method = "pgs";
  if (options.trace) solution.trace = std::make_unique<SolveTrace>();
  solution.lambda = take_spare<std::vector<double>>();
  sweeps->set(warm_start);
  const double target = options.tolerance * largest_magnitude(system.b);
  const int most = options.max_iterations > 0 ? options.max_iterations : kDefaultSweeps;
  const double limit = options.work_limit > 0 ? options.work_limit : kInfinity;
  while (solution.iterations < most && solution.work.visits < limit) {
    int count = 0;
    do {
      ++count;
      ++solution.iterations;
      solution.work.visits += static_cast<double>(system.rows.size());
    } while (count < sweeps->together() && solution.iterations < most && solution.work.visits < limit);
    const double change = sweep_and_record(*sweeps, count, system, solution.trace.get());
    if (change <= 0.5 * target && sweeps->violation() <= target) break;
  }
  sweeps->get(sweeps->impulses(), solution.lambda);
  if (sweeps->contradicts())
    conclude(system, options, solution);
  else
    conclude(system, sweeps->violation(), options, solution);
  return true;
}

Solution solve_pgs(const IslandSystem& system, std::span<const double> warm_start,
                   const SolveOptions& options, std::unique_ptr<SolverMemory>*) {
  Solution solution;
  if (sweep_blocks(system, warm_start, options, solution)) return solution;
  return sweep_until_done<BodyOperator>(system, warm_start, options);
}

Solution solve_pgs_contact(const ContactProblem& problem, std::span<const double> warm_start,
                           const SolveOptions& options, std::unique_ptr<SolverMemory>*) {
  return sweep_until_done<MatrixOperator>(problem, warm_start, options);
}

}  // namespace

extern const SolverEntry kPgsEntry{
    .name = "pgs",
    .summary = "projected Gauss-Seidel, up to 1000 sweeps unless told otherwise",
    .reference = "Cryer 1971; Moreau 1999, sec. 4; Catto 2005",
    .exact = false,
    .friction = true,
    .bilateral = true,
    .solve = solve_pgs,
    .solve_contact = solve_pgs_contact};

}  // namespace skerry
