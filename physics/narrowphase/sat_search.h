// SPDX-License-Identifier: MIT
//
// Inside the narrow phase: the search for the axis of least penetration [Gottschalk, Lin, Manocha 1996;
// Ericson 2005, sec. 5.2], for a given number of corners.
//
// It goes in three steps, each of which may be the last: what the cache knows; a ranking of all axes, which
// for rectangles needs no corners; and the exact value of the one or two axes that are left in question. The
// last step is the same on every path, so results do not depend on what was skipped.
#pragma once

#include <bit>

#include "physics/narrowphase/hull.h"
#include "physics/narrowphase/lanes.h"

namespace skerry::narrow {

/// The first of the corners that are lowest along a direction. @param low  its projection
template <int N>
int lowest_corner(const Vec2* v, int count, Vec2 n, double& low) {
  const int last = N > 0 ? N : count;
  int corner = 0;
  low = n.x * v[0].x + n.y * v[0].y;
  for (int i = 1; i < last; ++i) {
    const double value = n.x * v[i].x + n.y * v[i].y;
    corner = value < low ? i : corner;
    low = value < low ? value : low;
  }
  return corner;
}

inline double coordinate_scale(const Hull& a, const Hull& b, const Transform& relative) {
  const Two sums = (magnitude(load(a.v[0])) + magnitude(load(a.v[1]))) +
                   (magnitude(load(b.v[0])) + magnitude(load(b.v[1]))) + magnitude(load(relative.p));
  return sums.low() + sums.high();
}

/// Turns and moves points; each is written in one piece, because a pair that was written in two cannot be
/// read in one without waiting.
template <int N>
[[gnu::always_inline]] inline void transform(const Vec2* from, int count, Rot q, Vec2 p, Vec2* to) {
  const int last = N > 0 ? N : count;
  const Two x_axis = Two::of(q.c, q.s), y_axis = Two::of(-q.s, q.c), offset = Two::of(p.x, p.y);
  for (int i = 0; i < last; ++i) {
    ((x_axis * Two::both(from[i].x) + y_axis * Two::both(from[i].y)) + offset).store(&to[i].x);
  }
}

/// Bit k: lane k of a is at least that of b.
inline unsigned reached(Two a, Two b) {
  return bits(at_least(a, b));
}

/// One axis of the combined numbering (edges of a, then of b), with all corners of the other core.
struct Probe {
  Vec2 n;  ///< in the first core's frame
  double separation;
  int support;
};

template <int NA, int NB>
[[gnu::always_inline]] inline Probe probe(const Hull& a, const Hull& b, const Placed& placed, int axis) {
  const int na = NA > 0 ? NA : a.count, nb = NB > 0 ? NB : b.count;
  const bool on_a = axis < na;
  // Which core it is depends on the scene alone, so it is selected, not branched on.
  const int edge = on_a ? axis : axis - na;
  const Vec2 own = on_a ? a.n[edge] : b.n[edge], turned = rotate(placed.turn, own);
  const Vec2 n = {on_a ? own.x : turned.x, on_a ? own.y : turned.y};
  const Vec2* const v = on_a ? placed.v : a.v;
  const double face = dot(n, (on_a ? a.v : placed.v)[edge]);
  if constexpr (NA == NB && NA > 0) {
    static_assert(NA % 2 == 0);
    const Two x = Two::both(n.x), y = Two::both(n.y);
    Two value[NA / 2];
    for (int k = 0; k < NA / 2; ++k) {
      const Two v0 = load(v[2 * k]), v1 = load(v[2 * k + 1]);
      value[k] = x * lows(v0, v1) + y * highs(v0, v1);
    }
    Two lows_of_both = value[0];
    for (int k = 1; k < NA / 2; ++k) lows_of_both = lesser(lows_of_both, value[k]);
    const double low = smallest(lows_of_both);
    // The last corner if nothing is a number.
    unsigned at = 1u << (NA - 1);
    for (int k = 0; k < NA / 2; ++k) at |= reached(Two::both(low), value[k]) << 2 * k;
    return {n, low - face, std::countr_zero(at)};
  }
  double low = kInfinity;
  const int support = lowest_corner<0>(v, on_a ? nb : na, n, low);
  return {n, low - face, support};
}

inline double maximum(const double* value, int from, int to) {
  double high = value[from];
  // NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult): callers have filled them.
  for (int i = from + 1; i < to; ++i) high = value[i] > high ? value[i] : high;
  return high;
}

/// What looking at all axes leaves in question.
struct Ranking {
  int apart = -1;  ///< an axis that separates by more than the limit; nothing else is valid then
  int first = 0,
      second = 0;    ///< in their order: the best axis and the one to compare it with, maybe the same
  double lead = -1;  ///< all others are worse than the best by this, at least [m]; < 0: not asked for
};

/// The best axis beside `chosen`, and how far the third one is behind.
inline void choose_partner(const double* separation, int total, int chosen, double best, Ranking& out) {
  int other = chosen;
  double value = -kInfinity;
  for (int i = 0; i < total; ++i) {
    const bool take = i != chosen && separation[i] > value;
    value = take ? separation[i] : value;
    other = take ? i : other;
  }
  out.first = std::min(chosen, other);
  out.second = std::max(chosen, other);
  double third = -kInfinity;
  for (int i = 0; i < total; ++i) {
    third = i != chosen && i != other && separation[i] > third ? separation[i] : third;
  }
  out.lead = best - third;
}

inline double reach_of(const Hull& hull) {
  double reach = 0;
  for (int i = 0; i < hull.count; ++i) reach = std::max(reach, magnitude(hull.v[i]));
  return reach;
}

/// Separations along the 8 edges of an octagon with normals `n` and corners `v` from the 8 `corners` of
/// another. @return false if nothing was done: two edges in the lanes are the best that the processor can do
bool octagon_separations(const Vec2* n, const Vec2* v, const Vec2* corners, double* out);

/// Ranks all axes by their separations. @param keep  the second best axis and the lead over the third are
/// wanted
Ranking rank_all(const Hull& a, const Hull& b, const Placed& placed, double limit, double bias, bool keep);

/// The same for two rectangles from their middles and half widths: opposite edges at once, two axes in the
/// lanes [Gottschalk 1996]. Separations are right within `bias` only, so where that matters it returns false.
/// No corner is moved, so pairs that are apart cost little.
[[gnu::always_inline]] inline bool rank_boxes(const Hull& a, const Hull& b, const Transform& relative,
                                              double limit, double bias, bool keep, Ranking& out) {
  const Two size_a = load(a.rectangle->half), size_b = load(b.rectangle->half);
  const Two na0 = load(a.n[0]), na1 = load(a.n[1]), nb0 = load(b.n[0]), nb1 = load(b.n[1]);
  const Two ax = lows(na0, na1), ay = highs(na0, na1), bx = lows(nb0, nb1), by = highs(nb0, nb1);
  // The normals of b in the frame of a.
  const Two q = load(relative.q), c = lows(q, q), s = highs(q, q);
  const Two mx = c * bx - s * by, my = s * bx + c * by;
  // From the middle of a to that of b.
  const Vec2& middle = b.rectangle->middle;
  const Two d = load(relative.p) - load(a.rectangle->middle);
  const Two dx = lows(d, d) + (c * Two::both(middle.x) - s * Two::both(middle.y));
  const Two dy = highs(d, d) + (s * Two::both(middle.x) + c * Two::both(middle.y));
  const Two along_a = ax * dx + ay * dy, along_b = mx * dx + my * dy;
  // Cosine and sine of the angle between the rectangles, whatever their signs.
  const Two cosines = magnitude(lows(ax, ax) * mx + lows(ay, ay) * my);
  const Two same = lows(cosines, cosines), other = highs(cosines, cosines);
  const Two reach_a = size_a + (size_b * same + exchanged(size_b) * other);
  const Two reach_b = size_b + (size_a * same + exchanged(size_a) * other);
  const Two best_a = magnitude(along_a) - reach_a, best_b = magnitude(along_b) - reach_b;
  const double best = largest(greater(best_a, best_b)), doubt = 4 * bias;
  if (best > limit - doubt) {
    if (!(best > limit + doubt)) return false;
    if (!keep) {
      out.apart = 0;
      return true;
    }
  }
  // Edges 0 and 1 of a, then 2 and 3, then those of b, whose normals point the other way.
  const Two a01 = along_a - reach_a, a23 = negated(along_a) - reach_a;
  const Two b01 = negated(along_b) - reach_b, b23 = along_b - reach_b;
  const Two good = Two::both(best - doubt);
  const unsigned near =
      reached(a01, good) | reached(a23, good) << 2 | reached(b01, good) << 4 | reached(b23, good) << 6;
  if (near == 0) return false;  // NaN
  const int chosen = std::countr_zero(near), last = static_cast<int>(std::bit_width(near)) - 1;
  if (best > limit) {
    out.apart = chosen;
    return true;
  }
  const unsigned rivals = near & (near - 1);
  if ((rivals & (rivals - 1)) != 0) return false;
  out.first = chosen;
  out.second = last;
  if (!keep) return true;
  double separation[8];
  a01.store(separation);
  a23.store(separation + 2);
  b01.store(separation + 4);
  b23.store(separation + 6);
  if (chosen == last) {
    choose_partner(separation, 8, chosen, best, out);
  } else {
    separation[chosen] = separation[last] = -kInfinity;
    out.lead = best - maximum(separation, 0, 8);
  }
  out.lead -= doubt;
  return true;
}

/// True if the discs around two rectangles are farther apart than `limit` beyond doubt. Without a root: their
/// radii r and s have (r + s)^2 <= 2 (r^2 + s^2) = S, and (sqrt(S) + l)^2 <= 65/64 S + 65 l^2.
[[gnu::always_inline]] inline bool discs_around_apart(const Shape::Rectangle& a, const Shape::Rectangle& b,
                                                      Vec2 d, double limit) {
  const Two half_a = load(a.half), half_b = load(b.half), squares = half_a * half_a + half_b * half_b;
  const Two middles = magnitude(load(a.middle)) + magnitude(load(b.middle));
  const double l = limit + (middles.low() + middles.high());
  return length_squared(d) > (65.0 / 32) * (squares.low() + squares.high()) + 65 * (l * l);
}

/// True if the pair cannot have come within `limit` of each other (cores) on the axis that held them apart.
inline bool still_apart(const SatCache& cache, const Transform& pose_a, const Transform& pose_b,
                        double limit) {
  const Two d = load(pose_b.p) - load(pose_a.p);
  const Two moved = magnitude(d - load(cache.offset)) +
                    (Two::both(cache.reach) * magnitude(load(pose_a.q) - load(cache.turn)) +
                     Two::both(cache.reach_b) * magnitude(load(pose_b.q) - load(cache.turn_b)));
  return cache.slack - (moved.low() + moved.high()) > limit;
}

/// The axis of least penetration of two cores with NA and NB corners (0: any number). Inlined, as for boxes
/// half of the time would go into handing things over.
template <int NA, int NB>
[[gnu::always_inline]] inline Axis search(const Hull& a, const Hull& b, const Transform& relative,
                                          double limit, Placed& placed, SatCache* cache,
                                          NarrowPhaseStats* stats) {
  const int na = NA > 0 ? NA : a.count, total = na + (NB > 0 ? NB : b.count);
  const auto numbered = [&](std::int32_t code) { return code >= 0 ? code : na + ~code; };
  const auto coded = [&](int axis) { return axis < na ? axis : ~(axis - na); };
  Axis result;
  result.scale = coordinate_scale(a, b, relative);
  const double bias = kAxisBias * result.scale;

  Ranking ranking;
  bool known = false, placed_already = false;
  const auto place = [&] {
    placed.turn = relative.q;
    transform<NB>(b.v, b.count, relative.q, relative.p, placed.v);
    placed_already = true;
  };
  if (cache != nullptr && cache->state == SatCache::State::Settled) {
    const Vec2 moved = relative.p - cache->offset;
    const double turned = std::abs(relative.q.c - cache->turn.c) + std::abs(relative.q.s - cache->turn.s);
    // Both directions of looking: b's corners in a's frame and a's corners in b's frame.
    if (magnitude(moved) + turned * (cache->reach + magnitude(relative.p)) < cache->slack) {
      const int axis = numbered(cache->axis), partner = numbered(cache->partner);
      ranking.first = std::min(axis, partner);
      ranking.second = std::max(axis, partner);
      known = true;
    }
  }
  if (!known) {
    bool ranked = false;
    if constexpr (NA == 4 && NB == 4) {
      if (a.rectangle != nullptr && b.rectangle != nullptr) {
        ranked = rank_boxes(a, b, relative, limit, bias, cache != nullptr, ranking);
      }
    }
    if (!ranked) {
      place();
      ranking = rank_all(a, b, placed, limit, bias, cache != nullptr);
    }
    result.apart = ranking.apart >= 0;
    if (stats != nullptr) stats->axes_tested += static_cast<std::uint64_t>(total);
    if (cache != nullptr) {
      cache->state = result.apart ? SatCache::State::Apart : SatCache::State::Settled;
      cache->slack = result.apart ? -1 : 0.5 * ranking.lead - bias;
      cache->axis = coded(result.apart ? ranking.apart : ranking.first);
      cache->partner = coded(ranking.second);
      cache->reach = reach_of(a) + reach_of(b);
      cache->offset = relative.p;
      cache->turn = relative.q;
    }
    if (result.apart) return result;
  }
  if (!placed_already) place();

  // The last word is the same on every path, to the bit.
  Probe best = probe<NA, NB>(a, b, placed, ranking.first);
  int axis = ranking.first;
  if (ranking.second != ranking.first) {
    const Probe rival = probe<NA, NB>(a, b, placed, ranking.second);
    if (known && std::max(best.separation, rival.separation) > limit) {
      cache->state = SatCache::State::Apart;
      cache->slack = -1;
      cache->axis = coded(best.separation > limit ? ranking.first : ranking.second);
      result.apart = true;
    }
    if (best.separation < rival.separation - bias) {
      best = rival;
      axis = ranking.second;
    }
  } else if (known && best.separation > limit) {
    cache->state = SatCache::State::Apart;
    cache->slack = -1;
    cache->axis = coded(ranking.first);
    result.apart = true;
  }
  if (known && stats != nullptr) {
    const std::uint64_t tested = ranking.second != ranking.first ? 2 : 1;
    stats->axes_tested += tested;
    stats->axes_skipped += static_cast<std::uint64_t>(total) - tested;
  }
  result.index = coded(axis);
  result.separation = best.separation;
  result.n = best.n;
  result.support = best.support;
  write_whole(result.n);
  return result;
}

}  // namespace skerry::narrow
