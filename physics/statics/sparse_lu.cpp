// SPDX-License-Identifier: MIT
#include "physics/statics/sparse_lu.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

namespace skerry::statics {

bool SparseLu::factor(int n, const std::vector<Entry>& entries, double smallest_pivot) {
  return eliminate(n, n, entries, smallest_pivot, nullptr);
}

bool SparseLu::factor(int n, int columns, const std::vector<Entry>& entries, double smallest_pivot,
                      std::vector<int>& left_out) {
  left_out.clear();
  return eliminate(n, columns, entries, smallest_pivot, &left_out);
}

bool SparseLu::eliminate(int n, int columns, const std::vector<Entry>& entries, double smallest_pivot,
                         std::vector<int>* left_out) {
  n_ = n;
  columns_ = columns;
  const auto size = static_cast<std::size_t>(n);
  std::vector<Eigen::Triplet<double, int>> triplets;
  triplets.reserve(entries.size());
  for (const Entry& entry : entries) triplets.emplace_back(entry.row, entry.column, entry.value);
  Eigen::SparseMatrix<double, Eigen::ColMajor, int> matrix(n, columns);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  matrix.makeCompressed();

  std::vector<int> candidates(static_cast<std::size_t>(columns));
  if (n > 0 && columns > 0) {
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
    Eigen::COLAMDOrdering<int>()(matrix, order);
    for (int i = 0; i < columns; ++i) candidates[static_cast<std::size_t>(order.indices()[i])] = i;
  }
  column_order_.clear();

  row_position_.assign(size, -1);
  lower_ = {};
  upper_ = {};
  lower_.begin.push_back(0);
  upper_.begin.push_back(0);
  inverse_pivot_.assign(size, 0);

  // While factorising, rows of L carry their numbers in A; positions follow at the end.
  std::vector<double> x(size, 0);
  std::vector<char> marked(size, 0);
  std::vector<int> reach, stack, cursor(size, 0);
  for (const int column : candidates) {
    const auto k = column_order_.size();

    // Which rows the column fills: depth first through the columns of L, in reverse topological order.
    reach.clear();
    for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, column); it; ++it) {
      if (marked[static_cast<std::size_t>(it.row())]) continue;
      stack.assign(1, static_cast<int>(it.row()));
      marked[static_cast<std::size_t>(it.row())] = 1;
      const auto first_of = [&](int row) {
        const int position = row_position_[static_cast<std::size_t>(row)];
        return position < 0 ? 0 : lower_.begin[static_cast<std::size_t>(position)];
      };
      cursor[static_cast<std::size_t>(it.row())] = first_of(static_cast<int>(it.row()));
      while (!stack.empty()) {
        const auto row = static_cast<std::size_t>(stack.back());
        const int position = row_position_[row];
        const int end = position < 0 ? 0 : lower_.begin[static_cast<std::size_t>(position) + 1];
        bool deeper = false;
        for (int& at = cursor[row]; at < end;) {
          const int next = lower_.row[static_cast<std::size_t>(at++)];
          if (marked[static_cast<std::size_t>(next)]) continue;
          marked[static_cast<std::size_t>(next)] = 1;
          cursor[static_cast<std::size_t>(next)] = first_of(next);
          stack.push_back(next);
          deeper = true;
          break;
        }
        if (deeper) continue;
        reach.push_back(static_cast<int>(row));
        stack.pop_back();
      }
    }

    // x = L \ column, in topological order.
    for (Eigen::SparseMatrix<double>::InnerIterator it(matrix, column); it; ++it)
      x[static_cast<std::size_t>(it.row())] = it.value();
    for (auto row = reach.rbegin(); row != reach.rend(); ++row) {
      const int position = row_position_[static_cast<std::size_t>(*row)];
      if (position < 0) continue;
      const double value = x[static_cast<std::size_t>(*row)];
      const auto begin = static_cast<std::size_t>(lower_.begin[static_cast<std::size_t>(position)]);
      const auto end = static_cast<std::size_t>(lower_.begin[static_cast<std::size_t>(position) + 1]);
      for (std::size_t i = begin; i < end; ++i)
        x[static_cast<std::size_t>(lower_.row[i])] -= lower_.value[i] * value;
    }

    // The largest of the rows without a position is the pivot; of equals the first, for the same bits always.
    int pivot = -1;
    double largest = smallest_pivot;
    for (const int row : reach) {
      const auto i = static_cast<std::size_t>(row);
      if (row_position_[i] >= 0) continue;
      const double size_of = std::abs(x[i]);
      if (size_of > largest || (pivot >= 0 && size_of == largest && row < pivot)) {
        largest = size_of;
        pivot = row;
      }
    }
    const bool usable = pivot >= 0 && std::isfinite(largest);
    if (!usable && left_out) {
      for (const int row : reach) {
        x[static_cast<std::size_t>(row)] = 0;
        marked[static_cast<std::size_t>(row)] = 0;
      }
      left_out->push_back(column);
      continue;
    }
    const double inverse = usable ? 1 / x[static_cast<std::size_t>(pivot)] : 0;
    for (const int row : reach) {
      const auto i = static_cast<std::size_t>(row);
      const double value = x[i];
      x[i] = 0;
      marked[i] = 0;
      if (row == pivot || value == 0) continue;
      if (row_position_[i] >= 0) {
        upper_.row.push_back(row_position_[i]);
        upper_.value.push_back(value);
      } else {
        lower_.row.push_back(row);
        lower_.value.push_back(value * inverse);
      }
    }
    if (!usable) return false;
    column_order_.push_back(column);
    row_position_[static_cast<std::size_t>(pivot)] = static_cast<int>(k);
    inverse_pivot_[k] = inverse;
    lower_.begin.push_back(static_cast<int>(lower_.row.size()));
    upper_.begin.push_back(static_cast<int>(upper_.row.size()));
  }
  if (column_order_.size() != size) return false;
  for (int& row : lower_.row) row = row_position_[static_cast<std::size_t>(row)];
  return true;
}

void SparseLu::solve(std::vector<double>& x, std::vector<double>& work) const {
  const auto n = static_cast<std::size_t>(n_);
  work.resize(n);
  for (std::size_t i = 0; i < n; ++i) work[static_cast<std::size_t>(row_position_[i])] = x[i];
  if (columns_ > n_) x.assign(static_cast<std::size_t>(columns_), 0);
  for (std::size_t k = 0; k < n; ++k) {
    const double value = work[k];
    if (value == 0) continue;  // loads touch few nodes
    for (int i = lower_.begin[k]; i < lower_.begin[k + 1]; ++i)
      work[static_cast<std::size_t>(lower_.row[static_cast<std::size_t>(i)])] -=
          lower_.value[static_cast<std::size_t>(i)] * value;
  }
  for (std::size_t k = n; k-- > 0;) {
    const double value = work[k] * inverse_pivot_[k];
    x[static_cast<std::size_t>(column_order_[k])] = value;
    if (value == 0) continue;
    for (int i = upper_.begin[k]; i < upper_.begin[k + 1]; ++i)
      work[static_cast<std::size_t>(upper_.row[static_cast<std::size_t>(i)])] -=
          upper_.value[static_cast<std::size_t>(i)] * value;
  }
}

void SparseLu::solve_transposed(std::vector<double>& x, std::vector<double>& work) const {
  const auto n = static_cast<std::size_t>(n_);
  work.resize(n);
  for (std::size_t k = 0; k < n; ++k) {
    double value = x[static_cast<std::size_t>(column_order_[k])];
    for (int i = upper_.begin[k]; i < upper_.begin[k + 1]; ++i)
      value -= upper_.value[static_cast<std::size_t>(i)] *
               work[static_cast<std::size_t>(upper_.row[static_cast<std::size_t>(i)])];
    work[k] = value * inverse_pivot_[k];
  }
  for (std::size_t k = n; k-- > 0;) {
    double value = work[k];
    for (int i = lower_.begin[k]; i < lower_.begin[k + 1]; ++i)
      value -= lower_.value[static_cast<std::size_t>(i)] *
               work[static_cast<std::size_t>(lower_.row[static_cast<std::size_t>(i)])];
    work[k] = value;
  }
  for (std::size_t i = 0; i < n; ++i) x[i] = work[static_cast<std::size_t>(row_position_[i])];
}

}  // namespace skerry::statics
