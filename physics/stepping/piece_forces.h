// SPDX-License-Identifier: MIT
//
// The force problem of one piece of a step of `time_stepping`.
#pragma once

#include <cstdint>
#include <vector>

#include "physics/stepping/island_rows.h"
#include "physics/stepping/stepper.h"

namespace skerry {

/// A part of a step that is made in one go.
struct Piece {
  double elapsed = 0;                        ///< where it begins, since the beginning of the step [s]
  double h = 0;                              ///< its length [s]
  const std::vector<std::uint8_t>& resting;  ///< per contact of the island: bits of the points that take part
  bool plastic = false;                      ///< landings within it are plastic, at its end
  bool may_stop = true;                      ///< the end of sliding is looked for
  bool varying = false;                      ///< forces depend on the state
  bool told = false;                         ///< something here moves as prescribed
  /// Per joint of the island: bits of the limits that take part; what reaches another one ends the piece.
  /// None: all limits hold at its end.
  const std::vector<std::uint8_t>* limits = nullptr;
  bool first = false;  ///< velocities may be other ones than joints allow
};

struct PieceForces {
  bool act = false;        ///< there are contacts or joints in it
  bool moving = false;     ///< the geometry changes within it
  bool given_up = false;   ///< they were not found for what they may cost: nothing is stored
  bool disobeyed = false;  ///< joints do not allow the velocities of a first piece: nothing was done
  double brought = 0;      ///< work of what is told to move, if the forces are an answer [J]
  double stop = 0;         ///< when the first sliding ends in it, or its length [s]
};

/// Solves for the forces of a piece and stores the impulses in its contacts and joints. Forces that depend on
/// the state are those of its middle.
/// @param after  velocities at its end
PieceForces solve_piece(WorldState& state, const Island& island, const Piece& piece,
                        const std::vector<Velocity>& before, std::vector<Velocity>& after,
                        IslandResult& result);

}  // namespace skerry
