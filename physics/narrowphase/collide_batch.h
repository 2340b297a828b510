// SPDX-License-Identifier: MIT
//
// Contact manifolds of many pairs of one kind, four at a time.
#pragma once

#include <span>

#include "physics/narrowphase/manifold.h"
#include "physics/shape.h"

namespace skerry {

/// Pairs of shapes as arrays by field: entry i of each is of pair i. All have the same length.
struct PairArrays {
  std::span<const Shape*const> shape_a, shape_b;
  std::span<const Transform> pose_a, pose_b;
  std::span<const double> margin;       ///< largest separation that is still reported [m], >= 0
  std::span<SatCache* const> cache;     ///< kept between steps; or empty: none
  std::span<Manifold* const> manifold;  ///< where the results go
};

/// Does what `collide` does for each pair of rectangles (boxes, rounded or not, turned or moved within their
/// bodies), to the bit and in any order of the pairs, at less than half of the time: four pairs side by side,
/// in the registers of AVX2 where the processor has them.
///
/// All eight axes of a pair are tested, which is cheaper than to remember the best one. Pairs that are apart
/// leave in their cache how far; while they have moved by less, they are skipped. What is rare (equal axes,
/// corner against corner) goes through `collide`, as do pairs of other shapes.
///
/// @param stats  counters to add to; may be null
/// @pre the rotations are finite
/// @throws std::invalid_argument for a chain
void collide_boxes(const PairArrays& pairs, NarrowPhaseStats* stats = nullptr);

/// The same for pairs of discs. Caches are not used.
void collide_discs(const PairArrays& pairs, NarrowPhaseStats* stats = nullptr);

/// The same for pairs of a half-plane, which may be either of the two, and a rectangle or disc. Caches are
/// not used.
void collide_half_planes(const PairArrays& pairs, NarrowPhaseStats* stats = nullptr);

/// The same for pairs of a rectangle and a disc, either of which may be the first. Caches are not used.
void collide_boxes_and_discs(const PairArrays& pairs, NarrowPhaseStats* stats = nullptr);

namespace narrow {

/// The functions above for one set of instructions.
struct BatchVersion {
  const char* name;
  void (*boxes)(const PairArrays&, NarrowPhaseStats*);
  void (*discs)(const PairArrays&, NarrowPhaseStats*);
  void (*planes)(const PairArrays&, NarrowPhaseStats*);
  void (*boxes_and_discs)(const PairArrays&, NarrowPhaseStats*);
};
/// The versions that this processor can run, the one that is taken first; for tests and benchmarks.
std::span<const BatchVersion> batch_versions();

}  // namespace narrow

}  // namespace skerry
