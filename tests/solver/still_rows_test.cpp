// SPDX-License-Identifier: MIT
#include "physics/solver/still_rows.h"

#include <cmath>
#include <gtest/gtest.h>

#include "physics/solver/auto.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace still_rows_test {

/// A box that cannot turn, on two points of the ground, with resistance to rolling and a motor.
IslandSystem box_that_cannot_turn(double motor_wants, double strength, double rolling_wants) {
  IslandSystem system = scenes::stack(1, {.friction = 0.5, .rolling = 0.1}).system;
  system.bodies[0].angular = 0;
  Row motor;
  motor.kind = RowKind::Motor;
  motor.b = 0;
  motor.Jb = {0, 0, 1};
  motor.lower = -strength;
  motor.upper = strength;
  system.rows.insert(system.rows.begin(), motor);
  for (std::size_t i = 1; i < system.rows.size(); ++i)
    if (system.rows[i].normal >= 0) ++system.rows[i].normal;
  system.b.insert(system.b.begin(), motor_wants);
  for (std::size_t i = 0; i < system.rows.size(); ++i)
    if (system.rows[i].kind == RowKind::Rolling) system.b[i] = rolling_wants;
  return system;
}

TEST(StillRows, WhatNothingCanFollowIsAtTheBoundThatItAsksFor) {
  for (const double motor : {-2.0, 0.0, 2.0}) {
    for (const double rolling : {-0.5, 0.0, 0.5}) {
      const IslandSystem system = box_that_cannot_turn(motor, 5, rolling);
      const Solution solution = solve_auto(system, {}, {.trace = true}, nullptr);
      EXPECT_EQ(solution.status, SolveStatus::Solved) << solution.residual;
      EXPECT_LE(natural_map_residual(system, solution.lambda), 1e-12);
      EXPECT_EQ(solution.lambda[0], motor > 0 ? 5 : motor < 0 ? -5 : 0);
      double weight = 0;
      for (std::size_t i = 0; i < system.rows.size(); ++i) {
        if (system.rows[i].kind == RowKind::Normal) weight += solution.lambda[i];
        if (system.rows[i].kind != RowKind::Rolling) continue;
        const double bound = 0.1 * solution.lambda[static_cast<std::size_t>(system.rows[i].normal)];
        EXPECT_EQ(solution.lambda[i], rolling > 0 ? bound : rolling < 0 ? -bound : 0);
      }
      EXPECT_NEAR(weight * system.bodies[0].linear, 10.0 / 60, 1e-12);
      EXPECT_GE(solution.trace->notes.size(), 1u);
    }
  }
}

TEST(StillRows, WithoutABoundThereIsNoAnswer) {
  const IslandSystem system = box_that_cannot_turn(2, kInfinity, 0);
  const Solution solution = solve_auto(system, {}, {}, nullptr);
  EXPECT_NE(solution.status, SolveStatus::Solved);
  EXPECT_NEAR(solution.residual, 1, 1e-9) << "of the motor, which wants most";
  EXPECT_EQ(solution.lambda[0], 0);
}

TEST(StillRows, AContactThatNothingOpensDoesNotRub) {
  IslandSystem system = scenes::stack(1, {.friction = 0.5, .points_per_edge = 1}).system;
  system.bodies[0] = {0, 1};
  system.rows[0].Jb[2] = 0;
  system.rows[1].Jb[2] = 1;
  system.b = {-0.1, 0.3};
  const Solution solution = solve_auto(system, {}, {}, nullptr);
  EXPECT_EQ(solution.status, SolveStatus::Solved);
  EXPECT_EQ(solution.lambda, (std::vector<double>{0, 0}));
}

}  // namespace still_rows_test
}  // namespace skerry
