// SPDX-License-Identifier: MIT
//
// Imported problems often hold hundreds of islands; solved one by one they cost less and fail less.
#pragma once

#include <functional>
#include <vector>

#include "physics/solver/contact_states.h"

namespace skerry {

/// Returns the rows of each part of the problem that no entry of W and no friction bound ties to another
/// part. Parts are ordered by their first row, rows ascend.
std::vector<std::vector<int>> independent_parts(const ContactProblem& problem);

/// Solves one part from its starting impulses; the last argument is the number of the part.
using PartSolveFn = std::function<Solution(const ContactProblem&, std::vector<double>, std::size_t)>;

/// Solves part by part and judges the whole; a single part is handed on as it is. Work and iterations are the
/// sums, the trace is that of the first part that has one.
Solution solve_by_parts(const ContactProblem& problem, const std::vector<std::vector<int>>& parts,
                        const std::vector<double>& start, const SolveOptions& options,
                        const PartSolveFn& solve);

}  // namespace skerry
