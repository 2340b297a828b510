// SPDX-License-Identifier: MIT
//
// What a step in one piece leaves in its contacts: impulses for the report and for the next step, and which
// points landed.
#pragma once

#include <vector>

#include "physics/stepping/island_rows.h"

namespace skerry {

/// The answer to the rows of a piece.
struct PieceAnswer {
  const Assembly& assembly;
  const std::vector<double>& lambda;    ///< [N s]
  const std::vector<Velocity>& before;  ///< where the piece begins
  double from, h;                       ///< where that is in the step, and its length [s]
  double slow;                          ///< what approaches no faster does not land [m/s]
  bool exact;                           ///< else what carried load before does not land, either
};

/// Rows among some contacts.
struct StoredRows {
  int landings = 0;  ///< points that were struck
  int friction = 0;
};

/// For the contacts of an island from one place in its list to another. Their rows stand in the same order.
StoredRows store_contacts(WorldState& state, const Island& island, const PieceAnswer& answer,
                          std::size_t from, std::size_t to);

}  // namespace skerry
