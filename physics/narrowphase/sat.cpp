// SPDX-License-Identifier: MIT
//
// Separating axes of two convex cores [Gottschalk, Lin, Manocha 1996; Ericson 2005, sec. 5.2].
//
// Small cores are searched edge by corner. For large ones the deepest corner is followed around while the
// edges turn (rotating calipers [Shamos 1978]), so that a search costs O(n + m).
#include <tuple>

#include "physics/narrowphase/hull.h"
#include "physics/narrowphase/lanes.h"

namespace skerry::narrow {
namespace {

constexpr int kSmall = 8;  // up to this many corners a plain loop is faster than following the corner

/// Smallest projection of the corners on a direction.
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
int lowest_corner(const Vec2* v, int count, Vec2 n) {
  const int last = N > 0 ? N : count;
  int corner = 0;
  double low = n.x * v[0].x + n.y * v[0].y;
  for (int i = 1; i < last; ++i) {
    const double value = n.x * v[i].x + n.y * v[i].y;
    corner = value < low ? i : corner;
    low = value < low ? value : low;
  }
  return corner;
}

/// Moves `corner` to the lowest one along `n`, starting nearby.
double descend(const Vec2* v, int count, Vec2 n, int& corner) {
  double low = dot(n, v[corner]);
  for (const int step : {1, count - 1}) {
    // At most one turn: rounding cannot make it circle.
    for (int left = count; left > 0; --left) {
      int next = corner + step;
      if (next >= count) next -= count;
      const double value = dot(n, v[next]);
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

/// Turns and moves points; each is written in one piece, because a pair that was written in two cannot be
/// read in one without waiting.
template <int N>
void transform(const Vec2* from, int count, Rot q, Vec2 p, Vec2* to) {
  const int last = N > 0 ? N : count;
  const Two x_axis = Two::of(q.c, q.s), y_axis = Two::of(-q.s, q.c), offset = Two::of(p.x, p.y);
  for (int i = 0; i < last; ++i) {
    ((x_axis * Two::both(from[i].x) + y_axis * Two::both(from[i].y)) + offset).store(&to[i].x);
  }
}

/// Separation along one axis of the combined numbering (edges of a, then of b), always with all corners.
template <int NA, int NB>
double separation_along(const Hull& a, const Hull& b, const Placed& placed, int axis) {
  if (axis < a.count) return lowest<NB>(placed.v, b.count, a.n[axis]) - dot(a.n[axis], a.v[axis]);
  const int edge = axis - a.count;
  const Vec2 n = rotate(placed.turn, b.n[edge]);
  return lowest<NA>(a.v, a.count, n) - dot(n, placed.v[edge]);
}

/// Separations along the edges of one core from the corners of the other, two edges at a time. One value more
/// than there are edges may be written.
template <int NE, int NC>
void separations_along(const Vec2* n, const Vec2* v, int edges, const Vec2* corners, int count, double* out) {
  const int last_edge = NE > 0 ? NE : edges, last = NC > 0 ? NC : count;
  for (int i = 0; i < last_edge; i += 2) {
    const int k = i + 1 < last_edge ? i + 1 : i;
    const Two nx = Two::of(n[i].x, n[k].x), ny = Two::of(n[i].y, n[k].y);
    Two low = nx * Two::both(corners[0].x) + ny * Two::both(corners[0].y);
    for (int j = 1; j < last; ++j) {
      low = lesser(nx * Two::both(corners[j].x) + ny * Two::both(corners[j].y), low);
    }
    (low - (nx * Two::of(v[i].x, v[k].x) + ny * Two::of(v[i].y, v[k].y))).store(out + i);
  }
}

int highest(const double* value, int from, int to) {
  int best = from;
  for (int i = from + 1; i < to; ++i) best = value[i] > value[best] ? i : best;
  return best;
}

double maximum(const double* value, int from, int to) {
  double high = value[from];
  for (int i = from + 1; i < to; ++i) high = value[i] > high ? value[i] : high;
  return high;
}

/// Fills separations of all axes; returns the axis that separates by more than `limit`, or -1.
template <int NA, int NB>
int all_separations(const Hull& a, const Hull& b, const Placed& placed, double limit, double* separation) {
  const int na = NA > 0 ? NA : a.count, nb = NB > 0 ? NB : b.count;
  if (NA > 0 || std::max(na, nb) <= kSmall) {
    // All edges of one core before the question whether one separates: the answer is hard to foresee for the
    // processor, so it is asked twice and not at every edge.
    separations_along<NA, NB>(a.n, a.v, na, placed.v, nb, separation);
    if (maximum(separation, 0, na) > limit) return highest(separation, 0, na);
    struct Normals {  // left as it is, like Placed
      union {
        Vec2 n[kSmall];
      };
      Normals() {}
    } turned;
    transform<NB>(b.n, nb, placed.turn, {}, turned.n);
    separations_along<NB, NA>(turned.n, placed.v, nb, a.v, na, separation + na);
    return maximum(separation, na, na + nb) > limit ? highest(separation, na, na + nb) : -1;
  }
  int corner = lowest_corner<0>(placed.v, nb, a.n[0]);
  for (int i = 0; i < na; ++i) {
    separation[i] = descend(placed.v, nb, a.n[i], corner) - dot(a.n[i], a.v[i]);
    if (separation[i] > limit) return i;
  }
  corner = lowest_corner<0>(a.v, na, rotate(placed.turn, b.n[0]));
  for (int i = 0; i < nb; ++i) {
    const Vec2 n = rotate(placed.turn, b.n[i]);
    separation[na + i] = descend(a.v, na, n, corner) - dot(n, placed.v[i]);
    if (separation[na + i] > limit) return na + i;
  }
  return -1;
}

double reach_of(const Hull& hull) {
  double reach = 0;
  for (int i = 0; i < hull.count; ++i) reach = std::max(reach, magnitude(hull.v[i]));
  return reach;
}

/// The corner of the other core that lies deepest below the chosen edge.
template <int NA, int NB>
void find_support(const Hull& a, const Hull& b, const Placed& placed, int axis, Axis& result) {
  const int na = NA > 0 ? NA : a.count, nb = NB > 0 ? NB : b.count;
  const bool on_a = axis < na;
  // Which core it is depends on the scene alone, so it is selected, not branched on.
  const Vec2 n = rotate(on_a ? Rot{} : placed.turn, on_a ? a.n[axis] : b.n[axis - na]);
  const Vec2* v = on_a ? placed.v : a.v;
  constexpr int same = NA == NB ? NA : 0;
  result.support = lowest_corner<same>(v, on_a ? nb : na, n);
}

template <int NA, int NB>
Axis search(const Hull& a, const Hull& b, const Transform& relative, double limit, Placed& placed,
            SatCache* cache, NarrowPhaseStats* stats) {
  const int na = NA > 0 ? NA : a.count, total = na + (NB > 0 ? NB : b.count);
  const auto numbered = [na](std::int32_t code) { return code >= 0 ? code : na + ~code; };
  const auto coded = [na](int axis) { return axis < na ? axis : ~(axis - na); };
  placed.turn = relative.q;
  transform<NB>(b.v, b.count, relative.q, relative.p, placed.v);
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
    double separation[2 * kMaxCorners + 1];
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
    const double best = maximum(separation, 0, total), good = best - bias;
    int chosen = 0;
    for (int i = total - 1; i >= 0; --i) chosen = separation[i] >= good ? i : chosen;
    if (cache == nullptr) {
      result.index = coded(chosen);
      result.separation = separation[chosen];
      if (NA == 0 && std::max(na, b.count) > kSmall) {
        result.separation = separation_along<NA, NB>(a, b, placed, chosen);
      }
      find_support<NA, NB>(a, b, placed, chosen, result);
      return result;
    }
    int other = -1;
    double value_other = -kInfinity;
    for (int i = 0; i < total; ++i) {
      const bool take = i != chosen && separation[i] > value_other;
      value_other = take ? separation[i] : value_other;
      other = take ? i : other;
    }
    first = std::min(chosen, other);
    second = std::max(chosen, other);
    double third = -kInfinity;
    for (int i = 0; i < total; ++i) {
      third = i != first && i != second && separation[i] > third ? separation[i] : third;
    }
    cache->valid = true;
    cache->axis = coded(chosen);
    cache->partner = coded(other);
    cache->slack = 0.5 * (best - third) - bias;
    cache->reach = reach_of(a) + reach_of(b);
    cache->offset = relative.p;
    cache->turn = relative.q;
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
  find_support<NA, NB>(a, b, placed, axis, result);
  return result;
}

}  // namespace

bool second_comes_first_by_details(const Shape& a, const Transform& pose_a, const Shape& b,
                                   const Transform& pose_b) {
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

Axis find_axis(const Hull& a, const Hull& b, const Transform& relative, double limit, Placed& placed,
               SatCache* cache, NarrowPhaseStats* stats) {
  if (a.count == 4 && b.count == 4) return search<4, 4>(a, b, relative, limit, placed, cache, stats);
  return search<0, 0>(a, b, relative, limit, placed, cache, stats);
}

}  // namespace skerry::narrow
