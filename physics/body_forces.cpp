// SPDX-License-Identifier: MIT
#include "physics/body_forces.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "physics/joint_rows.h"
#include "physics/stepping/applied_forces.h"
#include "physics/world_access.h"
#include "physics/world_report.h"

namespace skerry {
namespace {

/// Collects the forces on one body.
class Forces {
 public:
  Forces(const WorldState& state, std::uint32_t body) : s_(state), body_(body) {}

  void add_weight() {
    add(ForceSource::Weight, {s_.bodies.mass[body_] * s_.bodies.gravity_scale[body_] * s_.config.gravity, 0});
  }

  void add_contacts() {
    for (const ContactReport& contact : s_.report.contacts_list) {
      const bool second = contact.body_b.index == body_;
      if (!second && contact.body_a.index != body_) continue;
      for (int i = 0; i < contact.count; ++i) {
        const ContactPointReport& point = contact.points[static_cast<std::size_t>(i)];
        const Vec2 on_b =
            point.normal_impulse * contact.normal + point.friction_impulse * perp(contact.normal);
        add(ForceSource::Contact, second ? contact.body_a : contact.body_b, point.position,
            {(second ? 1 : -1) / s_.report.h * on_b, 0});
      }
    }
  }

  void add_joints() {
    for (const std::uint32_t i : s_.joints_of[body_]) {
      const JointRecord& joint = s_.joints[i];
      // A joint that has not pulled yet may be newer than the last step.
      if (std::all_of(std::begin(joint.row_impulse), std::end(joint.row_impulse),
                      [](double impulse) { return impulse == 0; }))
        continue;
      const bool second = joint.def.b.index == body_;
      const Vec2 anchor = to_world(s_.bodies.pose(body_), second ? joint.local_b : joint.local_a);
      const Wrench impulse = second ? Wrench{joint.impulse, joint.angular_impulse} : on_a(joint);
      add(ForceSource::Joint, second ? joint.def.a : joint.def.b, anchor,
          {impulse.force / s_.report.h, impulse.torque / s_.report.h});
    }
  }

  void add_others() {
    if (s_.bodies.type[body_] != BodyType::Dynamic) return;
    add(ForceSource::Applied, s_.applied[body_]);
    // What sleeps is in no field, and does not move.
    if (s_.bodies.asleep[body_] || s_.bodies.island[body_] < 0) return;
    const VaryingForces varying = varying_forces(s_, body_);
    add(ForceSource::Field, varying.field);
    add(ForceSource::Drag, varying.drag);
  }

  std::vector<BodyForce> take() { return std::move(forces_); }

 private:
  void add(ForceSource source, const Wrench& wrench) { add(source, {}, s_.bodies.position[body_], wrench); }

  void add(ForceSource source, BodyId other, Vec2 point, const Wrench& wrench) {
    if (wrench.force == Vec2{} && wrench.torque == 0) return;
    forces_.push_back({source, other, point, wrench.force, wrench.torque});
  }

  /// The torque about the anchor. Not the opposite of b's where wheels of a pulley or a pair of teeth, which
  /// the ground holds, stand between the two.
  Wrench on_a(const JointRecord& joint) const {
    const JointEnd a = halfway(s_, joint.def.a.index);
    const Vec2 arm = rotate(a.q, joint.local_a);
    JointRows rows;
    const int count = joint_geometry(joint, a, halfway(s_, joint.def.b.index), rows);
    Wrench sum;
    for (int k = 0; k < count; ++k) {
      const JointRow& row = rows[static_cast<std::size_t>(k)];
      const Vec2 force{row.Ja[0], row.Ja[1]};
      sum.force += joint.row_impulse[k] * force;
      sum.torque += joint.row_impulse[k] * (row.Ja[2] - cross(arm, force));
    }
    return sum;
  }

  const WorldState& s_;
  std::uint32_t body_;
  std::vector<BodyForce> forces_;
};

}  // namespace

std::vector<BodyForce> forces_on(const World& world, BodyId body) {
  const WorldState& state = *world.state_;
  Forces forces(state, slot(state, body));
  forces.add_weight();
  if (state.report.h > 0) {
    forces.add_contacts();
    forces.add_joints();
    forces.add_others();
  }
  return forces.take();
}

}  // namespace skerry
