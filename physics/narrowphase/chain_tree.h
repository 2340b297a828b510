// SPDX-License-Identifier: MIT
//
// Inside the narrow phase: which segments of a chain can be concerned, in logarithmic time.
//
// Terrain is walked along, so neighbours in the order of segments are neighbours in space, and the order
// itself is a good hierarchy: boxes around 8 segments, around 2 of those boxes, around 4, up to one box. It
// is built once, when the chain is made, and lies in the chain's frame.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "physics/shape.h"

namespace skerry::narrow {

inline constexpr std::size_t kSegmentsInLeaf = 8;

/// Lower and upper corners of all boxes [m]: those of 8 segments first, the largest one last.
std::vector<Vec2> chain_tree(const Shape& chain);

/// Calls `visit(i)` for segments, ascending, without those whose boxes `wanted(box)` (chain's frame) refuses.
/// Up to 7 segments beside a wanted one may be visited, too.
template <class Wanted, class Visit>
void visit_segments(const Shape& chain, Wanted&& wanted, Visit&& visit) {
  const std::size_t segments = chain.normals.size();
  const auto leaf = [&](std::size_t first) {
    const std::size_t last = std::min(first + kSegmentsInLeaf, segments);
    for (std::size_t i = first; i < last; ++i) visit(static_cast<int>(i));
  };
  if (chain.tree.empty()) {
    for (std::size_t first = 0; first < segments; first += kSegmentsInLeaf) leaf(first);
    return;
  }
  // Levels from the leaves up: number of boxes and where they begin.
  std::size_t count[64], begin[64];
  int top = 0;
  count[0] = (segments + kSegmentsInLeaf - 1) / kSegmentsInLeaf;
  begin[0] = 0;
  for (; count[top] > 1; ++top) {
    begin[top + 1] = begin[top] + count[top];
    count[top + 1] = (count[top] + 1) / 2;
  }
  // Down the left side first: at each level at most one right sibling waits.
  struct Node {
    int level;
    std::size_t index;
  } waiting[64];
  int depth = 0;
  waiting[depth++] = {top, 0};
  while (depth > 0) {
    const Node node = waiting[--depth];
    const std::size_t at = 2 * (begin[node.level] + node.index);
    if (!wanted(Aabb{chain.tree[at], chain.tree[at + 1]})) continue;
    if (node.level == 0) {
      leaf(node.index * kSegmentsInLeaf);
      continue;
    }
    const std::size_t child = 2 * node.index;
    if (child + 1 < count[node.level - 1]) waiting[depth++] = {node.level - 1, child + 1};
    waiting[depth++] = {node.level - 1, child};
  }
}

}  // namespace skerry::narrow
