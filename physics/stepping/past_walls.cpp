// SPDX-License-Identifier: MIT
#include "physics/stepping/past_walls.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "physics/narrowphase/queries.h"
#include "physics/stepping/chain_side.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/touching.h"
#include "physics/stepping/travel.h"

namespace skerry {
namespace {

// What went less far than this share of its half width went through nothing; cosines of the angle to its way
// of what points along it, and between normals of one side.
constexpr double kLeastWay = 0.5, kAlongTheWay = 0.5, kSameSide = 0.9;

/// Whether the shortest way out of a wall from a point in it goes along a straight way or back, or through
/// the face by which it came: what is no deeper than its own half width and has it to the side passes there.
bool is_in_the_way(const Shape& wall, Vec2 point, Vec2 way, Vec2 face, double half_width) {
  const ClosestPoint nearest = closest_point(wall, {}, point);
  return nearest.distance < -half_width || std::abs(dot(nearest.normal, face)) > kSameSide ||
         std::abs(dot(nearest.normal, way)) > kAlongTheWay * length(way);
}

/// A shape that moves, and a wall.
struct Passage {
  const Shape &wall, &shape;
  Transform wall_before, wall_now, before, now;  ///< poses of their bodies

  /// The shift that brings the shape before the wall again, into which its middle went, world frame [m]; 0
  /// where it did not.
  Vec2 way_back() const {
    const double own = half_width(shape);
    const Vec2 middle = middle_of(shape);
    const Vec2 from = to_local(wall_before, to_world(before, middle)),
               to = to_local(wall_now, to_world(now, middle)), way = to - from;
    const double square = length_squared(way);
    if (!(square > kLeastWay * kLeastWay * own * own && square < kInfinity)) return {};
    const std::optional<RayHit> in = ray_cast(wall, {}, {from, way, 1});
    if (!in || in->t == 0) return {};
    Vec2 deepest = to;
    if (!contains(wall, {}, to)) {
      const std::optional<RayHit> out = ray_cast(wall, {}, {to, -way, 1});
      if (!out) return {};
      deepest = 0.5 * (in->point + out->point);
    }
    if (!is_in_the_way(wall, deepest, way, in->normal, own)) return {};
    // As high over the face as its lowest corner wants.
    const Vec2 normal = rotate(wall_now.q, in->normal);
    double low = kInfinity;
    for (const Vec2 corner : shape.vertices) low = std::min(low, dot(normal, rotate(now.q, corner - middle)));
    return rotate(wall_now.q, in->point - to) + (shape.radius - low) * normal;
  }
};

}  // namespace

bool may_pass_walls(const WorldState& state, std::uint32_t body, double way) {
  return way > kLeastWay * state.thickness[body];
}

void put_before_walls(WorldState& state, const Island& island, std::span<const Transform> start, double from,
                      double to, IslandResult& result) {
  bool any = false;
  for (const std::uint32_t index : island.contacts) {
    const Contact& contact = state.contacts[index];
    const bool a_moves = state.local_index[contact.body_a] >= 0;
    if (a_moves == (state.local_index[contact.body_b] >= 0)) continue;
    const std::uint32_t body = a_moves ? contact.body_a : contact.body_b,
                        ground = a_moves ? contact.body_b : contact.body_a;
    const Shape& wall = state.shapes[a_moves ? contact.shape_b : contact.shape_a].shape;
    const Shape& shape = state.shapes[a_moves ? contact.shape_a : contact.shape_b].shape;
    if (!is_hull(wall) || !is_hull(shape)) continue;
    const Passage passage{wall,
                          shape,
                          pose_at(state, ground, from),
                          pose_at(state, ground, to),
                          start[static_cast<std::size_t>(state.local_index[body])],
                          state.bodies.pose(body)};
    const Vec2 back = passage.way_back();
    if (back == Vec2{}) continue;
    const double way = length(back);
    shift_body(state, body, std::array<double, 3>{back.x, back.y, 0});
    note_way(state, body, way, result.report.flowing);
    note_way_astray(state, body, way, result.report.flowing);
    any = true;
  }
  if (any) result.manifolds_reused += update_manifolds(state, island, to, result.narrow);
}

}  // namespace skerry
