// SPDX-License-Identifier: MIT
//
// How gap and sliding velocity of two touching features change in time: first and second derivatives in
// closed form.
#pragma once

#include <array>
#include <optional>

#include "physics/contact.h"

namespace skerry {

/// A contact has passed a corner when it is this far beyond [m]: then the narrow phase sees it, too.
inline constexpr double kBeyondCorner = 1e-10;

/// Pose and velocity of a body.
struct BodyMotion {
  Vec2 p;            ///< centre of mass [m]
  Rot q;             ///< orientation
  Vec2 v;            ///< [m/s]
  double omega = 0;  ///< [rad/s]
};

/// The features that meet at a contact point, in the bodies' frames: two points, or a point and an edge, each
/// grown by the radius of its shape.
struct ContactFeatures {
  enum class Kind : std::uint8_t { Points, EdgeOfA, EdgeOfB };
  Kind kind = Kind::Points;
  Vec2 point_a, point_b;      ///< the points; of the edge, where it starts [m]
  Vec2 along, normal;         ///< of the edge: direction and outward normal
  double length = kInfinity;  ///< of the edge [m]
  double radius_a = 0, radius_b = 0;
  /// Points: directions of the edges that leave the corner. Beyond one of them it is that edge that meets.
  std::array<Vec2, 2> edges_a{}, edges_b{};
  int edge_count_a = 0, edge_count_b = 0;
  bool past = false;  ///< two sharp corners have passed each other: nothing of them meets any more
};

/// The features of point `i` of the contact's manifold, which was made at `pose_a`, `pose_b`; none for
/// features that are no point and edge.
std::optional<ContactFeatures> features_of(const Contact& contact, const Shape& a, const Transform& pose_a,
                                           const Shape& b, const Transform& pose_b, int i);

/// Geometry of two features in motion. With a_rel the relative acceleration J a of a row at `position`,
/// the second derivative of the gap is J_n a + normal_bias and that of the sliding J_t a + tangent_bias
/// [Pfeiffer & Glocker 1996, sec. 4.2: contact kinematics].
struct ContactKinematics {
  Vec2 normal;               ///< from a to b
  Vec2 position;             ///< between the two surfaces [m]
  double gap = 0;            ///< [m]
  double gap_rate = 0;       ///< [m/s]
  double sliding = 0;        ///< velocity of b against a along perp(normal) [m/s]
  double normal_bias = 0;    ///< [m/s^2]
  double tangent_bias = 0;   ///< [m/s^2]
  double range = kInfinity;  ///< how far the contact is from leaving its features [m]; negative: it has
};

/// @return none if the two points coincide, so that they have no normal
std::optional<ContactKinematics> kinematics_of(const ContactFeatures& features, const BodyMotion& a,
                                               const BodyMotion& b);

}  // namespace skerry
