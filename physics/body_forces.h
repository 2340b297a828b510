// SPDX-License-Identifier: MIT
//
// What acted on a body in the last step: its free-body diagram.
#pragma once

#include <cstdint>
#include <vector>

#include "physics/world.h"

namespace skerry {

enum class ForceSource : std::uint8_t {
  Weight,
  Contact,
  Joint,
  Applied,  ///< by the user, for that step
  Field,
  Drag,
};

/// A force on a body, the mean over the last step.
struct BodyForce {
  ForceSource source = ForceSource::Weight;
  BodyId other;       ///< Contact, Joint: what it comes from; none: the ground
  Vec2 point;         ///< where it acts, as the step left the bodies: world frame [m]
  Vec2 force;         ///< [N]
  double torque = 0;  ///< that it has besides, about `point` [N m]
};

/// All forces on a body in the last step, those of nothing left out: weight, contacts (a force a point, if
/// `Observe::contacts` was on), joints, what the user applied, field and drag. Without collisions they sum to
/// mass times the change of velocity over the length of the step: exactly for what does not turn and under
/// forces that are even, else to the first order. Impulses of collisions are in the forces of joints, but not
/// in those of contacts; the torque of rolling resistance is not among the torques.
/// @throws std::invalid_argument for a body that is not there, and what the force field throws
std::vector<BodyForce> forces_on(const World& world, BodyId body);

}  // namespace skerry
