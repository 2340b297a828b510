// SPDX-License-Identifier: MIT
#include "physics/solver/small_exact.h"

#include <cmath>
#include <gtest/gtest.h>
#include <stdexcept>

#include "tests/support/island_scenes.h"

namespace skerry {
namespace {

using scenes::Scene;

TEST(SmallExact, SticksStacksAndRestingIslandsToTheFloor) {
  for (int height = 1; height <= kSmallBodies; ++height)
    for (const double friction : {0.0, 0.5}) {
      SCOPED_TRACE("height " + std::to_string(height));
      const Scene scene = scenes::stack(height, {.friction = friction});
      ASSERT_TRUE(fits_small_exact(scene.system));
      const Solution solution = solve_small_exact(scene.system, {}, {}, nullptr);
      EXPECT_EQ(solution.method, "small_exact");
      EXPECT_EQ(solution.status, SolveStatus::Solved);
      EXPECT_LE(natural_map_residual(scene.system, solution.lambda), 1e-12);
      EXPECT_NEAR(solution.residual, natural_map_residual(scene.system, solution.lambda), 1e-13);
    }
  const Scene pyramid = scenes::pyramid(3);
  EXPECT_EQ(solve_small_exact(pyramid.system, {}, {}, nullptr).method, "small_exact");
}

TEST(SmallExact, AnswersEveryRandomIslandExactlyByItselfOrByBodySpace) {
  int fast = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const int bodies = 1 + static_cast<int>(seed % 8), contacts = 1 + static_cast<int>(seed % 6);
    const Scene scene =
        scenes::random_island({.bodies = bodies, .contacts = contacts, .pins = static_cast<int>(seed % 3)},
                              {.friction = 0.4, .noise = 0.3, .seed = seed});
    const Solution solution = solve_small_exact(scene.system, {}, {}, nullptr);
    EXPECT_EQ(solution.status, SolveStatus::Solved);
    EXPECT_LE(natural_map_residual(scene.system, solution.lambda),
              std::max(1.1e-10, 16 * residual_floor(scene.system, solution.lambda)));
    fast += solution.method == "small_exact";
  }
  EXPECT_GT(fast, 10);
}

TEST(SmallExact, LeavesWhatDoesNotFitToBodySpace) {
  const Scene tall = scenes::stack(kSmallBodies + 1);
  EXPECT_FALSE(fits_small_exact(tall.system));
  EXPECT_EQ(solve_small_exact(tall.system, {}, {}, nullptr).method, "body_space");
  EXPECT_EQ(solve_small_exact(tall.system, {}, {}, nullptr).status, SolveStatus::Solved);

  Scene fixed = scenes::stack(2);
  fixed.system.bodies[0] = {0, 0};
  EXPECT_FALSE(fits_small_exact(fixed.system));
  EXPECT_FALSE(fits_small_exact(IslandSystem{}));
}

TEST(SmallBatch, GivesTheBitsOfTheSingleSolve) {
  std::vector<Scene> islands;
  for (std::uint64_t seed = 1; seed <= 21; ++seed)
    islands.push_back(scenes::stack(3, {.friction = 0.7, .noise = 0.001, .seed = seed}));
  islands.push_back(scenes::stack(2));                // another topology
  islands.push_back(scenes::stack(12));               // too tall
  islands.push_back(scenes::stack(3, {.noise = 2}));  // does not stick
  std::vector<const IslandSystem*> systems;
  for (const Scene& island : islands) systems.push_back(&island.system);
  const std::vector<Solution> batch = solve_batch(systems, {});
  ASSERT_EQ(batch.size(), islands.size());
  for (std::size_t i = 0; i < islands.size(); ++i) {
    SCOPED_TRACE("island " + std::to_string(i));
    const Solution single = solve_small_exact(islands[i].system, {}, {}, nullptr);
    EXPECT_EQ(batch[i].status, SolveStatus::Solved);
    EXPECT_EQ(batch[i].method, single.method);
    EXPECT_EQ(batch[i].lambda, single.lambda);
    EXPECT_EQ(batch[i].residual, single.residual);
  }
}

TEST(SmallBatch, GivesTheBitsOfTheSingleSolveForAnyIslands) {
  int together = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const int size = static_cast<int>(seed % 7);
    std::vector<Scene> islands;
    std::vector<const IslandSystem*> systems;
    for (std::uint64_t lane = 0; lane < 8; ++lane) {
      // One topology, but for pairs of bodies that are named in another order.
      const scenes::SceneOptions options{.friction = seed % 3 == 0 ? 0 : 0.6,
                                         .rolling = seed % 5 == 0 && seed % 3 != 0 ? 0.01 : 0,
                                         .points_per_edge = 1 + static_cast<int>(seed % 3),
                                         .noise = 1e-3,
                                         .seed = 10 * seed + lane};
      islands.push_back(seed % 4 == 0   ? scenes::stack(1 + size, options)
                        : seed % 4 == 1 ? scenes::pyramid(1 + size % 3, options)
                        : seed % 4 == 2 ? scenes::chain(1 + size, options)
                                        : scenes::random_island({.bodies = 1 + size,
                                                                 .contacts = 1 + static_cast<int>(seed % 5),
                                                                 .pins = static_cast<int>(seed % 3)},
                                                                options));
    }
    for (const Scene& island : islands) systems.push_back(&island.system);
    const std::vector<Solution> batch = solve_batch(systems, {});
    for (std::size_t k = 0; k < islands.size(); ++k) {
      const Solution single = solve_small_exact(islands[k].system, {}, {}, nullptr);
      EXPECT_EQ(batch[k].method, single.method);
      EXPECT_EQ(batch[k].lambda, single.lambda);
      EXPECT_EQ(batch[k].residual, single.residual);
      together += single.method == "small_exact";
    }
  }
  EXPECT_GT(together, 1000);
}

TEST(SmallBatch, RefusesOtherTopologiesAndBadLanes) {
  SmallBatch batch;
  EXPECT_EQ(batch.residual(0), kInfinity);
  EXPECT_TRUE(batch.set(0, scenes::stack(2).system));
  EXPECT_FALSE(batch.set(1, scenes::stack(3).system));
  EXPECT_FALSE(batch.set(1, scenes::stack(2, {.friction = 0}).system));
  EXPECT_FALSE(batch.set(1, scenes::stack(20).system));
  EXPECT_THROW(batch.set(8, scenes::stack(2).system), std::invalid_argument);
  EXPECT_THROW(batch.set(-1, scenes::stack(2).system), std::invalid_argument);
  batch.solve();
  EXPECT_LE(batch.residual(0), 1e-12);
}

TEST(SmallExact, NonsenseNumbersAreNotCalledSolved) {
  Scene scene = scenes::stack(2);
  scene.system.b[0] = 1e308;
  scene.system.b[2] = -1e308;
  const Solution solution = solve_small_exact(scene.system, {}, {}, nullptr);
  for (const double z : solution.lambda) EXPECT_TRUE(std::isfinite(z));
  // A row that moves nothing: D = 0.
  Scene idle = scenes::stack(1);
  idle.system.rows[0].Jb = {0, 0, 0};
  const Solution other = solve_small_exact(idle.system, {}, {}, nullptr);
  for (const double z : other.lambda) EXPECT_TRUE(std::isfinite(z));
}

}  // namespace
}  // namespace skerry
