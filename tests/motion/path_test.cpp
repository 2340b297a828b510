// SPDX-License-Identifier: MIT
//
// The motion within a step against closed forms.
#include "physics/stepping/path.h"

#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "physics/snapshot.h"
#include "physics/stepping/stepper.h"
#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace path_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;
using test::weightless;

constexpr double kG = 9.81;

class PathOf : public testing::TestWithParam<std::string_view> {
 protected:
  static WorldConfig config() {
    WorldConfig config;
    config.stepper = GetParam();
    return config;
  }
};

TEST_P(PathOf, ABounceWithinTheStepIsTwoParabolas) {
  const double e = 0.7, drop = 1;
  World world(config());
  world.observe({.paths = true});
  add_ground(world, smooth(make_disc(1), e));
  const auto ball = add(world, {0, drop + 0.5}, smooth(make_disc(0.5), e), 1, {2, 0}, 3);
  // One step of 0.6 s; it hits at 0.4515 s.
  const double h = 0.6, hit = std::sqrt(2 * drop / kG);
  world.step(h);
  for (int i = 0; i <= 600; ++i) {
    const double t = h * i / 600;
    const BodyState found = world.interpolated(ball, t);
    const double after = t - hit;
    const double up = e * std::sqrt(2 * kG * drop);
    const double y = after < 0 ? drop - 0.5 * kG * t * t : up * after - 0.5 * kG * after * after;
    const double v = after < 0 ? -kG * t : up - kG * after;
    EXPECT_NEAR(found.position.x, 2 * t, 1e-12);
    EXPECT_NEAR(found.position.y, 0.5 + y, 1e-12) << t;
    EXPECT_NEAR(found.velocity.y, v, 1e-11) << t;
    EXPECT_NEAR(found.angle, 3 * t, 1e-12);
    EXPECT_NEAR(found.omega, 3, 1e-12);
  }
}

TEST_P(PathOf, RollingDownAnInclineIsAParabolaWithinTheStep) {
  const double angle = kPi / 6;
  World world(config());
  world.observe({.paths = true});
  add_ground(world, rough(make_disc(1), 0.5), -angle);
  const Rot q = Rot::from_angle(-angle);
  const auto disc = add(world, rotate(q, {0, 0.5}), rough(make_disc(0.5), 0.5));
  const double a = 2.0 / 3 * kG * std::sin(angle);
  for (int step = 0; step < 10; ++step) {
    world.step(0.1);
    for (int i = 0; i <= 10; ++i) {
      const double t = world.time() - 0.1 + 0.01 * i;
      const BodyState found = world.interpolated(disc, t);
      EXPECT_NEAR(dot(found.position, rotate(q, {1, 0})), 0.5 * a * t * t, 1e-12);
      EXPECT_NEAR(found.omega, -a * t / 0.5, 1e-11);
    }
  }
}

// Piles that land, slide, roll and come to rest, in steps that end in each of these ways.
TEST_P(PathOf, JoinsTheStatesAtBothEndsOfEveryStep) {
  const int seeds = test_scale(6);
  for (int seed = 0; seed < seeds; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(static_cast<unsigned>(seed));
    const auto number = [&](double from, double to) {
      return from + (to - from) * static_cast<double>(random()) / 4294967296.0;
    };
    WorldConfig how = config();
    if (seed % 6 == 5) how.accuracy = 1e-3;
    World world(how);
    world.observe({.paths = true});
    add_ground(world, rough(make_disc(1), 0.4, 0.3));
    std::vector<BodyId> bodies;
    for (int i = 0; i < 6; ++i) {
      const double width = number(0.4, 1), height = number(0.4, 1), radius = number(0.2, 0.5);
      const double friction = number(0, 0.8), restitution = seed % 2 == 0 ? 0.0 : number(0, 0.6);
      const double x = number(-0.6, 0.6), speed = number(-2, 2), angle = number(0, 6);
      const Shape shape = i % 2 == 0 ? make_disc(radius) : make_box({width, height});
      bodies.push_back(
          add(world, {x, 0.8 + 1.1 * i}, rough(shape, friction, restitution), 1, {speed, 0}, 0, angle));
    }
    if (seed % 4 == 3) world.create_joint({.a = bodies[0], .b = bodies[1], .anchor_a = {0, 1.3}});
    const double h = 1.0 / 60;
    std::vector<BodyState> before(bodies.size());
    for (int step = 0; step < 150; ++step) {
      for (std::size_t k = 0; k < bodies.size(); ++k)
        before[k] = {world.position(bodies[k]), world.angle(bodies[k]), {}, 0};
      world.step(h);
      const double last = std::nextafter(world.time(), 0.0);
      for (std::size_t k = 0; k < bodies.size(); ++k) {
        const BodyState begin = world.interpolated(bodies[k], world.time() - h);
        ASSERT_LT(length(begin.position - before[k].position), 1e-12) << step << " body " << k;
        ASSERT_NEAR(begin.angle, before[k].angle, 1e-12) << step << " body " << k;
        const BodyState end = world.interpolated(bodies[k], last);
        ASSERT_LT(length(end.position - world.position(bodies[k])), 1e-12) << step << " body " << k;
        ASSERT_NEAR(end.angle, world.angle(bodies[k]), 1e-12) << step << " body " << k;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Registry, PathOf, testing::Values("time_stepping", "event_driven", "auto"),
                         [](const auto& stepper) { return std::string(stepper.param); });

TEST(Path, RungeKuttaOutputFollowsAPendulumBetweenTheSteps) {
  WorldConfig config;
  config.stepper = "event_driven";
  World coarse(config), fine(config);
  coarse.observe({.paths = true});
  BodyId bobs[2];
  World* worlds[2] = {&coarse, &fine};
  for (int k = 0; k < 2; ++k) {
    bobs[k] = worlds[k]->create_body({.position = {1, 0}, .mass = 1.0, .inertia = 0.01});
    worlds[k]->create_joint(
        {.kind = JointKind::Revolute, .b = bobs[k], .anchor_a = {0, 0}, .anchor_b = {0, 0}});
  }
  for (int step = 0; step < 4; ++step) {
    coarse.step(0.5);
    for (int i = 0; i < 10; ++i) {
      fine.step(0.05);
      const BodyState found = coarse.interpolated(bobs[0], std::min(fine.time(), coarse.time()));
      EXPECT_NEAR(length(found.position - fine.position(bobs[1])), 0, 1e-10);
      EXPECT_NEAR(found.omega, fine.omega(bobs[1]), 1e-9);
    }
  }
}

TEST(Path, KinematicBodiesAndRestingOnesAreKnownToo) {
  World world;
  world.observe({.paths = true});
  add_ground(world, smooth(make_disc(1)));
  const auto lift = world.create_body({.type = BodyType::Kinematic, .position = {5, 3}, .velocity = {1, 2}});
  world.add_shape(lift, smooth(make_box({1, 0.1})));
  const auto box = add(world, {0, 0.5}, smooth(make_box({1, 1})));
  for (int i = 0; i < 10; ++i) world.step(0.1);
  EXPECT_EQ(world.report().islands_at_rest, 1);
  const double t = world.time() - 0.03;
  EXPECT_NEAR(world.interpolated(lift, t).position.y, 3 + 2 * t, 1e-12);
  EXPECT_EQ(world.interpolated(box, t).position.y, world.position(box).y);
}

TEST(Path, OfKinematicBodiesIsThatOfTheStepWhateverTheyWereToldSince) {
  World world(weightless());
  world.observe({.paths = true});
  const auto make = [&world](Vec2 at) {
    const BodyId body = world.create_body({.type = BodyType::Kinematic, .position = at});
    world.add_shape(body, smooth(make_box({1, 0.1})));
    return body;
  };
  const BodyId told = make({0, 3}), straight = make({0, 0});
  const auto way = [](double t) { return Placement{{std::sin(5 * t), 3 + t * t}, std::cos(3 * t)}; };
  world.set_motion(told, way);
  world.set_velocity(straight, {1, 2}, 3);
  for (int i = 0; i < 4; ++i) world.step(0.1);
  const double t = 0.34, back = world.time() - t;
  const auto expect_path = [&](const World& w, const char* what) {
    const BodyState there = w.interpolated(told, t);
    EXPECT_NEAR(there.position.x, std::sin(5 * t), 1e-12) << what;
    EXPECT_NEAR(there.position.y, 3 + t * t, 1e-12) << what;
    EXPECT_NEAR(there.angle, std::cos(3 * t), 1e-12) << what;
    EXPECT_NEAR(there.velocity.x, 5 * std::cos(5 * t), 1e-9) << what;
    EXPECT_NEAR(there.velocity.y, 2 * t, 1e-9) << what;
    EXPECT_NEAR(there.omega, -3 * std::sin(3 * t), 1e-9) << what;
    EXPECT_NEAR(w.interpolated(straight, t).position.y, 2 * (0.4 - back), 1e-12) << what;
    EXPECT_NEAR(w.interpolated(straight, t).omega, 3, 1e-12) << what;
  };
  expect_path(world, "as they are");
  World loaded = load_snapshot(save_snapshot(world));
  loaded.adopt(world.callbacks());
  expect_path(loaded, "loaded");
  world.set_motion(told, {});
  world.set_velocity(told, {7, 7}, 7);
  world.set_velocity(straight, {}, 0);
  expect_path(world, "told otherwise");
  world.set_motion(straight, way);
  EXPECT_NEAR(world.interpolated(straight, t).position.x, 0.4 - back, 1e-12);
}

TEST(Path, RefusesTimesOutsideTheStepAndStepsThatWereNotObserved) {
  World world;
  const auto ball = add(world, {0, 0}, smooth(make_disc(1)));
  world.step(0.5);
  EXPECT_EQ(world.interpolated(ball, 0.5).position, world.position(ball));
  EXPECT_THROW(world.interpolated(ball, 0.25), std::invalid_argument);
  world.observe({.paths = true});
  world.step(0.5);
  EXPECT_NEAR(world.interpolated(ball, 0.75).position.y, -0.5 * kG * 0.75 * 0.75, 1e-13);
  for (const double t : {0.25, 1.25, std::nan("")})
    EXPECT_THROW(world.interpolated(ball, t), std::invalid_argument);
}

TEST(Path, OfABodyThatWasMadeSinceIsWhereItIs) {
  World world(weightless());
  world.observe({.paths = true});
  const BodyId gone = add(world, {0, 0}, smooth(make_disc(0.1)), 1, {1, 0});
  add(world, {0, 5}, smooth(make_disc(0.1)), 1, {1, 0});
  world.step(0.1);
  world.destroy(gone);
  const BodyId fresh = add(world, {7, 7}, smooth(make_disc(0.1)), 1, {3, 0});
  ASSERT_EQ(fresh.index, gone.index);
  EXPECT_EQ(world.interpolated(fresh, 0.05).position, (Vec2{7, 7}));
  EXPECT_THROW(world.interpolated(gone, 0.05), std::invalid_argument);
}

/// Times of a caller's own are as exact as the time of the world is.
TEST(Path, ARoundingOutsideTheStepIsItsEnd) {
  World world(weightless());
  world.observe({.paths = true});
  add(world, {0, 5}, smooth(make_disc(0.1)), 1, {2, 0});
  const BodyId body = add(world, {0, 0}, smooth(make_disc(0.1)), 1, {1, 0});
  add(world, {0, -5}, smooth(make_disc(0.1)), 1, {2, 0});
  for (const double long_step : {1.0, 1000.0, 1e6}) {
    world.step(long_step);
    for (const double h : {0.1, 1.0 / 60, 0.001}) {
      const Vec2 before = world.position(body);
      const double begin = world.time();
      world.step(h);
      const double rounding = 1e-15 * world.time();
      for (const double t : {begin - rounding, begin, begin + rounding, world.time() - h})
        EXPECT_NEAR(world.interpolated(body, t).position.x, before.x, 4e-15 * world.time()) << t << ", " << h;
      const double later = world.time() + rounding;
      EXPECT_EQ(world.interpolated(body, later).position, world.position(body)) << h;
      EXPECT_THROW(world.interpolated(body, begin - 1e-3 * h - 1e-9 * begin), std::invalid_argument);
    }
  }
}

}  // namespace path_test
}  // namespace skerry
