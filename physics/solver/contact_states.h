// SPDX-License-Identifier: MIT
//
// What the solvers in contact space share: the state of each row (at a bound or free), the start, and the
// verdict at the end.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/islands/delassus.h"
#include "physics/solver/solver.h"

namespace skerry {

/// A normal row at Lower is an open contact; a friction row at Lower or Upper slips, Free it sticks.
enum class RowState : std::uint8_t { Lower, Free, Upper };

/// True for a friction or rolling row.
inline bool is_scaled(const Row& row) {
  return row.normal >= 0;
}

/// Moves lambda into its bounds, in row order; what is not finite becomes zero first.
void clamp_to_bounds(const std::vector<Row>& rows, std::vector<double>& lambda);

/// Returns the warm start clamped to the bounds, or zeros (clamped) when it does not have n entries.
std::vector<double> starting_impulses(const std::vector<Row>& rows, std::span<const double> warm_start);

/// States read off impulses: at a bound, within `slack` of it relative to the bound's own size, or free. A
/// friction row of an open contact is Free, so that a contact that closes starts by sticking.
std::vector<RowState> states_from_impulses(const std::vector<Row>& rows, const std::vector<double>& lambda,
                                           double slack = 1e-9);

/// Everything that touches sticks: the cold start that needs the fewest changes in heaps at rest.
std::vector<RowState> all_sticking(const std::vector<Row>& rows);

/// Counts open, sticking and slipping contacts into a trace entry.
void count_states(const std::vector<Row>& rows, const std::vector<RowState>& states, SolveIteration& entry);

/// Rounding is no excuse for more than this (relative): where contacts contradict each other, impulses run
/// away, and the rounding of theirs explains anything.
inline constexpr double kHighestFloor = 1e-4;

/// Judges `solution.lambda` from the definition: clamps it, sets the residual, and the status to Solved if
/// the residual is within the tolerance or within 16 rounding floors (the sums of a solver's own arithmetic
/// round a few times more often than those of the residual; `kHighestFloor` at most, and on islands only the
/// floors of impulses that something calls for, see wedging.h), else Inexact.
void conclude(const IslandSystem& system, const SolveOptions& options, Solution& solution);
void conclude(const ContactProblem& problem, const SolveOptions& options, Solution& solution);
/// The same where sweeps know the largest violation of the natural map [m/s], which is not computed again
/// where it is far from an answer: what may be called solved is judged by the rows themselves.
void conclude(const IslandSystem& system, double violation, const SolveOptions& options, Solution& solution);

/// Runs a contact-space solver on an island: builds W, solves, judges on the island.
Solution solve_in_contact_space(ContactSolveFn solve, const IslandSystem& system,
                                std::span<const double> warm_start, const SolveOptions& options,
                                std::unique_ptr<SolverMemory>* memory);

}  // namespace skerry
