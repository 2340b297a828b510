// SPDX-License-Identifier: MIT
//
// Contacts that slide or roll come to rest at a moment of their own, and motors get to their speed; what
// holds them from then on is not what slowed them down.
#pragma once

#include <memory>
#include <vector>

#include "physics/solver/solver.h"
#include "physics/stepping/island_rows.h"

namespace skerry {

/// One piece of a step whose force problem is solved.
struct SolvedPiece {
  const Assembly& start;                ///< rows where the piece begins
  Assembly& assembly;                   ///< the same rows as they were solved, with the right-hand side
  const std::vector<Velocity>& before;  ///< at the beginning of the piece
  const std::vector<Velocity>& free;    ///< at its end without contact forces
  const std::vector<double>& bend;      ///< by row: what the end adds to a linear change [m/s]; or empty
  double h;                             ///< its length [s]
};

/// Whether ends of sliding are looked for: up to 16 rows, which a car has with its joints.
bool has_few_rows(const IslandSystem& system);

/// Looks for rows of friction, rolling resistance and motors with a largest force that move at the beginning
/// of the piece (against the speed that a motor aims at) and, in `solution`, no longer or backwards at its
/// end. If there are any, the piece is solved again with all of them at their bound throughout, and once more
/// with what stops then; their velocities go linearly through zero.
///
/// For islands that have few rows. In larger ones what slides ends a piece at rest or beyond it: off by mu g
/// h^2 / 8 at most where it stays at rest, by mu g h in its velocity where it goes on.
///
/// @param solution  replaced by the last one if a stop was found
/// @return time of the first stop since the beginning of the piece, or `h` [s]
double slide_to_stop(const WorldState& state, const SolvedPiece& piece, const SolveOptions& options,
                     std::unique_ptr<SolverMemory>* memory, Solution& solution);

}  // namespace skerry
