// SPDX-License-Identifier: MIT
//
// A gas of hard discs, e = 1: conservation, equation of state, distribution of speeds.
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace {

using test::add;
using test::smooth;
using test::weightless;

/// Henderson's equation of state of hard discs: p = n k T Z. [Henderson 1975]
double henderson(double eta) {
  return (1 + eta * eta / 8) / ((1 - eta) * (1 - eta));
}

struct Gas {
  double energy_error = 0;    ///< relative
  double pressure = 0;        ///< on the walls [N/m]
  double eta = 0;             ///< area fraction in the middle of the box
  double temperature = 0;     ///< k T: kinetic energy a disc [J]
  double mean_over_root = 0;  ///< <v>^2 / <v^2>, averaged over time
  int impacts = 0;
};

/// `side`^2 discs of radius 0.05 m in a square box whose area fraction is about `eta`.
Gas run(int side, double eta, double seconds, double settle) {
  const int count = side * side;
  const double r = 0.05, box = std::sqrt(count * kPi * r * r / eta), wall = 1;
  WorldConfig config = weightless();
  config.max_impacts_per_step = 1000;
  World world(config);
  const auto walls = world.create_body({.type = BodyType::Static});
  for (const Vec2 n : {Vec2{1, 0}, Vec2{-1, 0}, Vec2{0, 1}, Vec2{0, -1}})
    world.add_shape(walls, smooth(make_half_plane({-0.5 * box * n.x, -0.5 * box * n.y}, n), wall));
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  const double pitch = (box - 2 * r) / side;
  for (int i = 0; i < count; ++i) {
    const Vec2 at{(i % side + 0.5) * pitch + r - 0.5 * box, (i / side + 0.5) * pitch + r - 0.5 * box};
    add(world, at, smooth(make_disc(r), 1), 1, {normal(random), normal(random)});
  }
  Gas gas;
  const double energy = world.kinetic_energy();
  const double h = 1.0 / 120;
  double push = 0, area = 0, ratio = 0;
  int samples = 0;
  for (int i = 0; world.time() < settle + seconds; ++i) {
    const StepReport& report = world.step(h);
    gas.impacts += report.impacts;
    gas.energy_error = std::max(gas.energy_error, std::abs(report.kinetic_energy / energy - 1));
    if (world.time() < settle) continue;
    for (const ContactEvent& event : report.events) {
      if (event.kind == ContactEventKind::Hit && (event.body_a == walls || event.body_b == walls))
        push += event.impulse;
    }
    // Area fraction of the middle half of the box: centres there, each with its whole disc.
    const BodyArrays& bodies = world.bodies();
    double speed = 0, square = 0;
    int inside = 0;
    for (std::size_t k = 1; k < bodies.size(); ++k) {
      inside += std::max(std::abs(bodies.position[k].x), std::abs(bodies.position[k].y)) < 0.25 * box;
      speed += length(bodies.velocity[k]);
      square += length_squared(bodies.velocity[k]);
    }
    area += inside * kPi * r * r / (0.25 * box * box);
    ratio += speed * speed / (count * square);
    ++samples;
  }
  // Centres come no nearer to the corners than r: that much of each wall is never pushed.
  gas.pressure = push / (4 * (box - 2 * r) * samples * h);
  gas.eta = area / samples;
  gas.temperature = energy / count;
  gas.mean_over_root = ratio / samples;
  return gas;
}

TEST(HardDiscGas, KeepsEnergyFollowsTheEquationOfStateAndMaxwell) {
  // Scale 25 is the gas of the references: 1024 discs for 60 s.
  const int side = std::min(32, 12 + test_scale(1) - 1);
  const double seconds = std::min(60, 10 * test_scale(1));
  const Gas gas = run(side, 0.28, seconds, 2);
  const double n = gas.eta / (kPi * 0.05 * 0.05);
  const double z = gas.pressure / (n * gas.temperature);
  std::printf(
      "%d discs, %g s, %d impacts: eta %.4f, Z %.4f (Henderson %.4f), <v>^2/<v^2> %.4f (pi/4 = %.4f), "
      "energy to %.1e\n",
      side * side, seconds, gas.impacts, gas.eta, z, henderson(gas.eta), gas.mean_over_root, kPi / 4,
      gas.energy_error);
  EXPECT_LE(gas.energy_error, 1e-12);
  // Fluctuations of a smaller gas in a shorter time.
  const double noise = side == 32 ? 0.01 : 0.04;
  EXPECT_NEAR(z / henderson(gas.eta), 1, noise);
  EXPECT_NEAR(gas.mean_over_root, kPi / 4, side == 32 ? 0.005 : 0.02);
}

TEST(HardDiscGas, FreeClusterKeepsItsMomentaToRounding) {
  World world(weightless());
  std::mt19937_64 random(9);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 100; ++i) {
    const Vec2 at{0.4 * (i % 10), 0.4 * (i / 10)};
    add(world, at, smooth(make_disc(0.1), 1), 1 + 0.1 * (i % 7), {normal(random), normal(random)});
  }
  const Vec2 momentum = world.momentum();
  const double angular = world.angular_momentum(), energy = world.kinetic_energy();
  int impacts = 0;
  for (int i = 0; i < 240; ++i) impacts += world.step(1.0 / 240).impacts;
  EXPECT_GT(impacts, 50);
  double scale = 0;
  for (std::size_t i = 0; i < world.bodies().size(); ++i)
    scale += world.bodies().mass[i] * length(world.bodies().velocity[i]);
  EXPECT_NEAR(length(world.momentum() - momentum), 0, 1e-14 * scale);
  EXPECT_NEAR(world.angular_momentum(), angular, 1e-14 * scale * 10);
  EXPECT_NEAR(world.kinetic_energy() / energy, 1, 1e-12);
}

}  // namespace
}  // namespace skerry
