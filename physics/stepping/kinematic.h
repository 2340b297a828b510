// SPDX-License-Identifier: MIT
//
// Where kinematic bodies are within a step: on a straight way with their velocity, or on the polynomial of
// their prescribed motion.
#pragma once

#include <array>

#include "physics/forces.h"
#include "physics/math.h"
#include "physics/stepping/path.h"

namespace skerry {

/// Position, velocity and acceleration at one moment.
struct KinematicState {
  Vec2 p;            ///< [m]
  double angle = 0;  ///< [rad]
  Vec2 v;            ///< [m/s]
  double omega = 0;  ///< [rad/s]
  Vec2 a;            ///< [m/s^2]
  double alpha = 0;  ///< [rad/s^2]
};

/// A prescribed motion within one step: the polynomial of degree 7 through its places at the eight
/// Chebyshev-Lobatto points, whose error is about 2 (h w / 4)^8 / 8! of the amplitude at the frequency w
/// [Hairer, Norsett & Wanner 1993, sec. II.6 on interpolation]. As plain data it can be asked by many
/// threads.
class MotionPath {
 public:
  /// Asks `motion` at eight times of the step. @throws std::invalid_argument if it is not finite there
  void sample(const PrescribedMotion& motion, double time, double h);
  /// @param t  since the beginning of the step [s]
  KinematicState at(double t) const;
  /// The same polynomial as that of a path, without its body.
  PathPiece piece() const;
  /// The place that the motion gave for the end of the step, to the bit.
  Placement end() const { return end_; }
  /// About the farthest that the centre goes from where it begins [m], and the largest turn [rad].
  double extent() const { return extent_; }
  double turn() const { return turn_; }

 private:
  static constexpr int kNodes = 8;
  double h_ = 1;
  std::array<std::array<double, kNodes>, 3> divided_{};  ///< Newton's differences of x, y, angle
  Placement end_;
  double extent_ = 0, turn_ = 0;
};

struct Island;
struct WorldState;

/// The motion of a kinematic (or fixed) body, `elapsed` after the beginning of the step [s].
KinematicState kinematic_state(const WorldState& state, std::uint32_t body, double elapsed);
/// How much of a time `left` [s] from `elapsed` on what an island may meet, and moves as prescribed, stays
/// where its velocity and acceleration foretell it, as landings are looked for along such parabolas: the
/// whole, or a half, a quarter ... of it.
double foreseeable_length(const WorldState& state, const Island& island, double elapsed, double left);
/// The whole step `h` [s] of a kinematic body that is at its end.
PathPiece kinematic_path(const WorldState& state, std::uint32_t body, double h);

}  // namespace skerry
