// SPDX-License-Identifier: MIT
//
// Long chains and trees of joints, answered as a whole among sweeps.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <random>
#include <string>

#include "physics/islands/delassus.h"
#include "physics/solver/block_sweeps.h"

namespace skerry {
namespace joint_lines_test {

using Joint = JointLines::Joint;

/// A row between two bodies (-1: the ground) that holds both ways.
Row held(int a, int b, std::array<double, 3> Ja, std::array<double, 3> Jb) {
  Row row;
  row.kind = RowKind::Joint;
  row.a = a;
  row.b = b;
  if (a >= 0) row.Ja = Ja;
  if (b >= 0) row.Jb = Jb;
  row.lower = -kInfinity;
  row.upper = kInfinity;
  return row;
}

/// A tree of joints with one to three rows each, of which one may hang on the ground: each body on one of the
/// last few.
IslandSystem random_tree(std::mt19937_64& random, int bodies, int last_few, bool grounded) {
  std::uniform_real_distribution<double> number(-1, 1);
  IslandSystem system;
  for (int k = 0; k < bodies; ++k)
    system.bodies.push_back({1 + 0.9 * number(random), 2 + 1.9 * number(random)});
  for (int k = grounded ? 0 : 1; k < bodies; ++k) {
    const int a =
        k == 0 ? -1 : k - 1 - static_cast<int>(random() % static_cast<unsigned>(std::min(k, last_few)));
    const int count = 1 + static_cast<int>(random() % 3);
    for (int i = 0; i < count; ++i) {
      std::array<double, 3> Ja{}, Jb{};
      for (double& x : Ja) x = number(random);
      for (double& x : Jb) x = number(random);
      system.rows.push_back(held(a, k, Ja, Jb));
      system.b.push_back(number(random));
    }
  }
  validate(system);
  return system;
}

/// Links of half a metre from the origin to the right, each hinged to the one before; the first, and the last
/// if `closed`, to the ground. They sag by `sag` at most.
IslandSystem chain(int links, double sag, bool closed) {
  IslandSystem system;
  const auto height = [&](int end) { return -4 * sag * end * (links - end) / (1.0 * links * links); };
  const auto hinge = [&](int a, int b, int end) {
    const auto arm = [&](int body) {
      return Vec2{0.5 * (end - body) - 0.25, height(end) - 0.5 * (height(body) + height(body + 1))};
    };
    const Vec2 p = arm(a), q = arm(b);
    system.rows.push_back(held(a, b, {-1, 0, p.y}, {1, 0, -q.y}));
    system.rows.push_back(held(a, b, {0, -1, -p.x}, {0, 1, q.x}));
  };
  for (int k = 0; k < links; ++k) system.bodies.push_back({10, 400});
  for (int k = 0; k < links; ++k) hinge(k - 1, k, k);
  if (closed) hinge(links - 1, -1, links);
  return system;
}

/// A load on each link, with friction, and what falling for a step wants of all rows.
void load(IslandSystem& system, std::mt19937_64& random) {
  std::uniform_real_distribution<double> number(-1, 1);
  const int links = static_cast<int>(system.bodies.size());
  std::vector<double> fall(system.bodies.size(), -0.17);
  for (int k = 0; k < links; ++k) {
    system.bodies.push_back({6, 230});
    fall.push_back(-1 + 0.5 * number(random));
    for (const double x : {-0.15, 0.15}) {
      const int normal = system.size();
      Row row;
      row.a = k;
      row.b = links + k;
      row.Ja = {0, -1, -x};
      row.Jb = {0, 1, x};
      system.rows.push_back(row);
      row.kind = RowKind::Friction;
      row.Ja = {-1, 0, 0.1};
      row.Jb = {1, 0, 0.2};
      row.lower = row.upper = 0;
      row.normal = normal;
      row.mu = 0.6;
      system.rows.push_back(row);
    }
  }
  system.b.clear();
  for (const Row& row : system.rows) {
    double u = 0;
    if (row.a >= 0) u += row.Ja[1] * fall[static_cast<std::size_t>(row.a)];
    if (row.b >= 0) u += row.Jb[1] * fall[static_cast<std::size_t>(row.b)];
    system.b.push_back(-u);
  }
  validate(system);
}

/// Violation after so many sweeps, relative to the largest free velocity.
double violation(const IslandSystem& system, int sweeps, bool lines, ThreadPool* threads = nullptr,
                 std::vector<double>* lambda = nullptr) {
  BlockSweeps all;
  EXPECT_TRUE(all.assign(system, true, threads, lines));
  EXPECT_EQ(all.lined(), lines);
  all.set({});
  all.sweep(sweeps);
  if (lambda != nullptr) all.get(all.impulses(), *lambda);
  double scale = 0;
  for (const double b : system.b) scale = std::max(scale, std::abs(b));
  return all.violation() / scale;
}

TEST(JointLines, AnswerWhatRandomTreesWant) {
  std::mt19937_64 random(11);
  for (int sample = 0; sample < 300; ++sample) {
    const int bodies = 14 + static_cast<int>(random() % 60), last_few = 1 + static_cast<int>(random() % 4);
    SCOPED_TRACE("sample " + std::to_string(sample) + ", " + std::to_string(bodies) + " bodies");
    const IslandSystem system = random_tree(random, bodies, last_few, sample % 2 == 0);
    std::vector<double> lambda;
    // What rounding leaves of a factor the second one takes away.
    EXPECT_LE(violation(system, 2, true, nullptr, &lambda), 1e-9);
    const Eigen::MatrixXd W(delassus(system));
    const Eigen::Map<const Eigen::VectorXd> b(system.b.data(), system.size());
    const Eigen::VectorXd expected = W.ldlt().solve(b);
    const Eigen::Map<const Eigen::VectorXd> found(lambda.data(), system.size());
    EXPECT_LE((W * found - b).norm(), 1e-9 * b.norm());
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(W, Eigen::EigenvaluesOnly);
    const double condition = eigen.eigenvalues().maxCoeff() / eigen.eigenvalues().minCoeff();
    EXPECT_LE((found - expected).norm(), 1e-13 * condition * expected.norm());
  }
}

TEST(JointLines, ComeToTheAnswerOfOtherSweeps) {
  // As far as rows give, chains do not take those so long.
  std::mt19937_64 random(12);
  for (int sample = 0; sample < 20; ++sample) {
    SCOPED_TRACE("sample " + std::to_string(sample));
    IslandSystem system = chain(12, 0.5, true);
    load(system, random);
    std::vector<double> lambda[2];
    for (const bool lines : {false, true}) {
      BlockSweeps sweeps;
      ASSERT_TRUE(sweeps.assign(system, true, nullptr, lines));
      sweeps.soften(0.3, 0.1);
      sweeps.set({});
      EXPECT_LE(sweeps.sweep(20000), 1e-13);
      sweeps.get(sweeps.impulses(), lambda[lines]);
    }
    for (std::size_t i = 0; i < lambda[0].size(); ++i) EXPECT_NEAR(lambda[0][i], lambda[1][i], 1e-10) << i;
  }
}

TEST(JointLines, LetSweepsComeToTheAnswer) {
  std::mt19937_64 random(13);
  for (const bool closed : {false, true}) {
    IslandSystem system = chain(100, 5, closed);
    load(system, random);
    const double few = violation(system, 60, true), more = violation(system, 200, true);
    const double without = violation(system, 3000, false);
    std::printf("%s: 60 sweeps with lines %.1e, 200 %.1e; 3000 without %.1e\n", closed ? "bridge" : "rope",
                few, more, without);
    EXPECT_LE(few, 0.2 * without);
    EXPECT_LE(more, 1e-8);
  }
}

TEST(JointLines, LeaveWhatDependsOnOthersToTheSweeps) {
  // Links in a straight line between two walls: what one wants along it the others say.
  IslandSystem system = chain(30, 0, true);
  system.b.resize(system.rows.size());
  std::vector<std::array<double, 3>> free(system.bodies.size(), {0.2, -0.17, 0.5});
  for (std::size_t i = 0; i < system.rows.size(); ++i) {
    const Row& row = system.rows[i];
    double u = 0;
    if (row.a >= 0) u += along(row.Ja, free[static_cast<std::size_t>(row.a)]);
    if (row.b >= 0) u += along(row.Jb, free[static_cast<std::size_t>(row.b)]);
    system.b[i] = -u;
  }
  std::vector<double> lambda;
  EXPECT_LE(violation(system, 3, true, nullptr, &lambda), 1e-12);
  for (const double x : lambda) EXPECT_LE(std::abs(x), 1);
  // Walls that come together: nothing can be done, and nothing becomes infinite.
  for (double& b : system.b) b = 0;
  system.b[0] = 1;
  EXPECT_TRUE(std::isfinite(violation(system, 50, true, nullptr, &lambda)));
  for (const double x : lambda) EXPECT_LE(std::abs(x), 100);
}

TEST(JointLines, AreTreesThatAreLong) {
  const auto chosen = [](const std::vector<Joint>& joints, int ground) {
    JointLines lines;
    lines.choose(joints, ground);
    return lines.joints().size();
  };
  std::vector<Joint> line, ring, star;
  for (int k = 0; k < 40; ++k) {
    line.push_back({k, k, k + 1, 2});
    ring.push_back({k, k, (k + 1) % 40, 2});
    star.push_back({k, 0, k + 1, 2});
  }
  EXPECT_EQ(chosen(line, 41), 40u);
  EXPECT_EQ(chosen({line.begin(), line.begin() + 10}, 41), 0u) << "a person's";
  EXPECT_EQ(chosen(ring, 40), 39u);
  EXPECT_EQ(chosen(star, 41), 0u) << "eight of them are short";
  // Of the ground all may be: it connects nothing.
  std::vector<Joint> pinned;
  pinned.reserve(80);
  for (int k = 0; k < 40; ++k) pinned.push_back({k, 40, k, 2});
  EXPECT_EQ(chosen(pinned, 40), 0u);
  pinned.insert(pinned.end(), line.begin(), line.begin() + 39);
  EXPECT_EQ(chosen(pinned, 40), 79u);
  // Two chains that only the ground connects, one of which is short.
  std::vector<Joint> two(line.begin(), line.begin() + 5);
  two.push_back({5, 41, 0, 2});
  two.push_back({6, 41, 20, 2});
  two.insert(two.end(), line.begin() + 20, line.end());
  EXPECT_EQ(chosen(two, 41), 21u);
  EXPECT_EQ(chosen({}, 0), 0u);
}

TEST(JointLines, GiveTheSameBitsForAnyThreads) {
  std::mt19937_64 random(14);
  IslandSystem system = chain(2000, 60, true);
  load(system, random);
  std::vector<double> expected;
  for (const int threads : {1, 2, 4}) {
    ThreadPool pool(threads);
    std::vector<double> lambda;
    violation(system, 7, true, &pool, &lambda);
    if (threads == 1) expected = lambda;
    EXPECT_EQ(lambda, expected) << threads;
  }
}

}  // namespace joint_lines_test
}  // namespace skerry
