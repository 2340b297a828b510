// SPDX-License-Identifier: MIT
#include "physics/narrowphase/collide.h"

#include <stdexcept>

#include "physics/narrowphase/hull.h"

namespace skerry {
namespace {

using narrow::Hull;

/// Beyond this distance of the bodies [m] their squares would overflow; they do not touch.
constexpr double kFarAway = 1.0e100;

void discs(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b, double margin,
           Manifold& m) {
  // All differences change sign exactly when the discs are exchanged.
  const Vec2 ca = rotate(pose_a.q, a.vertices[0]), cb = rotate(pose_b.q, b.vertices[0]);
  const Vec2 d = (pose_b.p - pose_a.p) + (cb - ca);
  const double radii = a.radius + b.radius;
  const double square = dot(d, d);
  if (!(square <= (radii + margin) * (radii + margin))) return;
  const double distance = std::sqrt(square);
  const bool along = distance > narrow::kNoDirection;
  const bool down = !along && narrow::second_comes_first(a, pose_a, b, pose_b);
  const Vec2 n = along ? d / distance : Vec2{0, down ? -1.0 : 1.0};
  // The middle of the two surface points; the sum is symmetric too.
  const Vec2 middle = 0.5 * ((pose_a.p + ca) + (pose_b.p + cb));
  m.count = 1;
  m.normal = n;
  m.points[0].position = middle + (0.5 * (a.radius - b.radius)) * n;
  m.points[0].separation = distance - radii;
  m.points[0].feature = make_feature(corner_code(0), corner_code(0));
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

void dispatch(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b, double margin,
              SatCache* cache, NarrowPhaseStats* stats, Manifold& m) {
  if (a.kind == ShapeKind::Disc && b.kind == ShapeKind::Disc) return discs(a, pose_a, b, pose_b, margin, m);
  if (a.kind == ShapeKind::Chain || b.kind == ShapeKind::Chain) {
    throw std::invalid_argument("collide: a chain is met segment by segment (collide_chain_segment)");
  }
  const Vec2 d = pose_b.p - pose_a.p;
  if (!(narrow::magnitude(d) < kFarAway)) return;
  const Hull hulls[2] = {narrow::hull_of(a), narrow::hull_of(b)};
  const int rank_a = narrow::rank_of(a.kind), rank_b = narrow::rank_of(b.kind);
  bool exchange = rank_a < rank_b;
  if (rank_a == rank_b) {
    if (rank_a == 2) return;
    if (cache != nullptr && cache->valid && cache->slack <= 0 &&
        apart_on_cached_axis(hulls[0], pose_a, hulls[1], pose_b, margin, cache->axis)) {
      if (stats != nullptr) {
        stats->axes_tested += 1;
        stats->axes_skipped += static_cast<std::uint64_t>(hulls[0].count + hulls[1].count - 1);
      }
      return;
    }
    exchange = narrow::second_comes_first(a, pose_a, b, pose_b);
  } else {
    cache = nullptr;
  }
  const Transform& frame = exchange ? pose_b : pose_a;
  const Transform& other = exchange ? pose_a : pose_b;
  narrow::Output out{m, frame, exchange, {}};
  const Transform relative = narrow::relative_pose(frame, other);
  const Hull& first = hulls[exchange ? 1 : 0];
  const Hull& second = hulls[exchange ? 0 : 1];
  if (cache == nullptr) return narrow::meet(first, second, relative, margin, nullptr, stats, out);
  if (cache->exchanged != exchange) {
    // The search's first shape was the other one: what it knows is in the wrong frame.
    cache->slack = -1;
    cache->valid = false;
    cache->exchanged = exchange;
  }
  // The cache speaks of a and b, the search of first and second.
  const std::int32_t flip = exchange ? -1 : 0;
  cache->axis ^= flip;
  cache->partner ^= flip;
  narrow::meet(first, second, relative, margin, cache, stats, out);
  cache->axis ^= flip;
  cache->partner ^= flip;
}

}  // namespace

Manifold collide(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b,
                 double margin, SatCache* cache, NarrowPhaseStats* stats) {
  Manifold m;
  dispatch(a, pose_a, b, pose_b, margin, cache, stats, m);
  if (stats != nullptr) {
    stats->pairs += 1;
    stats->manifolds += m.count > 0 ? 1 : 0;
  }
  return m;
}

}  // namespace skerry
