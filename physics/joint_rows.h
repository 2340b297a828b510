// SPDX-License-Identifier: MIT
//
// Joints as rows: position error, Jacobian blocks, bounds.
#pragma once

#include <array>
#include <optional>

#include "physics/islands/island_system.h"
#include "physics/joint.h"

namespace skerry {

struct JointRecord;

/// One scalar constraint of a joint at given poses: `error` is C(q), and J its derivative.
struct JointRow {
  std::array<double, 3> Ja, Jb;  ///< velocity Jacobian blocks [1, 1, m]
  double error = 0;              ///< C(q) [m]; Limit: the slack, negative when exceeded
  bool limit = false;            ///< one-sided: the impulse is >= 0 and C >= 0
  Vec2 direction;                ///< of a positive impulse on b, world frame
};

/// The rows of a joint (two for Revolute, one otherwise) for bodies at `pose_a`, `pose_b`.
/// @return number of rows written
int joint_rows(const JointRecord& joint, const Transform& pose_a, const Transform& pose_b,
               std::array<JointRow, 2>& rows);

}  // namespace skerry
