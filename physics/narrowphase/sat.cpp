// SPDX-License-Identifier: MIT
//
// Rankings of all axes by their separations.
//
// Small cores are searched edge by corner. For large ones the deepest corner is followed around while the
// edges turn (rotating calipers [Shamos 1978]), so that a search costs O(n + m).
#include <tuple>

#include "physics/narrowphase/sat_search.h"

namespace skerry::narrow {
namespace {

constexpr int kSmall = 8;  // up to this many corners a plain loop is faster than following the corner

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
  double low = 0;
  int corner = lowest_corner<0>(placed.v, nb, a.n[0], low);
  for (int i = 0; i < na; ++i) {
    separation[i] = descend(placed.v, nb, a.n[i], corner) - dot(a.n[i], a.v[i]);
    if (separation[i] > limit) return i;
  }
  corner = lowest_corner<0>(a.v, na, rotate(placed.turn, b.n[0]), low);
  for (int i = 0; i < nb; ++i) {
    const Vec2 n = rotate(placed.turn, b.n[i]);
    separation[na + i] = descend(a.v, na, n, corner) - dot(n, placed.v[i]);
    if (separation[na + i] > limit) return na + i;
  }
  return -1;
}

template <int NA, int NB>
Ranking rank(const Hull& a, const Hull& b, const Placed& placed, double limit, double bias, bool keep) {
  Ranking out;
  const int total = (NA > 0 ? NA : a.count) + (NB > 0 ? NB : b.count);
  double separation[2 * kMaxCorners + 1];
  separation[0] = separation[1] = 0;  // two edges at least, which the compiler cannot know
  out.apart = all_separations<NA, NB>(a, b, placed, limit, separation);
  if (out.apart >= 0) return out;
  // The first axis that is as good as the best.
  const double best = maximum(separation, 0, total), good = best - bias;
  int chosen = 0;
  for (int i = total - 1; i >= 0; --i) chosen = separation[i] >= good ? i : chosen;
  out.first = out.second = chosen;
  if (keep) choose_partner(separation, total, chosen, best, out);
  return out;
}

}  // namespace

Ranking rank_all(const Hull& a, const Hull& b, const Placed& placed, double limit, double bias, bool keep) {
  if (a.count == 4 && b.count == 4) return rank<4, 4>(a, b, placed, limit, bias, keep);
  return rank<0, 0>(a, b, placed, limit, bias, keep);
}

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
