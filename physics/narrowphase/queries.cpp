// SPDX-License-Identifier: MIT
#include "physics/narrowphase/queries.h"

#include <stdexcept>

#include "physics/narrowphase/chain.h"
#include "physics/narrowphase/chain_segment.h"
#include "physics/narrowphase/hull.h"
#include "physics/narrowphase/time_of_impact.h"

namespace skerry {
namespace {

using narrow::Hull;
using narrow::Segment;

constexpr double kNoMargin = 1.0e100;

/// Closest points of two cores that `meet` takes in this order; coordinates of `frame`, which is a's pose.
ClosestPoints closest(const Hull& a, const Hull& b, const Transform& frame, const Transform& relative) {
  Manifold m;
  narrow::Output world{m, frame, false, {}};
  narrow::meet(a, b, relative, kNoMargin, nullptr, nullptr, world);
  ClosestPoints out;
  out.distance = kInfinity;
  out.normal = m.normal;
  for (int i = 0; i < m.count; ++i) {
    const ManifoldPoint& point = m.points[static_cast<std::size_t>(i)];
    if (!(point.separation < out.distance)) continue;
    out.distance = point.separation;
    const Vec2 half = (0.5 * out.distance) * m.normal;
    out.point_a = point.position - half;
    out.point_b = point.position + half;
  }
  return out;
}

ClosestPoints exchanged(ClosestPoints c) {
  std::swap(c.point_a, c.point_b);
  c.normal = -c.normal;
  return c;
}

/// Of a core and another hull, in any order of kinds.
ClosestPoints closest_of(const Hull& a, const Transform& pose_a, const Hull& b, const Transform& pose_b) {
  if (narrow::rank_of(a.kind) < narrow::rank_of(b.kind)) {
    return exchanged(closest(b, a, pose_b, narrow::relative_pose(pose_b, pose_a)));
  }
  return closest(a, b, pose_a, narrow::relative_pose(pose_a, pose_b));
}

ClosestPoints closest_to_chain(const Shape& chain, const Transform& pose_chain, const Hull& other,
                               const Transform& pose_other) {
  ClosestPoints best;
  best.distance = kInfinity;
  for (int i = 0; i < chain_segment_count(chain); ++i) {
    // Coordinates from the segment's start: a long chain is as exact as a short one.
    const Vec2 start = chain.vertices[static_cast<std::size_t>(i)];
    const Segment segment(chain, i, start);
    Transform relative = narrow::relative_pose(pose_chain, pose_other);
    relative.p -= start;
    const Transform frame{to_world(pose_chain, start), pose_chain.q};
    const ClosestPoints c = closest(segment.hull(), other, frame, relative);
    if (c.distance < best.distance) best = c;
  }
  return best;
}

Hull point_hull(const Vec2* point) {
  return {ShapeKind::Disc, point, nullptr, 1, 0};
}

/// A hit in the shape's frame; `t` infinite: none.
struct LocalHit {
  double t = kInfinity;
  Vec2 normal;
};

/// Ray against a circle; the square of the half chord is a product of a sum and a difference, so nothing
/// cancels for grazing rays.
void hit_circle(Vec2 origin, Vec2 direction, Vec2 centre, double radius, LocalHit& best) {
  const Vec2 m = origin - centre;
  const double along = dot(m, direction);
  if (along >= 0) return;
  const double speed = length(direction), miss = std::abs(cross(m, direction));
  if (miss > speed * radius) return;
  const double chord = std::sqrt((speed * radius - miss) * (speed * radius + miss));
  const double distance = length(m);
  const double t = (distance - radius) * (distance + radius) / (chord - along);
  if (!(t >= 0 && t < best.t)) return;
  best.t = t;
  best.normal = (m + t * direction) / radius;
}

/// Clips the ray with the half-planes of all edges [Cyrus, Beck 1978].
LocalHit hit_sharp_polygon(const Hull& hull, Vec2 origin, Vec2 direction) {
  LocalHit hit;
  double enter = 0, leave = kInfinity;
  int edge = -1;
  for (int i = 0; i < hull.count; ++i) {
    const double height = dot(hull.n[i], origin - hull.v[i]), rate = dot(hull.n[i], direction);
    // The ray is behind the line where height + rate t <= 0.
    if (rate < 0) {
      if (height > -rate * enter) {
        enter = height / -rate;
        edge = i;
      }
    } else if (rate > 0) {
      if (height > -rate * leave) leave = -height / rate;
    } else if (height > 0) {
      return hit;
    }
    if (leave < enter) return hit;
  }
  hit.t = enter;
  hit.normal = edge >= 0 ? hull.n[edge] : -direction / length(direction);
  return hit;
}

LocalHit hit_round_hull(const Hull& hull, Vec2 origin, Vec2 direction) {
  LocalHit best;
  const Transform at_origin;
  const ClosestPoints start = closest_of(hull, at_origin, point_hull(&origin), at_origin);
  if (start.distance <= 0) return {0, -direction / length(direction)};
  for (int i = 0; i < hull.count; ++i) {
    hit_circle(origin, direction, hull.v[i], hull.radius, best);
    if (hull.count < 2) continue;
    const Vec2 n = hull.n[i];
    const double rate = dot(n, direction), height = dot(n, origin - hull.v[i]) - hull.radius;
    if (!(rate < 0 && height >= 0)) continue;
    const double t = height / -rate;
    const Vec2 at = origin + t * direction - hull.v[i];
    const Vec2 tangent = perp(n);
    const double x = dot(tangent, at);
    if (x < 0 || x > dot(tangent, hull.v[i + 1 < hull.count ? i + 1 : 0] - hull.v[i]) || !(t < best.t))
      continue;
    best = {t, n};
  }
  return best;
}

LocalHit hit_disc(const Hull& hull, Vec2 origin, Vec2 direction) {
  const Vec2 m = origin - hull.v[0];
  if (length_squared(m) <= hull.radius * hull.radius) return {0, -direction / length(direction)};
  LocalHit best;
  hit_circle(origin, direction, hull.v[0], hull.radius, best);
  return best;
}

LocalHit hit_chain(const Shape& chain, Vec2 origin, Vec2 direction) {
  LocalHit best;
  const std::size_t corners = chain.vertices.size();
  for (std::size_t i = 0; i < chain.normals.size(); ++i) {
    const Vec2 p = chain.vertices[i], q = chain.vertices[i + 1 < corners ? i + 1 : 0], n = chain.normals[i];
    const double rate = dot(n, direction), height = dot(n, origin - p);
    if (!(rate < 0 && height >= 0)) continue;
    const double t = height / -rate;
    if (!(t < best.t)) continue;
    // The sides of the ray's line on which the ends lie; a ray through a shared corner hits at least one.
    const double side_p = cross(direction, p - origin), side_q = cross(direction, q - origin);
    if ((side_p > 0 && side_q > 0) || (side_p < 0 && side_q < 0)) continue;
    best = {t, n};
  }
  return best;
}

void require_pair(const Shape& a, const Shape& b, const char* what) {
  const bool plane_a = a.kind == ShapeKind::HalfPlane, plane_b = b.kind == ShapeKind::HalfPlane;
  const bool chain_a = a.kind == ShapeKind::Chain, chain_b = b.kind == ShapeKind::Chain;
  if ((plane_a || chain_a) && (plane_b || chain_b)) {
    throw std::invalid_argument(
        std::string(what).append(": one of the shapes must be a disc, capsule or polygon"));
  }
}

}  // namespace

ClosestPoints distance(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b) {
  require_pair(a, b, "distance");
  if (a.kind == ShapeKind::Chain) return closest_to_chain(a, pose_a, narrow::hull_of(b), pose_b);
  if (b.kind == ShapeKind::Chain) return exchanged(closest_to_chain(b, pose_b, narrow::hull_of(a), pose_a));
  return closest_of(narrow::hull_of(a), pose_a, narrow::hull_of(b), pose_b);
}

bool overlaps(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b) {
  return distance(a, pose_a, b, pose_b).distance <= 0;
}

ClosestPoint closest_point(const Shape& shape, const Transform& pose, Vec2 point) {
  const Transform at_point{point, {}};
  const Vec2 own;
  const ClosestPoints c = shape.kind == ShapeKind::Chain
                              ? closest_to_chain(shape, pose, point_hull(&own), at_point)
                              : closest_of(narrow::hull_of(shape), pose, point_hull(&own), at_point);
  return {c.point_a, c.normal, c.distance};
}

bool contains(const Shape& shape, const Transform& pose, Vec2 point) {
  return closest_point(shape, pose, point).distance <= 0;
}

std::optional<RayHit> ray_cast(const Shape& shape, const Transform& pose, const Ray& ray) {
  if (!is_finite(ray.origin) || !is_finite(ray.direction) || !(length_squared(ray.direction) > 0) ||
      !(ray.t_max >= 0)) {
    throw std::invalid_argument("ray_cast: the ray must be finite, its direction not zero and t_max >= 0");
  }
  const Vec2 origin = to_local(pose, ray.origin), direction = inverse_rotate(pose.q, ray.direction);
  const Hull hull = narrow::hull_of(shape);
  LocalHit hit;
  switch (shape.kind) {
    case ShapeKind::Disc:
      hit = hit_disc(hull, origin, direction);
      break;
    case ShapeKind::HalfPlane: {
      const double rate = dot(hull.n[0], direction), height = dot(hull.n[0], origin - hull.v[0]);
      if (height <= 0) {
        hit = {0, -direction / length(direction)};
      } else if (rate < 0) {
        hit = {height / -rate, hull.n[0]};
      }
      break;
    }
    case ShapeKind::Chain:
      hit = hit_chain(shape, origin, direction);
      break;
    default:
      hit = hull.radius == 0 ? hit_sharp_polygon(hull, origin, direction)
                             : hit_round_hull(hull, origin, direction);
  }
  if (!(hit.t <= ray.t_max)) return std::nullopt;
  return RayHit{hit.t, ray.origin + hit.t * ray.direction, rotate(pose.q, hit.normal)};
}

std::optional<RayHit> shape_cast(const Shape& moving, const Transform& pose_moving, Vec2 translation,
                                 const Shape& target, const Transform& pose_target) {
  require_pair(moving, target, "shape_cast");
  const ClosestPoints start = distance(target, pose_target, moving, pose_moving);
  if (start.distance <= 0) return RayHit{0, start.point_a, start.normal};
  const auto motion = [](const Transform& pose, Vec2 v) {
    Motion m;
    m.p0 = pose.p;
    m.angle0 = std::atan2(pose.q.s, pose.q.c);
    m.v = v;
    return m;
  };
  const ImpactTime impact =
      time_of_impact(target, motion(pose_target, {}), moving, motion(pose_moving, translation), 1);
  if (!impact.hit) return std::nullopt;
  const ClosestPoints touch =
      distance(target, pose_target, moving, {pose_moving.p + impact.t * translation, pose_moving.q});
  return RayHit{impact.t, touch.point_a, touch.normal};
}

}  // namespace skerry
