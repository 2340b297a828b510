// SPDX-License-Identifier: MIT
//
// Small islands whose rows depend on each other, nearly do, or contradict each other: joints that close a
// loop, that were made where they do not fit, or that jam.
#pragma once

#include <span>

#include "physics/solver/solver.h"

namespace skerry {

/// Rows up to which dense matrices cost no more than what else would be tried.
inline constexpr std::size_t kDependentRows = 48;

/// What `solve_dependent_rows` found.
enum class DependentRows : std::uint8_t {
  Solved,         ///< an answer within the tolerance
  Contradictory,  ///< no impulses are an answer: what no row can take would grow for ever
  Unknown,        ///< states that settle were not found
};

/// An active set on the states of the rows, of which those that are not at a bound get impulses by least
/// squares: of W scaled to 1 on its diagonal, by a complete orthogonal decomposition (Golub & Van Loan 2013,
/// sec. 5.4.7), with what changes velocities by less than 1e-7 of an impulse left out, and refinement. Begins
/// with the states of the warm start, or with everything sticking.
/// @param solution  the answer, or the best that was seen, if that is better than what is in it; its work
/// @pre system.rows.size() <= kDependentRows
DependentRows solve_dependent_rows(const IslandSystem& system, std::span<const double> warm_start,
                                   const SolveOptions& options, Solution& solution);

}  // namespace skerry
