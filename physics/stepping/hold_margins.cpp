// SPDX-License-Identifier: MIT
#include "physics/stepping/hold_margins.h"

#include <algorithm>
#include <cmath>

#include "physics/joint_rows.h"
#include "physics/stepping/touching.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

void add_contact(const WorldState& state, const Contact& contact, std::vector<HoldMargin>& margins) {
  const BodyArrays& all = state.bodies;
  const double lightness = all.inverse_mass[contact.body_a] + all.inverse_mass[contact.body_b];
  const double turning = all.inverse_inertia[contact.body_a] + all.inverse_inertia[contact.body_b];
  double normal = 0, friction = 0, rolling = 0;
  for (const PointMemory& memory : contact.points) {
    const double rate = memory.h > 0 ? 1 / memory.h : 0;
    margins.push_back({memory.feature, rate * memory.normal_impulse, 0, lightness});
    normal += rate * memory.normal_impulse;
    friction += rate * memory.friction_impulse;
    rolling += rate * memory.rolling_impulse;
  }
  const std::uint32_t feature = contact.points[0].feature;
  const double most = std::max(contact.static_friction, contact.friction) * normal;
  margins.push_back({feature, most - std::abs(friction), most - contact.friction * normal, lightness});
  margins.push_back({feature, contact.rolling_resistance * normal - std::abs(rolling), 0, turning});
}

void add_joint(const WorldState& state, const JointRecord& joint, std::vector<HoldMargin>& margins) {
  JointRows rows;
  const BodyId a = joint.def.a, b = joint.def.b;
  const int count = joint_rows(joint, joint_end(state, a.index), joint_end(state, b.index), rows);
  for (int k = 0; k < count; ++k) {
    const JointRow& row = rows[static_cast<std::size_t>(k)];
    HoldMargin& margin = margins.emplace_back();
    if (row.kind == JointRowKind::Limit) margin.left = joint.row_force[k];
    if (row.kind == JointRowKind::Motor && row.most < kInfinity)
      margin.left = row.most - std::abs(joint.row_force[k]);
    const auto add = [&](std::uint32_t body, const std::array<double, 3>& direction) {
      if (body == BodyId::kNone) return;
      const double squares = direction[0] * direction[0] + direction[1] * direction[1];
      margin.lightness += state.bodies.inverse_mass[body] * squares +
                          state.bodies.inverse_inertia[body] * direction[2] * direction[2];
    };
    add(a.index, row.Ja);
    add(b.index, row.Jb);
  }
}

}  // namespace

std::vector<HoldMargin> hold_margins(const WorldState& state, const Island& island) {
  std::vector<HoldMargin> margins;
  margins.reserve(4 * island.contacts.size() + kMaxJointRows * island.joints.size());
  for (const std::uint32_t i : island.contacts) add_contact(state, state.contacts[i], margins);
  for (const std::uint32_t i : island.joints) add_joint(state, state.joints[i], margins);
  return margins;
}

LateRelease late_release(const std::vector<HoldMargin>& first, const std::vector<HoldMargin>& second,
                         double length, double nothing) {
  LateRelease out;
  for (std::size_t k = 0; k < std::min(first.size(), second.size()); ++k) {
    const double left = second[k].left;
    if (first[k].feature != second[k].feature || !(left > 0)) continue;
    const double fall = (first[k].left - left) / (0.5 * length);
    if (!(fall > 0)) continue;
    const double below = 0.25 * length * fall - left;
    const double late = std::abs(below) / fall;
    const double velocity = (0.5 * std::abs(below) + second[k].drop) * late * second[k].lightness;
    if (below > 0)
      out.velocity = std::max(out.velocity, velocity);
    else if (velocity > nothing)
      out.ahead = std::min(out.ahead, late);
  }
  return out;
}

}  // namespace skerry
