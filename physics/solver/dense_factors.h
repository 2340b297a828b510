// SPDX-License-Identifier: MIT
//
// Eigen's dense factors, compiled once for the files that use them.
#pragma once

#include <Eigen/LU>
#include <Eigen/QR>

extern template class Eigen::PartialPivLU<Eigen::MatrixXd>;
extern template class Eigen::FullPivLU<Eigen::MatrixXd>;
extern template class Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>;

namespace skerry {

/// x of A x = b, or the x that the factor takes for it; without the solver being compiled where this is
/// called.
Eigen::VectorXd solution_of(const Eigen::PartialPivLU<Eigen::MatrixXd>& factor, const Eigen::VectorXd& b);
Eigen::VectorXd solution_of(const Eigen::FullPivLU<Eigen::MatrixXd>& factor, const Eigen::VectorXd& b);
Eigen::VectorXd solution_of(const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>& factor,
                            const Eigen::VectorXd& b);
Eigen::MatrixXd solution_of(const Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd>& factor,
                            const Eigen::MatrixXd& B);

/// b - A x.
Eigen::VectorXd residual(const Eigen::MatrixXd& A, const Eigen::VectorXd& x, const Eigen::VectorXd& b);

}  // namespace skerry
