// SPDX-License-Identifier: MIT
//
// Sweeps over blocks: four of them side by side give the bits of one after the other, and blocks of joints
// what the rows of their joints want.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <set>

#include "physics/solver/block_sweeps.h"
#include "physics/solver/solver.h"
#include "physics/solver/sweep_levels.h"

namespace skerry {
namespace {

/// Rows of one block on bodies `a` and `b` (-1: the ground).
std::vector<Row> random_block(std::mt19937& random, int a, int b) {
  std::uniform_real_distribution<double> number(-1, 1);
  const int points = 1 + static_cast<int>(random() % 2);
  const bool rough = random() % 3 != 0, rolls = points == 1 && random() % 4 == 0;
  std::vector<Row> rows;
  for (int i = 0; i < points; ++i) {
    const int normal = static_cast<int>(rows.size());
    for (const RowKind kind : {RowKind::Normal, RowKind::Friction, RowKind::Rolling}) {
      if ((kind == RowKind::Friction && !rough) || (kind == RowKind::Rolling && !rolls)) continue;
      Row row;
      row.kind = kind;
      row.a = a;
      row.b = b;
      for (double& x : row.Ja) x = a < 0 ? 0 : number(random);
      for (double& x : row.Jb) x = b < 0 ? 0 : number(random);
      if (kind != RowKind::Normal) {
        row.lower = row.upper = 0;
        row.normal = normal;
        row.mu = 0.5;
      }
      rows.push_back(row);
    }
  }
  return rows;
}

/// Rows of a joint between `a` and `b`: at least one and at most three that hold, and up to two others.
std::vector<Row> random_joint(std::mt19937& random, int a, int b, int others) {
  std::uniform_real_distribution<double> number(-1, 1);
  std::vector<Row> rows;
  const int held = 1 + static_cast<int>(random() % 3);
  for (int i = 0; i < held + others; ++i) {
    Row row;
    row.kind = i < held ? RowKind::Joint : i == held ? RowKind::Limit : RowKind::Motor;
    row.a = a;
    row.b = b;
    for (double& x : row.Ja) x = a < 0 ? 0 : number(random);
    for (double& x : row.Jb) x = b < 0 ? 0 : number(random);
    row.lower = i < held ? -kInfinity : i == held ? 0 : -0.3;
    row.upper = i <= held ? kInfinity : 0.3;
    rows.push_back(row);
  }
  // A prismatic joint has its limits first.
  if (random() % 3 == 0) std::reverse(rows.begin(), rows.end());
  // One body has three velocities, and no room for more rows that do not depend on each other.
  if (a < 0 || b < 0) rows.resize(std::min<std::size_t>(rows.size(), 3));
  return rows;
}

/// So many islands that know nothing of each other, alike to the bit, as one: the blocks of all alternate.
IslandSystem islands(unsigned seed, int count, bool joints) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  constexpr int bodies = 6, blocks = 11;
  IslandSystem system;
  std::vector<InverseMass> one;
  for (int i = 0; i < bodies; ++i) one.push_back({1 + 0.5 * number(random), 2 + number(random)});
  for (int c = 0; c < count; ++c) system.bodies.insert(system.bodies.end(), one.begin(), one.end());
  for (int k = 0; k < blocks; ++k) {
    // No two of the same bodies in a row, which would be one block.
    const int a = k % bodies, b = k % 5 == 4 ? -1 : (a + 1 + k / bodies) % bodies;
    const bool joint = joints && k % 3 != 2;
    const std::vector<Row> rows =
        joint ? random_joint(random, a, b, k % 2 == 0 ? 0 : 2) : random_block(random, a, b);
    std::vector<double> wanted;
    for (std::size_t i = 0; i < rows.size(); ++i) wanted.push_back(number(random));
    for (int c = 0; c < count; ++c) {
      const int first = system.size();
      for (std::size_t i = 0; i < rows.size(); ++i) {
        Row row = rows[i];
        if (row.a >= 0) row.a += c * bodies;
        if (row.b >= 0) row.b += c * bodies;
        if (row.normal >= 0) row.normal += first;
        system.rows.push_back(row);
        system.b.push_back(wanted[i]);
      }
    }
  }
  validate(system);
  return system;
}

std::vector<double> swept(const IslandSystem& system, int times, double& change, double& violation) {
  BlockSweeps sweeps;
  EXPECT_TRUE(sweeps.assign(system, true));
  sweeps.set({});
  for (int i = 0; i < times; ++i) change = sweeps.sweep();
  violation = sweeps.violation();
  std::vector<double> lambda;
  sweeps.get(sweeps.impulses(), lambda);
  return lambda;
}

TEST(Sweeps, SideBySideGiveTheBitsOfOneAfterTheOther) {
  constexpr int copies = 7;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    // One island is too small to be swept side by side; many are not.
    const bool joints = seed % 2 == 0;
    const IslandSystem few = islands(seed, 1, joints), many = islands(seed, copies, joints);
    for (const int times : {1, 2, 5, 40}) {
      double change = 0, changes = 0, violation = 0, violations = 0;
      const std::vector<double> one = swept(few, times, change, violation);
      const std::vector<double> all = swept(many, times, changes, violations);
      ASSERT_EQ(change, changes);
      ASSERT_EQ(violation, violations);
      // Row by row: the blocks of the copies stand side by side.
      std::size_t at = 0;
      for (std::size_t first = 0; first < one.size();) {
        std::size_t end = first + 1;
        while (end < one.size() && few.rows[end].a == few.rows[first].a &&
               few.rows[end].b == few.rows[first].b) {
          ++end;
        }
        for (int c = 0; c < copies; ++c) {
          for (std::size_t i = first; i < end; ++i) ASSERT_EQ(one[i], all[at++]);
        }
        first = end;
      }
      EXPECT_EQ(at, all.size());
    }
  }
}

/// A random block of joint rows, some compliant, between two bodies, or one and the ground.
IslandSystem one_joint(unsigned seed, int others) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-1, 1);
  IslandSystem system;
  for (int i = 0; i < 2; ++i)
    system.bodies.push_back({std::pow(10, 2 * number(random)), std::pow(10, 2 * number(random))});
  system.rows = random_joint(random, 0, seed % 3 == 0 ? -1 : 1, others);
  for (std::size_t i = 0; i < system.rows.size(); ++i) system.b.push_back(number(random));
  if (seed % 4 == 0) {
    system.compliance.assign(system.rows.size(), 0);
    system.compliance[random() % system.rows.size()] = std::pow(10, 3 * number(random));
  }
  validate(system);
  return system;
}

TEST(Sweeps, SolveAJointWithOneBoundInOneSweep) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const IslandSystem system = one_joint(seed, static_cast<int>(seed % 2));
    double change = 0, violation = 0;
    const std::vector<double> lambda = swept(system, 1, change, violation);
    EXPECT_LE(natural_map_residual(system, lambda), 1e-9 + 10 * residual_floor(system, lambda));
  }
}

TEST(Sweeps, ReportTheViolationOfTheRowsAsTheyWere) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const IslandSystem system = seed % 2 == 0 ? islands(seed, 3, true) : one_joint(seed, 2);
    for (const int times : {0, 1, 7}) {
      double change = 0, violation = 0;
      const std::vector<double> lambda = swept(system, times, change, violation);
      const double scale = largest_magnitude(system.b);
      const double wanted = natural_map_residual(system, lambda);
      EXPECT_NEAR(violation / scale, wanted, 1e-7 * wanted + 10 * residual_floor(system, lambda));
    }
  }
}

TEST(Sweeps, BeginWithTheImpulsesThatTheyAreGiven) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const IslandSystem system = islands(seed, 2, true);
    double change = 0, violation = 0;
    const std::vector<double> lambda = swept(system, 20, change, violation);
    BlockSweeps sweeps;
    ASSERT_TRUE(sweeps.assign(system, true));
    sweeps.set(lambda);
    std::vector<double> back;
    sweeps.get(sweeps.impulses(), back);
    const double largest = largest_magnitude(lambda);
    for (std::size_t i = 0; i < back.size(); ++i) EXPECT_NEAR(back[i], lambda[i], 1e-8 * largest) << i;
    EXPECT_NEAR(sweeps.violation(), violation, 1e-8 * (1 + violation));
  }
}

TEST(Sweeps, ConvergeToWhatDenseFactorsSayForJointsAndContacts) {
  // A chain of hinged rods that hangs from the ground and lies on it in places: no friction, so that
  // the velocities are unique.
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(-1, 1);
    IslandSystem system;
    const int links = 3 + static_cast<int>(random() % 6);
    for (int i = 0; i < links; ++i) system.bodies.push_back({1 + 0.5 * number(random), 3 + number(random)});
    for (int i = 0; i < links; ++i) {
      for (const int along : {0, 1}) {
        Row row;
        row.kind = RowKind::Joint;
        row.a = i - 1;
        row.b = i;
        row.lower = -kInfinity;
        const double turn = along == 0 ? 0.1 * number(random) : 0.5;
        if (i > 0) row.Ja = {along == 0 ? -1.0 : 0.0, along == 1 ? -1.0 : 0.0, -turn};
        row.Jb = {along == 0 ? 1.0 : 0.0, along == 1 ? 1.0 : 0.0, -turn};
        system.rows.push_back(row);
        system.b.push_back(number(random));
      }
    }
    for (int i = 0; i < links; i += 2) {
      Row row;
      row.b = i;
      row.Jb = {0.3 * number(random), 1, 0.2 * number(random)};
      system.rows.push_back(row);
      system.b.push_back(number(random));
    }
    double change = 0, violation = 0;
    const std::vector<double> lambda = swept(system, 4000, change, violation);
    const Solution dense = find_solver("dense_lu").solve(system, {}, {}, nullptr);
    ASSERT_EQ(dense.status, SolveStatus::Solved);
    std::vector<std::array<double, 3>> v(system.bodies.size()), wanted = v;
    apply_impulses(system, lambda, v);
    apply_impulses(system, dense.lambda, wanted);
    for (std::size_t k = 0; k < v.size(); ++k) {
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(v[k][c], wanted[k][c], 1e-7) << k;
    }
  }
}

TEST(Sweeps, GiveWhereTheyAreToldTo) {
  // Rods and contacts between three bodies, as many again as could hold: no impulse balances them unless they
  // give. What they give is a compliance of so many times the diagonal of W.
  for (unsigned seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> number(-1, 1);
    IslandSystem system;
    for (int i = 0; i < 3; ++i) system.bodies.push_back({1 + 0.5 * number(random), 2 + number(random)});
    for (int k = 0; k < 18; ++k) {
      Row row;
      row.kind = k % 2 == 0 ? RowKind::Joint : RowKind::Normal;
      row.lower = k % 2 == 0 ? -kInfinity : 0;
      row.a = k % 3;
      row.b = (k / 3 + k) % 3 == row.a ? -1 : (k / 3 + k) % 3;
      for (double& x : row.Ja) x = number(random);
      for (double& x : row.Jb) x = row.b < 0 ? 0 : number(random);
      system.rows.push_back(row);
      system.b.push_back(number(random));
    }
    BlockSweeps sweeps;
    ASSERT_TRUE(sweeps.assign(system, true));
    sweeps.soften(0.2, 0.5);
    sweeps.set({});
    for (int i = 0; i < 3000; ++i) sweeps.sweep();
    std::vector<double> lambda;
    sweeps.get(sweeps.impulses(), lambda);
    const std::vector<double> diagonal = inverse_effective_masses(system);
    for (std::size_t i = 0; i < diagonal.size(); ++i)
      system.compliance.push_back((i % 2 == 0 ? 0.2 : 0.5) * diagonal[i]);
    EXPECT_LE(natural_map_residual(system, lambda), 1e-9);
  }
}

TEST(Sweeps, LeaveJointsToThoseWhoAskForThem) {
  IslandSystem system = one_joint(1, 0);
  BlockSweeps sweeps;
  EXPECT_FALSE(sweeps.assign(system));
  EXPECT_TRUE(sweeps.assign(system, true));
  EXPECT_EQ(sweeps.rows(), system.size());
}

TEST(Sweeps, SayWhatJointsThatContradictEachOtherLeave) {
  // The same hinge twice, which wants two velocities: 1 and 3 along x.
  IslandSystem system;
  system.bodies = {{1, 1}};
  for (const double wanted : {1.0, 3.0}) {
    Row row;
    row.kind = RowKind::Joint;
    row.b = 0;
    row.Jb = {1, 0, 0};
    row.lower = -kInfinity;
    system.rows.push_back(row);
    system.b.push_back(wanted);
  }
  double change = 0, violation = 0;
  const std::vector<double> lambda = swept(system, 5, change, violation);
  EXPECT_NEAR(lambda[0] + lambda[1], 1, 1e-12);
  EXPECT_NEAR(violation, 2, 1e-12);
}

TEST(Sweeps, LevelsKeepTheOrderOfBlocksThatShareABody) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const int bodies = 2 + static_cast<int>(random() % 40), blocks = static_cast<int>(random() % 200);
    SweepLevels levels;
    levels.start(static_cast<std::size_t>(bodies), 3);
    std::vector<std::array<int, 3>> made;
    for (int k = 0; k < blocks; ++k) {
      // The ground is every number that is no body's.
      made.push_back({static_cast<int>(random() % bodies), static_cast<int>(random() % (bodies + 5)) - 2,
                      static_cast<int>(random() % 3)});
      if (made.back()[1] == made.back()[0]) made.back()[1] = -1;
      levels.add(made.back()[0], made.back()[1], made.back()[2]);
    }
    levels.finish();
    std::vector<int> place(made.size(), -1);
    std::size_t seen = 0;
    for (const SweepLevels::Run& run : levels.runs()) {
      std::set<int> touched;
      for (std::size_t i = run.begin; i < run.end; ++i) {
        const int k = levels.order()[i];
        EXPECT_EQ(made[static_cast<std::size_t>(k)][2], run.kind);
        place[static_cast<std::size_t>(k)] = static_cast<int>(seen++);
        for (int side = 0; side < 2; ++side) {
          const int body = made[static_cast<std::size_t>(k)][static_cast<std::size_t>(side)];
          EXPECT_TRUE(body < 0 || body >= bodies || touched.insert(body).second);
        }
      }
    }
    ASSERT_EQ(seen, made.size());
    for (std::size_t k = 0; k < made.size(); ++k) {
      for (std::size_t j = 0; j < k; ++j) {
        bool share = false;
        for (int x = 0; x < 2; ++x) {
          for (int y = 0; y < 2; ++y) {
            const int body = made[k][static_cast<std::size_t>(x)];
            share |= body >= 0 && body < bodies && body == made[j][static_cast<std::size_t>(y)];
          }
        }
        EXPECT_TRUE(!share || place[j] < place[k]);
      }
    }
  }
}

}  // namespace
}  // namespace skerry
