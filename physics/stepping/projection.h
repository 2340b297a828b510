// SPDX-License-Identifier: MIT
//
// Drift: brings positions and velocities back onto the constraints after a piece of a step.
#pragma once

#include <vector>

#include "physics/math.h"
#include "physics/stepping/stepper.h"

namespace skerry {

/// Moves the bodies by the smallest mass-weighted displacement after which joints hold, contacts do not
/// penetrate, and contacts that carried load are closed. Velocities are left alone but for a common rotation
/// that keeps the angular momentum of islands that touch nothing fixed. Does nothing (and solves nothing)
/// when all errors are at rounding level already.
/// @param elapsed  since the beginning of the step [s]
void project_positions(WorldState& state, const Island& island, double elapsed, IslandResult& result);

/// Adds angular momentum [kg m^2/s] to an island that touches nothing fixed, as a common rotation, which no
/// contact feels; other islands stay as they are.
void give_spin(WorldState& state, const Island& island, double momentum);

/// Removes the velocity that violates joints, loaded contacts and sticking contacts at the present geometry,
/// by the least-energy change and the friction that belongs to it; kept only where it makes the violation
/// smaller.
void project_velocities(WorldState& state, const Island& island, double elapsed, IslandResult& result);

/// The energy of an island at the beginning of a piece of a step, kept to see whether the piece creates any.
class IslandEnergy {
 public:
  IslandEnergy(const WorldState& state, const Island& island);
  /// Takes what was gained beyond the work of the external forces out of the motion of the bodies against
  /// each other (against the ground, if they touch it), by one factor for all of them. Does nothing where
  /// moving ground may have brought energy.
  void take_gain(WorldState& state, const Island& island) const;

 private:
  struct Place {
    Vec2 position;
    double angle;
  };
  std::vector<Place> start_;
  double kinetic_ = 0;
};

}  // namespace skerry
