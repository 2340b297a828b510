// SPDX-License-Identifier: MIT
//
// Sweeps until the states settle: the answer is exact, the same each time, and the search ends.
#include "physics/solver/settling_sweeps.h"

#include <cmath>
#include <gtest/gtest.h>

#include "physics/solver/body_space_model.h"
#include "physics/solver/solver.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace settling_sweeps_test {

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

// Problems in which sweeps never settle: few rows do so soon or not at all.
TEST(SettlingSweeps, OfFewRowsEndSoon) {
  for (const int seed : {2573, 2681, 4109}) {
    const scenes::SceneOptions options{.friction = 10,
                                       .mass_ratio = 1e6,
                                       .pattern = scenes::MassPattern::Random,
                                       .noise = 1,
                                       .seed = static_cast<std::uint64_t>(seed)};
    const int bodies = 3 + seed % 3;
    const IslandSystem system =
        scenes::random_island({.bodies = bodies, .contacts = 2 * bodies}, options).system;
    const Solution solution = find_solver("body_space").solve(system, {}, {}, nullptr);
    ASSERT_EQ(solution.status, SolveStatus::Inexact) << "seed " << seed;
    EXPECT_LE(solution.work.visits, 2.5e4 * system.size()) << "seed " << seed;
  }
}

TEST(SettlingSweeps, RefuseRowsOfJoints) {
  scenes::SceneOptions options{.friction = 0.5, .seed = 3};
  const IslandSystem system = scenes::random_island({.bodies = 4, .contacts = 6, .pins = 1}, options).system;
  const Walk walk = settle(system);
  EXPECT_FALSE(walk.solved);
  EXPECT_TRUE(walk.lambda.empty());
}

// A stack on the ground, and more ground that comes down on it.
IslandSystem squeezed(IslandSystem system, double speed) {
  Row row;
  row.b = static_cast<int>(system.bodies.size()) - 1;
  row.Jb = {0.0, -1.0, 0.1};
  system.rows.push_back(row);
  system.b.push_back(speed);
  return system;
}

TEST(SettlingSweeps, SeeContactsThatContradictEachOther) {
  SolveBudget budget;
  budget.factorisations = 1000;
  for (const double friction : {0.0, 0.5}) {
    const scenes::SceneOptions options{.friction = friction};
    for (const IslandSystem& system : {scenes::stack(1, options).system, scenes::stack(3, options).system,
                                       scenes::pyramid(4, options).system}) {
      SolveWork work;
      EXPECT_FALSE(contradicts(system, budget, work));
      EXPECT_TRUE(contradicts(squeezed(system, 1), budget, work));
      const Solution solution = find_solver("body_space").solve(squeezed(system, 1), {}, {}, nullptr);
      EXPECT_EQ(solution.status, SolveStatus::Inexact);
      EXPECT_LE(solution.residual, 1);
      EXPECT_LE(solution.work.factorisations, 300);
    }
    // What takes long is no contradiction.
    for (const double ratio : {1e3, 1e6}) {
      SolveWork work;
      const scenes::SceneOptions heavy{
          .friction = friction, .mass_ratio = ratio, .pattern = scenes::MassPattern::HeavyOnTop};
      EXPECT_FALSE(contradicts(scenes::stack(5, heavy).system, budget, work));
    }
  }
  SolveWork work;
  budget.visits = 1000;
  EXPECT_FALSE(contradicts(squeezed(scenes::stack(3).system, 1), budget, work));
  EXPECT_LE(work.visits, 1000);
}

}  // namespace settling_sweeps_test
}  // namespace skerry
