// SPDX-License-Identifier: MIT
#include "physics/solver/local_update.h"

#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <random>

#include "physics/solver/body_space.h"
#include "physics/solver/body_space_model.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace local_update_test {

using scenes::Scene;

// Weights of an active set: each contact sticks, slips or is open.
struct Weights {
  std::vector<double> g, h;
};

void set_contact(Weights& weights, const BodySpaceModel& model, int normal, int state, double stiffness) {
  const std::size_t n = static_cast<std::size_t>(normal), t = n + 1;
  weights.g[n] = state == 0 ? 0 : stiffness / model.row(normal).D;
  weights.g[t] = state == 1 ? stiffness / model.row(normal + 1).D : 0;
  weights.h[t] = state >= 2 ? (state == 2 ? 0.5 : -0.5) * weights.g[n] : 0;
}

// What the active set asks for: an impulse where a row is stiff, moderate numbers elsewhere.
std::vector<double> wanted(const BodySpaceModel& model, const Weights& weights, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(-1, 1);
  std::vector<double> k(weights.g.size());
  for (int i = 0; i < model.rows(); ++i) {
    const std::size_t s = static_cast<std::size_t>(i);
    k[s] = weights.g[s] > 0 ? weights.g[s] * unit(random) : unit(random);
    if (weights.h[s] != 0) {
      const std::size_t n = static_cast<std::size_t>(model.row(i).normal);
      k[s] += weights.h[s] / weights.g[n] * k[n];
    }
  }
  return k;
}

double largest(const std::vector<double>& x) {
  double size = 0;
  for (const double v : x) size = std::max(size, std::fabs(v));
  return size;
}

TEST(LocalUpdate, SolvesLikeANewFactorForStatesThatChangeAgainAndAgain) {
  const Scene scene = scenes::pyramid(36);
  for (const double stiffness : {1.0, 1e3, 1e7}) {
    for (unsigned seed = 1; seed <= 4; ++seed) {
      SCOPED_TRACE("stiffness " + std::to_string(stiffness) + ", seed " + std::to_string(seed));
      std::mt19937 random(seed);
      BodySpaceModel model, fresh;
      SolveWork work;
      model.assign(scene.system, work);
      fresh.assign(scene.system, work);
      const int n = model.rows();
      Weights weights{std::vector<double>(scene.system.rows.size()),
                      std::vector<double>(scene.system.rows.size())};
      // With even seeds something slips in the factor already, which is then without symmetry.
      std::uniform_int_distribution<int> contact(0, n / 2 - 1), state(0, 3);
      for (int i = 0; i < n; i += 2) set_contact(weights, model, i, 1, stiffness);
      if (seed % 2 == 0)
        for (int k = 0; k < 5; ++k) set_contact(weights, model, 2 * contact(random), 2 + k % 2, stiffness);
      ASSERT_TRUE(model.factor(weights.g.data(), weights.h.data(), work));
      for (int round = 0; round < 6; ++round) {
        for (int k = 0; k < 3; ++k)
          set_contact(weights, model, 2 * contact(random), state(random), stiffness);
        ASSERT_TRUE(model.adapt(weights.g.data(), weights.h.data(), work));
        ASSERT_TRUE(fresh.factor(weights.g.data(), weights.h.data(), work));
        const std::vector<double> k = wanted(model, weights, random);
        std::vector<double> found(k.size()), expected(k.size());
        model.solve(k.data(), weights.g.data(), weights.h.data(), found.data(), work);
        fresh.solve(k.data(), weights.g.data(), weights.h.data(), expected.data(), work);
        // Impulses of stiff rows are differences of numbers as large as the stiffness.
        const double tolerance = 1e-12 * (largest(k) + largest(expected));
        for (std::size_t i = 0; i < k.size(); ++i)
          ASSERT_NEAR(found[i], expected[i], tolerance) << "row " << i;
      }
    }
  }
}

TEST(LocalUpdate, RefusesChangesOfManyRowsAndSmallFactors) {
  const Scene large = scenes::pyramid(36), small = scenes::stack(30);
  for (const Scene* scene : {&large, &small}) {
    BodySpaceModel model;
    SolveWork work;
    model.assign(scene->system, work);
    const std::size_t n = scene->system.rows.size();
    std::vector<double> g(n, 1.0), h(n, 0.0);
    EXPECT_FALSE(model.adapt(g.data(), h.data(), work)) << "without a factor";
    ASSERT_TRUE(model.factor(g.data(), h.data(), work));
    g[4] = 0;
    EXPECT_EQ(model.adapt(g.data(), h.data(), work), scene == &large);
    for (double& x : g) x *= 2;
    EXPECT_FALSE(model.adapt(g.data(), h.data(), work));
    // A new factor is one again.
    ASSERT_TRUE(model.factor(g.data(), h.data(), work));
    EXPECT_EQ(model.adapt(g.data(), h.data(), work), scene == &large) << "nothing has changed";
  }
}

// A part of the rows, solved for by itself, against all of them with a new factor.
TEST(LocalUpdate, SurroundingsFollowAsAllRowsDo) {
  const Scene scene = scenes::pyramid(36);
  for (const double stiffness : {1.0, 1e3, 1e7}) {
    for (unsigned seed = 1; seed <= 6; ++seed) {
      SCOPED_TRACE("stiffness " + std::to_string(stiffness) + ", seed " + std::to_string(seed));
      std::mt19937 random(seed);
      BodySpaceModel model, fresh;
      SolveWork work;
      model.assign(scene.system, work);
      fresh.assign(scene.system, work);
      const int n = model.rows();
      Weights weights{std::vector<double>(scene.system.rows.size()),
                      std::vector<double>(scene.system.rows.size())};
      for (int i = 0; i < n; i += 2) set_contact(weights, model, i, 1, stiffness);
      std::uniform_int_distribution<int> contact(0, n / 2 - 1), state(0, 3);
      // With even seeds something slips in the factor already.
      if (seed % 2 == 0)
        for (int k = 0; k < 5; ++k) set_contact(weights, model, 2 * contact(random), 2 + k % 2, stiffness);
      ASSERT_TRUE(model.factor(weights.g.data(), weights.h.data(), work));
      // Contacts side by side, so that there are rows around them.
      const int first = 2 * (contact(random) / 2);
      for (int k = 0; k < 8; ++k) set_contact(weights, model, (first + 2 * k) % n, state(random), stiffness);
      ASSERT_TRUE(model.adapt(weights.g.data(), weights.h.data(), work));
      BodySpaceModel::Surroundings around(model);
      ASSERT_GE(around.rows().size(), 8u);
      // Another change among them, which is what they are for.
      for (std::size_t k = 0; k < around.rows().size(); k += 5) {
        const int row = around.rows()[k], normal = model.row(row).normal;
        set_contact(weights, model, normal < 0 ? row : normal, state(random), stiffness);
      }
      std::vector<double> k(weights.g.size(), 0.0), expected(k.size()), w(k.size()), zero(k.size(), 0.0);
      std::uniform_real_distribution<double> unit(-1, 1);
      std::vector<int> followed;
      for (const int row : around.rows()) {
        const std::size_t i = static_cast<std::size_t>(row);
        const bool differs = weights.g[i] == 0 || weights.h[i] != 0;
        if (!differs) continue;
        followed.push_back(row);
        k[i] = unit(random);
      }
      ASSERT_FALSE(followed.empty());
      // Rows that differ from the factor only may want something: those that slipped in it go by their law.
      for (const int row : followed) {
        const std::size_t i = static_cast<std::size_t>(row);
        if (seed % 2 == 0 && weights.h[i] != 0) k[i] = 0;
      }
      ASSERT_TRUE(around.follow(weights.g.data(), weights.h.data(), k.data()));
      ASSERT_TRUE(fresh.factor(weights.g.data(), weights.h.data(), work));
      fresh.solve(k.data(), weights.g.data(), weights.h.data(), expected.data(), work);
      fresh.evaluate(expected.data(), w.data());
      fresh.evaluate(zero.data(), zero.data());
      const double tolerance = 1e-11 * (1 + largest(expected));
      for (std::size_t r = 0; r < around.rows().size(); ++r) {
        const std::size_t i = static_cast<std::size_t>(around.rows()[r]);
        double d_lambda = 0, d_w = 0;
        around.change(static_cast<int>(r), d_lambda, d_w);
        EXPECT_NEAR(d_lambda, expected[i], tolerance) << "row " << i;
        EXPECT_NEAR(d_w, w[i] - zero[i], tolerance) << "row " << i;
      }
    }
  }
}

// One body moves sideways.
IslandSystem pushed_at(IslandSystem system, int body) {
  for (std::size_t i = 0; i < system.rows.size(); ++i) {
    if (system.rows[i].a == body) system.b[i] -= system.rows[i].Ja[0] * 0.5;
    if (system.rows[i].b == body) system.b[i] -= system.rows[i].Jb[0] * 0.5;
  }
  return system;
}

TEST(LocalUpdate, PushesOnOneBoxOfAPyramidSeldomNeedANewFactor) {
  const Scene scene = scenes::pyramid(60);
  const int top = static_cast<int>(scene.system.bodies.size()) - 1;
  const IslandSystem pushed = pushed_at(scene.system, top);
  std::unique_ptr<SolverMemory> memory;
  Solution solution = solve_body_space(scene.system, {}, {}, &memory);
  int updates = 0, without = 0, solves = 0;
  for (int k = 0; k < 10; ++k) {
    solution = solve_body_space(k % 2 == 0 ? pushed : scene.system, solution.lambda, {}, &memory);
    EXPECT_EQ(solution.status, SolveStatus::Solved);
    EXPECT_LT(solution.residual, 1e-12);
    without += solution.work.factorisations == 0;
    updates += solution.work.partial_factorisations;
    solves += solution.work.resolves;
  }
  // The first ones still have the factor of the cold start.
  EXPECT_GE(without, 5);
  EXPECT_GE(updates, 10);
  // Rows around those that change settle by themselves: where all are solved for at each change it is 135.
  EXPECT_LE(solves, 60);
}

// Few boxes hold these down, and states of rows that hardly carry anything change in turn: where rows around
// them do not settle, the nearest that was found goes on, and the last few contradictions try each state.
TEST(LocalUpdate, PushesOnBoxesNearTheTopSettleInAFewSolves) {
  const Scene scene = scenes::pyramid(60);
  const int bodies = static_cast<int>(scene.system.bodies.size());
  std::unique_ptr<SolverMemory> memory;
  Solution solution = solve_body_space(scene.system, {}, {}, &memory);
  int solves = 0, factors = 0;
  for (int body = bodies - 21; body < bodies; ++body) {
    const IslandSystem pushed = pushed_at(scene.system, body);
    for (const IslandSystem* system : {&pushed, &scene.system}) {
      solution = solve_body_space(*system, solution.lambda, {}, &memory);
      EXPECT_EQ(solution.status, SolveStatus::Solved) << "body " << body;
      EXPECT_LT(solution.residual, 1e-12) << "body " << body;
      solves += solution.work.resolves;
      factors += solution.work.factorisations;
    }
  }
  std::printf("42 pushes: %d solves, %d factors\n", solves, factors);
  EXPECT_LE(solves, 42 * 7);
  EXPECT_LE(factors, 10);
}

TEST(LocalUpdate, GoesOnAfterARefusal) {
  const Scene scene = scenes::pyramid(36);
  BodySpaceModel model;
  SolveWork work;
  model.assign(scene.system, work);
  const std::size_t n = scene.system.rows.size();
  const std::vector<double> g(n, 1.0), h(n, 0.0);
  ASSERT_TRUE(model.factor(g.data(), h.data(), work));
  std::vector<double> many = g, few = g;
  for (std::size_t i = 0; i < n; i += n / 100) many[i] = 2;
  for (std::size_t k = 0; k < 5; ++k) few[k * (n / 100)] = 2;
  EXPECT_TRUE(model.adapt(few.data(), h.data(), work));
  ASSERT_TRUE(model.factor(g.data(), h.data(), work));
  EXPECT_FALSE(model.adapt(many.data(), h.data(), work));
  EXPECT_TRUE(model.adapt(few.data(), h.data(), work)) << "what was refused is forgotten";
}

}  // namespace local_update_test
}  // namespace skerry
