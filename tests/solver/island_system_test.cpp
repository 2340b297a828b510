// SPDX-License-Identifier: MIT
#include "physics/islands/island_system.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "physics/import.h"
#include "physics/islands/delassus.h"
#include "tests/support/draw.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace island_system_test {

TEST(IslandSystem, RowVelocitiesByBodiesAgreeWithTheDelassusMatrix) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    const IslandSystem system = scenes::mixed_island(seed);
    const ContactProblem problem = contact_problem(system);
    std::mt19937_64 random(seed);
    std::vector<double> lambda(system.rows.size());
    for (double& impulse : lambda) impulse = std::normal_distribution<double>()(random);
    const std::vector<double> by_bodies = row_velocities(system, lambda),
                              by_matrix = row_velocities(problem, lambda);
    const std::vector<double> diagonal = inverse_effective_masses(system);
    for (std::size_t i = 0; i < lambda.size(); ++i) {
      ASSERT_NEAR(by_bodies[i], by_matrix[i], 1e-12) << "seed " << seed;
      ASSERT_NEAR(diagonal[i], problem.W.coeff(static_cast<int>(i), static_cast<int>(i)), 1e-13)
          << "seed " << seed;
      for (std::size_t j = 0; j < i; ++j) {
        const int p = static_cast<int>(i), q = static_cast<int>(j);
        ASSERT_EQ(problem.W.coeff(p, q), problem.W.coeff(q, p)) << "seed " << seed;
      }
    }
    ASSERT_NEAR(natural_map_residual(system, lambda), natural_map_residual(problem, lambda), 1e-11);
  }
}

TEST(IslandSystem, ResidualIsTheNaturalMapByItsFormula) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    const IslandSystem system = scenes::mixed_island(seed);
    std::mt19937_64 random(seed);
    std::vector<double> lambda(system.rows.size());
    for (double& impulse : lambda) impulse = std::normal_distribution<double>()(random);
    const std::vector<double> w = row_velocities(system, lambda), D = inverse_effective_masses(system);
    double worst = 0;
    for (std::size_t i = 0; i < lambda.size(); ++i) {
      const Row& row = system.rows[i];
      const double bound = row.normal >= 0 ? row.mu * std::max(0.0, lambda[row.normal]) : 0;
      const double lower = row.normal >= 0 ? -bound : row.lower, upper = row.normal >= 0 ? bound : row.upper;
      worst = std::max(worst, D[i] * std::abs(lambda[i] - std::clamp(lambda[i] - w[i] / D[i], lower, upper)));
    }
    ASSERT_NEAR(natural_map_residual(system, lambda) * largest_magnitude(system.b), worst, 1e-12)
        << "seed " << seed;
  }
}

TEST(IslandSystem, ResidualOfABoxAtRestIsZeroAtItsWeightAndOneWithoutSupport) {
  const IslandSystem system = scenes::box_on_floor().system;
  const double half = 0.5 * 10.0 / 60;
  EXPECT_NEAR(natural_map_residual(system, {half, 0, half, 0}), 0, 1e-16);
  EXPECT_DOUBLE_EQ(natural_map_residual(system, {0, 0, 0, 0}), 1);
  EXPECT_GT(natural_map_residual(system, {-half, 0, half, 0}), 0.1);
}

TEST(IslandSystem, ResidualOfARowThatNothingMovesCountsItsUnexplainedVelocity) {
  IslandSystem system;
  system.bodies.resize(1);
  Row row;
  row.b = 0;
  row.Jb = {0, 1, 0};
  row.upper = kInfinity;
  system.rows.push_back(row);
  system.b = {-2};  // separates: lambda = 0 explains it
  EXPECT_EQ(natural_map_residual(system, {0}), 0);
  system.b = {2};  // approaches, and no impulse can stop it
  EXPECT_EQ(natural_map_residual(system, {0}), 1);
}

TEST(IslandSystem, ValidateNamesTheRowAndTheValue) {
  const IslandSystem good = scenes::box_on_floor().system;
  EXPECT_NO_THROW(validate(good));
  const auto message = [&](auto&& spoil) -> std::string {
    IslandSystem bad = good;
    spoil(bad);
    try {
      validate(bad);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(message([](auto& s) { s.rows[2].b = 7; }), testing::HasSubstr("row 2"));
  EXPECT_THAT(message([](auto& s) { s.rows[1].normal = 3; }), testing::HasSubstr("row 1"));
  EXPECT_THAT(message([](auto& s) { s.rows[3].mu = -1; }), testing::HasSubstr("-1"));
  EXPECT_THAT(message([](auto& s) { s.rows[0].lower = -2; }), testing::HasSubstr("-2"));
  EXPECT_THAT(message([](auto& s) { s.b[1] = std::nan(""); }), testing::HasSubstr("row 1"));
  EXPECT_THAT(message([](auto& s) { s.b.pop_back(); }), testing::HasSubstr("got 3"));
  EXPECT_THAT(message([](auto& s) { s.bodies[0].linear = -1; }), testing::HasSubstr("body 0"));
  EXPECT_THAT(message([](auto& s) { s.rows[0].Jb[1] = kInfinity; }), testing::HasSubstr("row 0"));
  // A normal row of a normal row would be looked up by nobody, or far away.
  EXPECT_THAT(message([](auto& s) { s.rows[2].normal = 0; }), testing::HasSubstr("row 2: only friction"));
  EXPECT_THAT(message([](auto& s) { s.rows[0].normal = 99999; }), testing::HasSubstr("got 99999"));
  EXPECT_THAT(message([](auto& s) { s.rows[1].Jb[0] = 1e160; }),
              testing::HasSubstr("row 1: J M^-1 J' must be finite, got inf"));
}

TEST(FactorPattern, MinimumDegreeFillsLessThanTheNaturalOrderOnAPyramid) {
  const IslandSystem system = scenes::pyramid(8).system;
  const FactorPattern natural = factor_pattern(system, Ordering::Natural);
  const FactorPattern ordered = factor_pattern(system, Ordering::ApproximateMinimum);
  EXPECT_GE(natural.fill, 1);
  EXPECT_LT(ordered.fill, natural.fill);
  std::vector<char> seen(system.rows.size(), 0);
  for (const int row : ordered.order) seen[row] = 1;
  EXPECT_EQ(std::count(seen.begin(), seen.end(), 1), system.size());
  for (std::size_t k = 0; k < ordered.row.size(); ++k) ASSERT_GT(ordered.row[k], ordered.column[k]);
  // Redundant contacts: only the raise of the diagonal keeps the condition finite.
  EXPECT_GT(ordered.condition, 1e8);
}

TEST(FactorPattern, AChainHasNoFillInItsNaturalOrder) {
  const FactorPattern pattern = factor_pattern(scenes::chain(50).system, Ordering::Natural);
  EXPECT_EQ(pattern.fill, 1);
  EXPECT_EQ(pattern.row.size(), 48u);
}

TEST(ResidualFloor, CountsWhatComplianceGives) {
  IslandSystem system;
  system.bodies = {{1, 1}};
  Row row;
  row.b = 0;
  row.Jb = {0, 1, 0};
  system.rows = {row};
  system.b = {1};
  system.compliance = {0};
  // Never below a rounding of what is wanted.
  EXPECT_EQ(residual_floor(system, {1e-3}), residual_floor(system, {0}));
  EXPECT_DOUBLE_EQ(residual_floor(system, {1e3}), 1e3 * residual_floor(system, {0}));
  system.compliance = {1e6};
  EXPECT_DOUBLE_EQ(residual_floor(system, {1e3}), (1e9 + 1e3) * residual_floor(system, {0}));
}

TEST(ClampAndJudge, ShowsVelocitiesThatAreNoNumbers) {
  IslandSystem system;
  system.bodies = {{10, 10}, {10, 10}};
  for (int k = 0; k < 2; ++k) {
    Row row;
    row.a = k - 1;
    row.b = k;
    if (k > 0) row.Ja = {0, -1, 0};
    row.Jb = {0, 1, 0};
    system.rows.push_back(row);
    system.b.push_back(1);
  }
  std::vector<double> lambda{1e308, 1e308};
  EXPECT_FALSE(clamp_and_judge(system, lambda) <= 1);
}

/// Rows between bodies that follow each other.
IslandSystem path_of_rows(int rows, test::Draw& draw) {
  IslandSystem system;
  for (int k = 0; k <= rows; ++k) system.bodies.push_back({draw.uniform(0.5, 2), draw.uniform(0.5, 2)});
  for (int k = 0; k < rows; ++k) {
    Row row;
    row.kind = RowKind::Motor;
    row.a = k;
    row.b = k + 1;
    row.Ja = {draw.uniform(-1, 1), 1, draw.uniform(-1, 1)};
    row.Jb = {draw.uniform(-1, 1), -1, draw.uniform(-1, 1)};
    row.lower = -2;
    row.upper = 2;
    system.rows.push_back(row);
    system.b.push_back(draw.uniform(-1, 1));
  }
  return system;
}

TEST(ClampAndJudge, SeesWhatIsNearlyAPathForWhatItIs) {
  // Somewhere along a path there is a row back to an earlier body, one whose bounds another row scales, or
  // one between two bodies that do not move.
  for (unsigned seed = 1; seed <= 300; ++seed) {
    test::Draw draw(seed);
    const int n = seed % 2 == 0 ? 6 : 16 + draw.pick(9), what = static_cast<int>(seed / 2 % 3);
    IslandSystem system = path_of_rows(n, draw);
    std::vector<double> lambda(static_cast<std::size_t>(n));
    for (double& impulse : lambda) impulse = draw.uniform(-1, 1);
    const int at = 2 + draw.pick(n - 3);
    Row& row = system.rows[static_cast<std::size_t>(at)];
    if (what == 0) {
      row.b = draw.pick(at);
      if (at + 1 < n) system.rows[static_cast<std::size_t>(at) + 1].a = row.b;
    } else if (what == 1) {
      row.kind = RowKind::Friction;
      row.normal = draw.pick(at);
      system.rows[static_cast<std::size_t>(row.normal)].kind = RowKind::Normal;
      row.mu = 0.1;
    } else {
      for (const int body : {row.a, row.b}) system.bodies[static_cast<std::size_t>(body)] = {0, 0};
      system.b[static_cast<std::size_t>(at)] = 7;
    }
    std::vector<double> clamped = lambda;
    const double residual = clamp_and_judge(system, clamped);
    ASSERT_EQ(residual, natural_map_residual(system, clamped)) << "seed " << seed;
    for (std::size_t i = 0; i < lambda.size(); ++i) {
      const Row& one = system.rows[i];
      const ImpulseBounds bounds =
          impulse_bounds(one, one.normal < 0 ? 0 : clamped[static_cast<std::size_t>(one.normal)]);
      ASSERT_EQ(clamped[i], std::clamp(lambda[i], bounds.lower, bounds.upper)) << "seed " << seed;
    }
  }
}

TEST(ClampAndJudge, SaysOfTheSmallestWhatTheNaturalMapSays) {
  // Below the least scale residuals are absolute, on any path.
  for (const int n : {4, 20}) {
    for (const double size : {1.0, 1e-279, 1e-281, 1e-300}) {
      test::Draw draw(static_cast<unsigned>(n));
      IslandSystem system = path_of_rows(n, draw);
      system.b.assign(system.b.size(), size);
      std::vector<double> lambda(system.b.size(), 0.0);
      EXPECT_EQ(clamp_and_judge(system, lambda), natural_map_residual(system, lambda)) << n << ", " << size;
    }
  }
}

TEST(ClampAndJudge, ShowsWhatIsNoNumberWhereverItIs) {
  // One impulse is given, and nothing is wrong with its row; the velocities beside it are no numbers.
  for (const int n : {6, 24}) {
    for (int at = 1; at + 1 < n; ++at) {
      test::Draw draw(static_cast<unsigned>(at));
      IslandSystem system = path_of_rows(n, draw);
      std::vector<double> lambda(static_cast<std::size_t>(n), 0.0);
      for (const int body : {at, at + 1}) system.bodies[static_cast<std::size_t>(body)] = {100, 100};
      Row& row = system.rows[static_cast<std::size_t>(at)];
      row.lower = row.upper = lambda[static_cast<std::size_t>(at)] = 1e308;
      for (const int beside : {at - 1, at + 1}) {
        Row& other = system.rows[static_cast<std::size_t>(beside)];
        other.Ja = other.Jb = {1, -1, 0};
      }
      row.Ja = row.Jb = {1, 1, 0};
      EXPECT_FALSE(clamp_and_judge(system, lambda) <= 1) << n << " " << at;
    }
  }
}

TEST(ClampAndJudge, SaysInfinityForMoreThanIsWanted) {
  test::Draw draw(2);
  IslandSystem system = path_of_rows(8, draw);
  system.compliance.assign(8, 0.1);
  std::vector<double> lambda(8, 0.3);
  const double residual = clamp_and_judge(system, lambda);
  ASSERT_GT(residual, 0.1);
  EXPECT_EQ(clamp_and_judge(system, lambda, residual), residual);
  EXPECT_EQ(clamp_and_judge(system, lambda, 0.5 * residual), kInfinity);
  EXPECT_EQ(clamp_and_judge(system, lambda, 0), kInfinity);
}

TEST(FactorPattern, ConditionIsThatOfTheOneNorm) {
  // The estimate is never above it, and seldom much below.
  double least = 1;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    IslandSystem system =
        scenes::random_island({.bodies = 4, .contacts = 6, .pins = 2}, {.friction = 0.3, .seed = seed})
            .system;
    system.compliance.assign(system.rows.size(), 0.01);
    Eigen::MatrixXd W(delassus(system));
    W.diagonal() *= 1 + 1e-10;
    const double exact =
        W.cwiseAbs().colwise().sum().maxCoeff() * W.inverse().cwiseAbs().colwise().sum().maxCoeff();
    const double estimate = factor_pattern(system, Ordering::ApproximateMinimum).condition;
    ASSERT_LE(estimate, exact * (1 + 1e-6)) << "seed " << seed;
    least = std::min(least, estimate / exact);
  }
  EXPECT_GT(least, 0.5);
}

TEST(ResidualFloor, OfAMatrixCountsSizesAndIsNoLessThanARounding) {
  ContactProblem problem;
  problem.W.resize(2, 2);
  problem.W.insert(0, 0) = problem.W.insert(1, 1) = 2;
  problem.W.insert(0, 1) = problem.W.insert(1, 0) = -1;
  problem.rows.resize(2);
  problem.b = {0.5, -4};
  EXPECT_DOUBLE_EQ(residual_floor(problem, {8, 16}), kRoundingUnit * (8 + 32) / 4);
  EXPECT_DOUBLE_EQ(residual_floor(problem, {-8, 16}), kRoundingUnit * (8 + 32) / 4);
  EXPECT_DOUBLE_EQ(residual_floor(problem, {1e-3, 0}), kRoundingUnit);
  problem.b = {0, 0};
  EXPECT_DOUBLE_EQ(residual_floor(problem, {8, 16}), kRoundingUnit * 40);
}

TEST(IslandSystem, ResidualOfAMatrixShowsWhatIsNoNumber) {
  ContactProblem problem;
  problem.W.resize(3, 3);
  for (const int i : {0, 1, 2}) problem.W.insert(i, i) = 1;
  problem.rows.resize(3);
  problem.b = {0, 1, 0};
  EXPECT_EQ(natural_map_residual(problem, {0, 0, 0}), 1);
  EXPECT_TRUE(std::isnan(natural_map_residual(problem, {0, NAN, 0})));
  EXPECT_NO_THROW(validate(problem));
  problem.W.coeffRef(1, 1) = NAN;
  EXPECT_THROW(validate(problem), std::invalid_argument);
}

}  // namespace island_system_test
}  // namespace skerry
