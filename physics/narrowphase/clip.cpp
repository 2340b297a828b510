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

void clip_once(const Hull& a, const Hull& b, const Placed& placed, const Axis& axis, double margin,
               bool may_turn, Output& out) {
  const bool reference_is_a = axis.index >= 0;
  const int edge = reference_is_a ? axis.index : ~axis.index;
  const Hull& ref = reference_is_a ? a : b;
  const Hull& inc = reference_is_a ? b : a;
  // Which core is the reference is a coin toss, so it is selected by data and not by branches; a rotation by
  // nothing is exact.
  const Vec2* ref_v = reference_is_a ? a.v : placed.v;
  const Vec2* inc_v = reference_is_a ? placed.v : a.v;
  const Vec2 n = rotate(reference_is_a ? Rot{} : placed.turn, ref.n[edge]);

  // Of the two edges at the deepest corner the one that faces the reference edge is incident.
  const int before = axis.support > 0 ? axis.support - 1 : inc.count - 1;
  const Vec2 n_inc = inverse_rotate(reference_is_a ? placed.turn : Rot{}, n);  // in the incident core's frame
  const int incident = dot(n_inc, inc.n[before]) < dot(n_inc, inc.n[axis.support]) ? before : axis.support;

  const int i0 = edge, i1 = edge + 1 < ref.count ? edge + 1 : 0;
  const int j0 = incident, j1 = incident + 1 < inc.count ? incident + 1 : 0;
  const Vec2 p0 = ref_v[i0], p1 = ref_v[i1], q0 = inc_v[j0], q1 = inc_v[j1];
  const double radii = a.radius + b.radius;
  const double limit = margin + radii;

  // Along the tangent from p0; the incident edge runs backward, from q0 at x0 down to q1 at x1.
  const Vec2 tangent = perp(n);
  const double len = dot(tangent, p1 - p0);
  const double base = dot(n, p0);
  const double x0 = dot(tangent, q0 - p0), x1 = dot(tangent, q1 - p0);
  const double y0 = dot(n, q0) - base, y1 = dot(n, q1) - base;
  const double low = std::max(0.0, x1), high = std::min(len, x0);
  const double noise = kNoise * axis.scale;

  const auto feature = [reference_is_a](std::uint32_t ref_code, std::uint32_t inc_code) {
    return reference_is_a ? make_feature(ref_code, inc_code) : make_feature(inc_code, ref_code);
  };
  // Half the way between the surfaces, from a point on either core.
  const double from_ref = 0.5 * (ref.radius - inc.radius);
  const NormalFrom own = reference_is_a ? NormalFrom::First : NormalFrom::Second;
  const double towards_b = reference_is_a ? 1 : -1;

  const bool apart = axis.separation >= -noise;
  const bool overlap = high - low > noise;
  // If the deepest corner lies beside the reference edge and is closer to its end than the incident edge is,
  // these two corners are closest. With edges that are almost parallel the other end may still be in reach,
  // so it is added below; the normal lies between those of the edges.
  bool corners = false, corners_at_start = false;
  Vec2 corner_position;
  double corner_separation = 0;
  std::uint32_t corner_feature = 0;
  Vec2 normal = n;
  NormalFrom from = own;
  if (apart) {
    const bool deepest_is_q0 = axis.support == j0;
    const Vec2 deepest = deepest_is_q0 ? q0 : q1, other = deepest_is_q0 ? q1 : q0;
    const double x = deepest_is_q0 ? x0 : x1;
    corners_at_start = low > high ? x0 < 0 : x < 0;
    const Vec2 end = corners_at_start ? p0 : p1;
    const bool beside = x < 0 || x > len;
    const bool beyond = dot(other - deepest, end - deepest) <= 0;
    if (low <= high && beside && !beyond && may_turn && std::abs(y0 - y1) > 0.1 * noise) {
      // The end of the reference edge is closest to the incident edge's inside: two axes were equal within
      // the bias, but the other one has the exact normal.
      Axis turned = axis;
      turned.index = reference_is_a ? ~incident : incident;
      turned.support = corners_at_start ? i0 : i1;
      return clip_once(a, b, placed, turned, margin, false, out);
    }
    corners = low > high || (beside && beyond);
    if (corners) {
      const bool take_q0 = low > high ? length_squared(q0 - end) < length_squared(q1 - end) : deepest_is_q0;
      const Vec2 gap = (take_q0 ? q0 : q1) - end;
      const double distance = length(gap);
      if (distance > limit) return;
      double height = distance;
      if (distance > noise) {
        normal = gap / distance;
        from = NormalFrom::Corners;
      } else {
        height = take_q0 ? y0 : y1;
      }
      corner_position = end + (0.5 * height + from_ref) * normal;
      corner_separation = height - radii;
      corner_feature = feature(corner_code(corners_at_start ? i0 : i1), corner_code(take_q0 ? j0 : j1));
    }
  }
  out.normal(towards_b * normal, from);
  if (!overlap) {
    // One corner above the edge, or so little overlap that a second point would be the same.
    const bool first = y0 < y1;
    const double y = first ? y0 : y1;
    if (corners) {
      out.point(0, corner_position, corner_separation, corner_feature);
    } else if (y <= limit) {
      out.point(0, (first ? q0 : q1) + (from_ref - 0.5 * y) * n, y - radii,
                feature(edge_code(i0), corner_code(first ? j0 : j1)));
    }
    out.m.count = corners || y <= limit ? 1 : 0;
    return;
  }
  const double label = kCornerOnCorner * std::min(len, x0 - x1);
  const double slope = (y0 - y1) / (x0 - x1);
  // An end is the incident edge's corner where that lies above the reference edge, else the reference edge's.
  const bool start_is_inc = x1 >= 0, end_is_inc = x0 <= len;
  const double y_start = y1 - slope * std::min(x1, 0.0), y_end = y0 + slope * std::min(len - x0, 0.0);
  const auto code_of = [&](bool is_inc, bool both, int i, int j) {
    return feature(both || !is_inc ? corner_code(i) : edge_code(i0),
                   both || is_inc ? corner_code(j) : edge_code(j0));
  };
  std::uint32_t start_feature = code_of(start_is_inc, std::abs(x1) <= label, i0, j1);
  std::uint32_t end_feature = code_of(end_is_inc, std::abs(x0 - len) <= label, i1, j0);
  const double start_offset = from_ref + (start_is_inc ? -0.5 : 0.5) * y_start;
  const double end_offset = from_ref + (end_is_inc ? -0.5 : 0.5) * y_end;
  Vec2 start_position = *(start_is_inc ? inc_v + j1 : ref_v + i0) + start_offset * n;
  Vec2 end_position = *(end_is_inc ? inc_v + j0 : ref_v + i1) + end_offset * n;
  double start_separation = y_start - radii, end_separation = y_end - radii;
  bool keep_start = y_start <= limit, keep_end = y_end <= limit;
  if (corners) {
    (corners_at_start ? start_feature : end_feature) = corner_feature;
    (corners_at_start ? start_position : end_position) = corner_position;
    (corners_at_start ? start_separation : end_separation) = corner_separation;
    (corners_at_start ? keep_start : keep_end) = true;
  }
  const int both = keep_start && keep_end ? 1 : 0;
  const int start_slot = both & (in_order(start_feature, end_feature) ? 0 : 1);
  if (keep_start) out.point(start_slot, start_position, start_separation, start_feature);
  if (keep_end) out.point(both - start_slot, end_position, end_separation, end_feature);
  out.m.count = (keep_start ? 1 : 0) + (keep_end ? 1 : 0);
}

}  // namespace

void clip(const Hull& a, const Hull& b, const Placed& placed, const Axis& axis, double margin, Output& out) {
  clip_once(a, b, placed, axis, margin, true, out);
}

}  // namespace skerry::narrow
