// SPDX-License-Identifier: MIT
//
// Sweeps over blocks: four of them side by side give the bits of one after the other, and blocks of joints
// what the rows of their joints want.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "physics/islands/delassus.h"
#include "physics/solver/block_sweeps.h"
#include "physics/solver/solver.h"
#include "physics/solver/sweep_order.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace sweeps_test {

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
  one.reserve(bodies);
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

struct Pair {
  int a, b, kind;
};

/// Blocks between neighbours of a row of bodies, some between far ones, and some with the ground, all of
/// which are first in every third case.
std::vector<Pair> random_pairs(unsigned seed, int bodies, int blocks) {
  std::mt19937 random(seed);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  std::vector<Pair> made;
  for (int k = 0; k < blocks; ++k) {
    Pair pair{below(20) == 0 ? below(bodies) : std::min(bodies - 1, k * bodies / blocks + below(4)), 0,
              below(3)};
    // The ground is every number that is no body's.
    pair.b = below(4) == 0 ? bodies + below(5) : std::max(-2, pair.a - 1 - below(5));
    made.push_back(pair);
  }
  if (seed % 3 == 0)
    std::stable_partition(made.begin(), made.end(), [&](const Pair& p) { return p.b < 0 || p.b >= bodies; });
  return made;
}

bool share_a_body(const Pair& p, const Pair& q, int bodies) {
  for (const int body : {p.a, p.b}) {
    if (body >= 0 && body < bodies && (body == q.a || body == q.b)) return true;
  }
  return false;
}

SweepOrder order_of(const std::vector<Pair>& pairs, int bodies, int sweeps) {
  SweepOrder order;
  std::vector<std::uint8_t> kinds;
  order.start(static_cast<std::size_t>(bodies));
  for (const Pair& pair : pairs) {
    order.add(pair.a, pair.b);
    kinds.push_back(static_cast<std::uint8_t>(pair.kind));
  }
  order.arrange(sweeps);
  order.finish(kinds, 3);
  return order;
}

TEST(Sweeps, GroupsKeepTheOrderOfBlocksThatShareABody) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const int bodies = 2 + static_cast<int>(seed * 7 % 40), blocks = static_cast<int>(seed * 37 % 900);
    const std::vector<Pair> pairs = random_pairs(seed, bodies, blocks);
    const SweepOrder order = order_of(pairs, bodies, 1 + static_cast<int>(seed % 4));
    std::vector<int> group_of(pairs.size(), -1);
    for (std::size_t g = 0; g < order.groups().size(); ++g) {
      const SweepOrder::Group& group = order.groups()[g];
      for (int i = 0; i < group.count; ++i) {
        const std::size_t k = static_cast<std::size_t>(group.block[static_cast<std::size_t>(i)]);
        EXPECT_EQ(pairs[k].kind, group.kind);
        EXPECT_EQ(group_of[k], -1);
        group_of[k] = static_cast<int>(g);
      }
    }
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      ASSERT_GE(group_of[k], 0);
      for (std::size_t j = 0; j < k; ++j) {
        EXPECT_TRUE(!share_a_body(pairs[j], pairs[k], bodies) || group_of[j] < group_of[k]);
      }
    }
  }
}

TEST(Sweeps, LevelsFillGroupsAndKeepWhatWaitsApart) {
  // A wall whose blocks are numbered by column: each hangs on the one below and on its neighbours.
  constexpr int columns = 40, rows = 40;
  std::vector<Pair> pairs;
  pairs.reserve(2 * columns * rows);
  for (int x = 0; x < columns; ++x) {
    for (int y = 0; y < rows; ++y) {
      const int body = x * rows + y;
      pairs.push_back({y > 0 ? body - 1 : -1, body, 0});
      if (x > 0) pairs.push_back({body - rows, body, 0});
    }
  }
  const auto waiting = [&](const SweepOrder& order) {
    int count = 0;
    for (std::size_t g = 1; g < order.groups().size(); ++g) {
      const SweepOrder::Group &now = order.groups()[g], &last = order.groups()[g - 1];
      bool waits = false;
      for (int i = 0; i < now.count; ++i) {
        for (int j = 0; j < last.count; ++j)
          waits |= share_a_body(pairs[static_cast<std::size_t>(now.block[static_cast<std::size_t>(i)])],
                                pairs[static_cast<std::size_t>(last.block[static_cast<std::size_t>(j)])],
                                columns * rows);
      }
      count += waits;
    }
    return count;
  };
  const SweepOrder levels = order_of(pairs, columns * rows, 1);
  const SweepOrder late = order_of(pairs, columns * rows, 4);
  EXPECT_LE(levels.groups().size(), late.groups().size());
  EXPECT_LT(4 * levels.groups().size() - pairs.size(), pairs.size() / 10);
  EXPECT_LT(waiting(levels), static_cast<int>(levels.groups().size()) / 4);
  EXPECT_GT(waiting(late), 2 * waiting(levels));
}

TEST(Sweeps, TheNextSweepWaitsForTheLastChunkWithABodyOfItsChunk) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const int bodies = 40 + static_cast<int>(seed * 31 % 300), blocks = 1500;
    const std::vector<Pair> pairs = random_pairs(seed, bodies, blocks);
    const SweepOrder order = order_of(pairs, bodies, 2 + static_cast<int>(seed % 3));
    std::vector<std::vector<Pair>> chunks;
    for (std::size_t g = 0; g < order.groups().size(); ++g) {
      if (g % SweepOrder::kChunk == 0) chunks.emplace_back();
      const SweepOrder::Group& group = order.groups()[g];
      for (int i = 0; i < group.count; ++i)
        chunks.back().push_back(pairs[static_cast<std::size_t>(group.block[static_cast<std::size_t>(i)])]);
    }
    ASSERT_EQ(order.need().size(), chunks.size());
    for (std::size_t c = 0; c < chunks.size(); ++c) {
      std::size_t last = c;
      for (std::size_t later = c + 1; later < chunks.size(); ++later) {
        for (const Pair& p : chunks[c]) {
          for (const Pair& q : chunks[later]) {
            if (share_a_body(p, q, bodies)) last = later;
          }
        }
      }
      EXPECT_EQ(order.need()[c], static_cast<int>(last)) << "chunk " << c;
    }
  }
}

TEST(Sweeps, ContactsWithTheGroundStandWithTheOthersOfTheirBodies) {
  // A row of bodies on the ground, whose contacts come first: a sweep follows the one before it closely.
  constexpr int bodies = 2000;
  std::vector<Pair> pairs;
  pairs.reserve(2 * bodies);
  for (int k = 0; k < bodies; ++k) pairs.push_back({-1, k, 0});
  for (int k = 1; k < bodies; ++k) pairs.push_back({k - 1, k, 0});
  // By levels the last contact of the row ends the sweep, and its body's first one begins it.
  for (const int sweeps : {2, 4}) {
    const SweepOrder order = order_of(pairs, bodies, sweeps);
    const int chunks = static_cast<int>(order.need().size());
    for (int c = 0; c < chunks; ++c)
      EXPECT_LE(order.need()[static_cast<std::size_t>(c)] - c, 1 + 160 / SweepOrder::kChunk) << sweeps;
  }
}

TEST(Sweeps, OfTwoThreadsGoByLevelsWhereTheyCanFollowClosely) {
  // Many short rows of bodies: levels fill groups, and end a row soon after it began.
  constexpr int rows = 400, bodies = 5 * rows;
  std::vector<Pair> pairs;
  for (int k = 0; k < bodies; ++k) {
    if (k % 5 > 0) pairs.push_back({k - 1, k, k / 5 % 3});
  }
  const std::size_t levels = order_of(pairs, bodies, 1).groups().size();
  EXPECT_LT(levels, order_of(pairs, bodies, 4).groups().size());
  // A body has two contacts, a level apart of four: its last one is at most a third of all behind.
  EXPECT_EQ(order_of(pairs, bodies, 2).groups().size(), levels);
}

TEST(Sweeps, OfThreadsThatMakeOneEachGiveTheBitsOfOneAfterTheOther) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const IslandSystem system = islands(seed, 600, seed % 2 == 0);
    for (const double give : {0.0, 0.3}) {
      std::vector<double> expected;
      double change = 0, violation = 0;
      for (const int threads : {1, 2, 3, 4, 8}) {
        ThreadPool pool(threads);
        BlockSweeps sweeps;
        ASSERT_TRUE(sweeps.assign(system, true, &pool));
        ASSERT_GT(sweeps.together(), 1);
        sweeps.soften(give, give);
        sweeps.set({});
        if (threads == 1) {
          for (int i = 0; i < 11; ++i) change = sweeps.sweep();
        } else {
          EXPECT_EQ(sweeps.sweep(11), change);
        }
        std::vector<double> lambda;
        sweeps.get(sweeps.impulses(), lambda);
        if (threads == 1) {
          expected = lambda;
          violation = sweeps.violation();
        }
        EXPECT_EQ(sweeps.violation(), violation);
        EXPECT_EQ(lambda, expected) << threads << " threads";
        // The next ones of a pool are made by one thread, to see which way is faster.
        ASSERT_TRUE(sweeps.assign(system, true, &pool));
        sweeps.soften(give, give);
        sweeps.set({});
        EXPECT_EQ(sweeps.sweep(11), change);
        sweeps.get(sweeps.impulses(), lambda);
        EXPECT_EQ(lambda, expected) << threads << " threads, alone";
      }
    }
  }
}

TEST(Sweeps, BeginWithTheVelocitiesOfTheirImpulses) {
  BlockSweeps sweeps;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    // Islands that shrink and grow again: nothing of one may be left in the next.
    const IslandSystem system = islands(seed, 1 + static_cast<int>(seed * 379 % 700), seed % 2 == 0);
    std::vector<double> lambda;
    for (const int threads : {1, 2, 3}) {
      ThreadPool pool(threads);
      ASSERT_TRUE(sweeps.assign(system, true, &pool));
      sweeps.set(lambda);
      if (threads == 1) {
        for (const BodyVector& y : sweeps.velocities()) {
          for (int c = 0; c < 4; ++c) EXPECT_EQ(y.v[c], 0);
        }
        sweeps.sweep(5);
        sweeps.get(sweeps.impulses(), lambda);
        sweeps.set(lambda);
      }
      std::vector<std::array<double, 3>> change(system.bodies.size(), {0, 0, 0});
      apply_impulses(system, lambda, change);
      double largest = 0;
      for (const BodyVector& y : sweeps.velocities())
        for (int c = 0; c < 3; ++c) largest = std::max(largest, std::abs(y.v[c]));
      for (std::size_t k = 0; k < change.size(); ++k) {
        const double linear = std::sqrt(system.bodies[k].linear),
                     angular = std::sqrt(system.bodies[k].angular);
        const double root[3] = {linear, linear, angular};
        for (int c = 0; c < 3; ++c) {
          if (!(root[c] > 0)) continue;
          EXPECT_NEAR(sweeps.velocities()[k].v[c], change[k][c] / root[c], 1e-10 * largest);
        }
      }
    }
  }
}

/// As `islands`, some with joints of one row, which row by row are no other than as a block, or with contacts
/// that give, which no block takes.
IslandSystem islands_row_by_row(unsigned seed, int count) {
  const IslandSystem all = islands(seed, count, seed % 3 == 0);
  IslandSystem system;
  system.bodies = all.bodies;
  std::vector<int> number(all.rows.size(), -1);
  for (std::size_t i = 0; i < all.rows.size(); ++i) {
    Row row = all.rows[i];
    const bool joint = row.kind >= RowKind::Joint;
    if (joint && i > 0 && row.a == all.rows[i - 1].a && row.b == all.rows[i - 1].b) continue;
    if (row.normal >= 0) row.normal = number[static_cast<std::size_t>(row.normal)];
    number[i] = system.size();
    system.rows.push_back(row);
    system.b.push_back(all.b[i]);
  }
  if (seed % 4 == 1) {
    for (std::size_t i = 0; i < system.rows.size(); ++i) system.compliance.push_back(i % 5 == 0 ? 0.1 : 0);
  }
  validate(system);
  return system;
}

std::vector<double> random_start(unsigned seed, std::size_t rows) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> number(-0.5, 1);
  std::vector<double> start(seed % 2 == 0 ? rows : 0);
  for (double& impulse : start) impulse = number(random);
  return start;
}

TEST(TgsSoft, GivesOverBlocksWhatItGivesRowByRow) {
  const SolverEntry& solver = find_solver("tgs_soft");
  for (unsigned seed = 1; seed <= 120; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const IslandSystem system = islands_row_by_row(seed, 1 + static_cast<int>(seed % 5));
    const std::vector<double> start = random_start(seed, system.rows.size());
    // Of so many parts velocities are made anew more than once.
    for (const int parts : {0, 1, 3, 70}) {
      SolveOptions options;
      options.max_iterations = parts;
      options.trace = true;
      const Solution blocks = solver.solve(system, start, options, nullptr);
      const Solution rows = solver.solve_contact(contact_problem(system), start, options, nullptr);
      EXPECT_EQ(blocks.iterations, parts == 0 ? 4 : parts);
      ASSERT_EQ(blocks.lambda.size(), rows.lambda.size());
      const double largest = std::max(1.0, largest_magnitude(rows.lambda));
      for (std::size_t i = 0; i < rows.lambda.size(); ++i)
        ASSERT_NEAR(blocks.lambda[i], rows.lambda[i], 1e-9 * largest) << "row " << i << ", " << parts;
      EXPECT_NEAR(blocks.residual, natural_map_residual(system, blocks.lambda), 1e-9 * largest);
      ASSERT_EQ(blocks.trace->iterations.size(), rows.trace->iterations.size());
      for (std::size_t k = 0; k < rows.trace->iterations.size(); ++k) {
        EXPECT_NEAR(blocks.trace->iterations[k].residual, rows.trace->iterations[k].residual, 1e-8 * largest)
            << "part " << k + 1;
      }
      // Nobody is kept from looking, nor does it change anything.
      options.trace = false;
      EXPECT_EQ(solver.solve(system, start, options, nullptr).lambda, blocks.lambda);
    }
  }
}

TEST(Sweeps, TellVelocitiesThatAreNoNumbers) {
  IslandSystem system = islands(1, 3, false);
  BlockSweeps sweeps;
  ASSERT_TRUE(sweeps.assign(system));
  sweeps.set({});
  EXPECT_TRUE(std::isfinite(sweeps.violation()));
  sweeps.velocities()[1].v[2] = kInfinity;
  EXPECT_EQ(sweeps.violation(), kInfinity);
}

// In the order of the blocks of a stack, parts guessed from those before grow by a tenth each: after a
// thousand of them residuals were 1e26 until such guesses paused.
TEST(TgsSoft, ManyPartsDoNotRunAway) {
  const SolverEntry& solver = find_solver("tgs_soft");
  for (const double friction : {0.0, 0.5}) {
    for (const scenes::Scene& scene :
         {scenes::stack(10, {.friction = friction}),
          scenes::pyramid(10, {.friction = friction, .noise = 0.3, .seed = 7})}) {
      SolveOptions options;
      options.max_iterations = 4;
      const double few = solver.solve(scene.system, {}, options, nullptr).residual;
      for (const int parts : {256, 1024, 4096}) {
        options.max_iterations = parts;
        EXPECT_LE(solver.solve(scene.system, {}, options, nullptr).residual, 0.05 * few)
            << parts << " parts, friction " << friction << ", " << scene.system.bodies.size() << " bodies";
        EXPECT_LE(solver.solve_contact(contact_problem(scene.system), {}, options, nullptr).residual,
                  0.05 * few)
            << parts << " parts row by row, friction " << friction;
      }
    }
  }
}

TEST(TgsSoft, KeepsTheBoundsWhateverThePartsLeave) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const IslandSystem system = islands(seed, 3, seed % 2 == 0);
    const std::vector<double> start = random_start(seed, system.rows.size());
    const Solution solution = find_solver("tgs_soft").solve(system, start, {}, nullptr);
    for (std::size_t i = 0; i < system.rows.size(); ++i) {
      const Row& row = system.rows[i];
      const double normal = row.normal < 0 ? 0 : solution.lambda[static_cast<std::size_t>(row.normal)];
      const ImpulseBounds bounds = impulse_bounds(row, normal);
      EXPECT_GE(solution.lambda[i], bounds.lower);
      EXPECT_LE(solution.lambda[i], bounds.upper);
    }
  }
}

TEST(TgsSoft, HoldsAJointInItsRelaxingSweeps) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const IslandSystem system = one_joint(seed, static_cast<int>(seed % 2));
    const Solution solution = find_solver("tgs_soft").solve(system, {}, {}, nullptr);
    EXPECT_LE(solution.residual, 1e-9 + 10 * residual_floor(system, solution.lambda));
  }
}

TEST(TgsSoft, GivesTheSameBitsForAnyNumberOfThreads) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const IslandSystem system = islands(seed, 600, seed % 2 == 0);
    const std::vector<double> start = random_start(seed, system.rows.size());
    std::vector<double> expected;
    for (const int threads : {1, 2, 3, 8}) {
      ThreadPool pool(threads);
      SolveOptions options;
      options.threads = &pool;
      const Solution solution = find_solver("tgs_soft").solve(system, start, options, nullptr);
      if (threads == 1) expected = solution.lambda;
      EXPECT_EQ(solution.lambda, expected) << threads << " threads";
    }
  }
}

}  // namespace sweeps_test
}  // namespace skerry
