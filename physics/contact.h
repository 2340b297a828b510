// SPDX-License-Identifier: MIT
//
// Pairs of shapes that may touch in this step, kept from step to step in one sorted table.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "physics/broadphase/broadphase.h"
#include "physics/narrowphase/manifold.h"
#include "physics/narrowphase/time_of_impact.h"
#include "physics/shape.h"
#include "physics/skips.h"

namespace skerry {

/// What acted on a contact point in the last force solve.
struct PointForces {
  std::uint32_t feature = ~0u;  ///< none yet
  bool sticking = false;        ///< the friction impulse was strictly inside its bounds
  double normal_impulse = 0;    ///< [N s]; divided by `h` it is the force
  double friction_impulse = 0;
  double rolling_impulse = 0;
  double h = 0;  ///< length of the sub-step of that solve [s]

  /// Nothing presses here any more.
  void let_go() {
    sticking = false;
    normal_impulse = friction_impulse = rolling_impulse = 0;
  }
};

/// What a contact point carries from sub-step to sub-step and from step to step.
struct PointMemory : PointForces {
  // Sums over the step, for the report.
  double total_normal = 0, total_friction = 0, total_impact = 0;
  Vec2 impact_position;  ///< where the last impact of the step acted, world frame [m]
  Vec2 normal;           ///< along which the last force solve by `time_stepping` pushed
};

/// Shapes, the lower slot first, and the segment of a chain: the order of the contact table.
using ContactKey = std::tuple<std::uint32_t, std::uint32_t, std::int32_t>;

/// A pair of shapes (for chains: a segment and a shape).
struct Contact {
  std::uint32_t shape_a = 0, shape_b = 0;  ///< slots, shape_a < shape_b
  std::int32_t child = 0;                  ///< segment of the chain, otherwise 0
  std::uint32_t body_a = 0, body_b = 0;
  double friction = 0, restitution = 0, rolling_resistance = 0, surface_velocity = 0;
  double static_friction = 0;  ///< >= friction: the bound while nothing slides
  bool sensor = false;
  bool linked = false;           ///< may touch within this step: part of an island
  bool touched = false;          ///< touched at the end of the last step
  bool woken = false;            ///< came back from sleep and was not looked at since
  bool hit = false;              ///< took part in an impact in this step
  bool manifold_reused = false;  ///< at the beginning of this step: both bodies are where they were
  double hit_speed = 0;          ///< largest approach speed of those impacts [m/s]
  Vec2 hit_point, hit_normal;    ///< of the fastest of them, world frame
  double hit_time = 0;           ///< and when, since the beginning of the step [s]
  double margin = 0;             ///< largest separation that the manifold reports [m]
  Transform pose_a, pose_b;      ///< at which the manifold was made
  std::uint64_t begun = 0;       ///< number of the step (from 1) in which its sums were set to zero
  SatCache cache;
  Manifold manifold;
  std::array<PointMemory, 2> points;
  std::array<PointForces, 2> points_at_start;  ///< of the step, should its island have to be stepped again
  /// On b in this step, by forces and impacts, each in the direction in which it acted; and of that the part
  /// of the normals of impacts [N s].
  Vec2 impulse, impact;

  ContactKey key() const { return {shape_a, shape_b, child}; }
  /// A number that names point `i` and is equal in the next step if the same features meet.
  std::uint64_t source(int i) const;
};

/// The manifold of a pair at these poses; of segment `child` if one of the shapes is a chain.
Manifold contact_manifold(int child, const Shape& a, const Transform& pose_a, const Shape& b,
                          const Transform& pose_b, double margin, SatCache* cache, NarrowPhaseStats* stats);
inline Manifold contact_manifold(const Contact& contact, const Shape& a, const Transform& pose_a,
                                 const Shape& b, const Transform& pose_b, double margin, SatCache* cache,
                                 NarrowPhaseStats* stats) {
  return contact_manifold(contact.child, a, pose_a, b, pose_b, margin, cache, stats);
}

/// The same where a chain has no sides: as a sensor sees it.
Manifold crossing_manifold(const Contact& contact, const Shape& a, const Transform& pose_a, const Shape& b,
                           const Transform& pose_b, double margin);

/// True for two discs, or a disc and a half-plane: wherever they are, it is the same point that is nearest.
inline bool meet_at_one_point(const Shape& a, const Shape& b) {
  const auto is = [&](ShapeKind x, ShapeKind y) { return a.kind == x && b.kind == y; };
  return is(ShapeKind::Disc, ShapeKind::Disc) || is(ShapeKind::Disc, ShapeKind::HalfPlane) ||
         is(ShapeKind::HalfPlane, ShapeKind::Disc);
}

/// First time in [0, h] at which the pair touches under constant-acceleration motions.
ImpactTime contact_impact_time(const Contact& contact, const Shape& a, const Motion& motion_a, const Shape& b,
                               const Motion& motion_b, double h);

/// True if the contact's manifold is that of these poses (bit by bit) already and `skips` lets it be kept.
bool keep_manifold(Contact& contact, const Shape& a, const Transform& pose_a, const Shape& b,
                   const Transform& pose_b, double margin, const Skips& skips);

/// The manifold is not, or no longer, that of its poses: `keep_manifold` makes it anew wherever the bodies
/// are.
inline void forget_poses(Contact& contact) {
  contact.pose_a.q = {0, 0};
}

/// Carries on with `contact.manifold`, which was made for these poses and this margin.
void adopt_manifold(Contact& contact, const Transform& pose_a, const Transform& pose_b, double margin);

/// Makes the contact's manifold for these poses, unless it can be kept.
/// @return false if nothing had to be done
bool refresh_manifold(Contact& contact, const Shape& a, const Transform& pose_a, const Shape& b,
                      const Transform& pose_b, double margin, const Skips& skips, NarrowPhaseStats& stats);

/// Carries impulses over to `contact.points` after its manifold changed: points are matched by feature.
void match_points(Contact& contact);

}  // namespace skerry
