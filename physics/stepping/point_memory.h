// SPDX-License-Identifier: MIT
//
// What the points of a contact remember of a step in one piece.
#pragma once

#include <cmath>
#include <cstdint>

#include "physics/contact.h"
#include "physics/stepping/island_rows.h"
#include "physics/world_state.h"

namespace skerry {

/// What the forces of the last solve give b [N s].
inline Vec2 push_on_b(const PointForces& forces, Vec2 normal) {
  return forces.normal_impulse * normal + forces.friction_impulse * perp(normal);
}

/// No impulses. @param h  length of the step [s]
inline void forget_impulses(Contact& contact, double h) {
  for (PointMemory& memory : contact.points) {
    memory.normal_impulse = memory.friction_impulse = memory.rolling_impulse = 0;
    memory.h = h;
    memory.sticking = false;
  }
}

/// The impulse of one row; normal ones come before those of their friction.
inline void remember_impulse(const RowOrigin& origin, const Row& row, double lambda, Contact& contact) {
  PointMemory& memory = contact.points[static_cast<std::size_t>(origin.point)];
  contact.impulse += lambda * push_on_b(row);
  if (origin.kind == RowKind::Normal) memory.normal_impulse = lambda;
  if (origin.kind == RowKind::Rolling) memory.rolling_impulse = lambda;
  if (origin.kind != RowKind::Friction) return;
  memory.friction_impulse = lambda;
  memory.total_friction += lambda;
  memory.sticking =
      memory.normal_impulse > 0 && std::abs(lambda) < row.mu * memory.normal_impulse * (1 - 1e-12);
}

/// That impulse of the last step, for one of length `h` [s].
inline double last_impulse(const Contact& contact, const RowOrigin& origin, double h) {
  const PointMemory& memory = contact.points[static_cast<std::size_t>(origin.point)];
  if (!(memory.h > 0)) return 0;
  const double impulse = origin.kind == RowKind::Normal     ? memory.normal_impulse
                         : origin.kind == RowKind::Friction ? memory.friction_impulse
                                                            : memory.rolling_impulse;
  return impulse * (h / memory.h);
}

/// Its points have the impulses with which the step began, by their features.
inline void recall_impulses(Contact& contact) {
  for (int i = 0; i < contact.manifold.count; ++i) {
    PointForces& forces = contact.points[static_cast<std::size_t>(i)];
    for (const PointForces& last : contact.points_at_start)
      if (last.feature == forces.feature) forces = last;
  }
}

/// Nothing moves: the forces of the last step act on for one of length `h` [s].
inline void repeat_forces(WorldState& state, const Island& island, double h) {
  for (const std::uint32_t index : island.contacts) {
    Contact& contact = state.contacts[index];
    contact.impulse = {};
    for (PointMemory& memory : contact.points) {
      memory.total_normal = memory.normal_impulse;
      memory.total_friction = memory.friction_impulse;
      contact.impulse += push_on_b(memory, contact.manifold.normal);
    }
  }
  for (const std::uint32_t slot : island.joints) {
    JointRecord& joint = state.joints[slot];
    for (int k = 0; k < kMaxJointRows; ++k) joint.row_impulse[k] = h * joint.row_force[k];
  }
}

}  // namespace skerry
