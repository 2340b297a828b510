// SPDX-License-Identifier: MIT
#include "physics/solver/auto.h"

#include <algorithm>
#include <chrono>
#include <string>

#include "physics/solver/body_space.h"
#include "physics/solver/contact_states.h"
#include "physics/solver/convex_step.h"

namespace skerry {
namespace {

// Sweeps of the last rung; each costs about a tenth of a factorisation.
constexpr int kLastSweeps = 100;

struct AutoMemory : SolverMemory {
  std::unique_ptr<SolverMemory> body_space, convex;
};

bool is_one_contact(const IslandSystem& system) {
  if (system.rows.size() > 3 || system.rows[0].kind != RowKind::Normal) return false;
  for (std::size_t i = 1; i < system.rows.size(); ++i)
    if (system.rows[i].normal != 0) return false;
  return true;
}

// The first of the named solvers that this build has.
const SolverEntry& first_of(std::string_view name, std::string_view other) {
  for (const SolverEntry& entry : solvers())
    if (entry.name == name) return entry;
  return find_solver(other);
}

void note(Solution& solution, std::string text) {
  if (solution.trace) solution.trace->notes.push_back(std::move(text));
}

// Keeps the better answer; notes and work of both are kept.
void take_better(Solution& best, Solution&& other) {
  best.work += other.work;
  other.work = best.work;
  if (best.trace && other.trace) {
    auto& notes = best.trace->notes;
    notes.insert(notes.end(), other.trace->notes.begin(), other.trace->notes.end());
    auto& iterations = best.trace->iterations;
    iterations.insert(iterations.end(), other.trace->iterations.begin(), other.trace->iterations.end());
    other.trace = std::move(best.trace);
  }
  if (other.residual < best.residual)
    best = std::move(other);
  else
    best.trace = std::move(other.trace);
}

}  // namespace

Solution solve_auto(const IslandSystem& system, std::span<const double> warm_start,
                    const SolveOptions& options, std::unique_ptr<SolverMemory>* memory) {
  Solution solution;
  if (system.rows.empty()) {
    solution.status = SolveStatus::Solved;
    solution.residual = 0;
    solution.method = "none";
    if (options.trace) solution.trace = std::make_unique<SolveTrace>();
    note(solution, "no rows: free flight");
    return solution;
  }
  if (is_one_contact(system)) {
    static const SolverEntry& closed_form = find_solver("closed_form");
    solution = closed_form.solve(system, warm_start, options, nullptr);
    if (solution.status == SolveStatus::Solved) {
      note(solution, "one contact: closed form");
      return solution;
    }
  }

  std::unique_ptr<SolverMemory> local;
  if (!memory) memory = &local;
  if (!dynamic_cast<AutoMemory*>(memory->get())) *memory = std::make_unique<AutoMemory>();
  auto& kept = static_cast<AutoMemory&>(**memory);
  const auto begin = std::chrono::steady_clock::now();
  SolveOptions rest = options;

  solution = solve_body_space(system, warm_start, rest, &kept.body_space);
  if (solution.status == SolveStatus::Solved) return solution;

  // What is left of the budget; the convex step is always granted a few factorisations.
  const auto remaining = [&] {
    if (options.max_iterations > 0)
      rest.max_iterations = std::max(10, options.max_iterations - solution.work.factorisations);
    if (options.time_budget > 0) {
      const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
      rest.time_budget = std::max(0.1 * options.time_budget, options.time_budget - spent.count());
    }
  };
  const bool has_friction = std::any_of(system.rows.begin(), system.rows.end(), is_scaled);
  if (has_friction) {
    remaining();
    note(solution, "convex step: friction bounds fixed");
    const std::vector<double> bounds = warm_start.size() == system.rows.size()
                                           ? std::vector<double>(warm_start.begin(), warm_start.end())
                                           : solution.lambda;
    take_better(solution, solve_convex_step(system, bounds, rest, &kept.convex));
  }
  if (solution.status == SolveStatus::Inexact) {
    static const SolverEntry& sweeps = first_of("nncg", "pgs");
    note(solution, "sweeps from the best answer so far");
    remaining();
    rest.max_iterations = kLastSweeps;
    take_better(solution, sweeps.solve(system, solution.lambda, rest, nullptr));
  }
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
};

}  // namespace skerry
