// SPDX-License-Identifier: MIT
//
// The end of sliding falls inside a step of time_stepping: the step is cut there, so where a body stops does
// not depend on the step. All by formula.
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "tests/support/worlds.h"

namespace skerry {
namespace {

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

}  // namespace
}  // namespace skerry
