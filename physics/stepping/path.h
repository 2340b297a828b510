// SPDX-License-Identifier: MIT
//
// The motion of bodies within a step, as polynomials of time.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "physics/math.h"

namespace skerry {

/// One body's motion from one moment of a step to another without a jump in its velocity:
///
///   q(theta) = c0 + theta (c1 + (1 - theta) (c2 + theta (c3 + ...))),   theta = (t - begin) / length,
///
/// for x, y and the angle. This is the form of the continuous output of Dormand and Prince [Hairer, Norsett &
/// Wanner 1993, sec. II.6]; its first four terms are the Hermite cubic.
struct PathPiece {
  std::uint32_t body = 0;
  std::uint32_t generation = 0;
  double begin = 0;   ///< since the beginning of the step [s]
  double length = 0;  ///< for which theta goes from 0 to 1 [s]; an event may end the piece earlier
  std::array<std::array<double, 8>, 3> c{};

  /// Values and rates of x, y and the angle. @param t  since the beginning of the step [s]
  void at(double t, std::array<double, 3>& value, std::array<double, 3>& rate) const;
};

/// Position and velocity at one end of a piece: (x, y, angle) and rates.
struct PathEnd {
  std::array<double, 3> q{}, v{};
};

/// The cubic through both ends; a parabola if the acceleration is constant.
PathPiece hermite_piece(std::uint32_t body, std::uint32_t generation, double begin, double length,
                        const PathEnd& from, const PathEnd& to);

struct WorldState;
struct IslandResult;

/// The present ends of all bodies of an island, in its order.
std::vector<PathEnd> path_ends(const WorldState& state, const std::vector<std::uint32_t>& bodies);
/// Adds the cubics from `from` to the present state. @param begin, length  as in PathPiece
void record_hermite(const WorldState& state, const std::vector<std::uint32_t>& bodies, double begin,
                    double length, const std::vector<PathEnd>& from, IslandResult& result);
/// Bends the last pieces of these bodies, one of each at the end of the list and in the same order, so that
/// they end at `t` where the bodies are: a projection moved them.
void end_paths_here(const WorldState& state, const std::vector<std::uint32_t>& bodies, double t,
                    IslandResult& result);

}  // namespace skerry
