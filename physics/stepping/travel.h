// SPDX-License-Identifier: MIT
//
// How far bodies go within a step, and how far they leave the way of free flight: what tells afterwards
// whether a pair that was left out can have met (world_reach.cpp).
#pragma once

#include <array>
#include <cstdint>

#include "physics/world_state.h"

namespace skerry {

/// Ballistic flight in closed form: exact for constant acceleration. @param from  since the beginning of the
/// step [s]
void fly(WorldState& state, std::uint32_t body, double from, double h);

/// How far a shift moves any point of a body [m].
double length_of_shift(const WorldState& state, std::uint32_t body, const std::array<double, 3>& shift);

/// Largest speed [m/s] at which a body with velocity `v` leaves its way. @param time  since the beginning of
/// the step [s]
double speed_astray(const WorldState& state, std::uint32_t body, const std::array<double, 3>& v, double time);

/// Notes how far a body went within `t` [s], and how far from free flight, as its velocity changed evenly
/// between these two. @param from  since the beginning of the step [s]
void note_travel(WorldState& state, std::uint32_t body, double from, double t,
                 const std::array<double, 3>& before, const std::array<double, 3>& after);

/// The same for a shift without a time.
void note_shift(WorldState& state, std::uint32_t body, const std::array<double, 3>& shift);

/// Notes a way [m], or one away from free flight, of a body in an island in one piece.
/// @param in_flow  what goes a little beyond its bound is taken for what keeps it: the next step finds what
/// it met
void note_way(WorldState& state, std::uint32_t body, double way, bool in_flow);
void note_way_astray(WorldState& state, std::uint32_t body, double way, bool in_flow);

/// Moves and turns a body.
void shift_body(WorldState& state, std::uint32_t body, const std::array<double, 3>& shift);

/// The body went farther than its reach, or a fast one farther from its way than its allowance: what it
/// can have met is not known, and the world looks again.
bool left_its_reach(const WorldState& state, std::uint32_t body);

/// How much farther [m] a body may get in flow, so that the next step finds what it ran into: even two such
/// bodies do not pass through each other, or one through a thin wall.
double overrun(const WorldState& state, std::uint32_t body);
/// What of that is left to the next step, so that this one need not be made again.
double little_overrun(const WorldState& state, std::uint32_t body);

}  // namespace skerry
