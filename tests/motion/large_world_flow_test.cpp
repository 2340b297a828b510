// SPDX-License-Identifier: MIT
//
// Which islands flow in worlds with less than 1000 visits a body (`stepping/one_piece_rule.h`), where a step
// in flow costs less than two pieces of an exact one.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <optional>
#include <random>
#include <vector>

#include "tests/support/draw.h"
#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace large_world_flow_test {

constexpr double kStep = 1.0 / 60, kLarge = 400;

World make_world(std::optional<double> flow_work) {
  WorldConfig config;
  config.flow_work = flow_work;
  config.gravity = {0, -10};
  return World(config);
}

/// A stack of boxes on the ground. @param speed  of the upper one
void add_sliding_stack(World& world, int count, double speed, double restitution = 0) {
  const ShapeDef box = test::rough(make_box({1, 1}), 0.5, restitution);
  test::add_ground(world, box);
  for (int i = 0; i < count; ++i) test::add(world, {0, i + 0.5}, box, 1, {i + 1 == count ? speed : 0, 0});
}

int flowing(std::optional<double> flow_work, int boxes, double speed, double restitution = 0) {
  World world = make_world(flow_work);
  add_sliding_stack(world, boxes, speed, restitution);
  return world.step(kStep).islands_in_flow;
}

TEST(FlowInLargeWorlds, TakesSmallIslandsOfWhichAFifthIsFast) {
  EXPECT_EQ(flowing(kLarge, 3, 2), 1);         // 2 of 6 points
  EXPECT_EQ(flowing(kLarge, 3, 0.05), 0);      // none
  EXPECT_EQ(flowing(kLarge, 2, 2), 0);         // 4 points are too few
  EXPECT_EQ(flowing(kLarge, 3, 2, 0.8), 0);    // bounces well
  EXPECT_EQ(flowing(std::nullopt, 3, 2), 0);   // a small world
  EXPECT_EQ(flowing(std::nullopt, 14, 2), 0);  // 2 of 28 points
  EXPECT_EQ(flowing(1000, 3, 2), 0);           // as much work as in a small one
  EXPECT_EQ(flowing(0, 3, 2), 0);              // switched off
}

TEST(FlowInLargeWorlds, TakesWhatALandingCuts) {
  // A box falls onto a stack of seven within the step: one of 16 points is fast, too few to flow at once.
  for (const bool large : {false, true}) {
    World world = make_world(large ? std::optional(kLarge) : std::nullopt);
    add_sliding_stack(world, 7, 0);
    const BodyId ball = test::add(world, {0, 7.5 + 0.04}, test::rough(make_disc(0.5), 0.5), 1, {0, -6});
    const StepReport& report = world.step(kStep);
    EXPECT_EQ(report.islands, 1);
    EXPECT_EQ(report.islands_in_flow, large ? 1 : 0);
    EXPECT_EQ(report.substeps, 2);
    // Sweeps leave a little of the blow, and say so.
    EXPECT_NEAR(world.velocity(ball).y, 0, large ? 0.05 * 6 : 1e-6);
    EXPECT_LE(report.worst_penetration, large ? 1e-3 : 1e-9);
    EXPECT_EQ(report.worst_residual > 1e-6, large);
  }
}

TEST(FlowInLargeWorlds, IsForCloudsThatDriftTogether) {
  // 144 bricks that touch and drift against each other more slowly than gravity moves them in a step.
  // What lies on the ground comes to rest, if it is stepped exactly; what falls never does.
  for (const bool held : {false, true}) {
    World world = make_world(kLarge);
    const ShapeDef brick = test::rough(make_box({1, 1}), 0.5);
    if (held) test::add_ground(world, brick);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> noise(-0.05, 0.05);
    for (int i = 0; i < 12; ++i) {
      for (int row = 0; row < 12; ++row) test::add(world, {1.0 * i, row + 0.5}, brick, 1, {noise(random), 0});
    }
    int flow = 0, exact = 0;
    for (int k = 0; k < 5; ++k) {
      const StepReport& report = world.step(kStep);
      flow += report.islands_in_flow;
      exact += report.islands_in_one_piece;
      EXPECT_LE(report.worst_penetration, 1e-3);
    }
    std::printf("%s: %d steps in flow, %d exact in one piece\n", held ? "held" : "falling", flow, exact);
    EXPECT_EQ(exact > 0, held);
    EXPECT_GE(held ? exact : flow, 1);
  }
}

/// Most and mean visits of a body in a step, and the mean of the deepest overlaps, of 1056 boxes and discs
/// that fall by a tenth of their size into a pit, over a second.
struct Heap {
  double most = 0, mean = 0, deep = 0;
};
Heap drop_heap(double spread_of_mass) {
  constexpr int wide = 44, high = 24, steps = 60;
  World world = make_world(std::nullopt);
  const ShapeDef wall = test::rough(make_box({4, 120}), 0.5);
  const BodyId ground = test::add_ground(world, wall);
  for (const int side : {-1, 1}) {
    ShapeDef def = wall;
    def.shape = make_box({4, 120}, {side * (0.575 * wide + 2), 60});
    world.add_shape(ground, def);
  }
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < wide * high; ++i) {
    const int row = i / wide;
    const double r = 0.45 + 0.1 * unit(random);
    const Vec2 at{1.15 * (i % wide - 0.5 * (wide - 1)), 0.6 + 1.15 * row};
    const ShapeDef shape = test::rough(i % 2 == 0 ? make_box({2 * r, 2 * r}) : make_disc(r), 0.5);
    test::add(world, at, shape, std::pow(spread_of_mass, unit(random)), {0.3 * unit(random) - 0.15, 0});
  }
  Heap heap;
  for (int k = 0; k < steps; ++k) {
    const StepReport& report = world.step(kStep);
    const double visits = report.work.visits / (wide * high);
    heap.most = std::max(heap.most, visits);
    heap.mean += visits / steps;
    heap.deep += report.worst_penetration / steps;
  }
  std::printf("masses to %g: %.0f visits a body, %.0f at most, overlaps %.4f m\n", spread_of_mass, heap.mean,
              heap.most, heap.deep);
  return heap;
}

TEST(FlowInLargeWorlds, GivesHeavyAmongLightFineWork) {
  // What comes to rest in a small island, by ten visits a body for each body, does not in a large one: that
  // cost 4000 visits a body here. Without points that others are pushed into overlaps are 0.0235 m.
  const Heap heavy = drop_heap(1000), even = drop_heap(1);
  EXPECT_LE(heavy.mean, 2000);
  EXPECT_GE(heavy.mean, 1.5 * even.mean);
  EXPECT_LE(heavy.deep, 0.021);
}

/// A column of boxes, 24 beside each other and 60 high, that comes down at 10 m/s: sweeps cannot find out in
/// a step how high what is pushed out of each other has to rise. What they push out, one by one, is pushed
/// into the next ones, and its step is made again for what it meets there.
TEST(FlowInLargeWorlds, ADeepCrushIsNotShakenByWhatIsPushedOut) {
  World world = make_world(std::nullopt);
  const ShapeDef box = test::rough(make_box({0.2, 0.2}), 0.5);
  const BodyId ground = test::add_ground(world, box);
  for (const int side : {-1, 1}) {
    ShapeDef wall = box;
    wall.shape = make_box({2, 40}, {side * 3.6, 20});
    world.add_shape(ground, wall);
  }
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int row = 0; row < 60; ++row) {
    for (int k = 0; k < 24; ++k) {
      const Vec2 at{0.21 * (k - 11.5) + 0.003 * unit(random), 0.15 + 0.21 * row};
      test::add(world, at, box, 1, {unit(random), -10}, unit(random));
    }
  }
  double deep = 0;
  int again = 0;
  constexpr int kSteps = 60;
  for (int k = 0; k < kSteps; ++k) {
    const StepReport& report = world.step(kStep);
    deep += report.worst_penetration / kSteps;
    again += report.island_retries;
  }
  std::printf("overlaps %.4f m, %d steps made again\n", deep, again);
  EXPECT_LE(deep, 0.1);
  EXPECT_LE(again, 20);
}

/// 225 boxes that fly about in a box at up to 10 m/s.
struct Bouncing {
  int flowing = 0;
  double kept = 0;  ///< share of the kinetic energy at the end
};
Bouncing bounce(double restitution, bool gravity, double speed, std::optional<double> flow_work) {
  WorldConfig config;
  config.flow_work = flow_work;
  config.gravity = {0, gravity ? -10.0 : 0.0};
  World world(config);
  const ShapeDef box = test::rough(make_box({1, 1}), 0, restitution);
  const BodyId walls = world.create_body({.type = BodyType::Static});
  for (const int side : {-1, 1}) {
    world.add_shape(walls, test::rough(make_box({2, 24}, {side * 11.0, 0}), 0, restitution));
    world.add_shape(walls, test::rough(make_box({24, 2}, {0, side * 11.0}), 0, restitution));
  }
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 15; ++i) {
    for (int k = 0; k < 15; ++k)
      test::add(world, {1.35 * (i - 7), 1.35 * (k - 7)}, box, 1, {speed * unit(random), speed * unit(random)},
                0, unit(random));
  }
  Bouncing result;
  const double before = world.kinetic_energy();
  double energy = before + world.potential_energy();
  for (int k = 0; k < 40; ++k) {
    result.flowing += world.step(kStep).islands_in_flow > 0;
    const double now = world.kinetic_energy() + world.potential_energy();
    EXPECT_LE(now, energy + 1e-9 * before) << "step " << k;
    energy = now;
  }
  result.kept = world.kinetic_energy() / before;
  return result;
}

TEST(FlowInLargeWorlds, IsForWhatBouncesWhereSomethingRestsAsInSmallOnes) {
  for (const std::optional<double> work : {std::optional(kLarge), std::optional<double>()}) {
    // What keeps all of its speed is exact, whatever it does.
    const Bouncing elastic = bounce(1, false, 30, work);
    EXPECT_EQ(elastic.flowing, 0);
    EXPECT_NEAR(elastic.kept, 1, 1e-9);
    const Bouncing balls = bounce(0.8, true, 10, work);
    std::printf("restitution 0.8: %d of 40 steps in flow, %.3f of the kinetic energy kept\n", balls.flowing,
                balls.kept);
    EXPECT_GE(balls.flowing, 10);
  }
}

TEST(FlowInLargeWorlds, BeginsAboveAThousandBodies) {
  for (const int count : {900, 1100}) {
    World world = make_world(std::nullopt);
    const ShapeDef box = test::rough(make_box({1, 1}), 0.5);
    test::add_ground(world, box);
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> noise(-1, 1);
    for (int i = 0; i < count; ++i) {
      const int row = i / 30;
      test::add(world, {1.05 * (i % 30) + 0.02 * noise(random), 0.55 + 1.05 * row}, box, 1,
                {3 * noise(random), -3});
    }
    double most = 0;
    for (int k = 0; k < 10; ++k)
      most = std::max(most, static_cast<double>(world.step(kStep).work.visits) / count);
    std::printf("%d bodies: %.0f visits a body and step at most\n", count, most);
    if (count < 1000) {
      EXPECT_GT(most, 700);
    } else {
      EXPECT_LT(most, 500);
    }
  }
}

TEST(FlowInLargeWorlds, AsksForExactAnswersSeldomOnceOneWasNotFound) {
  // A loose pyramid that falls into place.
  World world = make_world(kLarge);
  const ShapeDef brick = test::rough(make_box({0.98, 1}), 0.6);
  test::add_ground(world, brick);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> noise(-0.02, 0.02);
  constexpr int base = 36;
  for (int row = 0; row < base; ++row) {
    for (int k = 0; k < base - row; ++k)
      test::add(world, {k + 0.5 * row + noise(random), 0.5 + 1.01 * row}, brick, 1,
                {noise(random), noise(random)});
  }
  int attempts = 0, step = 0;
  for (; step < 200 && (step < 5 || world.report().inexact_islands > 0); ++step) {
    const StepReport& report = world.step(kStep);
    attempts += report.work.visits > 4 * kLarge * base * (base + 1) / 2;
  }
  std::printf("rests after %d steps; %d cost more than four in flow\n", step, attempts);
  // 6 where it asks again in the next step.
  EXPECT_LE(attempts, 3);
  EXPECT_LT(step, 120);
}

/// Where a few bodies end up that fall into a box. @param others  bodies elsewhere
std::vector<Vec2> fall_into_box(int seed, int others) {
  WorldConfig config;
  config.stepper = "event_driven";
  World world(config);
  test::Draw draw(static_cast<unsigned>(seed));
  const ShapeDef floor = test::rough(make_box({4, 1}, {0, -0.5}), 0.5);
  const BodyId box = world.create_body({.type = BodyType::Static});
  world.add_shape(box, floor);
  for (const double side : {-2.0, 2.0}) world.add_shape(box, test::rough(make_box({0.5, 4}, {side, 2}), 0.5));
  std::vector<BodyId> bodies;
  const int count = 4 + draw.pick(6);
  bodies.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    const Vec2 size{draw.uniform(0.2, 0.6), draw.uniform(0.2, 0.6)};
    const Shape shape = draw.one_in(2) ? make_disc(0.5 * size.x) : make_box(size);
    bodies.push_back(
        world.create_body({.position = {draw.uniform(-1, 1), 0.5 + 0.6 * i}, .angle = draw.uniform(-2, 2)}));
    world.add_shape(bodies.back(), test::rough(shape, 0.5));
  }
  for (int i = 0; i < others; ++i)
    world.add_shape(world.create_body({.position = {1000.0 + i, 0}, .gravity_scale = 0}),
                    test::smooth(make_disc(0.4)));
  for (int i = 0; i < 60; ++i) world.step(kStep);
  std::vector<Vec2> places;
  places.reserve(bodies.size());
  for (const BodyId body : bodies) places.push_back(world.position(body));
  return places;
}

/// Where a step by events is given up the island flowed in a large world: 5 of 72 such heaps were elsewhere
/// after a second, by up to 0.07 m.
TEST(FlowInLargeWorlds, LeavesWhatGoesByEventsAsItIsAlone) {
  int elsewhere = 0;
  double farthest = 0;
  for (int seed = 0; seed < test_scale(24); ++seed) {
    const std::vector<Vec2> alone = fall_into_box(seed, 0), beside = fall_into_box(seed, 1000);
    double far = 0;
    for (std::size_t i = 0; i < alone.size(); ++i) far = std::max(far, length(alone[i] - beside[i]));
    elsewhere += far > 1e-3;
    farthest = std::max(farthest, far);
  }
  std::printf("%d of %d heaps are elsewhere, by up to %.2g m\n", elsewhere, test_scale(24), farthest);
  EXPECT_EQ(elsewhere, 0);
}

}  // namespace large_world_flow_test
}  // namespace skerry
