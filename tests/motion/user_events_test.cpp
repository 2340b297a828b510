// SPDX-License-Identifier: MIT
//
// Events of the caller's own, located within the step.
#include "physics/user_events.h"

#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

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

TEST(UserEvents, AtTheEndOfAPartOfAStepAreNotLost) {
  for (const double sign : {1.0, -1.0}) {
    World world(test::weightless());
    add(world, {0, 0}, smooth(make_disc(1)));
    world.observe({.paths = true});
    UserEvents events;
    int called = 0;
    for (int k = 1; k < 8; ++k) {
      events.add([=](double t) { return sign * (t - k / 512.0); },
                 [&](double t, bool rising) {
                   ++called;
                   EXPECT_EQ(rising, sign > 0);
                   EXPECT_NEAR(t, called / 512.0, 1e-15);
                 });
    }
    world.step(1.0 / 64);
    EXPECT_EQ(events.look(world), 7);
    world.step(1.0 / 64);
    EXPECT_EQ(events.look(world), 0);
  }
}

TEST(UserEvents, ManyAtOneTimeComeInTheOrderOfTheirNumbers) {
  World world(test::weightless());
  add(world, {0, 0}, smooth(make_disc(1)));
  world.observe({.paths = true});
  UserEvents events;
  std::vector<int> order, ascending;
  for (int k = 0; k < 100; ++k) {
    events.add([](double t) { return t - 0.01; }, [&order, k](double, bool) { order.push_back(k); });
    ascending.push_back(k);
  }
  world.step(1.0 / 64);
  events.look(world);
  EXPECT_EQ(order, ascending);
}

/// The beginning of a step is known to rounding, which is another one where times pass a power of two.
TEST(UserEvents, AtTheEndOfAStepHappenOnce) {
  for (const double h : {1.0 / 60, 1.0 / 144, 0.01, 0.013, 0.02}) {
    const int steps = 1000;
    const auto run = [&](const std::function<void(const World&)>& look) {
      World world(test::weightless());
      add(world, {0, 0}, smooth(make_disc(1)));
      world.observe({.paths = true});
      for (int i = 0; i < steps; ++i) {
        world.step(h);
        look(world);
      }
    };
    std::vector<double> ends;
    run([&](const World& world) { ends.push_back(world.time()); });
    UserEvents events;
    std::vector<int> called(ends.size(), 0);
    const auto passes = [&](std::size_t k) { return std::ilogb(ends[k]) != std::ilogb(ends[k - 1]); };
    for (std::size_t k = 1; k + 1 < ends.size(); ++k) {
      if (!passes(k) && !passes(k + 1)) continue;
      events.add([=](double t) { return t - ends[k]; }, [&called, k](double, bool) { ++called[k]; });
    }
    run([&](const World& world) { events.look(world); });
    int once = 0;
    for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
      EXPECT_LE(called[k], 1) << h << " s, step " << k;
      once += called[k];
    }
    EXPECT_GE(once, 10) << h;
  }
}

TEST(UserEvents, TwoWithinAFifthOfAStepAreFound) {
  World world(test::weightless());
  world.observe({.paths = true});
  const BodyId body = add(world, {0, 0}, smooth(make_disc(0.1)), 1, {1, 0});
  UserEvents events;
  int found = 0;
  events.add(
      [&](double t) {
        const double x = world.interpolated(body, t).position.x;
        return (x - 0.01) * (x - 0.19);
      },
      [&](double, bool) { ++found; });
  world.step(0.8);
  EXPECT_EQ(events.look(world), 2);
  EXPECT_EQ(found, 2);
}

/// A world of nothing but time, as quantities may be.
World watched_world() {
  World world(test::weightless());
  world.observe({.paths = true});
  return world;
}

TEST(UserEvents, TheirNumbersStayTheirsWhateverIsRemoved) {
  World world = watched_world();
  std::string called;
  UserEvents events;
  const auto watch = [&](char name) {
    return events.add([](double t) { return t - 0.01; }, [&called, name](double, bool) { called += name; });
  };
  const int a = watch('a');
  watch('b');
  events.remove(a);
  const int c = watch('c');
  watch('d');
  events.remove(c);
  EXPECT_THROW(events.remove(a), std::invalid_argument);
  world.step(1.0 / 60);
  EXPECT_EQ(events.look(world), 2);
  EXPECT_EQ(called, "bd");
}

TEST(UserEvents, ActionsAddAndRemoveForTheNextStep) {
  World world = watched_world();
  std::string called;
  UserEvents events;
  int last = -1;
  const auto at = [](double time) { return [time](double t) { return t - time; }; };
  int first = -1;
  first = events.add(at(0.002), [&](double, bool) {
    called += '1';
    events.remove(first);
    events.remove(last);
    for (int k = 0; k < 40; ++k)
      events.add(at(k % 2 == 0 ? 0.01 : 0.02), [&](double, bool) { called += '+'; });
  });
  // More than a function keeps in itself.
  const std::string word = "a word that is longer than what a string keeps without memory of its own";
  events.add(at(0.004), [&called, word](double, bool) { called += word.substr(0, 1); });
  last = events.add(at(0.006), [&called, word](double, bool) { called += word.substr(2, 1); });
  world.step(1.0 / 64);
  EXPECT_EQ(events.look(world), 3);
  EXPECT_EQ(called, "1aw");
  called.clear();
  world.step(1.0 / 64);
  EXPECT_EQ(events.look(world), 20);
  EXPECT_EQ(called, std::string(20, '+'));
}

TEST(UserEvents, OfTimeAloneNeedNoBody) {
  World world = watched_world();
  UserEvents events;
  int called = 0;
  events.add([](double t) { return t - 0.01; }, [&](double, bool) { ++called; });
  world.step(1.0 / 60);
  EXPECT_EQ(events.look(world), 1);
  EXPECT_EQ(called, 1);
}

TEST(UserEvents, DoNotAskForBodiesThatAreNoMore) {
  World world = watched_world();
  const BodyId gone = add(world, {5, 0}, smooth(make_disc(0.1)));
  const BodyId body = add(world, {0, 0}, smooth(make_disc(0.1)), 1, {1, 0});
  world.destroy(gone);
  UserEvents events;
  events.add([&](double t) { return world.interpolated(body, t).position.x - 0.01; }, [](double, bool) {});
  world.step(1.0 / 60);
  EXPECT_EQ(events.look(world), 1);
}

TEST(UserEvents, AreThoseOfTheLastStepAlone) {
  World world = watched_world();
  const BodyId body = add(world, {0, 0}, smooth(make_disc(0.1)), 1, {1, 0});
  std::string called;
  UserEvents events;
  for (const auto& [name, place] : {std::pair{'1', 0.05}, std::pair{'2', 0.15}, std::pair{'4', 0.35}})
    events.add([&world, body, x = place](double t) { return world.interpolated(body, t).position.x - x; },
               [&called, name = name](double, bool) { called += name; });
  world.step(0.1);
  world.step(0.1);
  EXPECT_EQ(events.look(world), 1);
  EXPECT_EQ(called, "2");
  world.step(0.1);
  world.step(0.1);
  EXPECT_EQ(events.look(world), 1);
  EXPECT_EQ(called, "24");
}

TEST(UserEvents, OnBothSidesOfTheEndOfAnEighthAreFound) {
  World world = watched_world();
  UserEvents events;
  for (int k = 1; k < 8; ++k)
    events.add([k](double t) { return (t - k / 8.0 - 0.005) * (t - k / 8.0 + 0.005); }, [](double, bool) {});
  world.step(1);
  EXPECT_EQ(events.look(world), 14);
}

}  // namespace user_events_test
}  // namespace skerry
