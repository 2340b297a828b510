// SPDX-License-Identifier: MIT
//
// Continuous collision: the first instant at which two moving shapes touch.
#pragma once

#include "physics/math.h"
#include "physics/shape.h"

namespace skerry {

/// Flight of a body from a start pose: position p0 + v t + a t^2 / 2, angle angle0 + omega t + alpha t^2 / 2.
struct Motion {
  Vec2 p0{};          ///< origin of the body's frame at t = 0 [m]
  double angle0 = 0;  ///< [rad]
  Vec2 v{};           ///< [m/s]
  double omega = 0;   ///< [rad/s]
  Vec2 a{};           ///< constant acceleration [m/s^2]
  double alpha = 0;   ///< constant angular acceleration [rad/s^2]

  Transform at(double t) const {
    return {p0 + t * (v + (0.5 * t) * a), Rot::from_angle(angle0 + t * (omega + 0.5 * t * alpha))};
  }
};

/// When two shapes meet.
struct ImpactTime {
  bool hit = false;
  double t = 0;        ///< [s]; t_max without a hit
  int iterations = 0;  ///< evaluations of the distance
  bool converged =
      true;  ///< false: the work limit was reached; `t` is safe, the shapes have not met before it
};

/// Finds the first t in [0, t_max] at which the separation of the shapes reaches `target` while they
/// approach.
///
/// Conservative advancement [Mirtich 1996] with a second-order bound: along the direction between the closest
/// features the motion of every corner is bounded below by its velocity and a bound on its acceleration, so
/// each step is safe, and near the impact the steps converge quadratically. Without rotation the bound is
/// exact.
///
/// Starts that already touch (separation <= target within rounding):
/// - they approach (the separation falls at first order, or at second order if the first is zero): a hit at
/// 0;
/// - they part: no hit at 0. The search goes on and finds a later meeting, after they have been farther apart
///   than `target`.
/// Grazing passes whose separation only touches `target` from above without falling below it by more than
/// rounding may be reported either way.
///
/// Half-planes and chains may take part; a half-plane must not rotate while another half-plane meets it. A
/// chain is one-sided: only its left side stops a shape.
///
/// @param t_max   length of the step [s], >= 0
/// @param target  separation that counts as touching [m], may be 0 or negative (a depth below the radius)
/// @throws std::invalid_argument if `t_max` is negative or not finite, or a motion is not finite
ImpactTime time_of_impact(const Shape& a, const Motion& motion_a, const Shape& b, const Motion& motion_b,
                          double t_max, double target = 0);

/// The same against one segment of a chain, one-sided.
ImpactTime time_of_impact_chain_segment(const Shape& chain, int segment, const Motion& motion_chain,
                                        const Shape& other, const Motion& motion_other, double t_max,
                                        double target = 0);

}  // namespace skerry
