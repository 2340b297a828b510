// SPDX-License-Identifier: MIT
//
// Contacts that are met within a step, off the way that was foreseen: nothing passes through anything.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <vector>

#include "physics/narrowphase/queries.h"
#include "tests/support/draw.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace missed_contacts_test {

using test::Draw;

constexpr double kStep = 1.0 / 60;

WorldConfig config_for(const char* stepper, Vec2 gravity = {0, -9.81}) {
  WorldConfig config;
  config.stepper = stepper;
  config.gravity = gravity;
  return config;
}

class MissedContacts : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(By, MissedContacts, testing::Values("auto", "event_driven", "time_stepping"),
                         [](const auto& each) { return std::string(each.param); });

/// A small body that lands on one corner turns at 100 rad/s and more, down through the floor and out of it
/// again within a step.
TEST_P(MissedContacts, OfWhatFlipsOnOneCorner) {
  for (const bool thick_box : {false, true}) {
    for (unsigned seed = 0; seed < 100; ++seed) {
      Draw draw(seed);
      World world(config_for(GetParam()));
      world.observe({.paths = true});
      const Shape floor = thick_box ? make_box({20, 4}, {0, -2}) : make_half_plane({}, {0, 1});
      world.add_shape(world.create_body({.type = BodyType::Static}),
                      {.shape = floor, .material = {.friction = 0}});
      const double width = draw.uniform(0.02, 0.1), radius = width * draw.uniform(0.1, 0.3),
                   speed = draw.uniform(2, 15), tilt = draw.uniform(0.02, 0.6);
      const Shape shape = draw.one_in(2)
                              ? make_box({width, 2 * radius})
                              : make_capsule({radius - 0.5 * width, 0}, {0.5 * width - radius, 0}, radius);
      const BodyId body = world.create_body(
          {.position = {0, width + draw.uniform(0, 0.1)}, .angle = tilt, .velocity = {0, -speed}});
      world.add_shape(body, {.shape = shape, .material = {.friction = 0}});
      double fastest = 0;
      for (int step = 0; step < 20; ++step) {
        world.step(kStep);
        fastest = std::max(fastest, world.velocity(body).y);
        for (int part = 1; part <= 20; ++part) {
          const auto then = world.interpolated(body, world.time() - kStep * (1 - part / 20.0));
          ASSERT_GT(distance(shape, then.pose(), floor, {}).distance, -1e-3)
              << "seed " << seed << " step " << step;
        }
      }
      EXPECT_LT(fastest, 1.6) << "seed " << seed;
    }
  }
}

/// A light ball is struck by a heavy one, and in the round after that by another one: it goes elsewhere than
/// in the round by which the plates around were judged.
TEST_P(MissedContacts, OfWhatIsStruckAgainInALaterRound) {
  for (const unsigned seed : {929u, 1877u, 2338u, 6914u}) {
    SCOPED_TRACE(seed);
    Draw draw(seed);
    World world(config_for(GetParam(), {0, 0}));
    world.observe({.paths = true});
    const double speed = draw.uniform(5, 20);
    const auto ball = [&](Vec2 at, Vec2 velocity, double radius, double density) {
      world.add_shape(
          world.create_body({.position = at, .velocity = velocity}),
          {.shape = make_disc(radius), .density = density, .material = {.friction = 0, .restitution = 1}});
    };
    const double radius = draw.uniform(0.01, 0.03), large = 0.05;
    ball({0, 0}, {}, radius, 1000);
    const double gap = draw.uniform(0.001, 0.02);
    ball({-radius - large - gap, 0}, {speed, 0}, large, 1e6);
    const double x = draw.uniform(0.8, 1.8) * speed * kStep, down = draw.uniform(0.3, 1.0) * speed;
    ball({x, draw.uniform(0.1, 0.8) * down * kStep + large}, {0, -down}, large, 1e6);
    const int plates = 2 + draw.pick(5);
    for (int k = 0; k < plates; ++k) {
      const double angle = draw.uniform(-1.2, 0.3), far = draw.uniform(1.95, 2.5) * speed * kStep;
      world.add_shape(world.create_body({.type = BodyType::Static,
                                         .position = far * Vec2{std::cos(angle), std::sin(angle)},
                                         .angle = angle}),
                      {.shape = make_box({0.004, 0.1}), .material = {.friction = 0, .restitution = 1}});
    }
    const auto shapes = world.shapes();
    for (int step = 0; step < 3; ++step) {
      world.step(kStep);
      for (int part = 1; part <= 50; ++part) {
        const double time = world.time() - kStep * (1 - part / 50.0);
        for (std::size_t i = 0; i < 3; ++i) {
          for (std::size_t j = i + 1; j < shapes.size(); ++j) {
            const auto a = world.interpolated(shapes[i].body, time),
                       b = world.interpolated(shapes[j].body, time);
            ASSERT_GT(distance(shapes[i].shape, a.pose(), shapes[j].shape, b.pose()).distance, -1e-4)
                << i << " and " << j << " in step " << step;
          }
        }
      }
    }
  }
}

/// A plate flies with a ball close behind it; its joint is at its end already where the step begins.
TEST_P(MissedContacts, WithWhatAJointStopsAtOnce) {
  for (const JointKind kind : {JointKind::Prismatic, JointKind::Rope, JointKind::Weld}) {
    for (unsigned seed = 0; seed < 40; ++seed) {
      Draw draw(seed);
      const double speed = draw.uniform(1, 8), gap = draw.uniform(0.001, 0.05);
      World world(config_for(GetParam(), draw.one_in(2) ? Vec2{} : Vec2{0, -9.81}));
      const BodyId plate = world.create_body({.velocity = {0, -speed}});
      world.add_shape(plate, {.shape = make_box({1, 0.1})});
      const BodyId ball = world.create_body({.position = {0, 0.15 + gap}, .velocity = {0, -speed}});
      world.add_shape(ball, {.shape = make_disc(0.1)});
      JointDef joint{.kind = kind, .b = plate};
      if (kind == JointKind::Prismatic) {
        joint.axis = {0, 1};
        joint.lower = 0;
      } else if (kind == JointKind::Rope) {
        joint.anchor_a = {0, 1.05};
        joint.anchor_b = {0, 0.05};
        joint.length = 1;
      }
      world.create_joint(joint);
      for (int step = 0; step < 5; ++step) {
        world.step(kStep);
        ASSERT_GT(world.position(ball).y - world.position(plate).y, 0.15 - 1e-6)
            << "seed " << seed << " step " << step;
      }
    }
  }
}

/// What has been slow for long enough stops where it is, with something faster behind it.
TEST_P(MissedContacts, WithWhatStopsSinceItIsSlow) {
  for (int hundredths = 1; hundredths < 120; ++hundredths) {
    const double gap = 0.01 * hundredths;
    WorldConfig config = config_for(GetParam(), {0, 0});
    config.sleep_speed = 0.5;
    World world(config);
    const BodyId slow = world.create_body({.velocity = {0.45, 0}});
    world.add_shape(slow, {.shape = make_box({0.2, 0.2})});
    world.create_joint({.kind = JointKind::Prismatic, .b = slow, .axis = {1, 0}});
    const BodyId fast = world.create_body({.position = {-0.2 - gap, 0}, .velocity = {0.7, 0}});
    world.add_shape(fast, {.shape = make_box({0.2, 0.2})});
    for (int step = 0; step < 40; ++step) {
      world.step(1.0 / 20);
      ASSERT_GT(world.position(slow).x - world.position(fast).x, 0.2 - 1e-6) << gap << " step " << step;
    }
  }
}

/// The inner corners of a chain, from which each of its sides shows a ball only what is before it, and a
/// flipper, with which the ball's motion is integrated.
TEST_P(MissedContacts, WithSidesOfAChainFromBeyondTheirEnds) {
  int missed = 0;
  for (const bool disc : {true, false}) {
    for (unsigned seed = 0; seed < 250; ++seed) {
      Draw draw(seed);
      World world(config_for(GetParam(), {0, -1.2}));
      world.add_shape(world.create_body({.type = BodyType::Static}),
                      {.shape = make_chain(std::vector<Vec2>{
                           {0, 1}, {0, 0.4}, {0.12, 0.25}, {0.2, 0.15}, {0.35, 0.1}, {1.35, 0.1}})});
      const BodyId flipper =
          world.create_body({.position = {0.25, 0.27}, .omega = draw.uniform(-9, 9), .mass = 0.05});
      world.add_shape(flipper, {.shape = make_capsule({-0.05, 0}, {0.05, 0}, 0.008),
                                .filter = {.category = 2, .mask = 4}});
      world.create_joint({.kind = JointKind::Revolute,
                          .b = flipper,
                          .anchor_a = {0.3, 0.27},
                          .lower = -0.5,
                          .upper = 0.5,
                          .motor_speed = draw.uniform(-20, 20),
                          .motor_limit = 0.4});
      const double direction = draw.uniform(-2.6, 0.2), speed = draw.uniform(1, 12);
      const Vec2 velocity = speed * Vec2{std::cos(direction), std::sin(direction)};
      const BodyId ball = world.create_body({.position = {draw.uniform(0.03, 0.2), draw.uniform(0.3, 0.45)},
                                             .velocity = velocity,
                                             .omega = draw.uniform(-60, 60),
                                             .mass = 0.08});
      world.add_shape(ball, {.shape = disc ? make_disc(0.0135) : make_capsule({-0.01, 0}, {0.01, 0}, 0.008),
                             .material = {.friction = 0.1, .restitution = 0.3},
                             .filter = {.category = 4}});
      // What begins in the wall is no matter here.
      if (world.step(1e-6).worst_penetration > 1e-4) continue;
      bool inside = false;
      for (int step = 0; step < 30; ++step) inside |= world.step(kStep).worst_penetration > 1e-4;
      missed += inside;
    }
  }
  EXPECT_EQ(missed, 0);
}

/// A scene in millimetres, with tolerances to match: a half-plane has no middle that is known so well.
TEST(MissedContacts, ATinyDiscRollsOnAHalfPlane) {
  Draw draw(1134);
  for (const char* stepper : {"time_stepping", "event_driven"}) {
    for (int run = 0; run < 50; ++run) {
      const double unit = 1.0 / 1024;
      WorldConfig config;
      config.stepper = stepper;
      config.gravity = {0, -9.81 * unit};
      config.contact_margin = 0.005 * unit;
      config.touch_tolerance = 1e-9 * unit;
      config.rest_speed = 1e-6 * unit;
      World world(config);
      const BodyId ground = world.create_body({.type = BodyType::Static});
      world.add_shape(ground, {.shape = make_half_plane({0, 0}, {0, 1})});
      const double radius = draw.uniform(0.0958, 0.0972) * unit;
      const BodyId disc =
          world.create_body({.position = {0, radius}, .velocity = {draw.uniform(1.0, 1.3) * unit, 0}});
      world.add_shape(disc, {.shape = make_disc(radius)});
      for (int step = 0; step < 10; ++step) {
        world.step(kStep);
        EXPECT_NEAR(world.position(disc).y, radius, 1e-9 * unit) << stepper << ", run " << run;
      }
    }
  }
}

}  // namespace missed_contacts_test
}  // namespace skerry
