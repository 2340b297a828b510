// SPDX-License-Identifier: MIT
#include "physics/stepping/joint_stability.h"

#include <algorithm>
#include <cmath>

#include "physics/stepping/touching.h"

namespace skerry {
namespace {

bool moves(const WorldState& state, std::uint32_t body) {
  return body != BodyId::kNone && (state.bodies.velocity[body] != Vec2{} || state.bodies.omega[body] != 0);
}

}  // namespace

double stable_length(const WorldState& state, const Island& island) {
  double fastest = 0;  // largest w^2
  for (const std::uint32_t slot : island.joints) {
    const JointRecord& joint = state.joints[slot];
    const std::uint32_t a = joint.def.a.index, b = joint.def.b.index;
    if (!moves(state, a) && !moves(state, b)) continue;
    const JointEnd end_a = joint_end(state, a), end_b = joint_end(state, b);
    JointRows rows;
    const int count = joint_rows(joint, end_a, end_b, rows);
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
    } else if (joint.def.kind == JointKind::Distance || joint.def.kind == JointKind::Rope) {
      rod_a = rod_b = length(anchor_b - anchor_a);
    }
    shake(a, length(force_a), length(anchor_a - end_a.p), rod_a);
    shake(b, length(force_b), length(anchor_b - end_b.p), rod_b);
  }
  return fastest > 0 ? 1 / std::sqrt(fastest) : kInfinity;
}

}  // namespace skerry
