// SPDX-License-Identifier: MIT
#include "physics/solver/bilateral.h"

#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "physics/solver/auto.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace {

using scenes::Scene;
using scenes::SceneBuilder;
using scenes::SceneOptions;

/// Links of length 1 in a zigzag, pinned to each other, the first one to the ground.
Scene pinned_chain(int links, const SceneOptions& options) {
  SceneBuilder builder(options);
  for (int i = 0; i < links; ++i) {
    const double mass = builder.layer_mass(i, links);
    builder.body({i + 0.5, 0.1 * (i % 2)}, mass, mass / 12);
  }
  for (int i = 0; i < links; ++i) builder.pin(i - 1, i, {static_cast<double>(i), 0.05 * (i % 3)});
  return builder.finish();
}

/// W in long double, solved by elimination with row pivoting.
std::vector<long double> eliminate(const IslandSystem& system) {
  const std::size_t n = system.rows.size();
  std::vector<std::vector<long double>> A(n, std::vector<long double>(n + 1, 0));
  const auto block = [](const Row& row, int body) { return row.a == body ? row.Ja : row.Jb; };
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      for (const int body : {system.rows[i].a, system.rows[i].b}) {
        if (body < 0 || (system.rows[j].a != body && system.rows[j].b != body)) continue;
        const InverseMass m = system.bodies[static_cast<std::size_t>(body)];
        const auto x = block(system.rows[i], body), y = block(system.rows[j], body);
        A[i][j] += static_cast<long double>(m.linear) *
                       (static_cast<long double>(x[0]) * y[0] + static_cast<long double>(x[1]) * y[1]) +
                   static_cast<long double>(m.angular) * x[2] * y[2];
      }
    }
    if (!system.compliance.empty()) A[i][i] += system.compliance[i];
    A[i][n] = system.b[i];
  }
  for (std::size_t p = 0; p < n; ++p) {
    std::size_t best = p;
    for (std::size_t i = p; i < n; ++i)
      if (std::abs(A[i][p]) > std::abs(A[best][p])) best = i;
    std::swap(A[p], A[best]);
    for (std::size_t i = 0; i < n; ++i) {
      if (i == p) continue;
      const long double factor = A[i][p] / A[p][p];
      for (std::size_t j = p; j <= n; ++j) A[i][j] -= factor * A[p][j];
    }
  }
  std::vector<long double> x(n);
  for (std::size_t i = 0; i < n; ++i) x[i] = A[i][n] / A[i][i];
  return x;
}

TEST(Bilateral, AgreesWithEliminationInLongDouble) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const int links = 1 + static_cast<int>(seed % 20);
    Scene scene = pinned_chain(links, {.mass_ratio = seed % 3 == 0 ? 1e4 : 1,
                                       .pattern = scenes::MassPattern::Random,
                                       .noise = 1,
                                       .seed = seed});
    if (seed % 4 == 0)
      scene.system.compliance.assign(scene.system.rows.size(), 0.01 * static_cast<double>(seed % 5));
    const Solution solution = solve_bilateral(scene.system, {}, {.tolerance = 1e-12}, nullptr);
    ASSERT_EQ(solution.status, SolveStatus::Solved) << solution.residual;
    EXPECT_NEAR(solution.residual, natural_map_residual(scene.system, solution.lambda), 1e-13);
    EXPECT_LE(solution.work.resolves, 4) << "rows " << scene.system.rows.size();
    const std::vector<long double> exact = eliminate(scene.system);
    double largest = 0;
    for (const long double x : exact) largest = std::max(largest, std::abs(static_cast<double>(x)));
    for (std::size_t i = 0; i < exact.size(); ++i)
      EXPECT_NEAR(solution.lambda[i], static_cast<double>(exact[i]), 1e-8 * largest) << i;
  }
}

TEST(Bilateral, LongChainTakesOneFactorisationAndFewRefinements) {
  const Scene scene = pinned_chain(400, {.noise = 1});
  const Solution solution = solve_auto(scene.system, {}, {.tolerance = 1e-12}, nullptr);
  EXPECT_EQ(solution.method, "bilateral");
  EXPECT_EQ(solution.status, SolveStatus::Solved);
  EXPECT_LE(solution.residual, 1e-12);
  EXPECT_EQ(solution.work.factorisations, 1);
  EXPECT_LE(solution.work.resolves, 5);
}

TEST(Bilateral, DependentRowsShareTheirImpulse) {
  // A beam on two pins: along it, one row too many.
  SceneBuilder builder({});
  builder.body({0, 0}, 2, 1);
  builder.pin(-1, 0, {-1, 0});
  builder.pin(-1, 0, {1, 0});
  Scene scene = builder.finish();
  scene.system.b = {0.3, 0.1, 0.3, 0.1};
  const Solution solution = solve_auto(scene.system, {}, {}, nullptr);
  EXPECT_EQ(solution.method, "bilateral");
  EXPECT_EQ(solution.status, SolveStatus::Solved);
  EXPECT_NEAR(solution.lambda[0], 0.3, 1e-12);
  EXPECT_NEAR(solution.lambda[2], 0.3, 1e-12);
  EXPECT_NEAR(solution.lambda[1], solution.lambda[3], 1e-12);
}

TEST(Bilateral, RowsThatContradictEachOtherAreNotSolved) {
  SceneBuilder builder({});
  builder.body({0, 0}, 2, 1);
  builder.pin(-1, 0, {-1, 0});
  builder.pin(-1, 0, {1, 0});
  Scene scene = builder.finish();
  scene.system.b = {0.3, 0.1, -0.3, 0.1};
  for (const auto& solve : {solve_bilateral, solve_auto}) {
    const Solution solution = solve(scene.system, {}, {}, nullptr);
    EXPECT_EQ(solution.status, SolveStatus::Inexact);
    EXPECT_GE(solution.residual, 0.9);
    for (const double z : solution.lambda) EXPECT_TRUE(std::isfinite(z));
  }
}

TEST(Bilateral, LeavesBoundsAndBodiesThatDoNotMoveToOthers) {
  const Scene contacts = scenes::stack(2);
  EXPECT_FALSE(is_bilateral(contacts.system));
  const Solution refused = solve_bilateral(contacts.system, {}, {}, nullptr);
  EXPECT_EQ(refused.status, SolveStatus::Unsupported);

  // Nothing can answer a row between bodies that do not move; zero rows are answered by nothing.
  Scene fixed = pinned_chain(1, {});
  fixed.system.bodies[0] = {0, 0};
  EXPECT_NE(solve_bilateral(fixed.system, {}, {}, nullptr).status, SolveStatus::Solved);
  EXPECT_EQ(solve_bilateral(IslandSystem{}, {}, {}, nullptr).status, SolveStatus::Solved);
}

TEST(Bilateral, KeptOrderGivesTheSameBits) {
  std::unique_ptr<SolverMemory> memory;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Scene scene = pinned_chain(40, {.noise = 1, .seed = seed});
    const Solution kept = solve_auto(scene.system, {}, {}, &memory);
    const Solution fresh = solve_auto(scene.system, {}, {}, nullptr);
    ASSERT_EQ(kept.lambda.size(), fresh.lambda.size());
    EXPECT_EQ(std::memcmp(kept.lambda.data(), fresh.lambda.data(), kept.lambda.size() * sizeof(double)), 0);
    EXPECT_EQ(kept.work.symbolic_analyses, seed == 1 ? 1 : 0);
  }
}

}  // namespace
}  // namespace skerry
