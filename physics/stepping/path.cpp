// SPDX-License-Identifier: MIT
#include "physics/stepping/path.h"

#include "physics/world_state.h"

namespace skerry {

void PathPiece::at(double t, std::array<double, 3>& value, std::array<double, 3>& rate) const {
  const double theta = length > 0 ? (t - begin) / length : 1;
  const double rest = 1 - theta;
  for (std::size_t k = 0; k < 3; ++k) {
    // Horner's scheme for the value and its derivative.
    double sum = 0, slope = 0;
    for (std::size_t i = 7; i >= 1; --i) {
      const bool forward = i % 2 == 1;
      slope = forward ? (sum + c[k][i]) + theta * slope : rest * slope - (sum + c[k][i]);
      sum = (sum + c[k][i]) * (forward ? theta : rest);
    }
    value[k] = c[k][0] + sum;
    rate[k] = length > 0 ? slope / length : 0;
  }
}

PathPiece hermite_piece(std::uint32_t body, std::uint32_t generation, double begin, double length,
                        const PathEnd& from, const PathEnd& to) {
  PathPiece piece;
  piece.body = body;
  piece.generation = generation;
  piece.begin = begin;
  piece.length = length;
  for (std::size_t k = 0; k < 3; ++k) {
    const double change = to.q[k] - from.q[k];
    const double bend = length * from.v[k] - change;
    piece.c[k] = {from.q[k], change, bend, change - length * to.v[k] - bend};
  }
  return piece;
}

std::vector<PathEnd> path_ends(const WorldState& state, const std::vector<std::uint32_t>& bodies) {
  const BodyArrays& all = state.bodies;
  std::vector<PathEnd> ends;
  ends.reserve(bodies.size());
  for (const std::uint32_t i : bodies) {
    ends.push_back({{all.position[i].x, all.position[i].y, all.angle[i]},
                    {all.velocity[i].x, all.velocity[i].y, all.omega[i]}});
  }
  return ends;
}

void record_hermite(const WorldState& state, const std::vector<std::uint32_t>& bodies, double begin,
                    double length, const std::vector<PathEnd>& from, IslandResult& result) {
  const std::vector<PathEnd> to = path_ends(state, bodies);
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    result.path.push_back(
        hermite_piece(bodies[k], state.bodies.generation[bodies[k]], begin, length, from[k], to[k]));
  }
}

void end_paths_here(const WorldState& state, const std::vector<std::uint32_t>& bodies, double t,
                    IslandResult& result) {
  const std::vector<PathEnd> to = path_ends(state, bodies);
  for (std::size_t k = 0; k < bodies.size(); ++k) {
    PathPiece& piece = result.path[result.path.size() - bodies.size() + k];
    const double theta = (t - piece.begin) / piece.length;
    if (!(theta > 0)) continue;
    std::array<double, 3> q{}, v{};
    piece.at(t, q, v);
    // 3 s^2 - 2 s^3 with s = t' / theta leaves the rates at both ends alone; shares too small for it get a
    // line.
    const double third = theta > 1e-3 ? -2 / (theta * theta * theta) : 0;
    const double first = theta > 1e-3 ? 3 / (theta * theta) + third : 1 / theta;
    for (std::size_t c = 0; c < 3; ++c) {
      const double change = to[k].q[c] - q[c];
      piece.c[c][1] += first * change;
      if (third == 0) continue;
      piece.c[c][2] -= first * change;
      piece.c[c][3] -= third * change;
    }
  }
}

}  // namespace skerry
