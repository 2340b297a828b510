// SPDX-License-Identifier: MIT
//
// Joints of a world: making and removing them, their reactions, motors and springs.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "physics/joint_rows.h"
#include "physics/stepping/touching.h"
#include "physics/text.h"
#include "physics/world_access.h"

namespace skerry {
namespace {

bool has_length(JointKind kind) {
  return kind == JointKind::Distance || kind == JointKind::Rope || kind == JointKind::Spring;
}

/// @param axis  of any length but zero
Vec2 unit(Vec2 axis) {
  const double size = length(axis);
  // Squares of what is far larger or smaller are no doubles.
  if (size > 1e-140 && size < 1e140) return axis / size;
  axis = axis / std::max(std::abs(axis.x), std::abs(axis.y));
  return axis / length(axis);
}

const char* name_of(JointKind kind) {
  switch (kind) {
    case JointKind::Revolute:
      return "revolute";
    case JointKind::Distance:
      return "distance";
    case JointKind::Rope:
      return "rope";
    case JointKind::Prismatic:
      return "prismatic";
    case JointKind::Weld:
      return "weld";
    case JointKind::Wheel:
      return "wheel";
    case JointKind::Pulley:
      return "pulley";
    case JointKind::Gear:
      return "gear";
    case JointKind::Rack:
      return "rack";
    case JointKind::Motor:
      return "motor";
    case JointKind::Spring:
      return "spring";
  }
  return "unknown";
}

/// Refuses definitions that mean nothing, and makes the anchors one where the joint has only one.
void check_joint(JointDef& def) {
  const auto is = [&def](std::initializer_list<JointKind> kinds) {
    return std::find(kinds.begin(), kinds.end(), def.kind) != kinds.end();
  };
  require_finite(def.anchor_a, "joint: anchor_a");
  require_finite(def.anchor_b, "joint: anchor_b");
  if (is({JointKind::Revolute, JointKind::Weld, JointKind::Prismatic, JointKind::Wheel}))
    def.anchor_b = def.anchor_a;
  if (def.length) require_at_least_zero(*def.length, "joint: length");
  require(def.kind != JointKind::Distance || def.length.value_or(length(def.anchor_b - def.anchor_a)) > 0,
          "distance joint: length must be positive, got 0; use a revolute joint, or a spring");
  require_finite(def.axis, "joint: axis");
  require(def.axis != Vec2{}, "joint: axis must not be zero");
  require(std::isfinite(def.ratio) && def.ratio != 0, "joint: ratio must not be 0, got ", def.ratio);
  require(def.kind != JointKind::Pulley || def.ratio > 0, "pulley: ratio must be positive, got ", def.ratio);
  require_finite(def.pulley_a, "joint: pulley_a");
  require_finite(def.pulley_b, "joint: pulley_b");
  require_at_least_zero(def.stiffness, "joint: stiffness");
  require_at_least_zero(def.damping, "joint: damping");
  if (def.lower) require_finite(*def.lower, "joint: lower limit");
  if (def.upper) require_finite(*def.upper, "joint: upper limit");
  require(!def.lower || !def.upper || *def.lower <= *def.upper,
          "joint: lower limit must not exceed the upper one, got ", def.lower.value_or(0), " and ",
          def.upper.value_or(0));
  if (def.motor_speed) require_finite(*def.motor_speed, "joint: motor_speed");
  require(def.kind != JointKind::Motor || def.motor_speed, "motor joint: motor_speed must be given");
  require(def.kind != JointKind::Spring || def.stiffness > 0 || def.damping > 0,
          "spring: stiffness or damping must be positive, got 0 and 0");
  require(def.motor_limit >= 0, "joint: motor_limit must be >= 0, got ", def.motor_limit);
  require(def.break_force >= 0, "joint: break_force must be >= 0, got ", def.break_force);
  require(def.break_torque >= 0, "joint: break_torque must be >= 0, got ", def.break_torque);
  // What a kind does not have is refused rather than ignored.
  const char* const kind = name_of(def.kind);
  const bool limits = def.lower || def.upper;
  const bool spring = def.stiffness > 0 || def.damping > 0;
  require(!limits || is({JointKind::Revolute, JointKind::Distance, JointKind::Prismatic, JointKind::Wheel,
                         JointKind::Spring}),
          "joint: a ", kind, " joint has no limits");
  require(!def.length || has_length(def.kind), "joint: a ", kind, " joint has no length");
  require(!spring || is({JointKind::Revolute, JointKind::Distance, JointKind::Prismatic, JointKind::Wheel,
                         JointKind::Spring}),
          "joint: a ", kind, " joint has no spring");
  const bool motor = def.motor_speed || def.motor_limit < kInfinity;
  require(!motor || is({JointKind::Revolute, JointKind::Distance, JointKind::Prismatic, JointKind::Wheel,
                        JointKind::Motor}),
          "joint: a ", kind, " joint has no motor");
}

/// @param collide  whether the bodies of the joint touch each other
void touch_end(WorldState& s, std::uint32_t body, bool collide) {
  if (collide)
    touch(s, body);
  else
    touch_pairs(s, body);
}

void redefine(WorldState& s, JointRecord& joint, const JointDef& def) {
  // Rows are counted by what the joint has; another one renumbers those behind it.
  const auto has = [](const JointDef& d) {
    return std::tuple(d.lower.has_value(), d.upper.has_value(), d.motor_speed.has_value(), d.stiffness > 0,
                      d.damping > 0);
  };
  if (has(def) != has(joint.def)) std::fill(std::begin(joint.row_force), std::end(joint.row_force), 0);
  s.springs += (def.stiffness > 0) - (joint.def.stiffness > 0);
  joint.def = def;
}

}  // namespace

void remove_joint(WorldState& s, std::uint32_t i) {
  for (const BodyId id : {s.joints[i].def.a, s.joints[i].def.b}) {
    if (!id) continue;
    touch_end(s, id.index, s.joints[i].def.collide);
    displace(s, id.index);
    std::erase(s.joints_of[id.index], i);
  }
  s.joints_changed = true;
  s.springs -= s.joints[i].def.stiffness > 0;
  const std::uint32_t generation = s.joints[i].generation;
  s.joints[i] = JointRecord{};
  s.joints[i].generation = generation + 1;
  s.free_joints.push_back(i);
}

JointId World::create_joint(const JointDef& given) {
  WorldState& s = *state_;
  JointDef def = given;
  require(static_cast<bool>(def.b), "joint: body b must be given; body a may be none for the ground");
  const std::uint32_t b = slot(s, def.b);
  if (def.a) slot(s, def.a);
  require(def.a != def.b, "joint: both ends are body ", def.b.index);
  check_joint(def);

  std::uint32_t i;
  if (s.free_joints.empty()) {
    i = static_cast<std::uint32_t>(s.joints.size());
    s.joints.emplace_back();
  } else {
    const auto lowest = std::min_element(s.free_joints.begin(), s.free_joints.end());
    i = *lowest;
    s.free_joints.erase(lowest);
  }
  JointRecord& joint = s.joints[i];
  joint.def = def;
  joint.local_a = def.a ? to_local(s.bodies.pose(def.a.index), def.anchor_a) : def.anchor_a;
  joint.local_b = to_local(s.bodies.pose(b), def.anchor_b);
  const double angle_a = def.a ? s.bodies.angle[def.a.index] : 0;
  joint.reference_angle = s.bodies.angle[b] - angle_a;
  joint.local_axis = unit(def.axis);
  if (def.a && def.kind != JointKind::Rack)
    joint.local_axis = inverse_rotate(s.bodies.rotation[def.a.index], joint.local_axis);
  joint.alive = true;
  // What pulleys, gears and racks keep is the value of now.
  const bool keeps =
      def.kind == JointKind::Pulley || def.kind == JointKind::Gear || def.kind == JointKind::Rack;
  joint.length = keeps ? joint_coordinate(joint, joint_end(s, def.a.index), joint_end(s, b)).value
                       : def.length.value_or(length(def.anchor_b - def.anchor_a));
  for (const BodyId end : {def.a, def.b}) {
    if (!end) continue;
    touch_end(s, end.index, def.collide);
    displace(s, end.index);
  }
  s.joints_changed = true;
  s.springs += def.stiffness > 0;
  if (def.a) s.joints_of[def.a.index].push_back(i);
  s.joints_of[b].push_back(i);
  return {i, joint.generation};
}

void World::destroy(JointId id) {
  remove_joint(*state_, slot(*state_, id));
}

bool World::alive(JointId id) const {
  const auto& all = state_->joints;
  return id.index < all.size() && all[id.index].alive && all[id.index].generation == id.generation;
}

Vec2 World::joint_force(JointId id) const {
  const JointRecord& joint = state_->joints[slot(*state_, id)];
  return state_->report.h > 0 ? joint.impulse / state_->report.h : Vec2{};
}

double World::joint_torque(JointId id) const {
  const JointRecord& joint = state_->joints[slot(*state_, id)];
  return state_->report.h > 0 ? joint.angular_impulse / state_->report.h : 0;
}

double World::joint_position(JointId id) const {
  const JointRecord& joint = state_->joints[slot(*state_, id)];
  return joint_coordinate(joint, joint_end(*state_, joint.def.a.index), joint_end(*state_, joint.def.b.index))
      .value;
}

double World::joint_speed(JointId id) const {
  const JointRecord& joint = state_->joints[slot(*state_, id)];
  return joint_coordinate(joint, joint_end(*state_, joint.def.a.index), joint_end(*state_, joint.def.b.index))
      .rate;
}

void World::set_joint(JointId id, const JointDef& given) {
  WorldState& s = *state_;
  JointRecord& joint = s.joints[slot(s, id)];
  const JointDef& old = joint.def;
  JointDef def = given;
  if (!given.length && has_length(def.kind)) def.length = joint.length;
  check_joint(def);
  def.length = given.length;
  require(def.kind == old.kind && def.a == old.a && def.b == old.b,
          "set_joint: the kind and the bodies of a joint stay; make another one");
  require(def.anchor_a == old.anchor_a && def.anchor_b == old.anchor_b && def.axis == old.axis &&
              def.pulley_a == old.pulley_a && def.pulley_b == old.pulley_b && def.ratio == old.ratio,
          "set_joint: the anchors, the axis, the pulleys and the ratio of a joint stay; make another one");
  if (def.length) joint.length = *def.length;
  const bool other_pairs = def.collide != old.collide;
  redefine(s, joint, def);
  for (const BodyId end : {def.a, def.b}) {
    if (!end) continue;
    touch_definition(s, end.index);
    displace(s, end.index);
    if (other_pairs) touch_pairs(s, end.index);
  }
}

void World::set_motor(JointId id, double speed, std::optional<double> limit) {
  JointRecord& joint = state_->joints[slot(*state_, id)];
  JointDef def = joint.def;
  def.motor_speed = speed;
  if (limit) def.motor_limit = *limit;
  check_joint(def);
  redefine(*state_, joint, def);
  // Scripts do this in every step: what is known of other islands at rest is kept.
  for (const BodyId end : {def.a, def.b}) {
    if (end) touch(*state_, end.index);
  }
}

double World::spring_energy() const {
  if (state_->springs == 0) return 0;
  double sum = 0;
  for (const JointRecord& joint : state_->joints) {
    if (joint.alive) sum += skerry::spring_energy(*state_, joint);
  }
  return sum;
}

}  // namespace skerry
