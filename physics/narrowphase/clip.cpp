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

/// Ascending by the pair of codes without regard to who is first, then by position: exchanging the shapes or
/// the reference face does not exchange the points.
void sort_by_feature(LocalManifold& m) {
  if (m.count < 2) return;
  const auto key = [](std::uint32_t f) {
    const std::uint32_t high = f >> 16, low = f & 0xffffu;
    return make_feature(std::min(high, low), std::max(high, low));
  };
  const std::uint32_t first = key(m.points[0].feature), second = key(m.points[1].feature);
  const bool wrong = first != second ? first > second : m.points[0].feature > m.points[1].feature;
  if (wrong) std::swap(m.points[0], m.points[1]);
}

LocalManifold clip_once(const Hull& a, const Hull& b, const Placed& placed, const Axis& axis, double margin,
                        bool may_turn) {
  const bool reference_is_a = axis.index >= 0;
  const int edge = reference_is_a ? axis.index : ~axis.index;
  const Hull& ref = reference_is_a ? a : b;
  const Hull& inc = reference_is_a ? b : a;
  const auto ref_corner = [&](int i) { return reference_is_a ? a.v[i] : placed.point(i); };
  const auto inc_corner = [&](int i) { return reference_is_a ? placed.point(i) : a.v[i]; };
  const Vec2 n = reference_is_a ? a.n[edge] : rotate(placed.turn, b.n[edge]);

  // Of the two edges at the deepest corner the one that faces the reference edge is incident.
  const int before = axis.support > 0 ? axis.support - 1 : inc.count - 1;
  const Vec2 n_inc = reference_is_a ? inverse_rotate(placed.turn, n) : n;  // in the incident core's frame
  const int incident = dot(n_inc, inc.n[before]) < dot(n_inc, inc.n[axis.support]) ? before : axis.support;

  const int i0 = edge, i1 = edge + 1 < ref.count ? edge + 1 : 0;
  const int j0 = incident, j1 = incident + 1 < inc.count ? incident + 1 : 0;
  const Vec2 p0 = ref_corner(i0), p1 = ref_corner(i1), q0 = inc_corner(j0), q1 = inc_corner(j1);
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
  LocalManifold m;
  m.normal = reference_is_a ? n : -n;
  m.from = reference_is_a ? NormalFrom::First : NormalFrom::Second;

  const bool apart = axis.separation >= -noise;
  const bool overlap = high - low > noise;
  const auto add = [&](double y, Vec2 point, double offset, std::uint32_t code) {
    m.points[m.count++] = {point + offset * n, y - radii, code};
  };
  // If the deepest corner lies beside the reference edge and is closer to its end than the incident edge is,
  // these two corners are closest. With edges that are almost parallel the other end may still be in reach,
  // so it is added below; the normal lies between those of the edges.
  bool corners = false, corners_at_start = false;
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
      return clip_once(a, b, placed, turned, margin, false);
    }
    corners = low > high || (beside && beyond);
    if (corners) {
      const bool take_q0 = low > high ? length_squared(q0 - end) < length_squared(q1 - end) : deepest_is_q0;
      const Vec2 gap = (take_q0 ? q0 : q1) - end;
      const double distance = length(gap);
      if (distance > limit) return m;
      Vec2 along = n;
      double height = distance;
      if (distance > noise) {
        along = gap / distance;
        m.from = NormalFrom::Corners;
      } else {
        height = take_q0 ? y0 : y1;
      }
      m.normal = reference_is_a ? along : -along;
      m.points[0] = {end + (0.5 * height + from_ref) * along, height - radii,
                     feature(corner_code(corners_at_start ? i0 : i1), corner_code(take_q0 ? j0 : j1))};
      m.count = 1;
    }
  }
  if (!overlap) {
    if (corners) return m;
    // One corner above the edge, or so little overlap that a second point would be the same.
    const bool first = y0 < y1;
    const double y = first ? y0 : y1;
    if (y > limit) return m;
    add(y, first ? q0 : q1, from_ref - 0.5 * y, feature(edge_code(i0), corner_code(first ? j0 : j1)));
    return m;
  }
  const double label = kCornerOnCorner * std::min(len, x0 - x1);
  const double slope = (y0 - y1) / (x0 - x1);
  // The end at the start of the reference edge.
  const double y_low = x1 >= 0 ? y1 : y1 - slope * x1;
  if (y_low <= limit && !(corners && corners_at_start)) {
    const std::uint32_t code = std::abs(x1) <= label ? feature(corner_code(i0), corner_code(j1))
                               : x1 > 0              ? feature(edge_code(i0), corner_code(j1))
                                                     : feature(corner_code(i0), edge_code(j0));
    if (x1 >= 0) {
      add(y_low, q1, from_ref - 0.5 * y_low, code);
    } else {
      add(y_low, p0, from_ref + 0.5 * y_low, code);
    }
  }
  // The end at its other corner.
  const double y_high = x0 <= len ? y0 : y1 + slope * (len - x1);
  if (y_high <= limit && !(corners && !corners_at_start)) {
    const std::uint32_t code = std::abs(x0 - len) <= label ? feature(corner_code(i1), corner_code(j0))
                               : x0 < len                  ? feature(edge_code(i0), corner_code(j0))
                                                           : feature(corner_code(i1), edge_code(j0));
    if (x0 <= len) {
      add(y_high, q0, from_ref - 0.5 * y_high, code);
    } else {
      add(y_high, p1, from_ref + 0.5 * y_high, code);
    }
  }
  sort_by_feature(m);
  return m;
}

}  // namespace

LocalManifold clip(const Hull& a, const Hull& b, const Placed& placed, const Axis& axis, double margin) {
  return clip_once(a, b, placed, axis, margin, true);
}

}  // namespace skerry::narrow
