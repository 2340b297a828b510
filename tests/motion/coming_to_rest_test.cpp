// SPDX-License-Identifier: MIT
//
// Heaps in flow come to rest where there are forces that hold them, and nowhere else.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <random>
#include <vector>

#include "physics/solver/associated_path.h"
#include "tests/bench/everyday_scenes.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace coming_to_rest_test {

constexpr double kStep = 1.0 / 60;

/// Boxes of 0.5 to 1 m in loose columns between two walls.
std::vector<BodyId> add_boxes(World& world, int count, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (random() / 4294967296.0);
  };
  const double width = 0.7 * std::sqrt(count);
  const int columns = static_cast<int>(2 * width / 1.4);
  const BodyId ground = test::add_ground(world, test::rough(make_box({1, 1}), 0.5));
  for (const Vec2 normal : {Vec2{1, 0}, Vec2{-1, 0}})
    world.add_shape(ground, test::rough(make_half_plane({-width * normal.x, 0}, normal), 0.5));
  std::vector<BodyId> boxes;
  for (int i = 0; i < count; ++i) {
    const Vec2 size{uniform(0.5, 1), uniform(0.5, 1)};
    const int row = i / columns;
    const Vec2 place{-width + 0.7 + 1.4 * (i % columns) + 0.05 * (row % 2), 0.8 + 1.4 * row};
    boxes.push_back(test::add(world, place, test::rough(make_box(size), 0.5), size.x * size.y, {}, 0,
                              uniform(-0.3, 0.3)));
  }
  return boxes;
}

TEST(ComingToRest, AHeapOfBoxesFallsAsleepWithExactForces) {
  // Of 48 heaps 43 sleep after 1800 steps, 41 exactly (`solver_flow_bench --resting 48 "600 boxes"`).
  int exact = 0, restless = 0;
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    World world;
    const std::vector<BodyId> boxes = add_boxes(world, 600, seed);
    int steps = 0, flowing = 0;
    const auto asleep = [&] {
      return std::count(world.bodies().asleep.begin(), world.bodies().asleep.end(), 1);
    };
    // In the median they take 720 steps.
    while (steps < 1500 && asleep() < 580) {
      flowing += world.step(kStep).islands_in_flow;
      ++steps;
    }
    const bool is_exact = world.report().inexact_islands == 0;
    std::printf("seed %u: %td asleep after %d steps, with %s forces\n", seed, asleep(), steps,
                is_exact ? "exact" : "nearly exact");
    EXPECT_GT(flowing, 200);
    // A body that swings between two others may go on for ever.
    if (asleep() < 580) {
      ++restless;
      continue;
    }
    if (!is_exact) continue;
    ++exact;
    EXPECT_LE(world.report().worst_residual, 1e-10);
    EXPECT_LE(world.report().worst_penetration, 1e-9);
    // What sleeps would go on resting.
    std::vector<BodyId> still;
    std::vector<Vec2> places;
    for (const BodyId box : boxes) {
      if (!world.asleep(box)) continue;
      still.push_back(box);
      places.push_back(world.position(box));
    }
    WorldConfig awake = world.config();
    awake.sleep = awake.reuse_resting = false;
    world.reconfigure(awake);
    int flows = 0;
    double residual = 0;
    for (int k = 0; k < 30; ++k) {
      const StepReport& next = world.step(kStep);
      flows += next.islands_in_flow;
      residual = std::max(residual, next.worst_residual);
    }
    EXPECT_EQ(flows, 0);
    EXPECT_LE(residual, 1e-10);
    double farthest = 0;
    for (std::size_t i = 0; i < still.size(); ++i)
      farthest = std::max(farthest, length(world.position(still[i]) - places[i]));
    EXPECT_LE(farthest, 1e-9);
  }
  EXPECT_LE(restless, 2);
  EXPECT_GE(exact, 2);
}

/// Bricks that fall into place by a hundredth of their height: forces by which a piece of a step cannot be
/// made well are given up before they lead to an impact of the whole pile, solved in vain, and to another one
/// of its own: twenty times what a step in flow costs.
TEST(ComingToRest, ForcesThatAreFarFromAnAnswerMakeNoPieceOfAStep) {
  World world;
  test::add_ground(world, test::rough(make_box({1, 1}), 0.6));
  std::mt19937 random(1);
  const auto noise = [&] { return 0.02 * (random() / 2147483648.0 - 1); };
  constexpr int base = 45;
  for (int row = 0; row < base; ++row)
    for (int k = 0; k < base - row; ++k)
      test::add(world, {k + 0.5 * row + noise(), 0.5 + 1.01 * row}, test::rough(make_box({0.98, 1}), 0.6),
                0.98, {noise(), noise()});
  int flowing = 0, attempts = 0;
  for (int k = 0; k < 60; ++k) {
    const StepReport& report = world.step(kStep);
    if (report.islands != 1 || report.islands_in_flow != 1) continue;
    ++flowing;
    attempts += report.work.factorisations > 0;
    EXPECT_EQ(report.substeps, 1) << k;
  }
  std::printf("%d steps in flow, %d attempts\n", flowing, attempts);
  EXPECT_GT(flowing, 10);
  EXPECT_GT(attempts, 0);
}

/// The top has to move by what the gaps of 77 layers add up to.
TEST(ComingToRest, TheGapsOfALargePileAreClosed) {
  const scale::Scene scene = scale::loose_pyramid();
  WorldConfig config;
  config.gravity = scene.gravity;
  World world(config);
  for (const scale::Item& item : scene.items) {
    const BodyId body =
        world.create_body({.type = item.type, .position = item.at, .velocity = item.velocity});
    const Vec2 half = item.parts.front().half;
    world.add_shape(body, test::rough(make_box({2 * half.x, 2 * half.y}), scene.friction));
  }
  int step = 0, dear = 0;
  bool rests = false;
  for (; step < 240 && !rests; ++step) {
    const StepReport& report = world.step(kStep);
    rests = report.inexact_islands == 0 && world.kinetic_energy() < 1e-12;
    dear += report.work.factorisations > 30;
  }
  std::printf("%s after %d steps, %d of them with more than 30 factors\n", rests ? "exact" : "not exact",
              step, dear);
  EXPECT_TRUE(rests);
  // Looks that are in vain for a single brick do not factor.
  EXPECT_LE(dear, 1);
}

/// The problem of rest of a row of boxes on a slope: bodies that do not move yet, and gravity.
IslandSystem row_on_a_slope(double angle, double friction) {
  World world;
  const ShapeDef box = test::rough(make_box({1, 1}), friction);
  test::add_ground(world, box, angle);
  const Rot q = Rot::from_angle(angle);
  for (int i = 0; i < 12; ++i)
    test::add(world, rotate(q, {static_cast<double>(i), 0.5}), box, 1, {}, 0, angle);
  world.observe({.systems = true});
  world.step(kStep);
  for (const IslandTrace& trace : world.report().traces)
    if (!trace.impact) return trace.system;
  return {};
}

TEST(ComingToRest, AsksForForcesThatHold) {
  const double angle = kPi / 6;
  const IslandSystem holds = row_on_a_slope(angle, 0.6), slides = row_on_a_slope(angle, 0.5);
  ASSERT_GE(holds.size(), 48);
  ASSERT_GE(slides.size(), 48);
  const Solution rest = find_rest(holds, {}, {});
  EXPECT_EQ(rest.status, SolveStatus::Solved);
  for (const double u : row_velocities(holds, rest.lambda)) EXPECT_NEAR(u, 0, 1e-11);
  // Next to forces that hold it takes fewer factors to find them.
  const Solution again = find_rest(holds, rest.lambda, {});
  EXPECT_EQ(again.status, SolveStatus::Solved);
  EXPECT_LT(again.work.factorisations, rest.work.factorisations);
  const Solution motion = find_rest(slides, {}, {});
  EXPECT_NE(motion.status, SolveStatus::Solved);
  EXPECT_LE(motion.work.factorisations, 60);
}

}  // namespace coming_to_rest_test
}  // namespace skerry
