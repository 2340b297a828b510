// SPDX-License-Identifier: MIT
//
// The end of sliding falls inside a step of time_stepping: the step is cut there, so where a body stops does
// not depend on the step. All by formula.
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "tests/support/worlds.h"

namespace skerry {
namespace sliding_stop_test {

using test::add;
using test::add_ground;
using test::rough;

constexpr double kG = 9.81;
constexpr double kExact = 1e-13;
// Steps a second; no stop falls on the end of a step.
constexpr int kRates[] = {30, 60, 61, 240};

void run_a_second(World& world, int steps) {
  for (int i = 0; i < steps; ++i) world.step(1.0 / steps);
}

TEST(SlidingStop, BlockStopsWhereTheFormulaSaysAndStays) {
  const double mu = 0.3, speed = 2;
  for (const int steps : kRates) {
    World world;
    add_ground(world, rough(make_disc(1), mu));
    const auto block = add(world, {0, 0.25}, rough(make_box({2, 0.5}), mu), 1, {speed, 0});
    run_a_second(world, steps);
    EXPECT_NEAR(world.position(block).x, speed * speed / (2 * mu * kG), kExact) << steps;
    EXPECT_EQ(world.velocity(block).x, 0) << steps;
  }
}

TEST(SlidingStop, BlockThrownUpASteepInclineTurnsBack) {
  const double mu = 0.3, speed = 2, angle = 0.5;
  for (const int steps : kRates) {
    World world;
    add_ground(world, rough(make_disc(1), mu), angle);
    const Rot q = Rot::from_angle(angle);
    const auto block =
        add(world, rotate(q, {0, 0.25}), rough(make_box({2, 0.5}), mu), 1, rotate(q, {speed, 0}), 0, angle);
    run_a_second(world, steps);
    const double up = kG * (std::sin(angle) + mu * std::cos(angle)),
                 down = kG * (std::sin(angle) - mu * std::cos(angle)), rest = 1 - speed / up;
    EXPECT_NEAR(dot(world.position(block), rotate(q, {1, 0})),
                speed * speed / (2 * up) - 0.5 * down * rest * rest, kExact)
        << steps;
  }
}

TEST(SlidingStop, DiscSlidesUntilItRolls) {
  // v = 2/3 v0 from t = v0 / (3 mu g) on, after 5 v0^2 / (18 mu g).
  const double mu = 0.2, speed = 3;
  for (const int steps : kRates) {
    World world;
    add_ground(world, rough(make_disc(1), mu));
    const auto disc = add(world, {0, 0.5}, rough(make_disc(0.5), mu), 1, {speed, 0});
    run_a_second(world, steps);
    const double time = speed / (3 * mu * kG), path = 5 * speed * speed / (18 * mu * kG);
    EXPECT_NEAR(world.position(disc).x, path + 2 * (1 - time), kExact) << steps;
    EXPECT_NEAR(world.velocity(disc).x, 2, kExact) << steps;
    EXPECT_NEAR(world.omega(disc), -4, kExact) << steps;
  }
}

TEST(SlidingStop, BlockIsTakenAlongByAConveyor) {
  const double mu = 0.3, belt = 1.5;
  for (const int steps : kRates) {
    World world;
    const auto ground = world.create_body({.type = BodyType::Static});
    ShapeDef surface = rough(make_half_plane({0, 0}, {0, 1}), mu);
    surface.material.surface_velocity = belt;
    world.add_shape(ground, surface);
    const auto block = add(world, {0, 0.25}, rough(make_box({2, 0.5}), mu));
    run_a_second(world, steps);
    const double time = belt / (mu * kG);
    EXPECT_NEAR(std::abs(world.position(block).x), 0.5 * mu * kG * time * time + belt * (1 - time), kExact)
        << steps;
    EXPECT_NEAR(std::abs(world.velocity(block).x), belt, kExact) << steps;
  }
}

// A table that is told to move: its velocity changes within the step.
TEST(SlidingStop, OnATableThatIsToldToMoveTurnsBackByTheFormula) {
  const double mu = 0.2, speed = 1.2, braking = 8, end = 0.3;
  // The table outruns the block until both have the same speed, and falls behind it from then on.
  const double time = speed / (braking + mu * kG), late = end - time;
  const double way = 0.5 * mu * kG * (time * time - late * late) + mu * kG * time * late;
  for (const int steps : {50, 100, 1000}) {
    World world;
    const BodyId table = world.create_body({.type = BodyType::Kinematic});
    world.add_shape(table, rough(make_box({4, 0.2}), mu));
    world.set_motion(table, [=](double t) { return Placement{{speed * t - 0.5 * braking * t * t, 0}, 0}; });
    const BodyId block = add(world, {0, 0.25}, rough(make_box({0.3, 0.3}), mu));
    for (int i = 0; i < std::lround(end * steps); ++i) world.step(1.0 / steps);
    EXPECT_NEAR(world.position(block).x, way, 1e-11) << steps;
  }
}

// A disc on the axle of a wheel that turns to and fro: their hinge rubs, slides and holds in turn. What
// drives the disc is in its middle, and its mass is farther out than its shape is.
TEST(SlidingStop, AWheelThatIsToldToTurnTakesWhatRubsOnItsAxleAlong) {
  const auto angle_after = [](const char* stepper, int steps, double seconds) {
    World world({.gravity = {0, 0}, .stepper = stepper});
    const BodyId wheel = world.create_body({.type = BodyType::Kinematic});
    world.set_motion(wheel, [](double t) { return Placement{{0, 0}, 0.5 * std::sin(3 * t)}; });
    const BodyId disc = world.create_body({.mass = 1.0, .inertia = 0.5});
    world.add_shape(disc, {.shape = make_disc(0.3)});
    world.create_joint(
        {.kind = JointKind::Revolute, .a = wheel, .b = disc, .motor_speed = 0, .motor_limit = 1});
    for (int i = 0; i < std::lround(seconds * steps); ++i) world.step(1.0 / steps);
    return world.angle(disc);
  };
  for (const char* stepper : {"time_stepping", "event_driven"})
    EXPECT_NEAR(angle_after(stepper, 50, 0.3), 0.09, 1e-13) << stepper;
  const double later = angle_after("event_driven", 50, 2);
  EXPECT_NEAR(angle_after("event_driven", 500, 2), later, 1e-9);
  EXPECT_NEAR(angle_after("time_stepping", 50, 2), later, 1e-3);
  EXPECT_NEAR(angle_after("time_stepping", 200, 2), later, 5e-5);
  EXPECT_NEAR(angle_after("time_stepping", 800, 2), later, 2e-6);
}

TEST(SlidingStop, FarOutATableThatSwingsTakesWhatSticksAlong) {
  for (const double far : {0.0, 1000.0}) {
    World world;
    const BodyId table = world.create_body({.type = BodyType::Kinematic, .position = {far, 0}});
    world.add_shape(table, rough(make_box({4, 0.2}), 0.4));
    world.set_motion(table, [=](double t) { return Placement{{far + 0.149 * std::sin(5 * t), 0}, 0}; });
    const BodyId block = add(world, {far, 0.25}, rough(make_box({0.3, 0.3}), 0.4), 1, {0.745, 0});
    for (int i = 0; i < 600; ++i) world.step(1.0 / 60);
    EXPECT_NEAR(world.position(block).x - world.position(table).x, 0, 1e-4) << far;
  }
}

TEST(SlidingStop, RollingResistanceStopsADisc) {
  // m a = -F and m r^2/2 a/r = F r - c m g without slip: a = -c g / (3/2 r).
  const double c = 0.02, r = 0.5, speed = 0.2;
  for (const int steps : kRates) {
    World world;
    ShapeDef like = rough(make_disc(r), 0.5);
    like.material.rolling_resistance = c;
    add_ground(world, like);
    const auto disc = add(world, {0, r}, like, 1, {speed, 0}, -speed / r);
    run_a_second(world, steps);
    EXPECT_NEAR(world.position(disc).x, speed * speed / (2 * c * kG / (1.5 * r)), kExact) << steps;
    EXPECT_EQ(world.omega(disc), 0) << steps;
  }
}

TEST(SlidingStop, SeveralBlocksStopInOneStepEachAtItsOwnPlace) {
  // A block on a block: the upper one is slower on a rougher face. Both accelerations are constant until the
  // first stop, then until the second: mu_1 between the blocks, mu_2 on the ground, masses m.
  //   above: a1 = -mu_1 g;  below: a2 = (mu_1 m - 2 mu_2 m) g / m
  const double mu_1 = 0.1, mu_2 = 0.4, fast = 0.4, slow = 0.5;
  for (const int steps : kRates) {
    World world;
    const auto ground = world.create_body({.type = BodyType::Static});
    ShapeDef floor = rough(make_half_plane({0, 0}, {0, 1}), mu_2);
    floor.friction_rule = MixingRule::Minimum;
    world.add_shape(ground, floor);
    ShapeDef lower = rough(make_box({4, 0.5}), mu_2), upper = rough(make_box({1, 0.5}), mu_1);
    upper.friction_rule = lower.friction_rule = MixingRule::Minimum;
    const auto below = add(world, {0, 0.25}, lower, 1, {slow, 0});
    const auto above = add(world, {0, 0.75}, upper, 1, {slow + fast, 0});
    run_a_second(world, steps);
    // The lower one stops first and is held: mu_1 m g < mu_2 2 m g.
    EXPECT_NEAR(world.position(below).x, slow * slow / (2 * (2 * mu_2 - mu_1) * kG), kExact) << steps;
    const double v = slow + fast;
    EXPECT_NEAR(world.position(above).x, v * v / (2 * mu_1 * kG), kExact) << steps;
  }
}

TEST(SlidingStop, DoesNotCutTheStepsOfAStackThatIsTouched) {
  // Blows so light that boxes slip for a ten-thousandth of a second. The stop of one shifts the loads of all,
  // and so on.
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  std::vector<BodyId> boxes;
  boxes.reserve(5);
  for (int i = 0; i < 5; ++i) boxes.push_back(add(world, {0, i + 0.5}, rough(make_box({1, 1}), 0.5)));
  for (int step = 0; step < 12; ++step) {
    const BodyId struck = boxes[static_cast<std::size_t>(step % 2)];
    world.apply_impulse(struck, {0.001 * (1 + step % 7), 0}, world.position(struck));
    const StepReport& report = world.step(1.0 / 60);
    EXPECT_EQ(report.substeps, 1) << step;
    EXPECT_EQ(report.impacts, 0) << step;
    EXPECT_LT(report.worst_residual, 1e-10) << step;
  }
}

/// A motor that gets to its speed at once would drive the disc on, within the same step, to where it slides
/// no longer: but it does not, and sliding goes on.
TEST(SlidingStop, OfADiscIsNotThatWhichItsMotorWouldBring) {
  const double mu = 0.15, radius = 0.2, omega = -4.723, speed = 0.15, h = 1.0 / 60;
  World world;
  add_ground(world, rough(make_disc(1), mu));
  const auto disc = add(world, {0, radius}, rough(make_disc(radius), mu), 1, {speed, 0}, omega - 0.003);
  world.create_joint({.kind = JointKind::Motor, .b = disc, .motor_speed = omega, .motor_limit = 8});
  world.step(h);
  EXPECT_NEAR(world.velocity(disc).x, speed + mu * kG * h, 1e-12);
  EXPECT_NEAR(world.omega(disc), omega, 1e-12);
}

/// A box that a motor turns slides with one corner over the ground. Its motor, the load of the corner and the
/// friction that comes with it change each other: corrected one after the other they left the ground, and
/// struck it in the next step.
TEST(SlidingStop, DoesNotEndForABoxThatAMotorTurns) {
  const auto way = [](int parts, int& impacts) {
    World world;
    ShapeDef like = rough(make_box({0.3632, 0.2016}), 0.15);
    like.material.rolling_resistance = 0.01;
    add_ground(world, like);
    const auto box = add(world, {2.3942, 0.1867}, like, 0.7866, {-0.15, 0.41}, -4.723, -1.55);
    world.create_joint({.kind = JointKind::Motor, .b = box, .motor_speed = -4.723, .motor_limit = 8.6412});
    impacts = 0;
    for (int k = 0; k < 18 * parts; ++k) {
      const int now = world.step(1.0 / 60 / parts).impacts;
      if (k >= 4 * parts) impacts += now;
    }
    return world.position(box);
  };
  int impacts = 0, finer = 0;
  const Vec2 whole = way(1, impacts), sixteenths = way(16, finer);
  EXPECT_EQ(impacts, finer);
  EXPECT_LT(length(whole - sixteenths), 2e-5);
}

/// The same where a motor without a largest force turns an arm on a box that slides with a corner: friction
/// is that of the corrected load, in any unit.
TEST(SlidingStop, KeepsItsFrictionWhateverTheUnitOfLength) {
  // On a corner, and on both ends of an edge.
  const auto way = [](double angle, double unit) {
    WorldConfig config;
    config.gravity = {0, -unit * kG};
    config.contact_margin *= unit;
    config.touch_tolerance *= unit;
    config.rest_speed *= unit;
    World world(config);
    add_ground(world, rough(make_disc(1), 0.2));
    const Vec2 size{0.44 * unit, 0.39 * unit};
    const Vec2 foot = rotate(Rot::from_angle(angle), 0.5 * Vec2{-size.x, -size.y});
    const auto box = add(world, {0, -foot.y}, rough(make_box(size), 0.2), 17, {1.8 * unit, 0}, 0, angle);
    const auto arm = add(world, Vec2{-0.43 * unit, 0.6 * unit - foot.y},
                         rough(make_box({0.2 * unit, 0.9 * unit}), 0.2), 1.5);
    world.create_joint({.kind = JointKind::Revolute,
                        .a = box,
                        .b = arm,
                        .anchor_a = world.position(box) + Vec2{-0.3 * unit, 0.3 * unit},
                        .motor_speed = -4});
    std::vector<Vec2> places;
    for (int k = 0; k < 20; ++k) {
      world.step(1.0 / 60);
      for (const auto body : {box, arm}) places.push_back((1 / unit) * world.position(body));
    }
    return places;
  };
  for (const double angle : {0.5, 0.0}) {
    const std::vector<Vec2> metres = way(angle, 1);
    for (const double unit : {1.0 / 64, 1.0 / 8, 8.0, 64.0}) {
      const std::vector<Vec2> other = way(angle, unit);
      for (std::size_t i = 0; i < metres.size(); ++i)
        ASSERT_LT(length(other[i] - metres[i]), 1e-7) << angle << ", " << unit << ", step " << i / 2;
    }
  }
}

}  // namespace sliding_stop_test
}  // namespace skerry
