// SPDX-License-Identifier: MIT
#include "physics/solver/auto.h"

#include <algorithm>
#include <chrono>
#include <string>

#include "physics/archive.h"
#include "physics/solver/bilateral.h"
#include "physics/solver/body_space.h"
#include "physics/solver/contact_states.h"
#include "physics/solver/convex_step.h"
#include "physics/solver/dependent_rows.h"
#include "physics/solver/independent_parts.h"
#include "physics/solver/small_exact.h"
#include "physics/solver/small_states.h"
#include "physics/solver/still_rows.h"
#include "physics/solver/tridiagonal.h"
#include "physics/solver/wedging.h"
#include "physics/solver/welded_bodies.h"
#include "physics/spare.h"

namespace skerry {
namespace {

// Sweeps of the last rung; each costs about a tenth of a factorisation.
constexpr int kLastSweeps = 100;
// Shares of the work limit: of the exact search, and what the convex step and the sweeps get at least.
constexpr double kExactShare = 0.6, kConvexShare = 0.25, kSweepShare = 0.1;
// Rounds of the convex step, and the residual relative to the last round's above which it is given up.
constexpr int kConvexRounds = 20;
constexpr double kConvexProgress = 0.8;
// Visits a row within which few bodies with joints mostly have their answer (99 of 100 in random mechanisms
// take less than 200), and those that jammed ones may cost.
constexpr double kSoon = 300, kJammedWork = 3000;
// Rows up to which complementary pivoting ends within seconds.
constexpr std::size_t kPivotingRows = 2000;
// A relative residual above which another start of the sweeps is tried.
constexpr double kPoor = 1e-2;

// Sweeps in search of smaller impulses, and the share of their size [W_ii lambda_i^2] that is worth another
// answer.
constexpr int kLooseningSweeps = 500;
constexpr double kSmaller = 0.25;
// Work of a pivot of Lemke's method on a table of a row times a row, its share of what is left of a limit,
// and pivots a row: answers were found within 12.
constexpr double kPivotVisits = 0.5, kPivotShare = 0.25, kPivotsARow = 16;

// Rows up to which a factor costs less than what keeps it from step to step: memory, and a key to find it by.
constexpr std::size_t kForgottenRows = 24;

struct AutoMemory final : SolverMemory {
  std::unique_ptr<SolverMemory> body_space, convex, bilateral;
  std::unique_ptr<SolverMemory> groups;  ///< of the problem of welded bodies

  std::string_view solver() const override { return "auto"; }
  void archive(Archive& a) override { a(body_space, convex, bilateral, groups); }
};

bool is_one_contact(const IslandSystem& system) {
  if (system.rows.size() > 3 || system.rows[0].kind != RowKind::Normal) return false;
  for (std::size_t i = 1; i < system.rows.size(); ++i)
    if (system.rows[i].normal != 0) return false;
  return true;
}

// Rows i and i + 1 share a body, others do not: W is tridiagonal. Only contacts in which every body has two.
bool is_chain(const IslandSystem& system) {
  Spare<std::vector<int>> spare;
  std::vector<int>& rows_of_body = *spare;
  rows_of_body.assign(system.bodies.size(), 0);
  for (std::size_t i = 0; i < system.rows.size(); ++i) {
    const Row& row = system.rows[i];
    if (row.kind != RowKind::Normal || row.a < 0 || row.b < 0) return false;
    if (++rows_of_body[static_cast<std::size_t>(row.a)] > 2) return false;
    if (++rows_of_body[static_cast<std::size_t>(row.b)] > 2) return false;
    if (i == 0) continue;
    const Row& last = system.rows[i - 1];
    if (row.a != last.a && row.a != last.b && row.b != last.a && row.b != last.b) return false;
  }
  return true;
}

constexpr const char* kDependent = "rows that depend on each other: least squares";

void note(Solution& solution, const char* text) {
  if (solution.trace) solution.trace->notes.emplace_back(text);
}

// Takes the other answer in place of the first one, or not; notes and work of both are kept.
void take(bool other_is_better, Solution& best, Solution&& other) {
  best.work += other.work;
  other.work = best.work;
  if (best.trace) {
    if (other.trace) *best.trace += *other.trace;
    other.trace = std::move(best.trace);
  }
  if (other_is_better)
    best = std::move(other);
  else
    best.trace = std::move(other.trace);
}

void take_better(Solution& best, Solution&& other) {
  const bool better = other.residual < best.residual;
  take(better, best, std::move(other));
}

// Rows without bounds.
Solution solve_all_bilateral(const IslandSystem& system, std::span<const double> warm_start,
                             const SolveOptions& options, std::unique_ptr<SolverMemory>* memory) {
  // Small islands leave no memory behind.
  AutoMemory* const kept = memory_as<AutoMemory>(memory);
  std::unique_ptr<SolverMemory> fresh;
  std::unique_ptr<SolverMemory>& own = kept ? kept->bilateral : fresh;
  bool contradictory = false;
  Solution solution = solve_without_bounds(system, options, &own, 0, &contradictory);
  if (fresh && memory != nullptr) {
    auto all = std::make_unique<AutoMemory>();
    all->bilateral = std::move(fresh);
    *memory = std::move(all);
  }
  if (solution.status == SolveStatus::Solved) return solution;
  if (system.rows.size() <= kDependentRows) {
    note(solution, kDependent);
    solve_dependent_rows(system, {}, options, solution);
    return solution;
  }
  if (contradictory) {
    note(solution, kDependent);
    return solution;
  }
  // Rows that depend on each other nearly want smaller weights.
  Solution other = solve_body_space(system, warm_start, options, nullptr);
  other.work += solution.work;
  solution.work = other.work;
  if (other.residual < 0.5 * solution.residual) {
    note(other, "no bounds, but nearly dependent rows");
    std::swap(solution, other);
  }
  return solution;
}

// The look with which body_space begins, without its memory: the last impulses may still be right.
bool try_warm(const IslandSystem& system, std::span<const double> warm_start, const SolveOptions& options,
              Solution& solution) {
  if (warm_start.size() != system.rows.size()) return false;
  std::vector<double> lambda = take_spare<std::vector<double>>();
  lambda.assign(warm_start.begin(), warm_start.end());
  const double residual = clamp_and_judge(system, lambda, options.tolerance, options.threads);
  if (!(residual <= options.tolerance)) {
    give_spare(std::move(lambda));
    return false;
  }
  solution.lambda = std::move(lambda);
  solution.residual = residual;
  solution.status = SolveStatus::Solved;
  solution.method = "body_space";
  solution.work.visits = static_cast<double>(system.rows.size());
  if (options.trace) solution.trace = std::make_unique<SolveTrace>();
  note(solution, "the warm start solves the problem already");
  return true;
}

// Lemke's method, with its work.
Solution solve_by_pivoting(const IslandSystem& system, const SolveOptions& options) {
  static const SolverEntry& lemke = find_solver("lemke");
  const auto rows = static_cast<double>(system.rows.size());
  Solution found = lemke.solve(system, {}, options, nullptr);
  found.work.visits += kPivotVisits * found.work.pivots * rows * rows;
  return found;
}

// Where bodies are wedged in, other ways may lead to an answer that presses less.
void loosen(const IslandSystem& system, const SolveOptions& options, Solution& solution) {
  if (solution.status != SolveStatus::Solved || !is_wedged(system, solution.lambda)) return;
  note(solution, "impulses beyond what moves the bodies: smaller ones are looked for");
  for (const std::string_view name : {"body_space", "lemke", "nncg"}) {
    if (name == "lemke" && system.rows.size() > kStateRows) continue;
    SolveOptions within = options;
    if (name == "nncg") within.max_iterations = kLooseningSweeps;
    if (options.work_limit > 0) within.work_limit = options.work_limit - solution.work.visits;
    if (options.work_limit > 0 && !(within.work_limit > 0)) return;
    Solution other = name == "lemke" ? solve_by_pivoting(system, within)
                                     : find_solver(name).solve(system, {}, within, nullptr);
    const bool smaller =
        other.status == SolveStatus::Solved &&
        size_of_impulses(system, other.lambda) < kSmaller * size_of_impulses(system, solution.lambda);
    take(smaller, solution, std::move(other));
    if (smaller && !is_wedged(system, solution.lambda)) return;
  }
}

/// Impulses that feed each other, by much friction between masses far apart or on what has its axle held, are
/// the answers of few states of many: complementary pivoting finds them.
bool try_pivoting(const IslandSystem& system, const SolveOptions& options, Solution& solution) {
  if (system.rows.size() > kStateRows) return false;
  const auto rows = static_cast<double>(system.rows.size());
  double pivots = kPivotsARow * rows;
  if (options.work_limit > 0)
    pivots = std::min(
        pivots, kPivotShare * (options.work_limit - solution.work.visits) / (kPivotVisits * rows * rows));
  if (!(pivots > rows)) return false;
  SolveOptions within = options;
  within.max_iterations = static_cast<int>(pivots);
  within.work_limit = 1;  // with few bases enumerated: all of them would take milliseconds
  note(solution, "no answer: complementary pivoting");
  take_better(solution, solve_by_pivoting(system, within));
  return solution.status == SolveStatus::Solved;
}

/// Welded bodies as one. @return false, and nothing has happened, where there are none
bool try_as_one(const IslandSystem& system, std::span<const double> warm_start, const SolveOptions& options,
                std::unique_ptr<SolverMemory>* memory, Solution& solution) {
  if (!options.welds_as_one) return false;
  Spare<WeldedBodies> welded;
  if (!welded->find(system)) return false;
  if (system.rows.size() <= kForgottenRows) memory = nullptr;
  AutoMemory* const kept = memory ? &make_memory_as<AutoMemory>(*memory) : nullptr;
  Spare<std::vector<double>> warm;
  welded->restrict_to_groups(warm_start, *warm);
  solution = solve_auto(welded->groups(), *warm, options, kept ? &kept->groups : nullptr);
  welded->expand(solution, options, kept ? &kept->bilateral : nullptr);
  return true;
}

/// Rows that nothing can follow, left out. @return false, and nothing has happened, where there are none
bool try_without_still_rows(const IslandSystem& system, std::span<const double> warm_start,
                            const SolveOptions& options, std::unique_ptr<SolverMemory>* memory,
                            Solution& solution) {
  StillRows still;
  if (!still.find(system)) return false;
  Spare<std::vector<double>> warm;
  still.restrict(warm_start, *warm);
  solution = solve_auto(still.others(), *warm, options, memory);
  note(solution, "rows that nothing can follow: at the bound that they ask for");
  still.expand(solution, options);
  return true;
}

}  // namespace

Solution solve_auto(const IslandSystem& system, std::span<const double> warm_start,
                    const SolveOptions& options, std::unique_ptr<SolverMemory>* memory) {
  if (system.rows.empty()) {
    Solution none;
    none.status = SolveStatus::Solved;
    none.residual = 0;
    none.method = "none";
    if (options.trace) none.trace = std::make_unique<SolveTrace>();
    note(none, "no rows: free flight");
    return none;
  }
  Solution solution;
  if (try_without_still_rows(system, warm_start, options, memory, solution)) return solution;
  if (is_bilateral(system)) return solve_all_bilateral(system, warm_start, options, memory);
  if (is_one_contact(system)) {
    static const SolverEntry& closed_form = find_solver("closed_form");
    Solution formula = closed_form.solve(system, warm_start, options, nullptr);
    if (formula.status == SolveStatus::Solved) {
      note(formula, "one contact: closed form");
      return formula;
    }
  }

  if (try_as_one(system, warm_start, options, memory, solution)) return solution;
  constexpr const char* kChain = "chain without friction: tridiagonal";
  if (try_chain(system, options, solution)) {
    note(solution, kChain);
    return solution;
  }
  const bool smooth = std::none_of(system.rows.begin(), system.rows.end(), is_scaled);
  if (smooth && is_chain(system)) {
    static const SolverEntry& tridiagonal = find_solver("tridiagonal");
    solution = tridiagonal.solve(system, warm_start, options, nullptr);
    if (solution.status == SolveStatus::Solved) {
      note(solution, kChain);
      return solution;
    }
  }
  const bool warm = std::any_of(warm_start.begin(), warm_start.end(), [](double z) { return z != 0; });
  const auto begin = std::chrono::steady_clock::now();
  SolveOptions rest = options;
  double most = options.work_limit;
  rest.work_limit = kExactShare * most;
  if (!warm) {
    if (try_small_exact(system, options, solution)) return solution;
    if (try_small_states(system, {}, options, solution)) {
      loosen(system, options, solution);
      return solution;
    }
    if (fits_small_exact(system)) memory = nullptr;
  } else if (system.rows.size() <= kStateRows && system.bodies.size() <= kStateBodies) {
    if (try_warm(system, warm_start, options, solution) ||
        try_small_states(system, warm_start, options, solution)) {
      loosen(system, options, solution);
      return solution;
    }
  }

  if (system.rows.size() <= kForgottenRows) memory = nullptr;
  AutoMemory* const kept = memory ? &make_memory_as<AutoMemory>(*memory) : nullptr;
  std::unique_ptr<SolverMemory> fresh;  // of the rounds below
  const auto search = [&](const SolveOptions& within) {
    Solution found = solve_body_space(system, warm_start, within, kept ? &kept->body_space : nullptr);
    if (solution.lambda.empty()) {
      found.work += solution.work;
      solution = std::move(found);
    } else {
      take_better(solution, std::move(found));
    }
    loosen(system, options, solution);
    return solution.status == SolveStatus::Solved;
  };
  // Joints of few bodies that have no answer soon depend on each other or jam.
  if (system.rows.size() <= kDependentRows && system.rows.front().kind != RowKind::Normal) {
    const auto rows = static_cast<double>(system.rows.size());
    SolveOptions soon = rest;
    soon.work_limit = std::min(most > 0 ? rest.work_limit : kInfinity, kSoon * rows);
    if (search(soon)) return solution;
    note(solution, kDependent);
    const DependentRows found = solve_dependent_rows(system, solution.lambda, options, solution);
    if (found == DependentRows::Solved) solution.method = "dependent_rows";
    if (found != DependentRows::Unknown) return solution;
    if (most > 0) most = std::min(most, kJammedWork * rows);
    rest.work_limit = kExactShare * most;
  }
  const bool none_left = !solution.lambda.empty() && most > 0 && solution.work.visits >= most;
  if (!none_left && search(rest)) return solution;
  if (!smooth && try_pivoting(system, options, solution)) return solution;

  // What is left of the budget; each rung is granted a share of its own, whatever the ones before took.
  const auto remaining = [&](double share) {
    if (options.max_iterations > 0)
      rest.max_iterations = std::max(10, options.max_iterations - solution.work.factorisations);
    if (options.work_limit > 0) rest.work_limit = std::max(share * most, most - solution.work.visits);
    if (options.time_budget > 0) {
      const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
      rest.time_budget = std::max(0.1 * options.time_budget, options.time_budget - spent.count());
    }
  };
  if (!smooth) {
    note(solution, "convex step: friction bounds fixed");
    std::vector<double> bounds = warm_start.size() == system.rows.size()
                                     ? std::vector<double>(warm_start.begin(), warm_start.end())
                                     : solution.lambda;
    // Bounds from the normal impulses of the answer lead to Coulomb's law where the fixed point contracts.
    double last = kInfinity;
    for (int round = 0; round < kConvexRounds; ++round) {
      remaining(round == 0 ? kConvexShare : 0);
      if (options.work_limit > 0 && !(rest.work_limit > 0)) break;
      Solution convex = solve_convex_step(system, bounds, rest, kept ? &kept->convex : &fresh);
      const double residual = convex.residual;
      bounds = convex.lambda;
      take_better(solution, std::move(convex));
      if (solution.status == SolveStatus::Solved || !(residual < kConvexProgress * last)) break;
      last = residual;
    }
  }
  if (solution.status == SolveStatus::Inexact) {
    static const SolverEntry& sweeps = find_solver("nncg");
    note(solution, "sweeps from the best answer so far");
    remaining(kSweepShare);
    rest.max_iterations = kLastSweeps;
    take_better(solution, sweeps.solve(system, solution.lambda, rest, nullptr));
    // An iterate that was cut off by the budget can be worse than none: sweeps from nothing never are.
    if (solution.residual > kPoor) {
      note(solution, "sweeps from nothing");
      remaining(kSweepShare);
      rest.max_iterations = kLastSweeps;
      take_better(solution, sweeps.solve(system, {}, rest, nullptr));
    }
  }
  loosen(system, options, solution);
  return solution;
}

Solution solve_auto_contact(const ContactProblem& problem, std::span<const double> warm_start,
                            const SolveOptions& options, std::unique_ptr<SolverMemory>* memory) {
  // An unsymmetric W is no island: complementary pivoting alone is made for it.
  const bool symmetric = problem.W.isApprox(Eigen::SparseMatrix<double>(problem.W.transpose()), 1e-9);
  std::size_t largest = 0;
  for (const std::vector<int>& part : independent_parts(problem)) largest = std::max(largest, part.size());
  const bool pivots = largest <= kPivotingRows;
  Solution solution;
  if (symmetric || !pivots) {
    static const SolverEntry& sparse = find_solver("sparse_contact");
    solution = sparse.solve_contact(problem, warm_start, options, memory);
    if (solution.status == SolveStatus::Solved || !pivots) return solution;
  }
  static const SolverEntry& lemke = find_solver("lemke");
  take_better(solution, lemke.solve_contact(problem, warm_start, options, nullptr));
  return solution;
}

extern const SolverEntry kAutoEntry;
const SolverEntry kAutoEntry = {
    .name = "auto",
    .summary = "the cheapest solver that answers the island exactly, by a ladder; verified, within a budget",
    .reference = "physics/README.md",
    .exact = true,
    .friction = true,
    .bilateral = true,
    .solve = solve_auto,
    .solve_contact = solve_auto_contact,
    .make_memory = []() -> std::unique_ptr<SolverMemory> { return std::make_unique<AutoMemory>(); },
};

}  // namespace skerry
