// SPDX-License-Identifier: MIT
//
// Questions about single shapes and pairs: distance, overlap, points, rays, swept shapes. Filters and the
// choice among many shapes are the caller's.
//
// A chain is a set of curves without an inside here; rays and swept shapes meet it on its left side only.
#pragma once

#include <optional>

#include "physics/broadphase/broadphase.h"
#include "physics/math.h"
#include "physics/shape.h"

namespace skerry {

/// The closest points of two shapes; where they overlap, the two points that the shortest way apart would
/// bring together.
struct ClosestPoints {
  Vec2 point_a, point_b;  ///< on the surfaces, world frame [m]
  Vec2 normal;            ///< unit vector from a to b
  double distance = 0;    ///< [m], negative: depth of penetration
};

/// @throws std::invalid_argument for two half-planes, or a chain with a half-plane or chain
ClosestPoints distance(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b);

/// True if the shapes have a point in common. @throws as `distance`
bool overlaps(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b);

/// The point of the surface closest to `point`.
struct ClosestPoint {
  Vec2 point;           ///< world frame [m]
  Vec2 normal;          ///< outward unit normal there (from the surface to `point` if that is outside)
  double distance = 0;  ///< [m], negative inside
};

ClosestPoint closest_point(const Shape& shape, const Transform& pose, Vec2 point);

/// True if `point` lies in the shape or on its surface (for a chain: on a segment).
bool contains(const Shape& shape, const Transform& pose, Vec2 point);

/// Where a ray or a swept shape meets a surface.
struct RayHit {
  double t = 0;  ///< parameter: ray.origin + t * ray.direction, or the share of the translation
  Vec2 point;    ///< world frame [m]
  Vec2 normal;   ///< of the surface, unit, against the motion
};

/// First point of the ray (0 <= t <= ray.t_max; a segment is a ray with t_max = 1) that lies in the shape. A
/// ray that starts inside hits at t = 0, with the normal against its direction.
/// @throws std::invalid_argument, with the ray, if the direction is zero, so long or short that its square is
/// no number (`World::ray_cast` takes such), or something is not finite
std::optional<RayHit> ray_cast(const Shape& shape, const Transform& pose, const Ray& ray);

/// Moves `moving` along `translation` without turning it until it touches `target`. A start that overlaps or
/// touches hits at t = 0.
/// @throws std::invalid_argument if a value is not finite, or as `distance`
std::optional<RayHit> shape_cast(const Shape& moving, const Transform& pose_moving, Vec2 translation,
                                 const Shape& target, const Transform& pose_target);

}  // namespace skerry
