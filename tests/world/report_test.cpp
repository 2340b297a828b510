// SPDX-License-Identifier: MIT
//
// The report of a step: sums over bodies and contacts, and counts.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <vector>

#include "tests/support/worlds.h"

namespace skerry {
namespace report_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;
using test::weightless;

TEST(Report, SaysWhichBroadPhaseFoundThePairsAndWhyAndFollowsItsChanges) {
  for (const BroadPhaseEntry& entry : broad_phases()) {
    WorldConfig config;
    config.broad_phase = entry.name;
    World world(config);
    add(world, {0, 0}, smooth(make_disc(0.5)));
    const BroadPhaseChoice choice = world.step(1.0 / 60).broad_phase;
    const bool is_auto = entry.name == "auto";
    EXPECT_EQ(choice.name, is_auto ? "brute_force" : entry.name);
    EXPECT_EQ(reason_of(choice), is_auto ? "few boxes" : "by name");
    EXPECT_EQ(choice.switches, 0u);
  }
  // A thousand discs in the second step, above a ground whose box has no end.
  World world(weightless());
  world.add_shape(world.create_body({.type = BodyType::Static}),
                  {.shape = make_half_plane({0, -10}, {0, 1})});
  add(world, {0, -3}, smooth(make_disc(0.5)), 1, {1, 0});
  EXPECT_EQ(world.step(1.0 / 60).broad_phase.name, "brute_force");
  for (int i = 0; i < 999; ++i) add(world, {2.0 * i, 0}, smooth(make_disc(0.5)), 1, {1, 0});
  for (int i = 0; i < 10; ++i) world.step(1.0 / 60);
  const BroadPhaseChoice choice = world.report().broad_phase;
  EXPECT_EQ(choice.name, "neighbour_list");
  EXPECT_EQ(choice.reason, BroadPhaseReason::Cheapest);
  EXPECT_EQ(choice.switches, 1u);
  EXPECT_EQ(choice.boxes, 1001u);
  EXPECT_NEAR(choice.extent.x, 1997, 1);
  EXPECT_THAT(reason_of(choice), testing::MatchesRegex("about [0-9]+ of 1001 moved a step, 1 to 1 m, in "
                                                       "2e\\+03 m x 4.* m"));
}

TEST(Report, IsCopiedWithItsTracesAndOutlivesTheNextStep) {
  World world;
  const ShapeDef box = rough(make_box({1, 1}), 0.5);
  add_ground(world, box);
  for (int i = 0; i < 3; ++i) add(world, {0.1 * i, 0.5 + i}, box);
  world.observe({.contacts = true, .systems = true, .solve_traces = true});
  static_assert(std::is_copy_constructible_v<StepReport> && std::is_copy_assignable_v<StepReport>);
  const StepReport copy = world.step(1.0 / 60);
  ASSERT_FALSE(copy.events.empty());
  ASSERT_FALSE(copy.traces.empty());
  const std::vector<ContactEvent> events = world.report().events;
  const std::vector<double> lambda = world.report().traces[0].lambda;
  const SolveTrace* trace = world.report().traces[0].trace.get();
  // Whoever goes through the events may destroy what they tell of, and step.
  for (const ContactEvent& event : copy.events) {
    if (world.alive(event.body_b)) world.destroy(event.body_b);
  }
  world.step(1.0 / 60);
  EXPECT_EQ(copy.step, 1u);
  EXPECT_EQ(copy.events.size(), events.size());
  EXPECT_EQ(copy.traces[0].lambda, lambda);
  ASSERT_EQ(copy.traces[0].trace.get(), trace);
  if (trace != nullptr) {
    EXPECT_FALSE(trace->notes.empty() && trace->iterations.empty());
  }
}

/// More contacts than are added up at a time.
TEST(Report, OfALargeIslandIsTheSumOfItsContacts) {
  World world;
  world.observe({.contacts = true});
  add_ground(world, rough(make_disc(1), 0.4));
  // Lower ones overlap more, by up to a tenth of a millimetre.
  for (int x = 0; x < 24; ++x)
    for (int y = 0; y < 24; ++y)
      add(world, {x * (1 - 1e-5), 0.5 + y - 2e-6 * y * (48 - y)}, rough(make_box({1, 1}), 0.4), 1,
          {0, -0.01 * (x % 2)});
  int touching = 0;
  for (int step = 0; step < 3; ++step) {
    const StepReport& report = world.step(1.0 / 60);
    for (const ContactEvent& event : report.events) {
      touching += event.kind == ContactEventKind::Begin;
      touching -= event.kind == ContactEventKind::End;
    }
    ASSERT_EQ(report.islands, 1);
    ASSERT_GT(report.contacts_list.size(), 1030u);
    double normal = 0, friction = 0, overlap = 0;
    int points = 0;
    for (const ContactReport& contact : report.contacts_list) {
      points += contact.count;
      for (int i = 0; i < contact.count; ++i) {
        const ContactPointReport& point = contact.points[static_cast<std::size_t>(i)];
        normal += point.normal_impulse + point.impact_impulse;
        friction += std::abs(point.friction_impulse);
        overlap = std::max(overlap, -point.separation);
      }
    }
    EXPECT_GT(friction, 0);
    EXPECT_GT(overlap, 0);
    EXPECT_NEAR(report.total_normal_impulse, normal, 1e-9 * normal) << step;
    EXPECT_NEAR(report.total_friction_impulse, friction, 1e-9 * friction) << step;
    EXPECT_GE(report.worst_penetration, overlap) << step;
    EXPECT_EQ(report.islands_list[0].contacts, points) << step;
    EXPECT_EQ(report.contacts, touching) << step;
  }
}

TEST(Report, CountsWhatThereIsAsleepOrNot) {
  for (const bool sleep : {false, true}) {
    World world({.sleep = sleep});
    add_ground(world, rough(make_disc(1), 0.5));
    const BodyId box = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5));
    add(world, {5, 100}, smooth(make_disc(0.1)));
    const ShapeId gone = world.add_shape(box, rough(make_disc(0.1), 0.5));
    world.destroy(gone);
    for (int i = 0; i < 30; ++i) world.step(1.0 / 60);
    const StepReport& report = world.report();
    EXPECT_EQ(report.bodies_asleep, sleep ? 1 : 0);
    EXPECT_EQ(report.bodies, 3);
    EXPECT_EQ(report.dynamic_bodies, 2);
    EXPECT_EQ(report.shapes, 3);
  }
}

TEST(Report, OfWhatRestsNamesNoStepper) {
  for (const char* stepper : {"event_driven", "time_stepping", "auto"}) {
    World world({.stepper = stepper, .sleep = false});
    add_ground(world, rough(make_disc(1), 0.5));
    const BodyId box = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5));
    for (int i = 0; i < 10; ++i) world.step(1.0 / 60);
    EXPECT_EQ(world.report().islands_at_rest, 1) << stepper;
    EXPECT_EQ(world.report().islands_by_events + world.report().islands_by_time_stepping, 0) << stepper;
    world.set_velocity(box, {1, 0}, 0);
    world.step(1.0 / 60);
    EXPECT_EQ(world.report().islands_at_rest, 0) << stepper;
    EXPECT_EQ(world.report().islands_by_events + world.report().islands_by_time_stepping, 1) << stepper;
  }
}

/// Sums are kept in blocks of bodies: all of one go, some of another.
TEST(Report, CountsNothingOfWhatIsDestroyed) {
  World world(weightless());
  const std::uint64_t empty = world.state_hash();
  std::vector<BodyId> bodies;
  bodies.reserve(200);
  for (int i = 0; i < 200; ++i)
    bodies.push_back(add(world, {3.0 * i, 0}, smooth(make_disc(0.5)), 1, {0, i == 100 ? 2.0 : 0.0}));
  for (int i = 0; i < 3; ++i) world.step(1.0 / 60);
  EXPECT_EQ(world.report().kinetic_energy, 2);
  const auto expect_sums = [&](double kinetic, const char* when) {
    const StepReport& report = world.step(1.0 / 60);
    EXPECT_EQ(report.kinetic_energy, kinetic) << when;
    EXPECT_EQ(report.momentum, (Vec2{0, kinetic})) << when;
    EXPECT_EQ(report.state_hash, world.state_hash()) << when;
  };
  for (std::size_t i = 64; i < 128; ++i) world.destroy(bodies[i]);
  expect_sums(0, "a block");
  for (std::size_t i = 1; i < 64; i += 2) world.destroy(bodies[i]);
  expect_sums(0, "half of one");
  for (std::size_t i = 0; i < 64; i += 2) world.destroy(bodies[i]);
  for (std::size_t i = 128; i < 200; ++i) world.destroy(bodies[i]);
  expect_sums(0, "all");
  EXPECT_EQ(world.report().state_hash, empty);
}

}  // namespace report_test
}  // namespace skerry
