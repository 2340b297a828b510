// SPDX-License-Identifier: MIT
//
// The sweeps of a step in one piece (physics/stepping/one_piece.h), for velocities and for positions.
#pragma once

#include <array>
#include <span>
#include <type_traits>
#include <vector>

#include "physics/solver/block_sweeps.h"
#include "physics/solver/cone_interior_point.h"
#include "physics/solver/solver.h"
#include "physics/solver/solver_trace.h"
#include "physics/solver/welded_bodies.h"
#include "physics/spare.h"

namespace skerry {

// Share of the work that the velocities get; the rest is for the positions.
inline constexpr double kVelocityShare = 0.8;
// Packing an island for the sweeps, in sweeps.
inline constexpr double kSetUp = 5;
// Sweeps over velocities, and over positions, that are made whatever they cost, where the user has not said
// what they may: bodies that are all in each other have many times as many rows as they have work.
inline constexpr double kLeastSweeps = 8, kLeastShiftSweeps = 4;
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

// Sweeps in which long chains of joints are answered as a whole come near an answer within some dozens, or
// nowhere. Where little work is to do, they stop at this residual, and where so many of them leave more than
// a share of what was there before.
inline constexpr double kNearEnough = 1e-4, kFalls = 0.7;
inline constexpr int kJudged = 10;
// Violation of the impulses to begin with, as a share of the largest free velocity, from which on it is
// looked at whether they are of any use.
inline constexpr double kWild = 100;

/// Shares by which rows of joints and contacts give (`BlockSweeps::soften`).
struct Give {
  double joints = 0, contacts = 0;
};
/// What joints and contacts beside them give of a shift of positions, as shares of what one alone would want:
/// where a jam leaves no room for both, it stays bounded, and limbs rather slip through each other than out
/// of their joints.
inline constexpr Give kShiftGive{.joints = 0.01, .contacts = 0.1};

/// When sweeps end that have not come to the answer, other than by their work.
struct SweepEnd {
  double swept = kInfinity;  ///< visits of sweeps at most: the rest of the work is for interior points
  bool coarse = false;       ///< those with chains of joints also as `kNearEnough` says
};

/// Work [visits] for so many sweeps over an island.
inline double work_of_sweeps(const IslandSystem& system, double sweeps) {
  return (kSetUp + sweeps) * static_cast<double>(system.rows.size());
}

inline bool look_at_nothing(const std::vector<double>&) {
  return false;
}

/// Whether impulses leave more energy than none would, by the quadratic that frictionless answers minimise:
/// those of a piece that was cut short say nothing about a whole step, and sweeps from there would take
/// thousands to forget them.
inline bool are_worse_than_none(const IslandSystem& system, std::span<const double> impulses) {
  Spare<std::vector<double>> lambda;
  lambda->assign(impulses.begin(), impulses.end());
  Spare<std::vector<std::array<double, 3>>> change;
  change->assign(system.bodies.size(), {});
  apply_impulses(system, *lambda, *change);
  double energy = 0;
  for (std::size_t i = 0; i < lambda->size(); ++i) {
    const Row& row = system.rows[i];
    double u = system.compliance.empty() ? 0 : system.compliance[i] * (*lambda)[i];
    if (row.a >= 0) u += along(row.Ja, (*change)[static_cast<std::size_t>(row.a)]);
    if (row.b >= 0) u += along(row.Jb, (*change)[static_cast<std::size_t>(row.b)]);
    energy += (*lambda)[i] * (0.5 * u - system.b[i]);
  }
  return !(energy <= 0);
}

/// Sweeps, which at this price leave no more than cleverer methods do (tests/bench/solver.md).
/// @param exact  no preview: in that one they count no setting up, as its solvers do not
/// @param look   is shown the impulses when `kFirstShare` of the work is done, and again after an interior
/// point, and says whether to stop there
template <class Look>
Solution sweep_bodies(const IslandSystem& system, bool exact, std::span<const double> warm,
                      const SolveOptions& options, Give give, Look&& look, const SweepEnd& end) {
  constexpr bool kLooks = !std::is_same_v<std::decay_t<Look>, decltype(&look_at_nothing)>;
  static const SolverEntry& standard = find_solver("pgs");
  Spare<BlockSweeps> sweeps;
  if (!sweeps->assign(system, true, options.threads, true)) {
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
  const bool coarse = end.coarse && sweeps->lined(), gives = give.joints > 0 || give.contacts > 0;
  double target = std::max(options.tolerance, coarse ? kNearEnough : 0) * scale;
  solution.work.visits = exact ? kSetUp * rows : 0;
  double worst = sweeps->violation();
  const bool jointed = !system.rows.empty() && system.rows.front().kind != RowKind::Normal;
  if (jointed && !warm.empty() && !(worst <= kWild * scale) && are_worse_than_none(system, warm)) {
    sweeps->set({});
    worst = sweeps->violation();
  }
  bool looked = false;
  double change = 0, judged = kInfinity;
  const auto has_work = [&] {
    return solution.work.visits < options.work_limit && solution.iterations * rows < end.swept;
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
    const bool falls = !coarse || solution.iterations % kJudged != 0 || change <= kFalls * judged;
    if (solution.iterations % kJudged == 0) judged = change;
    // The answer of rows that give is one to other rows.
    const bool ends = !falls || (gives && change <= target);
    const bool done = change <= 0.5 * target || !has_work() || ends;
    if (done) worst = sweeps->violation();
    if (ends) break;
  }
  if (!looked) stops();
  sweeps->get(sweeps->impulses(), solution.lambda);
  solution.residual = worst / scale;
  solution.status = worst <= options.tolerance * scale ? SolveStatus::Solved : SolveStatus::Inexact;
  return solution;
}

/// The same with welded bodies as one, which sweeps would take long to find out.
template <class Look>
Solution sweep_until_done(const IslandSystem& system, bool exact, std::span<const double> warm,
                          const SolveOptions& options, Give give, Look&& look, const SweepEnd& end = {}) {
  constexpr bool kLooks = !std::is_same_v<std::decay_t<Look>, decltype(&look_at_nothing)>;
  Spare<WeldedBodies> welded;
  if (!options.welds_as_one || !welded->find(system))
    return sweep_bodies(system, exact, warm, options, give, look, end);
  Spare<std::vector<double>> own;
  welded->restrict_to_groups(warm, *own);
  std::unique_ptr<SolverMemory> memory;
  SolveWork work;
  Solution solution;
  if constexpr (kLooks) {
    Spare<std::vector<double>> all;
    const auto look_at_all = [&](const std::vector<double>& of_groups) {
      welded->expand(of_groups, options, &memory, *all, work);
      return look(*all);
    };
    solution = sweep_bodies(welded->groups(), exact, *own, options, give, look_at_all, end);
  } else {
    solution = sweep_bodies(welded->groups(), exact, *own, options, give, look, end);
  }
  solution.work += work;
  welded->expand(solution, options, &memory);
  return solution;
}

}  // namespace skerry
