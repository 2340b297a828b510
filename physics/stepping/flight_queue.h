// SPDX-License-Identifier: MIT
//
// Islands in which nothing rests: bodies fly by their own clocks from impact to impact, earliest first.
#pragma once

#include "physics/stepping/stepper.h"

namespace skerry {

/// A queue is tried so often in a step: each try goes on until something rests or a body wore out.
inline constexpr int kMostFlights = 8;

/// Follows the impacts of an island in which nothing rests, one after the other: each flight in closed form,
/// each impact by the world's law for the bodies that touch at that moment, each pair foretold again only
/// when one of its bodies was struck [Alder & Wainwright 1959]. An impact costs in proportion to the
/// neighbours of the bodies that take part in it, not to the island, and none has to be left out.
///
/// It ends early where something comes to rest on something else (it touches and does not part, or hops no
/// higher than 16 touch tolerances), or where a body was struck `max_impacts_per_step` times; all bodies are
/// brought to that time. Small islands, and those with overlaps (which are not taken out here), joints or
/// ground that moves as told, are left as they are; so are those on which forces depend on the state where
/// events are noted. Else such forces are those of the middle of the flight that is left after each impact.
///
/// @param from, to     since the beginning of the step [s]; manifolds are those of `from`
/// @param note_events  report landings
/// @return time up to which the island was brought, `from` if nothing was done; manifolds are those of then
double fly_by_queue(WorldState& state, const Island& island, double from, double to, bool note_events,
                    IslandResult& result);

}  // namespace skerry
