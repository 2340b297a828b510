// SPDX-License-Identifier: MIT
//
// Inside the narrow phase: two edges that lie on each other, and the ends of their contact segment.
#pragma once

#include <algorithm>

#include "physics/narrowphase/hull.h"
#include "physics/narrowphase/lanes.h"

namespace skerry::narrow {

/// Without a branch.
constexpr std::uint32_t mirrored_if(bool exchange, std::uint32_t feature) {
  return feature ^ ((feature ^ mirrored(feature)) & -std::uint32_t{exchange});
}

/// Order of points: ascending by the pair of codes without regard to who is first, then by the first's code.
/// Exchanging the shapes or the reference face does not exchange the points.
inline bool in_order(std::uint32_t f, std::uint32_t g) {
  const auto key = [](std::uint32_t feature) {
    return std::uint64_t{std::min(feature, mirrored(feature))} << 32 | feature;
  };
  return key(f) <= key(g);
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

/// @tparam N  corners of both cores; 0: any number
template <int N = 0>
[[gnu::always_inline]] inline Edges edges_of(const Hull& a, const Hull& b, const Placed& placed,
                                             const Axis& axis) {
  static_assert((N & (N - 1)) == 0);
  // Masks instead of branches, here and below.
  const auto if_set = [](bool on, int i) { return i & -static_cast<int>(on); };
  const auto after = [&](int i, int count) {
    return N > 0 ? (i + 1) & (N - 1) : if_set(i + 1 < count, i + 1);
  };
  Edges e;
  e.reference_is_a = axis.index >= 0;
  const int edge = e.reference_is_a ? axis.index : ~axis.index;
  // Which core is the reference is a coin toss, so it is selected by data and not by branches.
  const Hull& ref = *chosen(e.reference_is_a, &a, &b);
  const Hull& inc = *chosen(e.reference_is_a, &b, &a);
  const Vec2* const placed_v = placed.v;
  const Vec2* ref_v = chosen(e.reference_is_a, a.v, placed_v);
  const Vec2* inc_v = chosen(e.reference_is_a, placed_v, a.v);
  e.n = axis.n;
  // Of the two edges at the deepest corner the one that faces the reference edge is incident.
  const int before =
      N > 0 ? (axis.support + N - 1) & (N - 1) : axis.support - 1 + if_set(axis.support == 0, inc.count);
  const Vec2 back = inverse_rotate(placed.turn, e.n);
  const Two n_inc = chosen(everywhere(e.reference_is_a), Two::of(back.x, back.y), Two::of(e.n.x, e.n.y));
  const Two n_before = n_inc * load(inc.n[before]), n_support = n_inc * load(inc.n[axis.support]);
  const bool take_before = n_before.low() + n_before.high() < n_support.low() + n_support.high();
  const int incident = N > 0 ? (take_before ? before : axis.support)
                             : axis.support ^ if_set(take_before, axis.support ^ before);
  e.i0 = edge;
  e.i1 = after(edge, ref.count);
  e.j0 = incident;
  e.j1 = after(incident, inc.count);
  e.p0 = ref_v + e.i0;
  e.p1 = ref_v + e.i1;
  e.q0 = inc_v + e.j0;
  e.q1 = inc_v + e.j1;
  const Vec2 tangent = perp(e.n);
  const double base = dot(e.n, *e.p0);
  e.len = dot(tangent, *e.p1 - *e.p0);
  const Two q0 = load(*e.q0), q1 = load(*e.q1), qx = lows(q0, q1), qy = highs(q0, q1);
  const Two along =
      Two::both(tangent.x) * (qx - Two::both(e.p0->x)) + Two::both(tangent.y) * (qy - Two::both(e.p0->y));
  const Two above = (Two::both(e.n.x) * qx + Two::both(e.n.y) * qy) - Two::both(base);
  e.x0 = along.low();
  e.x1 = along.high();
  e.y0 = above.low();
  e.y1 = above.high();
  e.from_ref = 0.5 * (ref.radius - inc.radius);
  return e;
}

inline std::uint32_t feature_of(const Edges& e, std::uint32_t ref_code, std::uint32_t inc_code) {
  return mirrored_if(!e.reference_is_a, make_feature(ref_code, inc_code));
}

inline void write_normal(const Edges& e, Vec2 n, NormalFrom from, Output& out) {
  out.normal(flipped(Two::of(n.x, n.y), everywhere(!e.reference_is_a)), from);
}
inline NormalFrom reference_of(const Edges& e) {
  return e.reference_is_a ? NormalFrom::First : NormalFrom::Second;
}

/// Writes the contact segment's ends: at the start of the reference edge corner q1 where that lies above the
/// edge, else p0; at its other corner q0 or p1. Both at once, in the lanes, up to their places in the result.
/// @param only  bit 0: the start is wanted, bit 1: the end
[[gnu::always_inline]] inline void write_ends(const Edges& e, double label, double radii, double limit,
                                              unsigned only, Output& out) {
  const double slope = (e.y0 - e.y1) / (e.x0 - e.x1);
  const Two over = Two::of(e.x1, e.len - e.x0), zero = Two::both(0);
  const Two inside = at_least(over, zero);
  const unsigned inc = bits(inside), both = bits(at_least(Two::both(label), magnitude(over)));
  const Two y = Two::of(e.y1, e.y0) + Two::of(-slope, slope) * lesser(over, zero);
  const unsigned keep = bits(at_least(Two::both(limit), y)) & only;
  // Midway between the surfaces, from the corner that is the end.
  const Two half = Two::both(0.5), offset = Two::both(e.from_ref) + chosen(inside, negated(half), half) * y;
  const Two q0 = load(*e.q0), q1 = load(*e.q1), p0 = load(*e.p0), p1 = load(*e.p1);
  const Two x = chosen(inside, lows(q1, q0), lows(p0, p1)) + offset * Two::both(e.n.x);
  const Two z = chosen(inside, highs(q1, q0), highs(p0, p1)) + offset * Two::both(e.n.y);
  const Two c = Two::both(out.frame.q.c), s = Two::both(out.frame.q.s);
  const Two wx = Two::both(out.frame.p.x) + (c * x - s * z), wy = Two::both(out.frame.p.y) + (s * x + c * z);
  const Two separation = y - Two::both(radii);
  // A corner of the reference edge unless only the other core has one here, and the other way round.
  const unsigned ref_corner = ~inc | both, inc_corner = inc | both;
  const std::uint32_t edge = edge_code(e.i0), incident = edge_code(e.j0);
  const auto code = [](unsigned is_corner, int corner, std::uint32_t otherwise) {
    return otherwise ^ ((otherwise ^ corner_code(corner)) & -(is_corner & 1));
  };
  const std::uint32_t at_start =
      feature_of(e, code(ref_corner, e.i0, edge), code(inc_corner, e.j1, incident));
  const std::uint32_t at_end =
      feature_of(e, code(ref_corner >> 1, e.i1, edge), code(inc_corner >> 1, e.j0, incident));
  // Whether one or two are kept is hard to foresee, so both are written; one that is not counts for nothing.
  const unsigned swapped = in_order(at_start, at_end) ? 0 : 1;
  const unsigned slot = keep >> 1 & (swapped | ~keep) & 1;
  out.m.count = static_cast<int>((keep & 1) + (keep >> 1));
  ManifoldPoint &start = out.m.points[slot], &end = out.m.points[slot ^ 1];
  lows(wx, wy).store(&start.position.x);
  highs(wx, wy).store(&end.position.x);
  start.separation = separation.low();
  end.separation = separation.high();
  start.feature = mirrored_if(out.exchange, at_start);
  end.feature = mirrored_if(out.exchange, at_end);
}

inline double overlap_of(const Edges& e) {
  const Two ends = lesser(Two::of(e.len, -e.x1), Two::of(e.x0, 0));
  return ends.low() + ends.high();
}
inline double label_of(const Edges& e) {
  return kCornerOnCorner * std::min(e.len, e.x0 - e.x1);
}
/// Where no more of the edges lies on each other there is one point: two corners meet, or nearly so, and a
/// second point would come and go.
inline double least_overlap_of(const Edges& e, double noise) {
  return std::max(noise, label_of(e));
}

/// How far a corner of the incident edge lies beside the reference edge and above it, together. Where so
/// little of the edges lies on each other that there is one point, it is the corner with the lesser sum: of
/// edges that are parallel the one that is there, of others the deeper one. @pre the edges do not lie beside
/// each other
inline double aside_of_start(const Edges& e) {
  return e.y0 + std::max(0.0, e.x0 - e.len);
}
inline double aside_of_end(const Edges& e) {
  return e.y1 + std::max(0.0, -e.x1);
}

/// One corner above the edge, or so little overlap that a second point would be the same.
void write_single(const Edges& e, double radii, double limit, Output& out);

/// Cores that do not overlap: two corners may be closest.
void clip_touching(const Hull& a, const Hull& b, const Placed& placed, const Axis& axis, double margin,
                   Output& out);

/// Cores that overlap.
template <int N = 0>
[[gnu::always_inline]] inline void clip_overlap(const Hull& a, const Hull& b, const Placed& placed,
                                                const Axis& axis, double margin, Output& out) {
  const Edges e = edges_of<N>(a, b, placed, axis);
  const double radii = a.radius + b.radius, limit = margin + radii;
  if (!(overlap_of(e) > least_overlap_of(e, kNoise * axis.scale))) return write_single(e, radii, limit, out);
  write_normal(e, e.n, reference_of(e), out);
  write_ends(e, label_of(e), radii, limit, 3, out);
}

}  // namespace skerry::narrow
