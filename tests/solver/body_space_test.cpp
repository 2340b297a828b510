// SPDX-License-Identifier: MIT
#include "physics/solver/body_space.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <random>
#include <string>

#include "tests/support/island_scenes.h"
#include "tests/support/settled_heap.h"

namespace skerry {
namespace body_space_test {

using scenes::MassPattern;
using scenes::Scene;
using scenes::SceneOptions;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Solution solve(const IslandSystem& system, const SolveOptions& options = {}) {
  return solve_body_space(system, {}, options, nullptr);
}

void expect_within_bounds(const IslandSystem& system, const Solution& solution) {
  ASSERT_EQ(solution.lambda.size(), system.rows.size());
  for (std::size_t i = 0; i < system.rows.size(); ++i) {
    const Row& row = system.rows[i];
    const double lambda = solution.lambda[i];
    ASSERT_TRUE(std::isfinite(lambda)) << "row " << i;
    const double bound = row.normal >= 0 ? row.mu * solution.lambda[static_cast<std::size_t>(row.normal)] : 0;
    EXPECT_GE(lambda, row.normal >= 0 ? -bound : row.lower) << "row " << i;
    EXPECT_LE(lambda, row.normal >= 0 ? bound : row.upper) << "row " << i;
  }
}

// To 1e-12, or to the rounding floor where that is higher.
void expect_exact(const IslandSystem& system, const Solution& solution) {
  EXPECT_EQ(solution.status, SolveStatus::Solved);
  const double floor = 16 * residual_floor(system, solution.lambda);
  EXPECT_LE(natural_map_residual(system, solution.lambda), std::max(1e-12, floor));
  EXPECT_EQ(solution.residual, natural_map_residual(system, solution.lambda));
  expect_within_bounds(system, solution);
}

double velocity_difference(const IslandSystem& system, const std::vector<double>& x,
                           const std::vector<double>& y) {
  std::vector<std::array<double, 3>> u(system.bodies.size()), v(system.bodies.size());
  apply_impulses(system, x, u);
  apply_impulses(system, y, v);
  double worst = 0;
  for (std::size_t i = 0; i < u.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) worst = std::max(worst, std::abs(u[i][k] - v[i][k]));
  return worst;
}

struct Frozen {
  const char* name;
  Scene (*make)(const SceneOptions&);
};
const Frozen kFrozen[] = {
    {"stack of 10", [](const SceneOptions& o) { return scenes::stack(10, o); }},
    {"stack of 100", [](const SceneOptions& o) { return scenes::stack(100, o); }},
    {"pyramid of 10", [](const SceneOptions& o) { return scenes::pyramid(10, o); }},
    {"pyramid of 20", [](const SceneOptions& o) { return scenes::pyramid(20, o); }},
    {"wall", [](const SceneOptions& o) { return scenes::wall(8, 8, false, o); }},
    {"wall with sides", [](const SceneOptions& o) { return scenes::wall(8, 8, true, o); }},
    {"heap of discs", [](const SceneOptions& o) { return scenes::disc_heap(10, o); }},
    {"discs that settled", [](const SceneOptions& o) { return scenes::settled_discs(300, 20, o); }},
};

TEST(BodySpace, SolvesFrozenScenesToTheFloor) {
  for (const Frozen& frozen : kFrozen)
    for (const double friction : {0.0, 0.5})
      for (const double noise : {0.0, 0.3}) {
        SCOPED_TRACE(std::string(frozen.name) + ", friction " + std::to_string(friction) + ", noise " +
                     std::to_string(noise));
        const Scene scene = frozen.make({.friction = friction, .noise = noise});
        expect_exact(scene.system, solve(scene.system));
      }
}

TEST(BodySpace, RedundantContactsAtRestAreSolvedToTheFloor) {
  for (const int points : {3, 8, 32})
    for (const bool duplicated : {false, true})
      for (const double friction : {0.0, 0.5}) {
        SCOPED_TRACE(std::to_string(points) + " points");
        const SceneOptions options{.friction = friction, .points_per_edge = points, .duplicated = duplicated};
        expect_exact(scenes::stack(20, options).system, solve(scenes::stack(20, options).system));
        expect_exact(scenes::pyramid(6, options).system, solve(scenes::pyramid(6, options).system));
      }
}

TEST(BodySpace, LargeMassRatiosAtRestAreSolvedToTheFloor) {
  for (const MassPattern pattern : {MassPattern::HeavyOnTop, MassPattern::Alternating, MassPattern::Random})
    for (const double ratio : {1e2, 1e4, 1e6})
      for (const double friction : {0.0, 0.5}) {
        SCOPED_TRACE("ratio " + std::to_string(ratio) + " pattern " +
                     std::to_string(static_cast<int>(pattern)));
        const Scene scene =
            scenes::stack(20, {.friction = friction, .mass_ratio = ratio, .pattern = pattern});
        expect_exact(scene.system, solve(scene.system));
      }
}

TEST(BodySpace, VeryHeavyBoxOnLightOnesNeedsNoSearch) {
  for (const double ratio : {1e7, 1e8, 1e9, 1e10}) {
    SCOPED_TRACE("ratio " + std::to_string(ratio));
    const Scene scene = scenes::stack(3, {.mass_ratio = ratio, .pattern = MassPattern::HeavyOnTop});
    const Solution solution = solve(scene.system);
    EXPECT_EQ(solution.status, SolveStatus::Solved);
    // Rounding of a load of `ratio` leaves a residual of some 1e-16 of it.
    EXPECT_LE(solution.residual, 1e-14 * ratio);
    EXPECT_LE(solution.work.factorisations, 8);
  }
}

TEST(BodySpace, ContactsANanometreApartAreSolvedToTheFloor) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scene scene = scenes::random_island({.bodies = 4, .contacts = 9, .near_copy = 1e-9},
                                              {.friction = 0.2, .noise = 1, .seed = seed});
    expect_exact(scene.system, solve(scene.system));
  }
}

TEST(BodySpace, FollowsPathsFromAWarmStartWhoseStatesLeadAstray) {
  int followed = 0, solved = 0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const IslandSystem rest = scenes::disc_heap(10, {.friction = 0.5, .noise = 0.01, .seed = seed}).system;
    std::unique_ptr<SolverMemory> memory;
    Solution solution = solve_body_space(rest, {}, {}, &memory);
    for (int step = 0; step < 20; ++step) {
      IslandSystem pushed = rest;
      const double speed = 0.005 * (1 + step % 7);
      for (std::size_t i = 0; i < rest.rows.size(); ++i) {
        const Row& row = rest.rows[i];
        if (row.a >= 0 && row.a % 50 == step % 2) pushed.b[i] -= speed * row.Ja[0];
        if (row.b >= 0 && row.b % 50 == step % 2) pushed.b[i] -= speed * row.Jb[0];
      }
      solution = solve_body_space(pushed, solution.lambda, {.trace = true}, &memory);
      const std::vector<std::string>& notes = solution.trace->notes;
      const auto path = std::find_if(notes.begin(), notes.end(), [](const std::string& note) {
        return note.starts_with("path from the warm start");
      });
      if (path == notes.end()) continue;
      ++followed;
      if (path + 1 != notes.end()) continue;
      ++solved;
      expect_exact(pushed, solution);
    }
  }
  std::printf("%d of %d\n", solved, followed);
  EXPECT_GE(followed, 8);
  EXPECT_GE(solved, followed / 5);
}

TEST(BodySpace, AgreesInVelocitiesWithLemkeOnSmallIslands) {
  const SolverEntry& lemke = find_solver("lemke");
  int compared = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const double friction = seed % 3 == 0 ? 0 : 0.15;
    const Scene scene =
        scenes::random_island({.bodies = 4, .contacts = 6}, {.friction = friction, .noise = 1, .seed = seed});
    const Solution ours = solve(scene.system);
    expect_exact(scene.system, ours);
    const Solution reference = lemke.solve(scene.system, {}, {}, nullptr);
    if (reference.status != SolveStatus::Solved) continue;
    ++compared;
    EXPECT_LT(velocity_difference(scene.system, ours.lambda, reference.lambda), 1e-7);
  }
  EXPECT_GT(compared, 250);
}

TEST(BodySpace, HoldsJointsTogetherAndLeavesContactsExact) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scene scene = scenes::random_island({.bodies = 6, .contacts = 5, .pins = 4},
                                              {.friction = 0.3, .rolling = 0.05, .noise = 1, .seed = seed});
    const Solution solution = solve(scene.system);
    expect_exact(scene.system, solution);
    const std::vector<double> w = row_velocities(scene.system, solution.lambda);
    for (std::size_t i = 0; i < w.size(); ++i) {
      if (scene.system.rows[i].kind == RowKind::Joint) {
        EXPECT_NEAR(w[i], 0, 1e-9);
      }
    }
  }
}

TEST(BodySpace, MotorsStopAtTheirLargestImpulseAndLimitsOnlyPush) {
  IslandSystem system;
  system.bodies = {{1, 2}};
  Row motor{.kind = RowKind::Motor, .a = -1, .b = 0, .Jb = {0, 0, 1}, .lower = -0.25, .upper = 0.25};
  Row limit{.kind = RowKind::Limit, .a = -1, .b = 0, .Jb = {1, 0, 0}};
  system.rows = {motor, limit};
  system.b = {0.4, -1};  // the motor can do it with 0.2; the limit is not reached
  Solution solution = solve(system);
  expect_exact(system, solution);
  EXPECT_NEAR(solution.lambda[0], 0.2, 1e-14);
  EXPECT_EQ(solution.lambda[1], 0);
  system.b = {-5, 3};  // too much for the motor; the limit pushes
  solution = solve(system);
  expect_exact(system, solution);
  EXPECT_EQ(solution.lambda[0], -0.25);
  EXPECT_NEAR(solution.lambda[1], 3, 1e-14);
}

TEST(BodySpace, ComplianceGivesWay) {
  IslandSystem system;
  system.bodies = {{0.5, 1}};
  system.rows = {{.kind = RowKind::Normal, .a = -1, .b = 0, .Jb = {0, 1, 0}}};
  system.b = {2};
  system.compliance = {1.5};
  const Solution solution = solve(system);
  expect_exact(system, solution);
  EXPECT_NEAR(solution.lambda[0], 2 / (0.5 + 1.5), 1e-14);
}

TEST(BodySpace, BodiesThatCannotMoveAreLikeTheGround) {
  Scene scene = scenes::stack(5, {.noise = 0.1});
  // A fixed body in the middle, one that cannot turn, one that only turns.
  scene.system.bodies[2] = {0, 0};
  scene.system.bodies[3].angular = 0;
  scene.system.bodies[4].linear = 0;
  scene.free_velocity[2] = {};
  scene.free_velocity[3][2] = 0;
  scene.free_velocity[4] = {0, 0, scene.free_velocity[4][2]};
  for (std::size_t i = 0; i < scene.system.rows.size(); ++i) {
    const Row& row = scene.system.rows[i];
    double u = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      if (row.a >= 0) u += row.Ja[k] * scene.free_velocity[static_cast<std::size_t>(row.a)][k];
      u += row.Jb[k] * scene.free_velocity[static_cast<std::size_t>(row.b)][k];
    }
    scene.system.b[i] = -u;
  }
  expect_exact(scene.system, solve(scene.system));

  // Nothing moves at all: approaching rows cannot be helped, the others are at rest.
  for (auto& body : scene.system.bodies) body = {0, 0};
  const Solution stuck = solve(scene.system);
  expect_within_bounds(scene.system, stuck);
  std::fill(scene.system.b.begin(), scene.system.b.end(), 0.0);
  expect_exact(scene.system, solve(scene.system));
}

TEST(BodySpace, AnEmptyIslandIsSolved) {
  const Solution solution = solve(IslandSystem{});
  EXPECT_EQ(solution.status, SolveStatus::Solved);
  EXPECT_TRUE(solution.lambda.empty());
}

TEST(BodySpace, AnUnchangedLoadCostsNoFactorisation) {
  const Scene scene = scenes::pyramid(10, {.noise = 0.1});
  std::unique_ptr<SolverMemory> memory;
  const Solution first = solve_body_space(scene.system, {}, {}, &memory);
  expect_exact(scene.system, first);
  const Solution second = solve_body_space(scene.system, first.lambda, {}, &memory);
  EXPECT_EQ(second.work.factorisations, 0);
  EXPECT_EQ(second.work.resolves, 0);
  EXPECT_EQ(second.lambda, first.lambda);
  EXPECT_EQ(second.status, SolveStatus::Solved);
}

TEST(BodySpace, AChangedLoadIsSolvedWithTheKeptFactor) {
  const Scene scene = scenes::stack(50);
  std::unique_ptr<SolverMemory> memory;
  const Solution first = solve_body_space(scene.system, {}, {}, &memory);
  EXPECT_EQ(first.work.symbolic_analyses, 1);
  IslandSystem heavier = scene.system;
  for (double& b : heavier.b) b *= 1.25;
  const Solution second = solve_body_space(heavier, first.lambda, {}, &memory);
  expect_exact(heavier, second);
  EXPECT_EQ(second.work.factorisations, 0);
  EXPECT_EQ(second.work.symbolic_analyses, 0);
  EXPECT_EQ(second.work.symbolic_skipped, 1);
  EXPECT_GT(second.work.resolves, 0);

  // A little motion is absorbed by the refinement; the answer is as exact.
  IslandSystem moved = heavier;
  for (Row& row : moved.rows) row.Jb[2] += 1e-8;
  const Solution third = solve_body_space(moved, second.lambda, {}, &memory);
  expect_exact(moved, third);
  EXPECT_EQ(third.work.factorisations, 0);
}

TEST(BodySpace, WarmStartsAfterAChangedLoadEndAtTheColdVelocities) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    // Without friction the velocities are unique; with it there may be several solutions.
    const bool unique = seed % 2 == 0;
    const SceneOptions options{.friction = unique ? 0 : 0.3, .noise = 0.05, .seed = seed};
    const Scene before = scenes::pyramid(8, options);
    SceneOptions changed = options;
    changed.noise = 0.06;
    const Scene after = scenes::pyramid(8, changed);
    std::unique_ptr<SolverMemory> memory;
    const Solution first = solve_body_space(before.system, {}, {}, &memory);
    const Solution warm = solve_body_space(after.system, first.lambda, {}, &memory);
    const Solution cold = solve(after.system);
    expect_exact(after.system, warm);
    expect_exact(after.system, cold);
    if (unique) {
      EXPECT_LT(velocity_difference(after.system, warm.lambda, cold.lambda), 1e-9);
    }
  }
}

TEST(BodySpace, MemoryOfAnotherIslandIsNotTrusted) {
  std::unique_ptr<SolverMemory> memory;
  const Scene first = scenes::pyramid(6), second = scenes::stack(21, {.noise = 0.1});
  solve_body_space(first.system, {}, {}, &memory);
  const Solution solution = solve_body_space(second.system, {}, {}, &memory);
  expect_exact(second.system, solution);
  const Solution again = solve_body_space(first.system, {}, {}, &memory);
  expect_exact(first.system, again);
}

TEST(BodySpace, GivesTheSameBitsTwice) {
  const Scene scene = scenes::wall(6, 6, true, {.noise = 0.3});
  const Solution first = solve(scene.system), second = solve(scene.system);
  std::unique_ptr<SolverMemory> memory;
  const Solution third = solve_body_space(scene.system, {}, {}, &memory);
  const std::size_t bytes = first.lambda.size() * sizeof(double);
  EXPECT_EQ(std::memcmp(first.lambda.data(), second.lambda.data(), bytes), 0);
  EXPECT_EQ(std::memcmp(first.lambda.data(), third.lambda.data(), bytes), 0);
}

TEST(BodySpace, ASpentBudgetGivesTheBestIterateWithinTheBounds) {
  const Scene scene = scenes::pyramid(12, {.noise = 1});
  for (const int limit : {1, 2, 5, 10}) {
    const Solution solution = solve(scene.system, {.max_iterations = limit});
    expect_within_bounds(scene.system, solution);
    EXPECT_LE(solution.work.factorisations, limit);
    EXPECT_EQ(solution.residual, natural_map_residual(scene.system, solution.lambda));
  }
}

TEST(BodySpace, SurvivesNonsenseWarmStartsAndHugeLoads) {
  const Scene scene = scenes::pyramid(5);
  std::mt19937 random(7);
  for (const double bad : {kNaN, kInfinity, -kInfinity, 1e300, -1e9}) {
    std::vector<double> warm(scene.system.rows.size(), 1.0);
    for (double& z : warm)
      if (random() % 2) z = bad;
    const Solution solution = solve_body_space(scene.system, warm, {}, nullptr);
    expect_exact(scene.system, solution);
  }
  for (const double size : {1e-300, 1e-150, 1e150, 1e300}) {
    IslandSystem system = scene.system;
    for (double& b : system.b) b *= size;
    expect_within_bounds(system, solve(system));
  }
}

// They ended in what was left of an earlier, larger island, which wrote past the end of memory.
TEST(BodySpace, LoadsTooSmallToHaveDigitsAreNoLoads) {
  for (const double size : {1e-323, 4.7e-321, 1e-300, 1e-285}) {
    for (const int boxes : {1, 2, 5}) {
      expect_exact(scenes::pyramid(5).system, solve(scenes::pyramid(5).system));
      IslandSystem system = scenes::stack(boxes).system;
      for (double& b : system.b) b = b < 0 ? -size : size;
      expect_exact(system, solve(system));
    }
  }
}

TEST(BodySpace, TraceTellsTheRungsAndTheStates) {
  const Scene scene = scenes::pyramid(6, {.noise = 0.2});
  const Solution solution = solve(scene.system, {.trace = true});
  ASSERT_TRUE(solution.trace);
  EXPECT_FALSE(solution.trace->notes.empty());
  EXPECT_EQ(solution.trace->ordering.size(), scene.system.bodies.size());
  ASSERT_FALSE(solution.trace->iterations.empty());
  const SolveIteration& last = solution.trace->iterations.back();
  EXPECT_EQ(last.open + last.stick + last.slip, static_cast<int>(scene.system.rows.size()) / 2);
  EXPECT_FALSE(solve(scene.system).trace);
}

}  // namespace body_space_test
}  // namespace skerry
