// SPDX-License-Identifier: MIT
//
// Joints: constraints between two bodies (or a body and the ground) that are rows of the same exact system as
// the contacts.
#pragma once

#include <cstdint>
#include <optional>

#include "physics/handle.h"
#include "physics/math.h"

namespace skerry {

/// What a joint holds. x is an anchor, d = x_b - x_a, and "along the axis" means along a direction that is
/// fixed in a.
enum class JointKind : std::uint8_t {
  Revolute,   ///< the two anchors coincide
  Distance,   ///< rod: the anchors keep their distance; with limits or a spring it is free between them
  Rope,       ///< the anchors come no farther apart than `length`
  Prismatic,  ///< b slides along the axis of a without turning against it
  Weld,       ///< the anchors coincide and the angle between the bodies stays
  Wheel,      ///< b's anchor moves along the axis of a only (suspension), and b turns freely
  Pulley,     ///< |x_a - pulley_a| + ratio |x_b - pulley_b| = constant; what reaches its wheel meets no stop
  Gear,       ///< angle_b + ratio angle_a = constant
  Rack,       ///< b's anchor moves by `ratio` [m] along the axis (fixed in the world) for each rad of a
  Motor,      ///< drives the angular velocity of b against a
  Spring,     ///< pulls the anchors to the distance `length`; length 0: towards each other in every direction
};

/// Rows that a joint can have at most.
inline constexpr int kMaxJointRows = 6;

/// Limits, motor and spring of a joint act on its coordinate: the angle of b against a since creation [rad]
/// (Revolute, Motor), the way along the axis since creation [m] (Prismatic; Wheel, whose motor acts on the
/// angle), or the distance of the anchors [m] (Distance, Rope, Spring). Units with "or" are those of angles.
struct JointDef {
  JointKind kind = JointKind::Revolute;
  BodyId a{};  ///< none: the ground
  BodyId b{};
  Vec2 anchor_a{};  ///< world frame at creation [m]
  /// World frame at creation [m]; ignored where the anchors are one point (Revolute, Weld, Prismatic, Wheel).
  Vec2 anchor_b{};
  std::optional<double> length{};  ///< Distance, Rope, Spring [m]; default: distance at creation
  bool collide = false;            ///< do the two bodies still touch each other?

  Vec2 axis{1, 0};              ///< Prismatic, Wheel, Rack: world frame at creation, any length but zero
  double ratio = 1;             ///< Pulley, Gear [1]; Rack [m]: the pitch radius
  Vec2 pulley_a{}, pulley_b{};  ///< Pulley: where the ends run over the wheels, world frame [m]
  std::optional<double> lower{}, upper{};  ///< limits of the coordinate [m or rad]
  std::optional<double> motor_speed{};     ///< wanted rate of the coordinate [m/s or rad/s]; none: no motor
  /// Largest force of the motor [N or N m]. Without one it gets its way, but ends at limits of its
  /// coordinate.
  double motor_limit = kInfinity;
  double stiffness = 0;             ///< of the spring [N/m or N m/rad]
  double damping = 0;               ///< of its damper [N s/m or N m s/rad]
  double break_force = kInfinity;   ///< the joint breaks when its mean force over a step is larger [N]
  double break_torque = kInfinity;  ///< or its mean torque [N m]
};

}  // namespace skerry
