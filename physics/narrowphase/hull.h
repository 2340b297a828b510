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

#include "physics/narrowphase/lanes.h"
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

// Shorter vectors have squares that underflow, so no direction [m].
inline constexpr double kNoDirection = 1.0e-100;

// Beyond this distance of the bodies [m] their squares would overflow; they do not touch.
inline constexpr double kFarAway = 1.0e100;
// Pairs are ordered by the sign of a product with the direction (1, this), one that man-made scenes do not
// have: the golden ratio less one.
inline constexpr double kOrderSlope = 0.6180339887498949;

/// A core and its radius; points into a Shape. A half-plane has its point and normal.
struct Hull {
  ShapeKind kind = ShapeKind::Disc;
  const Vec2* v = nullptr;
  const Vec2* n = nullptr;
  int count = 0;
  double radius = 0;
  const Shape::Rectangle* rectangle = nullptr;  ///< null if the core is none
};

inline Hull hull_of(const Shape& shape) {
  return {shape.kind,           shape.vertices.data(),
          shape.normals.data(), static_cast<int>(shape.vertices.size()),
          shape.radius,         shape.rectangle.half.x > 0 ? &shape.rectangle : nullptr};
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

/// Corners of the second core in the frame of the first. The empty constructor leaves the storage as it is:
/// clearing room for 64 corners would cost more than colliding two boxes.
struct Placed {
  union {
    Vec2 v[kMaxCorners];
  };
  Rot turn;
  Placed() {}  // NOLINT: see above
};

/// Order of two shapes at one place by everything else.
bool second_comes_first_by_details(const Shape& a, const Transform& pose_a, const Shape& b,
                                   const Transform& pose_b);

/// True if a pair calls shape `b` its first. Exchanging the arguments exchanges the roles (unless shapes and
/// poses are all equal), so what is computed from the first and second shape does not depend on their order.
/// The answer rarely changes while a pair moves.
inline bool second_comes_first(const Shape& a, const Transform& pose_a, const Shape& b,
                               const Transform& pose_b) {
  const Vec2 d = pose_b.p - pose_a.p;
  const double side = d.x + kOrderSlope * d.y;
  return side != 0 ? side < 0 : second_comes_first_by_details(a, pose_a, b, pose_b);
}

/// The axis of least penetration (or largest separation) of two cores with at least two corners each.
struct Axis {
  bool apart = false;     ///< some axis separates by more than the limit; nothing else is valid then
  int index = 0;          ///< edge of the first core (>= 0) or of the second as ~edge
  double separation = 0;  ///< of the cores [m]
  Vec2 n;                 ///< outward normal of the edge, in the first core's frame
  int support = 0;        ///< corner of the other core that lies deepest below the edge
  double scale = 0;       ///< magnitude of the coordinates that went in [m]
};

/// Searches all axes, or only those that `cache` leaves in question. `placed` is filled.
Axis find_axis(const Hull& a, const Hull& b, const Transform& relative, double limit, Placed& placed,
               SatCache* cache, NarrowPhaseStats* stats);

/// Whose edge gave the normal of a manifold.
enum class NormalFrom : std::uint8_t { First, Second, Corners };

/// Takes the contact of a first and a second core in the frame of the first and writes it where and how it is
/// wanted, member by member: a manifold that is copied around costs as much as finding it.
struct Output {
  Manifold& m;            ///< count is 0 and stays so if the shapes are too far apart
  Transform frame;        ///< pose of the first core in the frame of the result
  bool exchange = false;  ///< the caller's a is the second core
  NormalFrom from = NormalFrom::First;

  void normal(Vec2 n, NormalFrom origin) { normal(Two::of(n.x, n.y), origin); }
  void normal(Two n, NormalFrom origin) {
    flipped(turned(load(frame.q), n), everywhere(exchange)).store(&m.normal.x);
    from = origin;
  }
  void point(int slot, Vec2 position, double separation, std::uint32_t feature) {
    ManifoldPoint& out = m.points[static_cast<unsigned>(slot)];
    out.position = to_world(frame, position);
    out.separation = separation;
    out.feature = exchange ? mirrored(feature) : feature;
  }
};

/// Direction and distance between two cores in the frame of the first: what `clip` would find, without
/// points.
struct Closest {
  Vec2 normal;
  double distance = 0;  ///< of the cores [m]
  NormalFrom from = NormalFrom::First;
  int corner_a = 0, corner_b = 0;  ///< that meet; an edge by its first corner
};
Closest closest(const Hull& a, const Hull& b, const Placed& placed, const Axis& axis);

/// Clips the incident edge to the reference edge of `axis`, or finds the two closest corners.
/// @param may_turn  the normal may become that of the incident edge, if that is nearer to an end of the other
void clip(const Hull& a, const Hull& b, const Placed& placed, const Axis& axis, double margin, Output& out,
          bool may_turn = true);

/// Order in which kinds of shapes are first in a pair: half-planes, then cores with edges, then discs.
constexpr int rank_of(ShapeKind kind) {
  return kind == ShapeKind::HalfPlane ? 2 : kind == ShapeKind::Disc ? 0 : 1;
}

/// Contact of two shapes. @pre no chain; rank_of(a) >= rank_of(b); not two half-planes
/// @param relative  pose of b in the frame of a
void meet(const Hull& a, const Hull& b, const Transform& relative, double margin, SatCache* cache,
          NarrowPhaseStats* stats, Output& out);

}  // namespace skerry::narrow
