// SPDX-License-Identifier: MIT
//
// Inside the narrow phase: disc, capsule and polygon as the convex hull of 1, 2 or n points (the core), grown
// by a radius; and the search for the axis of least penetration of two cores.
//
// Everything is computed in the frame of the first core, from the difference of the two positions, so that a
// pair far from the origin is as exact as one at the origin.
#pragma once

#include <cmath>
#include <cstdint>

#include "physics/narrowphase/manifold.h"
#include "physics/shape.h"

namespace skerry::narrow {

inline constexpr int kMaxCorners = 64;
// Bits that rounding may spoil, relative to the coordinates: three roundings for a rotation, three for a dot
// product, with room.
inline constexpr double kNoise = 1.0e-14;
// Axes whose separations differ by less than this, relative to the coordinates, count as equal, and the first
// one is taken. Above the noise, so that faces that lie on each other always have the same reference face.
inline constexpr double kAxisBias = 1.0e-14;
// Corners that face each other within this share of the contact segment count as corner on corner, so that
// aligned stacks keep their feature ids. It changes the label only, never a number.
inline constexpr double kCornerOnCorner = 1.0e-7;

/// A core and its radius; points into a Shape. A half-plane has its point and normal.
struct Hull {
  ShapeKind kind = ShapeKind::Disc;
  const Vec2* v = nullptr;
  const Vec2* n = nullptr;
  int count = 0;
  double radius = 0;
};

inline Hull hull_of(const Shape& shape) {
  return {shape.kind, shape.vertices.data(), shape.normals.data(), static_cast<int>(shape.vertices.size()),
          shape.radius};
}

/// The rotation that takes vectors of frame `b` to frame `a`: inverse(a) b.
constexpr Rot relative_rotation(Rot a, Rot b) {
  return {a.c * b.c + a.s * b.s, a.c * b.s - a.s * b.c};
}

/// Pose of b in the frame of a.
constexpr Transform relative_pose(const Transform& a, const Transform& b) {
  return {inverse_rotate(a.q, b.p - a.p), relative_rotation(a.q, b.q)};
}

/// Sum of the coordinates' magnitudes.
inline double magnitude(Vec2 v) {
  return std::abs(v.x) + std::abs(v.y);
}

/// The second core in the frame of the first; no memory is initialised that is not used.
struct Placed {
  double x[kMaxCorners];
  double y[kMaxCorners];
  Rot turn;
  Vec2 point(int i) const { return {x[i], y[i]}; }
};

/// True if a pair calls shape `b` its first. Exchanging the arguments exchanges the roles (unless shapes and
/// poses are all equal), so what is computed from the first and second shape does not depend on their order.
/// The answer rarely changes while a pair moves: it is the sign of a product with the direction (1,
/// 0.618...), one that man-made scenes do not have.
bool second_comes_first(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b);

/// The axis of least penetration (or largest separation) of two cores with at least two corners each.
struct Axis {
  bool apart = false;     ///< some axis separates by more than the limit; nothing else is valid then
  int index = 0;          ///< edge of the first core (>= 0) or of the second as ~edge
  double separation = 0;  ///< of the cores [m]
  int support = 0;        ///< corner of the other core that lies deepest below the edge
  double scale = 0;       ///< magnitude of the coordinates that went in [m]
};

/// Searches all axes, or only those that `cache` leaves in question. `placed` is filled.
Axis find_axis(const Hull& a, const Hull& b, const Transform& relative, double limit, Placed& placed,
               SatCache* cache, NarrowPhaseStats* stats);

/// One contact point in the frame of the first core; positions are midway between the surfaces.
struct LocalPoint {
  Vec2 position;
  double separation;
  std::uint32_t feature;
};

/// Whose edge gave the normal of a manifold.
enum class NormalFrom : std::uint8_t { First, Second, Corners };

/// Contact points of two shapes in the frame of the first.
struct LocalManifold {
  Vec2 normal;
  LocalPoint points[2];
  int count = 0;
  NormalFrom from = NormalFrom::First;
};

/// Clips the incident edge to the reference edge of `axis`, or finds the two closest corners.
LocalManifold clip(const Hull& a, const Hull& b, const Placed& placed, const Axis& axis, double margin);

/// Order in which kinds of shapes are first in a pair: half-planes, then cores with edges, then discs.
constexpr int rank_of(ShapeKind kind) {
  return kind == ShapeKind::HalfPlane ? 2 : kind == ShapeKind::Disc ? 0 : 1;
}

/// Contact of two shapes in the frame of the first. @pre no chain; rank_of(a) >= rank_of(b); not two
/// half-planes
LocalManifold meet(const Hull& a, const Hull& b, const Transform& relative, double margin, SatCache* cache,
                   NarrowPhaseStats* stats);

}  // namespace skerry::narrow
