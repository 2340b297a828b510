// SPDX-License-Identifier: MIT
//
// The force method: member forces of an indeterminate structure from a determinate one in it and its
// self-stress states.
//
//   s = s0 + B x,   A s0 = p (no force in the redundant members),   A B = 0
//   B' (F s + e0) = 0   =>   (B' F B) x = -B' (F s0 + e0)
//
// F is the flexibility of the members, the inverse of their stiffness S. The answer is that of the
// displacement method; equilibrium does not pass through displacements, which are larger than strains by the
// square of the structure's slenderness, and self-stress states of trusses reach over a panel or two, so that
// B' F B has a narrow band [Livesley 1975, ch. 6; Kaneko, Lawo & Thierauf 1982].
#pragma once

#include <vector>

#include "physics/statics/sparse_lu.h"

namespace skerry::statics {

class Redundants {
 public:
  /// Chooses the redundant members and factorises.
  /// @param A  e x u, rank e; @param F  u x u, symmetric, positive definite; repeated entries are summed
  /// @param most  nonzeros of B above which the method does not pay
  /// @return false if no good choice of members was found, or B is not sparse: use another method then
  [[nodiscard]] bool factor(int e, int u, const std::vector<Entry>& A, const std::vector<Entry>& F,
                            std::size_t most);

  /// @param p  e loads; @param e0  u strains, or null for none; @param s  gets u forces
  void solve(const std::vector<double>& p, const std::vector<double>* e0, std::vector<double>& s);
  /// Adds to `s` what forces in the determinate members balance `r` (e numbers).
  void correct(const std::vector<double>& r, std::vector<double>& s);

  int count() const { return static_cast<int>(b_begin_.size()) - 1; }

 private:
  SparseLu lu_;
  std::vector<int> b_begin_{0}, b_row_;  // B, column by column
  std::vector<double> b_value_;
  std::vector<int> f_begin_, f_column_;  // F, row by row
  std::vector<double> f_value_;
  std::vector<int> order_, l_begin_, l_row_;  // P (B' F B) P' = L D L'
  std::vector<double> l_value_, inverse_d_;
  std::vector<double> x_, y_, work_, strain_;
};

}  // namespace skerry::statics
