// SPDX-License-Identifier: MIT
#include "physics/solver/bilateral.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <numeric>
#include <random>
#include <string>

#include "physics/solver/auto.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace bilateral_test {

using scenes::Scene;
using scenes::SceneBuilder;
using scenes::SceneOptions;

/// Links of length 1 in a zigzag, pinned to each other, the first one to the ground.
Scene pinned_chain(int links, const SceneOptions& options) {
  SceneBuilder builder(options);
  for (int i = 0; i < links; ++i) {
    const double mass = builder.layer_mass(i, links);
    builder.body({i + 0.5, 0.1 * (i % 2)}, mass, mass / 12);
  }
  for (int i = 0; i < links; ++i) builder.pin(i - 1, i, {static_cast<double>(i), 0.05 * (i % 3)});
  return builder.finish();
}

/// Of each link hang two more: no chain.
Scene pinned_tree(int links, const SceneOptions& options) {
  SceneBuilder builder(options);
  for (int i = 0; i < links; ++i)
    builder.body({static_cast<double>(i), 0.1 * (i % 2)}, builder.layer_mass(i, links), 1);
  for (int i = 0; i < links; ++i) builder.pin(i == 0 ? -1 : (i - 1) / 2, i, {i - 0.5, 0.3});
  return builder.finish();
}

/// W in long double, solved by elimination with row pivoting.
std::vector<long double> eliminate(const IslandSystem& system) {
  const std::size_t n = system.rows.size();
  std::vector<std::vector<long double>> A(n, std::vector<long double>(n + 1, 0));
  const auto block = [](const Row& row, int body) { return row.a == body ? row.Ja : row.Jb; };
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      for (const int body : {system.rows[i].a, system.rows[i].b}) {
        if (body < 0 || (system.rows[j].a != body && system.rows[j].b != body)) continue;
        const InverseMass m = system.bodies[static_cast<std::size_t>(body)];
        const auto x = block(system.rows[i], body), y = block(system.rows[j], body);
        A[i][j] += static_cast<long double>(m.linear) *
                       (static_cast<long double>(x[0]) * y[0] + static_cast<long double>(x[1]) * y[1]) +
                   static_cast<long double>(m.angular) * x[2] * y[2];
      }
    }
    if (!system.compliance.empty()) A[i][i] += system.compliance[i];
    A[i][n] = system.b[i];
  }
  for (std::size_t p = 0; p < n; ++p) {
    std::size_t best = p;
    for (std::size_t i = p; i < n; ++i)
      if (std::abs(A[i][p]) > std::abs(A[best][p])) best = i;
    std::swap(A[p], A[best]);
    for (std::size_t i = 0; i < n; ++i) {
      if (i == p) continue;
      const long double factor = A[i][p] / A[p][p];
      for (std::size_t j = p; j <= n; ++j) A[i][j] -= factor * A[p][j];
    }
  }
  std::vector<long double> x(n);
  for (std::size_t i = 0; i < n; ++i) x[i] = A[i][n] / A[i][i];
  return x;
}

TEST(Bilateral, AgreesWithEliminationInLongDouble) {
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const int links = 1 + static_cast<int>(seed % 20);
    Scene scene = pinned_chain(links, {.mass_ratio = seed % 3 == 0 ? 1e4 : 1,
                                       .pattern = scenes::MassPattern::Random,
                                       .noise = 1,
                                       .seed = seed});
    if (seed % 4 == 0)
      scene.system.compliance.assign(scene.system.rows.size(), 0.01 * static_cast<double>(seed % 5));
    const Solution solution = solve_bilateral(scene.system, {}, {.tolerance = 1e-12}, nullptr);
    ASSERT_EQ(solution.status, SolveStatus::Solved) << solution.residual;
    EXPECT_NEAR(solution.residual, natural_map_residual(scene.system, solution.lambda), 1e-13);
    EXPECT_LE(solution.work.resolves, 4) << "rows " << scene.system.rows.size();
    const std::vector<long double> exact = eliminate(scene.system);
    double largest = 0;
    for (const long double x : exact) largest = std::max(largest, std::abs(static_cast<double>(x)));
    for (std::size_t i = 0; i < exact.size(); ++i)
      EXPECT_NEAR(solution.lambda[i], static_cast<double>(exact[i]), 1e-8 * largest) << i;
  }
}

/// Rows between the first one with a body of the row and the row, all together.
std::size_t envelope_of(const IslandSystem& system) {
  std::size_t size = 0;
  for (std::size_t i = 0; i < system.rows.size(); ++i) {
    const Row& row = system.rows[i];
    const auto meets = [&](const Row& other) {
      return (row.a >= 0 && (row.a == other.a || row.a == other.b)) ||
             (row.b >= 0 && (row.b == other.a || row.b == other.b));
    };
    std::size_t first = 0;
    while (first < i && !meets(system.rows[first])) ++first;
    size += i - first;
  }
  return size;
}

/// Joints of one to three rows: chains, open and closed, and trees, in their order or not.
TEST(Bilateral, StaysWithinTheEnvelopeWhereThatIsNarrow) {
  int within = 0, others = 0, narrow = 0, loops = 0, trees = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> unit(-1, 1);
    const int links = 14 + static_cast<int>(seed % 9);
    IslandSystem system;
    const bool held = seed % 2 == 0, closed = seed % 5 == 0, shuffled = seed % 7 == 0,
               branches = seed % 3 == 0;
    for (int i = 0; i < links; ++i) {
      const double mass = std::exp2(4 * unit(random));
      system.bodies.push_back({1 / mass, 12 / mass});
      system.positions.push_back({static_cast<double>(i), 0});
    }
    const auto join = [&](int a, int b) {
      const int rows = 1 + static_cast<int>(random() % 3);
      for (int k = 0; k < rows; ++k) {
        Row row{.kind = RowKind::Joint, .a = a, .b = b, .lower = -kInfinity, .upper = kInfinity};
        for (int c = 0; c < 3; ++c)
          row.Ja[static_cast<std::size_t>(c)] = unit(random),
          row.Jb[static_cast<std::size_t>(c)] = unit(random);
        if (a < 0) row.Ja = {};
        system.rows.push_back(row);
        system.b.push_back(unit(random));
      }
    };
    if (held) join(-1, 0);
    for (int i = 1; i < links; ++i)
      join(branches ? std::max(0, i - 1 - static_cast<int>(random() % 4)) : i - 1, i);
    if (closed) join(links - 1, 0);
    if (shuffled) {
      std::vector<std::size_t> order(system.rows.size());
      std::iota(order.begin(), order.end(), std::size_t{0});
      std::shuffle(order.begin(), order.end(), random);
      const IslandSystem before = system;
      for (std::size_t i = 0; i < order.size(); ++i) {
        system.rows[i] = before.rows[order[i]];
        system.b[i] = before.b[order[i]];
      }
    }
    const Solution solution = solve_bilateral(system, {}, {.tolerance = 1e-10, .trace = true}, nullptr);
    const std::string note = solution.trace->notes.back();
    const bool in_envelope = note.find("envelope") != std::string::npos;
    const bool is_narrow = envelope_of(system) <= 8 * system.rows.size();
    EXPECT_FALSE(in_envelope && !is_narrow) << note;
    narrow += is_narrow;
    (in_envelope ? within : others) += 1;
    loops += in_envelope && closed;
    trees += in_envelope && branches;
    const std::vector<long double> exact = eliminate(system);
    double largest = 0;
    for (const long double x : exact) largest = std::max(largest, std::abs(static_cast<double>(x)));
    // Some of these are near to singular, where the graph of the bodies ends at what rounding explains.
    if (!in_envelope && largest > 1e4) continue;
    ASSERT_EQ(solution.status, SolveStatus::Solved) << solution.residual << ", largest " << largest;
    EXPECT_LE(natural_map_residual(system, solution.lambda), in_envelope ? 1e-10 : 1e-6);
    for (std::size_t i = 0; i < exact.size(); ++i)
      EXPECT_NEAR(solution.lambda[i], static_cast<double>(exact[i]), 1e-6 * largest) << i;
  }
  // But for a few that are near to singular.
  EXPECT_GT(narrow, 200);
  EXPECT_GE(within, narrow - 3);
  EXPECT_GT(others, 30);
  EXPECT_GT(loops, 30);
  EXPECT_GT(trees, 60);
}

TEST(Bilateral, LongChainTakesOneFactorisationAndFewRefinements) {
  const Scene scene = pinned_chain(400, {.noise = 1});
  const Solution solution = solve_auto(scene.system, {}, {.tolerance = 1e-12}, nullptr);
  EXPECT_EQ(solution.method, "bilateral");
  EXPECT_EQ(solution.status, SolveStatus::Solved);
  EXPECT_LE(solution.residual, 1e-12);
  EXPECT_EQ(solution.work.factorisations, 1);
  EXPECT_LE(solution.work.resolves, 5);
}

TEST(Bilateral, DependentRowsShareTheirImpulse) {
  // A beam on two pins: along it, one row too many.
  SceneBuilder builder({});
  builder.body({0, 0}, 2, 1);
  builder.pin(-1, 0, {-1, 0});
  builder.pin(-1, 0, {1, 0});
  Scene scene = builder.finish();
  scene.system.b = {0.3, 0.1, 0.3, 0.1};
  const Solution solution = solve_auto(scene.system, {}, {}, nullptr);
  EXPECT_EQ(solution.method, "bilateral");
  EXPECT_EQ(solution.status, SolveStatus::Solved);
  EXPECT_NEAR(solution.lambda[0], 0.3, 1e-12);
  EXPECT_NEAR(solution.lambda[2], 0.3, 1e-12);
  EXPECT_NEAR(solution.lambda[1], solution.lambda[3], 1e-12);
}

TEST(Bilateral, RowsThatContradictEachOtherAreNotSolved) {
  SceneBuilder builder({});
  builder.body({0, 0}, 2, 1);
  builder.pin(-1, 0, {-1, 0});
  builder.pin(-1, 0, {1, 0});
  Scene scene = builder.finish();
  scene.system.b = {0.3, 0.1, -0.3, 0.1};
  for (const auto& solve : {solve_bilateral, solve_auto}) {
    const Solution solution = solve(scene.system, {}, {}, nullptr);
    EXPECT_EQ(solution.status, SolveStatus::Inexact);
    EXPECT_GE(solution.residual, 0.9);
    for (const double z : solution.lambda) EXPECT_TRUE(std::isfinite(z));
  }
}

TEST(Bilateral, LoopsThatContradictEachOtherGetLeastSquaresByOneFactor) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    // A net of hinged bodies: its loops have more rows than its bodies have ways to move.
    const int width = 6 + static_cast<int>(seed), height = 7;
    SceneBuilder builder({.noise = 1, .seed = seed});
    const auto place = [width](int i) {
      const int row = i / width, column = i % width;
      return Vec2{static_cast<double>(column), -static_cast<double>(row)};
    };
    for (int i = 0; i < width * height; ++i) builder.body(place(i), 1 + i % 3, 0.1);
    builder.pin(-1, 0, {0, 0.5});
    for (int i = 0; i < width * height; ++i) {
      const auto [x, y] = place(i);
      if (i % width + 1 < width) builder.pin(i, i + 1, {x + 0.5, y});
      if (i + width < width * height) builder.pin(i, i + width, {x, y - 0.5});
    }
    Scene scene = builder.finish();
    for (std::size_t i = 0; i < scene.system.b.size(); ++i)
      scene.system.b[i] += 0.1 * std::sin(static_cast<double>(i * i + seed));
    const IslandSystem& system = scene.system;
    ASSERT_GT(system.rows.size(), 3 * system.bodies.size());
    const Solution solution = solve_auto(system, {}, {.tolerance = 1e-9}, nullptr);
    EXPECT_EQ(solution.method, "bilateral");
    EXPECT_EQ(solution.status, SolveStatus::Inexact);
    EXPECT_EQ(solution.work.factorisations, 1);
    EXPECT_GT(solution.residual, 1e-3);
    // Least squares weighted with 1 / W_ii: no impulses change what is left.
    const auto velocities = [&](const std::vector<double>& impulses) {
      std::vector<std::array<double, 3>> v(system.bodies.size());
      apply_impulses(system, impulses, v);
      std::vector<double> along_rows(system.rows.size());
      for (std::size_t i = 0; i < along_rows.size(); ++i) {
        const Row& row = system.rows[i];
        if (row.a >= 0) along_rows[i] += along(row.Ja, v[static_cast<std::size_t>(row.a)]);
        if (row.b >= 0) along_rows[i] += along(row.Jb, v[static_cast<std::size_t>(row.b)]);
      }
      return along_rows;
    };
    std::vector<double> left = velocities(solution.lambda);
    for (std::size_t i = 0; i < left.size(); ++i) {
      std::vector<double> unit(left.size(), 0);
      unit[i] = 1;
      left[i] = (system.b[i] - left[i]) / velocities(unit)[i];
    }
    for (const double rate : velocities(left)) EXPECT_NEAR(rate, 0, 1e-6);
  }
}

TEST(Bilateral, LeavesBoundsAndBodiesThatDoNotMoveToOthers) {
  const Scene contacts = scenes::stack(2);
  EXPECT_FALSE(is_bilateral(contacts.system));
  const Solution refused = solve_bilateral(contacts.system, {}, {}, nullptr);
  EXPECT_EQ(refused.status, SolveStatus::Unsupported);

  // Nothing can answer a row between bodies that do not move; zero rows are answered by nothing.
  Scene fixed = pinned_chain(1, {});
  fixed.system.bodies[0] = {0, 0};
  EXPECT_NE(solve_bilateral(fixed.system, {}, {}, nullptr).status, SolveStatus::Solved);
  EXPECT_EQ(solve_bilateral(IslandSystem{}, {}, {}, nullptr).status, SolveStatus::Solved);
}

TEST(Bilateral, KeptOrderGivesTheSameBits) {
  std::unique_ptr<SolverMemory> memory;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Scene scene = pinned_tree(40, {.noise = 1, .seed = seed});
    const Solution kept = solve_auto(scene.system, {}, {}, &memory);
    const Solution fresh = solve_auto(scene.system, {}, {}, nullptr);
    ASSERT_EQ(kept.lambda.size(), fresh.lambda.size());
    EXPECT_EQ(std::memcmp(kept.lambda.data(), fresh.lambda.data(), kept.lambda.size() * sizeof(double)), 0);
    EXPECT_EQ(kept.work.symbolic_analyses, seed == 1 ? 1 : 0);
  }
}

}  // namespace bilateral_test
}  // namespace skerry
