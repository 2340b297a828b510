// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <random>

#include "physics/solver/solver.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace contradicting_rows_test {

// Rows of one joint that want different things, and one that nothing can follow: the residual is that of the
// impulses, not what is sure to be left.
TEST(ContradictingRows, SweepsTellTheResidualOfRowsThatContradictEachOther) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    IslandSystem system =
        scenes::random_island({.bodies = 5, .contacts = 8}, {.friction = 0.3, .noise = 1, .seed = seed})
            .system;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(-1, 1);
    for (int k = 0; k < 2; ++k) {
      Row row;
      row.kind = RowKind::Joint;
      row.a = -1;
      row.b = static_cast<int>(random() % system.bodies.size());
      row.Jb = {number(random), number(random), seed % 3 == 0 ? 0 : number(random)};
      row.lower = -kInfinity;
      for (const double share : {1.0, 2.0}) {
        system.rows.push_back(row);
        for (double& x : system.rows.back().Jb) x *= share;
        system.b.push_back(number(random));
      }
    }
    if (seed % 4 == 0) {
      Row& motor = system.rows.emplace_back(system.rows.back());
      motor.kind = RowKind::Motor;
      motor.Jb = {0, 0, 0};
      motor.lower = -1;
      motor.upper = 1;
      system.b.push_back(0.5);
    }
    for (const char* name : {"tgs_soft", "pgs", "nncg"}) {
      for (const int sweeps : {1, 4, 50}) {
        const Solution solution = find_solver(name).solve(system, {}, {.max_iterations = sweeps}, nullptr);
        const double residual = natural_map_residual(system, solution.lambda);
        EXPECT_NEAR(solution.residual, residual, 1e-9 * (1 + residual)) << name << ", " << sweeps;
      }
    }
  }
}

TEST(ContradictingRows, ByLessThanTheToleranceTheyPressForNothing) {
  // Two pins at one place that are to move apart by what rounding leaves.
  scenes::SceneBuilder builder({});
  builder.body({0, 0}, 2, 0.3);
  builder.pin(-1, 0, {0.5, 0.2});
  builder.pin(-1, 0, {0.5, 0.2});
  scenes::Scene scene = builder.finish();
  for (const double apart : {0.0, 1e-15, 1e-13, 1e-12, 1e-11}) {
    scene.system.b = {0.3, 0.1, 0.3 + apart, 0.1};
    for (const char* name : {"auto", "body_space"}) {
      const Solution solution = find_solver(name).solve(scene.system, {}, {}, nullptr);
      EXPECT_EQ(solution.status, SolveStatus::Solved) << name << ", " << apart;
      EXPECT_LT(largest_magnitude(solution.lambda), 10) << name << ", " << apart;
    }
  }
}

}  // namespace contradicting_rows_test
}  // namespace skerry
