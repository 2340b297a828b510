// SPDX-License-Identifier: MIT
#include "physics/narrowphase/chain_tree.h"

namespace skerry::narrow {

std::vector<Vec2> chain_tree(const Shape& chain) {
  std::vector<Vec2> tree;
  const std::size_t segments = chain.normals.size(), corners = chain.vertices.size();
  const auto add = [&](Vec2 lower, Vec2 upper) {
    tree.push_back(lower);
    tree.push_back(upper);
  };
  for (std::size_t first = 0; first < segments; first += kSegmentsInLeaf) {
    const std::size_t last = std::min(first + kSegmentsInLeaf, segments);  // its corner ends the run
    Vec2 lower = chain.vertices[first], upper = lower;
    for (std::size_t i = first + 1; i <= last; ++i) {
      const Vec2 v = chain.vertices[i < corners ? i : 0];
      lower = {std::min(lower.x, v.x), std::min(lower.y, v.y)};
      upper = {std::max(upper.x, v.x), std::max(upper.y, v.y)};
    }
    add(lower, upper);
  }
  // Each level from the one below it.
  std::size_t begin = 0, count = tree.size() / 2;
  while (count > 1) {
    for (std::size_t i = 0; i < count; i += 2) {
      const std::size_t left = 2 * (begin + i), right = i + 1 < count ? left + 2 : left;
      const Vec2 a = tree[left], b = tree[right], c = tree[left + 1], d = tree[right + 1];
      add({std::min(a.x, b.x), std::min(a.y, b.y)}, {std::max(c.x, d.x), std::max(c.y, d.y)});
    }
    begin += count;
    count = (count + 1) / 2;
  }
  return tree;
}

}  // namespace skerry::narrow
