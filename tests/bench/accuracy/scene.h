// SPDX-License-Identifier: MIT
//
// A scene as plain data, from which every engine of the comparison builds its world. One material for all
// shapes, so that the engines' different mixing rules give the same coefficients.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "physics/math.h"

namespace skerry::bench {

enum class Form { Disc, Box, Polygon, HalfPlane };

/// The one shape of a body, in its frame; the centre of mass is the origin.
struct SceneShape {
  Form form = Form::Disc;
  double radius = 0.5;          ///< Disc [m]
  Vec2 size{1, 1};              ///< Box: full width and height [m]
  std::vector<Vec2> corners{};  ///< Polygon: counter-clockwise, centroid at the origin [m]
  double extent = 200;          ///< HalfPlane: engines without one use `ground_corners`, this wide [m]
};

struct SceneBody {
  SceneShape shape;
  bool fixed = false;
  Vec2 position{};  ///< of the centre of mass; HalfPlane: a point of its surface [m]
  double angle = 0;
  Vec2 velocity{};
  double omega = 0;
  double mass = 1;                  ///< [kg], uniformly distributed over the shape
  std::optional<double> inertia{};  ///< [kg m^2]; default: that of the uniform shape
};

enum class Link { Pin, Rod };

struct SceneJoint {
  Link link = Link::Pin;
  int a = -1;  ///< body, -1: the ground
  int b = 0;
  Vec2 at_a{};  ///< world frame [m]
  Vec2 at_b{};  ///< Rod only
};

struct Scene {
  std::vector<SceneBody> bodies;
  std::vector<SceneJoint> joints;
  Vec2 gravity{0, -10};  ///< [m/s^2]
  double friction = 0.5;
  double restitution = 0;

  int add(SceneBody body) {
    bodies.push_back(std::move(body));
    return static_cast<int>(bodies.size()) - 1;
  }
};

inline SceneShape disc(double radius) {
  SceneShape shape;
  shape.radius = radius;
  return shape;
}

inline SceneShape box(double width, double height) {
  SceneShape shape;
  shape.form = Form::Box;
  shape.size = {width, height};
  return shape;
}

inline SceneShape polygon(std::vector<Vec2> corners) {
  SceneShape shape;
  shape.form = Form::Polygon;
  shape.corners = std::move(corners);
  return shape;
}

/// Corners of a box, counter-clockwise.
inline std::vector<Vec2> box_corners(Vec2 size) {
  const Vec2 h = 0.5 * size;
  return {{-h.x, -h.y}, {h.x, -h.y}, {h.x, h.y}, {-h.x, h.y}};
}

/// For engines without half-planes: a box with the surface on top, half as deep as wide. The first corner
/// is one of the surface: single-precision engines reckon from there.
inline std::vector<Vec2> ground_corners(const SceneShape& half_plane) {
  const double half = half_plane.extent / 2;
  return {{-half, 0}, {-half, -half}, {half, -half}, {half, 0}};
}

/// Of any shape but a disc.
inline std::vector<Vec2> corners_of(const SceneShape& shape) {
  if (shape.form == Form::Box) return box_corners(shape.size);
  return shape.form == Form::HalfPlane ? ground_corners(shape) : shape.corners;
}

/// A convex polygon with every side moved in by `margin`, for engines that add so much on every side.
inline std::vector<Vec2> inset(const std::vector<Vec2>& corners, double margin) {
  const std::size_t n = corners.size();
  std::vector<Vec2> inner;
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 p = corners[i];
    const Vec2 in = p - corners[(i + n - 1) % n], out = corners[(i + 1) % n] - p;
    // Lengths along the two sides, from the sine of the angle between them.
    const double sine = cross(in, out);
    inner.push_back(p + margin / sine * (length(in) * out - length(out) * in));
  }
  return inner;
}

/// Ground whose surface goes through `point` and rises by `angle` to the right [rad].
inline SceneBody ground(double angle = 0, Vec2 point = {}) {
  SceneBody body;
  body.shape.form = Form::HalfPlane;
  body.fixed = true;
  body.angle = angle;
  body.position = point;
  return body;
}

/// Moment of inertia about the centre of mass of a uniform body [kg m^2].
inline double inertia_of(const SceneBody& body) {
  const SceneShape& s = body.shape;
  if (body.inertia) return *body.inertia;
  if (s.form == Form::Disc) return 0.5 * body.mass * s.radius * s.radius;
  if (s.form == Form::Box) return body.mass * length_squared(s.size) / 12;
  // Polygon: sum of triangles from the centroid.
  double area = 0, second = 0;
  for (std::size_t i = 0; i < s.corners.size(); ++i) {
    const Vec2 p = s.corners[i], q = s.corners[(i + 1) % s.corners.size()];
    area += cross(p, q) / 2;
    second += cross(p, q) * (dot(p, p) + dot(p, q) + dot(q, q)) / 12;
  }
  return body.mass * second / area;
}

}  // namespace skerry::bench
