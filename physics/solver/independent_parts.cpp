// SPDX-License-Identifier: MIT
#include "physics/solver/independent_parts.h"

#include <algorithm>

namespace skerry {

std::vector<std::vector<int>> independent_parts(const ContactProblem& problem) {
  const int n = problem.size();
  std::vector<int> leader(n);
  for (int i = 0; i < n; ++i) leader[i] = i;
  const auto find = [&](int i) {
    while (leader[i] != i) i = leader[i] = leader[leader[i]];
    return i;
  };
  const auto join = [&](int i, int j) {
    const int p = find(i), q = find(j);
    leader[std::max(p, q)] = std::min(p, q);
  };
  for (int j = 0; j < n; ++j) {
    if (is_scaled(problem.rows[j])) join(j, problem.rows[j].normal);
    for (Eigen::SparseMatrix<double>::InnerIterator it(problem.W, j); it; ++it)
      join(static_cast<int>(it.row()), j);
  }
  // A part is numbered by its first row.
  std::vector<std::vector<int>> parts;
  std::vector<int> number(n, -1);
  for (int i = 0; i < n; ++i) {
    int& part = number[find(i)];
    if (part < 0) {
      part = static_cast<int>(parts.size());
      parts.emplace_back();
    }
    parts[part].push_back(i);
  }
  return parts;
}

namespace {

/// The given rows as a problem of their own.
ContactProblem extract(const ContactProblem& problem, const std::vector<int>& rows, std::vector<int>& place) {
  ContactProblem part;
  const int n = static_cast<int>(rows.size());
  for (int k = 0; k < n; ++k) place[rows[k]] = k;
  part.W.resize(n, n);
  for (int k = 0; k < n; ++k) {
    part.W.startVec(k);
    for (Eigen::SparseMatrix<double>::InnerIterator it(problem.W, rows[k]); it; ++it) {
      part.W.insertBack(place[it.row()], k) = it.value();
    }
    part.b.push_back(problem.b[rows[k]]);
    part.rows.push_back(problem.rows[rows[k]]);
    if (is_scaled(part.rows.back())) part.rows.back().normal = place[part.rows.back().normal];
  }
  part.W.finalize();
  return part;
}

}  // namespace

Solution solve_by_parts(const ContactProblem& problem, const std::vector<std::vector<int>>& parts,
                        const std::vector<double>& start, const SolveOptions& options,
                        const PartSolveFn& solve) {
  if (parts.size() == 1) return solve(problem, start, 0);
  Solution solution;
  solution.lambda = start;
  std::vector<int> place(problem.rows.size(), -1);
  for (std::size_t k = 0; k < parts.size(); ++k) {
    std::vector<double> part_start;
    for (const int row : parts[k]) part_start.push_back(start[row]);
    Solution answer = solve(extract(problem, parts[k], place), std::move(part_start), k);
    for (std::size_t i = 0; i < parts[k].size(); ++i) solution.lambda[parts[k][i]] = answer.lambda[i];
    solution.iterations += answer.iterations;
    solution.method = answer.method;
    solution.work += answer.work;
    if (answer.trace && !solution.trace) solution.trace = std::move(answer.trace);
  }
  conclude(problem, options, solution);
  return solution;
}

}  // namespace skerry
