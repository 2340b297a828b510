// SPDX-License-Identifier: MIT
//
// How far what holds is from letting go.
#pragma once

#include <vector>

#include "physics/stepping/stepper.h"

namespace skerry {

/// A force of a contact or joint in the last piece of a step, and its bound: a normal force and zero,
/// friction or resistance to rolling of a whole contact and what the normal forces allow, the force of a
/// limit or a rope and zero, that of a motor and its largest one.
struct HoldMargin {
  std::uint32_t feature = 0;  ///< of the point; margins of the same place in two lists are the same if it is
  double left = 0;            ///< [N or N m] until it lets go; 0: nothing to let go
  double drop = 0;            ///< what it loses then: static friction beyond that of sliding [N]
  double lightness = 0;  ///< change of the relative velocity for an impulse, at most [1/kg or 1/(kg m^2)]
};

/// Of all contacts of an island, then of its joints.
std::vector<HoldMargin> hold_margins(const WorldState& state, const Island& island);

/// What holds and should have let go near the end of a time is held to its end, whether that is made in one
/// piece or in two, so the two do not differ. Margins that go on linearly from the first half to the second
/// tell.
struct LateRelease {
  double velocity = 0;       ///< what was held too much after the bounds [m/s or rad/s]
  double ahead = kInfinity;  ///< the shortest time after the end at which a bound will be reached [s]
};
/// @param first, second  of the halves of a time `length` [s]
/// @param nothing  velocity by the end of a time as long that does not matter [m/s]
LateRelease late_release(const std::vector<HoldMargin>& first, const std::vector<HoldMargin>& second,
                         double length, double nothing);

}  // namespace skerry
