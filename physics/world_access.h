// SPDX-License-Identifier: MIT
//
// What the public calls of a World share: checks of their arguments, handles to slots, and the note that a
// body was changed. Not for users.
#pragma once

#include <concepts>
#include <string>

#include "physics/text.h"
#include "physics/world_state.h"

namespace skerry {

/// Part of a message.
inline std::string to_part(const char* text) {
  return text;
}
std::string to_part(std::integral auto value) {
  return std::to_string(value);
}
inline std::string to_part(double value) {
  return to_text(value);
}
inline std::string to_part(Vec2 value) {
  return to_text(value);
}

[[noreturn]] void refuse(const std::string& message);

/// Unless the condition holds. The message is put together then only: these checks stand before every getter.
/// @throws std::invalid_argument with `message`, one part after the other
template <class... Parts>
void require(bool condition, const Parts&... message) {
  if (!condition) [[unlikely]]
    refuse((to_part(message) + ...));
}
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
