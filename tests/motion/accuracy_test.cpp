// SPDX-License-Identifier: MIT
//
// Accuracy on request: the error of scenes with known answers is of the order that was asked for.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "physics/stepping/stepper.h"
#include "tests/support/draw.h"
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

/// Place and velocity of a body, and what its steps said of their errors.
struct Outcome {
  Vec2 p, v;
  double angle = 0, omega = 0, estimate = 0;
};

double difference(const Outcome& x, const Outcome& y) {
  return std::max(
      {length(x.p - y.p), length(x.v - y.v), std::abs(x.angle - y.angle), std::abs(x.omega - y.omega)});
}

Outcome after_a_second(World& world, BodyId body) {
  double estimate = 0;
  for (int k = 0; k < 60; ++k) estimate += world.step(kStep).error_estimate;
  return {world.position(body), world.velocity(body), world.angle(body), world.omega(body), estimate};
}

TEST(Accuracy, CountsForWhatIsCutForItsOwnSake) {
  // Steps are cut where bars turn fast, in the same places however they are made.
  for (const double omega : {30.0, 60.0, 100.0}) {
    for (const double accuracy : {1e-3, 1e-5}) {
      WorldConfig config = test::weightless();
      config.stepper = "time_stepping";
      config.accuracy = accuracy;
      World world(config);
      const BodyId bar = world.create_body({.position = {0.5, 0},
                                            .velocity = {0, 0.5 * omega},
                                            .omega = omega,
                                            .mass = 1.0,
                                            .inertia = 1.0 / 12});
      world.create_joint({.kind = JointKind::Revolute, .b = bar, .anchor_a = {0, 0}});
      const Outcome out = after_a_second(world, bar);
      EXPECT_NEAR(out.angle, omega, 10 * accuracy) << omega << " rad/s, asked for " << accuracy;
      EXPECT_LE(out.estimate, 2 * accuracy);
    }
  }
}

/// A box that comes to rest by bouncing on its corners.
Outcome bounces(std::string_view stepper, double accuracy, unsigned seed, double higher) {
  test::Draw draw(seed);
  WorldConfig config;
  config.stepper = stepper;
  if (accuracy > 0) config.accuracy = accuracy;
  World world(config);
  add_ground(world, rough(make_disc(1), 0.4, 0.8));
  const double angle = draw.uniform(-0.3, 0.3), speed = draw.uniform(-1, 1), omega = draw.uniform(-1, 1);
  const Vec2 size{draw.uniform(0.3, 1), draw.uniform(0.3, 1)};
  const BodyId box =
      add(world, {0, 1 + higher}, rough(make_box(size), 0.4, 0.8), size.x * size.y, {speed, 0}, omega, angle);
  return after_a_second(world, box);
}

TEST(Accuracy, CountsForWhatBouncesToRest) {
  int asked = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    const Outcome known = bounces("event_driven", 0, seed, 0);
    const double growth = difference(known, bounces("event_driven", 0, seed, 1e-9)) / 1e-9;
    if (growth > 100) continue;
    ++asked;
    for (const double accuracy : {1e-4, 1e-6})
      EXPECT_LE(difference(known, bounces("time_stepping", accuracy, seed, 0)),
                10 * accuracy * std::max(1.0, growth))
          << "seed " << seed << ", asked for " << accuracy;
  }
  EXPECT_GT(asked, 40);
}

/// A block on a plate that shakes: it slides, leaves the plate and lands on it in each swing.
Outcome shaken(std::string_view stepper, double accuracy, double frequency) {
  WorldConfig config;
  config.stepper = stepper;
  if (accuracy > 0) config.accuracy = accuracy;
  World world(config);
  const BodyId plate = world.create_body({.type = BodyType::Kinematic});
  world.add_shape(plate, rough(make_box({40, 1}), 0.4));
  const double omega = 2 * kPi * frequency, wide = 0.1 / frequency, high = 0.05 / frequency;
  world.set_motion(plate, [=](double t) {
    return Placement{{wide * std::sin(omega * t), -0.5 + high * (std::sin(omega * t + 1) - std::sin(1.0))},
                     0};
  });
  const BodyId block = add(world, {0, 0.25}, rough(make_box({0.5, 0.5}), 0.4));
  return after_a_second(world, block);
}

TEST(Accuracy, CountsForWhatLiesOnGroundThatShakes) {
  for (const double frequency : {5.0, 10.0, 20.0}) {
    const Outcome known = shaken("event_driven", 0, frequency);
    for (const double accuracy : {1e-4, 1e-6})
      EXPECT_LE(length(shaken("time_stepping", accuracy, frequency).p - known.p), 10 * accuracy)
          << frequency << " Hz, asked for " << accuracy;
  }
}

/// A block on a table that shakes sideways, and slides for most of the time: after half a second.
Outcome slid(std::string_view stepper, double accuracy, unsigned seed) {
  test::Draw draw(seed);
  const double mu = draw.uniform(0.1, 0.6), omega = draw.uniform(5, 30), phase = draw.uniform(0, 2 * kPi);
  const double wide = draw.uniform(1.1, 4) * mu * kG / (omega * omega);
  WorldConfig config;
  config.stepper = stepper;
  if (accuracy > 0) config.accuracy = accuracy;
  World world(config);
  const BodyId table = world.create_body({.type = BodyType::Kinematic});
  world.add_shape(table, rough(make_box({20, 1}), mu));
  world.set_motion(table, [=](double t) { return Placement{{wide * std::sin(omega * t + phase), -0.5}, 0}; });
  const BodyId block = add(world, {0, 0.25}, rough(make_box({2, 0.5}), mu));
  for (int k = 0; k < 30; ++k) world.step(kStep);
  return {world.position(block), world.velocity(block)};
}

TEST(Accuracy, CountsForWhatStopsOnGroundThatShakes) {
  int exact = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Outcome known = slid("event_driven", 0, seed);
    for (const double accuracy : {1e-4, 1e-6})
      EXPECT_LE(difference(slid("time_stepping", accuracy, seed), known), 10 * accuracy)
          << "seed " << seed << ", asked for " << accuracy;
    // Stops are found without being asked for.
    exact += difference(slid("time_stepping", 0, seed), known) < 1e-8;
  }
  EXPECT_GE(exact, 20);
}

/// What rests until a force that grows lets it go: friction, resistance to rolling, friction in a hinge.
enum class LetGo { Sliding, Held, Rolling, Pulled, Hinge, Lifted };
Outcome let_go(std::string_view stepper, double accuracy, LetGo kind, unsigned seed) {
  test::Draw draw(seed);
  const double mu = draw.uniform(0.2, 0.7), share = draw.uniform(1.1, 3), omega = draw.uniform(2, 12);
  const double mass = draw.uniform(0.5, 3), arm = 0.05, torque = 0.3 * mass;
  WorldConfig config;
  config.stepper = stepper;
  if (accuracy > 0) config.accuracy = accuracy;
  if (kind == LetGo::Hinge) config.gravity = {};
  World world(config);
  ShapeDef ground = rough(make_disc(1), mu);
  ground.material.rolling_resistance = kind == LetGo::Rolling ? arm : 0;
  if (kind == LetGo::Held) ground.material.static_friction = 1.5 * mu;
  if (kind != LetGo::Hinge) add_ground(world, ground);
  ShapeDef shape = rough(kind == LetGo::Rolling ? make_disc(0.3) : make_box({2, 0.5}), mu);
  shape.material.rolling_resistance = ground.material.rolling_resistance;
  shape.material.static_friction = ground.material.static_friction;
  const double height = kind == LetGo::Rolling ? 0.3 : 0.25;
  const BodyId body = add(world, {0, height}, shape, mass);
  Vec2 force;
  double turning = 0;
  if (kind == LetGo::Sliding || kind == LetGo::Held) force.x = 1.5 * share * mu * mass * kG;
  if (kind == LetGo::Lifted) force.y = share * mass * kG;
  if (kind == LetGo::Rolling) turning = share * arm * mass * kG;
  if (kind == LetGo::Pulled) {
    const BodyId winch = world.create_body(
        {.type = BodyType::Kinematic, .position = {2, height}, .velocity = {0.3 * share, 0}});
    world.create_joint({.kind = JointKind::Spring,
                        .a = winch,
                        .b = body,
                        .anchor_a = {2, height},
                        .anchor_b = {0, height},
                        .length = 2,
                        .stiffness = mass * omega * omega});
  }
  if (kind == LetGo::Hinge) {
    turning = share * torque;
    world.create_joint({.kind = JointKind::Revolute,
                        .b = body,
                        .anchor_a = {0, height},
                        .anchor_b = {0, height},
                        .motor_speed = 0,
                        .motor_limit = torque});
  }
  if (kind != LetGo::Pulled) {
    world.set_force_field([=](const FieldSample& sample) {
      const double grown = std::sin(omega * sample.time);
      return Wrench{grown * force, grown * turning};
    });
  }
  for (int k = 0; k < 30; ++k) world.step(kStep);
  return {world.position(body), world.velocity(body), world.angle(body), world.omega(body)};
}

TEST(Accuracy, CountsForWhatIsLetGo) {
  for (const LetGo kind :
       {LetGo::Sliding, LetGo::Held, LetGo::Rolling, LetGo::Pulled, LetGo::Hinge, LetGo::Lifted}) {
    for (unsigned seed = 0; seed < 20; ++seed) {
      const Outcome known = let_go("event_driven", 0, kind, seed);
      for (const double accuracy : {1e-4, 1e-6}) {
        const Outcome found = let_go("time_stepping", accuracy, kind, seed);
        EXPECT_LE(difference(found, known), 10 * accuracy)
            << "kind " << static_cast<int>(kind) << ", seed " << seed << ", asked for " << accuracy;
      }
    }
  }
}

}  // namespace accuracy_test
}  // namespace skerry
