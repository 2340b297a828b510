// SPDX-License-Identifier: MIT
#include "physics/islands/island_builder.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <random>

namespace skerry {
namespace island_builder_test {

/// Components by repeated relabelling: slow and obvious.
std::vector<int> labels_by_relabelling(const std::vector<std::uint8_t>& dynamic,
                                       const std::vector<IslandEdge>& edges) {
  std::vector<int> label(dynamic.size());
  for (std::size_t i = 0; i < label.size(); ++i) label[i] = static_cast<int>(i);
  for (bool changed = true; changed;) {
    changed = false;
    for (const IslandEdge& edge : edges) {
      if (!edge.a_dynamic || !edge.b_dynamic || label[edge.a] == label[edge.b]) continue;
      label[edge.a] = label[edge.b] = std::min(label[edge.a], label[edge.b]);
      changed = true;
    }
  }
  return label;
}

std::vector<std::uint32_t> members_of(const std::vector<std::uint8_t>& flags) {
  std::vector<std::uint32_t> members;
  for (std::uint32_t i = 0; i < flags.size(); ++i) {
    if (flags[i]) members.push_back(i);
  }
  return members;
}

TEST(IslandBuilder, AgreesWithRelabellingOnRandomGraphs) {
  const unsigned seed = 3;
  std::mt19937 random(seed);
  IslandBuilder builder;
  for (int trial = 0; trial < 300; ++trial) {
    const std::uint32_t bodies = 1 + random() % 40;
    std::vector<std::uint8_t> dynamic(bodies);
    for (auto& flag : dynamic) flag = random() % 4 != 0;
    std::vector<IslandEdge> edges;
    for (std::uint32_t i = 0; bodies > 1 && i < random() % 60; ++i) {
      const std::uint32_t a = random() % bodies;
      const std::uint32_t b = (a + 1 + random() % (bodies - 1)) % bodies;
      edges.push_back({a, b, dynamic[a] != 0, dynamic[b] != 0, i, random() % 5 == 0});
    }
    const std::vector<Island> islands = builder.build(members_of(dynamic), edges);
    const std::vector<int> label = labels_by_relabelling(dynamic, edges);
    std::size_t members = 0;
    std::uint32_t last_first = 0;
    for (const Island& island : islands) {
      ASSERT_FALSE(island.bodies.empty());
      ASSERT_TRUE(std::is_sorted(island.bodies.begin(), island.bodies.end()));
      ASSERT_TRUE(std::is_sorted(island.contacts.begin(), island.contacts.end()));
      ASSERT_TRUE(&island == &islands[0] || island.bodies[0] > last_first)
          << "canonical order, seed " << seed;
      last_first = island.bodies[0];
      for (const std::uint32_t body : island.bodies)
        ASSERT_EQ(label[body], label[island.bodies[0]]) << "seed " << seed;
      members += island.bodies.size();
    }
    ASSERT_EQ(members, static_cast<std::size_t>(std::count(dynamic.begin(), dynamic.end(), 1)));
    // Two islands never share a label.
    for (std::size_t i = 0; i + 1 < islands.size(); ++i) {
      for (std::size_t j = i + 1; j < islands.size(); ++j) {
        ASSERT_NE(label[islands[i].bodies[0]], label[islands[j].bodies[0]]);
      }
    }
  }
}

TEST(IslandBuilder, StaticBodiesDoNotConnect) {
  // Two boxes on one floor (body 0).
  const std::vector<Island> islands =
      IslandBuilder().build({1, 2}, {{0, 1, false, true, 0, false}, {0, 2, false, true, 1, false}});
  ASSERT_EQ(islands.size(), 2u);
  EXPECT_EQ(islands[0].contacts, std::vector<std::uint32_t>{0});
  EXPECT_EQ(islands[1].contacts, std::vector<std::uint32_t>{1});
}

TEST(IslandBuilder, EdgesWithoutADynamicBodyBelongToNoIsland) {
  const std::vector<Island> islands = IslandBuilder().build({2}, {{0, 1, false, false, 0, false}});
  ASSERT_EQ(islands.size(), 1u);
  EXPECT_TRUE(islands[0].contacts.empty());
}

}  // namespace island_builder_test
}  // namespace skerry
