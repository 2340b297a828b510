// SPDX-License-Identifier: MIT
//
// Where faces of two bodies lie in one plane, as the tops of two floor tiles do, what slides from one to the
// other meets the side of the second with a corner. Rounding decides whether it overlaps that side by 1e-13
// m, or not; nothing that overlaps by less than counts as a touch is in the way.
#pragma once

#include "physics/narrowphase/time_of_impact.h"
#include "physics/world_state.h"

namespace skerry {

/// A contact that touches along one face and approaches there, but overlaps it by no more than the touch
/// tolerance, and slides along another face that says so, touches along that one from now on. One that parts
/// there instead is let go of: what it carried it carried along the other face.
/// @return whether the contact has another face now
bool pass_flush_face(const WorldState& state, Contact& contact, double elapsed);

/// The same for all of an island. @return whether there was one
bool pass_flush_faces(WorldState& state, const Island& island, double elapsed);

/// When a contact closes that does not touch now, or opens first: `contact_impact_time` without what only
/// passes a flush face.
ImpactTime landing_time(const WorldState& state, const Contact& contact, const Motion& a, const Motion& b,
                        double h);

}  // namespace skerry
