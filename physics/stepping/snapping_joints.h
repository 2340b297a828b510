// SPDX-License-Identifier: MIT
//
// Light bodies that hold a heavy one snap straight: within a moment they are many times as fast as it. A
// piece that steps over that has no answer near the bodies, or one without the energy that there was.
#pragma once

#include "physics/stepping/island_backup.h"

namespace skerry {

class IslandEnergy;

/// Whether bodies of an island without contacts hang on far lighter ones.
bool may_snap(const WorldState& state, const Island& island);

/// What there was before a piece, to make it again shorter where it stepped over what is faster than it.
class SnapGuard {
 public:
  /// @param elapsed  since the beginning of the step [s]
  SnapGuard(const WorldState& state, const Island& island, double elapsed);

  /// Whether joints are off that were not, after a piece until `elapsed` [s], or energy came or went that
  /// they do not bring.
  /// @param h  time that the step takes [s]
  /// @param energy  before the piece
  bool snapped(const WorldState& state, const Island& island, double elapsed, double h,
               const IslandEnergy& energy) const;
  void restore(WorldState& state, const Island& island) const { before_.restore(state, island); }

 private:
  IslandBackup before_;
  bool off_;
};

}  // namespace skerry
