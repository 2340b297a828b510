// SPDX-License-Identifier: MIT
//
// Bodies: what the caller says of one, and how the world stores all of them (one contiguous array a field).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "physics/handle.h"
#include "physics/math.h"

namespace skerry {

/// Static bodies never move; kinematic ones move as told; dynamic ones obey forces and contacts.
enum class BodyType : std::uint8_t { Static, Kinematic, Dynamic };

struct BodyDef {
  BodyType type = BodyType::Dynamic;
  Vec2 position{};               ///< origin of the frame in which the shapes are given, world frame [m]
  double angle = 0;              ///< [rad], counter-clockwise
  Vec2 velocity{};               ///< of the origin, from which shapes may move the centre of mass [m/s]
  double omega = 0;              ///< [rad/s]
  double gravity_scale = 1;      ///< 0: floats
  std::optional<double> mass{};  ///< [kg]; default: sum over the shapes of density * area
  std::optional<double>
      inertia{};       ///< about the centre of mass [kg m^2]; default: from the shapes, for `mass`
  std::string name{};  ///< for messages and the inspector
};

/// State and mass of all bodies, field by field; index = slot. Read-only for users (`World::bodies()`). Free
/// slots have `alive[i] == 0` and zero inverse mass.
struct BodyArrays {
  std::vector<Vec2> position;        ///< centre of mass, world frame [m]
  std::vector<double> angle;         ///< [rad], not reduced
  std::vector<Rot> rotation;         ///< of `angle`
  std::vector<Vec2> velocity;        ///< [m/s]
  std::vector<double> omega;         ///< [rad/s]
  std::vector<Vec2> force;           ///< applied by the user, cleared by each step [N]
  std::vector<double> torque;        ///< about the centre of mass [N m]
  std::vector<double> mass;          ///< [kg]; 0 for static and kinematic bodies
  std::vector<double> inertia;       ///< about the centre of mass [kg m^2]
  std::vector<double> inverse_mass;  ///< 0: infinite
  std::vector<double> inverse_inertia;
  std::vector<double> gravity_scale;
  std::vector<BodyType> type;
  std::vector<std::uint8_t> alive;
  std::vector<std::uint8_t> asleep;  ///< 1: at rest to the bit and out of the working set (see sleep.h)
  std::vector<std::int32_t> island;  ///< number in the last step, -1: none (static, kinematic, asleep)
  std::vector<std::uint32_t> generation;
  /// Of the slot among those that ever had a dynamic body, in the order in which they first had one; -1:
  /// never. It stays with the slot, so that bodies keep what they are called by it while others go or are
  /// held.
  std::vector<std::int32_t> number;
  std::int32_t numbered = 0;  ///< how many slots have one

  std::size_t size() const { return position.size(); }
  Transform pose(std::size_t i) const { return {position[i], rotation[i]}; }
};

}  // namespace skerry
