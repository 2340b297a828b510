// SPDX-License-Identifier: MIT
//
// What the points of a contact remember of a step in one piece.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "physics/contact.h"
#include "physics/spare.h"
#include "physics/stepping/island_rows.h"
#include "physics/world_state.h"

namespace skerry {

/// No impulses. @param h  length of the step [s]
inline void forget_impulses(Contact& contact, double h) {
  for (PointMemory& memory : contact.points) {
    memory.normal_impulse = memory.friction_impulse = memory.rolling_impulse = 0;
    memory.h = h;
    memory.sticking = false;
  }
}

/// The impulse of one row; normal ones come before those of their friction.
/// @param mu  of a row of friction
inline void remember_impulse(const RowOrigin& origin, double mu, double lambda, Contact& contact) {
  PointMemory& memory = contact.points[static_cast<std::size_t>(origin.point)];
  if (origin.kind == RowKind::Normal) memory.normal_impulse = lambda;
  if (origin.kind == RowKind::Rolling) memory.rolling_impulse = lambda;
  if (origin.kind != RowKind::Friction) return;
  memory.friction_impulse = lambda;
  memory.total_friction += lambda;
  memory.sticking = memory.normal_impulse > 0 && std::abs(lambda) < mu * memory.normal_impulse * (1 - 1e-12);
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

/// Nothing moves: the forces of the last step act on for one of length `h` [s].
inline void repeat_forces(WorldState& state, const Island& island, double h) {
  for (const std::uint32_t index : island.contacts) {
    for (PointMemory& memory : state.contacts[index].points) {
      memory.total_normal = memory.normal_impulse;
      memory.total_friction = memory.friction_impulse;
    }
  }
  for (const std::uint32_t slot : island.joints) {
    JointRecord& joint = state.joints[slot];
    for (int k = 0; k < kMaxJointRows; ++k) joint.row_impulse[k] = h * joint.row_force[k];
  }
}

/// Forces of an island in flow, kept while exact ones are looked for: an attempt in pieces lets go of what is
/// open by a hair, and a deep heap that begins with the forces of that sinks in before sweeps have pressed it
/// together again.
class KeptForces {
 public:
  KeptForces(const WorldState& state, const Island& island) {
    for (const std::uint32_t i : island.contacts)
      points_->push_back({state.contacts[i].points[0], state.contacts[i].points[1]});
    for (const std::uint32_t i : island.joints) rows_->push_back(std::to_array(state.joints[i].row_force));
  }

  /// Gives them back to the points that are still there.
  void restore(WorldState& state, const Island& island) const {
    for (std::size_t k = 0; k < island.contacts.size(); ++k) {
      for (PointMemory& memory : state.contacts[island.contacts[k]].points) {
        PointForces& forces = memory;
        for (const PointForces& kept : (*points_)[k])
          if (kept.feature == forces.feature) forces = kept;
      }
    }
    for (std::size_t k = 0; k < island.joints.size(); ++k)
      std::copy((*rows_)[k].begin(), (*rows_)[k].end(), state.joints[island.joints[k]].row_force);
  }

 private:
  Spare<std::vector<std::array<PointForces, 2>>> points_;
  Spare<std::vector<std::array<double, kMaxJointRows>>> rows_;
};

}  // namespace skerry
