// SPDX-License-Identifier: MIT
#include "physics/stepping/mode_impulses.h"

#include <algorithm>
#include <iterator>

#include "physics/world_state.h"

namespace skerry {
namespace {

std::size_t point_of(const Grip& grip, int i) {
  return static_cast<std::size_t>(grip.points[static_cast<std::size_t>(i)]);
}

PointMemory* memory_of(WorldState& state, const Island& island, const ModePoint& point) {
  for (PointMemory& memory : state.contacts[island.contacts[point.contact]].points) {
    if (memory.feature == point.feature) return &memory;
  }
  return nullptr;
}

}  // namespace

void clear_forces(WorldState& state, const Island& island, double h) {
  for (const std::uint32_t index : island.contacts) {
    for (PointMemory& memory : state.contacts[index].points) {
      memory.normal_impulse = memory.friction_impulse = memory.rolling_impulse = 0;
      memory.h = h;
      memory.sticking = false;
    }
  }
  for (const std::uint32_t slot : island.joints)
    std::fill(std::begin(state.joints[slot].row_force), std::end(state.joints[slot].row_force), 0);
}

void store_forces(WorldState& state, const Island& island, double h, const ContactMode& mode,
                  const ModeForces& forces, const AccelerationProblem::State& y) {
  clear_forces(state, island, h);
  const std::size_t points = 6 * island.bodies.size();
  const std::size_t grips = points + mode.points.size();
  const std::size_t joints = grips + mode.grips.size();
  for (std::size_t p = 0; p < mode.points.size(); ++p) {
    if (PointMemory* memory = memory_of(state, island, mode.points[p])) {
      // Closed points carry load, be it ever so small: that is how the projection knows them.
      if (mode.points[p].closed)
        memory->normal_impulse = h * std::max(forces.point_force[p], 1e-300 + 1e-15 * forces.scale);
      memory->total_normal += y[points + p];
    }
  }
  for (std::size_t k = 0; k < mode.grips.size(); ++k) {
    const Grip& grip = mode.grips[k];
    double load = 0;
    for (int i = 0; i < grip.count; ++i) load += forces.point_force[point_of(grip, i)];
    for (int i = 0; i < grip.count; ++i) {
      const ModePoint& point = mode.points[point_of(grip, i)];
      PointMemory* memory = memory_of(state, island, point);
      if (memory == nullptr || !point.closed || !(load > 0)) continue;
      const double share = forces.point_force[point_of(grip, i)] / load;
      (grip.rolling ? memory->rolling_impulse : memory->friction_impulse) = h * share * forces.grip_force[k];
      if (grip.rolling) continue;
      memory->total_friction += share * y[grips + k];
      memory->sticking = grip.sign == 0;
    }
  }
  for (std::size_t i = 0; i < mode.rows.size(); ++i) {
    JointRecord& joint = state.joints[island.joints[mode.rows[i].joint]];
    joint.row_force[mode.rows[i].row] = forces.row_force[i];
    joint.row_impulse[mode.rows[i].row] += y[joints + i];
  }
}

}  // namespace skerry
