// SPDX-License-Identifier: MIT
#include "physics/stepping/applied_forces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "physics/text.h"
#include "physics/world_state.h"

namespace skerry {

bool has_varying_forces(const WorldState& state, const Island& island) {
  return state.field || std::any_of(island.bodies.begin(), island.bodies.end(),
                                    [&](std::uint32_t i) { return state.drag[i].any(); });
}

bool meets_prescribed_motion(const WorldState& state, const Island& island) {
  if (state.kinematic.empty()) return false;
  const auto told = [&](std::uint32_t body) { return body != BodyId::kNone && state.prescribed[body]; };
  return std::any_of(island.contacts.begin(), island.contacts.end(),
                     [&](std::uint32_t i) {
                       return told(state.contacts[i].body_a) || told(state.contacts[i].body_b);
                     }) ||
         std::any_of(island.joints.begin(), island.joints.end(), [&](std::uint32_t i) {
           return told(state.joints[i].def.a.index) || told(state.joints[i].def.b.index);
         });
}

std::array<double, 3> applied_acceleration(const WorldState& state, std::uint32_t body,
                                           const JointEnd& motion, double elapsed) {
  const BodyArrays& all = state.bodies;
  Vec2 force = all.force[body];
  double torque = all.torque[body];
  const Drag& drag = state.drag[body];
  if (drag.any()) {
    force -= (drag.linear + drag.quadratic * length(motion.v)) * motion.v;
    torque -= (drag.angular + drag.angular_quadratic * std::abs(motion.omega)) * motion.omega;
  }
  if (state.field) {
    FieldSample sample;
    sample.body = {body, all.generation[body]};
    sample.position = motion.p;
    sample.angle = motion.angle;
    sample.velocity = motion.v;
    sample.omega = motion.omega;
    sample.mass = all.mass[body];
    sample.inertia = all.inertia[body];
    sample.time = state.time + elapsed;
    const Wrench wrench = state.field(sample);
    if (!is_finite(wrench.force) || !std::isfinite(wrench.torque)) {
      throw std::invalid_argument("force field: not finite for body " + std::to_string(body) + " at " +
                                  to_text(motion.p) + ": " + to_text(wrench.force) + ", " +
                                  to_text(wrench.torque));
    }
    force += wrench.force;
    torque += wrench.torque;
  }
  const Vec2 a = all.gravity_scale[body] * state.config.gravity + all.inverse_mass[body] * force;
  return {a.x, a.y, all.inverse_inertia[body] * torque};
}

double largest_acceleration(const WorldState& state, const Island& island) {
  double largest = 0;
  for (const std::uint32_t i : island.bodies) {
    largest = std::max(
        largest, length(state.acceleration[i]) + std::abs(state.angular_acceleration[i]) * state.radius[i]);
  }
  return largest;
}

double rounding_of_balance(const WorldState& state, const Island& island, double force) {
  constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();
  const BodyArrays& b = state.bodies;
  double lightest = 0;
  for (const std::uint32_t i : island.bodies)
    lightest =
        std::max({lightest, b.inverse_mass[i], b.inverse_inertia[i] * state.radius[i] * state.radius[i]});
  return kRounding * force * lightest;
}

}  // namespace skerry
