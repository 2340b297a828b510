// SPDX-License-Identifier: MIT
//
// What a user does to a world between steps, as data: it can be kept, applied again and written to a file.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "physics/archive.h"
#include "physics/world.h"

namespace skerry::sandbox {

enum class InputKind : std::uint8_t {
  Grab,     ///< takes hold of `body` at `at`
  Drag,     ///< moves the hand to `at`
  Release,  ///< lets go
  Spawn,    ///< makes a body of the kind `what` and size `size` at `at`
  Remove,   ///< destroys `body`
  Methods,  ///< from now on `what` = {solver, stepper, broad phase, impact law}
  Hold,     ///< makes `body` static where it is, or dynamic again
};

enum class SpawnKind : std::uint8_t { Disc, Box, Capsule, Hexagon };
inline constexpr int kSpawnKinds = 4;
std::string_view to_string(SpawnKind kind);

struct UserInput {
  std::uint64_t step = 0;  ///< number of steps done when it happened
  InputKind kind = InputKind::Grab;
  BodyId body{};
  Vec2 at{};  ///< world frame [m]
  SpawnKind spawn = SpawnKind::Disc;
  double size = 0;  ///< radius or half the edge [m]
  std::vector<std::string> methods{};

  friend bool operator==(const UserInput&, const UserInput&) = default;
};
void fields(Archive& archive, UserInput& input);

/// The user's hand: a spring of 4 Hz, critically damped, from a point of a body to the pointer. What it pulls
/// is the inertia of the body at that point, so it feels the same for a pebble and a millstone, and it
/// carries the body's weight. It is strong but not infinitely so: contacts and joints hold against it.
class Hand {
 public:
  bool holds() const { return static_cast<bool>(body_); }
  BodyId body() const { return body_; }
  Vec2 target() const { return target_; }
  /// Where it holds the body, world frame. @pre holds and the body is alive
  Vec2 grip(const World& world) const;

  void grab(const World& world, BodyId body, Vec2 at);
  void move(Vec2 target) { target_ = target; }
  void release() { body_ = {}; }
  /// Applies the force for a step of length `h`. Lets go of a body that is no more.
  void pull(World& world, double h);

 private:
  BodyId body_{};
  Vec2 local_, target_;
};

/// Does to the world what the input says; bodies that are no more are left alone.
/// @param material of bodies that are made
void apply_input(const UserInput& input, const Material& material, World& world, Hand& hand);

/// Whether a user can take the body: a dynamic one, or one that is held fast by one of these inputs.
bool is_loose(const World& world, BodyId body, std::span<const UserInput> inputs);

/// The topmost loose body at `point`, or none. Shapes within `slack` [m] count, so that small ones can be
/// picked.
BodyId pick_body(const World& world, Vec2 point, double slack, std::span<const UserInput> inputs = {});

}  // namespace skerry::sandbox
