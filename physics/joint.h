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

enum class JointKind : std::uint8_t {
  Revolute,  ///< the two anchors coincide
  Distance,  ///< rod: the anchors keep their distance
  Rope,      ///< the anchors come no farther apart than `length`
};

struct JointDef {
  JointKind kind = JointKind::Revolute;
  BodyId a{};  ///< none: the ground
  BodyId b{};
  Vec2 anchor_a{};  ///< world frame at creation [m]
  Vec2 anchor_b{};  ///< world frame at creation [m]; Revolute: ignored, the anchors are one point
  std::optional<double> length{};  ///< Distance, Rope [m]; default: distance of the anchors at creation
  bool collide = false;            ///< do the two bodies still touch each other?
};

}  // namespace skerry
