// SPDX-License-Identifier: MIT
//
// Separating axes of two convex cores [Gottschalk, Lin, Manocha 1996; Ericson 2005, sec. 5.2].
//
// Small cores are searched edge by corner. For large ones the deepest corner is followed around while the
// edges turn (rotating calipers [Shamos 1978]), so that a search costs O(n + m).
#include <tuple>

#include "physics/narrowphase/hull.h"

namespace skerry::narrow {
namespace {

constexpr int kSmall = 8;  // up to this many corners a plain loop is faster than following the corner

/// Projection of the corners of a placed or plain core on a direction: smallest value and where.
template <int N>
double lowest(const Vec2* v, int count, Vec2 n) {
  const int last = N > 0 ? N : count;
  double low = n.x * v[0].x + n.y * v[0].y;
  for (int i = 1; i < last; ++i) {
    const double value = n.x * v[i].x + n.y * v[i].y;
    low = value < low ? value : low;
  }
  return low;
}

template <int N>
double lowest(const Placed& placed, int count, Vec2 n) {
  const int last = N > 0 ? N : count;
  double low = n.x * placed.x[0] + n.y * placed.y[0];
  for (int i = 1; i < last; ++i) {
    const double value = n.x * placed.x[i] + n.y * placed.y[i];
    low = value < low ? value : low;
  }
  return low;
}

template <class PointAt>
int lowest_corner(int count, Vec2 n, PointAt point_at) {
  int corner = 0;
  double low = dot(n, point_at(0));
  for (int i = 1; i < count; ++i) {
    const double value = dot(n, point_at(i));
    if (value < low) {
      low = value;
      corner = i;
    }
  }
  return corner;
}

/// Moves `corner` to the lowest one along `n`, starting nearby.
template <class PointAt>
double descend(int count, Vec2 n, PointAt point_at, int& corner) {
  double low = dot(n, point_at(corner));
  for (const int step : {1, count - 1}) {
    // At most one turn: rounding cannot make it circle.
    for (int left = count; left > 0; --left) {
      int next = corner + step;
      if (next >= count) next -= count;
      const double value = dot(n, point_at(next));
      if (!(value < low)) break;
      low = value;
      corner = next;
    }
  }
  return low;
}

double coordinate_scale(const Hull& a, const Hull& b, const Transform& relative) {
  return magnitude(relative.p) + magnitude(a.v[0]) + magnitude(a.v[1]) + magnitude(b.v[0]) +
         magnitude(b.v[1]);
}

template <int N>
void place(const Hull& b, const Transform& relative, Placed& placed) {
  const int last = N > 0 ? N : b.count;
  const double c = relative.q.c, s = relative.q.s;
  placed.turn = relative.q;
  for (int i = 0; i < last; ++i) {
    placed.x[i] = (c * b.v[i].x - s * b.v[i].y) + relative.p.x;
    placed.y[i] = (s * b.v[i].x + c * b.v[i].y) + relative.p.y;
  }
}

/// Separation along one axis of the combined numbering (edges of a, then of b), always with all corners.
template <int NA, int NB>
double separation_along(const Hull& a, const Hull& b, const Placed& placed, int axis) {
  if (axis < a.count) return lowest<NB>(placed, b.count, a.n[axis]) - dot(a.n[axis], a.v[axis]);
  const int edge = axis - a.count;
  const Vec2 n = rotate(placed.turn, b.n[edge]);
  return lowest<NA>(a.v, a.count, n) - (n.x * placed.x[edge] + n.y * placed.y[edge]);
}

/// Fills separations of all axes; returns the axis that separates by more than `limit`, or -1.
template <int NA, int NB>
int all_separations(const Hull& a, const Hull& b, const Placed& placed, double limit, double* separation) {
  const int na = NA > 0 ? NA : a.count, nb = NB > 0 ? NB : b.count;
  if (NA > 0 || std::max(na, nb) <= kSmall) {
    for (int axis = 0; axis < na + nb; ++axis) {
      separation[axis] = separation_along<NA, NB>(a, b, placed, axis);
      if (separation[axis] > limit) return axis;
    }
    return -1;
  }
  const auto corner_of_a = [&](int i) { return a.v[i]; };
  const auto corner_of_b = [&](int i) { return placed.point(i); };
  int corner = lowest_corner(nb, a.n[0], corner_of_b);
  for (int i = 0; i < na; ++i) {
    separation[i] = descend(nb, a.n[i], corner_of_b, corner) - dot(a.n[i], a.v[i]);
    if (separation[i] > limit) return i;
  }
  corner = lowest_corner(na, rotate(placed.turn, b.n[0]), corner_of_a);
  for (int i = 0; i < nb; ++i) {
    const Vec2 n = rotate(placed.turn, b.n[i]);
    separation[na + i] = descend(na, n, corner_of_a, corner) - dot(n, placed.point(i));
    if (separation[na + i] > limit) return na + i;
  }
  return -1;
}

double reach_of(const Hull& hull) {
  double reach = 0;
  for (int i = 0; i < hull.count; ++i) reach = std::max(reach, magnitude(hull.v[i]));
  return reach;
}

template <int NA, int NB>
Axis search(const Hull& a, const Hull& b, const Transform& relative, double limit, Placed& placed,
            SatCache* cache, NarrowPhaseStats* stats) {
  const int na = NA > 0 ? NA : a.count, total = na + (NB > 0 ? NB : b.count);
  const auto numbered = [na](std::int32_t code) { return code >= 0 ? code : na + ~code; };
  const auto coded = [na](int axis) { return axis < na ? axis : ~(axis - na); };
  place<NB>(b, relative, placed);
  Axis result;
  result.scale = coordinate_scale(a, b, relative);
  const double bias = kAxisBias * result.scale;

  int first = -1, second = -1;  // the two axes in question, in their order
  if (cache != nullptr && cache->valid && cache->slack > 0) {
    const Vec2 moved = relative.p - cache->offset;
    const double turned = std::abs(relative.q.c - cache->turn.c) + std::abs(relative.q.s - cache->turn.s);
    // Both directions of looking: b's corners in a's frame and a's corners in b's frame.
    if (magnitude(moved) + turned * (cache->reach + magnitude(relative.p)) < cache->slack) {
      const auto [low, high] = std::minmax({numbered(cache->axis), numbered(cache->partner)});
      first = low;
      second = high;
    }
  }
  double value_first, value_second;
  if (first >= 0) {
    value_first = separation_along<NA, NB>(a, b, placed, first);
    value_second = separation_along<NA, NB>(a, b, placed, second);
    result.apart = std::max(value_first, value_second) > limit;
    if (stats != nullptr) {
      stats->axes_tested += 2;
      stats->axes_skipped += static_cast<std::uint64_t>(total - 2);
    }
    if (result.apart) {
      cache->axis = coded(value_first > limit ? first : second);
      cache->slack = -1;
      return result;
    }
  } else {
    double separation[2 * kMaxCorners];
    separation[0] = separation[1] = 0;  // two edges at least, which the compiler cannot know
    const int separating = all_separations<NA, NB>(a, b, placed, limit, separation);
    if (stats != nullptr)
      stats->axes_tested += static_cast<std::uint64_t>(separating < 0 ? total : separating + 1);
    if (separating >= 0) {
      if (cache != nullptr) {
        cache->valid = true;
        cache->axis = coded(separating);
        cache->slack = -1;
      }
      result.apart = true;
      return result;
    }
    // The first axis that is as good as the best, the best of the others, and the third.
    double best = -kInfinity;
    for (int i = 0; i < total; ++i) best = separation[i] > best ? separation[i] : best;
    int chosen = 0;
    for (int i = total - 1; i >= 0; --i) chosen = separation[i] >= best - bias ? i : chosen;
    int other = -1;
    double value_other = -kInfinity;
    for (int i = 0; i < total; ++i) {
      if (i == chosen || separation[i] <= value_other) continue;
      value_other = separation[i];
      other = i;
    }
    first = std::min(chosen, other);
    second = std::max(chosen, other);
    if (cache != nullptr) {
      double third = -kInfinity;
      for (int i = 0; i < total; ++i) {
        if (i != first && i != second && separation[i] > third) third = separation[i];
      }
      cache->valid = true;
      cache->axis = coded(chosen);
      cache->partner = coded(other);
      cache->slack = 0.5 * (best - third) - bias;
      cache->reach = reach_of(a) + reach_of(b);
      cache->offset = relative.p;
      cache->turn = relative.q;
    }
    value_first = separation[first];
    value_second = separation[second];
    if (NA == 0 && std::max(a.count, b.count) > kSmall) {
      // Following the corner may stop an ulp early; the last word is the same as on the short path.
      value_first = separation_along<NA, NB>(a, b, placed, first);
      value_second = separation_along<NA, NB>(a, b, placed, second);
    }
  }
  const bool take_second = value_first < value_second - bias;
  const int axis = take_second ? second : first;
  result.index = coded(axis);
  result.separation = take_second ? value_second : value_first;
  if (axis < na) {
    result.support = lowest_corner(b.count, a.n[axis], [&](int i) { return placed.point(i); });
  } else {
    result.support =
        lowest_corner(a.count, rotate(placed.turn, b.n[axis - na]), [&](int i) { return a.v[i]; });
  }
  return result;
}

/// Order of everything but the positions' difference; used when that is zero.
bool ordered_by_details(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b) {
  const auto key = [](const Shape& s, const Transform& t) {
    return std::tuple(static_cast<int>(s.kind), s.vertices.size(), s.radius, t.q.c, t.q.s, t.p.x, t.p.y);
  };
  const auto key_a = key(a, pose_a), key_b = key(b, pose_b);
  if (key_a != key_b) return key_b < key_a;
  for (std::size_t i = 0; i < a.vertices.size(); ++i) {
    const Vec2 va = a.vertices[i], vb = b.vertices[i];
    if (va != vb) return std::tuple(vb.x, vb.y) < std::tuple(va.x, va.y);
  }
  return false;
}

}  // namespace

bool second_comes_first(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b) {
  const Vec2 d = pose_b.p - pose_a.p;
  const double side = d.x + 0.6180339887498949 * d.y;
  return side == 0 ? ordered_by_details(a, pose_a, b, pose_b) : side < 0;
}

Axis find_axis(const Hull& a, const Hull& b, const Transform& relative, double limit, Placed& placed,
               SatCache* cache, NarrowPhaseStats* stats) {
  if (a.count == 4 && b.count == 4) return search<4, 4>(a, b, relative, limit, placed, cache, stats);
  return search<0, 0>(a, b, relative, limit, placed, cache, stats);
}

}  // namespace skerry::narrow
