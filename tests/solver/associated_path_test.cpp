// SPDX-License-Identifier: MIT
//
// The convex problem of associated sliding: solved by its own conditions, and Coulomb's where nothing slides.
#include "physics/solver/associated_path.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>

#include "physics/solver/cone_interior_point.h"
#include "tests/support/island_scenes.h"
#include "tests/support/scale.h"
#include "tests/support/solve_budget.h"

namespace skerry {
namespace associated_path_test {

using test::factors;

struct Found {
  bool solved = false;
  std::vector<double> lambda;
  SolveWork work;
};

Found follow(const IslandSystem& system) {
  Found found;
  BodySpaceModel model;
  ActiveSet active(model);
  active.reset(model.assign(system, found.work));
  const std::vector<double> zero(system.rows.size(), 0.0);
  found.solved =
      follow_associated_path(system, zero, 1e-10, model, active, factors(1000), found.work, nullptr);
  found.lambda = active.best();
  return found;
}

TEST(AssociatedPath, EndsWhereNothingComesNearerThanItSlidesApart) {
  // Two or three in a hundred came to a boundary far from the path when products could vanish, seed 63 for
  // one.
  int points = 0, lost = 0;
  const int islands = test_scale(80);
  for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(islands); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const IslandSystem system =
        scenes::random_island({.bodies = 12, .contacts = 20}, {.friction = 0.4, .noise = 1, .seed = seed})
            .system;
    ConeInteriorPoint path;
    SolveWork work;
    ASSERT_TRUE(path.assign(system, work));
    const double scale = largest_magnitude(system.b);
    path.start(std::vector<double>(system.rows.size(), 0.0), 0.3 * scale,
               ConeInteriorPoint::Sliding::Associated);
    for (int k = 0; k < 40 && path.centre() > 1e-7 * scale; ++k) path.step(work);
    if (path.centre() > 1e-7 * scale) {
      ++lost;
      continue;
    }
    std::vector<double> lambda;
    path.get(lambda);
    const std::vector<double> w = row_velocities(system, lambda);
    for (std::size_t i = 0; i < lambda.size(); ++i) {
      const Row& row = system.rows[i];
      if (row.kind != RowKind::Friction) continue;
      const auto n = static_cast<std::size_t>(row.normal);
      EXPECT_LE(std::abs(lambda[i]), row.mu * lambda[n] * (1 + 1e-9) + 1e-15);
      EXPECT_GE(w[n], row.mu * std::abs(w[i]) - 1e-5 * scale);
      // Forces do no work on what comes apart as it slides.
      EXPECT_NEAR(lambda[n] * w[n] + lambda[i] * w[i], 0, 1e-5 * scale * std::max(1.0, lambda[n]));
      ++points;
    }
  }
  EXPECT_GT(points, test_scale(1000));
  EXPECT_LE(lost, islands / 500);
}

TEST(AssociatedPath, FindsForcesThatHoldWhatCanRest) {
  const scenes::SceneOptions rest{.friction = 0.5};
  for (const auto& system : {scenes::pyramid(12, rest).system, scenes::wall(12, 12, false, rest).system,
                             scenes::wall(12, 12, true, rest).system, scenes::stack(30, rest).system}) {
    const Found found = follow(system);
    EXPECT_TRUE(found.solved);
    EXPECT_LE(natural_map_residual(system, found.lambda), 1e-10);
    EXPECT_LE(found.work.factorisations, 40);
    for (const double u : row_velocities(system, found.lambda)) EXPECT_NEAR(u, 0, 1e-10);
  }
}

TEST(AssociatedPath, EndsEarlyWhereSomethingSlides) {
  int islands = 0, used = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const scenes::SceneOptions moving{.friction = 0.3, .noise = 3, .seed = seed};
    for (const auto& system : {scenes::disc_heap(12, moving).system, scenes::pyramid(12, moving).system}) {
      const Found found = follow(system);
      EXPECT_FALSE(found.solved);
      ++islands;
      used += found.work.factorisations;
    }
  }
  std::printf("%d factors for %d islands\n", used, islands);
  EXPECT_LE(used, 25 * islands);
}

TEST(AssociatedPath, FindsForcesThatHoldWhatHangsTogether) {
  // Chains of ten boxes whose ends lie on the ground, and links that say what others say already.
  for (const int pins : {1, 2}) {
    scenes::SceneBuilder builder({.friction = 0.5});
    for (int k = 0; k < 10; ++k) {
      const double height = 0.5 + std::min(k, 9 - k);
      const int body = builder.body({1.5 * k, height}, 1, 1.0 / 6);
      if (k == 0 || k == 9) builder.edge(-1, body, 1.5 * k - 0.5, 1.5 * k + 0.5, 0);
      for (int pin = 0; pin < pins && k > 0; ++pin)
        builder.pin(body - 1, body, {1.5 * k - 0.75, builder.scene().system.positions[k].y - 0.2 * pin});
    }
    const IslandSystem system = builder.finish().system;
    const Found found = follow(system);
    // An arch of single pins would fold; with two it is as stiff as a beam.
    EXPECT_EQ(found.solved, pins == 2);
    if (!found.solved) continue;
    EXPECT_LE(natural_map_residual(system, found.lambda), 1e-10);
    EXPECT_LE(found.work.factorisations, 40);
    for (const double u : row_velocities(system, found.lambda)) EXPECT_NEAR(u, 0, 1e-10);
  }
}

TEST(AssociatedPath, LeavesRollingResistanceToOthers) {
  const Found found = follow(scenes::stack(3, {.friction = 0.5, .rolling = 0.1}).system);
  EXPECT_FALSE(found.solved);
  EXPECT_EQ(found.work.factorisations, 0);
}

}  // namespace associated_path_test
}  // namespace skerry
