// SPDX-License-Identifier: MIT
#include "physics/statics/redundants.h"

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

namespace skerry::statics {
namespace {

// Entries of A are of order 1. A determinate structure that needs smaller pivots is a poor one to build on.
constexpr double kGoodPivot = 1e-2;
// What is smaller in a self-stress state is rounding of its solve.
constexpr double kRounding = 1e-14;

}  // namespace

bool Redundants::factor(int e, int u, const std::vector<Entry>& A, const std::vector<Entry>& F,
                        std::size_t most) {
  std::vector<int> redundant;
  if (!lu_.factor(e, u, A, kGoodPivot, redundant)) return false;

  // Self-stress states: one redundant member at 1, the determinate ones hold it.
  std::vector<int> number(static_cast<std::size_t>(u), -1);
  for (std::size_t k = 0; k < redundant.size(); ++k)
    number[static_cast<std::size_t>(redundant[k])] = static_cast<int>(k);
  std::vector<std::vector<Entry>> loads(redundant.size());
  for (const Entry& entry : A) {
    const int k = number[static_cast<std::size_t>(entry.column)];
    if (k >= 0) loads[static_cast<std::size_t>(k)].push_back(entry);
  }
  b_begin_.assign(1, 0);
  b_row_.clear();
  b_value_.clear();
  for (std::size_t k = 0; k < redundant.size(); ++k) {
    x_.assign(static_cast<std::size_t>(e), 0);
    for (const Entry& entry : loads[k]) x_[static_cast<std::size_t>(entry.row)] -= entry.value;
    lu_.solve(x_, work_);
    x_[static_cast<std::size_t>(redundant[k])] = 1;
    double largest = 0;
    for (const double value : x_) largest = std::max(largest, std::abs(value));
    if (!std::isfinite(largest)) return false;
    for (int i = 0; i < u; ++i) {
      const double value = x_[static_cast<std::size_t>(i)];
      if (std::abs(value) <= kRounding * largest) continue;
      b_row_.push_back(i);
      b_value_.push_back(value);
    }
    b_begin_.push_back(static_cast<int>(b_row_.size()));
    if (b_row_.size() > most) return false;
  }

  // B' F B and its factor.
  using Sparse = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
  std::vector<Eigen::Triplet<double, int>> triplets;
  triplets.reserve(F.size());
  for (const Entry& entry : F) triplets.emplace_back(entry.row, entry.column, entry.value);
  Eigen::SparseMatrix<double, Eigen::RowMajor, int> flexibility(u, u);
  flexibility.setFromTriplets(triplets.begin(), triplets.end());
  flexibility.makeCompressed();
  f_begin_.assign(flexibility.outerIndexPtr(), flexibility.outerIndexPtr() + u + 1);
  f_column_.assign(flexibility.innerIndexPtr(), flexibility.innerIndexPtr() + flexibility.nonZeros());
  f_value_.assign(flexibility.valuePtr(), flexibility.valuePtr() + flexibility.nonZeros());
  triplets.clear();
  for (int k = 0; k < count(); ++k)
    for (int i = b_begin_[static_cast<std::size_t>(k)]; i < b_begin_[static_cast<std::size_t>(k) + 1]; ++i)
      triplets.emplace_back(b_row_[static_cast<std::size_t>(i)], k, b_value_[static_cast<std::size_t>(i)]);
  Sparse B(u, count());
  B.setFromTriplets(triplets.begin(), triplets.end());
  const Sparse matrix = Sparse(B.transpose()) * Sparse(flexibility * B);
  Eigen::SimplicialLDLT<Sparse> ldlt(matrix);
  if (ldlt.info() != Eigen::Success) return false;
  const Sparse L = ldlt.matrixL();
  const Eigen::VectorXd D = ldlt.vectorD();
  l_begin_.assign(1, 0);
  l_row_.clear();
  l_value_.clear();
  inverse_d_.clear();
  order_.assign(static_cast<std::size_t>(count()), 0);
  for (int k = 0; k < count(); ++k) {
    if (!(D[k] > 0) || !std::isfinite(D[k])) return false;
    inverse_d_.push_back(1 / D[k]);
    order_[static_cast<std::size_t>(k)] = ldlt.permutationPinv().indices()[k];
    for (Sparse::InnerIterator it(L, k); it; ++it) {
      if (it.row() == k) continue;
      l_row_.push_back(static_cast<int>(it.row()));
      l_value_.push_back(it.value());
    }
    l_begin_.push_back(static_cast<int>(l_row_.size()));
  }
  return l_row_.size() <= most;
}

void Redundants::solve(const std::vector<double>& p, const std::vector<double>* e0, std::vector<double>& s) {
  const std::size_t n = inverse_d_.size(), u = f_begin_.size() - 1, e = static_cast<std::size_t>(lu_.size());
  s.assign(p.begin(), p.begin() + static_cast<std::ptrdiff_t>(e));
  lu_.solve(s, work_);

  // -(F s0 + e0)
  strain_.resize(u);
  for (std::size_t i = 0; i < u; ++i) {
    double sum = e0 ? (*e0)[i] : 0;
    for (int j = f_begin_[i]; j < f_begin_[i + 1]; ++j)
      sum += f_value_[static_cast<std::size_t>(j)] *
             s[static_cast<std::size_t>(f_column_[static_cast<std::size_t>(j)])];
    strain_[i] = -sum;
  }
  y_.resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    const auto column = static_cast<std::size_t>(order_[k]);
    double sum = 0;
    for (int i = b_begin_[column]; i < b_begin_[column + 1]; ++i)
      sum += b_value_[static_cast<std::size_t>(i)] *
             strain_[static_cast<std::size_t>(b_row_[static_cast<std::size_t>(i)])];
    y_[k] = sum;
  }
  for (std::size_t k = 0; k < n; ++k) {
    const double value = y_[k];
    for (int i = l_begin_[k]; i < l_begin_[k + 1]; ++i)
      y_[static_cast<std::size_t>(l_row_[static_cast<std::size_t>(i)])] -=
          l_value_[static_cast<std::size_t>(i)] * value;
  }
  for (std::size_t k = n; k-- > 0;) {
    double value = y_[k] * inverse_d_[k];
    for (int i = l_begin_[k]; i < l_begin_[k + 1]; ++i)
      value -= l_value_[static_cast<std::size_t>(i)] *
               y_[static_cast<std::size_t>(l_row_[static_cast<std::size_t>(i)])];
    y_[k] = value;
  }
  for (std::size_t k = 0; k < n; ++k) {
    const auto column = static_cast<std::size_t>(order_[k]);
    for (int i = b_begin_[column]; i < b_begin_[column + 1]; ++i)
      s[static_cast<std::size_t>(b_row_[static_cast<std::size_t>(i)])] +=
          b_value_[static_cast<std::size_t>(i)] * y_[k];
  }
}

void Redundants::correct(const std::vector<double>& r, std::vector<double>& s) {
  x_.assign(r.begin(), r.begin() + lu_.size());
  lu_.solve(x_, work_);
  for (std::size_t i = 0; i < s.size(); ++i) s[i] += x_[i];
}

}  // namespace skerry::statics
