// SPDX-License-Identifier: MIT
//
// Threads that share the factor, the solves and the rows of one large island give the bits of one thread.
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "physics/solver/auto.h"
#include "physics/solver/block_ldlt.h"
#include "physics/solver/cone_interior_point.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace shared_solve_test {

using scenes::SceneBuilder;
using scenes::SceneOptions;
using Edges = std::vector<std::array<int, 2>>;

// A grid with some long edges: its elimination tree has many branches and a wide top.
Edges grid(int width, int height, std::mt19937& random) {
  Edges edges;
  std::uniform_int_distribution<int> any(0, width * height - 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int node = y * width + x;
      if (x + 1 < width) edges.push_back({node, node + 1});
      if (y + 1 < height) edges.push_back({node, node + width});
      if (any(random) < width) edges.push_back({std::min(node, width), any(random)});
    }
  std::erase_if(edges, [](const auto& e) { return e[0] == e[1]; });
  return edges;
}

struct Bits {
  std::vector<Block3> diagonal, lower;
  std::vector<BodyVector> solution;
};
bool operator==(const Bits& x, const Bits& y) {
  const auto same = [](const auto& a, const auto& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(a[0])) == 0;
  };
  return same(x.diagonal, y.diagonal) && same(x.lower, y.lower) && same(x.solution, y.solution);
}

// Dominated by its diagonal. @param spoilt  position of a pivot that is `with`, or -1
Bits factorise(const BlockPattern& pattern, bool general, ThreadPool* threads, bool& regular, int spoilt = -1,
               double with = 0) {
  BlockFactor factor;
  factor.set_pattern(pattern);
  regular = factor.factor(general, threads, [&](int position) {
    std::mt19937 random(static_cast<unsigned>(position) + 1);
    std::uniform_real_distribution<double> unit(-1, 1);
    for (int k = 0; k < 3; ++k) factor.diagonal(position).column[k][k] = position == spoilt ? with : 400;
    for (int high = position + 1; high < pattern.nodes(); ++high) {
      const int block = pattern.block(position, high);
      if (block < 0) continue;
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) {
          factor.lower(block).column[c][r] = unit(random);
          if (general) factor.upper(block).column[c][r] = unit(random);
        }
    }
  });
  Bits bits;
  if (!regular) return bits;
  for (int j = 0; j < pattern.nodes(); ++j) bits.diagonal.push_back(factor.diagonal(j));
  for (int p = 0; p < pattern.blocks(); ++p) bits.lower.push_back(factor.lower(p));
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int j = 0; j < pattern.nodes(); ++j)
    bits.solution.push_back({Vec4{unit(random), unit(random), unit(random), 0}});
  factor.solve(bits.solution.data(), threads);
  return bits;
}

TEST(SharedFactor, HasTheBitsOfOneThread) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    BlockPattern pattern;
    const int width = 14 + 4 * static_cast<int>(seed), height = 50 - 3 * static_cast<int>(seed);
    pattern.analyse(width * height, grid(width, height, random));
    for (const bool general : {false, true}) {
      bool regular = false;
      const Bits expected = factorise(pattern, general, nullptr, regular);
      ASSERT_TRUE(regular);
      for (const int threads : {2, 3, 5, 8}) {
        ThreadPool pool(threads);
        BlockSharing sharing;
        sharing.plan(pattern, threads);
        ASSERT_TRUE(sharing.pays());
        ASSERT_GE(sharing.subtrees(), threads);
        EXPECT_TRUE(factorise(pattern, general, &pool, regular) == expected)
            << threads << " threads, general " << general;
        EXPECT_TRUE(regular);
      }
    }
  }
}

TEST(SharedFactor, PlansEveryColumnOnceAndEveryProduct) {
  std::mt19937 random(3);
  BlockPattern pattern;
  pattern.analyse(900, grid(30, 30, random));
  for (const int threads : {2, 4, 16}) {
    BlockSharing sharing;
    sharing.plan(pattern, threads);
    std::vector<int> times(900, 0);
    for (int i = 0; i < sharing.subtrees(); ++i)
      for (const int column : sharing.subtree(i)) ++times[static_cast<std::size_t>(column)];
    for (const int column : sharing.top()) ++times[static_cast<std::size_t>(column)];
    EXPECT_EQ(times, std::vector<int>(900, 1)) << threads;
    // What is fetched by columns above, and what is done within subtrees, are all block updates.
    std::int64_t updates = 0;
    for (int i = 0; i < static_cast<int>(sharing.top().size()); ++i)
      for (const BlockSharing::Source& source : sharing.sources(i))
        updates += std::int64_t{source.count} * (pattern.column_size(source.last) - source.k - 1);
    for (int i = 0; i < sharing.subtrees(); ++i)
      for (const int j : sharing.subtree(i))
        for (int k = 0; k < sharing.inside(j); ++k) updates += pattern.column_size(j) - k - 1;
    EXPECT_EQ(updates, pattern.updates()) << threads;
  }
}

TEST(SharedFactor, RefusesABadPivotWhereverItIs) {
  std::mt19937 random(5);
  BlockPattern pattern;
  pattern.analyse(700, grid(28, 25, random));
  ThreadPool pool(3);
  for (const int spoilt : {0, 100, 350, 500, 680, 699}) {
    bool regular = true;
    factorise(pattern, false, &pool, regular, spoilt, std::numeric_limits<double>::quiet_NaN());
    EXPECT_FALSE(regular) << "position " << spoilt;
    factorise(pattern, true, &pool, regular, spoilt, std::numeric_limits<double>::infinity());
    EXPECT_FALSE(regular) << "position " << spoilt;
    factorise(pattern, false, &pool, regular);
    EXPECT_TRUE(regular);
  }
}

// Bodies in a grid, neighbours pinned to each other.
IslandSystem pinned_grid(int width, int height) {
  SceneBuilder builder(SceneOptions{});
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) builder.body({x + 0.0, y + 0.0}, 1, 0.1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int body = y * width + x;
      builder.pin(x == 0 ? -1 : body - 1, body, {x - 0.5, y + 0.1});
      if (y > 0) builder.pin(body - width, body, {x + 0.1, y - 0.5});
    }
  return builder.finish().system;
}

// Cold, then with a disturbed load from there with what is kept, the impulses of all solves.
std::vector<double> solve_twice(const IslandSystem& system, int threads) {
  ThreadPool pool(threads);
  SolveOptions options;
  options.threads = &pool;
  options.work_limit = 1e8;
  std::unique_ptr<SolverMemory> memory;
  Solution solution = solve_auto(system, {}, options, &memory);
  std::vector<double> all = solution.lambda;
  // Some bodies get a push.
  IslandSystem pushed = system;
  const std::array<double, 3> push{0.01, -0.02, 0.01};
  for (std::size_t i = 0; i < pushed.rows.size(); ++i) {
    const Row& row = pushed.rows[i];
    if (row.a >= 0 && row.a % 100 == 7) pushed.b[i] -= along(row.Ja, push);
    if (row.b >= 0 && row.b % 100 == 7) pushed.b[i] -= along(row.Jb, push);
  }
  solution = solve_auto(pushed, solution.lambda, options, &memory);
  EXPECT_LE(solution.residual, 1e-9);
  all.insert(all.end(), solution.lambda.begin(), solution.lambda.end());
  return all;
}

TEST(SharedSolve, HasTheBitsOfOneThread) {
  const struct {
    const char* name;
    IslandSystem system;
  } islands[] = {
      {"pyramid", scenes::pyramid(40).system},
      {"pyramid in a shock", scenes::pyramid(30, {.noise = 0.1, .seed = 4}).system},
      {"wall, smooth", scenes::wall(30, 30, true, {.friction = 0}).system},
      {"wall, heavy and light", scenes::wall(25, 30, false, {.mass_ratio = 100, .noise = 0.01}).system},
      {"heap of discs", scenes::disc_heap(40, {.friction = 0.1, .noise = 0.01}).system},
      {"pinned grid", pinned_grid(35, 35)},
  };
  for (const auto& island : islands) {
    SCOPED_TRACE(island.name);
    const std::vector<double> expected = solve_twice(island.system, 1);
    for (const int threads : {2, 3, 8}) EXPECT_EQ(solve_twice(island.system, threads), expected) << threads;
  }
}

// A heap on the ground, its neighbours in a layer pinned to each other.
IslandSystem pinned_heap(int base) {
  const scenes::Scene loose = scenes::disc_heap(base, {.noise = 0.3, .seed = 5});
  SceneBuilder builder({.noise = 0.3, .seed = 5});
  builder.scene() = loose;
  builder.scene().system.b.clear();
  const std::vector<Vec2>& places = loose.system.positions;
  for (int k = 1; k < static_cast<int>(places.size()); ++k) {
    const Vec2 here = places[static_cast<std::size_t>(k)], last = places[static_cast<std::size_t>(k - 1)];
    if (here.y == last.y) builder.pin(k - 1, k, 0.5 * (here + last));
  }
  return builder.finish().system;
}

TEST(SharedConePath, HasTheBitsOfOneThread) {
  using Sliding = ConeInteriorPoint::Sliding;
  const IslandSystem systems[] = {scenes::disc_heap(50, {.noise = 0.3, .seed = 2}).system,
                                  scenes::pyramid(28, {.noise = 0.3, .seed = 3}).system, pinned_heap(50)};
  for (const IslandSystem& system : systems) {
    const std::vector<double> start(system.rows.size(), 0.0);
    for (const Sliding sliding : {Sliding::Coulomb, Sliding::Associated}) {
      const auto follow = [&](int threads) {
        ThreadPool pool(threads);
        SolveWork work;
        ConeInteriorPoint path;
        EXPECT_TRUE(path.assign(system, work, &pool));
        path.start(start, 0.3, sliding);
        for (int k = 0; k < 8; ++k) EXPECT_GT(path.step(work), 0);
        std::vector<double> lambda;
        path.get(lambda);
        lambda.push_back(path.centre());
        return lambda;
      };
      const std::vector<double> expected = follow(1);
      for (const int threads : {2, 3, 8}) EXPECT_EQ(follow(threads), expected) << threads;
    }
  }
}

TEST(SharedSolve, NoNumberIsHiddenFromSeveralThreads) {
  ThreadPool threads(2);
  IslandSystem system;
  const int discs = 5000;
  const auto add = [&](int a, int b, double up) {
    Row row;
    row.a = a;
    row.b = b;
    if (a >= 0) row.Ja = {0, -up, 0};
    row.Jb = {0, up, 0};
    system.rows.push_back(row);
    system.b.push_back(1);
  };
  for (int k = 0; k < discs; ++k) {
    system.bodies.push_back({10, 10});
    add(k - 1, k, 1);
  }
  add(-1, discs - 1, -1);
  std::vector<double> lambda(system.rows.size(), 1e308);
  for (ThreadPool* pool : {&threads, static_cast<ThreadPool*>(nullptr)})
    EXPECT_FALSE(clamp_and_judge(system, lambda, kInfinity, pool) <= 1);
}

}  // namespace shared_solve_test
}  // namespace skerry
