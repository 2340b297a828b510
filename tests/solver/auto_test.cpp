// SPDX-License-Identifier: MIT
#include "physics/solver/auto.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <sstream>
#include <tuple>
#include <utility>

#include "physics/import.h"
#include "physics/solver/body_space.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace auto_test {

using scenes::Scene;
using scenes::SceneOptions;

Solution solve(const IslandSystem& system, const SolveOptions& options = {}) {
  return solve_auto(system, {}, options, nullptr);
}

bool has_note(const Solution& solution, const char* text) {
  return solution.trace && std::any_of(solution.trace->notes.begin(), solution.trace->notes.end(),
                                       [&](const std::string& n) { return n.find(text) != n.npos; });
}

// Bodies of a milligram beside an idle motor: the answer of the first rung is exact but for rounding.
TEST(Auto, AnswersWithinRoundingAreSolved) {
  std::istringstream problem(R"({
  "format": "skerry-island", "version": 1,
  "bodies": [
    {"inverse_mass": 906634.8154702601, "inverse_inertia": 43941.60665443816, "position": [1.0570223782971033, 0.6836643565976916]}],
  "rows": [
    {"kind": "motor", "a": -1, "b": 0, "Ja": [0, 0, 0], "Jb": [0, 0, 1], "lower": -0.5971653522274031, "upper": 0.5971653522274031, "normal": -1, "mu": 0, "source": "4"},
    {"kind": "joint", "a": -1, "b": 0, "Ja": [0, 0, 0], "Jb": [-0.5141084115309649, -0.6867548641333694, -0.4211282423784608], "lower": "-inf", "upper": "inf", "normal": -1, "mu": 0, "source": "8"},
    {"kind": "normal", "a": -1, "b": 0, "Ja": [0, 0, 0], "Jb": [0, 1, -0.30407319015553425], "lower": 0, "upper": "inf", "normal": -1, "mu": 0, "source": "12"},
    {"kind": "normal", "a": 0, "b": -1, "Ja": [-0, 1, 0.8730774755645305], "Jb": [0, 0, 0], "lower": 0, "upper": "inf", "normal": -1, "mu": 0, "source": "16"},
    {"kind": "friction", "a": 0, "b": -1, "Ja": [-1, -0, 0.475146133384317], "Jb": [0, 0, 0], "lower": 0, "upper": "inf", "normal": 3, "mu": 0, "source": "17"},
    {"kind": "normal", "a": 0, "b": -1, "Ja": [-0, 1, 0.8730774755645305], "Jb": [0, 0, 0], "lower": 0, "upper": "inf", "normal": -1, "mu": 0, "source": "100016"},
    {"kind": "friction", "a": 0, "b": -1, "Ja": [-1, -0, 0.475146133384317], "Jb": [0, 0, 0], "lower": 0, "upper": "inf", "normal": 5, "mu": 0, "source": "100017"},
    {"kind": "normal", "a": 0, "b": -1, "Ja": [0.6504321480339561, -0.7595643625157342, 0.2741458723120827], "Jb": [0, 0, 0], "lower": 0, "upper": "inf", "normal": -1, "mu": 0, "source": "20"},
    {"kind": "friction", "a": 0, "b": -1, "Ja": [0.7595643625157342, 0.6504321480339561, -0.8658117252222552], "Jb": [0, 0, 0], "lower": 0, "upper": "inf", "normal": 7, "mu": 0, "source": "21"}],
  "b": [0.7044814175161036, -0, 0, 0, 0, 0, 0, 0, 0]
})");
  const ImportedIsland island = read_json(problem);
  const Solution solution = solve(island.system);
  EXPECT_EQ(solution.status, SolveStatus::Solved) << solution.residual;
  EXPECT_FALSE(solution.method.empty());
  EXPECT_GT(solution.iterations, 0);
  EXPECT_LE(solution.residual, 1e-9);
}

TEST(Auto, TakesTheRungThatFits) {
  const Solution nothing = solve(IslandSystem{}, {.trace = true});
  EXPECT_EQ(nothing.status, SolveStatus::Solved);
  EXPECT_EQ(nothing.method, "none");
  EXPECT_TRUE(has_note(nothing, "no rows"));

  const Scene one = scenes::stack(1, {.friction = 0.5, .points_per_edge = 1});
  EXPECT_EQ(solve(one.system).method, "closed_form");

  EXPECT_EQ(solve(scenes::stack(3).system).method, "small_exact");
  EXPECT_EQ(solve(scenes::chain(50).system).method, "tridiagonal");

  const Scene pyramid = scenes::pyramid(8);
  EXPECT_EQ(solve(pyramid.system).method, "body_space");
}

TEST(Auto, EverySolverLeavesATraceOfWhatItAnswers) {
  const Scene one = scenes::stack(1, {.friction = 0.5, .points_per_edge = 1}), chain = scenes::chain(20),
              heap = scenes::stack(4);
  for (const auto& [name, scene] :
       {std::pair{"closed_form", &one}, std::pair{"tridiagonal", &chain}, std::pair{"lemke", &heap}}) {
    SCOPED_TRACE(name);
    const SolverEntry& solver = find_solver(name);
    const Solution solution = solver.solve(scene->system, {}, {.trace = true}, nullptr);
    ASSERT_TRUE(solution.trace);
    ASSERT_FALSE(solution.trace->iterations.empty());
    const SolveIteration& last = solution.trace->iterations.back();
    EXPECT_NEAR(last.residual, solution.residual, 1e-12);
    EXPECT_GT(last.open + last.stick + last.slip, 0);
    EXPECT_EQ(last.pivots, solution.work.pivots);
    EXPECT_FALSE(solver.solve(scene->system, {}, {}, nullptr).trace);
  }
  // Where chains need more than one look.
  Scene row = chain;
  for (std::size_t i = 0; i < row.system.b.size(); ++i) row.system.b[i] = i % 3 == 0 ? 1 : -0.9;
  for (Row& r : row.system.rows) std::swap(r.a, r.b), std::swap(r.Ja, r.Jb);
  const Solution several = find_solver("tridiagonal").solve(row.system, {}, {.trace = true}, nullptr);
  EXPECT_EQ(several.trace->iterations.size(), static_cast<std::size_t>(several.iterations));
  EXPECT_TRUE(has_note(solve(one.system, {.trace = true}), "closed form"));
}

TEST(Auto, EveryAnswerIsVerified) {
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const int bodies = 1 + static_cast<int>(seed % 5), contacts = 1 + static_cast<int>(seed % 7);
    const Scene scene =
        scenes::random_island({.bodies = bodies, .contacts = contacts, .pins = static_cast<int>(seed % 2)},
                              {.friction = 0.2, .noise = 1, .seed = seed});
    const Solution solution = solve(scene.system);
    EXPECT_NEAR(solution.residual, natural_map_residual(scene.system, solution.lambda), 1e-12);
    if (solution.status == SolveStatus::Solved) {
      EXPECT_LE(solution.residual, std::max(1.01e-10, 16 * residual_floor(scene.system, solution.lambda)));
    }
    EXPECT_EQ(solution.status, SolveStatus::Solved);
  }
}

TEST(Auto, ASmallBudgetStillGivesAFiniteAnswerAndSaysWhichRung) {
  const Scene scene = scenes::pyramid(15, {.noise = 1});
  const Solution rich = solve(scene.system);
  for (const int limit : {1, 3, 10}) {
    const Solution poor = solve(scene.system, {.max_iterations = limit, .trace = true});
    for (const double z : poor.lambda) ASSERT_TRUE(std::isfinite(z));
    EXPECT_EQ(poor.residual, natural_map_residual(scene.system, poor.lambda));
    EXPECT_TRUE(has_note(poor, "convex step"));
    EXPECT_TRUE(has_note(poor, "sweeps"));
    EXPECT_GE(poor.residual, rich.residual);
  }
}

TEST(Auto, ATimeBudgetIsKeptWithinReason) {
  const Scene scene = scenes::pyramid(40, {.noise = 1});
  const Solution solution = solve(scene.system, {.time_budget = 1e-3});
  for (const double z : solution.lambda) ASSERT_TRUE(std::isfinite(z));
  EXPECT_LT(solution.work.factorisations, 100);
}

Scene of_much_friction(int seed, int bodies, double mass_ratio) {
  const SceneOptions options{.friction = 10,
                             .mass_ratio = mass_ratio,
                             .pattern = scenes::MassPattern::Random,
                             .noise = 1,
                             .seed = static_cast<std::uint64_t>(seed)};
  return scenes::random_island({.bodies = bodies, .contacts = 2 * bodies}, options);
}

// Masses 1000 times each other's and more, friction of 10.
TEST(Auto, PivotingFindsWhatTheSearchDoesNot) {
  for (const auto& [seed, bodies, mass_ratio] :
       {std::tuple{508, 4, 1e3}, {1239, 3, 1e6}, {2378, 5, 1e3}, {371, 9, 1e3}, {76, 8, 1e6}}) {
    const Scene scene = of_much_friction(seed, bodies, mass_ratio);
    const Solution once = solve_body_space(scene.system, {}, {}, nullptr);
    EXPECT_EQ(once.status, SolveStatus::Inexact) << "seed " << seed;
    const Solution solution = solve(scene.system);
    EXPECT_EQ(solution.status, SolveStatus::Solved) << "seed " << seed << ": " << solution.residual;
    EXPECT_EQ(solution.method, "lemke") << "seed " << seed;
    EXPECT_LE(solution.work.visits, 1.5 * once.work.visits + 1e6) << "seed " << seed;
  }
}

// No rung finds an exact answer of this one.
TEST(Auto, SearchesInVainOnlyOnce) {
  const Scene scene = of_much_friction(87, 18, 1e3);
  const Solution once = solve_body_space(scene.system, {}, {}, nullptr);
  ASSERT_EQ(once.status, SolveStatus::Inexact);
  for (const double limit : {0.0, 1e7, 2e4}) {
    const Solution solution = solve(scene.system, {.work_limit = limit, .trace = true});
    EXPECT_EQ(solution.status, SolveStatus::Inexact) << "limit " << limit;
    EXPECT_LE(solution.work.visits, limit > 0 ? 1.3 * limit : 2e6) << "limit " << limit;
    EXPECT_EQ(has_note(solution, "pivoting"), limit != 2e4) << "limit " << limit;
  }
}

TEST(Auto, KeepsFactorsBetweenCallsAndGivesTheSameBits) {
  const Scene scene = scenes::pyramid(10, {.noise = 0.05});
  std::unique_ptr<SolverMemory> memory;
  const Solution first = solve_auto(scene.system, {}, {}, &memory);
  const Solution second = solve_auto(scene.system, first.lambda, {}, &memory);
  EXPECT_EQ(second.work.factorisations, 0);
  EXPECT_EQ(first.lambda, second.lambda);
  EXPECT_EQ(first.lambda, solve(scene.system).lambda);
}

// A wheel whose axle is held touches blocks on two sides of it under much friction: what presses there is
// what the friction of that very contact makes turn. Sweeps creep away, and of the states only one has an
// answer.
TEST(Auto, FindsImpulsesThatFeedEachOther) {
  IslandSystem system;
  system.bodies.push_back({.linear = 0, .angular = 0.83});
  const auto touch = [&](double press, double grip, double normal_wants, double friction_wants) {
    Row row;
    row.kind = RowKind::Normal;
    row.b = 0;
    row.lower = 0;
    row.upper = kInfinity;
    row.Jb = {0, 1, press};
    system.rows.push_back(row);
    row.kind = RowKind::Friction;
    row.normal = system.size() - 1;
    row.mu = 1.67;
    row.Jb = {-1, 0, grip};
    system.rows.push_back(row);
    system.b.insert(system.b.end(), {normal_wants, friction_wants});
  };
  touch(0.0973, 0.2285, -0.1397, -0.7614);
  touch(-0.3137, -0.3656, 0.1780, -0.3023);
  for (const double work_limit : {0.0, 1e4}) {
    const Solution solution = solve(system, {.work_limit = work_limit, .trace = true});
    EXPECT_EQ(solution.status, SolveStatus::Solved) << solution.residual;
    EXPECT_LE(natural_map_residual(system, solution.lambda), 1e-12);
    EXPECT_LT(std::abs(solution.lambda[1]), 20);
    EXPECT_EQ(solution.method, "lemke");
    EXPECT_TRUE(has_note(solution, "pivoting"));
  }
}

}  // namespace auto_test
}  // namespace skerry
