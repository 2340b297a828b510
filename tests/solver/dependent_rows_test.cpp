// SPDX-License-Identifier: MIT
#include "physics/solver/dependent_rows.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "physics/solver/auto.h"
#include "tests/solver/enumeration.h"
#include "tests/support/island_scenes.h"
#include "tests/support/scale.h"

namespace skerry {
namespace dependent_rows_test {

using scenes::Scene;
using scenes::SceneBuilder;

/// Pins of one body to the ground, in a row `spread` long: of four rows or more three depend on none.
Scene row_of_pins(int pins, double spread) {
  SceneBuilder builder({});
  builder.body({0, 0}, 2, 0.3);
  for (int k = 0; k < pins; ++k) builder.pin(-1, 0, {0.5 + spread * k, 0.2});
  return builder.finish();
}

TEST(DependentRows, NearlyDependentRowsHaveAnAnswer) {
  // Pins a thousandth of a millimetre apart, and velocities that both allow.
  for (const double spread : {1e-2, 1e-4, 1e-6}) {
    Scene scene = row_of_pins(3, spread);
    Solution solution;
    EXPECT_EQ(solve_dependent_rows(scene.system, {}, {}, solution), DependentRows::Solved) << spread;
    EXPECT_LE(natural_map_residual(scene.system, solution.lambda), 1e-9) << spread;
  }
}

TEST(DependentRows, DependentOnesGetTheSmallestImpulses) {
  Scene scene = row_of_pins(4, 0);
  Solution solution;
  ASSERT_EQ(solve_dependent_rows(scene.system, {}, {}, solution), DependentRows::Solved);
  for (std::size_t i = 2; i < 8; ++i) EXPECT_NEAR(solution.lambda[i], solution.lambda[i - 2], 1e-12);
}

TEST(DependentRows, ContradictionsAreToldFromAnswers) {
  // Two pins at one place that are to move apart.
  Scene scene = row_of_pins(2, 0);
  scene.system.b = {0.3, 0.1, -0.3, 0.1};
  Solution solution;
  EXPECT_EQ(solve_dependent_rows(scene.system, {}, {}, solution), DependentRows::Contradictory);
  EXPECT_NEAR(solution.residual, 1, 1e-9);
  EXPECT_LT(largest_magnitude(solution.lambda), 1);
  // The least errors: what both want of the other direction is fulfilled.
  const std::vector<double> w = row_velocities(scene.system, solution.lambda);
  EXPECT_NEAR(w[1], 0, 1e-12);
  EXPECT_NEAR(w[3], 0, 1e-12);
}

TEST(DependentRows, ABodyBetweenTwoWallsThatBothPushHasNoAnswer) {
  SceneBuilder builder({.friction = 0});
  builder.body({0, 0}, 1, 0.1);
  builder.pin(-1, 0, {0, 1});
  builder.contact(-1, 0, {-0.5, 0}, {1, 0});
  builder.contact(-1, 0, {0.5, 0}, {-1, 0});
  Scene scene = builder.finish();
  scene.system.b = {0, 0, 0.2, 0.1};
  Solution solution;
  EXPECT_EQ(solve_dependent_rows(scene.system, {}, {}, solution), DependentRows::Contradictory);
  for (const double z : solution.lambda) EXPECT_TRUE(std::isfinite(z));
  // With room on one side it has.
  scene.system.b = {0, 0, 0.2, -0.3};
  solution = {};
  EXPECT_EQ(solve_dependent_rows(scene.system, {}, {}, solution), DependentRows::Solved);
  EXPECT_EQ(solution.lambda[3], 0);
}

TEST(DependentRows, AgreesWithEnumerationOnRandomIslands) {
  const auto trials = static_cast<unsigned>(test_scale(2000));
  int solved = 0, all = 0;
  for (unsigned seed = 1; seed <= trials; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto uniform = [&](double low, double high) {
      return low + (high - low) * (random() / 4294967296.0);
    };
    scenes::SceneOptions options{.friction = seed % 2 == 0 ? 0.0 : 0.4, .noise = 1, .seed = seed};
    options.duplicated = seed % 3 == 0;
    SceneBuilder builder(options);
    const int bodies = 1 + static_cast<int>(random() % 3);
    for (int k = 0; k < bodies; ++k)
      builder.body({uniform(-1, 1), uniform(-1, 1)}, uniform(0.5, 2), uniform(0.05, 0.2));
    // Joints are rows without bounds: two at one place depend on each other.
    for (int k = 0; k + 1 < bodies; ++k) builder.pin(k, k + 1, {uniform(-1, 1), uniform(-1, 1)});
    if (random() % 2 == 0 && bodies > 1) {
      const Vec2 twice{uniform(-1, 1), uniform(-1, 1)};
      builder.pin(0, bodies - 1, twice);
      builder.pin(0, bodies - 1, twice + Vec2{1e-5, 0});
    }
    const int contacts = 1 + static_cast<int>(random() % (options.duplicated ? 2 : 3));
    for (int k = 0; k < contacts; ++k) {
      const double angle = uniform(-1, 1);
      builder.contact(-1, static_cast<int>(random() % static_cast<unsigned>(bodies)),
                      {uniform(-1, 1), uniform(-1, 1)}, {std::sin(angle), std::cos(angle)});
    }
    const Scene scene = builder.finish();
    Solution solution;
    const DependentRows found = solve_dependent_rows(scene.system, {}, {}, solution);
    ++all;
    // Velocities that there are have an answer: whatever the joints want is zero.
    EXPECT_NE(found, DependentRows::Contradictory);
    if (found != DependentRows::Solved) continue;
    ++solved;
    EXPECT_LE(natural_map_residual(scene.system, solution.lambda), 1e-7);
    if (options.friction > 0) continue;
    const Enumeration enumeration(scene.system);
    if (enumeration.solutions().empty()) continue;
    EXPECT_LT(enumeration.distance(solution.lambda), 1e-6);
  }
  EXPECT_GE(solved, 0.95 * all);
}

TEST(DependentRows, NumbersThatAreNoneAreNoAnswer) {
  Scene scene = row_of_pins(2, 0.1);
  scene.system.b[1] = std::nan("");
  Solution solution;
  EXPECT_EQ(solve_dependent_rows(scene.system, {}, {}, solution), DependentRows::Unknown);
  scene = row_of_pins(2, 0.1);
  scene.system.bodies[0] = {0, 0};
  solution = {};
  EXPECT_NE(solve_dependent_rows(scene.system, {}, {}, solution), DependentRows::Solved);
  for (const double z : solution.lambda) EXPECT_EQ(z, 0);
}

TEST(DependentRows, FrictionOfAContactThatMovesNothingIsNone) {
  // A wheel that only turns, on a contact under its axle, which carries nothing and so does not rub; what
  // lifts one of its two edges beside it has its answer all the same.
  SceneBuilder builder({.friction = 0.5});
  builder.body({0, 0}, 1, 0.1);
  builder.body({3, 0}, 1, 0.1);
  builder.pin(-1, 1, {3, 0});
  builder.contact(-1, 0, {0, -1}, {0, 1});
  builder.body({6, 0}, 1, 0.1);
  builder.contact(-1, 2, {5.6, -0.4}, {0, 1});
  builder.contact(-1, 2, {6.4, -0.4}, {0, 1});
  Scene scene = builder.finish();
  scene.system.bodies[0].linear = 0;
  scene.system.b = {0.2, -0.1, 0, 0.3, 0.5, 0, -0.4, 0};
  Solution solution;
  EXPECT_EQ(solve_dependent_rows(scene.system, {}, {}, solution), DependentRows::Solved);
  EXPECT_EQ(solution.lambda[2], 0);
  EXPECT_EQ(solution.lambda[3], 0);
  EXPECT_GT(solution.lambda[4], 0);
  EXPECT_EQ(solution.lambda[6], 0);
  EXPECT_LE(natural_map_residual(scene.system, solution.lambda), 1e-12);
}

TEST(DependentRows, TheLadderStopsThere) {
  // What is jammed by joints costs a bounded number of visits, whatever the ladder may.
  Scene scene = row_of_pins(2, 0);
  scene.system.b = {0.3, 0.1, -0.3, 0.1};
  const Solution solution = solve_auto(scene.system, {}, {.work_limit = 1e8}, nullptr);
  EXPECT_EQ(solution.status, SolveStatus::Inexact);
  EXPECT_LT(solution.work.visits, 3300 * scene.system.size());
}

}  // namespace dependent_rows_test
}  // namespace skerry
