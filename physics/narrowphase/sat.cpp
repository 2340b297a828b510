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

/// Separations along 2 K edges of one core, from `from` on, from the corners of the other: two edges in the
/// lanes, so that each corner is read once.
template <int K, int NC>
[[gnu::always_inline]] inline void separations_of(const Vec2* n, const Vec2* v, int edges, int from,
                                                  const Vec2* corners, int count, double* out) {
  const int last = NC > 0 ? NC : count;
  Two nx[K], ny[K], low[K];
  const Two x0 = Two::both(corners[0].x), y0 = Two::both(corners[0].y);
#pragma GCC unroll 4
  for (int k = 0; k < K; ++k) {
    const int i = from + 2 * k;
    const Two n0 = load(n[std::min(i, edges - 1)]), n1 = load(n[std::min(i + 1, edges - 1)]);
    nx[k] = lows(n0, n1);
    ny[k] = highs(n0, n1);
    low[k] = nx[k] * x0 + ny[k] * y0;
  }
  for (int j = 1; j < last; ++j) {
    const Two x = Two::both(corners[j].x), y = Two::both(corners[j].y);
#pragma GCC unroll 4
    for (int k = 0; k < K; ++k) low[k] = lesser(nx[k] * x + ny[k] * y, low[k]);
  }
#pragma GCC unroll 4
  for (int k = 0; k < K; ++k) {
    const int i = from + 2 * k;
    if (i >= edges) break;
    const Two v0 = load(v[i]), v1 = load(v[i + 1 < edges ? i + 1 : i]);
    (low[k] - (nx[k] * lows(v0, v1) + ny[k] * highs(v0, v1))).store(out + i);
  }
}

/// Separations along all edges. One value more than there are edges may be written.
template <int NE, int NC>
[[gnu::always_inline]] inline void separations_along(const Vec2* n, const Vec2* v, int edges,
                                                     const Vec2* corners, int count, double* out) {
  const int last_edge = NE > 0 ? NE : edges;
  if (NE == 8 && NC == 8 && octagon_separations(n, v, corners, out)) return;
  int from = 0;
  for (; from + 4 < last_edge; from += 8) separations_of<4, NC>(n, v, last_edge, from, corners, count, out);
  if (from + 2 < last_edge) return separations_of<2, NC>(n, v, last_edge, from, corners, count, out);
  if (from < last_edge) separations_of<1, NC>(n, v, last_edge, from, corners, count, out);
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
  // NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult): all are written; cores have edges.
  for (int i = total - 1; i >= 0; --i) chosen = separation[i] >= good ? i : chosen;
  out.first = out.second = chosen;
  if (keep) choose_partner(separation, total, chosen, best, out);
  return out;
}

}  // namespace

SKERRY_TWICE [[gnu::flatten]] Ranking rank_all(const Hull& a, const Hull& b, const Placed& placed,
                                               double limit, double bias, bool keep) {
  if (a.count == 4 && b.count == 4) return rank<4, 4>(a, b, placed, limit, bias, keep);
  if (a.count == 8 && b.count == 8) return rank<8, 8>(a, b, placed, limit, bias, keep);
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

SKERRY_TWICE Axis find_axis(const Hull& a, const Hull& b, const Transform& relative, double limit,
                            Placed& placed, SatCache* cache, NarrowPhaseStats* stats) {
  if (a.count == 4 && b.count == 4) return search<4, 4>(a, b, relative, limit, placed, cache, stats);
  if (a.count == 8 && b.count == 8) return search<8, 8>(a, b, relative, limit, placed, cache, stats);
  return search<0, 0>(a, b, relative, limit, placed, cache, stats);
}

}  // namespace skerry::narrow
