// SPDX-License-Identifier: MIT
//
// Bodies on which nothing but their external forces acts.
#pragma once

#include "physics/narrowphase/time_of_impact.h"
#include "physics/world_state.h"

namespace skerry {

/// Motion of a body from now on. @param elapsed  since the beginning of the step [s], for kinematic bodies
inline Motion free_flight(const WorldState& state, std::uint32_t body, double elapsed) {
  const BodyArrays& all = state.bodies;
  Motion m;
  if (body == BodyId::kNone) return m;
  m.p0 = all.position[body];
  m.angle0 = all.angle[body];
  if (state.local_index[body] >= 0) {
    m.a = state.acceleration[body];
    m.alpha = state.angular_acceleration[body];
  }
  if (state.local_index[body] >= 0) {
    m.v = all.velocity[body];
    m.omega = all.omega[body];
  }
  if (all.type[body] == BodyType::Kinematic) {
    const KinematicState now = kinematic_state(state, body, elapsed);
    m = {now.p, now.angle, now.v, now.omega, now.a, now.alpha};
  }
  return m;
}

/// The same motion with its clock started `t` [s] later.
inline Motion later(const Motion& m, double t) {
  Motion out = m;
  out.p0 = m.p0 + t * (m.v + (0.5 * t) * m.a);
  out.angle0 = m.angle0 + t * (m.omega + 0.5 * t * m.alpha);
  out.v = m.v + t * m.a;
  out.omega = m.omega + t * m.alpha;
  return out;
}

}  // namespace skerry
