// SPDX-License-Identifier: MIT
//
// What events used to leave to time stepping: contacts that go over corners, and bodies that are held more
// than once. Found by random worlds whose path depended on the length of the steps.
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "physics/root.h"
#include "tests/support/draw.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace event_features_test {

using test::add;
using test::rough;

WorldConfig by_events() {
  WorldConfig config;
  config.stepper = "event_driven";
  return config;
}

/// Makes steps of 1/60 s in parts, and counts those that were not made by events.
int fallbacks(World& world, int steps, int parts) {
  int sum = 0;
  for (int k = 0; k < steps * parts; ++k) sum += world.step(1.0 / 60 / parts).fallbacks;
  return sum;
}

/// A disc that rolls over a ridge too fast to stay on it flies from where its lowest point passes.
TEST(EventFeatures, ADiscLeavesARidgeWhereItPassesIt) {
  for (const double speed : {1.0, 3.0, 6.0}) {
    const auto end = [&](int parts) {
      World world(by_events());
      world.add_shape(world.create_body({.type = BodyType::Static}),
                      rough(make_chain(std::vector<Vec2>{{-6, 0.6}, {0, 0}, {6, -3}, {12, -3}}), 0.5));
      const double slope = -0.1, radius = 0.25;
      const Vec2 along = Vec2{1, slope} / std::hypot(1, slope), up = perp(along);
      const BodyId disc = add(world, -0.73 * along + radius * up, rough(make_disc(radius), 0.5), 2,
                              speed * along, -speed / radius);
      EXPECT_EQ(fallbacks(world, 24, parts), 0) << speed << " m/s, " << parts;
      return world.position(disc);
    };
    const Vec2 whole = end(1);
    for (const int parts : {2, 4, 8})
      EXPECT_LT(length(end(parts) - whole), 1e-10) << speed << " m/s, " << parts;
  }
}

/// What slides off a table too fast to roll over its edge falls from there, wherever in a step that is.
TEST(TableEdge, WhatSlidesOffFallsFromWhereItEnds) {
  for (const char* stepper : {"time_stepping", "event_driven"}) {
    for (const double speed : {2.1, 3.7, 6.0}) {
      WorldConfig config;
      config.stepper = stepper;
      World world(config);
      world.add_shape(world.create_body({.type = BodyType::Static}), test::smooth(make_box({2, 1})));
      const double radius = 0.25;
      const BodyId disc = add(world, {0.6, 0.5 + radius}, test::smooth(make_disc(radius)), 2, {speed, 0});
      for (int k = 1; k <= 24; ++k) {
        world.step(1.0 / 60);
        const double x = 0.6 + speed * k / 60, flown = std::max(0.0, (x - 1) / speed);
        EXPECT_NEAR(world.position(disc).x, x, 1e-8) << stepper << ", " << speed << " m/s, " << k;
        EXPECT_NEAR(world.position(disc).y, 0.5 + radius - 0.5 * 9.81 * flown * flown, 1e-8)
            << stepper << ", " << speed << " m/s, " << k;
      }
    }
  }
}

/// A capsule that lies on two points and resists rolling slides as far as a box does: v^2 / (2 mu g).
TEST(EventFeatures, TwoPointsHoldWhatResistsRolling) {
  for (const double resistance : {1e-3, 0.01, 0.1}) {
    World world(by_events());
    ShapeDef ground = rough(make_half_plane({0, 0}, {0, 1}), 0.4);
    ground.material.rolling_resistance = resistance;
    world.add_shape(world.create_body({.type = BodyType::Static}), ground);
    ShapeDef capsule = rough(make_capsule({-0.3, 0}, {0.3, 0}, 0.1), 0.4);
    capsule.material.rolling_resistance = resistance;
    const BodyId body = add(world, {0, 0.1}, capsule, 2, {1.7, 0});
    EXPECT_EQ(fallbacks(world, 40, 1), 0) << resistance;
    EXPECT_NEAR(world.position(body).x, 1.7 * 1.7 / (2 * 0.4 * 9.81), 1e-9) << resistance;
    EXPECT_NEAR(world.angle(body), 0, 1e-14) << resistance;
    EXPECT_EQ(world.velocity(body).x, 0) << resistance;
  }
}

/// Two halves of a box have a contact each, of which one may carry nothing but at one corner.
TEST(EventFeatures, TwoContactsHoldWhatResistsRolling) {
  for (const double resistance : {1e-3, 0.02, 0.1}) {
    World world(by_events());
    const auto surface = [&](const Shape& shape) {
      ShapeDef def = rough(shape, 0.3);
      def.material.rolling_resistance = resistance;
      return def;
    };
    world.add_shape(world.create_body({.type = BodyType::Static}), surface(make_half_plane({0, 0}, {0, 1})));
    const BodyId body = world.create_body({.position = {0, 0.1}, .velocity = {2, 0}});
    for (const double x : {-0.1, 0.1}) world.add_shape(body, surface(make_box({0.2, 0.2}, {x, 0})));
    EXPECT_EQ(fallbacks(world, 60, 1), 0) << resistance;
    EXPECT_NEAR(world.position(body).x, 2 * 2 / (2 * 0.3 * 9.81), 1e-9) << resistance;
    EXPECT_NEAR(world.angle(body), 0, 1e-12) << resistance;
  }
}

/// Two sides of a valley leave the angle of a disc to its resistance to rolling.
TEST(EventFeatures, AValleyHoldsNoAngle) {
  constexpr double kSlope = 0.6, kRadius = 0.2, kMass = 2;
  for (const double share : {0.5, 1.5}) {
    World world(by_events());
    const BodyId valley = world.create_body({.type = BodyType::Kinematic});
    const auto surface = [](const Shape& shape) {
      ShapeDef def = test::smooth(shape);
      def.material.rolling_resistance = 0.02;
      return def;
    };
    for (const double side : {-1, 1}) {
      const Vec2 normal{side * std::sin(kSlope), std::cos(kSlope)};
      world.add_shape(valley, surface(make_half_plane({0, 0}, normal)));
    }
    world.set_motion(valley, [](double t) { return Placement{{0.3 * std::sin(3 * t), 0}, 0}; });
    const BodyId disc =
        add(world, {0, kRadius / std::cos(kSlope)}, surface(make_disc(kRadius)), kMass, {0.9, 0});
    const double most = 0.02 * kMass * 9.81 / std::cos(kSlope);
    const double torque = share * most;
    for (int step = 0; step < 30; ++step) {
      world.apply_torque(disc, torque);
      EXPECT_EQ(world.step(1.0 / 60).fallbacks, 0);
    }
    const double spin = std::max(0.0, torque - most) / world.inertia(disc);
    EXPECT_NEAR(world.omega(disc), 0.5 * spin, 1e-9) << share;
    EXPECT_NEAR(world.angle(disc), 0.5 * spin * 0.25, 1e-9) << share;
  }
}

/// Where sixty contacts of a cluster closed at once, each a millionth of the time before the one before, the
/// time that was left had no millionth, and the search for the next one no end.
TEST(EventFeatures, ATimeWithoutParts) {
  const auto sunk = [](double) { return -1e-10; };
  EXPECT_FALSE(closing_time(sunk, 1, 3e-323, 1e-14));
  EXPECT_FALSE(closing_time(sunk, 1, 0, 1e-14));
  EXPECT_TRUE(closing_time(sunk, 1, 1e-30, 1e-14));
}

TEST(FirstRoot, IsWhereTheParabolaFirstGetsToZero) {
  test::Draw draw(1412);
  int found = 0;
  for (int run = 0; run < 20000; ++run) {
    const double value = draw.one_in(4) ? 0 : draw.uniform(0, 2), rate = draw.uniform(-2, 2);
    const double acceleration = draw.one_in(4) ? 0 : draw.uniform(-4, 4);
    const auto at = [&](double t) { return value + t * (rate + 0.5 * t * acceleration); };
    const double t = first_root(value, rate, acceleration);
    const double until = std::isfinite(t) ? t : 50;
    if (std::isfinite(t)) {
      ++found;
      ASSERT_NEAR(at(t), 0, 1e-14 * (1 + t * t)) << "run " << run;
    }
    if (value == 0 && rate < 0) {
      ASSERT_EQ(t, 0) << "run " << run;
      continue;
    }
    for (int k = 1; k < 20; ++k) ASSERT_GT(at(0.05 * k * until), -1e-14) << "run " << run << ", part " << k;
  }
  EXPECT_GT(found, 10000);
}

}  // namespace event_features_test
}  // namespace skerry
