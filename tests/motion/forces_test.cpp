// SPDX-License-Identifier: MIT
//
// Force fields, drag and prescribed motions against their formulas.
#include <cmath>
#include <gtest/gtest.h>
#include <mutex>
#include <set>
#include <stdexcept>
#include <thread>

#include "physics/snapshot.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace forces_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;
using test::weightless;

WorldConfig by(const std::string& stepper, WorldConfig config = {}) {
  config.stepper = stepper;
  return config;
}

void run(World& world, double seconds, double h) {
  const int steps = static_cast<int>(std::lround(seconds / h));
  for (int i = 0; i < steps; ++i) world.step(h);
}

class Forces : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(By, Forces, testing::Values("time_stepping", "event_driven"),
                         [](const auto& stepper) { return stepper.param; });

/// Checks that the error is rounding for event_driven, and of second (or another) order for time_stepping.
template <class Error>
void expect_order(const std::string& stepper, double fine, Error&& error, int order = 2) {
  if (stepper == "event_driven") {
    EXPECT_NEAR(error(1.0 / 60), 0, 1e-11);
    return;
  }
  const double coarse = error(1.0 / 60), half = error(1.0 / 120);
  EXPECT_NEAR(std::log2(coarse / half), order, 0.11) << coarse;
  EXPECT_LT(std::abs(half), fine);
}

TEST_P(Forces, BodyOfACentralFieldRunsOnAnEllipse) {
  // Force -k r: x = cos(w t), y = v/w sin(w t).
  expect_order(GetParam(), 1e-3, [](double h) {
    World world(by(GetParam(), weightless()));
    const auto ball = add(world, {1, 0}, smooth(make_disc(0.1)), 2, {0, 1.5});
    world.set_force_field([](const FieldSample& s) { return Wrench{-9 * s.mass * s.position, 0}; });
    run(world, 1, h);
    return length(world.position(ball) - Vec2{std::cos(3.0), 0.5 * std::sin(3.0)});
  });
}

TEST_P(Forces, FieldThatDependsOnTimeIsTakenAtItsTime) {
  expect_order(GetParam(), 1e-4, [](double h) {
    World world(by(GetParam(), weightless()));
    const auto ball = add(world, {0, 0}, smooth(make_disc(0.1)), 2);
    world.set_force_field([](const FieldSample& s) { return Wrench{{s.mass * std::cos(5 * s.time), 0}, 0}; });
    run(world, 1, h);
    return world.position(ball).x - (1 - std::cos(5.0)) / 25;
  });
}

TEST_P(Forces, MagneticFieldTurnsAChargeInACircle) {
  expect_order(GetParam(), 2e-3, [](double h) {
    World world(by(GetParam(), weightless()));
    const auto ball = add(world, {0, 0}, smooth(make_disc(0.1)), 1, {2, 0});
    world.set_force_field([](const FieldSample& s) { return Wrench{4.0 * perp(s.velocity), 0}; });
    run(world, 1, h);
    return length(world.position(ball) - Vec2{0.5 * std::sin(4.0), 0.5 * (1 - std::cos(4.0))});
  });
}

TEST_P(Forces, LinearDragSlowsDownExponentially) {
  // Drag is integrated with a fourth-order approximation of the exponential.
  const auto error = [](double h) {
    World world(by(GetParam(), weightless()));
    const auto ball = add(world, {0, 0}, smooth(make_disc(1)), 2, {3, 0}, 4);  // inertia 1
    world.set_drag(ball, {.linear = 3, .angular = 2});
    run(world, 1, h);
    return std::abs(world.velocity(ball).x - 3 * std::exp(-1.5)) +
           std::abs(world.omega(ball) - 4 * std::exp(-2.0));
  };
  expect_order(GetParam(), 1e-8, error, 4);
}

TEST_P(Forces, QuadraticDragLeadsToTheTerminalSpeed) {
  // v = vt tanh(g t / vt), vt = sqrt(m g / c)
  expect_order(GetParam(), 1e-3, [](double h) {
    World world(by(GetParam()));
    const auto ball = add(world, {0, 0}, smooth(make_disc(0.1)), 2);
    world.set_drag(ball, {.quadratic = 0.5});
    run(world, 1, h);
    const double vt = std::sqrt(2 * 9.81 / 0.5);
    return world.velocity(ball).y + vt * std::tanh(9.81 / vt);
  });
}

TEST_P(Forces, ActThroughJointsToo) {
  // A pendulum without gravity in a sideways wind of constant force swings about the wind's direction as it
  // would about gravity's; with the force from the field.
  double end[2] = {};
  for (const bool field : {false, true}) {
    WorldConfig config = weightless();
    if (!field) config.gravity = {9, 0};
    World world(by(GetParam(), config));
    const auto ball = add(world, {0, -1}, smooth(make_disc(0.1)), 2);
    world.create_joint({.kind = JointKind::Distance, .b = ball, .anchor_b = {0, -1}});
    if (field) world.set_force_field([](const FieldSample& s) { return Wrench{{9 * s.mass, 0}, 0}; });
    run(world, 1, 1.0 / 60);
    end[field] = world.position(ball).x;
  }
  EXPECT_NEAR(end[0], end[1], 1e-11);
}

TEST_P(Forces, RestingBodyWakesWhenTheFieldOfTheTimeMovesIt) {
  // At rest for the first second, by friction; then the wind blows. A skip of resting islands must not miss
  // it.
  World world(by(GetParam()));
  add_ground(world, rough({}, 0.5));
  const auto box = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5), 1);
  world.set_force_field([](const FieldSample& s) { return Wrench{{s.time > 1.0 ? 6.0 : 0.0, 0}, 0}; });
  run(world, 1, 1.0 / 60);
  EXPECT_NEAR(world.position(box).x, 0, 1e-12);
  EXPECT_EQ(world.report().islands_at_rest, 0);
  run(world, 1, 1.0 / 60);
  EXPECT_NEAR(world.velocity(box).x, 6 - 0.5 * 9.81, 0.05);
}

TEST_P(Forces, WhatRestsInAMediumSleepsAndWakes) {
  World world(by(GetParam()));
  add_ground(world, rough(make_disc(1), 0.5), 0.2);
  const Rot q = Rot::from_angle(0.2);
  const BodyId box = add(world, rotate(q, {0, 0.25}), rough(make_box({2, 0.5}), 0.5), 2, {}, 0, 0.2);
  world.set_drag(box, {.linear = 3, .quadratic = 1, .angular = 1});
  for (int i = 0; i < 30 && !world.asleep(box); ++i) world.step(1.0 / 60);
  EXPECT_TRUE(world.asleep(box));
  const Vec2 rest = world.position(box);
  world.apply_impulse(box, rotate(q, {-2, 0}), rest);
  world.step(1.0 / 60);
  EXPECT_GT(length(world.position(box) - rest), 0.01);
}

TEST_P(Forces, ReportSaysWhatAFieldSwitchesOff) {
  World world(by(GetParam()));
  const auto ball = add(world, {0, 0}, smooth(make_disc(0.1)));
  world.step(1.0 / 60);
  EXPECT_FALSE(world.report().field_keeps_awake);
  EXPECT_FALSE(world.report().field_wants_one_thread);
  const auto wind = [](const FieldSample&) { return Wrench{{1, 0}, 0}; };
  world.set_force_field(wind);
  world.step(1.0 / 60);
  EXPECT_TRUE(world.report().field_keeps_awake);
  EXPECT_TRUE(world.report().field_wants_one_thread);
  world.set_force_field(wind, FieldThreads::Many);
  world.step(1.0 / 60);
  EXPECT_TRUE(world.report().field_keeps_awake);
  EXPECT_FALSE(world.report().field_wants_one_thread);
  EXPECT_NEAR(world.velocity(ball).x, 2.0 / 60, 1e-14);
}

TEST_P(Forces, FieldForManyThreadsIsCalledByThemAndGivesTheSameBits) {
  std::uint64_t hash[3] = {};
  std::size_t callers[3] = {};
  for (const int k : {0, 1, 2}) {
    WorldConfig config = by(GetParam());
    config.threads = k == 0 ? 1 : 4;
    World world(config);
    for (int i = 0; i < 200; ++i) add(world, {10.0 * i, 0}, smooth(make_disc(0.5)));
    std::mutex mutex;
    std::set<std::thread::id> threads;
    world.set_force_field(
        [&](const FieldSample& s) {
          {
            const std::lock_guard lock(mutex);
            threads.insert(std::this_thread::get_id());
          }
          std::this_thread::yield();
          return Wrench{-s.mass * s.position, 0};
        },
        k == 2 ? FieldThreads::Many : FieldThreads::One);
    for (int i = 0; i < 20; ++i) world.step(1.0 / 60);
    hash[k] = world.report().state_hash;
    callers[k] = threads.size();
  }
  EXPECT_EQ(hash[1], hash[0]);
  EXPECT_EQ(hash[2], hash[0]);
  EXPECT_EQ(callers[0], 1u);
  EXPECT_EQ(callers[1], 1u);
  EXPECT_GT(callers[2], 1u);
}

TEST_P(Forces, FlightInAFieldIsCountedAsNoFlight) {
  World world(by(GetParam()));
  const auto ball = add(world, {0, 0}, smooth(make_disc(0.1)), 1, {1, 0});
  world.step(1.0 / 60);
  EXPECT_EQ(world.report().islands_in_flight, 1);
  world.set_drag(ball, {.linear = 0.1});
  world.step(1.0 / 60);
  EXPECT_EQ(world.report().islands_in_flight, 0);
}

TEST_P(Forces, LandingUnderDragIsFound) {
  // Drag makes the path no parabola: the ball must still not sink in.
  World world(by(GetParam()));
  add_ground(world, smooth({}));
  const auto ball = add(world, {0, 2}, smooth(make_disc(0.1)), 1);
  world.set_drag(ball, {.linear = 2});
  for (int i = 0; i < 120; ++i) {
    world.step(1.0 / 60);
    ASSERT_GE(world.position(ball).y, 0.1 - 1e-9);
  }
  EXPECT_NEAR(world.position(ball).y, 0.1, 1e-9);
}

TEST_P(Forces, FieldThatThrowsOrIsNotFiniteLeavesTheBodiesWhereTheyWere) {
  World world(by(GetParam()));
  const auto ball = add(world, {0, 2}, smooth(make_disc(0.1)), 1);
  const auto other = add(world, {3, 2}, smooth(make_disc(0.1)), 1);
  int calls = 0;
  world.set_force_field([&](const FieldSample&) -> Wrench {
    if (++calls > 3) throw std::runtime_error("no more");
    return {};
  });
  EXPECT_THROW(world.step(1.0 / 60), std::runtime_error);
  EXPECT_EQ(world.position(ball).y, 2);
  EXPECT_EQ(world.position(other).y, 2);
  EXPECT_EQ(world.velocity(other).y, 0);
  world.set_force_field([](const FieldSample&) { return Wrench{{NAN, 0}, 0}; });
  EXPECT_THROW(world.step(1.0 / 60), std::invalid_argument);
  world.set_force_field({});
  run(world, 0.5, 1.0 / 60);
  EXPECT_NEAR(world.position(ball).y, 2 - 0.125 * 9.81, 1e-12);
  EXPECT_THROW(world.set_drag(ball, {.linear = -1}), std::invalid_argument);
}

/// Its report says how far the world came, and why not farther; what comes then is as if it had not been
/// tried.
TEST_P(Forces, AStepThatWasInterruptedIsReportedAndMadeAgain) {
  const auto make = [] {
    World world(by(GetParam()));
    add_ground(world, rough(make_disc(1), 0.5, 0.3));
    for (int i = 0; i < 4; ++i) add(world, {0.1 * i, 0.3 + 0.7 * i}, rough(make_box({0.6, 0.6}), 0.5, 0.3));
    add(world, {-2, 0.5}, rough(make_disc(0.3), 0.5, 0.3), 1, {6, 0}, 1);
    return world;
  };
  World world = make(), other = make();
  bool throws = false;
  int calls = 0;
  world.set_force_field([&](const FieldSample&) {
    if (throws && ++calls > 7) throw std::runtime_error("no more");
    return Wrench{};
  });
  other.set_force_field([](const FieldSample&) { return Wrench{}; });
  for (int k = 0; k < 60; ++k) {
    if (k % 10 == 5) {
      const double energy = world.report().kinetic_energy + world.report().potential_energy;
      const std::uint64_t hash = world.report().state_hash;
      throws = true;
      calls = 0;
      EXPECT_THROW(world.step(1.0 / 60), std::runtime_error);
      throws = false;
      const StepReport& report = world.report();
      EXPECT_EQ(report.interrupted, "no more");
      EXPECT_EQ(report.step, static_cast<std::uint64_t>(k));
      EXPECT_EQ(report.time, world.time());
      EXPECT_EQ(report.h, 0);
      EXPECT_EQ(report.dynamic_bodies, 5);
      EXPECT_EQ(report.state_hash, hash);
      EXPECT_NEAR(report.kinetic_energy + report.potential_energy, energy, 1e-12 * energy);
      EXPECT_TRUE(report.contacts_list.empty() && report.events.empty());
    }
    EXPECT_TRUE(world.step(1.0 / 60).interrupted.empty());
    EXPECT_EQ(other.step(1.0 / 60).state_hash, world.report().state_hash) << k;
  }
}

/// Inner steps that are too long for a force diverge while they are tried; that is no fault of the force.
TEST(SteepForces, AreIntegratedWithStepsThatAreShortEnough) {
  for (const char* stepper : {"event_driven", "auto"}) {
    World world(by(stepper, weightless()));
    const double speed = 10, steepness = 1e4;
    const BodyId disc = add(world, {0, 0}, smooth(make_disc(0.5)), 1, {speed, 0});
    world.set_force_field([&](const FieldSample& s) {
      return Wrench{-steepness * length_squared(s.velocity) * s.velocity, 0};
    });
    ASSERT_NO_THROW(world.step(1.0 / 60)) << stepper;
    // 1/v^2 grows by 2 k t.
    EXPECT_NEAR(world.velocity(disc).x, 1 / std::sqrt(1 / (speed * speed) + 2 * steepness / 60), 1e-10);
  }
}

/// Far beyond the bound that the explicit treatment sets to the step, tries diverge, which is no exception.
TEST(SteepForces, ThatDivergeLeaveTheStepWithNumbers) {
  for (const double accuracy : {0.0, 1e-4}) {
    WorldConfig config;
    if (accuracy > 0) config.accuracy = accuracy;
    config.solve.work_limit = 1e5;
    World world(config);
    const BodyId terrain = world.create_body({.type = BodyType::Static});
    world.add_shape(terrain, smooth(make_chain(std::vector<Vec2>{{-9, 0}, {9, 1}})));
    const BodyId splinter = add(world, {0, 5.6}, smooth(make_box({0.0026, 0.013})), 0.034, {}, -1);
    world.set_force_field([](const FieldSample& f) {
      return Wrench{-(30 + 0.15 * length(f.velocity)) * f.velocity, -2e6 * f.omega};
    });
    for (int k = 0; k < 120; ++k) {
      ASSERT_NO_THROW(world.step(1.0 / 60)) << "step " << k;
      ASSERT_TRUE(is_finite(world.position(splinter)) && std::isfinite(world.angle(splinter)));
    }
  }
}

/// Drag only slows down, however steep it is for the step.
TEST_P(Forces, SteepDragStopsAndNeverThrows) {
  for (const double size : {1e-2, 1.0, 1e3, 1e8, 1e20, 1e300}) {
    for (const Drag& drag : {Drag{.linear = size}, Drag{.quadratic = size}, Drag{.angular = size},
                             Drag{.angular_quadratic = size}}) {
      World world(by(GetParam()));
      world.add_shape(world.create_body({.type = BodyType::Static}),
                      rough(make_half_plane({0, 0}, {0, 1}), 0.7));
      // One on the ground, and one that flies.
      const BodyId marble = add(world, {0, 0.0016}, rough(make_disc(0.0016), 0.7), 0.008, {3, 0}, 1e3);
      const BodyId other = add(world, {0, 3}, smooth(make_box({0.0026, 0.013})), 0.034, {-4, 0}, 1e5);
      world.set_drag(marble, drag);
      world.set_drag(other, drag);
      double vx = 4, omega = 1e5;
      for (int k = 0; k < 20; ++k) {
        EXPECT_EQ(world.step(1.0 / 60).contained, 0) << "drag " << size << ", step " << k;
        ASSERT_LE(length(world.velocity(marble)), 12);
        ASSERT_LE(std::abs(world.omega(marble)), 1.3e3);
        const Vec2 v = world.velocity(other);
        ASSERT_LE(std::abs(v.x), vx + 1e-12) << "drag " << size << ", step " << k;
        ASSERT_LE(std::abs(world.omega(other)), omega + 1e-10) << "drag " << size << ", step " << k;
        ASSERT_LE(v.x, 1e-12);
        ASSERT_GE(world.omega(other), -1e-10);
        vx = -v.x;
        omega = world.omega(other);
        // What stands on the ground does not lean on the medium.
        EXPECT_NEAR(world.report().total_normal_impulse * 60, 0.008 * 9.81, 1e-9) << "drag " << size;
      }
    }
  }
}

/// Bodies at 10 m/s stop within m v / c, or slow down by the logarithm of quadratic drag; a step in one piece
/// took them half-way to where they went without it, up to 80 times as far.
TEST_P(Forces, SteepDragStopsBodiesWhereItShould) {
  const double speed = 10, time = 0.5;
  for (const double drag : {60.0, 300.0, 1000.0, 1e4}) {
    for (const bool quadratic : {false, true}) {
      World world(by(GetParam(), weightless()));
      const BodyId body = add(world, {0, 0}, rough(make_disc(0.1), 0.5), 1, {speed, 0}, 20);
      Drag medium{.linear = drag, .angular = 1e-3 * drag};
      if (quadratic) medium = {.quadratic = drag};
      world.set_drag(body, medium);
      run(world, time, 1.0 / 60);
      const double way = quadratic ? std::log1p(drag * speed * time) / drag : speed / drag;
      EXPECT_NEAR(world.position(body).x, way, 1e-3 + 0.08 * way) << drag << (quadratic ? " s/m" : " N s/m");
      const double turn = 20 * world.inertia(body) / medium.angular;
      if (!quadratic) {
        EXPECT_NEAR(world.angle(body), turn, 0.01 + 0.08 * turn) << drag << " N s/m";
      }
    }
  }
}

TEST_P(Forces, ThreadsAskTheFieldInTheSameOrder) {
  std::uint64_t hash[2] = {};
  for (const int threads : {1, 4}) {
    WorldConfig config = by(GetParam());
    config.threads = threads;
    World world(config);
    for (int i = 0; i < 20; ++i) add(world, {2.0 * i, 1}, smooth(make_disc(0.5)), 1 + i);
    double sum = 0;  // depends on the order of the calls
    world.set_force_field([&](const FieldSample& s) {
      sum = 0.5 * sum + s.mass;
      return Wrench{{sum, 0}, 0};
    });
    for (int i = 0; i < 10; ++i) world.step(1.0 / 60);
    hash[threads > 1] = world.state_hash();
  }
  EXPECT_EQ(hash[0], hash[1]);
}

TEST_P(Forces, PrescribedMotionIsFollowedAndItsVelocityReachesWhatItCarries) {
  // A shaken table with a box that sticks: it must follow the table's cosine.
  World world(by(GetParam()));
  const auto table = world.create_body({.type = BodyType::Kinematic});
  world.add_shape(table, rough(make_box({4, 0.2}), 0.9));
  const auto box = add(world, {0, 0.35}, rough(make_box({0.5, 0.5}), 0.9), 1);
  const double w = 2 * kPi, amplitude = 0.1;  // 0.1 w^2 = 3.9 < 0.9 g
  world.set_motion(table, [&](double t) { return Placement{{amplitude * (1 - std::cos(w * t)), 0}, 0}; });
  const bool events = GetParam() == "event_driven";
  for (int i = 0; i < 120; ++i) {
    world.step(1.0 / 60);
    const double t = world.time();
    ASSERT_NEAR(world.position(table).x, amplitude * (1 - std::cos(w * t)), 1e-14);
    ASSERT_NEAR(world.velocity(table).x, amplitude * w * std::sin(w * t), 1e-9);
    ASSERT_NEAR(world.position(box).x, world.position(table).x, events ? 1e-8 : 1e-3) << i;
  }
  EXPECT_EQ(world.report().fallbacks, 0);
}

TEST_P(Forces, CrankDrivesASliderByItsPrescribedTurning) {
  // x = r cos(a) + sqrt(l^2 - r^2 sin(a)^2)
  World world(by(GetParam(), weightless()));
  const auto crank = world.create_body({.type = BodyType::Kinematic});
  const double r = 0.3, l = 1, w = 4;
  const auto piston = add(world, {r + l, 0}, smooth(make_box({0.2, 0.2})), 1);
  world.set_motion(crank, [&](double t) { return Placement{{0, 0}, w * t}; });
  world.create_joint(
      {.kind = JointKind::Distance, .a = crank, .b = piston, .anchor_a = {r, 0}, .anchor_b = {r + l, 0}});
  world.create_joint({.kind = JointKind::Prismatic, .b = piston, .anchor_a = {r + l, 0}, .axis = {1, 0}});
  for (int i = 0; i < 180; ++i) {
    world.step(1.0 / 60);
    const double a = w * world.time();
    ASSERT_NEAR(world.position(piston).x,
                r * std::cos(a) + std::sqrt(l * l - r * r * std::sin(a) * std::sin(a)), 1e-11);
  }
}

TEST_P(Forces, BallLandsOnARisingLift) {
  World world(by(GetParam()));
  const auto lift = world.create_body({.type = BodyType::Kinematic});
  world.add_shape(lift, smooth(make_box({2, 0.2})));
  const auto ball = add(world, {0, 1}, smooth(make_disc(0.1)), 1);
  world.set_motion(lift, [](double t) { return Placement{{0, 0.5 * t * t}, 0}; });  // a = 1 m/s^2
  run(world, 1.5, 1.0 / 60);
  EXPECT_NEAR(world.position(ball).y, 0.5 * 1.5 * 1.5 + 0.2, 1e-9);
  EXPECT_NEAR(world.velocity(ball).y, 1.5, GetParam() == "event_driven" ? 1e-9 : 1e-6);
  EXPECT_THROW(world.set_motion(ball, [](double) { return Placement{}; }), std::invalid_argument);
  EXPECT_THROW(world.set_motion(lift, [](double) { return Placement{{NAN, 0}, 0}; }), std::invalid_argument);
}

TEST_P(Forces, WhatAPrescribedMotionThrowsLeavesBodiesWhereTheyWere) {
  World world(by(GetParam(), weightless()));
  const auto make = [&world] { return world.create_body({.type = BodyType::Kinematic}); };
  const BodyId first = make(), second = make();
  world.set_motion(first, [](double t) { return Placement{{0.1 + t, 0}, 0}; });
  bool throws = false;
  world.set_motion(second, [&](double t) {
    if (throws) throw std::runtime_error("no");
    return Placement{{t, 5}, 0};
  });
  world.set_pose(first, {0.3, 2}, 1);
  world.set_velocity(first, {0, 9}, 2);
  throws = true;
  EXPECT_THROW(world.step(1.0 / 60), std::runtime_error);
  EXPECT_EQ(world.position(first), (Vec2{0.3, 2}));
  EXPECT_EQ(world.angle(first), 1);
  EXPECT_EQ(world.velocity(first), (Vec2{0, 9}));
  EXPECT_EQ(world.omega(first), 2);
}

TEST_P(Forces, ABodyInThePlaceOfAnotherFeelsTheFieldAsItsOwn) {
  World world(by(GetParam(), weightless()));
  // A circle with the circular frequency 2.
  world.set_force_field([](const FieldSample& s) { return Wrench{-4 * s.mass * s.position, 0}; });
  const auto make = [&world] { return add(world, {1, 0}, smooth(make_disc(0.1)), 1, {0, 2}); };
  BodyId body = make();
  world.step(1.0 / 60);
  world.destroy(body);
  body = make();
  for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
  const double tolerance = GetParam() == "event_driven" ? 1e-9 : 1e-3;
  EXPECT_NEAR(length(world.position(body)), 1, tolerance);
  EXPECT_NEAR(length(world.velocity(body)), 2, tolerance);
  EXPECT_EQ(world.bodies().island[body.index], 0);
}

TEST_P(Forces, SnapshotGoesOnBitByBitWithItsDragAndTheCallbacksOfTheOther) {
  World world(by(GetParam()));
  const auto lift = world.create_body({.type = BodyType::Kinematic});
  world.add_shape(lift, rough(make_box({2, 0.2}), 0.5));
  const auto ball = add(world, {0, 1}, rough(make_disc(0.1), 0.5), 1, {0.1, 0});
  world.set_drag(ball, {.linear = 0.3});
  world.set_motion(lift, [](double t) { return Placement{{0, 0.1 * std::sin(3 * t)}, 0}; });
  world.set_force_field([](const FieldSample& s) { return Wrench{{0.1 * s.time, 0}, 0}; });
  run(world, 0.3, 1.0 / 60);
  World copy = load_snapshot(save_snapshot(world));
  copy.adopt(world.callbacks());
  for (int i = 0; i < 60; ++i) {
    world.step(1.0 / 60);
    copy.step(1.0 / 60);
    ASSERT_EQ(world.state_hash(), copy.state_hash()) << i;
  }
}

}  // namespace forces_test
}  // namespace skerry
