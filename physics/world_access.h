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

/// "body 3 'wheel'", for messages.
std::string body_label(const WorldState& s, std::uint32_t body);

/// Whatever the user changes at a body wakes its island, and those that lean on it.
void touch(WorldState& s, std::uint32_t body);
/// The same, and what the body's shapes meet is found anew, wherever they lie: another filter, or a joint
/// that came or went, says otherwise.
void touch_pairs(WorldState& s, std::uint32_t body);
/// Forgets what is known of awake islands at rest; those that were are stepped again.
void forget_resting(WorldState& s);
/// As `touch`, and what is known of islands at rest is forgotten: it holds for the old surfaces and joints.
void touch_definition(WorldState& s, std::uint32_t body);
/// As `touch`, and joints that are off by then take along what they hold before anything moves.
void displace(WorldState& s, std::uint32_t body);
/// As `touch`, and queries look at the body's shapes themselves until the next step gives them boxes.
void make_loose(WorldState& s, std::uint32_t body);

/// Gives the contact of two shapes the friction, restitution, rolling resistance and surface velocity of
/// both.
void mix_materials(Contact& contact, const ShapeRecord& a, const ShapeRecord& b);

void remove_joint(WorldState& s, std::uint32_t joint);

}  // namespace skerry
