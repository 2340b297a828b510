// SPDX-License-Identifier: MIT
//
// Events of the caller's own, located within the step.
#include "physics/user_events.h"

#include <cmath>
#include <gtest/gtest.h>

#include "tests/support/worlds.h"

namespace skerry {
namespace user_events_test {

using test::add;
using test::add_ground;
using test::smooth;

constexpr double kG = 9.81;

class UserEventsBy : public testing::TestWithParam<std::string> {
 protected:
  static World make() {
    WorldConfig config;
    config.stepper = GetParam();
    World world(config);
    world.observe({.paths = true});
    return world;
  }
};

TEST_P(UserEventsBy, FindWhenABallPassesAHeightOnItsWayDownAndUp) {
  World world = make();
  add_ground(world, smooth(make_disc(1), 1));
  const auto ball = add(world, {0, 2.5}, smooth(make_disc(0.5), 1));
  std::vector<std::pair<double, bool>> seen;
  UserEvents events;
  events.add([&](double t) { return world.interpolated(ball, t).position.y - 1; },
             [&](double t, bool rising) { seen.emplace_back(t, rising); });
  int called = 0;
  for (int i = 0; i < 60; ++i) {
    world.step(1.0 / 60);
    called += events.look(world);
  }
  // Down 1.5 m, impact after 2 m, up again with the same times.
  const double down = std::sqrt(2 * 1.5 / kG), bounce = std::sqrt(2 * 2 / kG);
  ASSERT_EQ(seen.size(), 2u);
  EXPECT_EQ(called, 2);
  EXPECT_NEAR(seen[0].first, down, 1e-13);
  EXPECT_FALSE(seen[0].second);
  EXPECT_NEAR(seen[1].first, 2 * bounce - down, 1e-12);
  EXPECT_TRUE(seen[1].second);
}

TEST_P(UserEventsBy, ComeInTheOrderOfTimeAndAtTheJumpOfAnImpact) {
  World world = make();
  add_ground(world, smooth(make_disc(1), 1));
  const auto ball = add(world, {0, 2.5}, smooth(make_disc(0.5), 1));
  std::vector<char> order;
  double turned = 0;
  UserEvents events;
  events.add([&](double t) { return world.interpolated(ball, t).velocity.y; },
             [&](double t, bool) { order.push_back('v'), turned = t; });
  events.add([&](double t) { return world.interpolated(ball, t).position.y - 1; },
             [&](double, bool) { order.push_back('y'); });
  world.step(0.75);
  EXPECT_EQ(events.look(world), 3);
  EXPECT_EQ(std::string(order.begin(), order.end()), "yvy");
  EXPECT_NEAR(turned, std::sqrt(2 * 2 / kG), 1e-12);
}

TEST(UserEvents, AreRemovedByNumberAndRefuseWhatTheyCannotUse) {
  World world;
  const auto ball = add(world, {0, 1}, smooth(make_disc(0.1)));
  UserEvents events;
  EXPECT_THROW(events.add({}, [](double, bool) {}), std::invalid_argument);
  EXPECT_THROW(events.add([](double) { return 1.0; }, {}), std::invalid_argument);
  const int number = events.add([&](double t) { return world.interpolated(ball, t).position.y; },
                                [](double, bool) { FAIL(); });
  EXPECT_EQ(events.look(world), 0);
  world.step(0.1);
  EXPECT_THROW(events.look(world), std::invalid_argument);  // no paths
  events.remove(number);
  EXPECT_THROW(events.remove(number), std::invalid_argument);
  EXPECT_EQ(events.look(world), 0);
}

INSTANTIATE_TEST_SUITE_P(Registry, UserEventsBy, testing::Values("time_stepping", "event_driven", "auto"),
                         [](const auto& stepper) { return std::string(stepper.param); });

TEST(UserEvents, WithoutPathsTheStepIsRefusedWhateverTheQuantityIsMadeOf) {
  World world;
  add(world, {0, 2}, smooth(make_disc(0.5)));
  UserEvents events;
  int actions = 0;
  EXPECT_EQ(events.look(world), 0);
  const int number = events.add([](double t) { return t - 0.01; }, [&](double, bool) { ++actions; });
  EXPECT_EQ(events.look(world), 0);  // nothing was stepped yet
  world.step(1.0 / 60);
  try {
    events.look(world);
    ADD_FAILURE() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find("observe paths before the step"), std::string::npos);
  }
  EXPECT_EQ(actions, 0);
  events.remove(number);
  EXPECT_EQ(events.look(world), 0);
}

}  // namespace user_events_test
}  // namespace skerry
