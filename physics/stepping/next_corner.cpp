// SPDX-License-Identifier: MIT
#include "physics/stepping/next_corner.h"

#include "physics/root.h"
#include "physics/stepping/contact_kinematics.h"
#include "physics/stepping/free_flight.h"

namespace skerry {
namespace {

BodyMotion motion_at(const Motion& motion, double t) {
  const Motion then = later(motion, t);
  return {then.p0, Rot::from_angle(then.angle0), then.v, then.omega};
}

/// Whether there is no end to pass: on a half-plane, or of a disc on a disc.
bool are_endless(const Shape& a, const Shape& b) {
  return a.kind == ShapeKind::HalfPlane || b.kind == ShapeKind::HalfPlane ||
         (a.kind == ShapeKind::Disc && b.kind == ShapeKind::Disc);
}

}  // namespace

std::optional<double> next_corner_time(const WorldState& state, const Contact& contact, const Motion& a,
                                       const Motion& b, std::uint8_t resting, double h) {
  const Shape &shape_a = state.shapes[contact.shape_a].shape, &shape_b = state.shapes[contact.shape_b].shape;
  std::optional<double> first;
  if (are_endless(shape_a, shape_b)) return first;
  for (int i = 0; i < contact.manifold.count; ++i) {
    if ((resting >> i & 1) == 0) continue;
    const std::optional<ContactFeatures> features =
        features_of(contact, shape_a, a.at(0), shape_b, b.at(0), i);
    if (!features) continue;
    const auto left = [&](double t) {
      const std::optional<ContactKinematics> k = kinematics_of(*features, motion_at(a, t), motion_at(b, t));
      return k ? k->range + kBeyondCorner : kInfinity;
    };
    const double end = first.value_or(h), now = left(0), then = left(end);
    if (now > 0 && then < 0) first = falling_root(left, 0, now, end, then);
  }
  return first;
}

}  // namespace skerry
