// SPDX-License-Identifier: MIT
//
// Forces between bodies that do not touch: gravity, charges, springs without ends.
//
//   skerry::PairForces gravity({.strength = 6.674e-11});   // of all dynamic bodies, by their masses
//   for (;;) {
//     gravity.apply(world, h);
//     world.step(h);
//   }
#pragma once

#include <utility>
#include <vector>

#include "physics/handle.h"
#include "physics/math.h"

namespace skerry {

class World;

/// A force along the line between the centres of mass of two bodies [N]:
/// strength * weight of one * weight of the other * distance^-power.
struct PairLaw {
  double strength = 0;   ///< above 0 they attract each other, below they repel [N m^power / weight^2]
  double power = 2;      ///< 2: gravity, charges; 1: charged lines; -1: springs that are nought long
  double softening = 0;  ///< the force is distance * root^-(power + 1) with root^2 = distance^2 +
                         ///< softening^2, bounded where bodies meet [Plummer 1911] [m]
};

/// The forces of one law between all pairs of some bodies.
///
/// They act over a step as they are in the middle of it, where the bodies get to with the velocities of its
/// beginning: for what moves freely the leapfrog of drift, kick, drift [Verlet 1967; Hairer, Lubich & Wanner
/// 2003, section 1.4], of second order, which keeps momentum and angular momentum to rounding and whose error
/// of energy does not grow. Steps have to be short against the time in which two bodies pass each other;
/// `WorldConfig::accuracy` does not know what they leave. The work is that of all pairs. Bodies on which they
/// act never rest or sleep.
class PairForces {
 public:
  /// Between all dynamic bodies of a world, with their masses as weights, until some are named.
  /// @throws std::invalid_argument for numbers that are not finite, and a softening below 0
  explicit PairForces(const PairLaw& law);

  const PairLaw& law() const { return law_; }
  /// @throws std::invalid_argument as the constructor; nothing is changed then
  void set_law(const PairLaw& law);
  /// Names a body, of any type (what is not dynamic acts and is not moved), or gives it another weight:
  /// a charge, or a mass [any unit, below 0 too]. From the first one on the forces are among those named.
  /// @throws std::invalid_argument if the weight is not finite
  void set_weight(BodyId body, double weight);
  /// Adds the forces for the next step, of length `h` [s]. Bodies that are no more are left out, and pairs at
  /// one place, of which no direction is known.
  /// @throws std::invalid_argument if `h` is negative or not finite, and, with the bodies, for a force that
  /// is not finite; nothing is changed then
  void apply(World& world, double h) const;
  /// Where the bodies are now, 0 at an infinite distance (power above 1), at a distance of 1 m (power 1), or
  /// at none (below 1) [J].
  double potential_energy(const World& world) const;

 private:
  PairLaw law_;
  std::vector<std::pair<BodyId, double>> named_;  ///< by slot
  bool by_mass_ = true;
};

}  // namespace skerry
