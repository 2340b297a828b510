// SPDX-License-Identifier: MIT
//
// Faces along which two bodies pass each other, in place of that of their nearest points.
#pragma once

#include <algorithm>

#include "physics/world_state.h"

namespace skerry {

// Cosine of the angle between normals of one face.
constexpr double kSameFace = 1 - 1e-9;

/// How high the lowest corner of `other` is over a face of a shape, without radii [m].
/// @param outwards  normal of that face, world frame
inline double height_over(const Shape& shape, std::size_t edge, const Transform& of_shape, const Shape& other,
                          const Transform& of_other, Vec2 outwards) {
  const Vec2 foot = to_world(of_shape, shape.vertices[edge]);
  double low = kInfinity;
  for (const Vec2 corner : other.vertices)
    low = std::min(low, dot(outwards, to_world(of_other, corner) - foot));
  return low;
}

/// The contact has one point, with another normal, from now on.
inline void take_face(Contact& contact, Vec2 normal, double separation) {
  contact.manifold.normal = normal;
  contact.manifold.count = 1;
  contact.manifold.points[0].separation = separation;
  match_points(contact);
  forget_poses(contact);
}

}  // namespace skerry
