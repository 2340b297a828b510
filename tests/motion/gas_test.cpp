// SPDX-License-Identifier: MIT
//
// A gas of hard discs, e = 1: conservation, equation of state, distribution of speeds.
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace gas_test {

using test::add;
using test::smooth;
using test::weightless;

/// Henderson's equation of state of hard discs: p = n k T Z. [Henderson 1975]
double henderson(double eta) {
  return (1 + eta * eta / 8) / ((1 - eta) * (1 - eta));
}

struct Gas {
  double energy_error = 0;    ///< relative
  double momentum_error = 0;  ///< of what the walls gave, relative to the sum of all |m v|
  double pressure = 0;        ///< on the walls [N/m]
  double virial = 0;          ///< Z by the collisions in the middle of the box
  double eta = 0;             ///< area fraction in the middle of the box
  double temperature = 0;     ///< k T: kinetic energy a disc [J]
  double mean_over_root = 0;  ///< <v>^2 / <v^2>, averaged over time
  int impacts = 0;
};

/// `side`^2 discs of radius 0.05 m in a square box whose area fraction is about `eta`.
Gas run(const std::string& stepper, int side, double eta, double seconds, double settle) {
  const int count = side * side;
  const double r = 0.05, box = std::sqrt(count * kPi * r * r / eta), wall = 1;
  WorldConfig config = weightless();
  config.stepper = stepper;
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
  const Vec2 momentum = world.momentum();
  Vec2 given;
  double push = 0, area = 0, ratio = 0, handed_on = 0;
  int samples = 0;
  for (int i = 0; world.time() < settle + seconds; ++i) {
    const StepReport& report = world.step(h);
    gas.impacts += report.impacts;
    gas.energy_error = std::max(gas.energy_error, std::abs(report.kinetic_energy / energy - 1));
    EXPECT_EQ(report.fallbacks, 0) << i;
    for (const ContactEvent& event : report.events) {
      if (event.kind != ContactEventKind::Hit) continue;
      if (event.body_a != walls && event.body_b != walls) {
        const bool inside = std::max(std::abs(event.point.x), std::abs(event.point.y)) < 0.25 * box;
        if (world.time() >= settle && inside) handed_on += 2 * r * event.impulse;
        continue;
      }
      given += (event.body_a == walls ? event.impulse : -event.impulse) * event.normal;
      if (world.time() >= settle) push += event.impulse;
    }
    // Of about 1.25 kg m/s for each disc.
    gas.momentum_error =
        std::max(gas.momentum_error, length(report.momentum - momentum - given) / (1.25 * count));
    if (world.time() < settle) continue;
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
  // Clausius: p A = N k T + (1/2) sum of distance times impulse, a time unit.
  const double inside = gas.eta * (0.25 * box * box) / (kPi * r * r);
  gas.virial = 1 + handed_on / (2 * inside * gas.temperature * samples * h);
  gas.mean_over_root = ratio / samples;
  return gas;
}

class HardDiscGasBy : public testing::TestWithParam<std::string> {};

TEST_P(HardDiscGasBy, KeepsEnergyFollowsTheEquationOfStateAndMaxwell) {
  // Scale 25 is the gas of the references: 1024 discs for 60 s.
  const int side = std::min(32, 12 + test_scale(1) - 1);
  const double seconds = std::min(60, 20 * test_scale(1));
  const Gas gas = run(GetParam(), side, 0.295, seconds, 2);
  const double n = gas.eta / (kPi * 0.05 * 0.05);
  const double z = gas.pressure / (n * gas.temperature);
  std::printf(
      "%d discs, %g s, %d impacts: eta %.4f, Z %.4f, by the walls %.4f (Henderson %.4f), "
      "<v>^2/<v^2> %.4f (pi/4 = %.4f), "
      "energy to %.1e, momentum to %.1e\n",
      side * side, seconds, gas.impacts, gas.eta, gas.virial, z, henderson(gas.eta), gas.mean_over_root,
      kPi / 4, gas.energy_error, gas.momentum_error);
  EXPECT_LE(gas.energy_error, 1e-12);
  EXPECT_LE(gas.momentum_error, 1e-12);
  // The number of discs in the middle fluctuates by 3 % for seconds: the walls feel it, the virial hardly.
  const bool full = side == 32;
  EXPECT_NEAR(gas.virial / henderson(gas.eta), 1, full ? 0.01 : 0.02);
  EXPECT_NEAR(z / henderson(gas.eta), 1, full ? 0.03 : 0.06);
  EXPECT_NEAR(gas.mean_over_root, kPi / 4, full ? 0.005 : 0.02);
}

INSTANTIATE_TEST_SUITE_P(Steppers, HardDiscGasBy, testing::Values("time_stepping", "event_driven"),
                         [](const testing::TestParamInfo<std::string>& test) { return test.param; });

TEST(HardDiscGas, FreeClusterKeepsItsMomentaToRounding) {
  World world(weightless());
  std::mt19937_64 random(9);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 100; ++i) {
    const int row = i / 10;
    const Vec2 at{0.4 * (i % 10), 0.4 * row};
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

/// 400 elastic discs, most of them in one island, under forces that depend on the state.
class HardDiscGasUnder : public testing::Test {
 protected:
  static constexpr int kCount = 400;

  HardDiscGasUnder() : world_(weightless()) {
    std::mt19937_64 random(4);
    std::normal_distribution<double> normal;
    for (int i = 0; i < kCount; ++i) {
      const int row = i / 20;
      const Vec2 at{0.11 * (i % 20 - 9.5), 0.11 * (row - 9.5)};
      discs_.push_back(add(world_, at, smooth(make_disc(0.05), 1), 1, {normal(random), normal(random)}));
    }
  }

  World world_;
  std::vector<BodyId> discs_;
};

/// Impacts lose nothing, so that drag alone slows the whole of them: by the exponential, whatever they do.
TEST_F(HardDiscGasUnder, DragSlowsAsOneBodyDoes) {
  for (const BodyId disc : discs_) world_.set_drag(disc, {.linear = 0.5});
  const double energy = world_.kinetic_energy();
  int impacts = 0;
  for (int i = 1; i <= 120; ++i) {
    const StepReport& report = world_.step(1.0 / 120);
    impacts += report.impacts;
    EXPECT_EQ(report.islands_in_flow, 0);
    EXPECT_NEAR(report.kinetic_energy, energy * std::exp(-i / 120.0), 1e-5 * energy) << i;
  }
  std::printf("seed 4: %d impacts\n", impacts);
  EXPECT_GT(impacts, kCount);
}

/// In a harmonic trap the sum of the energies stays, but for the order of the method, and the centre of mass
/// swings as one body would.
TEST_F(HardDiscGasUnder, ATrapKeepsItsEnergyAndSwingsAsAWhole) {
  const double stiffness = 4;
  world_.set_force_field([=](const FieldSample& s) { return Wrench{-stiffness * s.position, 0}; });
  const auto energy = [&] {
    double sum = world_.kinetic_energy();
    for (const BodyId disc : discs_) sum += 0.5 * stiffness * length_squared(world_.position(disc));
    return sum;
  };
  const auto centre = [&] {
    Vec2 sum;
    for (const BodyId disc : discs_) sum += world_.position(disc);
    return sum / kCount;
  };
  const double start = energy();
  const Vec2 from = centre(), v = world_.momentum() / kCount;
  int impacts = 0;
  for (int i = 1; i <= 240; ++i) {
    impacts += world_.step(1.0 / 120).impacts;
    EXPECT_NEAR(energy(), start, 3e-4 * start) << i;
    const double phase = 2 * i / 120.0;
    EXPECT_LT(length(centre() - std::cos(phase) * from - std::sin(phase) / 2 * v), 1e-4) << i;
  }
  std::printf("seed 4: %d impacts, energy off by %.1e\n", impacts, std::abs(energy() / start - 1));
  EXPECT_GT(impacts, 4 * kCount);
}

}  // namespace gas_test
}  // namespace skerry
