// SPDX-License-Identifier: MIT
//
// Tests a sorted list of candidate pairs against the boxes of this moment: single precision decides but for
// ties, four pairs at once where the processor can, and what is left is in the order of the list.
#pragma once

#include <span>

#include "physics/broadphase/float_box.h"
#include "physics/broadphase/pair_finder.h"

namespace skerry {

/// Places that a list must have after its candidates, so that a look ahead needs no test for its end.
inline constexpr std::size_t kCandidatePadding = 28;

/// What all candidates of a list are tested for.
struct CandidateTests {
  const PairRequest& request;
  std::span<const FloatBox> boxes;  ///< by proxy
  bool by_mark;                     ///< keep only pairs with a box that is marked as moved
  bool scattered;                   ///< neighbours in the list are not neighbours in memory, nor in a cache
  bool wide;                        ///< use wide vector instructions where the processor has them

  /// Appends the candidates that are pairs to `out`, in their order.
  /// @param candidates  followed by `kCandidatePadding` pairs of proxies that exist
  void run(std::span<const Pair> candidates, PairBuffer& out, BroadPhaseStats& stats) const;
};

}  // namespace skerry
