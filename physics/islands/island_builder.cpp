// SPDX-License-Identifier: MIT
#include "physics/islands/island_builder.h"

#include <numeric>

namespace skerry {

std::vector<Island> build_islands(const std::vector<std::uint8_t>& dynamic,
                                  const std::vector<IslandEdge>& edges) {
  std::vector<std::uint32_t> parent(dynamic.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto find = [&parent](std::uint32_t i) {
    while (parent[i] != i) {
      parent[i] = parent[parent[i]];
      i = parent[i];
    }
    return i;
  };

  // The smaller root wins, so that every root is the smallest body of its island.
  for (const IslandEdge& edge : edges) {
    if (!edge.a_dynamic || !edge.b_dynamic) continue;
    const std::uint32_t a = find(edge.a);
    const std::uint32_t b = find(edge.b);
    if (a < b) parent[b] = a;
    if (b < a) parent[a] = b;
  }

  std::vector<Island> islands;
  std::vector<std::uint32_t> number(dynamic.size());
  for (std::uint32_t i = 0; i < dynamic.size(); ++i) {
    if (!dynamic[i]) continue;
    const std::uint32_t root = find(i);
    if (root == i) {
      number[i] = static_cast<std::uint32_t>(islands.size());
      islands.emplace_back();
    }
    islands[number[root]].bodies.push_back(i);
  }
  for (const IslandEdge& edge : edges) {
    if (!edge.a_dynamic && !edge.b_dynamic) continue;
    Island& island = islands[number[find(edge.a_dynamic ? edge.a : edge.b)]];
    (edge.joint ? island.joints : island.contacts).push_back(edge.index);
  }
  return islands;
}

}  // namespace skerry
