// SPDX-License-Identifier: MIT
#include "physics/solver/convex_step.h"

#include <cmath>
#include <gtest/gtest.h>

#include "physics/solver/body_space.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace convex_step_test {

using scenes::Scene;

double kinetic_energy(const IslandSystem& system, const std::vector<std::array<double, 3>>& v) {
  double energy = 0;
  for (std::size_t i = 0; i < v.size(); ++i)
    energy += 0.5 * ((v[i][0] * v[i][0] + v[i][1] * v[i][1]) / system.bodies[i].linear +
                     v[i][2] * v[i][2] / system.bodies[i].angular);
  return energy;
}

TEST(ConvexStep, IsExactWhereTheBoundsAreRight) {
  // The warm start is the solution itself: its normal impulses give the right bounds.
  for (const double noise : {0.0, 0.1}) {
    const Scene scene = scenes::stack(20, {.noise = noise});
    const Solution exact = solve_body_space(scene.system, {}, {}, nullptr);
    ASSERT_EQ(exact.status, SolveStatus::Solved);
    const Solution convex = solve_convex_step(scene.system, exact.lambda, {}, nullptr);
    EXPECT_EQ(convex.status, SolveStatus::Solved);
    EXPECT_EQ(convex.method, "convex_step");
  }
}

TEST(ConvexStep, IsSolvedToTheEndWhateverTheFriction) {
  for (std::uint64_t seed = 1; seed <= 30; ++seed)
    for (const double friction : {0.5, 1.0, 10.0}) {
      SCOPED_TRACE("seed " + std::to_string(seed) + " friction " + std::to_string(friction));
      const Scene scene = scenes::pyramid(7, {.friction = friction, .noise = 0.5, .seed = seed});
      const std::vector<double> warm(scene.system.rows.size(), 0.1);
      const Solution convex = solve_convex_step(scene.system, warm, {.trace = true}, nullptr);
      EXPECT_EQ(convex.trace->notes.back(), "convex problem solved");
      EXPECT_EQ(convex.residual, natural_map_residual(scene.system, convex.lambda));
    }
}

TEST(ConvexStep, GainsNoEnergy) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const double noise = seed % 3 == 0 ? 0.05 : 1;
    const Scene scene = scenes::wall(4, 4, true, {.friction = 0.8, .noise = noise, .seed = seed});
    const double before = kinetic_energy(scene.system, scene.free_velocity);
    std::vector<double> warm;
    for (int k = 0; k < 3; ++k) {
      const Solution convex = solve_convex_step(scene.system, warm, {}, nullptr);
      std::vector<std::array<double, 3>> v = scene.free_velocity;
      apply_impulses(scene.system, convex.lambda, v);
      EXPECT_LE(kinetic_energy(scene.system, v), before * (1 + 1e-9));
      warm = convex.lambda;
    }
  }
}

TEST(ConvexStep, WithoutFrictionItIsTheExactAnswer) {
  const Scene scene = scenes::pyramid(10, {.friction = 0, .noise = 0.3});
  EXPECT_EQ(solve_convex_step(scene.system, {}, {}, nullptr).status, SolveStatus::Solved);
}

TEST(ConvexStep, RepeatedWithItsOwnBoundsComesCloserToCoulombsLaw) {
  const Scene scene = scenes::pyramid(8, {.friction = 0.3, .noise = 0.3, .seed = 3});
  std::unique_ptr<SolverMemory> memory;
  Solution convex = solve_convex_step(scene.system, {}, {}, &memory);
  const double first = convex.residual;
  for (int k = 0; k < 10; ++k) convex = solve_convex_step(scene.system, convex.lambda, {}, &memory);
  EXPECT_LT(convex.residual, 0.1 * first);
}

}  // namespace convex_step_test
}  // namespace skerry
