// SPDX-License-Identifier: MIT
//
// What the event-driven stepper shows an observer of its forces: contact problems like those of other
// steppers.
#include <cmath>
#include <functional>
#include <gtest/gtest.h>

#include "tests/support/worlds.h"

namespace skerry {
namespace event_traces_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;

constexpr double kG = 9.81, kStep = 0.05;

/// The last problem of forces of a world's step.
const IslandTrace* last_forces(const StepReport& report) {
  const IslandTrace* last = nullptr;
  for (const IslandTrace& trace : report.traces)
    if (!trace.impact) last = &trace;
  return last;
}

struct Scene {
  const char* name;
  std::function<void(World&)> build;
  int steps;
  double impulse;  ///< sum over the normal or joint rows [N s]; 0: not known
};

void box_on_slope(World& world, double friction, double speed) {
  const double angle = kPi / 6;
  const Rot q = Rot::from_angle(angle);
  add_ground(world, rough(make_box({1, 1}), friction), angle);
  add(world, rotate(q, {0, 0.5}), rough(make_box({1, 1}), friction), 2, rotate(q, {speed, 0}), 0, angle);
}

TEST(EventTraces, ForcesOfAStepSolveTheProblemThatIsShown) {
  const double load = 2 * kG * std::cos(kPi / 6) * kStep;
  const Scene scenes[] = {
      {"sticks", [](World& world) { box_on_slope(world, 0.8, 0); }, 1, load},
      {"slides down", [](World& world) { box_on_slope(world, 0.3, -1); }, 3, load},
      // It stops in the middle of the step: what would hold it until the end is less than what slides.
      {"slides to a stop", [](World& world) { box_on_slope(world, 0.8, 0.1); }, 1, load},
      {"rolls",
       [](World& world) {
         add_ground(world, rough(make_box({1, 1}), 0.5), kPi / 6);
         add(world, rotate(Rot::from_angle(kPi / 6), {0, 0.5}), rough(make_disc(0.5), 0.5), 2);
       },
       2, load},
      {"hangs",
       [](World& world) {
         const BodyId body = add(world, {0, -1}, rough(make_disc(0.1), 0), 2);
         world.create_joint({.kind = JointKind::Distance, .b = body, .anchor_b = {0, -1}});
       },
       1, 2 * kG * kStep},
  };
  for (const Scene& scene : scenes) {
    World worlds[2];
    for (int watched = 0; watched < 2; ++watched) {
      WorldConfig config;
      config.stepper = "event_driven";
      World& world = worlds[watched] = World(config);
      scene.build(world);
      if (watched) world.observe({.systems = true});
      for (int i = 0; i < scene.steps; ++i) world.step(kStep);
      EXPECT_EQ(world.report().fallbacks, 0) << scene.name;
    }
    EXPECT_EQ(worlds[0].state_hash(), worlds[1].state_hash()) << scene.name << ": who looks changes nothing";
    const IslandTrace* trace = last_forces(worlds[1].report());
    ASSERT_NE(trace, nullptr) << scene.name;
    EXPECT_LE(natural_map_residual(trace->system, trace->lambda), 1e-10) << scene.name;
    EXPECT_EQ(trace->status, SolveStatus::Solved) << scene.name;
    EXPECT_EQ(trace->bodies.size(), trace->system.bodies.size()) << scene.name;
    double sum = 0;
    for (std::size_t i = 0; i < trace->lambda.size(); ++i)
      if (trace->system.rows[i].kind != RowKind::Friction) sum += std::abs(trace->lambda[i]);
    EXPECT_NEAR(sum, scene.impulse, 1e-9) << scene.name;
  }
}

// Where it slides, W lambda - b is how fast it does when the step ends.
TEST(EventTraces, OfWhatSlidesTellHowFast) {
  World world({.stepper = "event_driven"});
  box_on_slope(world, 0.3, -1);
  world.observe({.systems = true});
  for (int i = 0; i < 3; ++i) world.step(kStep);
  const IslandTrace* trace = last_forces(world.report());
  ASSERT_NE(trace, nullptr);
  const std::vector<double> after = row_velocities(trace->system, trace->lambda);
  const double speed = 1 + 3 * kStep * kG * (std::sin(kPi / 6) - 0.3 * std::cos(kPi / 6));
  int rubs = 0;
  for (std::size_t i = 0; i < after.size(); ++i) {
    if (trace->system.rows[i].kind != RowKind::Friction) continue;
    ++rubs;
    EXPECT_NEAR(std::abs(after[i]), speed, 1e-9);
  }
  EXPECT_GT(rubs, 0);
}

TEST(EventTraces, WhatFliesHasNoProblem) {
  WorldConfig config;
  config.stepper = "event_driven";
  World world(config);
  add(world, {0, 5}, rough(make_disc(0.5), 0.5));
  world.observe({.systems = true});
  world.step(kStep);
  EXPECT_TRUE(world.report().traces.empty());
}

TEST(Report, TracesTellTheTimeOfTheWorld) {
  World world;
  world.observe({.systems = true});
  add_ground(world, smooth(make_disc(1), 0.5));
  add(world, {0, 1.5}, smooth(make_disc(0.5), 0.5));
  bool struck = false;
  for (int i = 0; i < 60 && !struck; ++i) {
    for (const IslandTrace& trace : world.step(1.0 / 60).traces) {
      EXPECT_GE(trace.time, world.time() - 1.0 / 60 - 1e-12);
      EXPECT_LE(trace.time, world.time() + 1e-12);
      if (!trace.impact) continue;
      struck = true;
      EXPECT_NEAR(trace.time, std::sqrt(2 / 9.81), 1e-9);
    }
  }
  EXPECT_TRUE(struck);
}

}  // namespace event_traces_test
}  // namespace skerry
