// SPDX-License-Identifier: MIT
//
// Counts, mechanisms and self-stress states; unstable structures get a sentence and no NaN.
#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>
#include <stdexcept>

#include "physics/statics/mechanism.h"
#include "physics/statics/null_space.h"
#include "tests/statics/trusses.h"
#include "tests/support/scale.h"

namespace skerry::statics::test {
namespace determinacy_test {

void expect_no_forces(StructureSolver& solver) {
  Load load;
  load.nodes.push_back({0, {3, -7}});
  const Response response = solver.solve(load, true);
  for (const MemberForce& force : response.members) {
    EXPECT_EQ(force.axial, 0);
    EXPECT_EQ(force.moment_a, 0);
  }
  for (const Reaction& reaction : response.reactions) EXPECT_EQ(reaction.force, Vec2{});
}

TEST(Determinacy, SquareWithoutADiagonalMovesSideways) {
  Structure s;
  s.nodes = {{{0, 0}}, {{1, 0}}, {{1, 1}}, {{0, 1}}};
  s.members = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
  s.supports = {{0}, {1, SupportKind::Roller}};
  StructureSolver solver(s);
  EXPECT_FALSE(solver.determinacy().stable());
  EXPECT_EQ(solver.determinacy().sentence(), "mechanism: node 3 can move to the left");
  EXPECT_EQ(solver.method(), ForceMethod::None);
  expect_no_forces(solver);

  s.members.push_back({0, 2});
  EXPECT_EQ(StructureSolver(s).determinacy().sentence(), "statically determinate");
  s.members.push_back({1, 3});
  EXPECT_EQ(StructureSolver(s).determinacy().sentence(), "1 time statically indeterminate");
}

TEST(Determinacy, UnsupportedTrussMovesAsAWhole) {
  Structure s = pratt(4);
  s.supports.clear();
  StructureSolver solver(s);
  EXPECT_EQ(solver.determinacy().mechanisms.size(), 3u);
  EXPECT_NE(solver.determinacy().sentence().find(", and 2 more"), std::string::npos);
  expect_no_forces(solver);
}

TEST(Determinacy, RightCountInTheWrongPlaceIsAMechanism) {
  // Three parallel rollers: as many forces as equations, and still free to slide.
  Structure s = pratt(4);
  s.supports = {{0, SupportKind::Roller}, {2, SupportKind::Roller}, {4, SupportKind::Roller}};
  StructureSolver solver(s);
  EXPECT_EQ(solver.determinacy().equations, solver.determinacy().unknowns);
  EXPECT_EQ(solver.determinacy().mechanisms.size(), 1u);
  EXPECT_EQ(solver.determinacy().sentence(), "mechanism: node 1 can move to the left");
  EXPECT_EQ(solver.self_stresses().size(), 1u);
}

TEST(Determinacy, NamedNodesAreCalledByTheirNames) {
  Structure s;
  s.nodes = {{{0, 0}, "A"}, {{0, 1}, "B"}};
  s.members = {{0, 1}};
  s.supports = {{0}};
  EXPECT_EQ(StructureSolver(s).determinacy().sentence(), "mechanism: node B can move to the left");
}

TEST(Determinacy, BeamThatCanOnlyTurnSaysSo) {
  Structure s;
  s.nodes = {{{0, 0}}, {{2, 0}}};
  Member beam{0, 1, MemberKind::Beam};
  s.members = {beam};
  s.supports = {{0}, {1}};
  EXPECT_EQ(StructureSolver(s).determinacy().sentence(), "1 time statically indeterminate");
  s.supports = {{0}};
  EXPECT_EQ(StructureSolver(s).determinacy().sentence(), "mechanism: node 2 can move down");
  s.supports = {{0, SupportKind::Fixed}};
  EXPECT_EQ(StructureSolver(s).determinacy().sentence(), "statically determinate");
  s.supports.clear();
  EXPECT_EQ(StructureSolver(s).determinacy().mechanisms.size(), 3u);
}

TEST(Determinacy, WhatTurnsInAMechanismMovesAsFarAsItsLeverSays) {
  for (const double side : {1.0, -1.0}) {
    Structure s;
    s.nodes = {{{0, 0}}, {{side * 4, 0}}};
    s.members = {{0, 1, MemberKind::Beam}};
    s.supports = {{0}};
    StructureSolver solver(s);
    ASSERT_EQ(solver.determinacy().mechanisms.size(), 1u);
    const Mechanism& mechanism = solver.determinacy().mechanisms[0];
    EXPECT_NEAR(mechanism.displacement[1].y, -1, 1e-12);
    EXPECT_NEAR(mechanism.rotation[1], mechanism.displacement[1].y / (side * 4), 1e-12) << side;
    EXPECT_NEAR(mechanism.rotation[0], mechanism.rotation[1], 1e-12) << side;
  }
}

TEST(Determinacy, DirectionsHaveEightNames) {
  EXPECT_EQ(direction_word({1, 0.1}), "to the right");
  EXPECT_EQ(direction_word({-1, 0.1}), "to the left");
  EXPECT_EQ(direction_word({0.1, 1}), "up");
  EXPECT_EQ(direction_word({0.1, -1}), "down");
  EXPECT_EQ(direction_word({-1, -1}), "down and to the left");
  EXPECT_EQ(direction_word({1, 1}), "up and to the right");
}

TEST(Determinacy, RemovedBarsMakeAsManyMechanismsAndAddedOnesSelfStresses) {
  for (int seed = 1; seed <= test_scale(60); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(static_cast<unsigned>(seed));
    Structure s = random_truss(random, 12);
    const int change = seed % 3 + 1;
    if (seed % 2 == 0) {
      for (int k = 0; k < change; ++k) s.members.erase(s.members.begin() + (seed * 7 + 5 * k) % 15);
      StructureSolver solver(s);
      EXPECT_EQ(static_cast<int>(solver.determinacy().mechanisms.size()), change);
      EXPECT_EQ(solver.determinacy().indeterminacy(), 0);
      // No bar changes its length in any of them.
      for (const Mechanism& mechanism : solver.determinacy().mechanisms) {
        for (const Member& m : s.members) {
          const auto a = static_cast<std::size_t>(m.a), b = static_cast<std::size_t>(m.b);
          const Vec2 way = s.nodes[b].at - s.nodes[a].at;
          EXPECT_NEAR(dot(mechanism.displacement[b] - mechanism.displacement[a], way) / length(way), 0, 1e-9);
        }
      }
      expect_no_forces(solver);
    } else {
      for (int k = 0; k < change; ++k) s.members.push_back({k, 9 + k % 3, MemberKind::Bar, 2e11, 0.01});
      StructureSolver solver(s);
      EXPECT_EQ(solver.determinacy().indeterminacy(), change);
      const auto states = solver.self_stresses();
      ASSERT_EQ(static_cast<int>(states.size()), change);
      // Nodes that no support holds are in balance.
      for (const auto& forces : states) {
        std::vector<Vec2> sum(s.nodes.size());
        for (std::size_t i = 0; i < s.members.size(); ++i) {
          const auto a = static_cast<std::size_t>(s.members[i].a),
                     b = static_cast<std::size_t>(s.members[i].b);
          const Vec2 pull =
              forces[i].axial * (s.nodes[b].at - s.nodes[a].at) / length(s.nodes[b].at - s.nodes[a].at);
          sum[a] += pull;
          sum[b] += -pull;
        }
        for (std::size_t i = 2; i < sum.size(); ++i) EXPECT_LT(length(sum[i]), 1e-9);
      }
    }
  }
}

TEST(NullSpace, RankAgreesWithDenseQrOnRandomMatrices) {
  for (int seed = 1; seed <= test_scale(100); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(static_cast<unsigned>(seed));
    std::uniform_real_distribution<double> unit(-1, 1);
    const int rows = 1 + seed % 17, columns = 1 + (seed * 5) % 13, rank = seed % 7;
    const Eigen::MatrixXd left =
        Eigen::MatrixXd::NullaryExpr(rows, rank, [&](Eigen::Index, Eigen::Index) { return unit(random); });
    const Eigen::MatrixXd right =
        Eigen::MatrixXd::NullaryExpr(rank, columns, [&](Eigen::Index, Eigen::Index) { return unit(random); });
    const Eigen::MatrixXd a =
        rank == 0 ? Eigen::MatrixXd(Eigen::MatrixXd::Zero(rows, columns)) : left * right;
    std::vector<Entry> entries;
    for (int i = 0; i < rows; ++i)
      for (int j = 0; j < columns; ++j) entries.push_back({i, j, a(i, j)});
    const NullSpace space = null_space(rows, columns, entries, 1e-10);
    EXPECT_EQ(space.rank, std::min({rows, columns, rank}));
    EXPECT_EQ(static_cast<int>(space.basis.size()), columns - space.rank);
    for (const std::vector<double>& z : space.basis)
      EXPECT_LT((a * Eigen::VectorXd::Map(z.data(), columns)).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(NullSpace, VectorsHaveALargestEntryOfOne) {
  for (const std::vector<Entry>& row :
       {std::vector<Entry>{{0, 0, 1}, {0, 1, 5}, {0, 2, 25}}, std::vector<Entry>{{0, 0, 1}, {0, 1, 0.9}}}) {
    const int columns = static_cast<int>(row.size());
    const NullSpace space = null_space(1, columns, row, 1e-10);
    ASSERT_EQ(static_cast<int>(space.basis.size()), columns - 1);
    for (const std::vector<double>& vector : space.basis) {
      double largest = 0;
      for (const double value : vector) largest = std::max(largest, std::abs(value));
      EXPECT_NEAR(largest, 1, 1e-15) << columns;
    }
  }
}

TEST(SparseLu, SolvesLikeDenseLuBothWays) {
  for (int seed = 1; seed <= test_scale(60); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(static_cast<unsigned>(seed));
    std::uniform_real_distribution<double> unit(-1, 1);
    const int n = 1 + seed % 40;
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n);
    std::vector<Entry> entries;
    entries.reserve(6 * static_cast<std::size_t>(n));
    std::uniform_int_distribution<int> any(0, n - 1);
    for (int i = 0; i < n; ++i) entries.push_back({i, (i * 7 + 3) % n, unit(random)});
    for (int k = 0; k < 5 * n; ++k) entries.push_back({any(random), any(random), unit(random)});
    for (const Entry& e : entries) a(e.row, e.column) += e.value;
    const Eigen::FullPivLU<Eigen::MatrixXd> dense(a);
    SparseLu lu;
    if (!dense.isInvertible() || dense.rcond() < 1e-8) continue;
    ASSERT_TRUE(lu.factor(n, entries, 1e-13));
    std::vector<double> x, work;
    for (int i = 0; i < n; ++i) x.push_back(unit(random));
    const Eigen::VectorXd b = Eigen::VectorXd::Map(x.data(), n);
    std::vector<double> y = x;
    lu.solve(x, work);
    lu.solve_transposed(y, work);
    const double scale = a.cwiseAbs().sum();
    EXPECT_LT((a * Eigen::VectorXd::Map(x.data(), n) - b).norm(),
              1e-12 * scale * (1 + Eigen::VectorXd::Map(x.data(), n).norm()));
    EXPECT_LT((a.transpose() * Eigen::VectorXd::Map(y.data(), n) - b).norm(),
              1e-12 * scale * (1 + Eigen::VectorXd::Map(y.data(), n).norm()));
  }
}

TEST(SparseLu, SingularMatrixIsRefused) {
  SparseLu lu;
  EXPECT_FALSE(lu.factor(2, {{0, 0, 1}, {0, 1, 2}, {1, 0, 2}, {1, 1, 4}}, 1e-12));
  EXPECT_FALSE(lu.factor(2, {{0, 0, 1}}, 1e-12));
  EXPECT_TRUE(lu.factor(0, {}, 1e-12));
}

TEST(Structure, WrongDataIsRefusedWithItsNumber) {
  const auto message = [](const auto&... what) {
    try {
      validate(what...);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  Structure s;
  s.nodes = {{{0, 0}}, {{0, 0}}, {{1, 0}}};
  s.members = {{0, 2}};
  EXPECT_EQ(message(s), "");
  s.members = {{0, 3}};
  EXPECT_EQ(message(s), "member 1: no node 4, there are 3");
  s.members = {{0, 1}};
  EXPECT_EQ(message(s), "member 1: its ends must be apart, got a length of 0");
  s.members = {{0, 2, MemberKind::Bar, -5}};
  EXPECT_EQ(message(s), "member 1: modulus must not be negative, got -5");
  s.members = {{0, 2, MemberKind::Bar, kInfinity}};
  EXPECT_EQ(message(s), "member 1: modulus must be finite, got inf");
  s.members = {{0, 2, MemberKind::Bar, 2e11, kInfinity}};
  EXPECT_EQ(message(s), "member 1: area must be finite, got inf");
  s.members = {};
  s.supports = {{0}, {0}};
  EXPECT_EQ(message(s), "support 2: node 1 has a support already");
  s.supports = {{0}, {2, SupportKind::Roller, kInfinity}};
  EXPECT_EQ(message(s), "support 2: angle must be finite, got inf");
  s.members = {{0, 2}};
  EXPECT_EQ(message(s, Load{{{0, {kInfinity, 0}}}, {}, {}}), "load 1: force must be finite, got (inf, 0)");
  EXPECT_EQ(message(s, Load{{{0, {}, kInfinity}}, {}, {}}), "load 1: moment must be finite, got inf");
  EXPECT_EQ(message(s, Load{{}, {{0, 0.5, {0, kInfinity}}}, {}}),
            "span load 1: force must be finite, got (0, inf)");
  EXPECT_EQ(message(s, Load{{}, {}, {{0, {kInfinity, 0}}}}),
            "line load 1: force_per_length must be finite, got (inf, 0)");
  s.nodes[1].at.x = std::nan("");
  EXPECT_EQ(message(s), "node 2: position must be finite, got nan, 0");
  StructureSolver solver(pratt(3));
  Load load;
  load.nodes.push_back({0, {0, 0}, 5});
  EXPECT_THROW(solver.solve(load), std::invalid_argument);
  load.nodes = {{99, {0, 0}}};
  EXPECT_THROW(solver.solve(load), std::invalid_argument);
}

}  // namespace determinacy_test
}  // namespace skerry::statics::test
