// SPDX-License-Identifier: MIT
//
// Small questions that the parts of a stepper ask about bodies and contact points.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "physics/joint_rows.h"
#include "physics/world_state.h"

namespace skerry {

/// Pose of `body`, `elapsed` after the beginning of the step. Dynamic bodies are where they are; kinematic
/// ones, which many islands share, follow their motion; kNone is the ground.
inline Transform pose_at(const WorldState& state, std::uint32_t body, double elapsed) {
  if (body == BodyId::kNone) return {};
  const BodyArrays& all = state.bodies;
  if (all.type[body] != BodyType::Kinematic || elapsed == 0) return all.pose(body);
  const KinematicState now = kinematic_state(state, body, elapsed);
  return {now.p, Rot::from_angle(now.angle)};
}

/// A body as a joint sees it, `elapsed` after the beginning of the step.
inline JointEnd joint_end(const WorldState& state, std::uint32_t body, double elapsed = 0) {
  if (body == BodyId::kNone) return {};
  const BodyArrays& all = state.bodies;
  if (all.type[body] == BodyType::Kinematic && elapsed != 0) {
    const KinematicState now = kinematic_state(state, body, elapsed);
    return {now.p, Rot::from_angle(now.angle), now.angle, now.v, now.omega};
  }
  return {all.position[body], all.rotation[body], all.angle[body], all.velocity[body], all.omega[body]};
}

/// Energy in the spring of a joint, 0 without one [J]. @param elapsed  of kinematic bodies, as in `joint_end`
inline double spring_energy(const WorldState& state, const JointRecord& joint, double elapsed = 0) {
  if (!(joint.def.stiffness > 0)) return 0;
  JointRows rows;
  const int count = joint_geometry(joint, joint_end(state, joint.def.a.index, elapsed),
                                   joint_end(state, joint.def.b.index, elapsed), rows);
  double sum = 0;
  for (int k = 0; k < count; ++k) {
    const JointRow& row = rows[static_cast<std::size_t>(k)];
    if (row.kind == JointRowKind::Spring) sum += 0.5 * row.stiffness * row.error * row.error;
  }
  return sum;
}

/// Neither endless nor a chain.
inline bool is_hull(const Shape& shape) {
  return shape.kind == ShapeKind::Polygon || shape.kind == ShapeKind::Capsule ||
         shape.kind == ShapeKind::Disc;
}

/// Gaps up to this count as closed: the world's tolerance, or what rounding leaves of coordinates this large
/// [m].
inline double touch_tolerance(const WorldState& state, Vec2 where) {
  const double size = std::max(std::abs(where.x), std::abs(where.y));
  return std::max(state.config.touch_tolerance, 32 * std::numeric_limits<double>::epsilon() * size);
}

inline bool is_touching(const WorldState& state, const ManifoldPoint& point) {
  return point.separation <= touch_tolerance(state, point.position);
}

/// Whether a point of a contact touches.
inline bool touches(const WorldState& state, const Contact& contact) {
  return std::any_of(contact.manifold.points.begin(),
                     contact.manifold.points.begin() + contact.manifold.count,
                     [&](const ManifoldPoint& point) { return is_touching(state, point); });
}

/// Whether a point of a contact is farther in than `depth` [m], and than rounding explains.
inline bool is_deeper(const WorldState& state, const Contact& contact, double depth) {
  for (int i = 0; i < contact.manifold.count; ++i) {
    const ManifoldPoint& point = contact.manifold.points[static_cast<std::size_t>(i)];
    if (-point.separation > std::max(depth, touch_tolerance(state, point.position))) return true;
  }
  return false;
}

inline bool overlaps(const WorldState& state, const Contact& contact) {
  return is_deeper(state, contact, 0);
}

/// Size of a body of the island at hand; infinite for others [m].
inline double size_in_island(const WorldState& state, std::uint32_t body) {
  return body != BodyId::kNone && state.local_index[body] >= 0 ? state.radius[body] : kInfinity;
}

/// Whether a point of a contact of the island at hand is in deeper than a share of the smaller body.
inline bool is_deep(const WorldState& state, const Contact& contact, double share) {
  return is_deeper(
      state, contact,
      share * std::min(size_in_island(state, contact.body_a), size_in_island(state, contact.body_b)));
}

/// Velocity of the material point of `body` at `where`, world frame [m/s].
inline Vec2 point_velocity(const WorldState& state, std::uint32_t body, Vec2 where, double elapsed) {
  const JointEnd end = joint_end(state, body, elapsed);
  return end.v + end.omega * perp(where - end.p);
}

/// Velocity of b against a at a point.
inline Vec2 relative_velocity(const WorldState& state, const Contact& contact, Vec2 where, double elapsed) {
  return point_velocity(state, contact.body_b, where, elapsed) -
         point_velocity(state, contact.body_a, where, elapsed);
}

/// The same along the contact's normal [m/s]; negative: approaching.
inline double normal_velocity(const WorldState& state, const Contact& contact, Vec2 where, double elapsed) {
  return dot(contact.manifold.normal, relative_velocity(state, contact, where, elapsed));
}

}  // namespace skerry
