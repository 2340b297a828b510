// SPDX-License-Identifier: MIT
//
// Published results for event-driven stepping: rounding, or what the accuracy of the integration leaves.
#include <cmath>
#include <gtest/gtest.h>

#include "tests/support/worlds.h"

namespace skerry {
namespace {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;
using test::weightless;

constexpr double kG = 9.81;

WorldConfig by_events(WorldConfig config = {}) {
  config.stepper = "event_driven";
  return config;
}

/// The time of the first event of a kind in the report, or -1.
double time_of(const StepReport& report, MotionEventKind kind) {
  for (const MotionEvent& event : report.motion_events) {
    if (event.kind == kind) return event.time;
  }
  return -1;
}

struct Departure {
  double angle, onset;
  int solves, fallbacks;
};

/// A solid disc (or one without friction) leaves a fixed cylinder; from its ballistic state at the end of the
/// step back to where it left.
Departure roll_off(double mu) {
  const double r = 0.25, length_ = 1 + r, start = 0.1, h = 2;
  World world(by_events());
  const auto cylinder = world.create_body({.type = BodyType::Static});
  world.add_shape(cylinder, rough(make_disc(1), mu));
  const auto disc =
      add(world, {length_ * std::sin(start), length_ * std::cos(start)}, rough(make_disc(r), mu));
  const StepReport& report = world.step(h);
  const double flight = h - time_of(report, MotionEventKind::Release);
  const Vec2 v = world.velocity(disc) - flight * Vec2{0, -kG};
  const Vec2 p = world.position(disc) - flight * v - 0.5 * flight * flight * Vec2{0, -kG};
  Departure out{};
  out.angle = std::atan2(p.x, p.y);
  out.solves = report.force_solves;
  out.fallbacks = report.fallbacks;
  return out;
}

TEST(EventDriven, DiscLeavesACylinderAtTheKnownAngles) {
  const double start = std::cos(0.1);
  for (const auto& [mu, angle] :
       {std::pair(0.0, std::acos(2.0 / 3 * start)), std::pair(1e4, std::acos(4.0 / 7 * start)),
        std::pair(0.2, 0.907687858236848), std::pair(0.5, 0.936306116500060)}) {
    const Departure found = roll_off(mu);
    printf("mu %g error %.3e solves %d fallbacks %d\n", mu, found.angle - angle, found.solves, found.fallbacks);
    EXPECT_EQ(found.fallbacks, 0) << "mu " << mu;
    EXPECT_NEAR(found.angle, angle, 1e-12) << "mu " << mu;
    EXPECT_LE(found.solves, 400) << "mu " << mu;
  }
}

}  // namespace
}  // namespace skerry
