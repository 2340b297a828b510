// SPDX-License-Identifier: MIT
#include "physics/stepping/applied_forces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "physics/text.h"
#include "physics/world_report.h"
#include "physics/world_state.h"

namespace skerry {

bool has_varying_forces(const WorldState& state, const Island& island) {
  return state.field || std::any_of(island.bodies.begin(), island.bodies.end(),
                                    [&](std::uint32_t i) { return state.drag[i].any(); });
}

namespace {

/// Whether a contact or joint of the island has a body for which `test` holds. Within a step.
template <class Test>
bool meets(const Island& island, const WorldState& state, const Test& test) {
  return std::any_of(
             island.contacts.begin(), island.contacts.end(),
             [&](std::uint32_t i) { return test(state.links[i].body_a) || test(state.links[i].body_b); }) ||
         std::any_of(island.joints.begin(), island.joints.end(), [&](std::uint32_t i) {
           return test(state.joints[i].def.a.index) || test(state.joints[i].def.b.index);
         });
}

}  // namespace

bool meets_prescribed_motion(const WorldState& state, const Island& island) {
  return !state.kinematic.empty() && meets(island, state, [&](std::uint32_t body) {
    return body != BodyId::kNone && state.prescribed[body] && state.paths[body].moves();
  });
}

bool moves_as_told(const WorldState& state, std::uint32_t body) {
  const BodyArrays& all = state.bodies;
  if (body == BodyId::kNone || all.type[body] != BodyType::Kinematic) return false;
  if (state.prescribed[body]) return state.paths[body].moves();
  return all.velocity[body] != Vec2{} || all.omega[body] != 0;
}

bool meets_motion(const WorldState& state, const Island& island) {
  return !state.kinematic.empty() &&
         meets(island, state, [&](std::uint32_t body) { return moves_as_told(state, body); });
}

namespace {

// Velocities beyond this [m/s, rad/s] are no answers: products of such numbers still fit a double.
constexpr double kFastest = 1e100;
// Nothing is left of a velocity after this many times in which drag takes most of it.
constexpr double kSteepest = 1e12;

/// Drag over the velocity that it acts against.
struct Resistance {
  double linear;   ///< [N s/m]
  double angular;  ///< [N m s]
};

Resistance resistance(const Drag& drag, const JointEnd& motion) {
  return {drag.linear + drag.quadratic * length(motion.v),
          drag.angular + drag.angular_quadratic * std::abs(motion.omega)};
}

Wrench field_force(const WorldState& state, std::uint32_t body, const JointEnd& motion, double elapsed) {
  const BodyArrays& all = state.bodies;
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
  return wrench;
}

/// Without drag.
std::array<double, 3> driving_acceleration(const WorldState& state, std::uint32_t body,
                                           const JointEnd& motion, double elapsed, Vec2 force,
                                           double torque) {
  const BodyArrays& all = state.bodies;
  if (state.field) {
    const Wrench wrench = field_force(state, body, motion, elapsed);
    force += wrench.force;
    torque += wrench.torque;
  }
  const Vec2 a = all.gravity_scale[body] * state.config.gravity + all.inverse_mass[body] * force;
  return {a.x, a.y, all.inverse_inertia[body] * torque};
}

/// Share theta of the velocity at the end in what a resistance acts against, such that
///
///   v1 = v0 + h (a - k (theta v1 + (1 - theta) v0))
///
/// is exact for constant a and k [exponential fitting: Liniger & Willoughby 1970], with
/// exp(-r) ~ 1 / (1 + r + r^2/2 + r^3/6 + r^4/24), which gives the same bits everywhere. @param r  k h
double share_of_end(double r) {
  const double q = 1 + r * (1.0 / 2 + r * (1.0 / 6 + r / 24));
  return 1 - (1.0 / 2 + r * (1.0 / 6 + r / 24)) / q;
}

}  // namespace

std::array<double, 3> applied_acceleration(const WorldState& state, std::uint32_t body,
                                           const JointEnd& motion, double elapsed) {
  Vec2 force = state.bodies.force[body];
  double torque = state.bodies.torque[body];
  const Drag& drag = state.drag[body];
  if (drag.any()) {
    const Resistance against = resistance(drag, motion);
    force -= against.linear * motion.v;
    torque -= against.angular * motion.omega;
  }
  return driving_acceleration(state, body, motion, elapsed, force, torque);
}

DampedMotion damped_motion(const WorldState& state, std::uint32_t body, const JointEnd& motion,
                           double elapsed, const std::array<double, 3>& velocity_before, double h) {
  const BodyArrays& all = state.bodies;
  DampedMotion out;
  out.acceleration = driving_acceleration(state, body, motion, elapsed, all.force[body], all.torque[body]);
  const Drag& drag = state.drag[body];
  if (!drag.any()) return out;
  const Resistance against = resistance(drag, motion);
  // Of M (v1 - v0) = h (F - K (theta v1 + (1 - theta) v0)) + J' lambda what has v1 goes to the left.
  const auto damp = [h](double rate, double& factor) {
    const double r = std::min(kSteepest, h * rate);
    factor = 1 / (1 + share_of_end(r) * r);
    return r;
  };
  const double r[2] = {damp(all.inverse_mass[body] * against.linear, out.linear),
                       damp(all.inverse_inertia[body] * against.angular, out.angular)};
  for (std::size_t c = 0; c < 3; ++c) {
    double& a = out.acceleration[c];
    a = (a - r[c / 2] / h * velocity_before[c]) * (c < 2 ? out.linear : out.angular);
  }
  return out;
}

namespace {

/// Where forces are taken in a time in which the velocity changes evenly: in its middle.
DampedMotion damped_between(const WorldState& state, std::uint32_t body, const Velocity& before,
                            const Velocity& after, double elapsed, double h) {
  std::array<double, 3> mid{}, path{};
  for (std::size_t c = 0; c < 3; ++c) {
    mid[c] = 0.5 * (before[c] + after[c]);
    path[c] = 0.25 * h * (before[c] + mid[c]);
  }
  const double angle = state.bodies.angle[body] + path[2];
  const JointEnd middle{state.bodies.position[body] + Vec2{path[0], path[1]},
                        Rot::from_angle(angle),
                        angle,
                        {mid[0], mid[1]},
                        mid[2]};
  return damped_motion(state, body, middle, elapsed + 0.5 * h, before, h);
}

bool is_lost(const Velocity& v) {
  return !(std::abs(v[0]) < kFastest && std::abs(v[1]) < kFastest && std::abs(v[2]) < kFastest);
}

}  // namespace

void take_forces(WorldState& state, const Island& island, double elapsed, double h,
                 const std::vector<Velocity>& before, const std::vector<Velocity>& after,
                 std::vector<InverseMass>& damping) {
  damping.resize(before.size());
  for (std::size_t k = 0; k < after.size(); ++k) {
    const std::uint32_t body = island.bodies[k];
    const DampedMotion damped = damped_between(state, body, before[k], after[k], elapsed, h);
    damping[k] = {damped.linear, damped.angular};
    state.acceleration[body] = {damped.acceleration[0], damped.acceleration[1]};
    state.angular_acceleration[body] = damped.acceleration[2];
  }
}

bool field_swings_fast(const WorldState& state, const Island& island, double elapsed, double h,
                       const std::vector<Velocity>& before, const std::vector<Velocity>& after) {
  constexpr double kFast = 0.7;
  if (!state.field) return false;
  const BodyArrays& all = state.bodies;
  for (std::size_t k = 0; k < after.size(); ++k) {
    const std::uint32_t body = island.bodies[k];
    const JointEnd now{
        all.position[body], all.rotation[body], all.angle[body], {before[k][0], before[k][1]}, before[k][2]};
    const std::array<double, 3> first = applied_acceleration(state, body, now, elapsed);
    const Vec2 change = state.acceleration[body] - Vec2{first[0], first[1]};
    const Vec2 way = 0.25 * h * Vec2{before[k][0] + after[k][0], before[k][1] + after[k][1]};
    const double turn = 0.25 * h * (before[k][2] + after[k][2]);
    const double more = state.angular_acceleration[body] - first[2];
    if (h * h * length(change) > kFast * kFast * length(way) ||
        h * h * std::abs(more) > kFast * kFast * std::abs(turn))
      return true;
  }
  return false;
}

double stable_length_of_drag(const WorldState& state, const Island& island, double elapsed, double left) {
  constexpr double kLittleWay = 0.02, kNearTheLast = 0.1, kShare = 0.5;
  const BodyArrays& all = state.bodies;
  double least = kInfinity;
  const auto is_steep = [left](double rate) { return rate * left > kShare && rate * left < kSteepest; };
  for (const std::uint32_t body : island.bodies) {
    const Drag& drag = state.drag[body];
    if (!drag.any()) continue;
    const JointEnd now{all.position[body], all.rotation[body], all.angle[body], all.velocity[body],
                       all.omega[body]};
    const Resistance against = resistance(drag, now);
    const double rate = all.inverse_mass[body] * against.linear;
    const double turning_rate = all.inverse_inertia[body] * against.angular;
    const bool far = is_steep(rate) && left * length(now.v) > kLittleWay * state.radius[body];
    const bool turns_far = is_steep(turning_rate) && left * std::abs(now.omega) > kLittleWay;
    if (!far && !turns_far) continue;
    const std::array<double, 3> a =
        driving_acceleration(state, body, now, elapsed, all.force[body], all.torque[body]);
    // At its last speed nothing changes it.
    if (far && length(now.v - Vec2{a[0], a[1]} / rate) > kNearTheLast * length(now.v))
      least = std::min(least, kShare / rate);
    if (turns_far && std::abs(now.omega - a[2] / turning_rate) > kNearTheLast * std::abs(now.omega))
      least = std::min(least, kShare / turning_rate);
  }
  return least;
}

void damp(IslandSystem& system, const std::vector<InverseMass>& damping) {
  for (std::size_t k = 0; k < system.bodies.size(); ++k) {
    system.bodies[k].linear *= damping[k].linear;
    system.bodies[k].angular *= damping[k].angular;
  }
}

bool take_forces_of_flight(WorldState& state, std::uint32_t body, double elapsed, double h) {
  const BodyArrays& all = state.bodies;
  const Velocity before{all.velocity[body].x, all.velocity[body].y, all.omega[body]};
  Velocity after = before;
  for (int pass = 0; pass < 2; ++pass) {
    const std::array<double, 3> a = damped_between(state, body, before, after, elapsed, h).acceleration;
    for (std::size_t c = 0; c < 3; ++c) after[c] = before[c] + h * a[c];
    if (is_lost(after)) return false;
    state.acceleration[body] = {a[0], a[1]};
    state.angular_acceleration[body] = a[2];
  }
  return true;
}

VaryingForces varying_forces(const WorldState& state, std::uint32_t body) {
  const BodyArrays& all = state.bodies;
  const BodyBackup& before = state.backup[body];
  const double h = state.last_h;
  VaryingForces out;
  JointEnd middle = halfway(state, body);
  middle.v = 0.5 * (before.velocity + all.velocity[body]);
  middle.omega = 0.5 * (before.omega + all.omega[body]);
  if (state.field) out.field = field_force(state, body, middle, -0.5 * h);
  const Drag& drag = state.drag[body];
  if (!drag.any()) return out;
  const Resistance against = resistance(drag, middle);
  const double linear = share_of_end(std::min(kSteepest, h * all.inverse_mass[body] * against.linear));
  const double angular = share_of_end(std::min(kSteepest, h * all.inverse_inertia[body] * against.angular));
  out.drag.force = -against.linear * (linear * all.velocity[body] + (1 - linear) * before.velocity);
  out.drag.torque = -against.angular * (angular * all.omega[body] + (1 - angular) * before.omega);
  return out;
}

void take_drag_of_impulses(WorldState& state, const Island& island, double h,
                           const std::vector<Velocity>& before, const std::vector<Velocity>& after,
                           const std::vector<InverseMass>& damping) {
  for (std::size_t k = 0; k < after.size(); ++k) {
    const std::uint32_t body = island.bodies[k];
    Vec2& a = state.acceleration[body];
    double& alpha = state.angular_acceleration[body];
    // v1 = v0 + h a + damping M^-1 J' lambda; without drag the last product would have no factor.
    const double linear = (1 - 1 / damping[k].linear) / h, angular = (1 - 1 / damping[k].angular) / h;
    a += linear * (Vec2{after[k][0] - before[k][0], after[k][1] - before[k][1]} - h * a);
    alpha += angular * (after[k][2] - before[k][2] - h * alpha);
  }
}

bool are_lost(WorldState& state, const Island& island, const std::vector<Velocity>& after) {
  bool any = false;
  for (std::size_t k = 0; k < after.size(); ++k) {
    if (!is_lost(after[k])) continue;
    state.bodies.velocity[island.bodies[k]] = {kInfinity, kInfinity};
    any = true;
  }
  return any;
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
