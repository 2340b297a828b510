// SPDX-License-Identifier: MIT
//
// Steps in which a prescribed motion has a kink or a jump: they are made in parts, each with a ground that
// moves smoothly. Where the next one begins contacts find that the ground has another velocity, or is
// elsewhere, as at the beginning of a step: a kink is an impact where it approaches.
#pragma once

#include <vector>

#include "physics/stepping/one_piece_rule.h"

namespace skerry {

/// A time of a step without breaks, since its beginning [s].
struct SmoothSpan {
  double from, to;
};

/// The times of a step of the length `h` [s] between the breaks of what an island may meet and moves as
/// prescribed; none where there are no breaks. Between two of them is next to no time, so that each has
/// velocities of its own at its ends.
std::vector<SmoothSpan> smooth_spans(const WorldState& state, const Island& island, double h);

/// Whether a span begins there: then velocities may be other ones than joints allow, and bodies in others.
bool begins_span(const WorldState& state, const Island& island, double elapsed);

/// What is to be done where a span begins that is not the first: what jumped takes along what is joined to
/// it, whose motion that does not change, and manifolds are those of the ground there.
void begin_span(WorldState& state, const Island& island, const SmoothSpan& span, IslandResult& result);

enum class StepEnd { Beginning, End };

/// The same for a body that jumps where the step of the length `h` [s] begins or ends, which is not a break,
/// and for what the user put away from its joints before the step, unless it flows.
void follow_jump(WorldState& state, const Island& island, StepEnd where, double h, IslandResult& result);

/// A step of time_stepping with breaks. @return false, and nothing has happened, where there are none
bool step_over_breaks(WorldState& state, const Island& island, const OnePieceRule& rule, double h,
                      IslandResult& result);

}  // namespace skerry
