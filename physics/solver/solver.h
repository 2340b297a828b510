// SPDX-License-Identifier: MIT
//
// Solvers for the contact problem of an island. Each is one file and one row of the registry; all answer the
// same problem (physics/islands/island_system.h) and are judged by the same residual.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <typeinfo>
#include <vector>

#include "physics/islands/island_system.h"

namespace skerry {

class Archive;

enum class SolveStatus : std::uint8_t {
  Solved,       ///< residual within the tolerance, or at the rounding floor
  Inexact,      ///< best iterate found within the budget; the residual says how good
  Singular,     ///< the method needs a regular matrix and met a singular one
  Unsupported,  ///< the method cannot treat this kind of problem (see the flags of `SolverEntry`)
  Failed,       ///< no usable answer; lambda is all zero
};
std::string_view to_string(SolveStatus status);

class ThreadPool;

struct SolveOptions {
  double tolerance = 1e-10;  ///< on the relative residual; the rounding floor is accepted in its place
  int max_iterations = 0;    ///< sweeps, pivots or factorisations; 0: the method's own limit
  /// Counted work (`SolveWork::visits`) after which the search ends with the best answer so far; 0:
  /// unlimited. The same problem always gets the same answer, whatever the clock. Kept to within one
  /// factorisation.
  double work_limit = 0;
  double time_budget =
      0;               ///< [s]; 0: unlimited. Only for methods that say so: results then depend on the clock
  bool trace = false;  ///< fill `Solution::trace`
  /// Welded bodies are solved as one (solver/welded_bodies.h); by `auto`, and where steps sweep.
  bool welds_as_one = true;
  /// Threads that methods with loops to share may use; null: the caller's alone. The answer is the same bits.
  ThreadPool* threads = nullptr;
};

/// What happened in one iteration; kept only when asked for.
struct SolveIteration {
  double residual = 0;                ///< relative, natural map
  int open = 0, stick = 0, slip = 0;  ///< states of the contacts
  int pivots = 0;                     ///< changes of state, or pivots
};

struct SolveTrace {
  std::vector<SolveIteration> iterations;
  std::vector<int> ordering;       ///< elimination order of rows or bodies; empty: natural
  std::vector<std::string> notes;  ///< for people: which rung was taken and why

  /// What was done after this, on the same problem; the ordering stays.
  SolveTrace& operator+=(const SolveTrace& other) {
    iterations.insert(iterations.end(), other.iterations.begin(), other.iterations.end());
    notes.insert(notes.end(), other.notes.begin(), other.notes.end());
    return *this;
  }
};

/// Work done, for the step report.
struct SolveWork {
  int factorisations = 0;  ///< numerical factorisations
  int partial_factorisations = 0;
  int resolves = 0;  ///< solves with a kept factor
  int pivots = 0;
  int symbolic_analyses = 0;
  int symbolic_skipped = 0;  ///< orderings and patterns reused
  int rows_left_out = 0;     ///< of welds, whose bodies were solved as one
  /// Arithmetic in units of one row's share of a Gauss-Seidel sweep, some 10 ns; of body_space, its ladder
  /// and the sweeping solvers.
  double visits = 0;

  SolveWork& operator+=(const SolveWork& other) {
    factorisations += other.factorisations;
    partial_factorisations += other.partial_factorisations;
    resolves += other.resolves;
    pivots += other.pivots;
    symbolic_analyses += other.symbolic_analyses;
    symbolic_skipped += other.symbolic_skipped;
    rows_left_out += other.rows_left_out;
    visits += other.visits;
    return *this;
  }
};

struct Solution {
  SolveStatus status = SolveStatus::Failed;
  std::vector<double> lambda;  ///< n impulses; always finite and within the bounds
  int iterations = 0;
  double residual = kInfinity;  ///< natural_map_residual(system, lambda)
  std::string_view method;      ///< the solver that gave the answer (for `auto`: the rung)
  SolveWork work;
  std::unique_ptr<SolveTrace> trace;
};

/// What a solver may keep for an island from step to step (states, factor, ordering). Made by the solver at
/// its first call; thrown away by the world when the island's graph changes.
class SolverMemory {
 public:
  virtual ~SolverMemory() = default;
  /// The row of the registry whose `make_memory` makes an empty one.
  virtual std::string_view solver() const = 0;
  /// Writes or reads everything on which a later answer depends by a bit (physics/archive.h).
  virtual void archive(Archive& archive) = 0;
};

/// The memory of one solver, whose type is not derived from; null if there is none, or another solver's.
template <class Memory>
Memory* memory_as(std::unique_ptr<SolverMemory>* memory) {
  SolverMemory* const kept = memory != nullptr ? memory->get() : nullptr;
  return kept != nullptr && typeid(*kept) == typeid(Memory) ? static_cast<Memory*>(kept) : nullptr;
}
/// The same, made if it is not there.
template <class Memory>
Memory& make_memory_as(std::unique_ptr<SolverMemory>& memory) {
  if (memory_as<Memory>(&memory) == nullptr) memory = std::make_unique<Memory>();
  return static_cast<Memory&>(*memory);
}

/// Solves `system`. @param warm_start n impulses to begin from, or empty. @param memory may be null;
/// otherwise it points to what the same solver left there for an island with the same rows, or to an empty
/// pointer to fill. Never throws for numerical reasons; the status tells. @throws std::invalid_argument for
/// malformed systems is the business of `validate`; solvers assume a valid one.
using SolveFn = Solution (*)(const IslandSystem& system, std::span<const double> warm_start,
                             const SolveOptions& options, std::unique_ptr<SolverMemory>* memory);

struct ContactProblem;  // physics/islands/delassus.h

/// The same for a problem that is given by its W (imported ones), without bodies.
using ContactSolveFn = Solution (*)(const ContactProblem& problem, std::span<const double> warm_start,
                                    const SolveOptions& options, std::unique_ptr<SolverMemory>* memory);

/// One row of the registry.
struct SolverEntry {
  std::string_view name;       ///< command-line value
  std::string_view summary;    ///< one line
  std::string_view reference;  ///< source: author, year, section
  bool exact;                  ///< reaches the rounding floor where it applies
  bool friction;               ///< solves Coulomb friction (otherwise frictionless problems only)
  bool bilateral;              ///< accepts Joint, Limit and Motor rows
  bool fixed_work = false;     ///< makes so many sweeps, whatever the work limit
  SolveFn solve;
  ContactSolveFn solve_contact = nullptr;                    ///< null for solvers that need bodies
  std::unique_ptr<SolverMemory> (*make_memory)() = nullptr;  ///< null for solvers that keep nothing
};

std::span<const SolverEntry> solvers();
/// @throws std::invalid_argument that lists the names there are.
const SolverEntry& find_solver(std::string_view name);

}  // namespace skerry
