// SPDX-License-Identifier: MIT
#include "physics/narrowphase/collide_batch.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <iterator>

#include "physics/narrowphase/avx2.h"
#include "physics/narrowphase/collide.h"
#include "physics/narrowphase/sat_search.h"

namespace skerry::narrow {
namespace {

// What a point looks like to whoever writes it in one piece.
static_assert(sizeof(ManifoldPoint) == 32 && offsetof(ManifoldPoint, separation) == 16 &&
              offsetof(ManifoldPoint, feature) == 24);
static_assert(std::endian::native == std::endian::little);

#if !defined(SKERRY_MUST_HAVE_AVX2)
namespace baseline {
#define SKERRY_FOUR_AVX2 0
#include "physics/narrowphase/four_lanes.h"
//
#include "physics/narrowphase/batch_kernels.h"
//
#include "physics/narrowphase/plane_kernels.h"
//
#include "physics/narrowphase/disc_kernels.h"
#undef SKERRY_FOUR_AVX2
}  // namespace baseline
#endif

#if defined(SKERRY_MAY_USE_AVX2)
SKERRY_AVX2_BEGIN
namespace avx2 {
#define SKERRY_FOUR_AVX2 1
#include "physics/narrowphase/four_lanes.h"
//
#include "physics/narrowphase/batch_kernels.h"
//
#include "physics/narrowphase/plane_kernels.h"
//
#include "physics/narrowphase/disc_kernels.h"
#undef SKERRY_FOUR_AVX2
}  // namespace avx2
SKERRY_AVX2_END
#endif

bool is_box(const Shape& shape) {
  return shape.rectangle.half.x > 0;
}

// Entries that are looked at before the next ones: their lists stay in the nearest memory.
constexpr std::size_t kBlock = 128;

void add(const NarrowPhaseStats& counted, NarrowPhaseStats* stats) {
  if (stats == nullptr) return;
  stats->pairs += counted.pairs;
  stats->manifolds += counted.manifolds;
  stats->axes_tested += counted.axes_tested;
  stats->axes_skipped += counted.axes_skipped;
}

void alone(const PairArrays& pairs, std::size_t i, SatCache* cache, NarrowPhaseStats& stats) {
  *pairs.manifold[i] = collide(*pairs.shape_a[i], pairs.pose_a[i], *pairs.shape_b[i], pairs.pose_b[i],
                               pairs.margin[i], cache, &stats);
}

/// True if two boxes are known to be apart, or are so far apart that no axis is needed.
bool apart_at_once(const PairArrays& pairs, std::size_t i, SatCache* cache) {
  const Shape &a = *pairs.shape_a[i], &b = *pairs.shape_b[i];
  const Transform &pose_a = pairs.pose_a[i], &pose_b = pairs.pose_b[i];
  const double limit = pairs.margin[i] + a.radius + b.radius;
  if (cache == nullptr) return discs_around_apart(a.rectangle, b.rectangle, pose_b.p - pose_a.p, limit);
  if (cache->state != SatCache::State::Apart) return false;
  if (still_apart(*cache, pose_a, pose_b, limit)) return true;
  // Whether it is apart is found out anew.
  cache->state = SatCache::State::Empty;
  return false;
}

using BoxGroups = std::size_t (*)(const PairArrays& pairs, const std::uint32_t* list, std::size_t count,
                                  std::uint32_t* left, NarrowPhaseStats& stats);
template <BoxGroups kGroups>
void boxes_by(const PairArrays& pairs, NarrowPhaseStats* stats) {
  const auto cache_of = [&](std::size_t i) { return pairs.cache.empty() ? nullptr : pairs.cache[i]; };
  NarrowPhaseStats counted;
  std::uint32_t list[kBlock], left[kBlock];
  for (std::size_t from = 0; from < pairs.shape_a.size(); from += kBlock) {
    const std::size_t to = std::min(from + kBlock, pairs.shape_a.size());
    std::size_t count = 0;
    for (std::size_t i = from; i < to; ++i) {
      if (!is_box(*pairs.shape_a[i]) || !is_box(*pairs.shape_b[i])) {
        alone(pairs, i, cache_of(i), counted);
      } else if (apart_at_once(pairs, i, cache_of(i))) {
        *pairs.manifold[i] = Manifold();
        counted.pairs += 1;
        counted.axes_skipped += 8;
      } else {
        list[count++] = static_cast<std::uint32_t>(i);
      }
    }
    const std::size_t rest = kGroups(pairs, list, count, left, counted);
    counted.pairs += count - rest;
    counted.axes_tested += 8 * (count - rest);
    for (std::size_t i = 0; i < rest; ++i) alone(pairs, left[i], cache_of(left[i]), counted);
  }
  add(counted, stats);
}

using DiscGroups = std::size_t (*)(const PairArrays& pairs, std::size_t from, std::size_t to,
                                   std::uint32_t* left, NarrowPhaseStats& stats);
template <DiscGroups kGroups>
void discs_by(const PairArrays& pairs, NarrowPhaseStats* stats) {
  NarrowPhaseStats counted;
  std::uint32_t left[kBlock];
  for (std::size_t from = 0; from < pairs.shape_a.size(); from += kBlock) {
    const std::size_t to = std::min(from + kBlock, pairs.shape_a.size());
    const std::size_t rest = kGroups(pairs, from, to, left, counted);
    counted.pairs += to - from - rest;
    for (std::size_t i = 0; i < rest; ++i) alone(pairs, left[i], nullptr, counted);
  }
  add(counted, stats);
}

/// What meets the half-plane of a pair; null if none of the two is one.
const Shape* beside_plane(const Shape& a, const Shape& b) {
  return a.kind == ShapeKind::HalfPlane ? &b : b.kind == ShapeKind::HalfPlane ? &a : nullptr;
}

using PlaneGroups = BoxGroups;
template <PlaneGroups kBoxes, PlaneGroups kDiscs>
void planes_by(const PairArrays& pairs, NarrowPhaseStats* stats) {
  NarrowPhaseStats counted;
  std::uint32_t boxes[kBlock], discs[kBlock], left[kBlock];
  for (std::size_t from = 0; from < pairs.shape_a.size(); from += kBlock) {
    const std::size_t to = std::min(from + kBlock, pairs.shape_a.size());
    std::size_t box_count = 0, disc_count = 0;
    for (std::size_t i = from; i < to; ++i) {
      const Shape* const body = beside_plane(*pairs.shape_a[i], *pairs.shape_b[i]);
      if (body != nullptr && is_box(*body)) {
        boxes[box_count++] = static_cast<std::uint32_t>(i);
      } else if (body != nullptr && body->kind == ShapeKind::Disc) {
        discs[disc_count++] = static_cast<std::uint32_t>(i);
      } else {
        alone(pairs, i, nullptr, counted);
      }
    }
    std::size_t rest = kBoxes(pairs, boxes, box_count, left, counted);
    rest += kDiscs(pairs, discs, disc_count, left + rest, counted);
    counted.pairs += box_count + disc_count - rest;
    for (std::size_t i = 0; i < rest; ++i) alone(pairs, left[i], nullptr, counted);
  }
  add(counted, stats);
}

using BoxDiscGroups = BoxGroups;
template <BoxDiscGroups kGroups>
void boxes_and_discs_by(const PairArrays& pairs, NarrowPhaseStats* stats) {
  NarrowPhaseStats counted;
  std::uint32_t list[kBlock], left[kBlock];
  for (std::size_t from = 0; from < pairs.shape_a.size(); from += kBlock) {
    const std::size_t to = std::min(from + kBlock, pairs.shape_a.size());
    std::size_t count = 0;
    for (std::size_t i = from; i < to; ++i) {
      const Shape &a = *pairs.shape_a[i], &b = *pairs.shape_b[i];
      if ((is_box(a) && b.kind == ShapeKind::Disc) || (is_box(b) && a.kind == ShapeKind::Disc)) {
        list[count++] = static_cast<std::uint32_t>(i);
      } else {
        alone(pairs, i, nullptr, counted);
      }
    }
    const std::size_t rest = kGroups(pairs, list, count, left, counted);
    counted.pairs += count - rest;
    counted.axes_tested += 4 * (count - rest);
    for (std::size_t i = 0; i < rest; ++i) alone(pairs, left[i], nullptr, counted);
  }
  add(counted, stats);
}

// The best first.
constexpr BatchVersion kVersions[] = {
#if defined(SKERRY_MAY_USE_AVX2)
    {"AVX2", boxes_by<avx2::box_groups>, discs_by<avx2::disc_groups>,
     planes_by<avx2::plane_groups<4>, avx2::plane_groups<1>>, boxes_and_discs_by<avx2::box_disc_groups>},
#endif
#if !defined(SKERRY_MUST_HAVE_AVX2)
    {"baseline", boxes_by<baseline::box_groups>, discs_by<baseline::disc_groups>,
     planes_by<baseline::plane_groups<4>, baseline::plane_groups<1>>,
     boxes_and_discs_by<baseline::box_disc_groups>},
#endif
};

}  // namespace

std::span<const BatchVersion> batch_versions() {
  const bool best = std::size(kVersions) == 1 || has_avx2();
  return std::span(kVersions).subspan(best ? 0 : 1);
}

}  // namespace skerry::narrow

namespace skerry {

void collide_boxes(const PairArrays& pairs, NarrowPhaseStats* stats) {
  narrow::batch_versions().front().boxes(pairs, stats);
}

void collide_discs(const PairArrays& pairs, NarrowPhaseStats* stats) {
  narrow::batch_versions().front().discs(pairs, stats);
}

void collide_half_planes(const PairArrays& pairs, NarrowPhaseStats* stats) {
  narrow::batch_versions().front().planes(pairs, stats);
}

void collide_boxes_and_discs(const PairArrays& pairs, NarrowPhaseStats* stats) {
  narrow::batch_versions().front().boxes_and_discs(pairs, stats);
}

}  // namespace skerry
