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

namespace {

/// The integral of a force whose direction turns a little: of its size, its values and its directions at both
/// ends, as a line and an arc.
Vec2 integral_of(double size, double from, double to, Vec2 direction_from, Vec2 direction_to, double length) {
  const Vec2 sum = direction_from + direction_to;
  const Vec2 middle = sum / skerry::length(sum);
  return (size / 6) * (sum + 4 * middle) + (length * (to - from) / 12) * (direction_to - direction_from);
}

}  // namespace

void add_pushes(WorldState& state, const Island& island, const ContactMode& mode,
                const AccelerationProblem::State& before, const AccelerationProblem::State& after,
                const ModeForces& from, const ModeForces& to, double length) {
  const std::size_t points = 6 * island.bodies.size(), grips = points + mode.points.size();
  for (std::size_t p = 0; p < mode.points.size(); ++p) {
    if (!mode.points[p].closed) continue;
    state.contacts[island.contacts[mode.points[p].contact]].impulse +=
        integral_of(after[points + p] - before[points + p], from.point_force[p], to.point_force[p],
                    from.points[p].normal, to.points[p].normal, length);
  }
  for (std::size_t k = 0; k < mode.grips.size(); ++k) {
    const Grip& grip = mode.grips[k];
    if (grip.rolling) continue;
    std::size_t p = point_of(grip, 0);
    if (grip.count == 2 && !mode.points[p].closed) p = point_of(grip, 1);
    state.contacts[island.contacts[grip.contact]].impulse +=
        integral_of(after[grips + k] - before[grips + k], from.grip_force[k], to.grip_force[k],
                    perp(from.points[p].normal), perp(to.points[p].normal), length);
  }
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
