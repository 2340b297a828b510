// SPDX-License-Identifier: MIT
#include "physics/solver/dense_factors.h"

template class Eigen::PartialPivLU<Eigen::MatrixXd>;
template class Eigen::FullPivLU<Eigen::MatrixXd>;
template class Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>;

namespace skerry {

Eigen::VectorXd solution_of(const Eigen::PartialPivLU<Eigen::MatrixXd>& factor, const Eigen::VectorXd& b) {
  return factor.solve(b);
}

Eigen::VectorXd solution_of(const Eigen::FullPivLU<Eigen::MatrixXd>& factor, const Eigen::VectorXd& b) {
  return factor.solve(b);
}

Eigen::VectorXd solution_of(const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>& factor,
                            const Eigen::VectorXd& b) {
  return factor.solve(b);
}

Eigen::MatrixXd solution_of(const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>& factor,
                            const Eigen::MatrixXd& B) {
  return factor.solve(B);
}

Eigen::VectorXd residual(const Eigen::MatrixXd& A, const Eigen::VectorXd& x, const Eigen::VectorXd& b) {
  return b - A * x;
}

}  // namespace skerry
