// SPDX-License-Identifier: MIT
//
// When will two shapes of an island touch next?
#pragma once

#include <cstdint>

#include "physics/narrowphase/time_of_impact.h"
#include "physics/stepping/one_piece_rule.h"
#include "physics/world_state.h"

namespace skerry {

/// What a contact does within a piece of a step.
struct NextContact {
  double t = 0;  ///< first time in (0, h] at which a free point comes down; `h` if none does
  bool sinks =
      false;  ///< a point that touches goes down without having opened: it must take part in the solve
};

/// True if the points of a contact that rest (bit i: point i of the present manifold) are all that it can
/// have: nothing else can come down.
inline bool rests_wholly(const WorldState& state, const Contact& contact, std::uint8_t resting) {
  return resting != 0 &&
         meet_at_one_point(state.shapes[contact.shape_a].shape, state.shapes[contact.shape_b].shape);
}

/// Segments of a chain beside that of a contact, -1 for none, on which nothing of the other shape rests.
struct FreeSegments {
  int previous = -1, next = -1;
};

/// Looks at the points of the contact that are not in `resting` (bit i: point i of the present manifold).
/// @param beside  what turns over a ridge while a point of the contact rests is theirs in the end
/// @param gaps  what neither leaves nor lands
NextContact next_contact_time(const WorldState& state, std::uint32_t contact, const Motion& a,
                              const Motion& b, std::uint8_t resting, double h, FreeSegments beside,
                              const SmallGaps& gaps);

}  // namespace skerry
