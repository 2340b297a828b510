// SPDX-License-Identifier: MIT
//
// Event-driven stepping of what is neither a plain contact nor a plain joint: rolling resistance, ropes,
// conveyors.
#include <cmath>
#include <gtest/gtest.h>

#include "tests/support/worlds.h"

namespace skerry {
namespace event_laws_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;

constexpr double kG = 9.81;
constexpr double kStep = 1.0 / 60;

World by_events() {
  WorldConfig config;
  config.stepper = "event_driven";
  return World(config);
}

double time_of(const StepReport& report, MotionEventKind kind) {
  for (const MotionEvent& event : report.motion_events) {
    if (event.kind == kind) return event.time;
  }
  return -1;
}

// The couple arm * N slows a rolling disc with a = g arm / r / (1 + I / m r^2).
TEST(EventLaws, RollingResistanceStopsADiscAfterTheKnownTimeAndWay) {
  const double r = 0.5, v0 = 1, arm = 0.02;
  World world = by_events();
  ShapeDef ground = rough(make_disc(1), 0.8), wheel = rough(make_disc(r), 0.8);
  ground.material.rolling_resistance = wheel.material.rolling_resistance = arm;
  add_ground(world, ground);
  const auto disc = add(world, {0, r}, wheel, 1, {v0, 0}, -v0 / r);
  const double a = kG * arm / r / 1.5;
  double stopped = -1;
  for (int i = 0; i < 300; ++i) {
    const StepReport& report = world.step(kStep);
    EXPECT_EQ(report.fallbacks, 0) << i;
    if (stopped < 0) stopped = time_of(report, MotionEventKind::Stick);
  }
  EXPECT_NEAR(stopped, v0 / a, 1e-11);
  EXPECT_NEAR(world.position(disc).x, v0 * v0 / (2 * a), 1e-11);
  EXPECT_EQ(world.report().islands_at_rest, 1);
}

TEST(EventLaws, DiscOnAnInclineStaysWhereRollingResistanceHoldsIt) {
  // It rolls iff tan A > arm / r.
  const double r = 0.5, arm = 0.1;
  for (const double share : {0.99, 1.01}) {
    const double angle = std::atan(share * arm / r);
    World world = by_events();
    ShapeDef ground = rough(make_disc(1), 0.8), wheel = rough(make_disc(r), 0.8);
    ground.material.rolling_resistance = wheel.material.rolling_resistance = arm;
    add_ground(world, ground, -angle);
    const Rot q = Rot::from_angle(-angle);
    const auto disc = add(world, rotate(q, {0, r}), wheel);
    for (int i = 0; i < 60; ++i) world.step(kStep);
    const double way = dot(world.position(disc), rotate(q, {1, 0}));
    const double a = kG * (std::sin(angle) - std::cos(angle) * arm / r) / 1.5;
    EXPECT_NEAR(way, share > 1 ? 0.5 * a : 0, 1e-11) << share;
  }
}

TEST(EventLaws, RopeCatchesAFallingBallAtTheKnownTime) {
  const double reach = 1, slack = 0.4;
  World world = by_events();
  const auto ball = add(world, {0, -(reach - slack)}, smooth(make_disc(0.1)));
  world.create_joint({.kind = JointKind::Rope,
                      .b = ball,
                      .anchor_a = {0, 0},
                      .anchor_b = world.position(ball),
                      .length = reach});
  double caught = -1;
  for (int i = 0; i < 60; ++i) {
    const StepReport& report = world.step(kStep);
    EXPECT_EQ(report.fallbacks, 0) << i;
    if (caught < 0) caught = time_of(report, MotionEventKind::Limit);
  }
  EXPECT_NEAR(caught, std::sqrt(2 * slack / kG), 1e-12);
  EXPECT_NEAR(world.position(ball).y, -reach, 1e-9);
  EXPECT_NEAR(world.velocity(ball).y, 0, 1e-9);
}

// A ball on a rope with the speed v0 at the bottom leaves its circle at cos t = (2 - v0^2 / g l) / 3.
TEST(EventLaws, RopeSlackensWhereTheBallLeavesItsCircle) {
  const double reach = 1;
  for (const double ratio : {2.5, 3.5, 4.5}) {
    World world = by_events();
    world.observe({.paths = true});
    // A point mass: its spin does not matter, but the rope's end is its centre.
    const auto ball = add(world, {0, -reach}, smooth(make_disc(0.1)), 1, {std::sqrt(ratio * kG * reach), 0});
    world.create_joint({.kind = JointKind::Rope,
                        .b = ball,
                        .anchor_a = {0, 0},
                        .anchor_b = world.position(ball),
                        .length = reach});
    bool left = false;
    for (int i = 0; i < 60 && !left; ++i) {
      const StepReport& report = world.step(kStep);
      EXPECT_EQ(report.fallbacks, 0) << i;
      const double t = time_of(report, MotionEventKind::Release);
      if (t < 0) continue;
      left = true;
      const Vec2 p = world.interpolated(ball, t).position;
      EXPECT_NEAR(-p.y / length(p), (2 - ratio) / 3, 1e-9) << ratio;
      EXPECT_NEAR(length(p), reach, 1e-10);
    }
    EXPECT_TRUE(left) << ratio;
  }
}

TEST(EventLaws, ConveyorCarriesABlockAlongOnceItHasItsSpeed) {
  const double mu = 0.3, speed = 2;
  World world = by_events();
  ShapeDef belt = rough(make_disc(1), mu);
  belt.material.surface_velocity = -speed;  // counter-clockwise is to the left on top
  add_ground(world, belt);
  const auto block = add(world, {0, 0.25}, rough(make_box({2, 0.5}), mu));
  double carried = -1;
  for (int i = 0; i < 120; ++i) {
    const StepReport& report = world.step(kStep);
    EXPECT_EQ(report.fallbacks, 0) << i;
    if (carried < 0) carried = time_of(report, MotionEventKind::Stick);
  }
  EXPECT_NEAR(carried, speed / (mu * kG), 1e-12);
  EXPECT_NEAR(world.velocity(block).x, speed, 1e-12);
  const double way = speed * speed / (2 * mu * kG);
  EXPECT_NEAR(world.position(block).x, way + speed * (world.time() - speed / (mu * kG)), 1e-11);
}

}  // namespace event_laws_test
}  // namespace skerry
