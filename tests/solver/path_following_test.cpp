// SPDX-License-Identifier: MIT
//
// Path following: arrives where Newton methods cycle, solves what it says it solves, ends when it cannot.
#include "physics/solver/path_following.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <string>

#include "physics/solver/body_space.h"
#include "tests/support/island_scenes.h"
#include "tests/support/scale.h"

namespace skerry {
namespace path_following_test {

/// What a path says it has solved: the natural map of w + eta D (lambda - centre), relative.
double regularised_residual(const IslandSystem& system, const std::vector<double>& lambda,
                            const std::vector<double>& centre, double eta) {
  const std::vector<double> D = inverse_effective_masses(system);
  std::vector<double> w = row_velocities(system, lambda);
  double worst = 0;
  for (std::size_t i = 0; i < w.size(); ++i) {
    const Row& row = system.rows[i];
    w[i] += eta * D[i] * (lambda[i] - centre[i]);
    const double normal = row.normal < 0 ? 0 : lambda[static_cast<std::size_t>(row.normal)];
    worst = std::max(worst, natural_map_violation(impulse_bounds(row, normal), D[i], lambda[i], w[i]));
  }
  return worst / largest_magnitude(system.b);
}

TEST(PathFollowing, SolvesRegularisedProblemsFromNothing) {
  int reached = 0, total = 0;
  const unsigned count = static_cast<unsigned>(test_scale(200));
  for (unsigned seed = 1; seed <= count; ++seed) {
    scenes::SceneOptions options{.friction = seed % 3 ? 0.5 : 1, .noise = 1, .seed = seed};
    if (seed % 4 == 0) options.rolling = 0.05;
    options.duplicated = seed % 5 == 0;
    const IslandSystem system =
        seed % 2 ? scenes::pyramid(2 + static_cast<int>(seed % 5), options).system
                 : scenes::random_island({.bodies = 6, .contacts = 12, .pins = static_cast<int>(seed % 3)},
                                         options)
                       .system;
    BodySpaceModel model;
    SolveWork work;
    model.assign(system, work);
    PathFollower path(model);
    const std::vector<double> zero(system.rows.size(), 0.0);
    SolveBudget budget;
    budget.factorisations = 5000;
    ++total;
    if (path.run(zero, 1e-2, zero, 0.1, true, 4000, budget, work) != PathFollower::End::Reached) continue;
    ++reached;
    EXPECT_LE(regularised_residual(system, path.impulses(), zero, 1e-2), 1e-11) << "seed " << seed;
  }
  // Random contacts with friction 1 need not have a path to their solution.
  EXPECT_GE(reached, total * 95 / 100);
}

TEST(PathFollowing, GoesOnFromTheImpulsesOfTheStepBefore) {
  int solved = 0, total = 0, factors = 0;
  const unsigned count = static_cast<unsigned>(test_scale(100));
  for (unsigned seed = 1; seed <= count; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const scenes::SceneOptions options{.friction = 0.5, .noise = 0.01, .seed = seed};
    IslandSystem system = seed % 2 ? scenes::pyramid(4 + static_cast<int>(seed % 7), options).system
                                   : scenes::wall(5, 6, true, options).system;
    const Solution before = solve_body_space(system, {}, {}, nullptr);
    ASSERT_EQ(before.status, SolveStatus::Solved);
    // A tenth of the bodies are pushed.
    for (std::size_t i = 0; i < system.rows.size(); ++i) {
      const Row& row = system.rows[i];
      if (row.a >= 0 && row.a % 10 == 0) system.b[i] -= 0.05 * row.Ja[0];
      if (row.b >= 0 && row.b % 10 == 0) system.b[i] -= 0.05 * row.Jb[0];
    }
    BodySpaceModel model;
    SolveWork work;
    model.assign(system, work);
    ActiveSet active(model);
    active.reset(kInfinity);
    SolveBudget budget;
    budget.factorisations = 1000;
    ++total;
    if (!follow_path_from(before.lambda, 1e-10, 60, model, active, budget, work, nullptr)) continue;
    ++solved;
    factors += work.factorisations;
    EXPECT_LE(natural_map_residual(system, active.best()), 1e-10);
  }
  std::printf("%d of %d, %d factors each\n", solved, total, factors / std::max(1, solved));
  EXPECT_GE(solved, total * 8 / 10);
}

TEST(PathFollowing, IsTheSameEachTime) {
  const IslandSystem system = scenes::disc_heap(8, {.friction = 0.5, .noise = 0.5}).system;
  std::vector<double> first;
  for (int k = 0; k < 2; ++k) {
    BodySpaceModel model;
    SolveWork work;
    model.assign(system, work);
    PathFollower path(model);
    const std::vector<double> zero(system.rows.size(), 0.0);
    SolveBudget budget;
    budget.factorisations = 5000;
    EXPECT_EQ(path.run(zero, 1e-2, zero, 0.1, true, 4000, budget, work), PathFollower::End::Reached);
    if (k == 0) first = path.impulses();
    EXPECT_EQ(path.impulses(), first);
  }
}

TEST(PathFollowing, StopsAtItsBudget) {
  const IslandSystem system = scenes::pyramid(10, {.friction = 0.5, .noise = 1}).system;
  BodySpaceModel model;
  SolveWork work;
  model.assign(system, work);
  PathFollower path(model);
  const std::vector<double> zero(system.rows.size(), 0.0);
  SolveBudget budget;
  budget.factorisations = 7;
  EXPECT_EQ(path.run(zero, 1e-2, zero, 0.1, true, 4000, budget, work), PathFollower::End::Limit);
  EXPECT_LE(work.factorisations, 7);
  budget.factorisations = 1000;
  budget.visits = 2 * work.visits;
  path.run(zero, 1e-2, zero, 0.1, true, 4000, budget, work);
  EXPECT_LE(work.visits, 1.5 * budget.visits);
}

// One body of a pyramid at rest is struck: nearly all wanted velocities are nothing, so that everything is
// tied.
TEST(PathFollowing, FromNothingSolvesBlows) {
  int solved = 0, pivots = 0;
  const unsigned count = static_cast<unsigned>(test_scale(40));
  for (unsigned seed = 1; seed <= count; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const scenes::SceneOptions options{.friction = seed % 3 ? 0.5 : 1, .seed = seed};
    const int base = static_cast<int>(seed % 5 == 0 ? 20 + seed % 4 : 6 + seed % 9);
    IslandSystem system = scenes::pyramid(base, options).system;
    std::fill(system.b.begin(), system.b.end(), 0.0);
    const int struck = static_cast<int>(seed * 7 % system.bodies.size());
    const double fast[3] = {std::cos(seed), -std::abs(std::sin(seed)), 0.3};
    for (std::size_t i = 0; i < system.rows.size(); ++i) {
      const Row& row = system.rows[i];
      for (std::size_t c = 0; c < 3; ++c) {
        if (row.a == struck) system.b[i] -= row.Ja[c] * fast[c];
        if (row.b == struck) system.b[i] -= row.Jb[c] * fast[c];
      }
    }
    BodySpaceModel model;
    SolveWork work;
    model.assign(system, work);
    ActiveSet active(model);
    active.reset(kInfinity);
    SolveBudget budget;
    budget.factorisations = 200000;
    if (!pivot_from_nothing(1e-8, model, active, budget, work, nullptr)) continue;
    ++solved;
    pivots += work.pivots;
    EXPECT_LE(natural_map_residual(system, active.best()), 1e-8);
  }
  std::printf("%d of %u blows solved, %d pivots\n", solved, count, pivots);
  EXPECT_EQ(solved, static_cast<int>(count));
}

}  // namespace path_following_test
}  // namespace skerry
