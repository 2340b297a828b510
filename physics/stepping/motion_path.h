// SPDX-License-Identifier: MIT
//
// A prescribed motion within one step, as polynomials of time.
#pragma once

#include <array>
#include <vector>

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
/// [Hairer, Norsett & Wanner 1993, sec. II.6 on interpolation]. Where its velocity changes at once (a kink),
/// or it is elsewhere (a jump), it has a break, and a polynomial on either side of it. As plain data it can
/// be asked by many threads.
class MotionPath {
 public:
  /// Asks `motion` at ten times of the step, and up to some thousand where it has breaks.
  /// @param before  where the body was at the end of the last step
  /// @throws std::invalid_argument if it is not finite there
  void sample(const PrescribedMotion& motion, double time, double h, const Placement& before);
  /// @param t  since the beginning of the step [s]; at a break what is after it, and after the end where a
  ///           jump there leads
  KinematicState at(double t) const;
  /// The same polynomials as those of paths, in the order of time.
  void append_to(std::vector<PathPiece>& pieces, std::uint32_t body, std::uint32_t generation) const;
  /// The place that the motion gave for the end of the step, to the bit.
  Placement end() const { return end_; }
  /// The length of the step [s].
  double length() const { return h_; }
  /// Where it has breaks, ascending, since the beginning of the step [s].
  const std::vector<double>& breaks() const { return breaks_; }
  /// Whether it jumps where the step begins or ends, which are no breaks of the step.
  bool begins_with_jump() const { return jump_before_; }
  bool ends_with_jump() const { return jump_after_; }
  /// Whether it goes anywhere in the step.
  bool moves() const { return extent_ != 0 || turn_ != 0 || !breaks_.empty() || jump_before_ || jump_after_; }
  /// About the farthest that the centre goes from where it begins [m], and the largest turn [rad].
  double extent() const { return extent_; }
  double turn() const { return turn_; }

 private:
  static constexpr int kNodes = 8;
  class Sampler;
  /// The polynomial of a time between breaks.
  struct Part {
    double from = 0, length = 0;                          ///< of its nodes [s]
    std::array<std::array<double, kNodes>, 3> divided{};  ///< Newton's differences of x, y, angle
    KinematicState state(double t) const;
  };
  void cut(Sampler& sampler, const Placement& first);
  void sharpen_breaks();

  double h_ = 1;
  std::vector<Part> parts_;     ///< one more than breaks
  std::vector<double> breaks_;  ///< [s]
  Placement end_;
  double extent_ = 0, turn_ = 0;
  bool jump_before_ = false, jump_after_ = false;
};

}  // namespace skerry
