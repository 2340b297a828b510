// SPDX-License-Identifier: MIT
//
// Nonsmooth nonlinear conjugate gradients: a projected Gauss-Seidel sweep gives the (negative) gradient, and
// Fletcher-Reeves directions carry its memory [Silcowitz, Niebe, Erleben 2010]. Ten to hundreds of times
// fewer sweeps than Gauss-Seidel alone; the fallback of busy islands.
//
// Two things differ from the paper. The length of a gradient is measured in the norm of diag(W), so that
// light and heavy bodies count by their velocities; and the best iterate is kept, for the residual is not
// monotone.
#include <cmath>

#include "physics/solver/block_sweeps.h"
#include "physics/solver/gauss_seidel.h"
#include "physics/solver/solver_trace.h"
#include "physics/spare.h"

namespace skerry {
namespace {

constexpr int kDefaultSweeps = 1000;
/// Of a sweep with its extrapolation, in sweeps without.
constexpr double kSweepCost = 1.5;
/// Velocities are recombined, not recomputed; every so many sweeps they are, so that rounding does not add
/// up.
constexpr int kRefresh = 32;

template <typename Operator>
class Nncg {
 public:
  Nncg(const typename Operator::Problem& problem, std::span<const double> warm_start,
       const SolveOptions& options)
      : problem_(problem),
        options_(options),
        op_(problem),
        lambda_(starting_impulses(problem.rows, warm_start)) {
    op_.restart(lambda_);
    direction_.assign(lambda_.size(), 0.0);
    state_direction_ = op_.state();
    solution_.method = "nncg";
    if (options.trace) solution_.trace = std::make_unique<SolveTrace>();
  }

  Solution run() {
    const double target = options_.tolerance * largest_magnitude(problem_.b);
    const int sweeps = options_.max_iterations > 0 ? options_.max_iterations : kDefaultSweeps;
    double last_length = 0, least_change = kInfinity;
    const double limit = options_.work_limit > 0 ? options_.work_limit : kInfinity;
    while (solution_.iterations < sweeps && solution_.work.visits < limit) {
      const std::vector<double> before = lambda_;
      const typename Operator::State state_before = op_.state();
      const double change = gauss_seidel_sweep(op_, lambda_);
      ++solution_.iterations;
      solution_.work.visits += kSweepCost * static_cast<double>(lambda_.size());

      // The iterate right after a sweep is within its bounds: only such ones are answers.
      if (change < least_change) {
        least_change = change;
        solution_.lambda = lambda_;
      }
      if (options_.trace) record_iteration(problem_, lambda_, *solution_.trace);
      if (change <= 0.5 * target && natural_map_residual(problem_, lambda_) <= options_.tolerance) {
        solution_.lambda = lambda_;
        break;
      }
      extrapolate(before, state_before, last_length);
    }
    if (solution_.lambda.empty()) solution_.lambda = lambda_;
    conclude(problem_, options_, solution_);
    return std::move(solution_);
  }

 private:
  /// lambda += beta p, p = beta p - gradient; p is dropped where the gradient has grown.
  void extrapolate(const std::vector<double>& before, const typename Operator::State& state_before,
                   double& last_length) {
    double length = 0;
    for (std::size_t i = 0; i < lambda_.size(); ++i) {
      length += op_.diagonal(i) * (lambda_[i] - before[i]) * (lambda_[i] - before[i]);
    }
    const double beta = last_length > 0 ? length / last_length : 0;
    last_length = length;
    const double kept = beta <= 1 ? beta : 0;
    const std::vector<double> swept = lambda_;
    const typename Operator::State state_swept = op_.state();
    if (kept > 0) {
      for (std::size_t i = 0; i < lambda_.size(); ++i) lambda_[i] += kept * direction_[i];
      op_.add_state(kept, state_direction_);
    }
    for (std::size_t i = 0; i < lambda_.size(); ++i) {
      direction_[i] = kept * direction_[i] + (swept[i] - before[i]);
    }
    combine(kept, state_swept, state_before);
    if (solution_.iterations % kRefresh == 0) op_.restart(lambda_);
  }

  void combine(double kept, const std::vector<double>& after, const std::vector<double>& before) {
    for (std::size_t i = 0; i < after.size(); ++i) {
      state_direction_[i] = kept * state_direction_[i] + (after[i] - before[i]);
    }
  }
  void combine(double kept, const std::vector<std::array<double, 3>>& after,
               const std::vector<std::array<double, 3>>& before) {
    for (std::size_t k = 0; k < after.size(); ++k) {
      for (std::size_t c = 0; c < 3; ++c) {
        state_direction_[k][c] = kept * state_direction_[k][c] + (after[k][c] - before[k][c]);
      }
    }
  }

  const typename Operator::Problem& problem_;
  const SolveOptions& options_;
  Operator op_;
  std::vector<double> lambda_, direction_;
  typename Operator::State state_direction_;
  Solution solution_;
};

/// The same over blocks of scaled rows: the norm of diag(W) is the plain one there.
class BlockNncg {
 public:
  using Vectors = std::vector<BodyVector>;

  /// @return false if the island does not fit into blocks
  bool run(const IslandSystem& system, std::span<const double> warm_start, const SolveOptions& options,
           Solution& solution) {
    if (!sweeps_.assign(system)) return false;
    sweeps_.set(warm_start);
    solution.method = "nncg";
    if (options.trace) solution.trace = std::make_unique<SolveTrace>();
    const double target = options.tolerance * largest_magnitude(system.b);
    const int most = options.max_iterations > 0 ? options.max_iterations : kDefaultSweeps;
    const double limit = options.work_limit > 0 ? options.work_limit : kInfinity;
    Vectors &x = sweeps_.impulses(), &y = sweeps_.velocities();
    p_.assign(x.size(), BodyVector{});
    q_.assign(y.size(), BodyVector{});
    double last_length = 0, least_change = kInfinity;
    while (solution.iterations < most && solution.work.visits < limit) {
      x0_ = x;
      y0_ = y;
      const double change = sweep_and_record(sweeps_, 1, system, solution.trace.get());
      ++solution.iterations;
      solution.work.visits += kSweepCost * static_cast<double>(system.rows.size());
      // The iterate right after a sweep is within its bounds: only such ones are answers.
      if (change < least_change) {
        least_change = change;
        best_ = x;
      }
      if (change <= 0.5 * target) {
        sweeps_.get(x, solution.lambda);
        if (natural_map_residual(system, solution.lambda) <= options.tolerance) {
          best_ = x;
          break;
        }
      }
      // x += beta p, p = beta p - gradient; p is dropped where the gradient has grown.
      const double length = squared_distance(x, x0_);
      const double beta = last_length > 0 ? length / last_length : 0;
      last_length = length;
      const double kept = beta <= 1 ? beta : 0;
      extrapolate(kept, x0_, p_, x);
      extrapolate(kept, y0_, q_, y);
      if (solution.iterations % kRefresh == 0) sweeps_.restart();
    }
    sweeps_.get(best_.empty() ? x : best_, solution.lambda);
    conclude(system, options, solution);
    return true;
  }

  void clear() { best_.clear(); }

 private:
  static double squared_distance(const Vectors& a, const Vectors& b) {
    Vec4 sum{};
    for (std::size_t k = 0; k < a.size(); ++k) {
      const Vec4 d = a[k].v - b[k].v;
      sum += d * d;
    }
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
  }

  static void extrapolate(double kept, const Vectors& before, Vectors& direction, Vectors& x) {
    for (std::size_t k = 0; k < x.size(); ++k) {
      const Vec4 last = kept * direction[k].v;
      direction[k].v = last + (x[k].v - before[k].v);
      x[k].v += last;
    }
  }

  BlockSweeps sweeps_;
  Vectors x0_, y0_, p_, q_, best_;
};

Solution solve_nncg(const IslandSystem& system, std::span<const double> warm_start,
                    const SolveOptions& options, std::unique_ptr<SolverMemory>*) {
  Solution solution;
  const bool fits = [&] {
    Spare<BlockNncg> blocks;
    return blocks->run(system, warm_start, options, solution);
  }();
  if (fits) return solution;
  return Nncg<BodyOperator>(system, warm_start, options).run();
}

Solution solve_nncg_contact(const ContactProblem& problem, std::span<const double> warm_start,
                            const SolveOptions& options, std::unique_ptr<SolverMemory>*) {
  return Nncg<MatrixOperator>(problem, warm_start, options).run();
}

}  // namespace

extern const SolverEntry kNncgEntry{
    .name = "nncg",
    .summary =
        "nonsmooth nonlinear conjugate gradients over Gauss-Seidel sweeps, up to 1000 unless told otherwise",
    .reference = "Silcowitz, Niebe & Erleben 2010",
    .exact = false,
    .friction = true,
    .bilateral = true,
    .solve = solve_nncg,
    .solve_contact = solve_nncg_contact};

}  // namespace skerry
