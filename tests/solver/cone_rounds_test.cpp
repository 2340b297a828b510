// SPDX-License-Identifier: MIT
//
// Sweeps and the interior point on the cone in turn: exact answers of islands in which contacts open, stick
// and slip all over, from impulses of another such motion.
#include "physics/solver/cone_rounds.h"

#include <cstdio>
#include <gtest/gtest.h>

#include "physics/solver/body_space.h"
#include "tests/support/island_scenes.h"
#include "tests/support/scale.h"
#include "tests/support/solve_budget.h"

namespace skerry {
namespace cone_rounds_test {

using test::factors;

struct Busy {
  IslandSystem system;
  std::vector<double> warm;  ///< impulses of the same island with other velocities
};

std::vector<Busy> busy_islands() {
  std::vector<Busy> all;
  const auto add = [&](auto make) {
    for (const double noise : {0.5, 3.0})
      for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(test_scale(4)); ++seed) {
        const scenes::SceneOptions now{.friction = 0.5, .noise = noise, .seed = seed};
        const scenes::SceneOptions before{.friction = 0.5, .noise = noise, .seed = seed + 1000};
        all.push_back({make(now).system, solve_body_space(make(before).system, {}, {}, nullptr).lambda});
      }
  };
  add([](const scenes::SceneOptions& o) { return scenes::disc_heap(14, o); });
  add([](const scenes::SceneOptions& o) { return scenes::pyramid(14, o); });
  add([](const scenes::SceneOptions& o) { return scenes::wall(12, 12, false, o); });
  return all;
}

TEST(ConeRounds, EndExactlyWhatFlows) {
  int rounds_alone = 0, solved = 0;
  const std::vector<Busy> islands = busy_islands();
  for (const Busy& island : islands) {
    SolveWork work;
    BodySpaceModel model;
    ActiveSet active(model);
    active.reset(model.assign(island.system, work));
    const SolveBudget budget = factors(1000);
    if (cone_rounds(island.system, island.warm, model, active, {}, budget, work, nullptr)) {
      ++rounds_alone;
      EXPECT_LE(natural_map_residual(island.system, active.best()), 1e-9);
    }
    EXPECT_GT(work.factorisations, 0);
    const Solution solution = solve_body_space(island.system, island.warm, {}, nullptr);
    solved += solution.status == SolveStatus::Solved;
    EXPECT_LE(solution.residual, 1e-2);
  }
  std::printf("%zu islands: %d by rounds alone, %d with what follows\n", islands.size(), rounds_alone,
              solved);
  EXPECT_GE(rounds_alone, static_cast<int>(islands.size()) / 2);
  EXPECT_GE(solved, 9 * static_cast<int>(islands.size()) / 10);
}

TEST(ConeRounds, LeaveJointsAndCompliantRowsToOthers) {
  for (const bool joint : {true, false}) {
    IslandSystem system = scenes::pyramid(4, {.friction = 0.5}).system;
    if (joint) {
      system.rows[0].kind = RowKind::Joint;
      system.rows[0].lower = -kInfinity;
    } else {
      system.compliance.assign(system.rows.size(), 1e-3);
    }
    SolveWork work;
    BodySpaceModel model;
    ActiveSet active(model);
    active.reset(model.assign(system, work));
    EXPECT_FALSE(cone_rounds(system, {}, model, active, {}, factors(100), work, nullptr));
    EXPECT_EQ(work.factorisations, 0);
  }
}

TEST(ConeRounds, KeepToTheBudget) {
  const IslandSystem system = scenes::disc_heap(14, {.friction = 0.5, .noise = 3, .seed = 1}).system;
  for (const int most : {1, 5, 20}) {
    SolveWork work;
    BodySpaceModel model;
    ActiveSet active(model);
    active.reset(model.assign(system, work));
    cone_rounds(system, {}, model, active, {}, factors(most), work, nullptr);
    EXPECT_LE(work.factorisations, most + 1);
    EXPECT_LT(active.best_residual(), kInfinity);
  }
}

}  // namespace cone_rounds_test
}  // namespace skerry
