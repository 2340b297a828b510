// SPDX-License-Identifier: MIT
//
// Interior point on the friction cone: how near it brings to Coulomb's law what sweeps leave, within its
// work, and that it never leaves more than it was given.
#include "physics/solver/cone_interior_point.h"

#include <algorithm>
#include <cstdio>
#include <gtest/gtest.h>
#include <random>
#include <string>

#include "tests/support/island_scenes.h"

namespace skerry {
namespace cone_interior_point_test {

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

/// Residuals of islands, ascending.
struct Errors {
  std::vector<double> before, after;
  void print(const std::string& what) const {
    const std::size_t half = after.size() / 2;
    std::printf("%s: median %.1e to %.1e, worst %.1e to %.1e\n", what.c_str(), before[half], after[half],
                before.back(), after.back());
  }
};

Errors improve_all(const std::vector<IslandSystem>& islands) {
  Errors errors;
  for (const IslandSystem& system : islands) {
    const Result result = improve(system, kInfinity);
    EXPECT_TRUE(result.tried);
    EXPECT_LE(result.after, result.before * (1 + 1e-9));
    errors.before.push_back(result.before);
    errors.after.push_back(result.after);
  }
  std::sort(errors.before.begin(), errors.before.end());
  std::sort(errors.after.begin(), errors.after.end());
  return errors;
}

TEST(ConeInteriorPoint, BringsBusyIslandsCloseToCoulombsLaw) {
  struct Case {
    double ratio, median;
  };
  for (const Case& one : {Case{1, 1e-7}, Case{100, 1e-4}}) {
    const Errors errors =
        improve_all(busy_islands({.mass_ratio = one.ratio, .pattern = scenes::MassPattern::Random}));
    errors.print("masses 1 to " + std::to_string(one.ratio) + ", seeds 1 to 4");
    const std::size_t half = errors.after.size() / 2;
    EXPECT_GT(errors.before[half], 1e-3);
    EXPECT_LE(errors.after[half], one.median);
    EXPECT_LE(errors.after.back(), 0.1 * errors.before.back());
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

/// Joints of all kinds between every third pair of bodies that touch: hinges, limits of angles, motors that
/// are strong, weak or have no force at all, and springs.
IslandSystem with_joints(scenes::Scene scene, std::uint64_t seed) {
  IslandSystem& system = scene.system;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<std::array<int, 2>> pairs;
  for (const Row& row : system.rows)
    if (row.kind == RowKind::Normal && row.a >= 0 && row.b >= 0) pairs.push_back({row.a, row.b});
  for (std::size_t k = 0; k < pairs.size(); k += 3) {
    const int a = pairs[k][0], b = pairs[k][1];
    const auto add = [&](RowKind kind, std::array<double, 3> J, double lower, double upper, double give) {
      Row row{
          .kind = kind, .a = a, .b = b, .Ja = {-J[0], -J[1], -J[2]}, .Jb = J, .lower = lower, .upper = upper};
      const double u = along(row.Ja, scene.free_velocity[static_cast<std::size_t>(a)]) +
                       along(row.Jb, scene.free_velocity[static_cast<std::size_t>(b)]);
      system.rows.push_back(row);
      system.b.push_back(unit(random) - u);
      system.compliance.resize(system.rows.size(), 0);
      system.compliance.back() = give;
    };
    switch (k / 3 % 4) {
      case 0:
        add(RowKind::Joint, {1, 0, 0.3 * unit(random)}, -kInfinity, kInfinity, 0);
        add(RowKind::Joint, {0, 1, 0.3 * unit(random)}, -kInfinity, kInfinity, 0);
        break;
      case 1:
        add(RowKind::Limit, {0, 0, 1}, 0, kInfinity, 0);
        break;
      case 2: {
        const double most = k / 12 % 3 == 0 ? 0 : k / 12 % 3 == 1 ? 0.01 : 10;
        add(RowKind::Motor, {0, 0, 1}, -most, most, 0);
        break;
      }
      default:
        add(RowKind::Joint, {0.6, 0.8, 0}, -kInfinity, kInfinity, 0.5);
    }
  }
  return system;
}

TEST(ConeInteriorPoint, HoldsJointsLimitsMotorsAndSprings) {
  // Without friction the problem is convex, and the path always arrives.
  double worst = 0;
  int bounded = 0, held = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const scenes::SceneOptions moving{
        .friction = 0, .mass_ratio = seed % 2 ? 1.0 : 100.0, .noise = 1, .seed = seed};
    for (const IslandSystem& system :
         {with_joints(scenes::pyramid(9, moving), seed), with_joints(scenes::disc_heap(9, moving), seed)}) {
      validate(system);
      ConeInteriorPoint path;
      SolveWork work;
      ASSERT_TRUE(path.assign(system, work));
      const double scale = largest_magnitude(system.b);
      path.start(std::vector<double>(system.rows.size(), 0.0), 0.3 * scale);
      for (int k = 0; k < 80 && path.centre() > 1e-9 * scale; ++k) path.step(work);
      std::vector<double> lambda;
      path.get(lambda);
      worst = std::max(worst, natural_map_residual(system, lambda));
      for (std::size_t i = 0; i < lambda.size(); ++i) {
        const Row& row = system.rows[i];
        EXPECT_GE(lambda[i], row.lower);
        EXPECT_LE(lambda[i], row.upper);
        if (row.kind != RowKind::Motor || row.upper == 0) continue;
        (std::abs(lambda[i]) > 0.999 * row.upper ? bounded : held) += 1;
      }
    }
  }
  std::printf("seeds 1 to 6: worst %.1e; %d motors at their bounds, %d within\n", worst, bounded, held);
  EXPECT_LE(worst, 1e-6);
  EXPECT_GT(bounded, 5);
  EXPECT_GT(held, 5);
}

/// As where friction is bounded by what a contact carried that has since come to carry nothing.
TEST(ConeInteriorPoint, GoesOnWhereBoundsLeaveAlmostNoRoom) {
  IslandSystem system = scenes::pyramid(9, {.friction = 0.5, .noise = 0.5, .seed = 1}).system;
  int narrow = 0;
  for (Row& row : system.rows) {
    if (row.kind != RowKind::Friction) continue;
    const double bound = ++narrow % 2 == 0 ? 1e-12 : 0.01;
    row.kind = RowKind::Motor;
    row.normal = -1;
    row.lower = -bound;
    row.upper = bound;
  }
  std::vector<double> start(system.rows.size(), 0.0);
  for (std::size_t i = 0; i < start.size(); ++i)
    start[i] = system.rows[i].kind == RowKind::Motor ? system.rows[i].upper : 0.1;
  ConeInteriorPoint path;
  SolveWork work;
  ASSERT_TRUE(path.assign(system, work));
  const double scale = largest_magnitude(system.b);
  path.start(start, 0.3 * scale, ConeInteriorPoint::Sliding::Associated);
  EXPECT_GT(path.step(work), 0.1);
  for (int k = 0; k < 40 && path.centre() > 1e-9 * scale; ++k) path.step(work);
  std::vector<double> lambda;
  path.get(lambda);
  EXPECT_LE(natural_map_residual(system, lambda), 1e-6);
}

TEST(ConeInteriorPoint, BringsJointsInFlowCloseToCoulombsLaw) {
  std::vector<IslandSystem> islands;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5, 6}) {
    const scenes::SceneOptions moving{.noise = 0.5, .seed = seed};
    islands.push_back(with_joints(scenes::pyramid(9, moving), seed));
    islands.push_back(with_joints(scenes::wall(10, 8, false, moving), seed));
  }
  const Errors errors = improve_all(islands);
  errors.print("seeds 1 to 6");
  EXPECT_GT(errors.before[6], 1e-3);
  EXPECT_LE(errors.after[6], 1e-5);
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
  IslandSystem pressed = plain;
  Row motor{
      .kind = RowKind::Motor, .a = 0, .b = 1, .Ja = {0, 0, -1}, .Jb = {0, 0, 1}, .lower = 1, .upper = 1};
  pressed.rows.push_back(motor);
  pressed.b.push_back(0);
  EXPECT_FALSE(path.assign(pressed, work));
  IslandSystem jointed;
  jointed.bodies = plain.bodies;
  motor.lower = -1;
  jointed.rows = {motor};
  jointed.b = {0};
  EXPECT_FALSE(path.assign(jointed, work));
}

}  // namespace cone_interior_point_test
}  // namespace skerry
