// SPDX-License-Identifier: MIT
#include "physics/solver/welded_bodies.h"

#include <Eigen/Dense>
#include <algorithm>
#include <gtest/gtest.h>
#include <random>
#include <string>

#include "physics/solver/auto.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace welded_bodies_test {

using scenes::Scene;
using scenes::SceneBuilder;
using scenes::SceneOptions;

/// Boxes in columns on a floor, of which some neighbours are welded, in trees and loops; a box of the first
/// column may be welded to the floor.
Scene frames(std::uint64_t seed, const SceneOptions& options, int columns = 4, int layers = 3) {
  SceneBuilder builder(options);
  std::uniform_real_distribution<double> uniform(0, 1);
  const auto at = [&](int column, int layer) { return column * layers + layer; };
  for (int column = 0; column < columns; ++column)
    for (int layer = 0; layer < layers; ++layer) {
      const double mass = std::pow(options.mass_ratio, uniform(builder.random()));
      builder.body({1.02 * column, layer + 0.5}, mass, scenes::box_inertia(mass, 1, 1));
    }
  std::vector<std::uint8_t> welded(static_cast<std::size_t>(columns * layers), 0);
  if (seed % 3 == 0) builder.weld(-1, 0, {0, 0});
  for (int column = 0; column < columns; ++column)
    for (int layer = 0; layer < layers; ++layer) {
      const int body = at(column, layer);
      if (column > 0 && uniform(builder.random()) < 0.6)
        builder.weld(at(column - 1, layer), body, {1.02 * column - 0.51, layer + uniform(builder.random())});
      if (layer > 0 && uniform(builder.random()) < 0.6) {
        builder.weld(body - 1, body, {1.02 * column, static_cast<double>(layer)});
        welded[static_cast<std::size_t>(body)] = 1;
      }
    }
  for (int column = 0; column < columns; ++column)
    for (int layer = 0; layer < layers; ++layer) {
      if (welded[static_cast<std::size_t>(at(column, layer))] != 0) continue;
      builder.edge(layer == 0 ? -1 : at(column, layer) - 1, at(column, layer), 1.02 * column - 0.5,
                   1.02 * column + 0.5, layer);
    }
  return builder.finish();
}

SceneOptions options_of(std::uint64_t seed, double friction) {
  return {.friction = friction, .mass_ratio = seed % 2 == 0 ? 1 : 1e3, .noise = 1, .seed = seed};
}

Eigen::MatrixXd jacobian(const IslandSystem& system) {
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(system.size(), 3 * static_cast<int>(system.bodies.size()));
  for (int i = 0; i < system.size(); ++i) {
    const Row& row = system.rows[static_cast<std::size_t>(i)];
    for (int c = 0; c < 3; ++c) {
      if (row.a >= 0) J(i, 3 * row.a + c) = row.Ja[static_cast<std::size_t>(c)];
      if (row.b >= 0) J(i, 3 * row.b + c) = row.Jb[static_cast<std::size_t>(c)];
    }
  }
  return J;
}

Eigen::MatrixXd delassus_of(const IslandSystem& system) {
  Eigen::VectorXd inverse(3 * static_cast<int>(system.bodies.size()));
  for (std::size_t k = 0; k < system.bodies.size(); ++k)
    inverse.segment<3>(3 * static_cast<int>(k)) << system.bodies[k].linear, system.bodies[k].linear,
        system.bodies[k].angular;
  const Eigen::MatrixXd J = jacobian(system);
  return J * inverse.asDiagonal() * J.transpose();
}

TEST(WeldedBodies, GroupsHaveTheSchurComplementOfTheWelds) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scene scene = frames(seed, options_of(seed, 0.5));
    WeldedBodies welded;
    if (!welded.find(scene.system) || welded.rows().empty()) continue;
    ++found;
    const std::vector<int>& kept = welded.rows();
    std::vector<int> held;
    for (int i = 0; i < scene.system.size(); ++i)
      if (scene.system.rows[static_cast<std::size_t>(i)].kind == RowKind::Joint) held.push_back(i);
    ASSERT_EQ(kept.size(), static_cast<std::size_t>(welded.groups().size()));
    const Eigen::MatrixXd W = delassus_of(scene.system);
    const Eigen::VectorXd b = Eigen::Map<const Eigen::VectorXd>(scene.system.b.data(), W.rows());
    const Eigen::MatrixXd to_held = W(held, held).completeOrthogonalDecomposition().solve(W(held, kept));
    const Eigen::VectorXd alone = W(held, held).completeOrthogonalDecomposition().solve(b(held).eval());
    const Eigen::MatrixXd want = W(kept, kept) - W(kept, held) * to_held;
    const Eigen::VectorXd want_b = b(kept) - W(kept, held) * alone;
    const Eigen::MatrixXd have = delassus_of(welded.groups());
    const Eigen::VectorXd have_b =
        Eigen::Map<const Eigen::VectorXd>(welded.groups().b.data(), static_cast<int>(kept.size()));
    EXPECT_LT((want - have).cwiseAbs().maxCoeff(), 1e-9 * W.cwiseAbs().maxCoeff());
    EXPECT_LT((want_b - have_b).cwiseAbs().maxCoeff(), 1e-8 * b.cwiseAbs().maxCoeff());
  }
  EXPECT_GT(found, 250);
}

std::vector<std::array<double, 3>> velocities_after(const IslandSystem& system,
                                                    const std::vector<double>& lambda) {
  std::vector<std::array<double, 3>> v(system.bodies.size());
  apply_impulses(system, lambda, v);
  return v;
}

TEST(WeldedBodies, MoveAsTheyDoWithAllRows) {
  // Without friction the velocities are unique.
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Scene scene = frames(seed, options_of(seed, 0));
    const SolveOptions options{.tolerance = 1e-11};
    SolveOptions all_rows = options;
    all_rows.welds_as_one = false;
    const Solution one = solve_auto(scene.system, {}, options, nullptr);
    const Solution all = solve_auto(scene.system, {}, all_rows, nullptr);
    ASSERT_EQ(one.status, SolveStatus::Solved) << one.residual;
    ASSERT_EQ(all.status, SolveStatus::Solved) << all.residual;
    EXPECT_EQ(all.work.rows_left_out, 0);
    const auto u = velocities_after(scene.system, one.lambda), v = velocities_after(scene.system, all.lambda);
    for (std::size_t k = 0; k < u.size(); ++k)
      for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(u[k][c], v[k][c], 1e-8) << "body " << k;
  }
}

TEST(WeldedBodies, ObeyCoulombsLaw) {
  for (const double friction : {0.3, 0.8}) {
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
      SCOPED_TRACE("seed " + std::to_string(seed));
      const Scene scene = frames(seed, options_of(seed, friction), 5, 4);
      const Solution solution = solve_auto(scene.system, {}, {}, nullptr);
      ASSERT_EQ(solution.status, SolveStatus::Solved) << solution.residual;
      EXPECT_EQ(solution.residual, natural_map_residual(scene.system, solution.lambda));
    }
  }
}

TEST(WeldedBodies, BeginFromTheLastImpulsesAndKeepWhatTheyKnow) {
  const Scene scene = frames(5, options_of(5, 0.5), 6, 5);
  std::unique_ptr<SolverMemory> memory;
  const Solution first = solve_auto(scene.system, {}, {}, &memory);
  ASSERT_EQ(first.status, SolveStatus::Solved);
  EXPECT_GT(first.work.rows_left_out, 0);
  EXPECT_GT(first.work.symbolic_analyses, 0);
  const Solution again = solve_auto(scene.system, first.lambda, {}, &memory);
  ASSERT_EQ(again.status, SolveStatus::Solved);
  EXPECT_EQ(again.work.symbolic_analyses, 0);
  EXPECT_LT(again.work.visits, first.work.visits);
}

/// Two welded boxes above a floor.
SceneBuilder pair_of_boxes() {
  SceneBuilder builder({.friction = 0.5});
  builder.body({0, 0.5}, 1, scenes::box_inertia(1, 1, 1));
  builder.body({0, 1.5}, 1, scenes::box_inertia(1, 1, 1));
  builder.weld(0, 1, {0, 1});
  return builder;
}

TEST(WeldedBodies, WithContactsBetweenThemselvesCarryNothingThere) {
  SceneBuilder builder = pair_of_boxes();
  builder.edge(-1, 0, -0.5, 0.5, 0);
  builder.edge(0, 1, -0.5, 0.5, 1);
  const Scene scene = builder.finish();
  WeldedBodies welded;
  ASSERT_TRUE(welded.find(scene.system));
  EXPECT_EQ(welded.groups().size(), 4);
  EXPECT_EQ(welded.rows_less(), 7);
  ASSERT_EQ(welded.groups().bodies.size(), 1u);
  EXPECT_NEAR(welded.groups().bodies[0].linear, 0.5, 1e-15);
  EXPECT_NEAR(1 / welded.groups().bodies[0].angular, 2 * (1.0 / 6 + 0.25), 1e-14);
  const Solution solution = solve_auto(scene.system, {}, {}, nullptr);
  ASSERT_EQ(solution.status, SolveStatus::Solved) << solution.residual;
  EXPECT_EQ(solution.lambda[3 + 4], 0);
}

TEST(WeldedBodies, AreLeftAloneWhereAMotorActsBetweenThem) {
  SceneBuilder builder = pair_of_boxes();
  Row motor;
  motor.kind = RowKind::Motor;
  motor.a = 0;
  motor.b = 1;
  motor.Ja = {0, 0, -1};
  motor.Jb = {0, 0, 1};
  motor.lower = -1;
  motor.upper = 1;
  builder.scene().system.rows.push_back(motor);
  builder.edge(-1, 0, -0.5, 0.5, 0);
  const Scene scene = builder.finish();
  WeldedBodies welded;
  EXPECT_FALSE(welded.find(scene.system));
  EXPECT_EQ(solve_auto(scene.system, {}, {}, nullptr).status, SolveStatus::Solved);
}

TEST(WeldedBodies, DoNotTurnWithOneThatDoesNot) {
  SceneBuilder builder = pair_of_boxes();
  builder.contact(-1, 0, {0.4, 0}, {0, 1});
  Scene scene = builder.finish();
  scene.system.bodies[1].angular = 0;
  WeldedBodies welded;
  ASSERT_TRUE(welded.find(scene.system));
  EXPECT_EQ(welded.groups().bodies[0].angular, 0);
  const Solution solution = solve_auto(scene.system, {}, {}, nullptr);
  ASSERT_EQ(solution.status, SolveStatus::Solved) << solution.residual;
  const auto v = velocities_after(scene.system, solution.lambda);
  EXPECT_NEAR(v[0][2], 0, 1e-12);
  EXPECT_NEAR(v[0][1], scene.system.b[3], 1e-12);
}

TEST(WeldedBodies, AreNoneWhereNothingIsWelded) {
  WeldedBodies welded;
  EXPECT_FALSE(welded.find({}));
  EXPECT_FALSE(welded.find(scenes::stack(5).system));
  SceneBuilder pinned({.friction = 0.5});
  pinned.body({0, 0.5}, 1, scenes::box_inertia(1, 1, 1));
  pinned.body({0, 1.5}, 1, scenes::box_inertia(1, 1, 1));
  pinned.pin(0, 1, {0, 1});
  pinned.edge(-1, 0, -0.5, 0.5, 0);
  EXPECT_FALSE(welded.find(pinned.finish().system));
}

TEST(WeldedBodies, TurnAsTheOneThatCannotBeTurnedIsTold) {
  SceneBuilder builder({.friction = 0.5});
  for (int k = 0; k < 3; ++k) builder.body({0, k + 0.5}, 1, scenes::box_inertia(1, 1, 1));
  builder.weld(0, 1, {0, 1});
  builder.weld(1, 2, {0, 2});
  builder.contact(-1, 0, {0.4, 0}, {0, 1});
  Scene scene = builder.finish();
  scene.system.bodies[2].angular = 0;
  for (std::size_t i = 0; i < scene.system.rows.size(); ++i) {
    if (scene.system.rows[i].kind == RowKind::Joint) scene.system.b[i] = 0.1 * (static_cast<double>(i) + 1);
  }
  WeldedBodies welded;
  ASSERT_TRUE(welded.find(scene.system));
  std::vector<double> own(welded.groups().rows.size(), 0.0), all;
  own[0] = 0.3;
  SolveWork work;
  welded.expand(own, {}, nullptr, all, work);
  std::vector<std::array<double, 3>> by_rows(3), by_groups(3);
  apply_impulses(scene.system, all, by_rows);
  welded.move(own, by_groups);
  for (std::size_t k = 0; k < 3; ++k) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(by_rows[k][c], by_groups[k][c], 1e-12) << k << ", " << c;
  }
}

TEST(WeldedBodies, GoOnTurningWithOneThatNothingTurns) {
  for (const bool turns : {true, false}) {
    SceneBuilder builder({.friction = 0.5});
    for (int k = 0; k < 2; ++k) builder.body({0, k + 0.5}, 1 + k, scenes::box_inertia(1, 1, 1));
    builder.weld(0, 1, {0, 1});
    builder.contact(-1, 0, {0.4, 0}, {0, 1});
    Scene scene = builder.finish();
    if (!turns) scene.system.bodies[1].angular = 0;
    for (std::size_t i = 0; i < 3; ++i) scene.system.b[i] = 0;
    WeldedBodies welded;
    ASSERT_TRUE(welded.find(scene.system));
    const std::vector<std::array<double, 3>> rigid{{1 + 0.3 * 0.5, 2, 0.3}, {1 - 0.3 * 0.5, 2, 0.3}};
    std::vector<std::array<double, 3>> groups, bodies(2);
    welded.join(rigid, groups);
    welded.spread(groups, bodies);
    for (std::size_t k = 0; k < 2; ++k) {
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(bodies[k][c], rigid[k][c], 1e-13) << turns << ", " << k << ", " << c;
    }
  }
}

TEST(WeldedBodies, HeldByTheGroundTellWhatTheyAreTold) {
  SceneBuilder builder({.friction = 0.5});
  for (int k = 0; k < 2; ++k) builder.body({0, k + 0.5}, 1, scenes::box_inertia(1, 1, 1));
  builder.weld(-1, 0, {0, 0});
  builder.contact(0, 1, {0.4, 1}, {0, 1});
  Scene scene = builder.finish();
  for (std::size_t i = 0; i < 3; ++i) scene.system.b[i] = 0.1 * (static_cast<double>(i) + 1);
  WeldedBodies welded;
  ASSERT_TRUE(welded.find(scene.system));
  const std::vector<std::array<double, 3>> still(2);
  for (std::size_t k = 0; k < welded.rows().size(); ++k) {
    const double all = scene.system.b[static_cast<std::size_t>(welded.rows()[k])];
    EXPECT_NEAR(welded.told(k, still), all - welded.groups().b[k], 1e-13) << k;
  }
  EXPECT_GT(std::abs(welded.told(0, still)), 0.01);
}

/// A gear between bodies that turn as one holds the group.
TEST(WeldedBodies, AreTurnedAsAWholeByAGearBetweenThemselves) {
  SceneBuilder builder({.friction = 0.5});
  for (int k = 0; k < 2; ++k) builder.body({0, k + 0.5}, 1, scenes::box_inertia(1, 1, 1));
  builder.weld(0, 1, {0, 1});
  Scene scene = builder.finish();
  Row gear = scene.system.rows.back();
  gear.Ja = {0, 0, 1};
  gear.Jb = {0, 0, 2};
  gear.source += 1;
  scene.system.rows.push_back(gear);
  scene.system.b.assign(4, 0.0);
  WeldedBodies welded;
  ASSERT_TRUE(welded.find(scene.system));
  ASSERT_EQ(welded.rows().size(), 1u);
  EXPECT_EQ(welded.rows()[0], 3);
  const Row& whole = welded.groups().rows[0];
  EXPECT_EQ(whole.b, -1);
  EXPECT_NEAR(whole.Ja[2], 3, 1e-12);
}

/// Three rows that hold two bodies together, but let one turn twice as far as the other, weld nothing.
TEST(WeldedBodies, AreNoneWhereTheyTurnUnequally) {
  for (const bool equal : {true, false}) {
    SceneBuilder builder({.friction = 0.5});
    for (int k = 0; k < 2; ++k) builder.body({0, k + 0.5}, 1, scenes::box_inertia(1, 1, 1));
    builder.weld(0, 1, {0, 1});
    builder.contact(-1, 0, {0.4, 0}, {0, 1});
    Scene scene = builder.finish();
    if (!equal) scene.system.rows[2].Ja[2] *= 2;
    WeldedBodies welded;
    EXPECT_EQ(welded.find(scene.system), equal);
  }
}

}  // namespace welded_bodies_test
}  // namespace skerry
