// SPDX-License-Identifier: MIT
//
// Sweeps over blocks: four of them side by side give the bits of one after the other.
#include <gtest/gtest.h>
#include <random>
#include <set>

#include "physics/solver/block_sweeps.h"
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

/// So many islands that know nothing of each other, alike to the bit, as one: the blocks of all alternate.
IslandSystem islands(unsigned seed, int count) {
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
    const std::vector<Row> rows = random_block(random, a, b);
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
  EXPECT_TRUE(sweeps.assign(system));
  sweeps.set({});
  for (int i = 0; i < times; ++i) change = sweeps.sweep();
  violation = sweeps.violation();
  std::vector<double> lambda;
  sweeps.get(sweeps.impulses(), lambda);
  return lambda;
}

TEST(Sweeps, SideBySideGiveTheBitsOfOneAfterTheOther) {
  constexpr int copies = 7;
  for (unsigned seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    // One island is too small to be swept side by side; many are not.
    const IslandSystem few = islands(seed, 1), many = islands(seed, copies);
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
