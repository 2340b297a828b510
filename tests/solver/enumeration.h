// SPDX-License-Identifier: MIT
//
// The oracle for small problems: every combination of contact states, each solved in long double, and kept if
// it satisfies the definition. Frictionless velocities are unique; with friction there may be several
// answers.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "physics/islands/delassus.h"

namespace skerry {

/// Body velocity changes, three a body, of one solution.
using VelocityChange = std::vector<std::array<double, 3>>;

class Enumeration {
 public:
  /// @param system  contacts (normal, friction, rolling rows) and rows without bounds
  explicit Enumeration(const IslandSystem& system) : system_(system), n_(system.rows.size()), side_(n_, 0) {
    const Eigen::SparseMatrix<double> W = delassus(system);
    W_.assign(n_, std::vector<long double>(n_, 0));
    for (int j = 0; j < W.outerSize(); ++j) {
      for (Eigen::SparseMatrix<double>::InnerIterator it(W, j); it; ++it) W_[it.row()][j] = it.value();
    }
    scale_ = std::max(largest_magnitude(system.b), 1e-300);
    visit(0);
  }

  const std::vector<VelocityChange>& solutions() const { return solutions_; }

  /// Least distance of `lambda`'s velocities to those of a solution, in the largest component, relative to
  /// max |b|.
  double distance(const std::vector<double>& lambda) const {
    VelocityChange v(system_.bodies.size(), {0, 0, 0});
    apply_impulses(system_, lambda, v);
    double least = kInfinity;
    for (const VelocityChange& solution : solutions_) {
      double worst = 0;
      for (std::size_t k = 0; k < v.size(); ++k) {
        for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(v[k][c] - solution[k][c]));
      }
      least = std::min(least, worst / scale_);
    }
    return least;
  }

 private:
  static constexpr int kOpen = 2;

  /// side_: 0 free, -1 or +1 at that bound of the cone, kOpen: no impulse.
  void visit(std::size_t i) {
    if (i == n_) {
      try_states();
      return;
    }
    const Row& row = system_.rows[i];
    if (row.normal >= 0) {
      if (side_[row.normal] == kOpen) {
        side_[i] = kOpen;
        visit(i + 1);
        return;
      }
      for (const int side : {0, -1, 1}) {
        side_[i] = side;
        visit(i + 1);
      }
      return;
    }
    side_[i] = 0;
    visit(i + 1);
    if (row.kind != RowKind::Normal) return;
    side_[i] = kOpen;
    visit(i + 1);
  }

  void try_states() {
    std::vector<std::size_t> free;
    for (std::size_t i = 0; i < n_; ++i) {
      if (side_[i] == 0) free.push_back(i);
    }
    const std::size_t m = free.size();
    std::vector<std::vector<long double>> A(m, std::vector<long double>(m + 1));
    for (std::size_t p = 0; p < m; ++p) {
      for (std::size_t q = 0; q < m; ++q) {
        long double sum = W_[free[p]][free[q]];
        for (std::size_t t = free[q] + 1; t < n_; ++t) {
          const bool tied =
              system_.rows[t].normal == static_cast<int>(free[q]) && (side_[t] == 1 || side_[t] == -1);
          if (tied) sum += side_[t] * system_.rows[t].mu * W_[free[p]][t];
        }
        A[p][q] = sum;
      }
      A[p][m] = system_.b[free[p]];
    }
    if (!eliminate(A)) return;
    std::vector<double> lambda(n_, 0.0);
    for (std::size_t p = 0; p < m; ++p) lambda[free[p]] = static_cast<double>(A[p][m]);
    for (std::size_t t = 0; t < n_; ++t) {
      if (side_[t] == 1 || side_[t] == -1)
        lambda[t] = side_[t] * system_.rows[t].mu * lambda[system_.rows[t].normal];
    }
    if (!(natural_map_residual(system_, lambda) <= 1e-9)) return;
    if (distance(lambda) < 1e-9) return;
    VelocityChange v(system_.bodies.size(), {0, 0, 0});
    apply_impulses(system_, lambda, v);
    solutions_.push_back(v);
  }

  /// Gauss elimination with complete row pivoting; false when singular.
  static bool eliminate(std::vector<std::vector<long double>>& A) {
    const std::size_t m = A.size();
    for (std::size_t k = 0; k < m; ++k) {
      std::size_t best = k;
      for (std::size_t i = k + 1; i < m; ++i) {
        if (std::abs(A[i][k]) > std::abs(A[best][k])) best = i;
      }
      if (!(std::abs(A[best][k]) > 1e-15L * std::abs(A[0][0]))) return false;
      std::swap(A[k], A[best]);
      for (std::size_t i = 0; i < m; ++i) {
        if (i == k) continue;
        const long double factor = A[i][k] / A[k][k];
        for (std::size_t j = k; j <= m; ++j) A[i][j] -= factor * A[k][j];
      }
    }
    for (std::size_t k = 0; k < m; ++k) A[k][m] /= A[k][k];
    return true;
  }

  const IslandSystem& system_;
  std::size_t n_;
  std::vector<int> side_;
  std::vector<std::vector<long double>> W_;
  double scale_ = 1;
  std::vector<VelocityChange> solutions_;
};

}  // namespace skerry
