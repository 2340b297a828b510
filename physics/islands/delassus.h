// SPDX-License-Identifier: MIT
//
// The contact problem in contact space: the Delassus operator W as a sparse matrix, built from an island or
// given from outside (then there are no bodies). Also the views of W that people look at: the pattern of its
// factor under an ordering, fill and condition. This is the one header that shows Eigen.
#pragma once

#include <Eigen/SparseCore>
#include <cstdint>
#include <string_view>
#include <vector>

#include "physics/islands/island_system.h"

namespace skerry {

/// w = W lambda - b with bounds on lambda, as in island_system.h, but with W itself in place of bodies.
struct ContactProblem {
  Eigen::SparseMatrix<double> W;  ///< n x n; symmetric up to rounding when it comes from an island
  std::vector<double> b;          ///< n
  std::vector<Row> rows;          ///< n; kind, bounds, normal, mu and source count, the rest is not looked at

  int size() const { return static_cast<int>(rows.size()); }
};

/// Returns W = J M^-1 J^T + diag(compliance), n x n, symmetric bit by bit; entries that rows of a common body
/// share are stored even where they are zero, so that the pattern depends on the graph only.
Eigen::SparseMatrix<double> delassus(const IslandSystem& system);

/// Returns the problem of an island in contact space.
ContactProblem contact_problem(const IslandSystem& system);

/// @name The functions of island_system.h on a given W.
/// @{
std::vector<double> row_velocities(const ContactProblem& problem, const std::vector<double>& lambda);
std::vector<double> inverse_effective_masses(const ContactProblem& problem);
double natural_map_residual(const ContactProblem& problem, const std::vector<double>& lambda);
double residual_floor(const ContactProblem& problem, const std::vector<double>& lambda);
/// @throws std::invalid_argument with the row's number and the value.
void validate(const ContactProblem& problem);
/// @}

enum class Ordering : std::uint8_t {
  Natural,             ///< the rows as they stand
  ApproximateMinimum,  ///< approximate minimum degree [Amestoy, Davis, Duff 1996]
};
std::string_view to_string(Ordering ordering);

/// The factor of W + 1e-10 diag(W) = P^T L D L^T P as a picture: where its entries are.
struct FactorPattern {
  std::vector<int> order;        ///< n; order[k] is the row eliminated as number k
  std::vector<int> row, column;  ///< nonzeros of L below the diagonal, in eliminated numbering, by column
  double fill = 1;               ///< (nonzeros of L with diagonal) / (those of the lower triangle of W)
  double condition = 1;          ///< estimate in the 1-norm of W + 1e-10 diag(W) [Hager 1984]
};

/// Factors W with the given ordering and returns where L is not zero.
FactorPattern factor_pattern(const IslandSystem& system, Ordering ordering);
FactorPattern factor_pattern(const Eigen::SparseMatrix<double>& W, Ordering ordering);

}  // namespace skerry
