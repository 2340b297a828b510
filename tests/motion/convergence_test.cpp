// SPDX-License-Identifier: MIT
//
// The order of time_stepping on scenes whose contacts start to slip, stick and part within steps: errors
// against event_driven or a formula, averaged over a few step lengths so that it does not matter where in its
// step an event falls.
#include <cmath>
#include <functional>
#include <gtest/gtest.h>

#include "tests/support/worlds.h"

namespace skerry {
namespace convergence_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;

constexpr double kG = 9.81;

/// A scene: runs for a while in `steps` steps and returns where its body is.
using Scene = std::function<Vec2(int steps, const char* stepper)>;

Vec2 run(World& world, BodyId body, double seconds, int steps) {
  for (int i = 0; i < steps; ++i) world.step(seconds / steps);
  return world.position(body);
}

World by(const char* stepper) {
  WorldConfig config;
  config.stepper = stepper;
  return World(config);
}

Vec2 bowling(int steps, const char* stepper) {
  World world = by(stepper);
  add_ground(world, rough(make_disc(1), 0.2));
  const auto disc = add(world, {0, 0.5}, rough(make_disc(0.5), 0.2), 1, {3, 0});
  return run(world, disc, 1, steps);
}

Vec2 stopping_block(int steps, const char* stepper) {
  World world = by(stepper);
  add_ground(world, rough(make_disc(1), 0.3));
  const auto block = add(world, {0, 0.25}, rough(make_box({2, 0.5}), 0.3), 1, {2, 0});
  return run(world, block, 1, steps);
}

/// Rolls, slips from 0.47 rad on, leaves at 0.91 rad.
Vec2 cylinder(int steps, const char* stepper) {
  World world = by(stepper);
  const auto fixed = world.create_body({.type = BodyType::Static});
  world.add_shape(fixed, rough(make_disc(1), 0.2));
  const double reach = 1.25;
  const auto disc = add(world, {reach * std::sin(0.1), reach * std::cos(0.1)}, rough(make_disc(0.25), 0.2));
  return run(world, disc, 1.5, steps);
}

/// Slides with backspin until it rolls.
Vec2 spun_on_cylinder(int steps, const char* stepper) {
  World world = by(stepper);
  const auto fixed = world.create_body({.type = BodyType::Static});
  world.add_shape(fixed, rough(make_disc(1), 0.2));
  const double reach = 1.25;
  const auto disc =
      add(world, {reach * std::sin(0.1), reach * std::cos(0.1)}, rough(make_disc(0.25), 0.2), 1, {}, -6);
  return run(world, disc, 0.6, steps);
}

Vec2 ladder(int steps, const char* stepper) {
  World world = by(stepper);
  const double t0 = 1, half = 1, r = 1e-4;
  const auto fixed = world.create_body({.type = BodyType::Static});
  world.add_shape(fixed, smooth(make_half_plane({0, 0}, {0, 1})));
  world.add_shape(fixed, smooth(make_half_plane({0, 0}, {1, 0})));
  const auto body = world.create_body({.position = {half * std::cos(t0) + r, half * std::sin(t0) + r},
                                       .angle = kPi - t0,
                                       .mass = 1.0,
                                       .inertia = 1.0 / 3});
  world.add_shape(body, smooth(make_capsule({-half, 0}, {half, 0}, r)));
  return run(world, body, 0.6, steps);
}

/// Errors of time_stepping in 60 and in 960 steps; prints them with the order.
struct Errors {
  double coarse, fine, order;
};
Errors measure(const char* name, const Scene& scene) {
  const Vec2 exact = scene(60, "event_driven");
  const auto error = [&](int steps) {
    double sum = 0;
    for (int phase = 0; phase < 4; ++phase)
      sum += length(scene(steps + steps * phase / 13, "time_stepping") - exact);
    return sum / 4;
  };
  const double coarse = error(60), fine = error(960), order = std::log2(coarse / fine) / 4;
  std::printf("%-26s error %.2e in 60 steps, %.2e in 960: order %.2f\n", name, coarse, fine, order);
  return {coarse, fine, order};
}

TEST(Convergence, TimeSteppingIsOfSecondOrderAcrossSlipStickAndRelease) {
  for (const auto& [name, scene] : {std::pair<const char*, Scene>("roll-off from a cylinder", cylinder),
                                    {"spun on a cylinder", spun_on_cylinder},
                                    {"ladder", ladder}}) {
    EXPECT_GT(measure(name, scene).order, 1.7) << name;
  }
}

TEST(Convergence, TimeSteppingIsExactWhereForcesAreConstantBetweenStops) {
  for (const auto& [name, scene] :
       {std::pair<const char*, Scene>("bowling", bowling), {"stopping block", stopping_block}}) {
    const Errors error = measure(name, scene);
    EXPECT_LT(error.coarse, 1e-11) << name;
    EXPECT_LT(error.fine, 1e-11) << name;
  }
}

}  // namespace convergence_test
}  // namespace skerry
