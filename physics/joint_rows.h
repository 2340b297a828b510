// SPDX-License-Identifier: MIT
//
// Joints as rows: position error, Jacobian blocks, what differentiating twice leaves, bounds.
#pragma once

#include <array>
#include <cstdint>

#include "physics/joint.h"
#include "physics/math.h"

namespace skerry {

struct JointRecord;

enum class JointRowKind : std::uint8_t {
  Hold,    ///< C = 0
  Limit,   ///< C >= 0 with an impulse >= 0
  Motor,   ///< dC/dt = speed with a force of at most `most`
  Spring,  ///< the force is -stiffness C - damping dC/dt
};

/// A body as a joint sees it; the ground is the default.
struct JointEnd {
  Vec2 p;  ///< centre of mass [m]
  Rot q;
  double angle = 0;  ///< that of `q`, not reduced [rad]
  Vec2 v;            ///< [m/s]
  double omega = 0;  ///< [rad/s]
};

/// One scalar row of a joint, with C(q) its coordinate: dC/dt = J v and d2C/dt2 = J a + bias. Nothing is set
/// before `joint_rows` does it: clearing six of them would cost as much as making two.
struct JointRow {
  JointRowKind kind;
  std::array<double, 3> Ja, Jb;  ///< velocity Jacobian blocks [1, 1, m]
  double error;                  ///< C(q) [m or rad]; Limit: the slack, negative when exceeded
  double rate;                   ///< J v [m/s or rad/s]
  double bias;                   ///< (dJ/dt) v [m/s^2 or rad/s^2]
  double speed;                  ///< Motor [m/s or rad/s], else 0
  double most;                   ///< Motor [N or N m], else infinity
  double stiffness, damping;     ///< Spring, else 0
  bool singular;                 ///< the anchors coincide, so that their distance has no direction
};

using JointRows = std::array<JointRow, kMaxJointRows>;

/// The rows of a joint for bodies that move like `a` and `b`. Number and kinds depend on the joint alone, not
/// on where the bodies are.
/// @return number of rows written
int joint_rows(const JointRecord& joint, const JointEnd& a, const JointEnd& b, JointRows& rows);
/// The same without `rate` and `bias`, which are left as they were: for whoever needs the places only, at
/// half of the cost.
int joint_geometry(const JointRecord& joint, const JointEnd& a, const JointEnd& b, JointRows& rows);
/// Number of rows of a joint that has only rows that hold; -1 if it has a limit, a motor or a spring.
int held_rows(const JointDef& def);

/// Value and rate of the coordinate on which limits, motor and spring act (see JointDef). Pulley, Gear and
/// Rack: the error of what they hold.
struct JointCoordinate {
  double value = 0;  ///< [m or rad]
  double rate = 0;   ///< [m/s or rad/s]
};
JointCoordinate joint_coordinate(const JointRecord& joint, const JointEnd& a, const JointEnd& b);

/// What an impulse of 1 on `row` does to b: a force, and a torque about b's anchor.
struct JointReaction {
  Vec2 force;
  double torque = 0;
};
JointReaction row_reaction(const JointRecord& joint, const JointEnd& b, const JointRow& row);

}  // namespace skerry
