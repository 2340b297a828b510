// SPDX-License-Identifier: MIT
#include "physics/solver/small_exact.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <stdexcept>

#include "tests/support/island_scenes.h"

namespace skerry {
namespace small_exact_test {

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

// A box of `width` on a slope that pulls it down by `slide` of what presses it on, its corners the other way
// round if `swapped`.
IslandSystem box_on_slope(double width, double angle, double slide, double turn, bool swapped) {
  IslandSystem system;
  system.bodies = {{0.3, 1.7}};
  const double c = std::cos(angle), s = std::sin(angle);
  const std::array<double, 3> v{-slide * c + s, -slide * s - c, turn};  // free velocity
  for (const double side : {-0.5, 0.5}) {
    const Vec2 r{side * width * c + 0.5 * s, side * width * s - 0.5 * c};
    const Vec2 axes[] = {{-s, c}, {-c, -s}};
    for (const Vec2 axis : axes) {
      Row row;
      row.a = swapped ? 0 : -1;
      row.b = swapped ? -1 : 0;
      (swapped ? row.Ja : row.Jb) = {axis.x, axis.y, r.x * axis.y - r.y * axis.x};
      if (system.rows.size() % 2 == 1) {
        row.kind = RowKind::Friction;
        row.normal = system.size() - 1;
        row.mu = 0.5;
      }
      system.b.push_back(-along(swapped ? row.Ja : row.Jb, v));
      system.rows.push_back(row);
    }
  }
  return system;
}

TEST(SmallExact, SticksABoxOnAnySlopeByFormulaWithTheForcesOfStatics) {
  for (const double angle : {0.0, 0.3, 1.1, 2.0, -2.9})
    for (const double width : {1.0, 0.25, 7.0, 1e-3})
      for (const bool swapped : {false, true}) {
        SCOPED_TRACE("angle " + std::to_string(angle) + ", width " + std::to_string(width));
        const IslandSystem system = box_on_slope(width, angle, 0.05 * std::min(width, 1.0), 0, swapped);
        const Solution solution = solve_small_exact(system, {}, {}, nullptr);
        ASSERT_EQ(solution.status, SolveStatus::Solved);
        EXPECT_EQ(solution.method, "small_exact");
        EXPECT_EQ(solution.work.factorisations, 0) << "not by formula";
        EXPECT_LE(natural_map_residual(system, solution.lambda), 1.1e-13);
        EXPECT_NEAR(solution.residual, natural_map_residual(system, solution.lambda), 1e-13);
        const double mass = 1 / 0.3;
        EXPECT_NEAR(solution.lambda[0] + solution.lambda[2], mass, 1e-12 * mass);
        EXPECT_NEAR(solution.lambda[1], solution.lambda[3], 1e-12 * mass);
        EXPECT_NEAR(std::abs(solution.lambda[1] + solution.lambda[3]), 0.05 * std::min(width, 1.0) * mass,
                    1e-11);
      }
  // What slips or tilts, and points that are one: answers all the same, by other ways.
  for (const auto& [width, slide, turn] :
       {std::array{1.0, 0.8, 0.0}, {1.0, 0.0, 4.0}, {1.0, 0.0, -9.0}, {1e-9, 0.0, 0.0}, {0.0, 0.0, 0.0}}) {
    SCOPED_TRACE("width " + std::to_string(width) + ", slide " + std::to_string(slide));
    const IslandSystem system = box_on_slope(width, 0.2, slide, turn, false);
    const Solution solution = solve_small_exact(system, {}, {}, nullptr);
    ASSERT_EQ(solution.status, SolveStatus::Solved);
    EXPECT_LE(natural_map_residual(system, solution.lambda), 1.1e-10);
  }
}

// Bodies that each stand on an edge of an earlier one or, the first, of the ground: edges of any width, place
// and direction, rows of the pairs in any order, pairs named in either order.
IslandSystem random_tower(int bodies, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto real = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  IslandSystem system;
  std::vector<std::array<int, 2>> pairs;
  std::vector<Vec2> centre;
  for (int j = 0; j < bodies; ++j) {
    system.bodies.push_back({real(0.2, 5), real(0.5, 20)});
    centre.push_back({real(-1, 1), j + real(0, 1)});
    pairs.push_back({j == 0 ? -1 : std::uniform_int_distribution<int>(0, j - 1)(random), j});
  }
  std::shuffle(pairs.begin(), pairs.end(), random);
  for (const auto& [below, above] : pairs) {
    const double angle = real(-0.2, 0.2);
    const Vec2 n{-std::sin(angle), std::cos(angle)}, t = perp(n) * (random() % 2 ? 1.0 : -1.0);
    const Vec2 middle = centre[static_cast<std::size_t>(above)] - n * 0.5;
    const double half = real(0.2, 0.8);
    const bool swapped = random() % 2;
    for (const double side : {-half, half})
      for (const Vec2 axis : {n, t}) {
        const Vec2 point = middle + perp(n) * side;
        const auto block = [&](int body, double sign) -> std::array<double, 3> {
          if (body < 0) return {};
          const Vec2 r = point - centre[static_cast<std::size_t>(body)];
          return {sign * axis.x, sign * axis.y, sign * cross(r, axis)};
        };
        Row row;
        row.a = swapped ? above : below;
        row.b = swapped ? below : above;
        row.Ja = swapped ? block(above, 1) : block(below, -1);
        row.Jb = swapped ? block(below, -1) : block(above, 1);
        if (axis.x == t.x && axis.y == t.y) {
          row.kind = RowKind::Friction;
          row.normal = system.size() - 1;
          row.mu = 1;
        }
        system.rows.push_back(row);
      }
  }
  // All fall, and turn a little.
  const double turn = real(-0.02, 0.02);
  for (const Row& row : system.rows) {
    double u = 0;
    for (const auto& [body, J] : {std::pair{row.a, row.Ja}, std::pair{row.b, row.Jb}})
      if (body >= 0) u += along(J, {0.05 * turn, -1 - 0.01 * body, turn * (1 + body)});
    system.b.push_back(-u);
  }
  return system;
}

TEST(SmallExact, SticksTowersByFormula) {
  int by_formula = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const IslandSystem system = random_tower(1 + static_cast<int>(seed % kSmallBodies), seed);
    validate(system);
    const Solution solution = solve_small_exact(system, {}, {}, nullptr);
    ASSERT_EQ(solution.status, SolveStatus::Solved);
    const double residual = natural_map_residual(system, solution.lambda);
    EXPECT_LE(residual, std::max(1.1e-10, 16 * residual_floor(system, solution.lambda)));
    if (solution.method == "small_exact" && solution.work.factorisations == 0) {
      ++by_formula;
      EXPECT_LE(residual, 2e-12);
      EXPECT_NEAR(solution.residual, residual, 1e-12);
    }
    // Eight towers of one shape, other velocities.
    std::vector<IslandSystem> eight(SmallBatch::kLanes, system);
    std::vector<const IslandSystem*> systems;
    for (std::size_t k = 0; k < eight.size(); ++k) {
      for (double& b : eight[k].b) b *= 1 + 0.1 * static_cast<double>(k);
      if (k % 3 == 2) eight[k].b[0] += 5;  // tips over
      systems.push_back(&eight[k]);
    }
    const std::vector<Solution> batch = solve_batch(systems, {});
    for (std::size_t k = 0; k < eight.size(); ++k) {
      const Solution single = solve_small_exact(eight[k], {}, {}, nullptr);
      EXPECT_EQ(batch[k].method, single.method);
      EXPECT_EQ(batch[k].lambda, single.lambda);
      EXPECT_EQ(batch[k].residual, single.residual);
      EXPECT_EQ(batch[k].work.factorisations, single.work.factorisations);
    }
  }
  EXPECT_GT(by_formula, 100);
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

}  // namespace small_exact_test
}  // namespace skerry
