// SPDX-License-Identifier: MIT
//
// When will a joint of an island reach a limit, or a rope become taut? And which rows of joints hold what is
// at their bound?
#pragma once

#include <cstdint>
#include <optional>

#include "physics/narrowphase/time_of_impact.h"
#include "physics/world_state.h"

namespace skerry {

/// True if a joint may become taut or reach a limit.
bool has_limits(const JointDef& def);

/// Notes whether a motor without a largest force has come to a limit of its coordinate, which it drives
/// against no longer: it would contradict it. Others never stall.
/// @param elapsed  since the beginning of the step [s]
void note_stall(const WorldState& state, JointRecord& joint, double elapsed);

/// The limits of a joint that take part in the forces (bit k: row k of `joint_rows`): those that are reached
/// and not being left, or exceeded.
/// @param elapsed  since the beginning of the step [s]
std::uint8_t reached_limits(const WorldState& state, const JointRecord& joint, double elapsed);

/// First time in (0, h] at which a limit that is not among `reached` is reached, if one is.
/// @param a, b  motions of the two bodies; the ground rests where it is
std::optional<double> next_limit_time(const WorldState& state, const JointRecord& joint, const Motion& a,
                                      const Motion& b, std::uint8_t reached, double h);

/// Rows of a joint that hold what they are at (bit k: row k): limits that push, and motors that need less
/// than their largest force. These were at their speed, or get to it where the piece is not cut.
/// @param elapsed  since the beginning of the step, where the piece begins [s]
/// @param reached  limits that take part in its forces
/// @param whole    the piece is not cut
std::uint8_t held_rows_of(const WorldState& state, const JointRecord& joint, double elapsed,
                          std::uint8_t reached, bool whole);

/// Whether an island has motors.
bool has_motors(const WorldState& state, const Island& island);
/// Motors that pushed as hard as they can and are past their speed after a piece of a step hold it, as others
/// at their speed do (`WorldState::held_rows`): at its end, before the projection, what they drive is slower.
/// @param elapsed  since the beginning of the step [s]
/// @return whether a motor holds its speed
bool hold_passed_motors(WorldState& state, const Island& island, double elapsed);

}  // namespace skerry
