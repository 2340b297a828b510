// SPDX-License-Identifier: MIT
#include "physics/solver/solver.h"

#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <random>

#include "physics/islands/delassus.h"
#include "tests/solver/enumeration.h"
#include "tests/support/island_scenes.h"
#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace solver_test {

using scenes::MassPattern;
using scenes::Scene;
using scenes::SceneOptions;

bool has_friction(const IslandSystem& system) {
  for (const Row& row : system.rows) {
    if (row.normal >= 0) return true;
  }
  return false;
}

/// Everything a solution promises whatever its status: finite, within its bounds, the residual it says.
void expect_honest(const IslandSystem& system, const Solution& solution, const std::string& where) {
  ASSERT_EQ(solution.lambda.size(), system.rows.size()) << where;
  for (std::size_t i = 0; i < solution.lambda.size(); ++i) {
    ASSERT_TRUE(std::isfinite(solution.lambda[i])) << where << " row " << i;
    const Row& row = system.rows[i];
    const ImpulseBounds bounds = impulse_bounds(row, row.normal >= 0 ? solution.lambda[row.normal] : 0);
    ASSERT_GE(solution.lambda[i], bounds.lower) << where << " row " << i;
    ASSERT_LE(solution.lambda[i], bounds.upper) << where << " row " << i;
  }
  const double residual = natural_map_residual(system, solution.lambda);
  ASSERT_FALSE(std::isnan(residual)) << where;
  ASSERT_NEAR(solution.residual, residual, 1e-13 + 1e-6 * residual) << where;
  if (solution.status == SolveStatus::Solved) {
    ASSERT_LE(residual, std::max(1e-10, 16 * residual_floor(system, solution.lambda))) << where;
  }
}

/// Random small islands against enumeration; counts how many each exact solver solves.
void compare_with_enumeration(const scenes::RandomIsland& shape, SceneOptions options, int count,
                              const std::map<std::string_view, double>& least_share) {
  std::map<std::string_view, int> solved;
  std::map<std::string_view, std::string> failed;  // seeds
  int known = 0;
  for (int k = 0; k < count; ++k) {
    options.seed = 1000u + static_cast<unsigned>(k);
    const Scene scene = scenes::random_island(shape, options);
    const Enumeration oracle(scene.system);
    if (oracle.solutions().empty()) continue;
    ++known;
    for (const SolverEntry& solver : solvers()) {
      if (!solver.exact || (!solver.friction && has_friction(scene.system))) continue;
      const std::string where = std::string(solver.name) + " seed " + std::to_string(options.seed);
      const Solution solution = solver.solve(scene.system, {}, {}, nullptr);
      ASSERT_NO_FATAL_FAILURE(expect_honest(scene.system, solution, where));
      if (solution.status != SolveStatus::Solved) {
        failed[solver.name].append(" ").append(std::to_string(options.seed));
        continue;
      }
      ++solved[solver.name];
      // The velocity is that of one of the solutions; 1e-6: its error is the residual times the condition.
      ASSERT_LE(oracle.distance(solution.lambda), 1e-6 * std::sqrt(options.mass_ratio)) << where;
    }
  }
  ASSERT_GT(known, count / 2);
  for (const auto& [name, share] : least_share) {
    EXPECT_GE(solved[name], share * known)
        << name << " solved " << solved[name] << " of " << known << ", not the seeds" << failed[name];
  }
}

TEST(Solvers, AgreeWithEnumerationOnFrictionlessIslands) {
  compare_with_enumeration({.bodies = 3, .contacts = 6}, {.friction = 0, .noise = 1}, test_scale(400),
                           {{"lemke", 1}, {"dense_lu", 0.9}, {"incremental_ldlt", 1}, {"sparse_contact", 1}});
}

TEST(Solvers, AgreeWithEnumerationOnIslandsWithFriction) {
  compare_with_enumeration({.bodies = 3, .contacts = 4}, {.friction = 0.5, .noise = 1}, test_scale(400),
                           {{"lemke", 1}, {"sparse_contact", 1}});
}

TEST(Solvers, AgreeWithEnumerationOnIslandsWithRollingResistanceAndPins) {
  compare_with_enumeration({.bodies = 3, .contacts = 2, .pins = 1},
                           {.friction = 0.4, .rolling = 0.1, .noise = 1}, test_scale(300),
                           {{"lemke", 1}, {"sparse_contact", 1}});
}

TEST(Solvers, AgreeWithEnumerationAtMassRatioOneMillion) {
  compare_with_enumeration({.bodies = 3, .contacts = 4}, {.friction = 0.3, .mass_ratio = 1e6, .noise = 1},
                           test_scale(300), {{"lemke", 0.99}, {"sparse_contact", 0.99}});
}

TEST(Solvers, AgreeWithEnumerationOnSixContactsWithTheGround) {
  compare_with_enumeration({.bodies = 2, .contacts = 6, .ground_only = true}, {.friction = 0.5, .noise = 1},
                           test_scale(20), {{"lemke", 1}, {"sparse_contact", 1}});
}

TEST(Solvers, AgreeWithEnumerationOnEightContacts) {
  // Lemke's tableau left 9e-10 of one of 5400, whose basis is nearly singular.
  compare_with_enumeration({.bodies = 4, .contacts = 8}, {.friction = 0, .noise = 1}, test_scale(200),
                           {{"lemke", 0.999}, {"body_space", 1}, {"auto", 1}});
  // 65536 states each.
  compare_with_enumeration({.bodies = 4, .contacts = 8}, {.friction = 0.3, .noise = 1}, test_scale(2),
                           {{"lemke", 1}, {"auto", 1}});
}

TEST(Solvers, ClosedFormAgreesWithEnumerationIncludingPainleve) {
  for (const double mu : {0.0, 0.3, 1.0, 5.0}) {
    for (const double rolling : {0.0, 0.2}) {
      const scenes::RandomIsland one{.bodies = 1, .contacts = 1, .ground_only = true};
      compare_with_enumeration(one, {.friction = mu, .rolling = rolling, .noise = 1}, test_scale(300),
                               {{"closed_form", 1}});
    }
  }
}

/// Lemke and the sparse solver on one scene: both exact, the same velocities where they must be.
void expect_solved(const Scene& scene, std::string_view name, const std::string& where) {
  const Solution solution = find_solver(name).solve(scene.system, {}, {}, nullptr);
  ASSERT_NO_FATAL_FAILURE(expect_honest(scene.system, solution, where));
  EXPECT_EQ(solution.status, SolveStatus::Solved) << where << ' ' << name << ' ' << solution.residual;
}

TEST(Solvers, SolveManyPointsOnAnEdgeAndDuplicatedContacts) {
  for (const int points : {2, 3, 8, 32}) {
    for (const bool duplicated : {false, true}) {
      for (const double noise : {0.0, 0.1}) {
        const Scene scene =
            scenes::stack(2, {.points_per_edge = points, .duplicated = duplicated, .noise = noise});
        expect_solved(
            scene, "sparse_contact",
            std::to_string(points) + (duplicated ? " doubled" : "") + " noise " + std::to_string(noise));
        if (points <= 3) expect_solved(scene, "lemke", std::to_string(points));
      }
    }
  }
}

TEST(Solvers, SolveContactsOneNanometreApart) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const Scene scene = scenes::random_island({.bodies = 2, .contacts = 6, .near_copy = 1e-9},
                                              {.friction = 0, .noise = 1, .seed = seed});
    expect_solved(scene, "sparse_contact", "seed " + std::to_string(seed));
    expect_solved(scene, "lemke", "seed " + std::to_string(seed));
  }
}

TEST(Solvers, SparseContactSolvesHeapsAtRest) {
  for (const double mu : {0.0, 0.2, 0.5}) {
    SceneOptions options{.friction = mu};
    expect_solved(scenes::stack(100, options), "sparse_contact", "stack");
    expect_solved(scenes::pyramid(12, options), "sparse_contact", "pyramid");
    expect_solved(scenes::wall(6, 6, false, options), "sparse_contact", "wall");
    options.mass_ratio = 1000;
    options.pattern = MassPattern::HeavyOnTop;
    expect_solved(scenes::stack(30, options), "sparse_contact", "heavy on top");
  }
}

TEST(Solvers, TridiagonalSolvesChainsLikeLemke) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    const Scene scene =
        scenes::chain(20, {.mass_ratio = 1e3, .pattern = MassPattern::Random, .noise = 1, .seed = seed});
    expect_solved(scene, "tridiagonal", "seed " + std::to_string(seed));
    const Solution x = find_solver("tridiagonal").solve(scene.system, {}, {}, nullptr);
    const Solution y = find_solver("lemke").solve(scene.system, {}, {}, nullptr);
    for (std::size_t i = 0; i < x.lambda.size(); ++i) ASSERT_NEAR(x.lambda[i], y.lambda[i], 1e-10) << seed;
  }
  expect_solved(scenes::chain(100000, {.noise = 1}), "tridiagonal", "100000 discs");
}

// Discs in a row end as the nearest velocities, weighted by the masses, that do not fall from left to right.
std::vector<double> isotonic(const std::vector<double>& velocity, const std::vector<double>& mass) {
  struct Pool {
    double momentum, mass;
    std::size_t count;
  };
  std::vector<Pool> pools;
  for (std::size_t k = 0; k < velocity.size(); ++k) {
    pools.push_back({velocity[k] * mass[k], mass[k], 1});
    while (pools.size() > 1) {
      const Pool last = pools.back();
      Pool& before = pools[pools.size() - 2];
      if (before.momentum * last.mass <= last.momentum * before.mass) break;
      before.momentum += last.momentum;
      before.mass += last.mass;
      before.count += last.count;
      pools.pop_back();
    }
  }
  std::vector<double> result;
  for (const Pool& pool : pools) result.insert(result.end(), pool.count, pool.momentum / pool.mass);
  return result;
}

TEST(Solvers, TridiagonalEndsWithTheNearestVelocitiesThatDoNotFall) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const double ratio : {1.0, 1e4})
    for (int kind = 0; kind < 5; ++kind) {
      const int count = 1200;
      const Scene scene =
          scenes::chain(count, {.mass_ratio = ratio, .pattern = MassPattern::Random, .noise = 1, .seed = 5});
      std::vector<double> velocity, mass;
      for (int k = 0; k < count; ++k) {
        mass.push_back(1 / scene.system.bodies[static_cast<std::size_t>(k)].linear);
        const double t = static_cast<double>(k) / count;
        // Noise; all approach; pairs that approach and drift apart, the same swept up from the right in the
        // end, and all at once; speeds of few values, with ties.
        const double pairs = (k % 2 ? -0.1 : 0.1) / count + 5 * t;
        velocity.push_back(kind == 0   ? unit(random)
                           : kind == 1 ? -t
                           : kind == 2 ? pairs
                           : kind == 3 ? (k + 1 == count ? -1e4 * count : pairs)
                                       : std::round(2 * unit(random)));
      }
      IslandSystem system = scene.system;
      for (std::size_t i = 0; i < system.b.size(); ++i) system.b[i] = velocity[i] - velocity[i + 1];
      const Solution solution = find_solver("tridiagonal").solve(system, {}, {}, nullptr);
      EXPECT_EQ(solution.status, SolveStatus::Solved) << "kind " << kind;
      EXPECT_EQ(solution.iterations, 1) << "kind " << kind << ": more than the one pass";
      std::vector<std::array<double, 3>> change(velocity.size(), {0, 0, 0});
      apply_impulses(system, solution.lambda, change);
      const std::vector<double> expected = isotonic(velocity, mass);
      const double scale = largest_magnitude(velocity);
      for (std::size_t k = 0; k < velocity.size(); ++k)
        ASSERT_NEAR(velocity[k] + change[k][0], expected[k], 1e-9 * scale)
            << "kind " << kind << ", disc " << k;
    }
}

TEST(Solvers, MemoryThatNobodyKeepsLeavesNothingBehind) {
  // The same graphs come again with other numbers, and others between them, warm and cold.
  std::vector<Scene> all;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    const SceneOptions options{.friction = 0.3, .noise = seed % 2 ? 0.3 : 0.0, .seed = seed};
    all.push_back(scenes::stack(5, options));
    all.push_back(scenes::pyramid(4, options));
    all.push_back(scenes::wall(3, 4, seed % 3 == 0, options));
    all.push_back(scenes::disc_heap(4, options));
  }
  for (const char* name : {"body_space", "auto"}) {
    const SolverEntry& solver = find_solver(name);
    std::vector<double> warm;
    for (std::size_t k = 0; k < 4 * all.size(); ++k) {
      const IslandSystem& system = all[(7 * k) % all.size()].system;
      std::span<const double> start;
      if (k % 3 == 1) {
        warm.assign(system.rows.size(), 1e-3);
        start = warm;
      }
      std::unique_ptr<SolverMemory> fresh;
      const Solution kept = solver.solve(system, start, {}, &fresh);
      const Solution not_kept = solver.solve(system, start, {}, nullptr);
      ASSERT_EQ(kept.lambda, not_kept.lambda) << name << ", problem " << k;
      EXPECT_EQ(kept.residual, not_kept.residual);
      EXPECT_EQ(kept.work.visits, not_kept.work.visits);
      EXPECT_EQ(kept.work.factorisations, not_kept.work.factorisations);
      EXPECT_EQ(kept.work.symbolic_analyses, not_kept.work.symbolic_analyses);
      EXPECT_EQ(kept.work.symbolic_skipped, not_kept.work.symbolic_skipped);
    }
  }
}

TEST(Solvers, TridiagonalRefusesIslandsThatAreNoPath) {
  const Scene scene = scenes::disc_heap(3, {.friction = 0});
  const Solution solution = find_solver("tridiagonal").solve(scene.system, {}, {}, nullptr);
  EXPECT_EQ(solution.status, SolveStatus::Unsupported);
}

TEST(Solvers, DenseLuSaysSingularAndNeverNaN) {
  const Scene scene = scenes::stack(1, {.friction = 0, .points_per_edge = 3});
  const Solution solution = find_solver("dense_lu").solve(scene.system, {}, {}, nullptr);
  EXPECT_EQ(solution.status, SolveStatus::Singular);
  expect_honest(scene.system, solution, "three points on an edge");
}

TEST(Solvers, KeptFactorsServeANewLoadWithoutFactoring) {
  Scene scene = scenes::stack(5, {.friction = 0});
  for (const char* name : {"dense_lu", "incremental_ldlt", "sparse_contact"}) {
    std::unique_ptr<SolverMemory> memory;
    const SolverEntry& solver = find_solver(name);
    const Solution first = solver.solve(scene.system, {}, {}, &memory);
    ASSERT_EQ(first.status, SolveStatus::Solved) << name;
    IslandSystem heavier = scene.system;
    for (double& b : heavier.b) b *= 1.25;
    const Solution second = solver.solve(heavier, first.lambda, {}, &memory);
    EXPECT_EQ(second.status, SolveStatus::Solved) << name;
    EXPECT_EQ(second.work.factorisations + second.work.partial_factorisations, 0) << name;
    EXPECT_GE(second.work.resolves, 1) << name;
    for (std::size_t i = 0; i < first.lambda.size(); ++i) {
      EXPECT_NEAR(second.lambda[i], 1.25 * first.lambda[i], 1e-12) << name;
    }
  }
}

TEST(Solvers, GiveTheSameBitsTwice) {
  const Scene scene = scenes::pyramid(5, {.noise = 1});
  for (const SolverEntry& solver : solvers()) {
    const Solution x = solver.solve(scene.system, {}, {}, nullptr);
    const Solution y = solver.solve(scene.system, {}, {}, nullptr);
    EXPECT_EQ(x.lambda, y.lambda) << solver.name;
  }
}

TEST(Solvers, StayFiniteAndWithinBoundsOnGarbage) {
  std::vector<IslandSystem> systems;
  systems.emplace_back();  // no rows at all
  for (const double size : {1e-300, 1e-150, 1e-9, 1e9, 1e100, 1e300}) {
    for (IslandSystem system :
         {scenes::stack(2).system, scenes::random_island({2, 3, 1}, {.noise = 1}).system,
          scenes::chain(4).system}) {
      IslandSystem loads = system, masses = system;
      for (double& b : loads.b) b *= size;
      for (InverseMass& body : masses.bodies) body.linear *= std::min(size, 1e100);
      systems.push_back(loads);
      systems.push_back(masses);
    }
  }
  // Two pins that pull one body apart; a contact asked to part where nothing can move.
  scenes::SceneBuilder builder({});
  builder.body({0, 0}, 1, 1);
  builder.pin(-1, 0, {1, 0});
  builder.pin(-1, 0, {-1, 0});
  IslandSystem torn = builder.finish().system;
  torn.b = {1, 0, -1, 0};
  systems.push_back(torn);
  IslandSystem stuck = scenes::box_on_floor().system;
  stuck.bodies[0] = {0, 0};
  systems.push_back(stuck);
  for (std::size_t k = 0; k < systems.size(); ++k) {
    for (const SolverEntry& solver : solvers()) {
      SCOPED_TRACE(std::string(solver.name) + " on system " + std::to_string(k));
      std::vector<double> warm(systems[k].rows.size(), std::nan(""));
      for (const bool with_warm : {false, true}) {
        const Solution solution =
            solver.solve(systems[k], with_warm ? std::span<const double>(warm) : std::span<const double>(),
                         {.max_iterations = 200}, nullptr);
        ASSERT_EQ(solution.lambda.size(), systems[k].rows.size());
        for (std::size_t i = 0; i < solution.lambda.size(); ++i) {
          ASSERT_TRUE(std::isfinite(solution.lambda[i])) << "row " << i;
          const Row& row = systems[k].rows[i];
          const ImpulseBounds bounds = impulse_bounds(row, row.normal >= 0 ? solution.lambda[row.normal] : 0);
          ASSERT_GE(solution.lambda[i], bounds.lower) << "row " << i;
          ASSERT_LE(solution.lambda[i], bounds.upper) << "row " << i;
        }
        ASSERT_FALSE(std::isnan(solution.residual));
      }
    }
  }
}

TEST(Registry, NamesAreUniqueAndUnknownOnesAreListed) {
  std::map<std::string_view, int> names;
  for (const SolverEntry& entry : solvers()) ++names[entry.name];
  for (const auto& [name, count] : names) EXPECT_EQ(count, 1) << name;
  try {
    find_solver("magic");
    FAIL() << "an unknown name was accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("magic"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("lemke"), std::string::npos);
  }
}

TEST(TgsSoft, LeavesAnExactWarmStartAsItIs) {
  const scenes::Scene scene = scenes::stack(10);
  const Solution exact = find_solver("auto").solve(scene.system, {}, {}, nullptr);
  const Solution soft = find_solver("tgs_soft").solve(scene.system, exact.lambda, {}, nullptr);
  EXPECT_LE(soft.residual, 1e-12);
}

}  // namespace solver_test
}  // namespace skerry
