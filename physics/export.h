// SPDX-License-Identifier: MIT
//
// Contact problems as text that other programs read: MatrixMarket for the matrices and vectors, JSON for the
// whole island. Numbers are written so that reading them gives the same bits.
#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "physics/islands/delassus.h"

namespace skerry {

/// The matrices and vectors of a contact problem.
enum class MatrixPart : std::uint8_t {
  W,     ///< n x n Delassus operator
  J,     ///< n x 3m Jacobian, columns (vx, vy, omega) of each body
  M,     ///< 3m x 3m mass matrix, diagonal; bodies that do not move have infinite mass and are written as 0
  b,     ///< n wanted changes of relative velocity
  rows,  ///< n x 5: kind (as numbered by RowKind), row that scales the bounds (from 1; 0: none), mu,
         ///< lower and upper bound; infinite ones as plus and minus the largest double
  compliance,  ///< n diagonal terms
  lambda,      ///< n impulses
};
std::string_view to_string(MatrixPart part);

/// Writes one part in the MatrixMarket exchange format [Boisvert, Pozo, Remington 1996]: W as "coordinate
/// real symmetric" (lower triangle), J and M as "coordinate real general", vectors as "array real general".
/// @param lambda  n impulses; looked at for MatrixPart::lambda only
/// @throws std::invalid_argument when lambda does not have n entries, std::runtime_error when writing fails
void write_matrix_market(std::ostream& out, const IslandSystem& system, MatrixPart part,
                         const std::vector<double>& lambda = {});

/// Writes n numbers as one column, "array real general".
/// @throws std::runtime_error when writing fails
void write_matrix_market(std::ostream& out, const std::vector<double>& values);

/// A file of a contact problem.
struct MatrixMarketFile {
  std::string path;
  std::string text;  ///< empty: there is no such part, and a file of that name would be one of another system
};
/// STEM_W.mtx, STEM_J.mtx, STEM_M.mtx, STEM_b.mtx, STEM_rows.mtx, STEM_compliance.mtx and STEM_lambda.mtx.
std::vector<MatrixMarketFile> matrix_market_files(const std::string& stem, const IslandSystem& system,
                                                  const std::vector<double>& lambda = {});

/// Writes `matrix_market_files` one by one, and removes those that have no text.
/// @return the paths written
/// @throws std::runtime_error with the path that cannot be written; no half of that file is left
std::vector<std::string> write_matrix_market_files(const std::string& stem, const IslandSystem& system,
                                                   const std::vector<double>& lambda = {});

/// Writes the island as one JSON object: bodies (inverse masses, positions), rows, b, compliance, lambda.
/// Infinite bounds are the strings "inf" and "-inf".
void write_json(std::ostream& out, const IslandSystem& system, const std::vector<double>& lambda = {});

}  // namespace skerry
