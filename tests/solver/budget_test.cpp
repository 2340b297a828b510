// SPDX-License-Identifier: MIT
//
// The budget is counted work: the same answer on every machine, found in time, and no worse for having more
// of it.
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>

#include "physics/solver/auto.h"
#include "tests/support/island_scenes.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace budget_test {

using scenes::Scene;

Solution solve(const IslandSystem& system, double work_limit) {
  return solve_auto(system, {}, {.work_limit = work_limit}, nullptr);
}

TEST(Budget, IsKeptToWithinAFewFactorisationsAndGivesTheSameBits) {
  const Scene scene = scenes::pyramid(15, {.noise = 1});
  const double rows = static_cast<double>(scene.system.rows.size());
  const Solution rich = solve(scene.system, 0);
  EXPECT_EQ(rich.status, SolveStatus::Solved);
  for (const double limit : {1e3, 1e4, 1e5, 1e6}) {
    SCOPED_TRACE("limit " + std::to_string(limit));
    const Solution poor = solve(scene.system, limit);
    for (const double z : poor.lambda) ASSERT_TRUE(std::isfinite(z));
    EXPECT_EQ(poor.residual, natural_map_residual(scene.system, poor.lambda));
    // A rung ends after the factorisation in which its share runs out: some ten visits a row, four rungs.
    EXPECT_LE(poor.work.visits, 1.5 * limit + 100 * rows);
    EXPECT_EQ(poor.lambda, solve(scene.system, limit).lambda);
  }
  // Enough is as good as no limit at all, to the bit.
  EXPECT_EQ(solve(scene.system, 10 * rich.work.visits).lambda, rich.lambda);
  EXPECT_LT(solve(scene.system, 1e6).residual, solve(scene.system, 1e3).residual);
}

TEST(Budget, HoweverSmallEachRowGetsAnImpulse) {
  for (const double friction : {0.0, 0.5}) {
    Scene scene = scenes::pyramid(4);
    for (Row& row : scene.system.rows) row.mu = row.mu > 0 ? friction : 0;
    for (const double limit : {1e-300, 1.0, 30.0, 1e3}) {
      const Solution solution = solve(scene.system, limit);
      ASSERT_EQ(solution.lambda.size(), scene.system.rows.size()) << limit;
      EXPECT_NEAR(solution.residual, natural_map_residual(scene.system, solution.lambda), 1e-15) << limit;
    }
  }
}

TEST(Budget, SweepingSolversStopAtIt) {
  const Scene scene = scenes::stack(30);
  const double rows = static_cast<double>(scene.system.rows.size());
  for (const char* name : {"pgs", "nncg"}) {
    SCOPED_TRACE(name);
    const Solution solution = find_solver(name).solve(scene.system, {}, {.work_limit = 50 * rows}, nullptr);
    EXPECT_GE(solution.work.visits, 50 * rows);
    EXPECT_LE(solution.work.visits, 52 * rows);
    EXPECT_EQ(solution.status, SolveStatus::Inexact);
  }
}

/// A heap of boxes that falls over itself.
World falling_heap(double work_limit) {
  WorldConfig config;
  config.solve.work_limit = work_limit;
  config.flow_work = 0;
  World world(config);
  const ShapeDef box = test::rough(make_box({1, 1}), 0.5);
  test::add_ground(world, box);
  for (int i = 0; i < 30; ++i)
    test::add(world, {1.07 * (i % 6) + 0.21 * (i / 6), 0.6 + 1.15 * (i / 6)}, box, 1, {}, 0.3 * (i % 3 - 1));
  return world;
}

TEST(Budget, AWorldKeepsToItSaysSoAndStaysFinite) {
  World poor = falling_heap(2e4), again = falling_heap(2e4), rich = falling_heap(0);
  int inexact = 0;
  double most = 0, most_rich = 0;
  for (int step = 0; step < 45; ++step) {
    const StepReport& report = poor.step(1.0 / 60);
    inexact += report.inexact_islands;
    most = std::max(most, report.work.visits);
    EXPECT_EQ(report.state_hash, again.step(1.0 / 60).state_hash);
    EXPECT_EQ(report.contained, 0);
    EXPECT_GE(report.worst_residual, 0);
    // Nothing done leaves 1; sweeps that are cut off can leave a little more than that.
    EXPECT_LE(report.worst_residual, 2);
    most_rich = std::max(most_rich, rich.step(1.0 / 60).work.visits);
  }
  EXPECT_GT(inexact, 0);
  EXPECT_LT(most, most_rich);
  EXPECT_TRUE(std::isfinite(poor.kinetic_energy()));
}

/// What has spent its budget flows: forces that are as good as none let piles with joints fall through the
/// ground.
TEST(Budget, WhereItIsNextToNothingBodiesStillLieOnTheGround) {
  for (const unsigned seed : {7u, 8u, 9u}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const auto uniform = [&](double low, double high) {
      return low + (high - low) * (random() / 4294967296.0);
    };
    WorldConfig config;
    config.solve.work_limit = 2000;
    config.stepper = "auto";
    World world(config);
    test::add_ground(world, test::rough(make_disc(1), 0.5));
    std::vector<BodyId> bodies;
    for (int k = 0; k < 60; ++k) {
      const double x = uniform(-2, 2), width = uniform(0.3, 0.8), height = uniform(0.2, 0.8);
      const ShapeDef shape =
          test::rough(k % 3 ? make_box({width, height}) : make_disc(height / 2), uniform(0.2, 0.8));
      bodies.push_back(test::add(world, {x, 1 + 0.6 * k}, shape, 1, {}, 0, uniform(0, 3)));
    }
    for (std::size_t k = 0; k + 3 < bodies.size(); k += 6)
      world.create_joint({.a = bodies[k], .b = bodies[k + 1], .anchor_a = world.position(bodies[k])});
    for (const double x : {-3.4, 3.4}) {
      const BodyId wall = world.create_body({.type = BodyType::Static, .position = {x, 30}});
      world.add_shape(wall, test::rough(make_box({1, 64}), 0.5));
    }
    double lowest = kInfinity;
    for (int step = 0; step < 300; ++step) {
      world.step(1.0 / 60);
      for (const BodyId body : bodies) lowest = std::min(lowest, world.position(body).y);
    }
    EXPECT_GT(lowest, 0);
  }
}

TEST(Budget, TheDefaultOfAWorldChangesNothingInAnOrdinaryScene) {
  World standard = falling_heap(WorldConfig{}.solve.work_limit), unlimited = falling_heap(0);
  // Without a limit there is no end to factors either, and a heap that falls has a step now and then that
  // wants more of them than a limited solve gets.
  int same = 0;
  while (same < 40) {
    const StepReport& report = standard.step(1.0 / 60);
    const std::uint64_t hash = unlimited.step(1.0 / 60).state_hash;
    if (report.inexact_islands > 0) break;
    EXPECT_EQ(report.state_hash, hash) << same;
    ++same;
  }
  EXPECT_GE(same, 20);
}

TEST(Budget, OfAWorldMustNotBeNegative) {
  WorldConfig config;
  config.solve.work_limit = -1;
  EXPECT_THROW(World{config}, std::invalid_argument);
}

}  // namespace budget_test
}  // namespace skerry
