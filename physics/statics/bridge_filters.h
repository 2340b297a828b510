// SPDX-License-Identifier: MIT
//
// Which bodies of a bridge meet: members meet the surroundings only, wagons the deck and the surroundings,
// bearings their plates.
#pragma once

#include "physics/world.h"

namespace skerry::statics::filters {

inline constexpr std::uint32_t kWorld = 1, kMember = 2, kWagon = 4, kDeck = 8, kBearing = 16;
inline constexpr double kLightest = 1;        ///< [kg] of a body whose members have no density
inline constexpr double kBearingLift = 0.15;  ///< from the lower side of a member to its bearing plate [m]

inline ShapeDef plain(Shape shape, std::uint32_t category, std::uint32_t mask) {
  ShapeDef def;
  def.shape = std::move(shape);
  def.filter.category = category;
  def.filter.mask = mask;
  return def;
}

}  // namespace skerry::statics::filters
