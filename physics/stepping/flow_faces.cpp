// SPDX-License-Identifier: MIT
#include "physics/stepping/flow_faces.h"

#include <algorithm>
#include <cmath>

#include "physics/stepping/contact_face.h"
#include "physics/stepping/free_flight.h"
#include "physics/stepping/touching.h"
#include "physics/thread_pool.h"

namespace skerry {
namespace {

// Cosine of the angle between normals of faces that are alike; share of a time by which another one is later.
constexpr double kAlike = 0.95, kLater = 1e-6;
// Overlap with a face along which a body slides, as a share of the smaller body: flow leaves some.
constexpr double kFlush = 1e-4;
// What turns farther in a step does not go along straight lines [rad].
constexpr double kTurn = 0.03;
constexpr std::size_t kContactsAPiece = 256;

/// A face that keeps two bodies apart until a time.
struct Passage {
  Vec2 normal;        ///< from a to b
  Vec2 position;      ///< of the point that meets it [m]
  double separation;  ///< [m]
  double opening;     ///< its rate [m/s]
  double time = -1;   ///< from now on [s]; infinite: it is not passed
};

class LastPassage {
 public:
  LastPassage(const WorldState& state, const Contact& contact, double elapsed, double slow)
      : state_(state), contact_(contact), elapsed_(elapsed), slow_(slow) {
    const Shape &a = state.shapes[contact.shape_a].shape, &b = state.shapes[contact.shape_b].shape;
    const Transform pose_a = pose_at(state, contact.body_a, elapsed),
                    pose_b = pose_at(state, contact.body_b, elapsed);
    tolerance_ =
        kFlush * std::min(size_in_island(state, contact.body_a), size_in_island(state, contact.body_b));
    look(a, pose_a, b, pose_b, 1);
    look(b, pose_b, a, pose_a, -1);
  }

  const Passage& found() const { return last_; }

 private:
  /// The faces of `one`. @param sign  of their normals from a to b
  void look(const Shape& one, const Transform& pose, const Shape& other, const Transform& of_other,
            double sign) {
    for (std::size_t edge = 0; edge < one.normals.size(); ++edge) {
      const Vec2 outwards = rotate(pose.q, one.normals[edge]), foot = to_world(pose, one.vertices[edge]);
      const double low = height_over(one, edge, pose, other, of_other, outwards);
      const double height = low - one.radius - other.radius;
      if (!(height >= -tolerance_)) continue;
      const Vec2 lowest = lowest_corner(other, of_other, outwards, foot, low);
      Passage passage{sign * outwards, lowest - (other.radius + 0.5 * height) * outwards, height, 0};
      passage.opening = dot(passage.normal, relative_velocity(state_, contact_, passage.position, elapsed_));
      const bool stays = passage.opening >= (height <= tolerance_ ? -slow_ : 0);
      passage.time = stays ? kInfinity : std::max(height, 0.0) / -passage.opening;
      if (is_later(passage)) last_ = passage;
    }
  }

  /// Of those that are about as low as the lowest one that which is nearest to the nearest points.
  Vec2 lowest_corner(const Shape& other, const Transform& of_other, Vec2 outwards, Vec2 foot,
                     double low) const {
    Vec2 lowest;
    double nearest = kInfinity;
    for (const Vec2 corner : other.vertices) {
      const Vec2 at = to_world(of_other, corner);
      if (dot(outwards, at - foot) > low + tolerance_) continue;
      const double far = length_squared(at - contact_.manifold.points[0].position);
      if (!(far < nearest)) continue;
      nearest = far;
      lowest = at;
    }
    return lowest;
  }

  /// Of faces that are passed at one corner at one time that along which the body goes on.
  bool is_later(const Passage& passage) const {
    if (passage.time > last_.time * (1 + kLater) || last_.time < 0) return true;
    return passage.time >= last_.time * (1 - kLater) && std::abs(passage.opening) < std::abs(last_.opening);
  }

  const WorldState& state_;
  const Contact& contact_;
  double elapsed_, slow_, tolerance_;
  Passage last_{};
};

/// When the first point that closes faster than `slow` does, if within the step; else infinite [s].
double closing_time_of_points(const WorldState& state, const Contact& contact, double elapsed, double h,
                              double slow) {
  double first = kInfinity;
  for (int i = 0; i < contact.manifold.count; ++i) {
    const ManifoldPoint& point = contact.manifold.points[i];
    const double speed = -normal_velocity(state, contact, point.position, elapsed);
    if (speed > slow && point.separation < h * speed)
      first = std::min(first, std::max(point.separation, 0.0) / speed);
  }
  return first;
}

void foresee_face(const WorldState& state, Contact& contact, double elapsed, double h, double slow) {
  const double closing = closing_time_of_points(state, contact, elapsed, h, slow);
  if (!(closing < kInfinity)) return;
  const auto goes_straight = [&](std::uint32_t body, const Shape& shape) {
    return is_hull(shape) &&
           (shape.kind == ShapeKind::Disc || h * std::abs(state.bodies.omega[body]) <= kTurn);
  };
  if (!goes_straight(contact.body_a, state.shapes[contact.shape_a].shape) ||
      !goes_straight(contact.body_b, state.shapes[contact.shape_b].shape))
    return;
  const Passage face = LastPassage(state, contact, elapsed, slow).found();
  if (!(face.time >= (1 - kLater) * closing)) return;
  // Two points that close along much the same direction carry better than one.
  if (dot(face.normal, contact.manifold.normal) > (contact.manifold.count > 1 ? kAlike : kSameFace)) return;
  contact.manifold.points[0].position = face.position;
  take_face(contact, face.normal, face.separation);
}

}  // namespace

void foresee_faces(WorldState& state, const Island& island, double elapsed, double h, double slow) {
  share_each(state.island_threads, island.contacts.size(), kContactsAPiece, [&](std::size_t k) {
    foresee_face(state, state.contacts[island.contacts[k]], elapsed, h, slow);
  });
}

}  // namespace skerry
