// SPDX-License-Identifier: MIT
//
// The stepper that chooses: who makes which island's step, and that the choice shows in nothing else.
#include <cmath>
#include <gtest/gtest.h>

#include "tests/support/worlds.h"

namespace skerry {
namespace auto_stepper_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;

constexpr double kStep = 1.0 / 60;

WorldConfig by_choice() {
  WorldConfig config;
  config.stepper = "auto";
  return config;
}

/// Islands of one step by what their report says.
int count_of(const StepReport& report, std::string_view stepper) {
  return static_cast<int>(std::count_if(report.islands_list.begin(), report.islands_list.end(),
                                        [&](const IslandReport& x) { return x.stepper == stepper; }));
}

TEST(AutoStepper, QuietIslandsGoByEventsBusyOnesByTimeSteppingInTheSameStep) {
  World world(by_choice());
  add_ground(world, rough(make_disc(1), 0.4));
  add(world, {-50, 0.5}, rough(make_disc(0.5), 0.4), 1, {3, 0});
  // A row that is shaken by many hits at once: a ball rattles in a narrow slot.
  const auto walls = world.create_body({.type = BodyType::Static});
  world.add_shape(walls, smooth(make_box({1, 2}, {49.0, 1}), 1));
  world.add_shape(walls, smooth(make_box({1, 2}, {51.2, 1}), 1));
  add(world, {50.1, 0.5}, smooth(make_disc(0.5), 1), 1, {150, 0});
  int busy = 0;
  for (int i = 0; i < 30; ++i) {
    const StepReport& report = world.step(kStep);
    ASSERT_EQ(report.islands, 2);
    EXPECT_EQ(report.islands_list[0].stepper, "event_driven") << i;
    EXPECT_EQ(report.islands_by_events, count_of(report, "event_driven"));
    EXPECT_EQ(report.islands_by_time_stepping, count_of(report, "time_stepping"));
    busy += report.islands_list[1].stepper == "time_stepping";
  }
  EXPECT_EQ(busy, 30);
}

TEST(AutoStepper, GoesBackToEventsWhenTheIslandHasCalmedDown) {
  World world(by_choice());
  const double e = 0.9;
  const auto walls = world.create_body({.type = BodyType::Static});
  world.add_shape(walls, smooth(make_half_plane({-0.55, 0}, {1, 0}), e));
  world.add_shape(walls, smooth(make_half_plane({0.55, 0}, {-1, 0}), e));
  add_ground(world, smooth(make_disc(1)));
  add(world, {0, 0.5}, smooth(make_disc(0.5), e), 1, {200, 0});
  std::vector<std::string_view> by;
  for (int i = 0; i < 60; ++i) by.push_back(world.step(kStep).islands_list[0].stepper);
  EXPECT_EQ(by.front(), "time_stepping");
  EXPECT_EQ(by.back(), "event_driven");
  // One change, no flicker.
  EXPECT_EQ(std::count(by.begin(), by.end(), "time_stepping"),
            std::find(by.begin(), by.end(), "event_driven") - by.begin());
}

TEST(AutoStepper, RestingIslandsDoNoWork) {
  World world(by_choice());
  add_ground(world, rough(make_disc(1), 0.5));
  for (int i = 0; i < 5; ++i) add(world, {0, i + 0.5}, rough(make_box({1, 1}), 0.5));
  for (int i = 0; i < 30; ++i) world.step(kStep);
  const StepReport& report = world.step(kStep);
  EXPECT_EQ(report.islands_at_rest, 1);
  EXPECT_EQ(report.force_solves, 0);
  EXPECT_EQ(report.work.factorisations, 0);
  EXPECT_EQ(report.islands_by_events + report.islands_by_time_stepping, 0);
}

TEST(AutoStepper, LongChainsGoByEventsWhereAnAccuracyIsAskedFor) {
  // By steps of second order, halved until they agree to 1e-6, a step of this chain takes a second.
  for (const bool asked : {false, true}) {
    WorldConfig config = by_choice();
    if (asked) config.accuracy = 1e-6;
    World world(config);
    const int links = 30;
    const double l = 1.0 / links;
    BodyId last = world.create_body({.type = BodyType::Static});
    for (int i = 0; i < links; ++i) {
      ShapeDef link = smooth(make_box({l, 0.02 * l}));
      link.sensor = true;
      const BodyId body = add(world, {(i + 0.5) * l, 0}, link, l);
      world.create_joint({.kind = JointKind::Revolute, .a = last, .b = body, .anchor_a = {i * l, 0}});
      last = body;
    }
    const double energy = world.kinetic_energy() + world.potential_energy();
    for (int step = 0; step < 60; ++step) {
      world.step(1.0 / 240);
      EXPECT_EQ(count_of(world.report(), asked ? "event_driven" : "time_stepping"), 1) << step;
    }
    if (asked) {
      EXPECT_NEAR(world.kinetic_energy() + world.potential_energy(), energy, 1e-6);
    }
  }
}

TEST(AutoStepper, BowlingLawHoldsToRounding) {
  const double mu = 0.2, v0 = 3, r = 0.5, g = 9.81;
  World world(by_choice());
  add_ground(world, rough(make_disc(1), mu));
  const auto disc = add(world, {0, r}, rough(make_disc(r), mu), 1, {v0, 0});
  for (int i = 0; i < 60; ++i) world.step(kStep);
  const double time = v0 / (3 * mu * g), path = 5 * v0 * v0 / (18 * mu * g);
  EXPECT_NEAR(world.velocity(disc).x, 2 * v0 / 3, 1e-12);
  EXPECT_NEAR(world.position(disc).x, path + 2 * v0 / 3 * (1 - time), 1e-12);
}

TEST(AutoStepper, ChoosesAlikeForAnyNumberOfThreadsAndAnyBroadPhase) {
  const auto run = [](int threads, std::string_view broad_phase) {
    WorldConfig config = by_choice();
    config.threads = threads;
    config.broad_phase = broad_phase;
    World world(config);
    add_ground(world, rough(make_disc(1), 0.4, 0.3));
    for (int i = 0; i < 12; ++i) {
      add(world, {1.7 * (i % 6), 1 + 1.3 * (i / 6) + 0.01 * i},
          i % 2 == 0 ? rough(make_disc(0.4), 0.4, 0.3) : rough(make_box({0.8, 0.6}), 0.4, 0.3), 1,
          {0.1 * (i % 5), 0}, 0.5);
    }
    std::vector<std::uint64_t> trail;
    for (int i = 0; i < 60; ++i) {
      const StepReport& report = world.step(kStep);
      trail.push_back(report.state_hash);
      trail.push_back(static_cast<std::uint64_t>(report.islands_by_events));
    }
    return trail;
  };
  const auto expected = run(1, "brute_force");
  EXPECT_EQ(run(3, "brute_force"), expected);
  EXPECT_EQ(run(1, "uniform_grid"), expected);
}

}  // namespace auto_stepper_test
}  // namespace skerry
