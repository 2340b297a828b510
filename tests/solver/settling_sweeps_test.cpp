// SPDX-License-Identifier: MIT
//
// Sweeps until the states settle: the answer is exact, the same each time, and the search ends.
#include "physics/solver/settling_sweeps.h"

#include <cmath>
#include <gtest/gtest.h>

#include "physics/solver/body_space_model.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace {

struct Walk {
  bool solved = false;
  std::vector<double> lambda;
  SolveWork work;
};

Walk settle(const IslandSystem& system, const SettlingOptions& options = {}, double visits = kInfinity) {
  Walk walk;
  BodySpaceModel model;
  model.assign(system, walk.work);
  ActiveSet active(model);
  active.reset(kInfinity);
  SolveBudget budget;
  budget.factorisations = 100000;
  budget.visits = visits;
  walk.solved = settle_by_sweeps(system, active, options, budget, walk.work, nullptr);
  if (std::isfinite(active.best_residual())) walk.lambda = active.best();
  return walk;
}

// A heap in hexagonal packing is too steep to stand: its discs roll and slip in every direction.
TEST(SettlingSweeps, EndWithTheExactAnswerOfHeapsThatFallApart) {
  for (const double noise : {0.0, 0.3}) {
    const IslandSystem system = scenes::disc_heap(12, {.friction = 0.5, .noise = noise, .seed = 7}).system;
    const Walk walk = settle(system);
    ASSERT_TRUE(walk.solved) << "noise " << noise;
    EXPECT_LE(natural_map_residual(system, walk.lambda), 1e-12) << "noise " << noise;
    EXPECT_EQ(settle(system).lambda, walk.lambda) << "noise " << noise;
  }
}

TEST(SettlingSweeps, GiveUpAfterAsManySweepsAsTheyAreAllowed) {
  const IslandSystem system = scenes::disc_heap(24, {.friction = 0.5, .noise = 0.3, .seed = 7}).system;
  const double n = system.size();
  const Walk few = settle(system, {.tolerance = 1e-10, .sweeps = 1000});
  EXPECT_FALSE(few.solved);
  EXPECT_NEAR(few.work.visits, 1000 * n, 200 * n);
  const Walk bounded = settle(system, {}, 500 * n);
  EXPECT_FALSE(bounded.solved);
  EXPECT_NEAR(bounded.work.visits, 500 * n, 200 * n);
}

TEST(SettlingSweeps, RefuseRowsOfJoints) {
  scenes::SceneOptions options{.friction = 0.5, .seed = 3};
  const IslandSystem system = scenes::random_island({.bodies = 4, .contacts = 6, .pins = 1}, options).system;
  const Walk walk = settle(system);
  EXPECT_FALSE(walk.solved);
  EXPECT_TRUE(walk.lambda.empty());
}

}  // namespace
}  // namespace skerry
