// SPDX-License-Identifier: MIT
//
// Small steps with soft constraints, as game engines solve contacts: for comparison, and for scenes that want
// that look.
//
// The load b is applied in N equal parts. For each part the impulses lambda_0 of the part before are the
// start; one soft sweep, then one relaxing sweep without softness:
//
//   soft:   lambda <- clamp(lambda - m w / D - s (lambda - lambda_0)),   m = c / (1 + c), s = 1 / (1 + c)
//
// with c = x (2 zeta + x), x = h omega: a spring of damping ratio zeta = 10 and a frequency of an eighth of
// the sub-step rate (x = 2 pi / 8) [Catto 2011; Macklin et al. 2019]. An engine keeps the deflection of the
// spring in the positions; a solver of velocities has none, so the spring is taken to be deflected as its
// last impulse says: without lambda_0 a resting stack would lose a share s of its support in every part, and
// sink or burst. The impulses of the parts add up; bounds hold for each part and, the friction cone being
// convex, for their sum.
#include "physics/solver/gauss_seidel.h"

namespace skerry {
namespace {

constexpr int kDefaultSubsteps = 4;
constexpr double kStep = 2 * kPi / 8, kDamping = 10;
constexpr double kStiffness = kStep * (2 * kDamping + kStep);
constexpr double kMassScale = kStiffness / (1 + kStiffness), kImpulseScale = 1 / (1 + kStiffness);

/// One sweep over the rows of a part. `op` holds the velocities of all parts so far; `load` is the share of b
/// applied so far, `earlier` the sum of the parts before, `spring` the impulses at which the springs rest.
template <typename Operator>
void part_sweep(Operator& op, const std::vector<double>& earlier, const std::vector<double>& spring,
                double load, double mass_scale, double impulse_scale, std::vector<double>& part) {
  const auto& problem = op.problem();
  for (std::size_t i = 0; i < problem.rows.size(); ++i) {
    const double diagonal = op.diagonal(i);
    if (!(diagonal > 0)) continue;
    const Row& row = problem.rows[i];
    // The operator knows the whole load; take back what is not applied yet.
    const double w = op.velocity(i, earlier[i] + part[i]) + (1 - load) * problem.b[i];
    const double wanted = part[i] - mass_scale * w / diagonal - impulse_scale * (part[i] - spring[i]);
    ImpulseBounds bounds = impulse_bounds(row, is_scaled(row) ? part[row.normal] : 0);
    if (!is_scaled(row)) bounds = {bounds.lower - earlier[i], bounds.upper - earlier[i]};
    const double change = std::clamp(wanted, bounds.lower, bounds.upper) - part[i];
    if (change == 0 || !std::isfinite(change)) continue;
    part[i] += change;
    op.add(i, change);
  }
}

template <typename Operator>
Solution solve_in_parts(const typename Operator::Problem& problem, std::span<const double> warm_start,
                        const SolveOptions& options) {
  Solution solution;
  solution.method = "tgs_soft";
  const int parts = options.max_iterations > 0 ? options.max_iterations : kDefaultSubsteps;
  std::vector<double> part = starting_impulses(problem.rows, warm_start);
  for (double& impulse : part) impulse /= parts;
  std::vector<double> sum(problem.rows.size(), 0.0);
  if (options.trace) solution.trace = std::make_unique<SolveTrace>();
  Operator op(problem);
  for (int k = 1; k <= parts; ++k) {
    std::vector<double> start = sum;
    for (std::size_t i = 0; i < sum.size(); ++i) start[i] += part[i];
    op.restart(start);
    const double load = static_cast<double>(k) / parts;
    const std::vector<double> spring = part;
    part_sweep(op, sum, spring, load, kMassScale, kImpulseScale, part);
    part_sweep(op, sum, spring, load, 1, 0, part);
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += part[i];
    ++solution.iterations;
    solution.work.visits += 2 * static_cast<double>(sum.size());
    if (options.trace) {
      SolveIteration entry;
      entry.residual = natural_map_residual(problem, sum);
      count_states(problem.rows, states_from_impulses(problem.rows, sum), entry);
      solution.trace->iterations.push_back(entry);
    }
  }
  solution.lambda = std::move(sum);
  conclude(problem, options, solution);
  return solution;
}

Solution solve_tgs_soft(const IslandSystem& system, std::span<const double> warm_start,
                        const SolveOptions& options, std::unique_ptr<SolverMemory>*) {
  return solve_in_parts<BodyOperator>(system, warm_start, options);
}

Solution solve_tgs_soft_contact(const ContactProblem& problem, std::span<const double> warm_start,
                                const SolveOptions& options, std::unique_ptr<SolverMemory>*) {
  return solve_in_parts<MatrixOperator>(problem, warm_start, options);
}

}  // namespace

extern const SolverEntry kTgsSoftEntry{
    .name = "tgs_soft",
    .summary =
        "what game engines use: the load in 4 parts (or as told), a soft and a relaxing sweep for each",
    .reference = "Macklin et al. 2019 (small steps); Catto 2011 (soft constraints)",
    .exact = false,
    .friction = true,
    .bilateral = true,
    .solve = solve_tgs_soft,
    .solve_contact = solve_tgs_soft_contact};

}  // namespace skerry
