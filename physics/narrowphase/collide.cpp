// SPDX-License-Identifier: MIT
#include "physics/narrowphase/collide.h"

#include <stdexcept>

#include "physics/narrowphase/hull.h"

namespace skerry {
namespace {

using narrow::Axis;
using narrow::Hull;
using narrow::LocalManifold;
using narrow::Placed;

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

/// A core with edges against a disc; a is the core.
Manifold hull_and_disc(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b,
                       double margin, NarrowPhaseStats* stats) {
  const Hull hull = narrow::hull_of(a);
  const Transform relative = narrow::relative_pose(pose_a, pose_b);
  const Vec2 c = relative.p + rotate(relative.q, b.vertices[0]);
  const double radii = a.radius + b.radius, limit = radii + margin;

  // The edge whose line is farthest; the first one where several are.
  int edge = 0;
  double height = -kInfinity;
  double bias = 0;
  for (int i = 0; i < hull.count; ++i) {
    const double value = dot(hull.n[i], c - hull.v[i]);
    if (value > limit) {
      if (stats != nullptr) stats->axes_tested += static_cast<std::uint64_t>(i + 1);
      return {};
    }
    if (value > height + bias) {
      height = value;
      edge = i;
      bias = narrow::kAxisBias * narrow::magnitude(hull.v[i]);
    }
  }
  if (stats != nullptr) stats->axes_tested += static_cast<std::uint64_t>(hull.count);

  const int next = edge + 1 < hull.count ? edge + 1 : 0;
  const Vec2 v0 = hull.v[edge], v1 = hull.v[next];
  const Vec2 n = hull.n[edge];
  const double scale = narrow::magnitude(c) + narrow::magnitude(v0) + narrow::magnitude(v1);
  const double noise = narrow::kNoise * scale;
  LocalManifold m;
  m.normal = n;
  double distance = height;
  std::uint32_t code = edge_code(edge);
  if (height >= -noise) {
    // Beyond an end of the edge the corner is closest.
    const bool before = dot(perp(n), c - v0)<0, behind = dot(perp(n), c - v1)> 0;
    if (before || behind) {
      const Vec2 gap = c - (before ? v0 : v1);
      const double gap_length = length(gap);
      if (gap_length > limit) return {};
      code = corner_code(before ? edge : next);
      if (gap_length > noise) {
        distance = gap_length;
        m.normal = gap / gap_length;
      }
    }
  }
  m.count = 1;
  m.points[0] = {c - (0.5 * (distance - a.radius + b.radius)) * m.normal, distance - radii,
                 make_feature(code, corner_code(0))};
  return to_world_frame(m, pose_a);
}

/// A half-plane (a) against a core of any number of corners.
Manifold half_plane_and_hull(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b,
                             double margin) {
  const Hull hull = narrow::hull_of(b);
  const Vec2 n = rotate(pose_a.q, a.normals[0]);
  // Height of b's origin above the line.
  const double base = dot(n, (pose_b.p - pose_a.p) - rotate(pose_a.q, a.vertices[0]));
  const auto height_of = [&](int i) { return base + dot(n, rotate(pose_b.q, hull.v[i])) - hull.radius; };
  int deepest = 0;
  double height = height_of(0);
  for (int i = 1; i < hull.count; ++i) {
    const double value = height_of(i);
    if (value < height) {
      height = value;
      deepest = i;
    }
  }
  Manifold m;
  if (!(height <= margin)) return m;
  m.normal = n;
  const auto add = [&](int corner, double separation) {
    const Vec2 centre = pose_b.p + rotate(pose_b.q, hull.v[corner]);
    m.points[m.count++] = {centre - (hull.radius + 0.5 * separation) * n, separation,
                           make_feature(edge_code(0), corner_code(corner))};
  };
  add(deepest, height);
  if (hull.count >= 2) {
    // The other end of the edge that faces the plane.
    const int next = deepest + 1 < hull.count ? deepest + 1 : 0;
    const int before = deepest > 0 ? deepest - 1 : hull.count - 1;
    const double height_next = height_of(next), height_before = height_of(before);
    const Vec2 n_local = inverse_rotate(pose_b.q, n);
    const bool take_next = dot(n_local, hull.n[deepest]) <= dot(n_local, hull.n[before]);
    const int other = take_next ? next : before;
    const double separation = take_next ? height_next : height_before;
    if (separation <= margin) add(other, separation);
    if (m.count == 2 && other < deepest) std::swap(m.points[0], m.points[1]);
  }
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

Manifold hulls(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b,
               double margin, SatCache* cache, NarrowPhaseStats* stats) {
  const Hull hull_a = narrow::hull_of(a), hull_b = narrow::hull_of(b);
  if (cache != nullptr && cache->valid && cache->slack <= 0 &&
      apart_on_cached_axis(hull_a, pose_a, hull_b, pose_b, margin, cache->axis)) {
    if (stats != nullptr) {
      stats->axes_tested += 1;
      stats->axes_skipped += static_cast<std::uint64_t>(hull_a.count + hull_b.count - 1);
    }
    return {};
  }
  const bool exchange = narrow::second_comes_first(a, pose_a, b, pose_b);
  const Hull& first = exchange ? hull_b : hull_a;
  const Hull& second = exchange ? hull_a : hull_b;
  const Transform& frame = exchange ? pose_b : pose_a;
  const Transform relative = narrow::relative_pose(frame, exchange ? pose_a : pose_b);
  if (cache != nullptr) {
    // The cache speaks of a and b, the search of first and second.
    const bool fits = cache->valid && cache->exchanged == exchange;
    if (!fits) cache->slack = -1;
    cache->exchanged = exchange;
    if (exchange) {
      cache->axis = ~cache->axis;
      cache->partner = ~cache->partner;
    }
  }
  Placed placed;
  const Axis axis =
      narrow::find_axis(first, second, relative, margin + a.radius + b.radius, placed, cache, stats);
  if (cache != nullptr && exchange) {
    cache->axis = ~cache->axis;
    cache->partner = ~cache->partner;
  }
  if (axis.apart) return {};
  const Manifold m = to_world_frame(narrow::clip(first, second, placed, axis, margin), frame);
  return exchange ? mirrored(m) : m;
}

Manifold dispatch(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b,
                  double margin, SatCache* cache, NarrowPhaseStats* stats) {
  if (a.kind == ShapeKind::Chain || b.kind == ShapeKind::Chain) {
    throw std::invalid_argument("collide: a chain is met segment by segment (collide_chain_segment)");
  }
  if (!(narrow::magnitude(pose_b.p - pose_a.p) < kFarAway)) return {};
  const bool plane_a = a.kind == ShapeKind::HalfPlane, plane_b = b.kind == ShapeKind::HalfPlane;
  if (plane_a && plane_b) return {};
  if (plane_a) return half_plane_and_hull(a, pose_a, b, pose_b, margin);
  if (plane_b) return mirrored(half_plane_and_hull(b, pose_b, a, pose_a, margin));
  const bool disc_a = a.kind == ShapeKind::Disc, disc_b = b.kind == ShapeKind::Disc;
  if (disc_a && disc_b) return discs(a, pose_a, b, pose_b, margin);
  if (disc_b) return hull_and_disc(a, pose_a, b, pose_b, margin, stats);
  if (disc_a) return mirrored(hull_and_disc(b, pose_b, a, pose_a, margin, stats));
  return hulls(a, pose_a, b, pose_b, margin, cache, stats);
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
