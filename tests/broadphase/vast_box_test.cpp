// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include "physics/broadphase/broadphase.h"

namespace skerry {
namespace vast_box_test {

/// A floor 1e12 m wide under a row of boxes must not put them all into one cell: the tests stay linear.
TEST(HierarchicalGrid, OneVastBoxDoesNotMakeTheOthersShareACell) {
  for (const char* name : {"hierarchical_grid", "auto"}) {
    const auto broad_phase = make_broad_phase(name);
    constexpr std::uint32_t n = 20000;
    broad_phase->insert(0, {{-1e12, -1e12}, {1e12, 0}}, ProxyKind::Fixed);
    for (std::uint32_t i = 1; i <= n; ++i) {
      const double x = 2.0 * (i / 2), y = i % 2;
      broad_phase->insert(i, {{x, y}, {x + 1, y + 1}}, ProxyKind::Moving);
    }
    std::vector<Pair> pairs;
    broad_phase->moved_pairs(pairs);
    EXPECT_GE(pairs.size(), n / 2) << name;
    EXPECT_LT(broad_phase->stats().box_tests, 40u * n) << name;
  }
}

}  // namespace vast_box_test
}  // namespace skerry
