// SPDX-License-Identifier: MIT
//
// Forces of joints in their own space against elimination in long double.
#include "physics/stepping/bilateral_forces.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "tests/support/scale.h"

namespace skerry {
namespace bilateral_forces_test {

using Row = BilateralForces::Row;

struct Tree {
  std::vector<InverseMass> bodies;
  std::vector<Row> rows;
};

/// Joint k holds body k to the ground or to a body before it, by one to three rows of any direction.
Tree random_tree(std::mt19937& random, int count, bool chain) {
  const auto number = [&](double from, double to) {
    return from + (to - from) * static_cast<double>(random()) / 4294967296.0;
  };
  Tree tree;
  for (int k = 0; k < count; ++k) {
    tree.bodies.push_back({number(0.5, 2), number(0.5, 20)});
    const int other = chain    ? k - 1
                      : k == 0 ? -1
                               : static_cast<int>(random() % static_cast<unsigned>(k + 1)) - 1;
    const int held = 1 + static_cast<int>(random() % 3);
    for (int i = 0; i < held; ++i) {
      Row row;
      row.a = other;
      row.b = k;
      // Rows of one joint along different axes: as independent as those of hinges, sliders and welds.
      for (std::size_t c = 0; c < 3; ++c) {
        const double own = c == static_cast<std::size_t>(i) ? 1 : 0;
        if (other >= 0) row.Ja[c] = -own + number(-0.3, 0.3);
        row.Jb[c] = own + number(-0.3, 0.3);
      }
      row.wanted = number(-10, 10);
      tree.rows.push_back(row);
    }
  }
  return tree;
}

long double coupling(const Tree& tree, const Row& x, const Row& y) {
  long double sum = 0;
  const auto add = [&](int p, const std::array<double, 3>& u, int q, const std::array<double, 3>& v) {
    if (p < 0 || p != q) return;
    const InverseMass& m = tree.bodies[static_cast<std::size_t>(p)];
    sum += static_cast<long double>(m.linear) * u[0] * v[0] +
           static_cast<long double>(m.linear) * u[1] * v[1] +
           static_cast<long double>(m.angular) * u[2] * v[2];
  };
  add(x.a, x.Ja, y.a, y.Ja);
  add(x.a, x.Ja, y.b, y.Jb);
  add(x.b, x.Jb, y.a, y.Ja);
  add(x.b, x.Jb, y.b, y.Jb);
  return sum;
}

/// W lambda = b by elimination with row pivoting.
std::vector<long double> eliminate(const Tree& tree) {
  const std::size_t n = tree.rows.size(), width = n + 1;
  std::vector<long double> A;
  for (const Row& x : tree.rows) {
    for (const Row& y : tree.rows) A.push_back(coupling(tree, x, y));
    A.push_back(x.wanted);
  }
  for (std::size_t p = 0; p < n; ++p) {
    std::size_t best = p;
    for (std::size_t i = p; i < n; ++i)
      if (std::abs(A[i * width + p]) > std::abs(A[best * width + p])) best = i;
    for (std::size_t j = 0; j < width; ++j) std::swap(A[p * width + j], A[best * width + j]);
    for (std::size_t i = p + 1; i < n; ++i) {
      const long double factor = A[i * width + p] / A[p * width + p];
      for (std::size_t j = p; j < width; ++j) A[i * width + j] -= factor * A[p * width + j];
    }
  }
  std::vector<long double> x;
  x.resize(n);
  for (std::size_t p = n; p-- > 0;) {
    x[p] = A[p * width + n];
    for (std::size_t j = p + 1; j < n; ++j) x[p] -= A[p * width + j] * x[j];
    x[p] /= A[p * width + p];
  }
  return x;
}

TEST(BilateralForces, OfRandomTreesAndChainsAgreeWithElimination) {
  const unsigned seed = 606;
  std::mt19937 random(seed);
  BilateralForces solver;  // one for all: it notices that the graph is another one
  int answered = 0;
  const int count = test_scale(60);
  for (int k = 0; k < count; ++k) {
    const Tree tree = random_tree(random, 1 + static_cast<int>(random() % 25), k % 2 == 0);
    SolveWork work;
    std::vector<double> lambda;
    if (!solver.solve(tree.bodies, tree.rows, work, lambda)) continue;
    ++answered;
    const std::vector<long double> exact = eliminate(tree);
    long double largest = 0, off = 0;
    for (std::size_t i = 0; i < exact.size(); ++i) {
      largest = std::max(largest, std::abs(exact[i]));
      off = std::max(off, std::abs(exact[i] - lambda[i]));
    }
    ASSERT_LE(off, 1e-8L * largest) << "tree " << k << " of seed " << seed;
    // The same graph with other numbers needs no other order.
    std::vector<double> again;
    ASSERT_TRUE(solver.solve(tree.bodies, tree.rows, work, again));
    ASSERT_EQ(again, lambda);
    ASSERT_EQ(work.symbolic_skipped, 1);
  }
  EXPECT_GT(answered, count * 9 / 10);
}

TEST(BilateralForces, RefusesRowsThatRepeatEachOther) {
  std::mt19937 random(1);
  Tree tree = random_tree(random, 8, true);
  const Row last = tree.rows.back();
  tree.rows.push_back(last);
  BilateralForces solver;
  SolveWork work;
  std::vector<double> lambda;
  EXPECT_FALSE(solver.solve(tree.bodies, tree.rows, work, lambda));
}

TEST(BilateralForces, LeavesAHubOfManyJointsToTheBodies) {
  // Thirty spokes on one wheel couple each with each.
  Tree wheel;
  wheel.bodies.push_back({1, 1});
  for (int k = 1; k <= 30; ++k) {
    wheel.bodies.push_back({1, 1});
    Row row;
    row.a = 0;
    row.b = k;
    row.Ja = {-1, 0, 0.1 * k};
    row.Jb = {1, 0, 0};
    row.wanted = 1;
    wheel.rows.push_back(row);
  }
  BilateralForces solver;
  SolveWork work;
  std::vector<double> lambda;
  EXPECT_FALSE(solver.solve(wheel.bodies, wheel.rows, work, lambda));
  EXPECT_EQ(work.factorisations, 0);
}

}  // namespace bilateral_forces_test
}  // namespace skerry
