// SPDX-License-Identifier: MIT
//
// A dense LDL^T factor of a symmetric matrix that grows and shrinks by one row and column in O(n^2), and that
// watches itself.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "physics/archive.h"

namespace skerry {

/// A = L D L^T of the rows added so far, in the order of addition; A symmetric positive semi-definite up to
/// rounding.
///
/// A new row a with diagonal a_kk is bordered on without pivoting: L y = a, l = D^-1 y, pivot d = a_kk - l'y.
/// The factor watches itself [Higham 2002, sec. 10.1 and 11.1]:
///   - d < 1e-10 a_kk: the row depends on the others, `add` says Redundant and changes nothing,
///   - d < -1e-10 a_kk: rounding has piled up, or A is indefinite; the factor is made afresh and asked again,
///   - growth max |L_ij| > 1e4: refactored with complete diagonal pivoting before the next solve,
///   - backward error |b - A x| / (|A||x| + |b|) > 1e-13: refined, then refactored with pivoting.
class IncrementalLdlt {
 public:
  enum class Added : std::uint8_t { Independent, Redundant };

  /// Appends a row and column: `column` holds a_{1..n, new} against the rows in place, `diagonal`
  /// a_{new,new}.
  /// @param redundant  relative pivot below which the row is left out
  /// @throws std::invalid_argument when the column does not have size() entries or is not finite
  Added add(std::span<const double> column, double diagonal, double redundant = 1e-10);

  /// Removes the row at `position`; those behind it move up by one. O((size - position)^2), by a rank-one
  /// update of the trailing factor [Gill, Golub, Murray, Saunders 1974].
  /// @throws std::invalid_argument when there is no such row
  void remove(int position);

  void clear();
  int size() const { return size_; }

  /// Returns x with A x = b, refined when the watch asks for it.
  /// @throws std::invalid_argument when b does not have size() entries
  std::vector<double> solve(std::span<const double> b);

  double backward_error() const { return backward_error_; }   ///< of the last solve
  double growth() const;                                      ///< max |L_ij|
  int refinements() const { return refinements_; }            ///< steps so far
  int refactorisations() const { return refactorisations_; }  ///< with or without pivoting, so far

  void fields(Archive& a) {
    auto& [size, A, L, D, order, P, E, pivoted, backward_error, refinements, refactorisations] = *this;
    a(size, A, L, D, order, P, E, pivoted, backward_error, refinements, refactorisations);
  }

 private:
  double& l(int i, int j) { return L_[offset(i) + j]; }
  double l(int i, int j) const { return L_[offset(i) + j]; }
  double a(int i, int j) const { return i >= j ? A_[offset(i) + j] : A_[offset(j) + i]; }
  static std::size_t offset(int i) {
    return static_cast<std::size_t>(i) * (static_cast<std::size_t>(i) + 1) / 2;
  }
  /// Computes the row of L and the pivot that a new row of A would get.
  double border(std::vector<double>& row, double diagonal) const;
  void refactor();
  std::vector<double> product(std::span<const double> x) const;
  std::vector<double> solve_once(std::span<const double> b) const;
  void refactor_with_pivoting();

  int size_ = 0;
  std::vector<double> A_;  ///< lower triangle by rows
  std::vector<double> L_;  ///< unit lower triangle by rows, same layout
  std::vector<double> D_;
  std::vector<int> order_;     ///< with pivoting: order_[k] is the row eliminated as number k
  std::vector<double> P_, E_;  ///< the pivoted factor and its diagonal
  bool pivoted_ = false;
  double backward_error_ = 0;
  int refinements_ = 0, refactorisations_ = 0;
};

}  // namespace skerry
