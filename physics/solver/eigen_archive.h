// SPDX-License-Identifier: MIT
//
// Eigen's matrices in archives.
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

#include "physics/archive.h"

namespace skerry {

/// Rows, columns and the entries column by column.
template <class Matrix>
void archive_dense(Archive& a, Matrix& matrix) {
  auto rows = static_cast<std::int64_t>(matrix.rows()), columns = static_cast<std::int64_t>(matrix.cols());
  std::vector<double> entries(matrix.data(), matrix.data() + matrix.size());
  a(rows, columns, entries);
  if (!a.reading()) return;
  if (rows < 0 || columns < 0 || rows > (1 << 24) || columns > (1 << 24) ||
      static_cast<std::size_t>(rows * columns) != entries.size()) {
    a.refuse("a matrix whose entries do not fit its size");
  }
  matrix.resize(rows, columns);
  std::copy(entries.begin(), entries.end(), matrix.data());
}

/// Compressed columns. The pattern is kept, zeros included.
inline void archive_sparse(Archive& a, Eigen::SparseMatrix<double>& matrix) {
  matrix.makeCompressed();
  auto rows = static_cast<std::int64_t>(matrix.rows()), columns = static_cast<std::int64_t>(matrix.cols());
  std::vector<int> starts(matrix.outerIndexPtr(), matrix.outerIndexPtr() + matrix.outerSize() + 1);
  std::vector<int> places(matrix.innerIndexPtr(), matrix.innerIndexPtr() + matrix.nonZeros());
  std::vector<double> entries(matrix.valuePtr(), matrix.valuePtr() + matrix.nonZeros());
  a(rows, columns, starts, places, entries);
  if (!a.reading()) return;
  bool sound = rows >= 0 && columns >= 0 && rows < (1 << 28) && places.size() == entries.size() &&
               static_cast<std::int64_t>(starts.size()) == columns + 1 && starts.front() == 0 &&
               starts.back() == static_cast<int>(places.size());
  for (std::size_t i = 1; sound && i < starts.size(); ++i) sound = starts[i - 1] <= starts[i];
  for (std::size_t i = 0; sound && i < places.size(); ++i) sound = places[i] >= 0 && places[i] < rows;
  if (!sound) a.refuse("a sparse matrix whose entries do not fit its size");
  matrix = Eigen::Map<const Eigen::SparseMatrix<double>>(rows, columns, static_cast<int>(places.size()),
                                                         starts.data(), places.data(), entries.data());
}

}  // namespace skerry
