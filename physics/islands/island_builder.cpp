// SPDX-License-Identifier: MIT
#include "physics/islands/island_builder.h"

namespace skerry {

std::vector<Island> IslandBuilder::build(const std::vector<std::uint32_t>& bodies,
                                         const std::vector<IslandEdge>& edges) {
  std::vector<Island> islands;
  build(bodies, edges, islands);
  return islands;
}

void IslandBuilder::build(const std::vector<std::uint32_t>& bodies, const std::vector<IslandEdge>& edges,
                          std::vector<Island>& islands) {
  if (!bodies.empty() && parent_.size() <= bodies.back()) {
    parent_.resize(bodies.back() + 1);
    number_.resize(parent_.size());
  }
  for (const std::uint32_t i : bodies) parent_[i] = i;
  const auto find = [this](std::uint32_t i) {
    while (parent_[i] != i) {
      parent_[i] = parent_[parent_[i]];
      i = parent_[i];
    }
    return i;
  };

  // The smaller root wins, so that every root is the smallest body of its island.
  for (const IslandEdge& edge : edges) {
    if (!edge.a_dynamic || !edge.b_dynamic) continue;
    const std::uint32_t a = find(edge.a);
    const std::uint32_t b = find(edge.b);
    if (a < b) parent_[b] = a;
    if (b < a) parent_[a] = b;
  }

  std::uint32_t count = 0;
  for (const std::uint32_t i : bodies) {
    const std::uint32_t root = find(i);
    if (root == i) {
      number_[i] = count++;
      if (islands.size() < count) islands.emplace_back();
      Island& fresh = islands[number_[i]];
      fresh.bodies.clear();
      fresh.contacts.clear();
      fresh.joints.clear();
    }
    islands[number_[root]].bodies.push_back(i);
  }
  islands.resize(count);
  for (const IslandEdge& edge : edges) {
    if (!edge.a_dynamic && !edge.b_dynamic) continue;
    Island& island = islands[number_[find(edge.a_dynamic ? edge.a : edge.b)]];
    (edge.joint ? island.joints : island.contacts).push_back(edge.index);
  }
}

}  // namespace skerry
