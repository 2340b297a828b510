// SPDX-License-Identifier: MIT
//
// Rank and null space of a sparse matrix: self-stress states and mechanisms are null vectors of the
// equilibrium matrix and of its transpose.
#pragma once

#include <vector>

#include "physics/statics/sparse_lu.h"

namespace skerry::statics {

struct NullSpace {
  int rank = 0;
  std::vector<std::vector<double>> basis;  ///< columns - rank vectors, each with largest magnitude 1
};

/// Rank-revealing sparse QR, A P = Q R [Davis 2011]; a null vector for each dependent column.
///
/// @param entries  of the rows x columns matrix; repeated ones are summed
/// @param tolerance  columns that are dependent on others up to this count as such; units of the entries
NullSpace null_space(int rows, int columns, const std::vector<Entry>& entries, double tolerance);

}  // namespace skerry::statics
