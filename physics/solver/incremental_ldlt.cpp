// SPDX-License-Identifier: MIT
#include "physics/solver/incremental_ldlt.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "physics/text.h"

namespace skerry {
namespace {

constexpr double kIndefinite = -1e-10, kGrowth = 1e4, kBackwardError = 1e-13;
constexpr int kMaxRefinements = 3;

}  // namespace

IncrementalLdlt::Added IncrementalLdlt::add(std::span<const double> column, double diagonal,
                                            double redundant) {
  if (static_cast<int>(column.size()) != size_) {
    throw std::invalid_argument("column must have " + std::to_string(size_) + " entries, got " +
                                std::to_string(column.size()));
  }
  bool finite = std::isfinite(diagonal);
  for (const double value : column) finite = finite && std::isfinite(value);
  if (!finite)
    throw std::invalid_argument("column and diagonal must be finite, diagonal is " + to_text(diagonal));

  std::vector<double> row(column.begin(), column.end());
  double pivot = border(row, diagonal);
  if (pivot < kIndefinite * diagonal) {
    refactor();
    row.assign(column.begin(), column.end());
    pivot = border(row, diagonal);
  }
  if (!(pivot >= redundant * diagonal) || !(pivot > 0)) return Added::Redundant;

  A_.insert(A_.end(), column.begin(), column.end());
  A_.push_back(diagonal);
  L_.insert(L_.end(), row.begin(), row.end());
  L_.push_back(1);
  D_.push_back(pivot);
  ++size_;
  pivoted_ = false;
  return Added::Independent;
}

double IncrementalLdlt::border(std::vector<double>& row, double diagonal) const {
  for (int j = 0; j < size_; ++j) {
    const double* Lj = &L_[offset(j)];
    double sum = row[j];
    for (int k = 0; k < j; ++k) sum -= Lj[k] * row[k];
    row[j] = sum;
  }
  double pivot = diagonal;
  for (int j = 0; j < size_; ++j) {
    const double scaled = row[j] / D_[j];
    pivot -= scaled * row[j];
    row[j] = scaled;
  }
  return pivot;
}

void IncrementalLdlt::refactor() {
  ++refactorisations_;
  const int n = size_;
  L_.clear();
  D_.clear();
  for (size_ = 0; size_ < n; ++size_) {
    std::vector<double> row(A_.begin() + static_cast<std::ptrdiff_t>(offset(size_)),
                            A_.begin() + static_cast<std::ptrdiff_t>(offset(size_) + size_));
    const double diagonal = A_[offset(size_) + size_];
    // Rows that were independent when they came are kept; the floor only keeps the pivot positive.
    const double pivot = std::max(border(row, diagonal), 1e-16 * diagonal);
    L_.insert(L_.end(), row.begin(), row.end());
    L_.push_back(1);
    D_.push_back(pivot);
  }
}

void IncrementalLdlt::remove(int position) {
  if (position < 0 || position >= size_) {
    throw std::invalid_argument("no row " + std::to_string(position) + " among " + std::to_string(size_));
  }
  const int n = size_, tail = n - position - 1;
  // Deleting row p of A leaves L11 as it is and adds d_p l_p l_p' to the trailing block.
  std::vector<double> z(tail);
  for (int i = 0; i < tail; ++i) z[i] = l(position + 1 + i, position);
  double weight = D_[position];

  const auto without = [&](const std::vector<double>& packed) {
    std::vector<double> result;
    result.reserve(offset(n - 1));
    for (int i = 0; i < n; ++i) {
      if (i == position) continue;
      for (int j = 0; j <= i; ++j) {
        if (j != position) result.push_back(packed[offset(i) + j]);
      }
    }
    return result;
  };
  A_ = without(A_);
  L_ = without(L_);
  D_.erase(D_.begin() + position);
  size_ = n - 1;
  pivoted_ = false;

  // Rank-one update with positive weight: pivots only grow, so it is stable.
  for (int k = 0; k < tail; ++k) {
    const int row = position + k;
    const double p = z[k], old = D_[row], fresh = old + weight * p * p;
    const double beta = weight * p / fresh;
    weight *= old / fresh;
    D_[row] = fresh;
    for (int i = k + 1; i < tail; ++i) {
      double& entry = l(position + i, row);
      z[i] -= p * entry;
      entry += beta * z[i];
    }
  }
}

void IncrementalLdlt::clear() {
  size_ = 0;
  A_.clear();
  L_.clear();
  D_.clear();
  pivoted_ = false;
}

double IncrementalLdlt::growth() const {
  double largest = 0;
  for (int i = 0; i < size_; ++i) {
    for (int j = 0; j < i; ++j) largest = std::max(largest, std::abs(l(i, j)));
  }
  return largest;
}

std::vector<double> IncrementalLdlt::product(std::span<const double> x) const {
  std::vector<double> y(x.size(), 0.0);
  for (int i = 0; i < size_; ++i) {
    const double* row = &A_[offset(i)];
    double sum = row[i] * x[i];
    for (int j = 0; j < i; ++j) {
      sum += row[j] * x[j];
      y[j] += row[j] * x[i];
    }
    y[i] += sum;
  }
  return y;
}

std::vector<double> IncrementalLdlt::solve_once(std::span<const double> b) const {
  const std::vector<double>& L = pivoted_ ? P_ : L_;
  const std::vector<double>& D = pivoted_ ? E_ : D_;
  std::vector<double> x(b.size());
  for (int i = 0; i < size_; ++i) x[i] = pivoted_ ? b[order_[i]] : b[i];
  for (int i = 0; i < size_; ++i) {
    const double* row = &L[offset(i)];
    double sum = x[i];
    for (int j = 0; j < i; ++j) sum -= row[j] * x[j];
    x[i] = sum;
  }
  // A pivot that is zero belongs to a dependent row, which gets no impulse.
  for (int i = 0; i < size_; ++i) x[i] = D[i] != 0 ? x[i] / D[i] : 0;
  for (int i = size_ - 1; i >= 0; --i) {
    const double* row = &L[offset(i)];
    for (int j = 0; j < i; ++j) x[j] -= row[j] * x[i];
  }
  if (!pivoted_) return x;
  std::vector<double> result(x.size());
  for (int i = 0; i < size_; ++i) result[order_[i]] = x[i];
  return result;
}

void IncrementalLdlt::refactor_with_pivoting() {
  ++refactorisations_;
  pivoted_ = true;
  order_.resize(size_);
  for (int i = 0; i < size_; ++i) order_[i] = i;
  // Right-looking elimination of the dense square; the largest diagonal that is left comes next.
  const int n = size_;
  std::vector<double> S(static_cast<std::size_t>(n) * n);
  const auto at = [&](int i, int j) -> double& { return S[static_cast<std::size_t>(i) * n + j]; };
  double largest = 0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) at(i, j) = a(i, j);
    largest = std::max(largest, std::abs(a(i, i)));
  }
  P_.assign(offset(n), 0.0);
  E_.assign(n, 0.0);
  for (int k = 0; k < n; ++k) {
    int best = k;
    for (int i = k + 1; i < n; ++i) {
      if (std::abs(at(i, i)) > std::abs(at(best, best))) best = i;
    }
    if (best != k) {
      std::swap(order_[k], order_[best]);
      for (int j = 0; j < n; ++j) std::swap(at(k, j), at(best, j));
      for (int j = 0; j < n; ++j) std::swap(at(j, k), at(j, best));
    }
    const double pivot = at(k, k);
    // n eps max|A|: what is left is rounding, the rows from here on depend on those before.
    const bool zero = std::abs(pivot) <= n * 2.2e-16 * largest;
    E_[k] = zero ? 0 : pivot;
    for (int i = k + 1; i < n; ++i) {
      const double factor = zero ? 0 : at(i, k) / pivot;
      for (int j = k + 1; j < n; ++j) at(i, j) -= factor * at(k, j);
      at(i, k) = factor;
    }
  }
  // The factors of a column stand below its pivot, and were swapped along with their rows.
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) P_[offset(i) + j] = at(i, j);
    P_[offset(i) + i] = 1;
  }
}

std::vector<double> IncrementalLdlt::solve(std::span<const double> b) {
  if (static_cast<int>(b.size()) != size_) {
    throw std::invalid_argument("b must have " + std::to_string(size_) + " entries, got " +
                                std::to_string(b.size()));
  }
  if (!pivoted_ && growth() > kGrowth) refactor_with_pivoting();
  double norm = 0;
  for (int i = 0; i < size_; ++i) {
    double sum = 0;
    for (int j = 0; j < size_; ++j) sum += std::abs(a(i, j));
    norm = std::max(norm, sum);
  }
  const auto magnitude = [](std::span<const double> v) {
    double largest = 0;
    for (const double value : v) largest = std::max(largest, std::abs(value));
    return largest;
  };
  std::vector<double> x, error(b.size());
  const auto measure = [&](const std::vector<double>& solution) {
    const std::vector<double> Ax = product(solution);
    for (std::size_t i = 0; i < error.size(); ++i) error[i] = b[i] - Ax[i];
    const double scale = norm * magnitude(solution) + magnitude(b);
    const double relative = scale > 0 ? magnitude(error) / scale : 0;
    return std::isfinite(relative) ? relative : 1;
  };
  const auto solve_refined = [&] {
    x = solve_once(b);
    backward_error_ = measure(x);
    for (int k = 0; k < kMaxRefinements && backward_error_ > kBackwardError; ++k) {
      ++refinements_;
      const std::vector<double> step = solve_once(error);
      for (std::size_t i = 0; i < x.size(); ++i) x[i] += step[i];
      const double before = backward_error_;
      backward_error_ = measure(x);
      if (!(backward_error_ < 0.5 * before)) break;
    }
  };
  solve_refined();
  if (backward_error_ > kBackwardError && !pivoted_) {
    refactor_with_pivoting();
    solve_refined();
  }
  return x;
}

}  // namespace skerry
