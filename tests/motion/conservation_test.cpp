// SPDX-License-Identifier: MIT
//
// What time_stepping keeps at 1/60 s: momenta of free islands, energy of heaps, masonry at rest.
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <vector>

#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace conservation_test {

using test::add;
using test::add_ground;
using test::rough;
using test::weightless;

constexpr double kStep = 1.0 / 60;

TEST(Conservation, FreeBodiesThatGlideOnEachOtherKeepTheirMomenta) {
  for (const double mu : {0.0, 0.3}) {
    World world(weightless());
    add(world, {0, 0}, rough(make_box({4, 1}), mu), 2, {0.3, 0.1}, 0.4);
    add(world, {-1, 1}, rough(make_box({1, 1}), mu), 1, {1.5, -0.6}, 0.1);
    const double angular = world.angular_momentum();
    const Vec2 momentum = world.momentum();
    double energy = world.kinetic_energy(), loaded = 0;
    for (int i = 0; i < 180; ++i) {
      const StepReport& report = world.step(kStep);
      EXPECT_NEAR(world.angular_momentum(), angular, 1e-13) << "mu " << mu << " step " << i;
      EXPECT_LE(report.kinetic_energy, energy * (1 + 1e-6)) << "mu " << mu << " step " << i;
      energy = report.kinetic_energy;
      loaded += report.total_normal_impulse;
    }
    EXPECT_NEAR(length(world.momentum() - momentum), 0, 1e-13);
    EXPECT_GT(loaded, 0);
  }
}

TEST(Conservation, DroppedHeapsNeverGainEnergy) {
  for (const bool boxes : {false, true}) {
    const unsigned seed = 3;
    World world;
    add_ground(world, rough(make_disc(1), 0.5));
    const auto walls = world.create_body({.type = BodyType::Static});
    world.add_shape(walls, rough(make_half_plane({-3, 0}, {1, 0}), 0.5));
    world.add_shape(walls, rough(make_half_plane({3, 0}, {-1, 0}), 0.5));
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-0.1, 0.1);
    const int count = test_scale(30);
    for (int i = 0; i < count; ++i) {
      const Vec2 at{-2.2 + 1.1 * (i % 5) + unit(random), 1 + 1.1 * (i / 5)};
      if (boxes) {
        add(world, at, rough(make_box({0.8, 0.8}), 0.5), 1, {}, 0, unit(random));
      } else {
        add(world, at, rough(make_disc(0.4), 0.5));
      }
    }
    const double start = world.kinetic_energy() + world.potential_energy();
    double energy = start;
    for (int i = 0; i < 120; ++i) {
      const StepReport& report = world.step(kStep);
      const double now = report.kinetic_energy + report.potential_energy;
      EXPECT_LE(now, energy + 1e-6 * start) << "seed " << seed << " boxes " << boxes << " step " << i;
      energy = now;
    }
    EXPECT_LT(energy, 0.8 * start);
  }
}

// A near contact that carried load once must not be closed again by the projection.
/// Friction that held a corner at the end of a piece and not on its way did work in the first piece after
/// each impact.
TEST(Conservation, PolygonsThatRollOverTheirCornersGainNothing) {
  for (const int count : {3, 4, 6, 8}) {
    for (const double omega : {5.0, 15.0, 25.0, 40.0}) {
      SCOPED_TRACE(std::to_string(count) + " corners, " + std::to_string(omega) + " rad/s");
      World world;
      add_ground(world, rough(make_box({1, 1}), 2));
      std::vector<Vec2> corners;
      for (int i = 0; i < count; ++i) {
        const double angle = 2 * kPi * (i + 0.5) / count - kPi / 2;
        corners.push_back(0.5 * Vec2{std::cos(angle), std::sin(angle)});
      }
      test::add(world, {0, 0.5 * std::cos(kPi / count) + 0.05}, rough(make_polygon(corners), 2), 10,
                {0.45 * omega, 0}, -omega, 0.1);
      double last = world.kinetic_energy() + world.potential_energy();
      const double all = last;
      int impacts = 0;
      for (int k = 0; k < 120; ++k) {
        impacts += world.step(1.0 / 60).impacts;
        const double now = world.kinetic_energy() + world.potential_energy();
        ASSERT_LE(now, last + 1e-13 * all) << "step " << k;
        last = now;
      }
      EXPECT_GE(impacts, 1);
      EXPECT_LT(last, all);
    }
  }
}

TEST(Conservation, BoxThatIsThrownUpFromRestFlies) {
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  const auto box = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5));
  for (int i = 0; i < 3; ++i) world.step(1.0 / 60);
  world.set_velocity(box, {0, 0.2}, 0);
  world.step(1.0 / 60);
  EXPECT_NEAR(world.position(box).y, 0.5 + 0.2 / 60 - 0.5 * 9.81 / 3600, 1e-15);
}

// A box that rolls over its corner, a disc that rolls and slides on another: the projections give back what
// they take, so nothing but friction changes the energy.
TEST(Conservation, RollingOnACurveKeepsItsEnergyInTimeStepping) {
  World world;
  const auto hill = world.create_body({.type = BodyType::Static});
  world.add_shape(hill, rough(make_disc(1), 10));
  const auto disc = add(world, {1.25 * std::sin(0.2), 1.25 * std::cos(0.2)}, rough(make_disc(0.25), 10));
  const double before = world.kinetic_energy() + world.potential_energy();
  double worst = 0;
  for (int i = 0; i < 60; ++i) {
    const StepReport& report = world.step(1.0 / 60);
    worst = std::max(worst, std::abs(report.kinetic_energy + report.potential_energy - before));
  }
  EXPECT_LT(worst, 1e-5);
  EXPECT_GT(length(world.velocity(disc)), 1);
}

TEST(Masonry, PyramidDoesNotSink) {
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  const int base = std::min(100, 10 * test_scale(1));
  std::vector<std::pair<BodyId, double>> boxes;
  for (int row = 0; row < base; ++row) {
    for (int i = 0; i < base - row; ++i)
      boxes.emplace_back(add(world, {1.1 * (i + 0.5 * row), row + 0.5}, rough(make_box({1, 1}), 0.5)),
                         row + 0.5);
  }
  for (int i = 0; i < 300; ++i) world.step(kStep);
  double sunk = 0;
  for (const auto& [body, y] : boxes) sunk = std::max(sunk, std::abs(world.position(body).y - y));
  EXPECT_LE(sunk, 1e-4);
  EXPECT_LE(world.report().worst_penetration, 1e-9);
}

// A semicircular arch of 15 wedges with straight edges stands from t / R = 0.106068 on (R to the middle of
// the thickness t), if nothing slides.
TEST(Masonry, ArchOf15WedgesFallsBelowItsLeastThicknessAndStandsAbove) {
  const int count = 15;
  for (const double thickness : {0.105, 0.107}) {
    World world;
    add_ground(world, rough(make_disc(1), 2));
    std::vector<BodyId> wedges;
    std::vector<Vec2> start;
    const auto at = [](double radius, int joint) {
      const double angle = kPi * joint / count;
      return Vec2{radius * std::cos(angle), joint % count == 0 ? 0 : radius * std::sin(angle)};
    };
    for (int k = 0; k < count; ++k) {
      const std::vector<Vec2> corners{at(1 - thickness / 2, k), at(1 + thickness / 2, k),
                                      at(1 + thickness / 2, k + 1), at(1 - thickness / 2, k + 1)};
      const auto body = world.create_body({});
      world.add_shape(body, rough(make_polygon(corners), 2));
      wedges.push_back(body);
      start.push_back(world.position(body));
    }
    for (int i = 0; i < 180; ++i) world.step(kStep);
    double moved = 0;
    for (int k = 0; k < count; ++k) moved = std::max(moved, length(world.position(wedges[k]) - start[k]));
    if (thickness < 0.106068) {
      EXPECT_GT(moved, 1e-2) << thickness;
    } else {
      EXPECT_LE(moved, 1e-6) << thickness;
    }
  }
}

TEST(Masonry, StackOfAHundredStandsForTenSeconds) {
  WorldConfig config;
  config.reuse_resting = false;
  World world(config);
  add_ground(world, rough(make_disc(1), 0.5));
  std::vector<BodyId> boxes;
  for (int i = 0; i < 100; ++i) boxes.push_back(add(world, {0, i + 0.5}, rough(make_box({1, 1}), 0.5)));
  for (int i = 0; i < 600; ++i) world.step(kStep);
  for (int i = 0; i < 100; ++i) EXPECT_LE(length(world.position(boxes[i]) - Vec2{0, i + 0.5}), 1e-6);
  EXPECT_LE(world.report().worst_penetration, 1e-9);
}

}  // namespace conservation_test
}  // namespace skerry
