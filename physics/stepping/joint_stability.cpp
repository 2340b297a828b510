// SPDX-License-Identifier: MIT
#include "physics/stepping/joint_stability.h"

#include <algorithm>
#include <cmath>

#include "physics/stepping/touching.h"

namespace skerry {
namespace {

// Share of the size of a body at which a joint sits at its centre.
constexpr double kNoArm = 1e-3;
// Angle by which bodies may turn about their joints in a step, and in a piece of one in which they turn by
// more [rad].
constexpr double kFarTurn = 0.8, kTurn = 0.5;

bool moves(const WorldState& state, std::uint32_t body) {
  return body != BodyId::kNone && (state.bodies.velocity[body] != Vec2{} || state.bodies.omega[body] != 0);
}

/// True if w h < 1 whatever way the forces of the joint point: no more than their sum pulls, and at the ends
/// of the arms. Joints whose rows have unit directions, and no rod.
bool is_calm(const WorldState& state, const JointRecord& joint, double h) {
  const JointKind kind = joint.def.kind;
  if (kind != JointKind::Revolute && kind != JointKind::Weld && kind != JointKind::Prismatic) return false;
  double pull = 0;
  for (const double force : joint.row_force) pull += std::abs(force);
  const auto rate = [&](std::uint32_t body, Vec2 arm) {
    return body == BodyId::kNone
               ? 0
               : state.bodies.inverse_inertia[body] * pull * (std::abs(arm.x) + std::abs(arm.y));
  };
  const double fastest =
      std::max(rate(joint.def.a.index, joint.local_a), rate(joint.def.b.index, joint.local_b));
  // Far enough from the border for rounding not to matter.
  return fastest * h * h < 0.5;
}

/// Whether it pulls along the line between its anchors. A spring that wants them in one place pulls towards
/// it from everywhere.
bool is_rod(const JointRecord& joint) {
  const JointKind kind = joint.def.kind;
  return kind == JointKind::Distance || kind == JointKind::Rope || kind == JointKind::Pulley ||
         (kind == JointKind::Spring && joint.length > 0);
}

/// @param starting  joints between bodies at rest do, too
/// @param counts  says which joints do
template <class Counts>
double stable_length_where(const WorldState& state, const Island& island, bool starting, Counts&& counts) {
  double fastest = 0;  // largest w^2
  for (const std::uint32_t slot : island.joints) {
    const JointRecord& joint = state.joints[slot];
    const std::uint32_t a = joint.def.a.index, b = joint.def.b.index;
    if ((!starting && !moves(state, a) && !moves(state, b)) || !counts(joint)) continue;
    const JointEnd end_a = joint_end(state, a), end_b = joint_end(state, b);
    JointRows rows;
    const int count = joint_geometry(joint, end_a, end_b, rows);
    Vec2 force_a, force_b;
    for (int i = 0; i < count; ++i) {
      const double force = joint.row_force[i];
      force_a +=
          force * Vec2{rows[static_cast<std::size_t>(i)].Ja[0], rows[static_cast<std::size_t>(i)].Ja[1]};
      force_b +=
          force * Vec2{rows[static_cast<std::size_t>(i)].Jb[0], rows[static_cast<std::size_t>(i)].Jb[1]};
    }
    const Vec2 anchor_a = end_a.p + rotate(end_a.q, joint.local_a);
    const Vec2 anchor_b = end_b.p + rotate(end_b.q, joint.local_b);
    const auto shake = [&](std::uint32_t body, double force, double arm, double rod) {
      if (body == BodyId::kNone) return;
      double rate = state.bodies.inverse_inertia[body] * force * arm;
      if (rod > 0) rate += state.bodies.inverse_mass[body] * force / rod;
      fastest = std::max(fastest, rate);
    };
    double rod_a = 0, rod_b = 0;
    if (joint.def.kind == JointKind::Pulley) {
      rod_a = length(anchor_a - joint.def.pulley_a);
      rod_b = length(anchor_b - joint.def.pulley_b);
    } else if (is_rod(joint)) {
      rod_a = rod_b = length(anchor_b - anchor_a);
    }
    shake(a, length(force_a), length(anchor_a - end_a.p), rod_a);
    shake(b, length(force_b), length(anchor_b - end_b.p), rod_b);
  }
  return fastest > 0 ? 1 / std::sqrt(fastest) : kInfinity;
}

}  // namespace

double stable_length(const WorldState& state, const Island& island, double enough, bool starting) {
  return stable_length_where(state, island, starting,
                             [&](const JointRecord& joint) { return !is_calm(state, joint, enough); });
}

double stable_length_of_rods(const WorldState& state, const Island& island) {
  return stable_length_where(state, island, false, [](const JointRecord& joint) { return is_rod(joint); });
}

double stable_length_of_turns(const WorldState& state, const Island& island, double h) {
  // At a glance, as nearly nothing turns as fast.
  const auto turns = [&](BodyId body) {
    return body && std::abs(state.bodies.omega[body.index]) * h > kFarTurn;
  };
  double fastest = 0;
  for (const std::uint32_t slot : island.joints) {
    const JointRecord& joint = state.joints[slot];
    const JointDef& def = joint.def;
    if (!turns(def.a) && !turns(def.b)) continue;
    if (def.kind == JointKind::Gear || def.kind == JointKind::Motor) continue;
    const JointEnd a = joint_end(state, def.a.index), b = joint_end(state, def.b.index);
    const Vec2 anchor_b = b.p + rotate(b.q, joint.local_b);
    // What slides pushes where it is.
    const bool slides = def.kind == JointKind::Prismatic || def.kind == JointKind::Wheel;
    const Vec2 arm_a = slides ? anchor_b - a.p : rotate(a.q, joint.local_a);
    const auto turn = [&](BodyId body, double omega, Vec2 arm) {
      if (body && length(arm) > kNoArm * state.radius[body.index])
        fastest = std::max(fastest, std::abs(omega));
    };
    turn(def.a, a.omega, arm_a);
    turn(def.b, b.omega, anchor_b - b.p);
  }
  return fastest * h > kFarTurn ? kTurn / fastest : kInfinity;
}

double stable_length_of_springs(const WorldState& state, const Island& island) {
  constexpr double kStretch = 0.2;
  if (state.springs == 0) return kInfinity;
  double fastest = 0;  // largest v w / l
  for (const std::uint32_t slot : island.joints) {
    const JointRecord& joint = state.joints[slot];
    if (!(joint.def.stiffness > 0) || !is_rod(joint) || joint.def.kind == JointKind::Pulley) continue;
    const JointEnd a = joint_end(state, joint.def.a.index), b = joint_end(state, joint.def.b.index);
    const Vec2 arm_a = rotate(a.q, joint.local_a), arm_b = rotate(b.q, joint.local_b);
    const Vec2 line = b.p + arm_b - a.p - arm_a;
    const double l = length(line);
    if (!(l > 0)) continue;
    const Vec2 along = line / l;
    const auto mobility = [&](BodyId body, Vec2 arm) {
      if (!body) return 0.0;
      const double lever = cross(arm, along);
      return state.bodies.inverse_mass[body.index] + lever * lever * state.bodies.inverse_inertia[body.index];
    };
    const double past = std::abs(cross(along, b.v + b.omega * perp(arm_b) - a.v - a.omega * perp(arm_a)));
    const double swing =
        std::sqrt(joint.def.stiffness * (mobility(joint.def.a, arm_a) + mobility(joint.def.b, arm_b)));
    fastest = std::max(fastest, past * swing / l);
  }
  return fastest > 0 ? std::sqrt(kStretch / fastest) : kInfinity;
}

bool swings_fast(const WorldState& state, const Island& island, double h) {
  const BodyArrays& all = state.bodies;
  return std::any_of(island.joints.begin(), island.joints.end(), [&](std::uint32_t slot) {
    const JointRecord& joint = state.joints[slot];
    if (!(joint.def.stiffness > 0)) return false;
    // The spring of a hinge acts on angles.
    const bool turns = joint.def.kind == JointKind::Revolute;
    const auto mobility = [&](BodyId body) {
      return !body ? 0 : turns ? all.inverse_inertia[body.index] : all.inverse_mass[body.index];
    };
    return h * h * joint.def.stiffness * (mobility(joint.def.a) + mobility(joint.def.b)) > 4;
  });
}

}  // namespace skerry
