// SPDX-License-Identifier: MIT
#include "physics/statics/null_space.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <Eigen/SparseQR>
#include <cmath>

namespace skerry::statics {

NullSpace null_space(int rows, int columns, const std::vector<Entry>& entries, double tolerance) {
  NullSpace result;
  if (columns == 0) return result;
  // Eigen's factorisation wants at least as many rows as columns; rows of zeros change nothing.
  const int tall = std::max(rows, columns);
  std::vector<Eigen::Triplet<double, int>> triplets;
  triplets.reserve(entries.size());
  for (const Entry& entry : entries) triplets.emplace_back(entry.row, entry.column, entry.value);
  Eigen::SparseMatrix<double, Eigen::ColMajor, int> matrix(tall, columns);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  matrix.makeCompressed();

  Eigen::SparseQR<Eigen::SparseMatrix<double, Eigen::ColMajor, int>, Eigen::COLAMDOrdering<int>> qr;
  qr.setPivotThreshold(tolerance);
  qr.compute(matrix);
  result.rank = static_cast<int>(qr.rank());
  const int free = columns - result.rank;
  if (free == 0) return result;

  // A P [z1; z2] = 0  <=>  R11 z1 = -R12 z2
  const Eigen::SparseMatrix<double, Eigen::ColMajor, int> r = qr.matrixR();
  const Eigen::SparseMatrix<double, Eigen::ColMajor, int> r11 = r.topLeftCorner(result.rank, result.rank);
  for (int k = 0; k < free; ++k) {
    Eigen::VectorXd z = Eigen::VectorXd::Zero(columns);
    z(result.rank + k) = 1;
    if (result.rank > 0) {
      Eigen::VectorXd top = -Eigen::VectorXd(r.col(result.rank + k)).head(result.rank);
      r11.triangularView<Eigen::Upper>().solveInPlace(top);
      z.head(result.rank) = top;
    }
    z = qr.colsPermutation() * z;
    z /= z.cwiseAbs().maxCoeff();
    result.basis.emplace_back(z.data(), z.data() + columns);
  }
  return result;
}

}  // namespace skerry::statics
