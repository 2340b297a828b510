// SPDX-License-Identifier: MIT
#include "physics/contact.h"

#include "physics/hash.h"
#include "physics/narrowphase/chain.h"
#include "physics/narrowphase/collide.h"

namespace skerry {

std::uint64_t Contact::source(int i) const {
  Fnv1a hash;
  hash.add(shape_a);
  hash.add(shape_b);
  hash.add(static_cast<std::uint32_t>(child));
  hash.add(manifold.points[i].feature);
  return hash.value();
}

Manifold contact_manifold(int child, const Shape& a, const Transform& pose_a, const Shape& b,
                          const Transform& pose_b, double margin, SatCache* cache, NarrowPhaseStats* stats) {
  if (a.kind == ShapeKind::Chain) return collide_chain_segment(a, child, pose_a, b, pose_b, margin, stats);
  if (b.kind != ShapeKind::Chain) return collide(a, pose_a, b, pose_b, margin, cache, stats);
  Manifold manifold = collide_chain_segment(b, child, pose_b, a, pose_a, margin, stats);
  manifold.normal = -manifold.normal;
  return manifold;
}

Manifold crossing_manifold(const Contact& contact, const Shape& a, const Transform& pose_a, const Shape& b,
                           const Transform& pose_b, double margin) {
  if (a.kind == ShapeKind::Chain) return cross_chain_segment(a, contact.child, pose_a, b, pose_b, margin);
  if (b.kind != ShapeKind::Chain) return collide(a, pose_a, b, pose_b, margin, nullptr, nullptr);
  Manifold manifold = cross_chain_segment(b, contact.child, pose_b, a, pose_a, margin);
  manifold.normal = -manifold.normal;
  return manifold;
}

ImpactTime contact_impact_time(const Contact& contact, const Shape& a, const Motion& motion_a, const Shape& b,
                               const Motion& motion_b, double h) {
  if (a.kind == ShapeKind::Chain)
    return time_of_impact_chain_segment(a, contact.child, motion_a, b, motion_b, h);
  if (b.kind == ShapeKind::Chain)
    return time_of_impact_chain_segment(b, contact.child, motion_b, a, motion_a, h);
  return time_of_impact(a, motion_a, b, motion_b, h);
}

bool keep_manifold(Contact& contact, const Shape& a, const Transform& pose_a, const Shape& b,
                   const Transform& pose_b, double margin, const Skips& skips) {
  if (!skips.manifolds || pose_a != contact.pose_a || pose_b != contact.pose_b) return false;
  const bool serves = contact.manifold.count == 1 && contact.manifold.points[0].separation <= margin &&
                      meet_at_one_point(a, b);
  if (serves) contact.margin = margin;
  return margin == contact.margin;
}

void adopt_manifold(Contact& contact, const Transform& pose_a, const Transform& pose_b, double margin) {
  contact.margin = margin;
  contact.pose_a = pose_a;
  contact.pose_b = pose_b;
  match_points(contact);
}

bool refresh_manifold(Contact& contact, const Shape& a, const Transform& pose_a, const Shape& b,
                      const Transform& pose_b, double margin, const Skips& skips, NarrowPhaseStats& stats) {
  if (keep_manifold(contact, a, pose_a, b, pose_b, margin, skips)) return false;
  contact.manifold =
      contact_manifold(contact, a, pose_a, b, pose_b, margin, skips.axes ? &contact.cache : nullptr, &stats);
  adopt_manifold(contact, pose_a, pose_b, margin);
  return true;
}

/// Every slot has the memory of its feature already.
static bool points_match(const Contact& contact) {
  for (int i = 0; i < 2; ++i) {
    const std::uint32_t feature = i < contact.manifold.count ? contact.manifold.points[i].feature : ~0u;
    if (contact.points[i].feature != feature) return false;
  }
  return true;
}

void match_points(Contact& contact) {
  if (points_match(contact)) return;
  const std::array<PointMemory, 2> old = contact.points;
  std::array<PointMemory, 2> next;
  std::array<bool, 2> taken{}, known{};
  for (int i = 0; i < contact.manifold.count; ++i) {
    next[i].feature = contact.manifold.points[i].feature;
    for (int j = 0; j < 2; ++j) {
      if (taken[j] || old[j].feature != next[i].feature) continue;
      next[i] = old[j];
      taken[j] = known[i] = true;
      break;
    }
  }
  // Sums of points that vanished within the step still belong to the pair: what follows them keeps them, or
  // what is left.
  for (int j = 0; j < 2; ++j) {
    if (taken[j]) continue;
    const bool second = contact.manifold.count == 2 && !known[1] && (known[0] || j == 1);
    PointMemory& heir = next[second ? 1 : 0];
    heir.total_normal += old[j].total_normal;
    heir.total_friction += old[j].total_friction;
    heir.total_impact += old[j].total_impact;
    if (old[j].total_impact > 0) heir.impact_position = old[j].impact_position;
  }
  contact.points = next;
}

}  // namespace skerry
