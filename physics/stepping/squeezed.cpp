// SPDX-License-Identifier: MIT
#include "physics/stepping/squeezed.h"

#include <algorithm>
#include <cmath>

#include "physics/spare.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// Overlaps below this [m] are no squeeze; so much of an overlap a body goes aside; sine up to which pushes
// are of one line.
constexpr double kLeast = 1e-6, kAside = 0.1, kInLine = 0.02;

/// What squeezes a body.
struct Squeeze {
  Vec2 line;           ///< of the first push; 0: none yet
  double deepest = 0;  ///< [m]
  bool from_before = false, from_behind = false;
  bool across = false;   ///< something pushes to the side, too
  bool rounded = false;  ///< a step aside turns a normal

  void push(Vec2 direction, double depth, bool corners) {
    if (line == Vec2{}) line = direction;
    (dot(line, direction) > 0 ? from_before : from_behind) = true;
    across |= std::abs(cross(line, direction)) > kInLine;
    rounded |= corners;
    deepest = std::max(deepest, depth);
  }
  bool is_in_line() const { return from_before && from_behind && !across && rounded; }
};

/// Whether two corners meet, or two discs: the normal is the line between them.
bool is_of_corners(const WorldState& state, const RowOrigin& origin) {
  const std::uint32_t feature =
      state.contacts[origin.index].manifold.points[static_cast<std::size_t>(origin.point)].feature;
  return (feature & make_feature(1, 1)) == 0;
}

}  // namespace

bool step_aside(const WorldState& state, const Assembly& assembly, std::vector<Velocity>& shift) {
  Spare<std::vector<Squeeze>> squeezes;
  squeezes->assign(shift.size(), Squeeze{});
  for (std::size_t i = 0; i < assembly.origin.size(); ++i) {
    const RowOrigin& origin = assembly.origin[i];
    const Row& row = assembly.system.rows[i];
    if (origin.joint || row.kind != RowKind::Normal) continue;
    const double left = origin.error + row_velocity(assembly, static_cast<int>(i), shift) - assembly.drive[i];
    if (!(left < -kLeast)) continue;
    const bool corners = is_of_corners(state, origin);
    const Vec2 push = push_on_b(row);
    if (row.b >= 0) (*squeezes)[static_cast<std::size_t>(row.b)].push(push, -left, corners);
    if (row.a >= 0) (*squeezes)[static_cast<std::size_t>(row.a)].push(-push, -left, corners);
  }
  bool any = false;
  for (std::size_t k = 0; k < shift.size(); ++k) {
    const Squeeze& squeeze = (*squeezes)[k];
    if (!squeeze.is_in_line()) continue;
    // One line for all of them, whichever end it was seen from.
    const Vec2 line =
        squeeze.line.x < 0 || (squeeze.line.x == 0 && squeeze.line.y < 0) ? -squeeze.line : squeeze.line;
    const Vec2 aside = ((k % 2 == 0 ? kAside : -kAside) * squeeze.deepest) * perp(line);
    shift[k][0] += aside.x;
    shift[k][1] += aside.y;
    any = true;
  }
  return any;
}

}  // namespace skerry
