// SPDX-License-Identifier: MIT
//
// From the axis of least penetration to contact points: the incident edge is cut to the extent of the
// reference edge, and its two ends are the extremes of the contact segment [Ericson 2005, sec. 5.2.4; Catto
// 2007]. An end is a corner of one core against an edge of the other whichever core the axis came from, so
// the feature ids do not depend on that choice.
#include "physics/narrowphase/clip_edges.h"

namespace skerry::narrow {
namespace {

/// Cores that do not overlap: two corners may be closest.
void clip_apart(const Hull& a, const Hull& b, const Placed& placed, const Axis& axis, double margin,
                bool may_turn, Output& out) {
  const Edges e = edges_of(a, b, placed, axis);
  const double radii = a.radius + b.radius, limit = margin + radii, noise = kNoise * axis.scale;
  const double overlap = overlap_of(e), least = least_overlap_of(e, noise);
  // Not by their overlap: that of an edge which stands upright on the other one is rounding.
  const bool disjoint = e.x0 < 0 || e.x1 > e.len;
  // If the deepest corner lies beside the reference edge and is closer to its end than the incident edge is,
  // these two corners are closest. With edges that are almost parallel the other end may still be in reach,
  // so it is added; the normal lies between those of the edges.
  const bool deepest_is_q0 = axis.support == e.j0;
  const Vec2 deepest = *(deepest_is_q0 ? e.q0 : e.q1), other = *(deepest_is_q0 ? e.q1 : e.q0);
  const double x = deepest_is_q0 ? e.x0 : e.x1;
  const bool at_start = disjoint ? e.x0 < 0 : x < 0;
  const Vec2 corner = *(at_start ? e.p0 : e.p1);
  const bool beside = x < 0 || x > e.len;
  const bool beyond = dot(other - deepest, corner - deepest) <= 0;
  if (!disjoint && beside && !beyond && may_turn && std::abs(e.y0 - e.y1) > 0.1 * noise) {
    // The end of the reference edge is closest to the incident edge's inside: two axes were equal within the
    // bias, but the other one has the exact normal.
    Axis turned = axis;
    turned.index = e.reference_is_a ? ~e.j0 : e.j0;
    turned.n = e.reference_is_a ? rotate(placed.turn, b.n[e.j0]) : a.n[e.j0];
    turned.support = at_start ? e.i0 : e.i1;
    return clip_apart(a, b, placed, turned, margin, false, out);
  }
  const bool corners = disjoint || (beside && beyond);
  if (!corners && !(overlap > least)) return write_single(e, radii, limit, out);
  if (!corners) {
    write_normal(e, e.n, reference_of(e), out);
    return write_ends(e, label_of(e), radii, limit, 3, out);
  }
  const bool take_q0 =
      disjoint ? length_squared(*e.q0 - corner) < length_squared(*e.q1 - corner) : deepest_is_q0;
  const Vec2 gap = *(take_q0 ? e.q0 : e.q1) - corner;
  const double distance = length(gap);
  if (distance > limit) return;
  Vec2 normal = e.n;
  NormalFrom from = reference_of(e);
  double height = take_q0 ? e.y0 : e.y1;
  if (distance > noise) {
    normal = gap / distance;
    height = distance;
    from = NormalFrom::Corners;
  }
  write_normal(e, normal, from, out);
  // The end beside it is these corners; the other one may be in reach.
  if (overlap > least) write_ends(e, label_of(e), radii, limit, at_start ? 2 : 1, out);
  const std::uint32_t feature =
      feature_of(e, corner_code(at_start ? e.i0 : e.i1), corner_code(take_q0 ? e.j0 : e.j1));
  int slot = 0;
  if (out.m.count == 1) {
    const std::uint32_t beside_it =
        out.exchange ? mirrored(out.m.points[0].feature) : out.m.points[0].feature;
    // Where both orders are equal the start comes first.
    const bool first = at_start ? in_order(feature, beside_it) : !in_order(beside_it, feature);
    slot = first ? 0 : 1;
    if (first) out.m.points[1] = out.m.points[0];
  }
  out.point(slot, corner + (0.5 * height + e.from_ref) * normal, height - radii, feature);
  out.m.count += 1;
}

}  // namespace

/// One corner above the edge, or so little overlap that a second point would be the same.
void write_single(const Edges& e, double radii, double limit, Output& out) {
  const bool first = aside_of_start(e) < aside_of_end(e);
  const double y = first ? e.y0 : e.y1;
  if (!(y <= limit)) return;
  write_normal(e, e.n, reference_of(e), out);
  const double x = first ? e.x0 : e.x1, label = kCornerOnCorner * e.len;
  const std::uint32_t ref_code = std::abs(x) <= label           ? corner_code(e.i0)
                                 : std::abs(x - e.len) <= label ? corner_code(e.i1)
                                                                : edge_code(e.i0);
  out.point(0, *(first ? e.q0 : e.q1) + (e.from_ref - 0.5 * y) * e.n, y - radii,
            feature_of(e, ref_code, corner_code(first ? e.j0 : e.j1)));
  out.m.count = 1;
}

Closest closest(const Hull& a, const Hull& b, const Placed& placed, const Axis& axis) {
  const bool reference_is_a = axis.index >= 0;
  const int edge = reference_is_a ? axis.index : ~axis.index;
  const Hull& ref = reference_is_a ? a : b;
  const Hull& inc = reference_is_a ? b : a;
  const Vec2* ref_v = reference_is_a ? a.v : placed.v;
  const Vec2* inc_v = reference_is_a ? placed.v : a.v;
  const Vec2 n = axis.n;
  const double towards_b = reference_is_a ? 1 : -1;
  const Closest face{towards_b * n, axis.separation, reference_is_a ? NormalFrom::First : NormalFrom::Second,
                     reference_is_a ? edge : axis.support, reference_is_a ? axis.support : edge};
  const double noise = kNoise * axis.scale;
  if (axis.separation < -noise) return face;
  const Vec2 p0 = ref_v[edge], p1 = ref_v[edge + 1 < ref.count ? edge + 1 : 0], q = inc_v[axis.support];
  const Vec2 tangent = perp(n);
  const bool before = dot(tangent, q - p0) < 0;
  if (!before && dot(tangent, q - p1) <= 0) return face;
  const Vec2 gap = q - (before ? p0 : p1);
  const double distance = length(gap);
  // A neighbour of the deepest corner that is closer means that two axes were equal within the bias.
  const int next = axis.support + 1 < inc.count ? axis.support + 1 : 0;
  const int previous = axis.support > 0 ? axis.support - 1 : inc.count - 1;
  if (!(distance > noise) || dot(inc_v[next] - q, gap) < 0 || dot(inc_v[previous] - q, gap) < 0) return face;
  const int corner = before ? edge : edge + 1 < ref.count ? edge + 1 : 0;
  return {(towards_b / distance) * gap, distance, NormalFrom::Corners, reference_is_a ? corner : axis.support,
          reference_is_a ? axis.support : corner};
}

void clip(const Hull& a, const Hull& b, const Placed& placed, const Axis& axis, double margin, Output& out,
          bool may_turn) {
  if (axis.separation >= -kNoise * axis.scale) return clip_apart(a, b, placed, axis, margin, may_turn, out);
  clip_overlap(a, b, placed, axis, margin, out);
}

void clip_touching(const Hull& a, const Hull& b, const Placed& placed, const Axis& axis, double margin,
                   Output& out) {
  clip_apart(a, b, placed, axis, margin, true, out);
}

}  // namespace skerry::narrow
