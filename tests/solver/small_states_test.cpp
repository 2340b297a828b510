// SPDX-License-Identifier: MIT
#include "physics/solver/small_states.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "physics/solver/body_space.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace small_states_test {

using scenes::Scene;

Scene random_scene(std::uint64_t seed, double friction) {
  const int bodies = 1 + static_cast<int>(seed % 16), contacts = 1 + static_cast<int>(seed % 24);
  return scenes::random_island({.bodies = bodies, .contacts = contacts, .pins = static_cast<int>(seed % 3)},
                               {.friction = friction, .noise = 0.5, .seed = seed});
}

/// Largest difference of the velocities that two lists of impulses give the bodies [m/s, rad/s].
double apart(const IslandSystem& system, const std::vector<double>& x, const std::vector<double>& y) {
  std::vector<std::array<double, 3>> u(system.bodies.size()), v(system.bodies.size());
  apply_impulses(system, x, u);
  apply_impulses(system, y, v);
  double worst = 0;
  for (std::size_t k = 0; k < u.size(); ++k)
    for (std::size_t c = 0; c < 3; ++c) worst = std::max(worst, std::abs(u[k][c] - v[k][c]));
  return worst;
}

TEST(SmallStates, AnswersNearlyEveryRandomIslandWithinTheTolerance) {
  int fitting = 0, solved = 0;
  for (std::uint64_t seed = 1; seed <= 1000; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scene scene = random_scene(seed, 0.4);
    if (scene.system.rows.empty() || scene.system.rows.size() > kStateRows) continue;
    ++fitting;
    Solution solution;
    if (!try_small_states(scene.system, {}, {}, solution)) continue;
    ++solved;
    EXPECT_EQ(solution.status, SolveStatus::Solved);
    const double residual = natural_map_residual(scene.system, solution.lambda);
    EXPECT_LE(residual, 1e-10);
    EXPECT_NEAR(residual, solution.residual, 1e-13);
  }
  EXPECT_GT(fitting, 700);
  EXPECT_GT(solved, 0.9 * fitting) << "of " << fitting;
}

TEST(SmallStates, WithoutFrictionBodiesMoveAsBodySpaceHasThem) {
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scene scene = random_scene(seed, 0);
    if (scene.system.rows.empty() || scene.system.rows.size() > kStateRows) continue;
    Solution solution;
    if (!try_small_states(scene.system, {}, {}, solution)) continue;
    const Solution other = solve_body_space(scene.system, {}, {}, nullptr);
    if (other.status != SolveStatus::Solved) continue;
    EXPECT_LE(apart(scene.system, solution.lambda, other.lambda),
              1e-7 * (1 + largest_magnitude(scene.system.b)));
  }
}

TEST(SmallStates, FollowsAWarmStart) {
  int tried = 0, found = 0, far = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Scene scene = random_scene(seed, 0.4);
    Solution first;
    if (scene.system.rows.size() > kStateRows || !try_small_states(scene.system, {}, {}, first)) continue;
    // Other velocities of the bodies before.
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> change(-0.01, 0.01);
    std::vector<std::array<double, 3>> v(scene.system.bodies.size());
    for (auto& body : v) body = {change(random), change(random), change(random)};
    for (std::size_t i = 0; i < scene.system.rows.size(); ++i) {
      const Row& row = scene.system.rows[i];
      if (row.a >= 0) scene.system.b[i] -= along(row.Ja, v[static_cast<std::size_t>(row.a)]);
      if (row.b >= 0) scene.system.b[i] -= along(row.Jb, v[static_cast<std::size_t>(row.b)]);
    }
    ++tried;
    Solution next;
    if (!try_small_states(scene.system, first.lambda, {}, next)) continue;
    ++found;
    EXPECT_LE(natural_map_residual(scene.system, next.lambda), 1e-10);
    far += next.work.factorisations > 3;
  }
  EXPECT_GT(found, 0.97 * tried) << "of " << tried;
  EXPECT_LT(far, 0.1 * tried) << "of " << tried;
}

TEST(SmallStates, LeavesWhatDoesNotFitToOthers) {
  Solution solution;
  EXPECT_FALSE(try_small_states(IslandSystem{}, {}, {}, solution));
  EXPECT_FALSE(try_small_states(scenes::stack(kStateBodies + 1).system, {}, {}, solution));
  Scene soft = scenes::stack(2);
  soft.system.compliance.assign(soft.system.rows.size(), 0.1);
  EXPECT_FALSE(try_small_states(soft.system, {}, {}, solution));
  // A row that nothing can follow.
  Scene fixed = scenes::stack(1);
  fixed.system.bodies[0] = {0, 0};
  EXPECT_FALSE(try_small_states(fixed.system, {}, {}, solution));
  EXPECT_TRUE(solution.lambda.empty());
  // Bodies that do not turn are no trouble.
  Scene upright = scenes::stack(3);
  for (InverseMass& body : upright.system.bodies) body.angular = 0;
  EXPECT_TRUE(try_small_states(upright.system, {}, {}, solution));
  EXPECT_LE(natural_map_residual(upright.system, solution.lambda), 1e-12);
}

}  // namespace small_states_test
}  // namespace skerry
