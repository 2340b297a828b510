// SPDX-License-Identifier: MIT
//
// Contacts of one pair in the frame of its first shape.
#include "physics/narrowphase/hull.h"

namespace skerry::narrow {
namespace {

void discs(const Hull& a, const Hull& b, const Transform& relative, double margin, Output& out) {
  const Vec2 gap = (relative.p + rotate(relative.q, b.v[0])) - a.v[0];
  const double distance = length(gap), radii = a.radius + b.radius;
  if (!(distance <= radii + margin)) return;
  const Vec2 n = distance > kNoDirection ? gap / distance : Vec2{0, 1};
  out.normal(n, NormalFrom::Corners);
  out.point(0, a.v[0] + (0.5 * (distance + a.radius - b.radius)) * n, distance - radii,
            make_feature(corner_code(0), corner_code(0)));
  out.m.count = 1;
}

void hull_and_disc(const Hull& hull, const Hull& disc, const Transform& relative, double margin,
                   NarrowPhaseStats* stats, Output& out) {
  const Vec2 c = relative.p + rotate(relative.q, disc.v[0]);
  const double radii = hull.radius + disc.radius, limit = radii + margin;

  // The edge whose line is farthest; the first one where several are.
  int edge = 0;
  double height = -kInfinity;
  double bias = 0;
  for (int i = 0; i < hull.count; ++i) {
    const double value = dot(hull.n[i], c - hull.v[i]);
    if (value > limit) {
      if (stats != nullptr) stats->axes_tested += static_cast<std::uint64_t>(i + 1);
      return;
    }
    if (value > height + bias) {
      height = value;
      edge = i;
      bias = kAxisBias * magnitude(hull.v[i]);
    }
  }
  if (stats != nullptr) stats->axes_tested += static_cast<std::uint64_t>(hull.count);

  const int next = edge + 1 < hull.count ? edge + 1 : 0;
  const Vec2 v0 = hull.v[edge], v1 = hull.v[next];
  Vec2 n = hull.n[edge];
  NormalFrom from = NormalFrom::First;
  const double noise = kNoise * (magnitude(c) + magnitude(v0) + magnitude(v1));
  double distance = height;
  std::uint32_t code = edge_code(edge);
  if (height >= -noise) {
    // Beyond an end of the edge the corner is closest.
    const bool before = dot(perp(n), c - v0)<0, behind = dot(perp(n), c - v1)> 0;
    if (before || behind) {
      const Vec2 gap = c - (before ? v0 : v1);
      const double gap_length = length(gap);
      if (gap_length > limit) return;
      code = corner_code(before ? edge : next);
      if (gap_length > noise) {
        distance = gap_length;
        n = gap / gap_length;
        from = NormalFrom::Corners;
      }
    }
  }
  out.normal(n, from);
  out.point(0, c - (0.5 * (distance - hull.radius + disc.radius)) * n, distance - radii,
            make_feature(code, corner_code(0)));
  out.m.count = 1;
}

void half_plane_and_hull(const Hull& plane, const Hull& hull, const Transform& relative, double margin,
                         Output& out) {
  const Vec2 n = plane.n[0];
  // Height of the second body's origin above the line.
  const double base = dot(n, relative.p - plane.v[0]);
  const Vec2 n_local = inverse_rotate(relative.q, n);
  const auto height_of = [&](int i) { return base + dot(n_local, hull.v[i]) - hull.radius; };
  int deepest = 0;
  double height = height_of(0);
  for (int i = 1; i < hull.count; ++i) {
    const double value = height_of(i);
    if (value < height) {
      height = value;
      deepest = i;
    }
  }
  if (!(height <= margin)) return;
  out.normal(n, NormalFrom::First);
  const auto put = [&](int slot, int corner, double separation) {
    const Vec2 centre = relative.p + rotate(relative.q, hull.v[corner]);
    out.point(slot, centre - (hull.radius + 0.5 * separation) * n, separation,
              make_feature(edge_code(0), corner_code(corner)));
  };
  out.m.count = 1;
  if (hull.count == 1) return put(0, 0, height);
  // The other end of the edge that faces the plane.
  const int next = deepest + 1 < hull.count ? deepest + 1 : 0;
  const int before = deepest > 0 ? deepest - 1 : hull.count - 1;
  const bool take_next = dot(n_local, hull.n[deepest]) <= dot(n_local, hull.n[before]);
  const int other = take_next ? next : before;
  const double separation = height_of(other);
  if (!(separation <= margin)) return put(0, deepest, height);
  put(deepest < other ? 0 : 1, deepest, height);
  put(deepest < other ? 1 : 0, other, separation);
  out.m.count = 2;
}

}  // namespace

void meet(const Hull& a, const Hull& b, const Transform& relative, double margin, SatCache* cache,
          NarrowPhaseStats* stats, Output& out) {
  if (a.kind == ShapeKind::HalfPlane) return half_plane_and_hull(a, b, relative, margin, out);
  if (a.kind == ShapeKind::Disc) return discs(a, b, relative, margin, out);
  if (b.kind == ShapeKind::Disc) return hull_and_disc(a, b, relative, margin, stats, out);
  Placed placed;
  const Axis axis = find_axis(a, b, relative, margin + a.radius + b.radius, placed, cache, stats);
  if (!axis.apart) clip(a, b, placed, axis, margin, out);
}

}  // namespace skerry::narrow
