// SPDX-License-Identifier: MIT
#include "physics/narrowphase/collide.h"

#include <stdexcept>

#include "physics/narrowphase/clip_edges.h"
#include "physics/narrowphase/sat_search.h"

namespace skerry {
namespace {

using narrow::Hull;

/// Direction of two discs with one centre.
[[gnu::noinline, gnu::cold]] void discs_at_one_place(const Shape& a, const Transform& pose_a, const Shape& b,
                                                     const Transform& pose_b, Vec2& n) {
  n = {0, narrow::second_comes_first(a, pose_a, b, pose_b) ? -1.0 : 1.0};
}

/// Two discs, both coordinates in the lanes.
[[gnu::always_inline]] inline void discs(const Shape& a, const Transform& pose_a, const Shape& b,
                                         const Transform& pose_b, double margin, Manifold& m) {
  using narrow::load, narrow::Two;
  // All differences change sign exactly when the discs are exchanged.
  const Two pa = load(pose_a.p), pb = load(pose_b.p);
  const Two ca = turned(load(pose_a.q), load(a.vertices[0])),
            cb = turned(load(pose_b.q), load(b.vertices[0]));
  const Two d = (pb - pa) + (cb - ca), squares = d * d;
  const double radii = a.radius + b.radius, reach = radii + margin;
  const double square = squares.low() + squares.high();
  if (!(square <= reach * reach)) return;
  const double distance = narrow::root(square);
  (d / Two::both(distance)).store(&m.normal.x);
  if (!(distance > narrow::kNoDirection)) [[unlikely]]
    discs_at_one_place(a, pose_a, b, pose_b, m.normal);
  // The middle of the two surface points; the sum is symmetric too.
  const Two middle = Two::both(0.5) * ((pa + ca) + (pb + cb));
  (middle + Two::both(0.5 * (a.radius - b.radius)) * load(m.normal)).store(&m.points[0].position.x);
  m.points[0].separation = distance - radii;
  m.points[0].feature = make_feature(corner_code(0), corner_code(0));
  m.count = 1;
}

/// True if the cached axis separates the cores by more than `limit` beyond doubt: then the full search would
/// find them apart too. Notes by how much.
bool apart_on_cached_axis(const Hull& a, const Transform& pose_a, const Hull& b, const Transform& pose_b,
                          double limit, SatCache& cache) {
  const bool on_a = cache.axis >= 0;
  const int edge = on_a ? cache.axis : ~cache.axis;
  const Hull& own = on_a ? a : b;
  const Hull& other = on_a ? b : a;
  if (edge >= own.count) return false;
  const Transform& pose_own = on_a ? pose_a : pose_b;
  const Transform& pose_other = on_a ? pose_b : pose_a;
  const Vec2 n = rotate(pose_own.q, own.n[edge]);
  const Vec2 n_other = inverse_rotate(pose_other.q, n);
  double low = dot(n_other, other.v[0]);
  for (int i = 1; i < other.count; ++i) {
    const double value = dot(n_other, other.v[i]);
    low = value < low ? value : low;
  }
  const Vec2 d = pose_other.p - pose_own.p;
  const double face = dot(own.n[edge], own.v[edge]);
  const double noise = 2 * narrow::kNoise * (narrow::magnitude(d) + std::abs(low) + std::abs(face));
  const double separation = dot(n, d) + low - face - noise;
  if (!(separation > limit)) return false;
  // In the frame of the edge's owner a turn of the other core moves its corners by their reach, one of the
  // owner all that lies between its origin and them.
  const double reach = narrow::reach_of(other), far = reach + narrow::magnitude(d);
  cache.slack = separation;
  cache.reach = on_a ? far : reach;
  cache.reach_b = on_a ? reach : far;
  cache.offset = pose_b.p - pose_a.p;
  cache.turn = pose_a.q;
  cache.turn_b = pose_b.q;
  return true;
}

/// Two polygons or capsules that the cache knows to have been apart.
[[gnu::noinline]] bool apart_again(const Shape& shape_a, const Transform& pose_a, const Shape& shape_b,
                                   const Transform& pose_b, double limit, SatCache& cache,
                                   NarrowPhaseStats* stats) {
  const Hull a = narrow::hull_of(shape_a), b = narrow::hull_of(shape_b);
  if (!apart_on_cached_axis(a, pose_a, b, pose_b, limit, cache)) return false;
  if (stats != nullptr) {
    stats->axes_tested += 1;
    stats->axes_skipped += static_cast<std::uint64_t>(a.count + b.count - 1);
  }
  return true;
}

/// Two cores in the order of the pair. @tparam N  corners of both, which are rectangles; 0: any cores
template <int N>
[[gnu::always_inline]] inline void ordered_cores(const Hull& first, const Hull& second,
                                                 const Transform& frame, const Transform& other,
                                                 bool exchange, double margin, double limit, SatCache* cache,
                                                 NarrowPhaseStats* stats, Manifold& m) {
  Transform relative = narrow::relative_pose(frame, other);
  narrow::write_whole(relative.p);
  narrow::write_whole(relative.q);
  narrow::Output out{m, frame, exchange, {}};
  // The cache speaks of a and b, the search of first and second.
  const std::int32_t flip = exchange ? -1 : 0;
  if (cache != nullptr) {
    // What is known of a settled pair is in the frame of its first shape.
    if (cache->exchanged != exchange) cache->state = SatCache::State::Empty;
    cache->exchanged = exchange;
    cache->axis ^= flip;
    cache->partner ^= flip;
  }
  narrow::Placed placed;
  const narrow::Axis axis = N > 0 ? narrow::search<N, N>(first, second, relative, limit, placed, cache, stats)
                                  : narrow::find_axis(first, second, relative, limit, placed, cache, stats);
  if (cache != nullptr) {
    cache->axis ^= flip;
    cache->partner ^= flip;
  }
  if (axis.apart) return;
  if (axis.separation >= -narrow::kNoise * axis.scale) {
    return narrow::clip_touching(first, second, placed, axis, margin, out);
  }
  narrow::clip_overlap<N>(first, second, placed, axis, margin, out);
}

/// Two polygons or capsules.
[[gnu::always_inline]] inline void cores(const Shape& shape_a, const Transform& pose_a, const Shape& shape_b,
                                         const Transform& pose_b, double margin, SatCache* cache,
                                         NarrowPhaseStats* stats, Manifold& m) {
  const Vec2 d = pose_b.p - pose_a.p;
  if (!(narrow::magnitude(d) < narrow::kFarAway)) return;
  const double limit = margin + shape_a.radius + shape_b.radius;
  if (cache != nullptr && cache->state == SatCache::State::Apart &&
      apart_again(shape_a, pose_a, shape_b, pose_b, limit, *cache, stats)) {
    return;
  }
  const bool boxes = shape_a.rectangle.half.x > 0 && shape_b.rectangle.half.x > 0;
  // With a cache an axis is worth knowing.
  if (boxes && cache == nullptr &&
      narrow::discs_around_apart(shape_a.rectangle, shape_b.rectangle, d, limit)) {
    if (stats != nullptr) stats->axes_skipped += 8;
    return;
  }
  const bool exchange = narrow::second_comes_first(shape_a, pose_a, shape_b, pose_b);
  const Transform &frame = exchange ? pose_b : pose_a, &other = exchange ? pose_a : pose_b;
  const Shape &first = exchange ? shape_b : shape_a, &second = exchange ? shape_a : shape_b;
  if (boxes) {
    const auto hull = [](const Shape& s) {
      return Hull{s.kind, s.vertices.data(), s.normals.data(), 4, s.radius, &s.rectangle};
    };
    return ordered_cores<4>(hull(first), hull(second), frame, other, exchange, margin, limit, cache, stats,
                            m);
  }
  ordered_cores<0>(narrow::hull_of(first), narrow::hull_of(second), frame, other, exchange, margin, limit,
                   cache, stats, m);
}

/// Pairs with a half-plane, or with a disc and something else.
void others(const Shape& a, const Transform& pose_a, const Shape& b, const Transform& pose_b, double margin,
            NarrowPhaseStats* stats, Manifold& m) {
  if (a.kind == ShapeKind::Chain || b.kind == ShapeKind::Chain) {
    throw std::invalid_argument("collide: a chain is met segment by segment (collide_chain_segment)");
  }
  const int rank_a = narrow::rank_of(a.kind), rank_b = narrow::rank_of(b.kind);
  if (rank_a == rank_b || !(narrow::magnitude(pose_b.p - pose_a.p) < narrow::kFarAway)) return;
  const bool exchange = rank_a < rank_b;
  const Transform& frame = exchange ? pose_b : pose_a;
  narrow::Output out{m, frame, exchange, {}};
  const Transform relative = narrow::relative_pose(frame, exchange ? pose_a : pose_b);
  narrow::meet(narrow::hull_of(exchange ? b : a), narrow::hull_of(exchange ? a : b), relative, margin,
               nullptr, stats, out);
}

constexpr bool has_edges(ShapeKind kind) {
  return kind == ShapeKind::Polygon || kind == ShapeKind::Capsule;
}

/// Everything but two discs; apart from them, as what it needs (registers, room on the stack) costs two discs
/// more than their contact.
SKERRY_TWICE [[gnu::noinline]] void collide_others(const Shape& a, const Transform& pose_a, const Shape& b,
                                                   const Transform& pose_b, double margin, SatCache* cache,
                                                   NarrowPhaseStats* stats, Manifold& m) {
  if (has_edges(a.kind) && has_edges(b.kind)) {
    cores(a, pose_a, b, pose_b, margin, cache, stats, m);
  } else {
    others(a, pose_a, b, pose_b, margin, stats, m);
  }
}

}  // namespace

SKERRY_TWICE Manifold collide(const Shape& a, const Transform& pose_a, const Shape& b,
                              const Transform& pose_b, double margin, SatCache* cache,
                              NarrowPhaseStats* stats) {
  Manifold m;
  if (a.kind == ShapeKind::Disc && b.kind == ShapeKind::Disc) {
    discs(a, pose_a, b, pose_b, margin, m);
  } else if (cache != nullptr && cache->state == SatCache::State::Apart &&
             narrow::still_apart(*cache, pose_a, pose_b, margin + a.radius + b.radius)) {
    if (stats != nullptr) stats->axes_skipped += a.vertices.size() + b.vertices.size();
  } else {
    collide_others(a, pose_a, b, pose_b, margin, cache, stats, m);
  }
  if (stats != nullptr) {
    stats->pairs += 1;
    stats->manifolds += m.count > 0 ? 1 : 0;
  }
  return m;
}

}  // namespace skerry
