// SPDX-License-Identifier: MIT
#include "physics/stepping/snapping_joints.h"

#include <algorithm>
#include <cmath>

#include "physics/stepping/applied_forces.h"
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
// Energy that comes or goes is more than this share of what moves.
constexpr double kLost = 1e-3;

double kinetic_energy(const WorldState& state, const Island& island) {
  const BodyArrays& all = state.bodies;
  double sum = 0;
  for (const std::uint32_t i : island.bodies) {
    sum +=
        0.5 * (all.mass[i] * length_squared(all.velocity[i]) + all.inertia[i] * all.omega[i] * all.omega[i]);
  }
  return sum;
}

/// What the forces of the step can still do, or have done [J], up to a constant.
double work_of_forces(const WorldState& state, const Island& island) {
  const BodyArrays& all = state.bodies;
  double sum = 0;
  for (const std::uint32_t i : island.bodies) {
    sum += all.mass[i] * dot(state.acceleration[i], all.position[i]) +
           all.inertia[i] * state.angular_acceleration[i] * all.angle[i];
  }
  return sum;
}

/// What the bodies get from rest in a step [J].
double energy_of_a_step(const WorldState& state, const Island& island, double h) {
  double sum = 0;
  for (const std::uint32_t i : island.bodies)
    sum += state.bodies.mass[i] * h * h * length_squared(state.acceleration[i]);
  return sum;
}

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

SnapGuard::SnapGuard(const WorldState& state, const Island& island, double elapsed, double h)
    : before_(state, island),
      off_(joints_are_off(state, island, elapsed, kOff)),
      h_(h),
      kinetic_(kinetic_energy(state, island)),
      total_(kinetic_ - work_of_forces(state, island)) {}

bool SnapGuard::snapped(const WorldState& state, const Island& island, double elapsed) const {
  if (!off_ && joints_are_off(state, island, elapsed, kOff)) return true;
  if (!keeps_energy(state, island)) return false;
  const double kinetic = kinetic_energy(state, island);
  const double moved = std::max(kinetic, kinetic_) + energy_of_a_step(state, island, h_);
  return std::abs(kinetic - work_of_forces(state, island) - total_) > kLost * moved;
}

}  // namespace skerry
