// SPDX-License-Identifier: MIT
//
// Interior point on the friction cone: how near it brings to Coulomb's law what sweeps leave, within its
// work, and that it never leaves more than it was given.
#include "physics/solver/cone_interior_point.h"

#include <algorithm>
#include <cstdio>
#include <gtest/gtest.h>

#include "tests/support/island_scenes.h"

namespace skerry {
namespace {

constexpr int kSweeps = 40;

struct Result {
  bool tried = false;
  double before = 0, after = 0;  ///< relative residuals
  std::vector<double> lambda;
  SolveWork work;
};

Result improve(const IslandSystem& system, double limit) {
  Result result;
  BlockSweeps sweeps;
  EXPECT_TRUE(sweeps.assign(system, true));
  sweeps.set({});
  for (int k = 0; k < kSweeps; ++k) sweeps.sweep();
  sweeps.get(sweeps.impulses(), result.lambda);
  result.before = natural_map_residual(system, result.lambda);
  double violation = 0;
  result.tried = improve_by_interior_point(system, limit, nullptr, sweeps, violation, result.work);
  sweeps.get(sweeps.impulses(), result.lambda);
  result.after = natural_map_residual(system, result.lambda);
  if (result.tried) {
    EXPECT_NEAR(violation, result.after * largest_magnitude(system.b), 1e-7);
  }
  return result;
}

/// Heaps and walls all of whose bodies move at random: contacts open, stick and slip all over them.
std::vector<IslandSystem> busy_islands(scenes::SceneOptions options) {
  std::vector<IslandSystem> all;
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    options.seed = seed;
    for (const double noise : {0.5, 3.0}) {
      options.noise = noise;
      all.push_back(scenes::disc_heap(12, options).system);
      all.push_back(scenes::pyramid(12, options).system);
      all.push_back(scenes::wall(10, 12, false, options).system);
    }
  }
  return all;
}

TEST(ConeInteriorPoint, BringsBusyIslandsCloseToCoulombsLaw) {
  struct Case {
    double ratio, median;
  };
  for (const Case& one : {Case{1, 1e-7}, Case{100, 1e-4}}) {
    std::vector<double> before, after;
    for (const IslandSystem& system :
         busy_islands({.mass_ratio = one.ratio, .pattern = scenes::MassPattern::Random})) {
      const Result result = improve(system, kInfinity);
      ASSERT_TRUE(result.tried);
      EXPECT_LE(result.after, result.before * (1 + 1e-9));
      before.push_back(result.before);
      after.push_back(result.after);
    }
    std::sort(before.begin(), before.end());
    std::sort(after.begin(), after.end());
    const std::size_t half = after.size() / 2;
    std::printf("masses 1 to %g, seeds 1 to 4: median %.1e to %.1e, worst %.1e to %.1e\n", one.ratio,
                before[half], after[half], before.back(), after.back());
    EXPECT_GT(before[half], 1e-3);
    EXPECT_LE(after[half], one.median);
    EXPECT_LE(after.back(), 0.1 * before.back());
  }
}

TEST(ConeInteriorPoint, SolvesWithoutFrictionWhateverTheMasses) {
  double worst = 0;
  for (const double ratio : {1.0, 100.0}) {
    for (const IslandSystem& system :
         busy_islands({.friction = 0, .mass_ratio = ratio, .pattern = scenes::MassPattern::Random}))
      worst = std::max(worst, improve(system, kInfinity).after);
  }
  std::printf("seeds 1 to 4: worst %.1e\n", worst);
  EXPECT_LE(worst, 1e-7);
}

TEST(ConeInteriorPoint, KeepsToItsWork) {
  for (const IslandSystem& system : busy_islands({})) {
    const double bodies = static_cast<double>(system.bodies.size());
    for (const double limit : {100 * bodies, 1000 * bodies, 2000 * bodies, 4000 * bodies}) {
      const Result result = improve(system, limit);
      if (result.tried) {
        EXPECT_LE(result.work.visits, limit);
      }
      EXPECT_LE(result.after, result.before * (1 + 1e-9));
      // What cannot be done is not begun.
      if (limit <= 100 * bodies) {
        EXPECT_EQ(result.work.visits, 0);
      }
    }
  }
}

TEST(ConeInteriorPoint, TakesBodiesThatNothingMoves) {
  double worst = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    scenes::Scene scene = scenes::wall(10, 12, false, {.noise = 1, .seed = seed});
    IslandSystem& system = scene.system;
    system.bodies[45] = {};
    scene.free_velocity[45] = {};
    for (std::size_t i = 0; i < system.rows.size(); ++i) {
      const Row& row = system.rows[i];
      system.b[i] = 0;
      if (row.a >= 0) system.b[i] -= along(row.Ja, scene.free_velocity[static_cast<std::size_t>(row.a)]);
      if (row.b >= 0) system.b[i] -= along(row.Jb, scene.free_velocity[static_cast<std::size_t>(row.b)]);
    }
    const Result result = improve(system, kInfinity);
    ASSERT_TRUE(result.tried);
    worst = std::max(worst, result.after);
  }
  std::printf("seeds 1 to 5: worst %.1e\n", worst);
  EXPECT_LE(worst, 1e-3);
}

TEST(ConeInteriorPoint, LeavesRowsOfOtherKindsToOthers) {
  ConeInteriorPoint path;
  SolveWork work;
  const IslandSystem plain = scenes::pyramid(3).system;
  EXPECT_TRUE(path.assign(plain, work));
  EXPECT_FALSE(path.assign(scenes::pyramid(3, {.rolling = 0.1}).system, work));
  IslandSystem soft = plain;
  soft.compliance.assign(soft.rows.size(), 1e-6);
  EXPECT_FALSE(path.assign(soft, work));
  IslandSystem jointed = plain;
  Row joint = jointed.rows.front();
  joint.kind = RowKind::Joint;
  joint.lower = -kInfinity;
  jointed.rows.push_back(joint);
  jointed.b.push_back(0);
  EXPECT_FALSE(path.assign(jointed, work));
}

}  // namespace
}  // namespace skerry
