// SPDX-License-Identifier: MIT
//
// What the public calls of a World share: checks of their arguments, handles to slots, and the note that a
// body was changed. Not for users.
#pragma once

#include <string>

#include "physics/world_state.h"

namespace skerry {

/// @throws std::invalid_argument with `message` unless the condition holds.
void require(bool condition, const std::string& message);
/// @throws std::invalid_argument "WHAT must be ..., got VALUE".
void require_finite(double value, const char* what);
void require_finite(Vec2 value, const char* what);
void require_at_least_zero(double value, const char* what);

/// The slot of what a handle names. @throws std::invalid_argument if it does not exist (any more)
std::uint32_t slot(const WorldState& s, BodyId id);
std::uint32_t slot(const WorldState& s, ShapeId id);
std::uint32_t slot(const WorldState& s, JointId id);

/// Whatever the user changes at a body wakes its island, and those that lean on it.
void touch(WorldState& s, std::uint32_t body);
/// The same, and queries look at the body's shapes themselves until the next step gives them boxes.
void make_loose(WorldState& s, std::uint32_t body);

void remove_joint(WorldState& s, std::uint32_t joint);

}  // namespace skerry
