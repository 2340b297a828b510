// SPDX-License-Identifier: MIT
//
// State of the bodies of a world, and what the user does to it: poses, velocities, forces, prescribed motion.
#include <algorithm>
#include <cmath>

#include "physics/text.h"
#include "physics/world_access.h"

namespace skerry {

Vec2 World::position(BodyId id) const {
  return state_->bodies.position[slot(*state_, id)];
}
double World::angle(BodyId id) const {
  return state_->bodies.angle[slot(*state_, id)];
}
Vec2 World::velocity(BodyId id) const {
  return state_->bodies.velocity[slot(*state_, id)];
}
double World::omega(BodyId id) const {
  return state_->bodies.omega[slot(*state_, id)];
}
double World::mass(BodyId id) const {
  return state_->bodies.mass[slot(*state_, id)];
}
double World::inertia(BodyId id) const {
  return state_->bodies.inertia[slot(*state_, id)];
}
Transform World::pose(BodyId id) const {
  return state_->bodies.pose(slot(*state_, id));
}
std::string_view World::name(BodyId id) const {
  return state_->names[slot(*state_, id)];
}

Vec2 World::velocity_at(BodyId id, Vec2 point_world) const {
  const std::uint32_t i = slot(*state_, id);
  const BodyArrays& b = state_->bodies;
  return b.velocity[i] + b.omega[i] * perp(point_world - b.position[i]);
}

void World::set_pose(BodyId id, Vec2 position, double angle) {
  const std::uint32_t i = slot(*state_, id);
  require_finite(position, "position");
  require_finite(angle, "angle");
  state_->bodies.position[i] = position;
  state_->bodies.angle[i] = angle;
  state_->bodies.rotation[i] = Rot::from_angle(angle);
  make_loose(*state_, i);
  displace(*state_, i);
}

void World::set_velocity(BodyId id, Vec2 velocity, double omega) {
  const std::uint32_t i = slot(*state_, id);
  require_finite(velocity, "velocity");
  require_finite(omega, "omega");
  if (state_->bodies.type[i] == BodyType::Static)
    refuse("set_velocity: " + body_label(*state_, i) + " is static and cannot have a velocity");
  if (state_->bodies.velocity[i] == velocity && state_->bodies.omega[i] == omega) return;
  touch(*state_, i);
  state_->bodies.velocity[i] = velocity;
  state_->bodies.omega[i] = omega;
}

void World::apply_force(BodyId id, Vec2 force, Vec2 point_world) {
  const std::uint32_t i = slot(*state_, id);
  require_finite(force, "force");
  require_finite(point_world, "point");
  touch(*state_, i);
  state_->bodies.force[i] += force;
  state_->bodies.torque[i] += cross(point_world - state_->bodies.position[i], force);
}

void World::apply_torque(BodyId id, double torque) {
  const std::uint32_t i = slot(*state_, id);
  require_finite(torque, "torque");
  touch(*state_, i);
  state_->bodies.torque[i] += torque;
}

void World::apply_impulse(BodyId id, Vec2 impulse, Vec2 point_world) {
  const std::uint32_t i = slot(*state_, id);
  require_finite(impulse, "impulse");
  require_finite(point_world, "point");
  BodyArrays& b = state_->bodies;
  const Vec2 v = b.velocity[i] + b.inverse_mass[i] * impulse;
  double omega = b.omega[i];
  if (b.inverse_inertia[i] > 0) omega += b.inverse_inertia[i] * cross(point_world - b.position[i], impulse);
  require_finite(v, "velocity that the impulse gives");
  require_finite(omega, "omega that the impulse gives");
  touch(*state_, i);
  b.velocity[i] = v;
  b.omega[i] = omega;
}

void World::set_force_field(ForceField field, FieldThreads threads) {
  state_->field = std::move(field);
  state_->field_threads = threads;
  state_->sleepers.wake_all(*state_);
}

void World::set_drag(BodyId id, const Drag& drag) {
  const std::uint32_t i = slot(*state_, id);
  require_at_least_zero(drag.linear, "linear drag");
  require_at_least_zero(drag.quadratic, "quadratic drag");
  require_at_least_zero(drag.angular, "angular drag");
  require_at_least_zero(drag.angular_quadratic, "angular_quadratic drag");
  if (state_->bodies.type[i] != BodyType::Dynamic)
    refuse("set_drag: only dynamic bodies feel it, " + body_label(*state_, i) + " is not");
  touch(*state_, i);
  state_->drag[i] = drag;
}

void World::set_gravity_scale(BodyId id, double scale) {
  const std::uint32_t i = slot(*state_, id);
  require_finite(scale, "gravity_scale");
  touch(*state_, i);
  state_->bodies.gravity_scale[i] = scale;
}

void World::set_motion(BodyId id, PrescribedMotion motion) {
  const std::uint32_t i = slot(*state_, id);
  if (state_->bodies.type[i] != BodyType::Kinematic)
    refuse("set_motion: " + body_label(*state_, i) + " must be kinematic");
  if (motion) {
    const Placement now = motion(state_->time);
    require_finite(now.position, "prescribed position");
    require_finite(now.angle, "prescribed angle");
    set_pose(id, now.position, now.angle);
  }
  state_->prescribed[i] = std::move(motion);
  // Without a motion, too: what stands still from now on is begun once more as what it is.
  touch(*state_, i);
}

bool World::has_motion(BodyId id) const {
  return bool{state_->prescribed[slot(*state_, id)]};
}

WorldCallbacks World::callbacks() const {
  const WorldState& s = *state_;
  WorldCallbacks result{s.field, s.field_threads, {}};
  for (const std::uint32_t i : s.kinematic)
    if (s.prescribed[i]) result.motions.emplace_back(body_id(i), s.prescribed[i]);
  return result;
}

void World::adopt(const WorldCallbacks& callbacks) {
  WorldState& s = *state_;
  s.field = callbacks.field;
  s.field_threads = callbacks.field_threads;
  s.sleepers.wake_all(s);
  for (const std::uint32_t i : s.kinematic) {
    if (!s.prescribed[i]) continue;
    s.prescribed[i] = nullptr;
    touch(s, i);
  }
  for (const auto& [body, motion] : callbacks.motions) {
    if (!alive(body) || s.bodies.type[body.index] != BodyType::Kinematic) continue;
    s.prescribed[body.index] = motion;
    touch(s, body.index);
  }
}

bool World::asleep(BodyId id) const {
  return state_->bodies.asleep[slot(*state_, id)] != 0;
}

void World::wake(BodyId id) {
  touch(*state_, slot(*state_, id));
}

BodyId World::body_id(std::size_t i) const {
  require(i < state_->bodies.size() && state_->bodies.alive[i], "no body in slot ", i);
  return {static_cast<std::uint32_t>(i), state_->bodies.generation[i]};
}

}  // namespace skerry
