// SPDX-License-Identifier: MIT
//
// From the axis of least penetration to contact points: the incident edge is cut to the extent of the
// reference edge, and its two ends are the extremes of the contact segment [Ericson 2005, sec. 5.2.4; Catto
// 2007]. An end is a corner of one core against an edge of the other whichever core the axis came from, so
// the feature ids do not depend on that choice.
#include <algorithm>

#include "physics/narrowphase/hull.h"

namespace skerry::narrow {
namespace {

/// Order of points: ascending by the pair of codes without regard to who is first, then by the first's code.
/// Exchanging the shapes or the reference face does not exchange the points.
bool in_order(std::uint32_t f, std::uint32_t g) {
  const auto key = [](std::uint32_t feature) {
    const std::uint32_t high = feature >> 16, low = feature & 0xffffu;
    return make_feature(std::min(high, low), std::max(high, low));
  };
  const std::uint32_t first = key(f), second = key(g);
  return first != second ? first < second : f <= g;
}

/// The reference edge p0 -> p1 and the incident edge q0 -> q1 of an axis, and where they lie on each other.
struct Edges {
  bool reference_is_a;
  int i0, i1, j0, j1;  // corners
  Vec2 n;              // of the reference edge
  const Vec2 *p0, *p1, *q0, *q1;
  double len;  // of the reference edge
  double x0, x1, y0,
      y1;           // q0 and q1 along the tangent and the normal, from p0; x0 > x1 as the edges are opposed
  double from_ref;  // middle between the surfaces: half the difference of the radii
};

inline Edges edges_of(const Hull& a, const Hull& b, const Placed& placed, const Axis& axis) {
  Edges e;
  e.reference_is_a = axis.index >= 0;
  const int edge = e.reference_is_a ? axis.index : ~axis.index;
  // Which core is the reference is a coin toss, so it is selected by data and not by branches; a rotation by
  // nothing is exact.
  const Hull& ref = e.reference_is_a ? a : b;
  const Hull& inc = e.reference_is_a ? b : a;
  const Vec2* ref_v = e.reference_is_a ? a.v : placed.v;
  const Vec2* inc_v = e.reference_is_a ? placed.v : a.v;
  e.n = rotate(e.reference_is_a ? Rot{} : placed.turn, ref.n[edge]);
  // Of the two edges at the deepest corner the one that faces the reference edge is incident.
  const int before = axis.support > 0 ? axis.support - 1 : inc.count - 1;
  const Vec2 n_inc =
      inverse_rotate(e.reference_is_a ? placed.turn : Rot{}, e.n);  // in the incident core's frame
  const int incident = dot(n_inc, inc.n[before]) < dot(n_inc, inc.n[axis.support]) ? before : axis.support;
  e.i0 = edge;
  e.i1 = edge + 1 < ref.count ? edge + 1 : 0;
  e.j0 = incident;
  e.j1 = incident + 1 < inc.count ? incident + 1 : 0;
  e.p0 = ref_v + e.i0;
  e.p1 = ref_v + e.i1;
  e.q0 = inc_v + e.j0;
  e.q1 = inc_v + e.j1;
  const Vec2 tangent = perp(e.n);
  const double base = dot(e.n, *e.p0);
  e.len = dot(tangent, *e.p1 - *e.p0);
  e.x0 = dot(tangent, *e.q0 - *e.p0);
  e.x1 = dot(tangent, *e.q1 - *e.p0);
  e.y0 = dot(e.n, *e.q0) - base;
  e.y1 = dot(e.n, *e.q1) - base;
  e.from_ref = 0.5 * (ref.radius - inc.radius);
  return e;
}

inline std::uint32_t feature_of(const Edges& e, std::uint32_t ref_code, std::uint32_t inc_code) {
  const std::uint32_t feature = make_feature(ref_code, inc_code);
  return e.reference_is_a ? feature : mirrored(feature);
}

inline void write_normal(const Edges& e, Vec2 n, NormalFrom from, Output& out) {
  out.normal(e.reference_is_a ? n : -n, from);
}
inline NormalFrom reference_of(const Edges& e) {
  return e.reference_is_a ? NormalFrom::First : NormalFrom::Second;
}

/// One end of the contact segment.
struct End {
  Vec2 position;
  double separation;
  std::uint32_t feature;
  bool keep;
};

// By index: a branch on which core has the corner would be a coin toss.
constexpr double kHalf[2] = {0.5, -0.5};

/// The end at the start of the reference edge: q1 where that lies above the edge, else p0.
inline End end_at_start(const Edges& e, double slope, double label, double radii, double limit) {
  const bool inc = e.x1 >= 0, both = std::abs(e.x1) <= label;
  const double y = e.y1 - slope * std::min(e.x1, 0.0);
  const double offset = e.from_ref + kHalf[inc ? 1 : 0] * y;
  const Vec2* corner = inc ? e.q1 : e.p0;
  return {*corner + offset * e.n, y - radii,
          feature_of(e, both || !inc ? corner_code(e.i0) : edge_code(e.i0),
                     both || inc ? corner_code(e.j1) : edge_code(e.j0)),
          y <= limit};
}

/// The end at its other corner: q0 or p1.
inline End end_at_end(const Edges& e, double slope, double label, double radii, double limit) {
  const double over = e.len - e.x0;
  const bool inc = over >= 0, both = std::abs(over) <= label;
  const double y = e.y0 + slope * std::min(over, 0.0);
  const double offset = e.from_ref + kHalf[inc ? 1 : 0] * y;
  const Vec2* corner = inc ? e.q0 : e.p1;
  return {*corner + offset * e.n, y - radii,
          feature_of(e, both || !inc ? corner_code(e.i1) : edge_code(e.i0),
                     both || inc ? corner_code(e.j0) : edge_code(e.j0)),
          y <= limit};
}

inline void write_points(const End& start, const End& end, Output& out) {
  const int both = start.keep && end.keep ? 1 : 0;
  const int slot = both & (in_order(start.feature, end.feature) ? 0 : 1);
  if (start.keep) out.point(slot, start.position, start.separation, start.feature);
  if (end.keep) out.point(both - slot, end.position, end.separation, end.feature);
  out.m.count = (start.keep ? 1 : 0) + (end.keep ? 1 : 0);
}

inline double overlap_of(const Edges& e) {
  return std::min(e.len, e.x0) - std::max(0.0, e.x1);
}
inline double label_of(const Edges& e) {
  return kCornerOnCorner * std::min(e.len, e.x0 - e.x1);
}

/// One corner above the edge, or so little overlap that a second point would be the same.
void write_single(const Edges& e, double radii, double limit, Output& out) {
  const bool first = e.y0 < e.y1;
  const double y = first ? e.y0 : e.y1;
  if (!(y <= limit)) return;
  write_normal(e, e.n, reference_of(e), out);
  out.point(0, *(first ? e.q0 : e.q1) + (e.from_ref - 0.5 * y) * e.n, y - radii,
            feature_of(e, edge_code(e.i0), corner_code(first ? e.j0 : e.j1)));
  out.m.count = 1;
}

/// Cores that do not overlap: two corners may be closest.
void clip_apart(const Hull& a, const Hull& b, const Placed& placed, const Axis& axis, double margin,
                bool may_turn, Output& out) {
  const Edges e = edges_of(a, b, placed, axis);
  const double radii = a.radius + b.radius, limit = margin + radii, noise = kNoise * axis.scale;
  const double overlap = overlap_of(e);
  const bool disjoint = overlap < 0;
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
    turned.support = at_start ? e.i0 : e.i1;
    return clip_apart(a, b, placed, turned, margin, false, out);
  }
  const bool corners = disjoint || (beside && beyond);
  if (!corners && !(overlap > noise)) return write_single(e, radii, limit, out);
  End nearest{};
  Vec2 normal = e.n;
  NormalFrom from = reference_of(e);
  if (corners) {
    const bool take_q0 =
        disjoint ? length_squared(*e.q0 - corner) < length_squared(*e.q1 - corner) : deepest_is_q0;
    const Vec2 gap = *(take_q0 ? e.q0 : e.q1) - corner;
    const double distance = length(gap);
    if (distance > limit) return;
    double height = take_q0 ? e.y0 : e.y1;
    if (distance > noise) {
      normal = gap / distance;
      height = distance;
      from = NormalFrom::Corners;
    }
    nearest = {corner + (0.5 * height + e.from_ref) * normal, height - radii,
               feature_of(e, corner_code(at_start ? e.i0 : e.i1), corner_code(take_q0 ? e.j0 : e.j1)), true};
  }
  write_normal(e, normal, from, out);
  End start{}, end{};
  if (overlap > noise) {
    const double slope = (e.y0 - e.y1) / (e.x0 - e.x1), label = label_of(e);
    start = end_at_start(e, slope, label, radii, limit);
    end = end_at_end(e, slope, label, radii, limit);
  }
  if (corners) (at_start ? start : end) = nearest;
  write_points(start, end, out);
}

}  // namespace

Closest closest(const Hull& a, const Hull& b, const Placed& placed, const Axis& axis) {
  const bool reference_is_a = axis.index >= 0;
  const int edge = reference_is_a ? axis.index : ~axis.index;
  const Hull& ref = reference_is_a ? a : b;
  const Hull& inc = reference_is_a ? b : a;
  const Vec2* ref_v = reference_is_a ? a.v : placed.v;
  const Vec2* inc_v = reference_is_a ? placed.v : a.v;
  const Vec2 n = rotate(reference_is_a ? Rot{} : placed.turn, ref.n[edge]);
  const double towards_b = reference_is_a ? 1 : -1;
  const Closest face{towards_b * n, axis.separation, reference_is_a ? NormalFrom::First : NormalFrom::Second};
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
  return {(towards_b / distance) * gap, distance, NormalFrom::Corners};
}

void clip(const Hull& a, const Hull& b, const Placed& placed, const Axis& axis, double margin, Output& out) {
  const double noise = kNoise * axis.scale;
  if (axis.separation >= -noise) return clip_apart(a, b, placed, axis, margin, true, out);
  const Edges e = edges_of(a, b, placed, axis);
  const double radii = a.radius + b.radius, limit = margin + radii;
  if (!(overlap_of(e) > noise)) return write_single(e, radii, limit, out);
  const double slope = (e.y0 - e.y1) / (e.x0 - e.x1), label = label_of(e);
  write_normal(e, e.n, reference_of(e), out);
  write_points(end_at_start(e, slope, label, radii, limit), end_at_end(e, slope, label, radii, limit), out);
}

}  // namespace skerry::narrow
