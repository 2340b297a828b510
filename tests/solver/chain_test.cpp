// SPDX-License-Identifier: MIT
//
// Chains without friction: random ones on a bent line, with gaps, the ground and walls, light and heavy
// discs.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <numeric>
#include <random>

#include "physics/solver/solver.h"
#include "tests/solver/enumeration.h"
#include "tests/support/island_scenes.h"
#include "tests/support/scale.h"

namespace skerry {
namespace chain_test {

struct Chance {
  explicit Chance(unsigned seed) : random(seed) {}
  double real(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }
  bool one_in(int n) { return std::uniform_int_distribution<int>(1, n)(random) == 1; }
  std::mt19937_64 random;
};

/// Row between two neighbours, -1 the ground. @param angle  of its normal @param turn  arm about both centres
Row link(int a, int b, double angle, double turn) {
  Row row;
  row.a = a;
  row.b = b;
  if (a >= 0) row.Ja = {-std::cos(angle), -std::sin(angle), turn};
  row.Jb = {std::cos(angle), std::sin(angle), turn};
  return row;
}

// `bend`: how far a normal may turn from the one before [rad]; above 90 degrees discs push each other back.
IslandSystem random_chain(int discs, double mass_ratio, double bend, Chance& chance) {
  IslandSystem system;
  for (int k = 0; k < discs; ++k) {
    const double mass = std::pow(mass_ratio, chance.real(0, 1));
    const bool wall = chance.one_in(12);
    system.bodies.push_back(wall ? InverseMass{} : InverseMass{1 / mass, 8 / mass});
  }
  double angle = chance.real(0, 6);
  for (int k = chance.one_in(2) ? -1 : 0; k + 1 < discs; ++k) {
    if (chance.one_in(15)) continue;
    angle += chance.real(-bend, bend);
    const bool wall = k < 0 || system.bodies[static_cast<std::size_t>(k)].linear == 0;
    if (wall && system.bodies[static_cast<std::size_t>(k) + 1].linear == 0) continue;
    // Off-centre now and then, so that discs turn.
    system.rows.push_back(link(k, k + 1, angle, chance.one_in(4) ? chance.real(-0.2, 0.2) : 0));
    system.b.push_back(chance.one_in(8) ? 0 : chance.real(-1, 1));
  }
  return system;
}

Solution solve_chain(const IslandSystem& system) {
  return find_solver("tridiagonal").solve(system, {}, {}, nullptr);
}

// The same island with other numbers for bodies and another order of rows.
IslandSystem shuffled(const IslandSystem& system, std::vector<std::size_t>& row_of, Chance& chance) {
  std::vector<int> body_of(system.bodies.size());
  std::iota(body_of.begin(), body_of.end(), 0);
  std::shuffle(body_of.begin(), body_of.end(), chance.random);
  row_of.resize(system.rows.size());
  std::iota(row_of.begin(), row_of.end(), 0);
  std::shuffle(row_of.begin(), row_of.end(), chance.random);
  IslandSystem other;
  other.bodies.resize(system.bodies.size());
  for (std::size_t k = 0; k < body_of.size(); ++k)
    other.bodies[static_cast<std::size_t>(body_of[k])] = system.bodies[k];
  for (const std::size_t i : row_of) {
    Row row = system.rows[i];
    row.a = row.a < 0 ? -1 : body_of[static_cast<std::size_t>(row.a)];
    row.b = body_of[static_cast<std::size_t>(row.b)];
    other.rows.push_back(row);
    other.b.push_back(system.b[i]);
  }
  return other;
}

TEST(Chains, AreAnsweredAsEnumerationSays) {
  for (unsigned seed = 1; seed <= static_cast<unsigned>(test_scale(300)); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Chance chance(seed);
    const IslandSystem system =
        random_chain(2 + static_cast<int>(seed % 9), 100, seed % 3 == 0 ? 2 : 0.5, chance);
    if (system.rows.empty()) continue;
    const Enumeration oracle(system);
    if (oracle.solutions().empty()) continue;  // between walls that approach
    const Solution solution = solve_chain(system);
    ASSERT_EQ(solution.status, SolveStatus::Solved);
    ASSERT_LE(oracle.distance(solution.lambda), 1e-9);
  }
}

TEST(Chains, ThatOnlyPushTakeOnePassInAnyOrderOfRowsAndBodies) {
  int dense = 0;
  for (unsigned seed = 1; seed <= static_cast<unsigned>(test_scale(300)); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Chance chance(seed);
    IslandSystem system = random_chain(2 + static_cast<int>(seed % 60), seed % 2 ? 1 : 1e4, 0.7, chance);
    for (InverseMass& body : system.bodies)
      if (body.linear == 0) body = {1, 8};  // walls may leave rows that depend on each other
    if (system.rows.empty()) continue;
    for (Row& row : system.rows) row.Ja[2] = row.Jb[2] = 0;
    const Solution solution = solve_chain(system);
    ASSERT_EQ(solution.status, SolveStatus::Solved);
    EXPECT_EQ(solution.iterations, 1);
    // Judged from the definition, whatever the way.
    EXPECT_EQ(solution.residual, natural_map_residual(system, solution.lambda));
    std::vector<std::size_t> row_of;
    const IslandSystem other = shuffled(system, row_of, chance);
    const Solution same = solve_chain(other);
    ASSERT_EQ(same.status, SolveStatus::Solved);
    EXPECT_EQ(same.iterations, 1);
    const double scale = largest_magnitude(solution.lambda);
    for (std::size_t i = 0; i < row_of.size(); ++i)
      ASSERT_NEAR(same.lambda[i], solution.lambda[row_of[i]], 1e-9 * scale);
    const auto pressing = static_cast<std::size_t>(
        std::count_if(solution.lambda.begin(), solution.lambda.end(), [](double x) { return x > 0; }));
    if (2 * pressing > system.rows.size()) ++dense;
  }
  EXPECT_GT(dense, 50) << "hardly any long runs";
}

TEST(Chains, GiveTheSameBitsFourRowsAtATimeAndOneByOne) {
  for (unsigned seed = 1; seed <= static_cast<unsigned>(test_scale(500)); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Chance chance(seed);
    IslandSystem system;
    double angle = chance.real(0, 6);
    const int discs = 13 + static_cast<int>(seed % 50);
    for (int k = 0; k < discs; ++k) system.bodies.push_back({chance.real(0.1, 10), chance.real(0.1, 10)});
    for (int k = seed % 2 ? -1 : 0; k + 1 < discs; ++k) {
      angle += chance.real(-0.3, 0.3);
      system.rows.push_back(link(k, k + 1, angle, chance.one_in(4) ? chance.real(-0.1, 0.1) : 0));
      system.b.push_back(chance.real(seed % 3 ? -1 : 0, 1));
    }
    const Solution together = solve_chain(system);
    ASSERT_EQ(together.status, SolveStatus::Solved);
    ASSERT_EQ(together.iterations, 1);
    ASSERT_EQ(together.residual, natural_map_residual(system, together.lambda));
    // A pair of discs apart from the others is no part of their path.
    IslandSystem apart = system;
    apart.bodies.insert(apart.bodies.end(), 2, {1, 1});
    Row row = system.rows.back();
    row.a = discs;
    row.b = discs + 1;
    apart.rows.push_back(row);
    apart.b.push_back(0);
    const Solution one_by_one = solve_chain(apart);
    ASSERT_EQ(one_by_one.iterations, 1);
    for (std::size_t i = 0; i < system.rows.size(); ++i)
      ASSERT_EQ(together.lambda[i], one_by_one.lambda[i]) << i;
    ASSERT_EQ(one_by_one.residual, together.residual);
    // Any impulses within the bounds.
    std::vector<double> lambda(system.rows.size());
    for (double& x : lambda) x = chance.one_in(4) ? 0 : chance.real(0, 1);
    const std::vector<double> before = lambda;
    ASSERT_EQ(clamp_and_judge(system, lambda), natural_map_residual(system, before));
    ASSERT_EQ(lambda, before);
  }
}

TEST(Chains, OneThatPressesAllAlongHasTheImpulsesOfOneSolve) {
  // One disc of speed 1 hits n - 1 at rest: all end at 1/n, and row k brings n - k of them there.
  for (const int count : {2, 3, 4, 5, 6, 7, 8, 9, 100, 1001}) {
    const IslandSystem system = scenes::chain(count).system;
    const double mass = 1 / system.bodies[0].linear;
    const Solution solution = solve_chain(system);
    ASSERT_EQ(solution.status, SolveStatus::Solved);
    for (int k = 0; k + 1 < count; ++k)
      ASSERT_NEAR(solution.lambda[static_cast<std::size_t>(k)], mass * (count - 1 - k) / count, 1e-12)
          << count;
  }
}

TEST(Chains, OfDependentRowsHaveAnAnswerWhereThereIsOne) {
  // A disc between walls: both push it, or neither need.
  IslandSystem system;
  system.bodies = {{0, 0}, {1, 1}, {0, 0}};
  for (const int a : {0, 1}) {
    Row row;
    row.a = a;
    row.b = a + 1;
    row.Ja = {-1, 0, 0};
    row.Jb = {1, 0, 0};
    system.rows.push_back(row);
  }
  for (const auto& [left, right] :
       {std::pair{1.0, -1.0}, {-1.0, 1.0}, {-1.0, -1.0}, {0.5, -2.0}, {0.0, 0.0}}) {
    system.b = {left, right};
    const Solution solution = solve_chain(system);
    EXPECT_EQ(solution.status, SolveStatus::Solved) << left << ", " << right;
    EXPECT_LE(natural_map_residual(system, solution.lambda), 1e-12);
  }
  system.b = {1, 1};  // nothing helps
  EXPECT_NE(solve_chain(system).status, SolveStatus::Solved);
}

TEST(Chains, AreJudgedByOnePassAsByTheDefinitionBitForBit) {
  const int count = test_scale(500);
  int wrong = 0;
  for (unsigned seed = 1; seed <= static_cast<unsigned>(count); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Chance chance(seed);
    IslandSystem system = random_chain(2 + static_cast<int>(seed % 40), 1e3, 3, chance);
    if (system.rows.empty()) continue;
    for (Row& row : system.rows)
      if (chance.one_in(4)) {
        row.kind = RowKind::Motor;
        row.lower = chance.one_in(2) ? -kInfinity : chance.real(-1, 0);
        row.upper = chance.real(0, 1);
      }
    if (seed % 7 == 0) system.compliance.assign(system.rows.size(), 0.1);
    std::vector<double> lambda(system.rows.size());
    for (double& x : lambda)
      x = chance.one_in(5) ? 0 : chance.one_in(200) ? std::nan("") : chance.real(-1, 2);
    std::vector<double> clamped = lambda;
    const double residual = clamp_and_judge(system, clamped);
    if (residual > 1e-3) ++wrong;
    for (std::size_t i = 0; i < lambda.size(); ++i) {
      const double finite = std::isfinite(lambda[i]) ? lambda[i] : 0;
      ASSERT_EQ(clamped[i], std::clamp(finite, system.rows[i].lower, system.rows[i].upper));
    }
    ASSERT_EQ(residual, natural_map_residual(system, clamped));
  }
  EXPECT_GT(wrong, 9 * count / 10) << "impulses at random are no answer";
}

TEST(Chains, AJudgeSeesOneWrongImpulseInAThousand) {
  IslandSystem system = scenes::chain(1001, {.noise = 1}).system;
  const Solution solution = solve_chain(system);
  ASSERT_LE(solution.residual, 1e-12);
  for (std::size_t i = 0; i < system.rows.size(); i += 37) {
    std::vector<double> wrong = solution.lambda;
    wrong[i] += 1e-3;
    EXPECT_GT(clamp_and_judge(system, wrong), 1e-5) << "row " << i;
  }
}

TEST(Chains, OfFacesThatMeetAtTwoPointsAreAnswered) {
  // Two rows of a pair of bodies are coupled through both of them, in whatever order they come.
  for (const int pairs : {1, 2}) {
    for (const bool backwards : {false, true}) {
      IslandSystem system;
      system.bodies = {{1, 6}, {0.5, 2}, {1, 6}, {2, 3}};
      if (pairs == 1) system.bodies.resize(2);
      for (const double x : {-0.5, 0.4}) {
        for (int pair = 0; pair < pairs; ++pair) {
          Row row;
          row.a = 2 * pair + (backwards ? 1 : 0);
          row.b = 2 * pair + (backwards ? 0 : 1);
          row.Ja = {0, -1, -x};
          row.Jb = {0, 1, x + 0.1};
          system.rows.push_back(row);
          system.b.push_back(1 + x);
        }
      }
      const Solution solution = find_solver("tridiagonal").solve(system, {}, {}, nullptr);
      EXPECT_EQ(solution.status, SolveStatus::Solved);
      EXPECT_LT(natural_map_residual(system, solution.lambda), 1e-13);
      for (const double lambda : solution.lambda) EXPECT_GT(lambda, 0);
    }
  }
}

TEST(Chains, WithBoundsOfAllKindsAndComplianceAreAnswered) {
  for (unsigned seed = 1; seed <= 400; ++seed) {
    std::mt19937 random(seed);
    const auto real = [&](double low, double high) { return low + (high - low) * (random() / 4294967296.0); };
    IslandSystem system;
    const int discs = 2 + static_cast<int>(seed % 30);
    for (int k = 0; k < discs; ++k) system.bodies.push_back({real(0.1, 2), real(0.1, 2)});
    std::vector<Row> rows;
    for (int k = -1; k + 1 < discs; ++k) {
      Row row;
      row.kind = RowKind::Joint;
      row.a = k;
      row.b = k + 1;
      const double angle = real(0, 6), turn = real(-0.3, 0.3);
      if (k >= 0) row.Ja = {-std::cos(angle), -std::sin(angle), turn};
      row.Jb = {std::cos(angle), std::sin(angle), turn};
      const int bounds = static_cast<int>(random() % 5);
      if (bounds == 0 || bounds == 3) row.lower = -kInfinity;
      if (bounds == 1) {
        row.lower = real(-0.2, 0.2);
        row.upper = row.lower + real(0, 0.5);
      }
      if (bounds == 2) row.lower = row.upper = real(-0.5, 0.5);
      if (bounds == 3) row.upper = real(-0.2, 0.2);
      rows.push_back(row);
      system.b.push_back(real(-1, 1));
    }
    // Each second one in another order.
    for (std::size_t k = rows.size(); seed % 2 == 0 && k > 1; --k) std::swap(rows[k - 1], rows[random() % k]);
    system.rows = rows;
    for (std::size_t k = 0; seed % 3 == 0 && k < rows.size(); ++k) system.compliance.push_back(real(0, 0.5));
    std::unique_ptr<SolverMemory> memory;
    for (int again = 0; again < 3; ++again) {
      const Solution solution = find_solver("tridiagonal").solve(system, {}, {}, &memory);
      EXPECT_EQ(solution.status, SolveStatus::Solved) << "seed " << seed << ", " << again;
      EXPECT_LT(natural_map_residual(system, solution.lambda), 1e-12) << "seed " << seed << ", " << again;
      EXPECT_LE(solution.iterations, 30) << "seed " << seed << ", " << again;
      for (double& b : system.b) b += again == 0 ? 0 : real(-0.2, 0.2);
    }
  }
}

TEST(Chains, OfContradictingRowsAreTold) {
  IslandSystem system;
  system.bodies = {{1, 0}};
  for (const double wanted : {1.0, 2.0}) {
    Row row;
    row.b = 0;
    row.kind = RowKind::Joint;
    row.lower = -kInfinity;
    row.Jb = {0, 1, 0};
    system.rows.push_back(row);
    system.b.push_back(wanted);
  }
  const Solution solution = find_solver("tridiagonal").solve(system, {}, {}, nullptr);
  EXPECT_EQ(solution.status, SolveStatus::Singular);
  EXPECT_EQ(solution.lambda, (std::vector<double>{0, 0}));
}

TEST(Chains, ThatAreRingsAreLeftToOthers) {
  IslandSystem system;
  system.bodies = {{1, 1}, {1, 1}, {1, 1}, {1, 1}};
  for (int k = 0; k < 4; ++k) {
    const Vec2 along = k % 2 == 0 ? Vec2{1, 0} : Vec2{0, 1};
    Row row;
    row.a = k;
    row.b = (k + 1) % 4;
    row.Ja = {-along.x, -along.y, 0.1};
    row.Jb = {along.x, along.y, 0.1};
    system.rows.push_back(row);
    system.b.push_back(1);
  }
  EXPECT_EQ(find_solver("tridiagonal").solve(system, {}, {}, nullptr).status, SolveStatus::Unsupported);
}

}  // namespace chain_test
}  // namespace skerry
