// SPDX-License-Identifier: MIT
//
// The search for the contact states of an exact solution, on top of any engine that solves the linear problem
// which given states leave. dense_lu, incremental_ldlt and sparse_contact are this search with three engines.
#pragma once

#include <span>
#include <vector>

#include "physics/archive.h"
#include "physics/solver/contact_states.h"

namespace skerry {

/// A slipping row: lambda[row] = factor * lambda[normal].
struct Tie {
  int row = -1, normal = -1;
  double factor = 0;
  friend bool operator==(const Tie&, const Tie&) = default;
};

inline void fields(Archive& a, Tie& v) {
  auto& [row, normal, factor] = v;
  a(row, normal, factor);
}

/// What a set of states leaves to be solved: lambda = constant for rows at bounds of their own,
/// factor * lambda[normal] for slipping rows, and unknown for the free ones.
struct Reduction {
  std::vector<int> free;         ///< rows with an unknown impulse, ascending
  std::vector<int> place;        ///< n; position in `free`, or -1
  std::vector<double> constant;  ///< n; impulse of rows that are neither free nor slipping
  std::vector<Tie> slipping;     ///< rows tied to a free normal row
};
Reduction reduce(const std::vector<Row>& rows, const std::vector<RowState>& states);

/// Puts the impulses of the free rows (in the order of `free`) together with the rest.
std::vector<double> expand(const Reduction& reduction, std::span<const double> free_impulses);

/// Solves (W + shift diag(W)) lambda = b on the free rows of a reduction.
class StateEngine {
 public:
  virtual ~StateEngine() = default;

  /// @param b      n right-hand sides (velocities)
  /// @param shift  >= 0, relative to the diagonal: the proximal term
  /// @param lambda out: n impulses; not changed on failure
  /// @return false when the matrix is singular
  virtual bool solve(const Reduction& reduction, std::span<const double> b, double shift,
                     std::vector<double>& lambda, SolveWork& work) = 0;
};

/// Searches the solution from several starts: `states` (those of the last step), the states of the warm start
/// in `solution.lambda`, all sticking, and what 60 to 2860 conjugate gradient sweeps suggest; then, with
/// `proximal`, by proximal continuation: solves about a reference impulse with the diagonal raised by
/// 10 %, moves the reference, lowers the shift, down to 1e-11 [Rockafellar 1976].
///
/// Within a start all violated rows change state at once; when their number has not fallen for eight rounds,
/// one at a time, picked by a fixed sequence of dice, until it does [Judice & Pires 1994, after Kostreva 1978
/// and Murty 1974].
///
/// @param states  in: n states to begin with, or empty; out: those of the answer
/// Fills lambda, residual, status, iterations, work and trace of `solution`. Singular: no answer was found
/// and a matrix on the way was singular.
void solve_by_states(const ContactProblem& problem, StateEngine& engine, bool proximal,
                     const SolveOptions& options, std::vector<RowState>& states, Solution& solution);

}  // namespace skerry
