// SPDX-License-Identifier: MIT
//
// Forces that depend on the state, and motions that the caller prescribes.
#pragma once

#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "physics/handle.h"
#include "physics/math.h"

namespace skerry {

/// A force at the centre of mass and a torque about it.
struct Wrench {
  Vec2 force;         ///< [N]
  double torque = 0;  ///< [N m]
};

/// What a force field is asked about.
struct FieldSample {
  BodyId body;
  Vec2 position;       ///< of the centre of mass, world frame [m]
  double angle = 0;    ///< [rad]
  Vec2 velocity;       ///< [m/s]
  double omega = 0;    ///< [rad/s]
  double mass = 0;     ///< [kg]
  double inertia = 0;  ///< [kg m^2]
  double time = 0;     ///< [s] of the world
};

/// A field acts on every dynamic body besides gravity. It must depend on nothing but its argument (it is
/// asked several times a step, at states that are tried and thrown away), and be smooth for the steppers'
/// orders to hold: the midpoint rule in time_stepping, Runge-Kutta of order 8 in event_driven. Islands in a
/// field never rest or sleep, since it may be another one at any time.
using ForceField = std::function<Wrench(const FieldSample&)>;

/// Who may call a force field.
enum class FieldThreads : std::uint8_t {
  One,   ///< one thread at a time, in the order of the islands: then one thread makes the step of all of them
  Many,  ///< any number at the same time
};

/// Resistance of a medium: F = -(linear + quadratic |v|) v, torque = -(angular + angular_quadratic |w|) w.
/// In time_stepping it may be as steep as it likes: what is constant over a step slows down by a fourth-order
/// approximation of the exponential. event_driven takes steps of the size of m / linear, or gives up and lets
/// time_stepping make the step.
struct Drag {
  double linear = 0;             ///< [N s/m]
  double quadratic = 0;          ///< [N s^2/m^2]
  double angular = 0;            ///< [N m s]
  double angular_quadratic = 0;  ///< [N m s^2]

  bool any() const { return linear > 0 || quadratic > 0 || angular > 0 || angular_quadratic > 0; }
};

/// Where a kinematic body is.
struct Placement {
  Vec2 position;     ///< of the centre of mass, world frame [m]
  double angle = 0;  ///< [rad]
};

/// Prescribed motion: where a kinematic body is at a time of the world [s]. Asked at ten times of each step;
/// velocity and acceleration are those of the polynomial through eight of them. Kinks and jumps are looked for
/// where the other two tell of them: the step is cut there, and a jump strikes nothing on its way.
using PrescribedMotion = std::function<Placement(double time)>;

/// What a world asks its user while it steps. Snapshots do not hold it.
struct WorldCallbacks {
  ForceField field;
  FieldThreads field_threads{};
  std::vector<std::pair<BodyId, PrescribedMotion>> motions;
};

}  // namespace skerry
