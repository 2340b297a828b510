// SPDX-License-Identifier: MIT
//
// Accuracy on request: the error of scenes with known answers is of the order that was asked for.
#include <cmath>
#include <gtest/gtest.h>

#include "physics/stepping/stepper.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace accuracy_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;

constexpr double kG = 9.81;
constexpr double kStep = 1.0 / 60;

World world_with(std::string_view stepper, double accuracy) {
  WorldConfig config;
  config.stepper = stepper;
  World world(config);
  world.set_accuracy(accuracy);
  return world;
}

/// Runs until `seconds` and tells whether any inner steps were made under error control.
void run(World& world, double seconds) {
  int controlled = 0;
  const int steps = static_cast<int>(std::lround(seconds / kStep));
  for (int i = 0; i < steps; ++i) controlled += world.step(kStep).inner_steps;
  EXPECT_GT(controlled, 0);
}

/// Bowling: slides, then rolls.
double bowling_error(std::string_view stepper, double accuracy) {
  const double mu = 0.2, v0 = 3, r = 0.5;
  World world = world_with(stepper, accuracy);
  add_ground(world, rough(make_disc(1), mu));
  const auto disc = add(world, {0, r}, rough(make_disc(r), mu), 1, {v0, 0});
  run(world, 1);
  const double time = v0 / (3 * mu * kG), path = 5 * v0 * v0 / (18 * mu * kG);
  return std::max(std::abs(world.position(disc).x - (path + 2 * v0 / 3 * (1 - time))),
                  std::abs(world.velocity(disc).x - 2 * v0 / 3));
}

/// A pendulum from rest at 1 rad: after a period it is back.
double pendulum_error(std::string_view stepper, double accuracy) {
  World world = world_with(stepper, accuracy);
  const double reach = 1.0, start = 1.0, inertia = 0.1;
  const auto bob = world.create_body(
      {.position = {reach * std::sin(start), -reach * std::cos(start)}, .mass = 1.0, .inertia = inertia});
  world.create_joint({.kind = JointKind::Revolute, .b = bob, .anchor_a = {0, 0}, .anchor_b = {0, 0}});
  double a = 1, g = std::cos(start / 2);
  for (int i = 0; i < 20; ++i) {
    const double mean = 0.5 * (a + g);
    g = std::sqrt(a * g);
    a = mean;
  }
  const double period = 2 * kPi / a * std::sqrt((reach * reach + inertia) / (kG * reach));
  for (int i = 0; i < 100; ++i) world.step(period / 100);
  return std::max(std::abs(world.angle(bob)), std::abs(world.omega(bob)));
}

/// Disc rolling off a cylinder: energy and geometry give the angle at which it leaves.
double departure_error(std::string_view stepper, double accuracy) {
  const double r = 0.25, reach = 1 + r, start = 0.1;
  World world = world_with(stepper, accuracy);
  const auto cylinder = world.create_body({.type = BodyType::Static});
  world.add_shape(cylinder, smooth(make_disc(1)));
  const auto disc = add(world, {reach * std::sin(start), reach * std::cos(start)}, smooth(make_disc(r)));
  run(world, 2);
  // Without friction it leaves at cos t = 2/3 cos t0; then its horizontal velocity stays.
  const double cosine = 2.0 / 3 * std::cos(start);
  const double speed = std::sqrt(2 * kG * reach * (std::cos(start) - cosine));
  return std::abs(world.velocity(disc).x - speed * cosine);
}

class AccuracyOf : public testing::TestWithParam<std::string_view> {};

TEST_P(AccuracyOf, ErrorsAreOfTheOrderThatWasAskedFor) {
  for (const auto& [name, error_of] :
       {std::pair("bowling", &bowling_error), std::pair("pendulum", &pendulum_error),
        std::pair("departure", &departure_error)}) {
    for (const double accuracy : {1e-4, 1e-6, 1e-8}) {
      const double error = error_of(GetParam(), accuracy);
      std::printf("%-14s %-10s asked for %g: error %.2g\n", std::string(GetParam()).c_str(), name, accuracy,
                  error);
      EXPECT_LE(error, 10 * accuracy) << name;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Registry, AccuracyOf, testing::Values("time_stepping", "event_driven", "auto"),
                         [](const auto& stepper) { return std::string(stepper.param); });

TEST(Accuracy, EventDrivenStepsGrowWithWhatIsAllowed) {
  // Two seconds of a pendulum in one step: only the accuracy decides how it is divided.
  int solves_before = 0;
  for (const double accuracy : {1e-10, 1e-7, 1e-4}) {
    World coarse = world_with("event_driven", accuracy), fine = world_with("event_driven", 1e-14);
    BodyId bobs[2];
    World* worlds[2] = {&coarse, &fine};
    for (int k = 0; k < 2; ++k) {
      bobs[k] = worlds[k]->create_body({.position = {1, 0}, .mass = 1.0, .inertia = 0.1});
      worlds[k]->create_joint(
          {.kind = JointKind::Revolute, .b = bobs[k], .anchor_a = {0, 0}, .anchor_b = {0, 0}});
      worlds[k]->step(2);
    }
    EXPECT_NEAR(coarse.omega(bobs[0]), fine.omega(bobs[1]), 10 * accuracy);
    const int solves = coarse.report().force_solves;
    if (solves_before > 0) {
      EXPECT_LT(solves, solves_before);
    }
    solves_before = solves;
  }
}

TEST(Accuracy, IslandsThatNeedSmallStepsTakeThemAlone) {
  const auto steps_of = [](bool first, bool second) {
    World world = world_with("time_stepping", 1e-6);
    const auto add_pendulum = [&](double x, double length) {
      const auto bob =
          world.create_body({.position = {x + length, 0}, .mass = 1.0, .inertia = 0.01 * length * length});
      world.create_joint({.kind = JointKind::Revolute, .b = bob, .anchor_a = {x, 0}, .anchor_b = {x, 0}});
    };
    if (first) add_pendulum(0, 5);
    if (second) add_pendulum(100, 0.05);
    int steps = 0;
    for (int i = 0; i < 60; ++i) steps += world.step(kStep).inner_steps;
    return steps;
  };
  const int slow = steps_of(true, false), fast = steps_of(false, true);
  EXPECT_GT(fast, 3 * slow);
  EXPECT_EQ(steps_of(true, true), slow + fast);
}

TEST(Accuracy, IsReportedWithStepsAndRejections) {
  World world = world_with("time_stepping", 1e-6);
  const auto cylinder = world.create_body({.type = BodyType::Static});
  world.add_shape(cylinder, rough(make_disc(1), 0.2));
  add(world, {1.25 * std::sin(0.1), 1.25 * std::cos(0.1)}, rough(make_disc(0.25), 0.2));
  int rejected = 0;
  double estimate = 0;
  for (int i = 0; i < 60; ++i) {
    const StepReport& report = world.step(kStep);
    rejected += report.rejected_steps;
    estimate += report.error_estimate;
  }
  EXPECT_GT(rejected, 0);  // where it begins to slip
  EXPECT_GT(estimate, 0);
  EXPECT_LE(estimate, 1e-6);
}

TEST(Accuracy, RestingIslandsAreStillNotComputedAgain) {
  World world = world_with("time_stepping", 1e-6);
  add_ground(world, rough(make_disc(1), 0.5));
  for (int i = 0; i < 5; ++i) add(world, {0, i + 0.5}, rough(make_box({1, 1}), 0.5));
  for (int i = 0; i < 30; ++i) world.step(kStep);
  EXPECT_EQ(world.report().islands_at_rest, 1);
}

TEST(Accuracy, RefusesWhatNoStepperCanGive) {
  World world;
  for (const double wrong : {0.0, -1e-6, 1e-15, 0.1, std::nan("")})
    EXPECT_THROW(world.set_accuracy(wrong), std::invalid_argument) << wrong;
  world.set_accuracy(std::nullopt);
  EXPECT_FALSE(world.config().accuracy);
}

// Narrow orbits take many inner steps in a second: each has its part of the error, not all of it.
TEST(Accuracy, IsThatOfASecondForAnyNumberOfInnerSteps) {
  constexpr double strength = 4;
  for (const double eccentricity : {0.3, 0.6, 0.9}) {
    for (const double axis : {0.3, 0.5}) {
      for (const double wanted : {1e-6, 1e-8, 1e-10}) {
        SCOPED_TRACE(testing::Message() << eccentricity << ", " << axis << " m, " << wanted);
        WorldConfig config = test::weightless();
        config.stepper = "event_driven";
        config.accuracy = wanted;
        World world(config);
        world.set_force_field([](const FieldSample& s) {
          const double r = length(s.position);
          return Wrench{(-strength * s.mass / (r * r * r)) * s.position, 0};
        });
        const double slowest = std::sqrt(strength / axis * (1 - eccentricity) / (1 + eccentricity));
        const BodyId planet =
            add(world, {-axis * (1 + eccentricity), 0}, smooth(make_disc(0.01)), 2, {0, -slowest});
        double estimate = 0;
        for (int i = 0; i < 60; ++i) estimate += world.step(kStep).error_estimate;
        // Kepler's equation, from the far end of the orbit on.
        const double mean = std::sqrt(strength / (axis * axis * axis)) + kPi;
        double anomaly = mean;
        for (int i = 0; i < 100; ++i)
          anomaly -=
              (anomaly - eccentricity * std::sin(anomaly) - mean) / (1 - eccentricity * std::cos(anomaly));
        const Vec2 place = axis * Vec2{std::cos(anomaly) - eccentricity,
                                       std::sqrt(1 - eccentricity * eccentricity) * std::sin(anomaly)};
        EXPECT_LT(length(world.position(planet) - place), wanted);
        EXPECT_LE(estimate, wanted * (1 + 1e-9));
      }
    }
  }
}

}  // namespace accuracy_test
}  // namespace skerry
