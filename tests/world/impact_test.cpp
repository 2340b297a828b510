// SPDX-License-Identifier: MIT
//
// Impacts against closed forms.
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "physics/solver/impact_law.h"
#include "physics/solver/impact_laws.h"
#include "physics/solver/solver.h"
#include "tests/support/draw.h"
#include "tests/support/island_scenes.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace impact_test {

using test::add;
using test::add_row;
using test::smooth;
using test::weightless;

double energy_scale(double value) {
  return std::max(1.0, std::abs(value));
}

struct CradleResult {
  std::vector<double> speeds;
  double energy_error;
  double momentum_error;
};

CradleResult run_cradle(const std::vector<double>& start, double gap, double seconds,
                        const WorldConfig& config = weightless()) {
  World world(config);
  const auto discs = add_row(world, start, 1, gap);
  const double energy = world.kinetic_energy();
  const double momentum = world.momentum().x;
  for (int i = 0; i < static_cast<int>(seconds * 60); ++i) world.step(1.0 / 60);
  CradleResult result;
  for (const BodyId disc : discs) result.speeds.push_back(world.velocity(disc).x);
  result.energy_error = std::abs(world.kinetic_energy() - energy) / energy_scale(energy);
  result.momentum_error = std::abs(world.momentum().x - momentum);
  return result;
}

class CradleOf : public testing::TestWithParam<int> {};

TEST_P(CradleOf, LastDiscLeavesWithTheSpeedOfTheFirst) {
  const int count = GetParam();
  // The first disc comes from 0.25 m away; the others touch.
  World world(weightless());
  std::vector<BodyId> discs;
  discs.push_back(add(world, {-1.25, 0}, smooth(make_disc(0.5), 1), 1, {1, 0}));
  for (int i = 0; i + 1 < count; ++i)
    discs.push_back(add(world, {static_cast<double>(i), 0}, smooth(make_disc(0.5), 1)));
  for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
  for (int i = 0; i < count; ++i) {
    EXPECT_NEAR(world.velocity(discs[i]).x, i + 1 == count ? 1.0 : 0.0, 1e-12)
        << "disc " << i << " of " << count;
    EXPECT_NEAR(world.velocity(discs[i]).y, 0, 1e-12);
    EXPECT_NEAR(world.omega(discs[i]), 0, 1e-12);
  }
  EXPECT_NEAR(world.kinetic_energy(), 0.5, 1e-13);
  EXPECT_NEAR(world.momentum().x, 1, 1e-13);
}

INSTANTIATE_TEST_SUITE_P(Cradle, CradleOf, testing::Values(2, 3, 5, 50));

TEST(Cradle, KDiscsInGiveKDiscsOut) {
  for (int k = 1; k <= 4; ++k) {
    std::vector<double> start(5, 0.0);
    for (int i = 0; i < k; ++i) start[i] = 1;
    const CradleResult result = run_cradle(start, 0, 0.1);
    for (int i = 0; i < 5; ++i) EXPECT_NEAR(result.speeds[i], i >= 5 - k ? 1.0 : 0.0, 1e-12) << "k = " << k;
    EXPECT_LE(result.energy_error, 1e-13);
    EXPECT_LE(result.momentum_error, 1e-13);
  }
}

TEST(Cradle, TwoDiscsFromBothSidesAtOnceLeaveSymmetrically) {
  World world(weightless());
  const auto left = add(world, {-1.5, 0}, smooth(make_disc(0.5), 1), 1, {1, 0});
  std::vector<BodyId> still;
  still.reserve(3);
  for (int i = 0; i < 3; ++i)
    still.push_back(add(world, {static_cast<double>(i), 0}, smooth(make_disc(0.5), 1)));
  const auto right = add(world, {3.5, 0}, smooth(make_disc(0.5), 1), 1, {-1, 0});
  for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
  EXPECT_NEAR(world.velocity(left).x, -1, 1e-12);
  EXPECT_NEAR(world.velocity(right).x, 1, 1e-12);
  for (const BodyId disc : still) EXPECT_NEAR(world.velocity(disc).x, 0, 1e-12);
}

TEST(Cradle, SeparatedDiscsPassTheSpeedOnOneAfterTheOther) {
  const CradleResult result = run_cradle({1, 0, 0, 0, 0}, 0.01, 1);
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(result.speeds[i], i == 4 ? 1.0 : 0.0, 1e-12);
}

TEST(ImpactLaws, ThreeTouchingDiscsShowTheDifference) {
  const std::vector<std::pair<const char*, std::vector<double>>> expected{
      {"reflections", {0, 0, 1}},
      {"simultaneous", {-1.0 / 3, 2.0 / 3, 2.0 / 3}},
      {"poisson", {-1.0 / 3, 2.0 / 3, 2.0 / 3}}};
  for (const auto& [law, speeds] : expected) {
    WorldConfig config = weightless();
    config.impact_law = law;
    const CradleResult result = run_cradle({1, 0, 0}, 0, 0.1, config);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(result.speeds[i], speeds[i], 1e-12) << law << ", disc " << i;
  }
}

TEST(ImpactLaws, UnknownNameListsTheKnownOnes) {
  try {
    find_impact_law("newton");
    FAIL();
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("reflections"), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("newton"), std::string::npos);
  }
}

TEST(Cradle, RestitutionBelowOneMixesElasticAndPlasticAnswers) {
  // All five touch: the plastic share 1 - e is spread evenly, the elastic one goes to the last.
  World world(weightless());
  std::vector<BodyId> discs;
  discs.reserve(5);
  for (int i = 0; i < 5; ++i) {
    discs.push_back(
        add(world, {static_cast<double>(i), 0}, smooth(make_disc(0.5), 0.9), 1, {i == 0 ? 1.0 : 0.0, 0}));
  }
  world.step(1e-6);
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(world.velocity(discs[i]).x, i == 4 ? 0.92 : 0.02, 1e-12);
}

TEST(SingleImpact, AgreesWithTheClosedFormForAllShapesAndMassRatios) {
  const unsigned seed = 11;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto shape = [&](int kind) {
    if (kind == 0) return make_disc(0.5);
    if (kind == 1) return make_box({1, 0.7});
    if (kind == 2) return make_capsule({-0.4, 0}, {0.4, 0.1}, 0.2);
    const std::vector<Vec2> corners{{-0.5, -0.4}, {0.6, -0.3}, {0.2, 0.6}};
    return make_polygon(corners);
  };
  int impacts = 0;
  for (int trial = 0; trial < 400; ++trial) {
    World world(weightless());
    const double ratio = std::pow(10.0, 6 * unit(random));
    const double e = 0.5 + 0.5 * unit(random);
    const int kind_a = trial % 4, kind_b = trial / 4 % 4;
    const auto a = add(world, {0, 0}, smooth(shape(kind_a), e), 1, {unit(random), unit(random)}, unit(random),
                       3 * unit(random));
    const auto b = add(world, {3, unit(random)}, smooth(shape(kind_b), e), ratio,
                       {-4 + unit(random), unit(random)}, unit(random), 3 * unit(random));
    world.observe({.contacts = true});
    for (int i = 0; i < 120; ++i) {
      const Vec2 va = world.velocity(a), vb = world.velocity(b);
      const double wa = world.omega(a), wb = world.omega(b);
      const Vec2 momentum = world.momentum();
      const double angular = world.angular_momentum();
      const StepReport& report = world.step(1.0 / 120);
      const double mass = 1 + ratio;
      ASSERT_NEAR(length(world.momentum() - momentum), 0, 1e-14 * mass * 5)
          << "seed " << seed << " trial " << trial;
      ASSERT_NEAR(world.angular_momentum(), angular, 1e-14 * mass * 50)
          << "seed " << seed << " trial " << trial;
      if (report.impacts != 1) continue;
      const auto hit = std::find_if(report.events.begin(), report.events.end(),
                                    [](const ContactEvent& x) { return x.kind == ContactEventKind::Hit; });
      ASSERT_NE(hit, report.events.end());
      ++impacts;
      // Relative approach and rebound along the normal obey e; the impulse is (1 + e) u / W.
      const double approach = hit->approach_speed;
      const double j = hit->impulse;
      const Vec2 dva = world.velocity(a) - va;
      const Vec2 dvb = world.velocity(b) - vb;
      ASSERT_NEAR(length(dva + j * hit->normal), 0, 1e-12 * std::max(1.0, j)) << "seed " << seed;
      ASSERT_NEAR(length(ratio * dvb - j * hit->normal), 0, 1e-12 * std::max(1.0, j) * std::max(1.0, ratio));
      const double ia = world.inertia(a), ib = world.inertia(b);
      // Energy: dT = -j u- (1 - e) / 2 for a single impact.
      const double before =
          0.5 * (length_squared(va) + ia * wa * wa + ratio * length_squared(vb) + ib * wb * wb);
      ASSERT_NEAR(world.kinetic_energy() - before, -0.5 * j * approach * (1 - e),
                  1e-12 * std::max(before, 1.0))
          << "seed " << seed << " trial " << trial;
      break;
    }
  }
  EXPECT_GT(impacts, 200);
}

TEST(SingleImpact, DiscsHeadOnFollowNewtonsFormula) {
  for (const double m2 : {1e-6, 0.25, 1.0, 7.0, 1e6}) {
    for (const double e : {0.0, 0.3, 1.0}) {
      World world(weightless());
      const auto a = add(world, {0, 0}, smooth(make_disc(0.5), e), 1, {2, 0});
      const auto b = add(world, {1.3, 0}, smooth(make_disc(0.5), e), m2, {-1, 0});
      for (int i = 0; i < 30; ++i) world.step(1.0 / 60);
      const double v1 = ((1 - e * m2) * 2 + (1 + e) * m2 * -1) / (1 + m2);
      const double v2 = ((m2 - e) * -1 + (1 + e) * 2) / (1 + m2);
      EXPECT_NEAR(world.velocity(a).x, v1, 1e-12 * std::max(1.0, std::abs(v1))) << "m2 " << m2 << " e " << e;
      EXPECT_NEAR(world.velocity(b).x, v2, 1e-12 * std::max(1.0, std::abs(v2))) << "m2 " << m2 << " e " << e;
    }
  }
}

TEST(SingleImpact, RodThatLandsOnItsEndFollowsTheClosedForm) {
  // Impulse of a uniform thin rod of length 2 and mass m falling flat-out at speed v, at angle t to the
  // floor: j = (1 + e) m v / (1 + 3 cos^2 t).
  for (const double t : {0.2, 0.7, 1.2}) {
    for (const double e : {0.0, 0.5, 1.0}) {
      World world(weightless());
      const auto ground = world.create_body({.type = BodyType::Static});
      world.add_shape(ground, smooth(make_half_plane({0, 0}, {0, 1}), e));
      const double r = 1e-6;
      const auto rod = world.create_body(
          {.position = {0, 1.2}, .angle = t, .velocity = {0, -3}, .mass = 2.0, .inertia = 2.0 / 3.0});
      world.add_shape(rod, smooth(make_capsule({-1, 0}, {1, 0}, r), e));
      for (int i = 0; i < 60 && world.report().impacts == 0; ++i) world.step(1.0 / 60);
      const double j = (1 + e) * 2 * 3 / (1 + 3 * std::cos(t) * std::cos(t));
      EXPECT_NEAR(world.velocity(rod).y, -3 + j / 2, 1e-12 * 10) << "t " << t << " e " << e;
      EXPECT_NEAR(world.omega(rod), -j * std::cos(t) / (2.0 / 3.0), 1e-12 * 20);
    }
  }
}

TEST(Impact, LightBallDroppedOnAHeavyOneReboundsThreeTimesAsFast) {
  World world(weightless());
  world.add_shape(world.create_body({.type = BodyType::Static}), smooth(make_half_plane({0, 0}, {0, 1}), 1));
  const auto heavy = add(world, {0, 1.0}, smooth(make_disc(0.5), 1), 1e9, {0, -1});
  const auto light = add(world, {0, 1.6 + 1e-3}, smooth(make_disc(0.1), 1), 1, {0, -1});
  for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
  EXPECT_NEAR(world.velocity(light).y, 3, 1e-8);
  EXPECT_NEAR(world.velocity(heavy).y, 1, 1e-8);
}

TEST(Impact, RackOfFifteenBreaksSymmetricallyAndKeepsItsEnergy) {
  World world(weightless());
  const double pitch = std::sqrt(3.0) / 2;
  std::vector<std::pair<BodyId, Vec2>> rack;
  for (int row = 0; row < 5; ++row) {
    for (int i = 0; i <= row; ++i) {
      const Vec2 at{row * pitch, i - 0.5 * row};
      rack.emplace_back(add(world, at, smooth(make_disc(0.5), 1)), at);
    }
  }
  const auto cue = add(world, {-1.5, 0}, smooth(make_disc(0.5), 1), 1, {1, 0});
  for (int i = 0; i < 40; ++i) world.step(1.0 / 60);
  EXPECT_NEAR(world.kinetic_energy(), 0.5, 1e-12);
  EXPECT_NEAR(world.momentum().x, 1, 1e-12);
  EXPECT_NEAR(world.velocity(cue).y, 0, 1e-12);
  for (const auto& [body, at] : rack) {
    for (const auto& [other, there] : rack) {
      if (std::abs(at.x - there.x) > 1e-9 || std::abs(at.y + there.y) > 1e-9) continue;
      EXPECT_NEAR(world.velocity(body).x, world.velocity(other).x, 1e-11);
      EXPECT_NEAR(world.velocity(body).y, -world.velocity(other).y, 1e-11);
    }
  }
}

TEST(Impact, BallBetweenTwoWallsEndsInsteadOfBouncingForEver) {
  World world(weightless());
  const auto walls = world.create_body({.type = BodyType::Static});
  world.add_shape(walls, smooth(make_half_plane({-0.5, 0}, {1, 0}), 1));
  world.add_shape(walls, smooth(make_half_plane({0.5, 0}, {-1, 0}), 1));
  const auto ball = add(world, {0, 0}, smooth(make_disc(0.5), 1), 1, {1, 0.3});
  world.step(1.0 / 60);
  EXPECT_NEAR(world.velocity(ball).x, 0, 1e-6);
  EXPECT_NEAR(world.velocity(ball).y, 0.3, 1e-12);
}

TEST(Impact, WhatJointsSqueezeDoesNotBounceForEver) {
  // One joint holds the body, another one pulls it on: no velocity is an answer, and any lets it approach.
  ImpactProblem problem;
  problem.system.bodies = {{1, 0}};
  problem.system.positions = {{0, 0}};
  for (const RowKind kind : {RowKind::Joint, RowKind::Joint, RowKind::Normal}) {
    Row row;
    row.kind = kind;
    row.b = 0;
    row.Jb = {1, 0, 0};
    if (kind == RowKind::Joint) row.lower = -kInfinity;
    problem.system.rows.push_back(row);
  }
  problem.system.b = {0, 0, 0};
  problem.drive = {0, 1, 0};
  problem.restitution = {0, 0, 0.9};
  problem.velocity = {{-1, 0, 0}};
  problem.solver = &find_solver("auto");
  const ImpactResult result = find_impact_law("reflections").apply(problem);
  EXPECT_LT(result.reflections, 1000);
  EXPECT_NE(result.status, SolveStatus::Solved);
  EXPECT_LE(std::abs(result.velocity[0][0]), 1.1);
}

TEST(Impact, RandomChainsEndKeepMomentumAndNeverGainEnergy) {
  const unsigned seed = 5;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> unit(0, 1);
  for (int trial = 0; trial < 40; ++trial) {
    World world(weightless());
    const int count = 3 + trial % 40;
    for (int i = 0; i < count; ++i) {
      add(world, {static_cast<double>(i), 0}, smooth(make_disc(0.5), trial % 2 ? 1 : unit(random)),
          std::pow(10.0, 2 * unit(random) - 1), {normal(random), 0});
    }
    const double energy = world.kinetic_energy();
    const double momentum = world.momentum().x;
    world.step(1e-9);
    EXPECT_LE(world.kinetic_energy(), energy * (1 + 1e-12)) << "seed " << seed << " trial " << trial;
    EXPECT_NEAR(world.momentum().x, momentum, 1e-11) << "seed " << seed << " trial " << trial;
    if (trial % 2) {
      EXPECT_NEAR(world.kinetic_energy(), energy, 1e-11 * energy);
    }
  }
}

// A mirror image of what joints are off by would make contacts approach in every round.
TEST(Impact, OfHingedBodiesEndsSoonThoughTheirJointsMoveApart) {
  const unsigned seed = 11;
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  int struck = 0;
  for (int trial = 0; trial < 60; ++trial) {
    World world(weightless());
    test::add_ground(world, test::rough(make_box({1, 1}), 0.5, 0.5));
    std::vector<BodyId> boxes;
    for (int i = 0; i < 2 + trial % 6; ++i) {
      boxes.push_back(add(world, {1.1 * i, 0.25}, test::rough(make_box({1, 0.5}), 0.5, 0.5), 1,
                          {normal(random), normal(random)}, normal(random)));
      if (i == 0) continue;
      world.create_joint({.a = boxes[i - 1], .b = boxes[i], .anchor_a = {1.1 * i - 0.55, 0.25}});
    }
    const double energy = world.kinetic_energy();
    const StepReport& report = world.step(1e-9);
    struck += report.impacts;
    EXPECT_LE(report.reflections, 500) << "seed " << seed << " trial " << trial;
    EXPECT_LE(world.kinetic_energy(), energy * (1 + 1e-12)) << "seed " << seed << " trial " << trial;
    for (std::size_t i = 1; i < boxes.size(); ++i) {
      const Vec2 hinge{1.1 * static_cast<double>(i) - 0.55, 0.25};
      const auto velocity = [&](BodyId body) {
        return world.velocity(body) + world.omega(body) * perp(hinge - world.position(body));
      };
      EXPECT_LE(length(velocity(boxes[i]) - velocity(boxes[i - 1])), 1e-7)
          << "seed " << seed << " trial " << trial;
    }
  }
  EXPECT_GT(struck, 50);
}

TEST(Reflections, LeaveNoApproachWhateverBouncesHowMuch) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    test::Draw draw(seed);
    const scenes::Scene scene = scenes::pyramid(4, {.friction = seed % 2 == 0 ? 0 : 0.5});
    ImpactProblem problem;
    problem.system = scene.system;
    problem.solver = &find_solver("auto");
    for (std::size_t k = 0; k < scene.system.bodies.size(); ++k)
      problem.velocity.push_back({draw.uniform(-1, 1), draw.uniform(-3, 1), draw.uniform(-2, 2)});
    problem.drive.assign(scene.system.rows.size(), 0);
    for (std::size_t i = 0; i < scene.system.rows.size(); ++i)
      problem.restitution.push_back(draw.one_in(2) ? 0.0 : draw.uniform(0.5, 1));
    const ImpactResult result = impact::apply_reflections(problem);
    for (std::size_t i = 0; i < scene.system.rows.size(); ++i) {
      const Row& row = scene.system.rows[i];
      if (row.kind != RowKind::Normal) continue;
      double speed = 0;
      for (std::size_t c = 0; c < 3; ++c) {
        if (row.a >= 0) speed += row.Ja[c] * result.velocity[static_cast<std::size_t>(row.a)][c];
        if (row.b >= 0) speed += row.Jb[c] * result.velocity[static_cast<std::size_t>(row.b)][c];
      }
      ASSERT_GT(speed, -1e-5) << "seed " << seed << ", row " << i;
    }
  }
}

}  // namespace impact_test
}  // namespace skerry
