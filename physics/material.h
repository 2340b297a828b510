// SPDX-License-Identifier: MIT
//
// What a surface does when another one touches it, and how two surfaces' numbers become those of their
// contact.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

namespace skerry {

struct Material {
  double friction = 0.5;          ///< Coulomb coefficient mu >= 0 of sliding [1]
  double restitution = 0;         ///< e, 0 (plastic) to 1 (elastic) [1]
  double rolling_resistance = 0;  ///< arm of the rolling couple, >= 0 [m]
  double surface_velocity =
      0;  ///< conveyor speed along the surface, counter-clockwise around the shape [m/s]
  /// Coefficient while nothing slides, at least `friction` [1]; default: the same.
  std::optional<double> static_friction{};
};

/// How the two values of a pair become one. When the shapes differ in their rule the larger enumerator wins.
enum class MixingRule : std::uint8_t { Average, GeometricMean, Minimum, Maximum };

inline double mix(MixingRule rule, double a, double b) {
  switch (rule) {
    case MixingRule::Average:
      return 0.5 * (a + b);
    case MixingRule::GeometricMean:
      return std::sqrt(a * b);
    case MixingRule::Minimum:
      return std::min(a, b);
    default:
      return std::max(a, b);
  }
}

/// Category bits and the categories that a shape meets; a pair is considered when each is in the other's
/// mask.
struct Filter {
  std::uint32_t category = 1;
  std::uint32_t mask = 0xffffffffu;
  std::int32_t group = 0;  ///< same positive group: always, same negative group: never, whatever the masks

  friend bool operator==(const Filter&, const Filter&) = default;
};

constexpr bool may_collide(const Filter& a, const Filter& b) {
  if (a.group != 0 && a.group == b.group) return a.group > 0;
  return (a.category & b.mask) != 0 && (b.category & a.mask) != 0;
}

}  // namespace skerry
