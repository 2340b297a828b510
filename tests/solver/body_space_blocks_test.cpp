// SPDX-License-Identifier: MIT
#include <Eigen/Dense>
#include <algorithm>
#include <gtest/gtest.h>
#include <random>

#include "physics/solver/block_ldlt.h"

namespace skerry {
namespace body_space_blocks_test {

using Edges = std::vector<std::array<int, 2>>;

Edges random_graph(int nodes, int edges, std::mt19937& random) {
  Edges result;
  std::uniform_int_distribution<int> any(0, nodes - 1);
  for (int k = 0; k < edges; ++k) {
    const int a = any(random), b = any(random);
    if (a != b) result.push_back({a, b});
  }
  return result;
}

// Fills the factor with random numbers on the pattern, and a dense matrix with the same ones.
Eigen::MatrixXd random_matrix(const BlockPattern& pattern, BlockFactor& factor, bool general,
                              std::mt19937& random) {
  const int n = pattern.nodes();
  std::uniform_real_distribution<double> unit(-1, 1);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(3 * n, 3 * n);
  factor.clear(general);
  for (int j = 0; j < n; ++j) {
    for (int i = j + 1; i < n; ++i) {
      const int block = pattern.block(j, i);
      if (block < 0) continue;
      for (int c = 0; c < 3; ++c)
        for (int r = 0; r < 3; ++r) {
          const double low = unit(random), high = general ? unit(random) : low;
          factor.lower(block).column[c][r] = dense(3 * i + r, 3 * j + c) = low;
          if (general) factor.upper(block).column[c][r] = high;
          dense(3 * j + c, 3 * i + r) = high;
        }
    }
    for (int c = 0; c < 3; ++c)
      for (int r = 0; r <= c; ++r) {
        const double value = unit(random) + (r == c ? 4.0 * n : 0);
        dense(3 * j + r, 3 * j + c) = dense(3 * j + c, 3 * j + r) = value;
        factor.diagonal(j).column[c][r] = factor.diagonal(j).column[r][c] = value;
      }
  }
  return dense;
}

TEST(BlockFactor, SolvesLikeDenseLuOnRandomGraphs) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const int n = 1 + static_cast<int>(seed) % 23;
    BlockPattern pattern;
    pattern.analyse(n, random_graph(n, 2 * n, random));
    BlockFactor factor;
    factor.set_pattern(pattern);
    for (const bool general : {false, true}) {
      const Eigen::MatrixXd dense = random_matrix(pattern, factor, general, random);
      ASSERT_TRUE(factor.factor());
      const Eigen::VectorXd rhs = Eigen::VectorXd::Random(3 * n);
      std::vector<BodyVector> x(static_cast<std::size_t>(n));
      for (int j = 0; j < n; ++j)
        x[static_cast<std::size_t>(j)].v = Vec4{rhs[3 * j], rhs[3 * j + 1], rhs[3 * j + 2], 0};
      factor.solve(x.data());
      const Eigen::VectorXd expected = dense.partialPivLu().solve(rhs);
      for (int j = 0; j < n; ++j)
        for (int k = 0; k < 3; ++k)
          EXPECT_NEAR(x[static_cast<std::size_t>(j)].v[k], expected[3 * j + k], 1e-13)
              << "general " << general;
    }
  }
}

TEST(BlockFactor, RefusesMatricesThatAreNotPositiveDefiniteOrNotFinite) {
  BlockPattern pattern;
  const Edges edge{{0, 1}};
  pattern.analyse(2, edge);
  BlockFactor factor;
  factor.set_pattern(pattern);
  const auto fill = [&](double last, bool general) {
    factor.clear(general);
    for (int j = 0; j < 2; ++j)
      for (int k = 0; k < 3; ++k) factor.diagonal(j).column[k][k] = j == 1 && k == 2 ? last : 1;
    return factor.factor();
  };
  EXPECT_TRUE(fill(1, false));
  EXPECT_FALSE(fill(0, false));
  EXPECT_FALSE(fill(-1, false));
  EXPECT_FALSE(fill(std::numeric_limits<double>::quiet_NaN(), false));
  EXPECT_FALSE(fill(std::numeric_limits<double>::infinity(), false));
  EXPECT_TRUE(fill(-1, true));
  EXPECT_FALSE(fill(0, true));
  EXPECT_FALSE(fill(std::numeric_limits<double>::quiet_NaN(), true));
}

TEST(BlockPattern, DependsOnTheSetOfEdgesOnly) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    Edges edges = random_graph(40, 70, random);
    BlockPattern first, second;
    first.analyse(40, edges);
    edges.insert(edges.end(), edges.begin(), edges.begin() + 20);
    std::shuffle(edges.begin(), edges.end(), random);
    for (auto& e : edges) std::swap(e[0], e[1]);
    second.analyse(40, edges);
    EXPECT_EQ(first.order(), second.order());
    EXPECT_EQ(first.blocks(), second.blocks());
    for (const auto& e : edges) {
      const int a = first.position(e[0]), b = first.position(e[1]);
      EXPECT_GE(first.block(std::min(a, b), std::max(a, b)), 0) << "an edge is not in the pattern";
    }
  }
}

TEST(BlockPattern, ChainsHaveNoFill) {
  Edges edges;
  for (int k = 0; k + 1 < 1000; ++k) edges.push_back({k, k + 1});
  BlockPattern pattern;
  pattern.analyse(1000, edges);
  EXPECT_EQ(pattern.blocks(), 999);
  EXPECT_EQ(pattern.updates(), 0);
  pattern.analyse(0, {});
  EXPECT_EQ(pattern.nodes(), 0);
}

}  // namespace body_space_blocks_test
}  // namespace skerry
