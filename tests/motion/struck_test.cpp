// SPDX-License-Identifier: MIT
//
// What falls on terrain, or is struck, or is wedged: nothing passes through, and nothing gains energy.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <vector>

#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace struck_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;

constexpr double kStep = 1.0 / 60;

class StruckBy : public testing::TestWithParam<const char*> {
 protected:
  static World make_world(WorldConfig config = {}) {
    config.stepper = GetParam();
    return World(config);
  }
  static double energy_of(const World& world) { return world.kinetic_energy() + world.potential_energy(); }
};

void add_chain(World& world, std::vector<Vec2> corners, double friction, double restitution = 0) {
  const BodyId ground = world.create_body({.type = BodyType::Static});
  world.add_shape(ground, rough(make_chain(corners), friction, restitution));
}

// One end lands first; the other one may pass the line within the rest of a step, and the middle with it.
TEST_P(StruckBy, ThinPlanksDoNotFallThroughTerrain) {
  const unsigned seed = 5;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> angle(0, kPi), spin(-6, 6), speed(-3, 3), height(0.3, 1.5);
  int fallen = 0;
  const int planks = test_scale(60);
  for (int k = 0; k < planks; ++k) {
    World world = make_world();
    add_chain(world, {{-9, 0}, {0, 0}, {9, 0}}, 0.3);
    const double thickness = k % 3 == 0 ? 0.01 : k % 3 == 1 ? 0.02 : 0.05;
    const ShapeDef plank = k % 2 == 0 ? rough(make_box({0.5, thickness}), 0.3)
                                      : rough(make_capsule({-0.25, 0}, {0.25, 0}, 0.5 * thickness), 0.3);
    const Vec2 velocity{speed(random), 0};
    const double turn = angle(random), omega = spin(random);
    const BodyId body = add(world, {0.1, height(random)}, plank, 1, velocity, omega, turn);
    for (int i = 0; i < 60; ++i) world.step(kStep);
    fallen += world.position(body).y < 0;
  }
  EXPECT_EQ(fallen, 0) << "of " << planks << ", seed " << seed;
}

// A heavy disc throws a light one down aslant, over a corner of the terrain that it was not above.
TEST_P(StruckBy, WhatIsThrownOverACornerOfTerrainMeetsTheNextSegment) {
  for (double speed = 10; speed <= 100; speed += 15) {
    for (double corner = 0.1; corner < 1.5; corner += 0.2) {
      World world = make_world(test::weightless());
      add_chain(world, {{-5, 0}, {corner, 0}, {5, 0}}, 0, 0.5);
      const BodyId light = add(world, {0, 0.3}, smooth(make_disc(0.05), 0.5));
      const double before = 0.15 + 0.1 * speed * kStep;
      add(world, {-0.8 * before, 0.3 + 0.6 * before}, smooth(make_disc(0.1), 0.5), 50,
          {0.8 * speed, -0.6 * speed});
      world.step(kStep);
      world.step(kStep);
      EXPECT_GT(world.position(light).y, 0) << "speed " << speed << " corner " << corner;
    }
  }
}

// A light box under a heavy one is a wedge: friction that comes along with a correction can outgrow it.
TEST_P(StruckBy, AWedgedBoxGainsNoEnergy) {
  struct Scene {
    double x, vx, omega, light_angle, heavy_angle;
  };
  for (const Scene& scene : {Scene{-0.1, 0, -8, 0.5, 2.5}, Scene{-0.3, 2, -4, 0, 2}}) {
    World world = make_world();
    add_ground(world, rough(make_disc(1), 0.5));
    add(world, {0, 0.3}, rough(make_box({0.3, 0.15}), 0.5), 1, {}, 0, scene.light_angle);
    add(world, {scene.x, 1}, rough(make_box({0.4, 0.2}), 0.5), 50, {scene.vx, -3}, scene.omega,
        scene.heavy_angle);
    for (int i = 0; i < 24; ++i) {
      const double before = energy_of(world);
      world.step(kStep);
      ASSERT_LT(energy_of(world), 1.01 * before + 0.01) << scene.x << " at " << world.time();
    }
  }
  const int pairs = test_scale(200);
  for (const double h : {kStep, kStep / 16}) {
    for (int k = 0; k < (h < kStep ? pairs / 4 : pairs); ++k) {
      const int seed = 290 + k;
      std::mt19937_64 random(static_cast<unsigned>(seed));
      const auto uniform = [&random](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random);
      };
      World world = make_world();
      add_ground(world, rough(make_disc(1), 0.5));
      const auto box = [](double size) { return rough(make_box({size, 0.5 * size}), 0.5); };
      const auto drop = [&](double size, Vec2 at, double mass, Vec2 velocity, double omega) {
        return add(world, at, box(size), mass, velocity, omega, uniform(0, 3));
      };
      const double first = uniform(0.2, 0.4), second = uniform(0.3, 0.6), x = uniform(-0.6, 0.6);
      const double vx = uniform(-3, 3), vy = uniform(-5, 0), omega = uniform(-10, 10);
      drop(first, {0, uniform(0.3, 0.5)}, 1, {uniform(-3, 3), 0}, uniform(-3, 3));
      drop(second, {x, uniform(1, 1.3)}, 50, {vx, vy}, omega);
      for (double t = 0; t < 0.7; t += h) {
        const double before = energy_of(world);
        world.step(h);
        ASSERT_LT(energy_of(world), 1.01 * before + 0.01) << "pair " << seed << " at " << world.time();
      }
    }
  }
}

// The bar cannot move; a mirror image of what stops it would turn it about its hinge for ever.
TEST_P(StruckBy, AHingedBarBetweenPegsIsHitInAFewReflections) {
  for (const double restitution : {0.5, 0.9}) {
    World world = make_world();
    const BodyId bar = add(world, {1, 0}, rough(make_box({2, 0.2}), 0.3, restitution));
    world.create_joint({.kind = JointKind::Revolute, .b = bar, .anchor_a = {0, 0}});
    for (const double y : {0.2, -0.2}) {
      const BodyId peg = world.create_body({.type = BodyType::Static, .position = {1.5, y}});
      world.add_shape(peg, rough(make_disc(0.1), 0.3, restitution));
    }
    const BodyId ball = add(world, {1.9, 0.4}, rough(make_disc(0.1), 0.3, restitution), 1, {0, -2});
    int most = 0;
    double fastest = 0;
    for (int i = 0; i < 60; ++i) {
      most = std::max(most, world.step(kStep).reflections);
      EXPECT_EQ(world.report().inexact_islands, 0) << restitution << " step " << i;
      fastest = std::max(fastest, world.velocity(ball).y);
    }
    EXPECT_LT(most, 2000) << restitution;
    EXPECT_GT(fastest, 0.5) << restitution;
  }
}

INSTANTIATE_TEST_SUITE_P(Every, StruckBy, testing::Values("time_stepping", "event_driven", "auto"),
                         [](const auto& which) { return std::string(which.param); });

}  // namespace struck_test
}  // namespace skerry
