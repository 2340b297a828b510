// SPDX-License-Identifier: MIT
//
// The motion within the last step.
#include <algorithm>
#include <stdexcept>

#include "physics/text.h"
#include "physics/world_state.h"

namespace skerry {

BodyState World::interpolated(BodyId id, double time) const {
  const WorldState& s = *state_;
  const Vec2 position = World::position(id);  // refuses ids that do not exist
  const std::uint32_t i = id.index;
  const BodyState now{position, s.bodies.angle[i], s.bodies.velocity[i], s.bodies.omega[i]};
  if (time == s.time) return now;
  const double elapsed = time - (s.time - s.report.h);
  // A rounding error outside the step is its end.
  const double slack = 1e-12 * std::max(s.time, s.report.h);
  if (!(elapsed >= -slack && time <= s.time + slack)) {
    throw std::invalid_argument("interpolated: time must be within the last step, from " +
                                to_text(s.time - s.report.h) + " to " + to_text(s.time) + " s, got " +
                                to_text(time));
  }
  if (!s.paths_known)
    throw std::invalid_argument(
        "interpolated: observe paths before the step, World::observe({.paths = true})");
  if (time > s.time) return now;

  // The last piece that begins by then.
  const auto later = std::upper_bound(s.step_paths.begin(), s.step_paths.end(), std::pair(i, elapsed),
                                      [](const std::pair<std::uint32_t, double>& at, const PathPiece& piece) {
                                        return at < std::pair(piece.body, piece.begin);
                                      });
  // Without a path the body rested, or was made after the step.
  const bool before_first = later == s.step_paths.begin() || std::prev(later)->body != i;
  const auto piece = before_first ? later : std::prev(later);
  if (piece == s.step_paths.end() || piece->body != i || piece->generation != id.generation) return now;
  std::array<double, 3> q{}, v{};
  piece->at(std::max(elapsed, piece->begin), q, v);
  return {{q[0], q[1]}, q[2], {v[0], v[1]}, v[2]};
}

}  // namespace skerry
