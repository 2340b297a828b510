// SPDX-License-Identifier: MIT
//
// W = J M^-1 J' of an island as a grid of cells for pictures.
#pragma once

#include <vector>

#include "physics/islands/island_system.h"

namespace skerry::sandbox {

/// A square picture of W. One cell is one entry, or, when W is larger than the picture may be, the entry of
/// largest magnitude in a block.
struct CellGrid {
  int size = 0;                ///< cells on a side
  int nonzeros = 0;            ///< structural nonzeros of W itself
  double largest = 0;          ///< largest magnitude [1/kg]
  std::vector<double> values;  ///< row by row

  double at(int row, int column) const {
    return values[static_cast<std::size_t>(row) * static_cast<std::size_t>(size) +
                  static_cast<std::size_t>(column)];
  }
};

/// Computes W in O(sum over bodies of (rows at the body)^2) and places it on at most `most` x `most` cells.
CellGrid delassus_cells(const IslandSystem& system, int most);

}  // namespace skerry::sandbox
