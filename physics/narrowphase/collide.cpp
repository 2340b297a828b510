// SPDX-License-Identifier: MIT
#include "physics/narrowphase/collide.h"

#include <stdexcept>

#include "physics/narrowphase/hull.h"

namespace skerry {
namespace {

using narrow::Hull;
using narrow::LocalManifold;

/// Beyond this distance of the bodies [m] their squares would overflow; they do not touch.
constexpr double kFarAway = 1.0e100;

Manifold to_world_frame(const LocalManifold& local, const Transform& frame) {
  Manifold m;
  m.count = local.count;
  if (m.count == 0) return m;
  m.normal = rotate(frame.q, local.normal);
  for (int i = 0; i < local.count; ++i) {
    m.points[i] = {to_world(frame, local.points[i].position), local.points[i].separation,
                   local.points[i].feature};
  }
  return m;
}

Manifold discs(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b,
               double margin) {
  // All differences change sign exactly when the discs are exchanged.
  const Vec2 ca = rotate(pose_a.q, a.vertices[0]), cb = rotate(pose_b.q, b.vertices[0]);
  const Vec2 d = (pose_b.p - pose_a.p) + (cb - ca);
  const double radii = a.radius + b.radius;
  const double square = dot(d, d);
  Manifold m;
  if (square > (radii + margin) * (radii + margin)) return m;
  const double distance = std::sqrt(square);
  m.count = 1;
  m.normal = distance > 0                                       ? d / distance
             : narrow::second_comes_first(a, pose_a, b, pose_b) ? Vec2{0, -1}
                                                                : Vec2{0, 1};
  // The middle of the two surface points; the sum is symmetric too.
  const Vec2 middle = 0.5 * ((pose_a.p + ca) + (pose_b.p + cb));
  m.points[0] = {middle + (0.5 * (a.radius - b.radius)) * m.normal, distance - radii,
                 make_feature(corner_code(0), corner_code(0))};
  return m;
}

/// True if the cached axis separates the shapes by more than the margin beyond doubt: then the full search
/// would find them apart too.
bool apart_on_cached_axis(const Hull& a, const Transform& pose_a, const Hull& b, const Transform& pose_b,
                          double margin, std::int32_t axis) {
  const bool on_a = axis >= 0;
  const int edge = on_a ? axis : ~axis;
  const Hull& own = on_a ? a : b;
  const Hull& other = on_a ? b : a;
  if (edge >= own.count) return false;
  const Transform& pose_own = on_a ? pose_a : pose_b;
  const Transform& pose_other = on_a ? pose_b : pose_a;
  const Vec2 n = rotate(pose_own.q, own.n[edge]);
  const Vec2 n_other = inverse_rotate(pose_other.q, n);
  double low = dot(n_other, other.v[0]);
  for (int i = 1; i < other.count; ++i) {
    const double value = dot(n_other, other.v[i]);
    low = value < low ? value : low;
  }
  const Vec2 d = pose_other.p - pose_own.p;
  const double face = dot(own.n[edge], own.v[edge]);
  const double noise = narrow::kNoise * (narrow::magnitude(d) + std::abs(low) + std::abs(face));
  return dot(n, d) + low - face > margin + a.radius + b.radius + noise;
}

Manifold dispatch(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b,
                  double margin, SatCache* cache, NarrowPhaseStats* stats) {
  if (a.kind == ShapeKind::Chain || b.kind == ShapeKind::Chain) {
    throw std::invalid_argument("collide: a chain is met segment by segment (collide_chain_segment)");
  }
  if (!(narrow::magnitude(pose_b.p - pose_a.p) < kFarAway)) return {};
  const Hull hull_a = narrow::hull_of(a), hull_b = narrow::hull_of(b);
  const int rank_a = narrow::rank_of(a.kind), rank_b = narrow::rank_of(b.kind);
  if (rank_a == 0 && rank_b == 0) return discs(a, pose_a, b, pose_b, margin);
  bool exchange = rank_a < rank_b;
  if (rank_a == rank_b) {
    if (rank_a == 2) return {};
    if (cache != nullptr && cache->valid && cache->slack <= 0 &&
        apart_on_cached_axis(hull_a, pose_a, hull_b, pose_b, margin, cache->axis)) {
      if (stats != nullptr) {
        stats->axes_tested += 1;
        stats->axes_skipped += static_cast<std::uint64_t>(hull_a.count + hull_b.count - 1);
      }
      return {};
    }
    exchange = narrow::second_comes_first(a, pose_a, b, pose_b);
  } else {
    cache = nullptr;
  }
  if (cache != nullptr && cache->exchanged != exchange) {
    // The search's first shape was the other one: what it knows is in the wrong frame.
    cache->slack = -1;
    cache->valid = false;
    cache->exchanged = exchange;
  }
  const Transform& frame = exchange ? pose_b : pose_a;
  const Transform relative = narrow::relative_pose(frame, exchange ? pose_a : pose_b);
  // The cache speaks of a and b, the search of first and second.
  const auto translate = [&] {
    if (cache == nullptr || !exchange) return;
    cache->axis = ~cache->axis;
    cache->partner = ~cache->partner;
  };
  translate();
  const LocalManifold local = exchange ? narrow::meet(hull_b, hull_a, relative, margin, cache, stats)
                                       : narrow::meet(hull_a, hull_b, relative, margin, cache, stats);
  translate();
  const Manifold m = to_world_frame(local, frame);
  return exchange ? mirrored(m) : m;
}

}  // namespace

Manifold collide(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b,
                 double margin, SatCache* cache, NarrowPhaseStats* stats) {
  const Manifold m = dispatch(a, pose_a, b, pose_b, margin, cache, stats);
  if (stats != nullptr) {
    stats->pairs += 1;
    stats->manifolds += m.count > 0 ? 1 : 0;
  }
  return m;
}

}  // namespace skerry
