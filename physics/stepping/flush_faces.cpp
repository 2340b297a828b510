// SPDX-License-Identifier: MIT
#include "physics/stepping/flush_faces.h"

#include <algorithm>
#include <cmath>

#include "physics/stepping/contact_face.h"
#include "physics/stepping/free_flight.h"
#include "physics/stepping/touching.h"

namespace skerry {
namespace {

// Landings that turn out to be passes, one after the other.
constexpr int kMostPasses = 4;
// So many tolerances in, the flush face is the nearer one without doubt.
constexpr double kWellPast = 4;

struct Face {
  Vec2 normal;        // from a to b
  double separation;  // along it [m]
  double opening;     // its rate [m/s]
};

/// Of the faces that two polygons overlap by no more than `tolerance`, the one that they slide along: with
/// this relative velocity they go to or from it most slowly.
Face face_of_passage(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b,
                     Vec2 relative, double tolerance) {
  Face best{{}, 0, kInfinity};
  const auto look = [&](const Shape& one, const Transform& pose, const Shape& other,
                        const Transform& of_other, double sign) {
    for (std::size_t edge = 0; edge < one.normals.size(); ++edge) {
      const Vec2 outwards = rotate(pose.q, one.normals[edge]), normal = sign * outwards;
      const double opening = dot(normal, relative);
      if (!(std::abs(opening) < std::abs(best.opening))) continue;
      const double height = height_over(one, edge, pose, other, of_other, outwards);
      if (height >= -tolerance) best = {normal, height, opening};
    }
  };
  look(a, pose_a, b, pose_b, 1);
  look(b, pose_b, a, pose_a, -1);
  return best;
}

/// Whether there is such a face, and it is not that of `normal`.
bool is_other(const Face& face, Vec2 normal) {
  return face.opening < kInfinity && !(dot(face.normal, normal) > kSameFace);
}

bool have_sharp_corners(const WorldState& state, const Contact& contact) {
  const auto sharp = [](const Shape& shape) { return shape.kind == ShapeKind::Polygon && shape.radius == 0; };
  return sharp(state.shapes[contact.shape_a].shape) && sharp(state.shapes[contact.shape_b].shape);
}

/// Where the two are nearest to each other. @pre the manifold has a point
const ManifoldPoint& nearest_point(const Manifold& manifold) {
  const bool second = manifold.count == 2 && manifold.points[1].separation < manifold.points[0].separation;
  return manifold.points[second ? 1 : 0];
}

Vec2 velocity_at(const Motion& m, Vec2 where) {
  return m.v + m.omega * perp(where - m.p0);
}

}  // namespace

bool pass_flush_face(const WorldState& state, Contact& contact, double elapsed) {
  bool closes = false, opens = false;
  for (int i = 0; i < contact.manifold.count; ++i) {
    const ManifoldPoint& point = contact.manifold.points[i];
    if (!is_touching(state, point)) continue;
    const double speed = normal_velocity(state, contact, point.position, elapsed);
    closes = closes || speed < -state.config.rest_speed;
    opens = opens || (speed > state.config.rest_speed && contact.points[i].normal_impulse > 0);
  }
  if (!(closes || opens) || !have_sharp_corners(state, contact)) return false;
  const ManifoldPoint nearest = nearest_point(contact.manifold);
  const Vec2 where = nearest.position;
  const Face face =
      face_of_passage(state.shapes[contact.shape_a].shape, pose_at(state, contact.body_a, elapsed),
                      state.shapes[contact.shape_b].shape, pose_at(state, contact.body_b, elapsed),
                      relative_velocity(state, contact, where, elapsed), touch_tolerance(state, where));
  if (!is_other(face, contact.manifold.normal)) return false;
  if (!closes) {
    // It was loaded along that face, and leaves over the end of it.
    for (PointMemory& memory : contact.points)
      memory.normal_impulse = memory.friction_impulse = memory.rolling_impulse = 0;
    return false;
  }
  contact.manifold.points[0] = nearest;
  take_face(contact, face.normal, face.separation);
  return true;
}

bool pass_flush_faces(WorldState& state, const Island& island, double elapsed) {
  bool passed = false;
  for (const std::uint32_t index : island.contacts)
    passed = pass_flush_face(state, state.contacts[index], elapsed) || passed;
  return passed;
}

ImpactTime landing_time(const WorldState& state, const Contact& contact, const Motion& a, const Motion& b,
                        double h) {
  const Shape &shape_a = state.shapes[contact.shape_a].shape, &shape_b = state.shapes[contact.shape_b].shape;
  Motion from_a = a, from_b = b;
  double begin = 0;
  for (int pass = 0;; ++pass) {
    ImpactTime impact = contact_impact_time(contact, shape_a, from_a, shape_b, from_b, h - begin);
    impact.t += begin;
    if (!impact.hit || pass == kMostPasses || !have_sharp_corners(state, contact)) return impact;
    const Motion at_a = later(a, impact.t), at_b = later(b, impact.t);
    const Transform pose_a = a.at(impact.t), pose_b = b.at(impact.t);
    const Manifold met = contact_manifold(contact, shape_a, pose_a, shape_b, pose_b,
                                          state.config.contact_margin, nullptr, nullptr);
    if (met.count == 0) return impact;
    const Vec2 where = nearest_point(met).position,
               relative = velocity_at(at_b, where) - velocity_at(at_a, where);
    const double tolerance = touch_tolerance(state, where);
    const Face face = face_of_passage(shape_a, pose_a, shape_b, pose_b, relative, tolerance);
    if (!is_other(face, met.normal) || face.opening < -state.config.rest_speed) return impact;
    begin = impact.t + kWellPast * tolerance / length(relative);
    if (!(begin < h)) return {false, h, impact.iterations, true};
    from_a = later(a, begin);
    from_b = later(b, begin);
  }
}

}  // namespace skerry
