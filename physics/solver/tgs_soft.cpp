// SPDX-License-Identifier: MIT
//
// Small steps with soft constraints, as game engines solve contacts: for comparison, and for scenes that want
// that look.
//
// The load b is applied in N equal parts. Each part begins with the impulses of those before and, as a guess,
// once more with what the last of them added; then there are a soft sweep and a relaxing one without
// softness:
//
//   soft:       lambda <- clamp(lambda - m w / D - s (lambda - lambda_0)),   m = c / (1 + c), s = 1 / (1 + c)
//   relaxing:   lambda <- clamp(lambda - w / D)
//
// with c = x (2 zeta + x), x = h omega: a spring of damping ratio zeta = 10 and a frequency of an eighth of
// the sub-step rate (x = 2 pi / 8) [Catto 2011; Macklin et al. 2019]. An engine keeps the deflection of the
// spring in the positions; a solver of velocities has none, so the spring is taken to be deflected as its
// last impulse lambda_0 says: without that a resting stack would lose a share s of its support in every part,
// and sink or burst. As a sweep sees each row once, lambda is lambda_0 there: what is left of softness is
// that the row goes a share m of its way.
//
// In an order of rows that is not a symmetric one, a guess by the whole of the last part can grow from part
// to part (where an eigenvalue of the sweeps is complex; a stack of 10 in blocks: by a tenth a part, out of
// rounding), which tells after hundreds of parts. Where parts grow, guesses pause, each time for twice as
// long.
//
// Impulses are those of all parts together, and so are their bounds: within the friction cone the friction of
// one part may use what normal impulses of others leave.
#include <algorithm>
#include <cmath>

#include "physics/solver/block_sweeps.h"
#include "physics/solver/gauss_seidel.h"
#include "physics/solver/solver_trace.h"
#include "physics/spare.h"

namespace skerry {
namespace {

constexpr int kDefaultSubsteps = 4;
constexpr double kStep = 2 * kPi / 8, kDamping = 10;
constexpr double kStiffness = kStep * (2 * kDamping + kStep);
constexpr double kMassScale = kStiffness / (1 + kStiffness);
// Velocities are guessed along with the impulses, not recomputed; every so many parts they are, so that
// rounding does not add up.
constexpr int kRefresh = 32;
// Parts that grow by so much from one refresh to the next run away.
constexpr double kRunsAway = 2;
// Bodies or blocks that a thread takes at a time.
constexpr std::size_t kVectorsAPiece = 4096;

int parts_of(const SolveOptions& options) {
  return options.max_iterations > 0 ? options.max_iterations : kDefaultSubsteps;
}

/// Whether a part is guessed from the one before, or begins where that one ended.
class Guesses {
 public:
  /// Looked at after part k, if k is one of those where the size of parts is asked for.
  static bool asks(int k) { return k % kRefresh == 0; }
  /// @param size the largest change of an impulse in part k
  void look(int k, double size) {
    if (k > kRefresh && !(size <= kRunsAway * size_)) {
      pause_ = std::max(kRefresh, 2 * pause_);
      resume_ = k + pause_;
    }
    size_ = size;
  }
  [[nodiscard]] bool after(int k) const { return k >= resume_; }

 private:
  double size_ = 0;
  int pause_ = 0, resume_ = 0;
};

template <typename Operator>
Solution solve_in_parts(const typename Operator::Problem& problem, std::span<const double> warm_start,
                        const SolveOptions& options) {
  Solution solution;
  solution.method = "tgs_soft";
  if (options.trace) solution.trace = std::make_unique<SolveTrace>();
  const int parts = parts_of(options);
  std::vector<double>& lambda = solution.lambda;
  lambda = starting_impulses(problem.rows, warm_start);
  for (double& impulse : lambda) impulse /= parts;
  std::vector<double> before(lambda.size(), 0.0);
  Operator op(problem);
  Guesses guesses;
  for (int k = 1; k <= parts; ++k) {
    op.restart(lambda);
    const double load = static_cast<double>(k) / parts;
    gauss_seidel_sweep(op, lambda, load, kMassScale);
    gauss_seidel_sweep(op, lambda, load);
    ++solution.iterations;
    solution.work.visits += 2 * static_cast<double>(lambda.size());
    if (solution.trace) record_iteration(problem, lambda, *solution.trace);
    if (k == parts) break;
    if (Guesses::asks(k)) {
      double size = 0;
      for (std::size_t i = 0; i < lambda.size(); ++i) size = std::max(size, std::abs(lambda[i] - before[i]));
      guesses.look(k, size);
    }
    const double share = guesses.after(k) ? 1 : 0;
    for (std::size_t i = 0; i < lambda.size(); ++i) {
      const double part = lambda[i] - before[i];
      before[i] = lambda[i];
      lambda[i] += share * part;
    }
  }
  conclude(problem, options, solution);
  return solution;
}

/// The same over blocks.
class BlockParts {
 public:
  /// @return false if the island does not fit into blocks
  bool run(const IslandSystem& system, std::span<const double> warm_start, const SolveOptions& options,
           Solution& solution) {
    if (!sweeps_.assign(system, true, options.threads)) return false;
    solution.method = "tgs_soft";
    solution.lambda = take_spare<std::vector<double>>();
    if (options.trace) solution.trace = std::make_unique<SolveTrace>();
    const int parts = parts_of(options);
    Vectors &x = sweeps_.impulses(), &y = sweeps_.velocities();
    sweeps_.set(warm_start);
    begin(1.0 / parts, x, x_before_, options.threads);
    begin(1.0 / parts, y, y_before_, options.threads);
    Guesses guesses;
    for (int k = 1; k <= parts; ++k) {
      sweeps_.sweep_part(static_cast<double>(k) / parts, kMassScale);
      ++solution.iterations;
      solution.work.visits += 2 * static_cast<double>(system.rows.size());
      if (solution.trace) {
        sweeps_.get(x, solution.lambda);
        record_iteration(system, solution.lambda, *solution.trace);
      }
      if (k == parts) break;
      if (Guesses::asks(k)) guesses.look(k, largest_part(x, x_before_));
      const double share = guesses.after(k) ? 1 : 0;
      guess(x, x_before_, share, options.threads);
      guess(y, y_before_, share, options.threads);
      if (k % kRefresh == 0) sweeps_.restart();
    }
    sweeps_.get(x, solution.lambda);
    if (sweeps_.contradicts())
      conclude(system, options, solution);
    else
      conclude(system, sweeps_.violation(), options, solution);
    return true;
  }

 private:
  using Vectors = std::vector<BodyVector>;

  static void begin(double share, Vectors& now, Vectors& before, ThreadPool* threads) {
    before.resize(now.size());
    skerry::share(threads, now.size(), kVectorsAPiece, [&](std::size_t from, std::size_t to) {
      for (std::size_t k = from; k < to; ++k) {
        before[k].v = Vec4{};
        now[k].v *= share;
      }
    });
  }

  static double largest_part(const Vectors& now, const Vectors& before) {
    Vec4 largest{};
    for (std::size_t k = 0; k < now.size(); ++k) {
      const Vec4 part = now[k].v - before[k].v, size = part < 0 ? -part : part;
      largest = largest < size ? size : largest;
    }
    return std::max(std::max(largest[0], largest[1]), std::max(largest[2], largest[3]));
  }

  static void guess(Vectors& now, Vectors& before, double share, ThreadPool* threads) {
    skerry::share(threads, now.size(), kVectorsAPiece, [&](std::size_t from, std::size_t to) {
      for (std::size_t k = from; k < to; ++k) {
        const Vec4 part = now[k].v - before[k].v;
        before[k].v = now[k].v;
        now[k].v += share * part;
      }
    });
  }

  BlockSweeps sweeps_;
  Vectors x_before_, y_before_;
};

Solution solve_tgs_soft(const IslandSystem& system, std::span<const double> warm_start,
                        const SolveOptions& options, std::unique_ptr<SolverMemory>*) {
  Solution solution;
  {
    Spare<BlockParts> blocks;
    if (blocks->run(system, warm_start, options, solution)) return solution;
  }
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
    .fixed_work = true,
    .solve = solve_tgs_soft,
    .solve_contact = solve_tgs_soft_contact};

}  // namespace skerry
