// SPDX-License-Identifier: MIT
//
// The sweeps of a step in one piece (physics/stepping/one_piece.h), for velocities and for positions.
#pragma once

#include <span>
#include <type_traits>
#include <vector>

#include "physics/solver/block_sweeps.h"
#include "physics/solver/cone_interior_point.h"
#include "physics/solver/solver.h"
#include "physics/solver/solver_trace.h"
#include "physics/spare.h"

namespace skerry {

// Share of the work that the velocities get; the rest is for the positions.
inline constexpr double kVelocityShare = 0.8;
// Packing an island for the sweeps, in sweeps.
inline constexpr double kSetUp = 5;
// Sweeps before an interior point goes on from where they came, and how many times as many before it does
// again.
inline constexpr int kInteriorFrom = 20, kInteriorAgain = 5;
// Residual at which nothing more is done after it.
inline constexpr double kGoodEnough = 1e-8;
// Sweeps, or share of the work if these are more, after which points are looked for that only the impulses of
// others close: before an interior point, which would have to be done again with them.
inline constexpr int kFirstSweeps = 40;
inline constexpr double kFirstShare = 0.6;
// Changes of a sweep, as a share of the largest free velocity, from which on that is vain: sweeps are too far
// from an answer.
inline constexpr double kAstray = 0.1;

/// Shares by which rows of joints and contacts give (`BlockSweeps::soften`).
struct Give {
  double joints = 0, contacts = 0;
};

inline bool look_at_nothing(const std::vector<double>&) {
  return false;
}

/// Sweeps, which at this price leave no more than cleverer methods do (tests/bench/solver.md).
/// @param exact  no preview: in that one they count no setting up, as its solvers do not
/// @param look   is shown the impulses when `kFirstShare` of the work is done, and again after an interior
/// point, and says whether to stop there
/// @param swept  visits of sweeps at most: the rest of the work is for interior points
template <class Look>
Solution sweep_until_done(const IslandSystem& system, bool exact, std::span<const double> warm,
                          const SolveOptions& options, Give give, Look&& look, double swept = kInfinity) {
  constexpr bool kLooks = !std::is_same_v<std::decay_t<Look>, decltype(&look_at_nothing)>;
  static const SolverEntry& standard = find_solver("pgs");
  Spare<BlockSweeps> sweeps;
  if (!sweeps->assign(system, true, options.threads)) {
    Solution solution = standard.solve(system, warm, options, nullptr);
    look(solution.lambda);
    return solution;
  }
  Solution solution;
  solution.method = standard.name;
  if (options.trace) solution.trace = std::make_unique<SolveTrace>();
  sweeps->soften(give.joints, give.contacts);
  sweeps->set(warm);
  const double rows = static_cast<double>(system.rows.size());
  const double scale = residual_scale(largest_magnitude(system.b));
  double target = options.tolerance * scale;
  solution.work.visits = exact ? kSetUp * rows : 0;
  double worst = sweeps->violation();
  bool looked = false;
  double change = 0;
  const auto has_work = [&] {
    return solution.work.visits < options.work_limit && solution.iterations * rows < swept;
  };
  const auto stops = [&] {
    looked = true;
    if (change > kAstray * scale) return false;
    sweeps->get(sweeps->impulses(), solution.lambda);
    return look(solution.lambda);
  };
  const auto due = [&] {
    return solution.iterations == kFirstSweeps || solution.work.visits >= kFirstShare * options.work_limit;
  };
  int attempt = kLooks ? kFirstSweeps : kInteriorFrom;
  while (worst > target && has_work()) {
    if (!looked && due() && stops()) break;
    if (solution.iterations == attempt) {
      attempt *= kInteriorAgain;
      if (improve_by_interior_point(system, options.work_limit, options.threads, *sweeps, worst,
                                    solution.work)) {
        target = std::max(target, kGoodEnough * scale);
        if (solution.trace) {
          sweeps->get(sweeps->impulses(), solution.lambda);
          record_iteration(system, solution.lambda, *solution.trace);
          solution.trace->notes.emplace_back("an interior point went on from the sweeps");
        }
        // Sweeps that were astray, as with a heavy body on light ones, may have an answer to look at now.
        looked = false;
        change = worst;
      }
      if (worst <= target) break;
    }
    int count = 0;
    do {
      ++count;
      ++solution.iterations;
      solution.work.visits += rows;
    } while (count < sweeps->together() && solution.iterations != attempt && (looked || !due()) &&
             has_work());
    // The change underestimates the violation.
    change = sweep_and_record(*sweeps, count, system, solution.trace.get());
    const bool done = change <= 0.5 * target || !has_work();
    if (done) worst = sweeps->violation();
  }
  if (!looked) stops();
  sweeps->get(sweeps->impulses(), solution.lambda);
  solution.residual = worst / scale;
  solution.status = worst <= options.tolerance * scale ? SolveStatus::Solved : SolveStatus::Inexact;
  return solution;
}

}  // namespace skerry
