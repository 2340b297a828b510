// SPDX-License-Identifier: MIT
#include "physics/stepping/free_flight.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "physics/joint_rows.h"
#include "physics/stepping/applied_forces.h"
#include "physics/stepping/path.h"
#include "physics/stepping/projection.h"
#include "physics/stepping/stepper.h"
#include "physics/stepping/touching.h"
#include "physics/stepping/travel.h"

namespace skerry {
namespace {

// Velocities that differ by no more than this share are the same, but for rounding.
constexpr double kRounded = 1e-14;

/// Whether a joint between two bodies that move alike, without turning, pushes nothing: it holds where they
/// are, so that no projection would move them, and wherever both go together. A motor may be at its limit,
/// which nothing has looked at yet.
bool goes_along(const WorldState& state, std::uint32_t slot) {
  const JointRecord& joint = state.joints[slot];
  const std::uint32_t a = joint.def.a.index, b = joint.def.b.index;
  if (!joint.def.a || state.local_index[a] < 0 || state.local_index[b] < 0 || joint.def.motor_speed)
    return false;
  const double floor = position_floor(state, state.bodies.position[b]);
  JointRows rows;
  const int count = joint_geometry(joint, joint_end(state, a), joint_end(state, b), rows);
  for (int k = 0; k < count; ++k) {
    const JointRow& row = rows[static_cast<std::size_t>(k)];
    const bool holds = row.kind == JointRowKind::Hold;
    if (!holds && row.kind != JointRowKind::Limit) return false;
    if (!((holds ? std::abs(row.error) : -row.error) <= floor)) return false;
    if (row.Ja[0] != -row.Jb[0] || row.Ja[1] != -row.Jb[1]) return false;
  }
  return true;
}

/// Whether joints alone are at work here, and have nothing to do: all bodies move alike, without turning, and
/// fall alike. What is at rest is not in flight.
bool falls_as_one(const WorldState& state, const Island& island) {
  if (!state.config.skips.flight || !island.contacts.empty() || island.joints.empty()) return false;
  const BodyArrays& all = state.bodies;
  const std::uint32_t first = island.bodies.front();
  const Vec2 v = all.velocity[first], a = state.acceleration[first];
  if (v == Vec2{} && a == Vec2{}) return false;
  const double most = kRounded * length(v);
  const auto flies_like_first = [&](std::uint32_t i) {
    return length(all.velocity[i] - v) <= most && std::abs(all.omega[i]) * state.radius[i] <= most &&
           state.acceleration[i] == a && state.angular_acceleration[i] == 0;
  };
  return std::all_of(island.bodies.begin(), island.bodies.end(), flies_like_first) &&
         !has_varying_forces(state, island) &&
         std::all_of(island.joints.begin(), island.joints.end(),
                     [&](std::uint32_t slot) { return goes_along(state, slot); });
}

}  // namespace

bool is_in_flight(const WorldState& state, const Island& island) {
  return state.config.skips.flight && island.contacts.empty() && island.joints.empty() &&
         !has_varying_forces(state, island);
}

bool fly_freely(WorldState& state, const Island& island, double h, IslandResult& result) {
  if (!is_in_flight(state, island) && !falls_as_one(state, island)) return false;
  std::vector<PathEnd> start;
  if (state.observe.paths) start = path_ends(state, island.bodies);
  for (const std::uint32_t body : island.bodies) fly(state, body, 0, h);
  for (const std::uint32_t slot : island.joints)
    std::fill(std::begin(state.joints[slot].row_force), std::end(state.joints[slot].row_force), 0);
  if (state.observe.paths) record_hermite(state, island.bodies, 0, h, start, result);
  result.in_flight = true;
  result.substeps = 1;
  return true;
}

}  // namespace skerry
