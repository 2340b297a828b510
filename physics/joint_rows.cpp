// SPDX-License-Identifier: MIT
#include "physics/joint_rows.h"

#include "physics/world.h"

namespace skerry {
namespace {

/// The row that measures the relative velocity of the anchors along `direction`.
JointRow along(Vec2 direction, Vec2 ra, Vec2 rb) {
  JointRow row;
  row.direction = direction;
  row.Ja = {-direction.x, -direction.y, -cross(ra, direction)};
  row.Jb = {direction.x, direction.y, cross(rb, direction)};
  return row;
}

}  // namespace

int joint_rows(const JointRecord& joint, const Transform& pose_a, const Transform& pose_b,
               std::array<JointRow, 2>& rows) {
  const Vec2 ra = rotate(pose_a.q, joint.local_a);
  const Vec2 rb = rotate(pose_b.q, joint.local_b);
  const Vec2 apart = (pose_b.p - pose_a.p) + (rb - ra);
  switch (joint.def.kind) {
    case JointKind::Revolute:
      rows[0] = along({1, 0}, ra, rb);
      rows[0].error = apart.x;
      rows[1] = along({0, 1}, ra, rb);
      rows[1].error = apart.y;
      return 2;
    case JointKind::Distance:
    case JointKind::Rope: {
      const double distance = length(apart);
      // Anchors on one point have no direction; any will do, and the next step has one.
      const Vec2 direction = distance > 0 ? apart / distance : Vec2{0, 1};
      const bool rope = joint.def.kind == JointKind::Rope;
      rows[0] = along(rope ? -direction : direction, ra, rb);
      rows[0].error = rope ? joint.length - distance : distance - joint.length;
      rows[0].limit = rope;
      return 1;
    }
  }
  return 0;
}

}  // namespace skerry
