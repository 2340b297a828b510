// SPDX-License-Identifier: MIT
//
// Islands of which every row holds both ways (joints without limits, springs, what a projection corrects):
// the problem is linear, so one factorisation answers it.
#pragma once

#include "physics/solver/solver.h"

namespace skerry {

/// True if no row has a bound, neither its own nor a scaled one.
bool is_bilateral(const IslandSystem& system);

/// Solves W lambda = b by one factorisation and a few refinements.
///
/// Up to 12 rows, none of which depends on others: W itself, dense, on the stack, with diagonal pivoting.
/// More, if they are those of a chain whose joints come in its order (rows of a body stand at most 5 apart):
/// W again, within its envelope [George & Liu 1981, section 4.2], a tenth of the work.
/// Else the body graph (body_space_model.h) with weights 1/(eta D), whose refinement is the proximal point
/// iteration and gives dependent rows the smallest impulses. Impulses begin from zero, so the answer depends
/// on `system` alone, to the bit.
///
/// @param warm_start  not looked at
/// @param memory      keeps order and fill of the body graph
/// @return Inexact where rows contradict each other, or depend on each other nearly; Unsupported with zero
///         impulses if `is_bilateral` is false
Solution solve_bilateral(const IslandSystem& system, std::span<const double> warm_start,
                         const SolveOptions& options, std::unique_ptr<SolverMemory>* memory);
/// The same for up to three rows, without the account of a Solution: what projections ask several times a
/// step.
/// @param lambda  the answer, if there is one whose relative residual is at most `tolerance`
/// @param work    what it cost is added to it
/// @return false if there are more rows, or they have bounds, or depend on each other
bool solve_few_without_bounds(const IslandSystem& system, double tolerance, std::vector<double>& lambda,
                              SolveWork& work);

/// The same as `solve_bilateral`. @pre `is_bilateral`
/// @param scale          what errors are relative to [m/s], for rows of a larger problem; 0: the largest |b|
/// @param contradictory  if not null, becomes true where the body graph answered and what it leaves of b is
///                       what no impulses change: rows that depend on each other contradict each other, and
///                       this is their answer by least squares
Solution solve_without_bounds(const IslandSystem& system, const SolveOptions& options,
                              std::unique_ptr<SolverMemory>* memory, double scale = 0,
                              bool* contradictory = nullptr);

}  // namespace skerry
