// SPDX-License-Identifier: MIT
//
// Shapes, given in the frame of their body, and their mass properties in closed form.
//
// Disc, capsule and polygon are one thing to the narrow phase: the convex hull of 1, 2 or n points, grown by
// a radius. A half-plane is the set of points behind a line. A chain is terrain: segments that share their
// inner vertices.
#pragma once

#include <cstdint>
#include <span>
#include <variant>
#include <vector>

#include "physics/material.h"
#include "physics/math.h"

namespace skerry {

enum class ShapeKind : std::uint8_t { Disc, Capsule, Polygon, HalfPlane, Chain };

/// Area, centre and second moment of a shape of unit density.
struct AreaProperties {
  double area = 0;           ///< [m^2]
  Vec2 centroid;             ///< shape's frame [m]
  double second_moment = 0;  ///< polar, about the centroid [m^4]
};

/// An immutable piece of geometry in the body's frame. Made by the functions below, which check their
/// arguments.
struct Shape {
  ShapeKind kind = ShapeKind::Disc;
  double radius = 0;           ///< disc and capsule: radius, polygon: rounding, otherwise 0 [m]
  std::vector<Vec2> vertices;  ///< disc: centre; capsule: two ends; polygon: counter-clockwise corners of the
                               ///< core; half-plane: a point of its line; chain: the corners in order
  std::vector<Vec2>
      normals;             ///< polygon: outward unit normal of the edge from vertex i to i+1; capsule: two;
                           ///< half-plane: its outward normal; chain: left normal (the solid is on the right)
  bool closed = false;     ///< chain: the last vertex joins the first
  std::vector<Vec2> tree;  ///< chain: boxes around runs of segments (see narrowphase/chain_tree.h)

  /// What pairs of rectangles are searched by; the other shapes have none.
  struct Rectangle {
    Vec2 middle;
    Vec2 half;  ///< half widths along normals 0 and 1 [m]; 0: not a rectangle
    friend bool operator==(const Rectangle&, const Rectangle&) = default;
  } rectangle;

  friend bool operator==(const Shape&, const Shape&) = default;
};

/// @throws std::invalid_argument unless radius > 0 and all is finite, with the value in the message.
Shape make_disc(double radius, Vec2 centre = {});
/// A segment grown by `radius`. @throws std::invalid_argument if the ends coincide or radius <= 0.
Shape make_capsule(Vec2 from, Vec2 to, double radius);
/// A convex polygon with 3 to 64 corners, either orientation, grown by `rounding` >= 0.
/// @throws std::invalid_argument for fewer than 3 points, repeated or collinear points, a non-convex order,
/// or values that are not finite, with the corner's number in the message.
Shape make_polygon(std::span<const Vec2> corners, double rounding = 0);
/// An upright box of full size (width, height), optionally rounded within that size and turned by `angle`
/// [rad].
Shape make_box(Vec2 size, Vec2 centre = {}, double angle = 0, double rounding = 0);
/// All points p with dot(p - point, normal) <= 0. @throws std::invalid_argument if the normal is zero.
Shape make_half_plane(Vec2 point, Vec2 normal);
/// Terrain of straight segments, solid on the right-hand side when walking from the first corner to the last.
Shape make_chain(std::span<const Vec2> corners, bool closed = false);

/// The shape moved by `offset` (bodies keep their geometry relative to the centre of mass).
Shape translated(const Shape& shape, Vec2 offset);
/// Area, centroid and second moment; zero for half-planes and chains, which have no mass.
AreaProperties area_properties(const Shape& shape);
/// Stands for infinity in boxes, and in how far from its body a half-plane can be met [m].
inline constexpr double kEndless = 1.0e12;

/// The smallest box around the shape at pose `pose`; a half-plane's is endless where it must be.
Aabb bounding_box(const Shape& shape, const Transform& pose);
/// Largest distance of a point of the shape from the body's origin [m]; infinite for half-planes.
double bounding_radius(const Shape& shape);
/// Smallest distance of an edge from the mean of the corners [m], a disc's radius; 0 for half-planes and
/// chains.
double half_width(const Shape& shape);

/// Splits a simple polygon (either orientation, no holes) into convex parts of at most 64 corners; keeps the
/// area.
/// @throws std::invalid_argument if the outline crosses itself or has fewer than 3 corners.
std::vector<std::vector<Vec2>> convex_parts(std::span<const Vec2> outline);

}  // namespace skerry
