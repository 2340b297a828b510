// SPDX-License-Identifier: MIT
//
// Rows of a world at rest, for `RestSolver`.
#pragma once

#include <array>
#include <vector>

#include "physics/statics/rest.h"

namespace skerry::statics {

/// What belongs to the rows of `RestAnalysis::system`, those of the joints first.
struct RestRows {
  std::vector<std::array<int, 2>> of_joint;  ///< first row, and the one after the last
  std::vector<Vec2> directions;              ///< of joint rows: force on body b for a unit of the row
  std::vector<Vec2> springs;                 ///< force of each joint's spring on body b [N]
  /// Of each body: sums of the magnitudes of its loads, springs among them, and of the springs [N, N m].
  std::vector<std::array<double, 2>> applied, sprung;
  std::vector<double> last_step;  ///< forces of the rows in the world's last step [N]; empty: not known
};

/// Fills bodies, loads, rows (without b), contacts and joints of `out`.
RestRows rest_rows(const World& world, const RestOptions& options, RestAnalysis& out);

}  // namespace skerry::statics
