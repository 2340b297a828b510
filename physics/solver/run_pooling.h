// SPDX-License-Identifier: MIT
//
// Rows in a path that only push: W is a tridiagonal M-matrix (couplings not above zero) and impulses have the
// bounds 0 and +inf. One pass from the left finds which rows press and eliminates them on the way.
//
// What presses stays so: a row that approaches when it comes joins the run on its left, and a row at rest
// between two runs joins both when their impulses make it approach [Chandrasekaran 1970; for equal discs this
// pools adjacent violators of the order of velocities, Barlow et al. 1972]. A run is known by its two ends,
// so that each row joins once, in O(1) with one division: it separates what it joins, and its pivot is that
// of nested dissection. Backwards in the order of joining, each row then needs only the impulses on both
// sides of the run that it made.
#pragma once

#include <vector>

#include "physics/solver/simd.h"

namespace skerry {

/// W along a path, and what the rows want.
struct PathRow {
  double diagonal = 0;  ///< above zero
  double push = 0;      ///< minus the coupling with the row before, not below zero; of the first row: zero
  double b = 0;
};

/// Finds the impulses of a path that only pushes.
class RunPooling {
 public:
  /// Takes `n` rows in path order. @param source  `bool(int k, PathRow&)`, false to give up
  /// @param slack  rows that approach by less are at rest
  /// @return false if the source gave up, or at a pivot that is not positive to rounding: dependent rows
  template <class Source>
  SKERRY_ALWAYS_INLINE bool join_rows(int n, double slack, Source&& source);

  /// After `join_rows`: writes the impulses of all rows, and zero at `impulse[n]`.
  void solve(double* impulse) const;

  /// Calls `f(k)` for every row at rest.
  template <class F>
  void each_at_rest(F&& f) const {
    for (int i = 0; i < at_rest_; ++i) f(rest_[static_cast<std::size_t>(i)].row);
  }

 private:
  // A row at rest and the run on its left, which may be empty: what is needed to join both.
  struct Rest {
    int row, first;                 // of the run; `row` if it is empty
    double diagonal, pivot;         // without and with the run
    double approach;                // by which the row approaches under the run's impulses
    double reach;                   // what an impulse here adds to that of the run's first row; 1 if empty
    double g_first, inverse_first;  // of the run: impulse of its first row, entry of its W^-1
  };
  // A row that presses: its impulse is g + left x push x impulse of the row before the run that it made
  // + the same on the right.
  struct Joined {
    double g, left, right;
    int row, before, behind;
  };

  int n_ = 0, at_rest_ = 0, joined_ = 0;
  std::vector<double> push_;  // of each row on the next; zero of the last, and behind it
  std::vector<Rest> rest_;
  std::vector<Joined> join_;
};

template <class Source>
SKERRY_ALWAYS_INLINE bool RunPooling::join_rows(int n, double slack, Source&& source) {
  constexpr double kDependent = 1e-14;
  constexpr int kRestart = 4;
  const auto size = static_cast<std::size_t>(n);
  if (push_.size() < size + 1) {
    push_.resize(size + 1);
    rest_.resize(size);
    join_.resize(size);
  }
  double* const push = push_.data();
  Rest* rest = rest_.data();
  Joined* joined = join_.data();
  n_ = n;
  push[n] = 0;
  // The run on the left of the row that comes: W^-1 between its ends, and their impulses if nothing pushes
  // from outside.
  int first = 0;
  double g_first = 0, g_last = 0, inverse_first = 0, inverse_last = 0, across = 0;
  // inverse_last as a fraction, whose parts need no division from row to row: the chain of pivots is then one
  // of a product and a sum. It begins anew every few rows, before the parts get large.
  double minor = 0, major = 1;
  for (int k = 0; k < n; ++k) {
    PathRow row;
    if (!source(k, row)) return false;
    const double p = row.push;
    if (k > 0) push[k - 1] = p;
    const double reach = first == k ? 1 : p * across;
    const double approach = p * g_last + row.b;
    if (!(approach > slack)) {
      const double pivot = row.diagonal - p * p * inverse_last;
      *rest++ = {k, first, row.diagonal, pivot, approach, reach, g_first, inverse_first};
      first = k + 1;
      g_first = g_last = inverse_first = inverse_last = minor = 0;
      major = 1;
      continue;
    }
    const double larger = row.diagonal * major - p * p * minor;
    if (!(larger > kDependent * (row.diagonal * major))) return false;
    const double inverse = major / larger, g = approach * inverse;
    minor = major;
    major = larger;
    if (k % kRestart == 0) {
      minor = inverse;
      major = 1;
    }
    across = reach * inverse;
    g_first += reach * g;
    inverse_first += reach * across;
    g_last = g;
    inverse_last = inverse;
    *joined++ = {g, across, inverse, k, first > 0 ? first - 1 : n, k + 1};
    // Its impulse reaches the row before its run, which may have to join.
    while (first > 0) {
      const Rest& before = rest[-1];
      const double next = push[before.row];
      const double approaches = next * g_first + before.approach;
      if (!(approaches > slack)) break;
      const double d = before.pivot - next * next * inverse_first;
      if (!(d > kDependent * before.diagonal)) return false;
      const double i = 1 / d, impulse = approaches * i, reach_last = next * across;
      const double left = before.reach * i, right = reach_last * i;
      g_last += reach_last * impulse;
      inverse_last += reach_last * right;
      minor = inverse_last;
      major = 1;
      across = before.reach * right;
      g_first = before.g_first + before.reach * impulse;
      inverse_first = before.inverse_first + before.reach * left;
      first = before.first;
      *joined++ = {impulse, left, right, before.row, first > 0 ? first - 1 : n, k + 1};
      --rest;
    }
  }
  if (n > 0) push[n - 1] = 0;
  at_rest_ = static_cast<int>(rest - rest_.data());
  joined_ = static_cast<int>(joined - join_.data());
  return true;
}

}  // namespace skerry
