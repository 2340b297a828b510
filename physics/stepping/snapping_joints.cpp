// SPDX-License-Identifier: MIT
#include "physics/stepping/snapping_joints.h"

#include <algorithm>

#include "physics/stepping/applied_forces.h"
#include "physics/stepping/island_energy.h"
#include "physics/stepping/joint_limits.h"
#include "physics/stepping/joint_midpoint.h"
#include "physics/stepping/one_piece_joints.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// How many times as heavy a body is as the one it hangs on; of chains of up to 64 times none was off.
constexpr double kHeavy = 64;
// Joints are off by more than this share of a body, which pieces that went well never leave.
constexpr double kOff = 1e-7;

/// Whether joints only hold, and nothing else changes the energy than constant forces.
bool keeps_energy(const WorldState& state, const Island& island) {
  return !has_varying_forces(state, island) && !meets_motion(state, island) &&
         std::all_of(island.joints.begin(), island.joints.end(), [&](std::uint32_t slot) {
           const JointDef& def = state.joints[slot].def;
           return holds_always(def) && !has_limits(def) && !def.motor_speed && def.stiffness == 0 &&
                  def.damping == 0;
         });
}

}  // namespace

bool may_snap(const WorldState& state, const Island& island) {
  if (!island.contacts.empty() || island.joints.size() < 2) return false;
  const BodyArrays& all = state.bodies;
  return std::any_of(island.joints.begin(), island.joints.end(), [&](std::uint32_t slot) {
    const JointDef& def = state.joints[slot].def;
    if (!def.a || !def.b) return false;
    const double a = all.inverse_mass[def.a.index], b = all.inverse_mass[def.b.index];
    return std::min(a, b) > 0 && std::max(a, b) > kHeavy * std::min(a, b);
  });
}

SnapGuard::SnapGuard(const WorldState& state, const Island& island, double elapsed)
    : before_(state, island), off_(joints_are_off(state, island, elapsed, kOff)) {}

bool SnapGuard::snapped(const WorldState& state, const Island& island, double elapsed, double h,
                        const IslandEnergy& energy) const {
  if (!off_ && joints_are_off(state, island, elapsed, kOff)) return true;
  return keeps_energy(state, island) && energy.changed(state, island, h);
}

}  // namespace skerry
