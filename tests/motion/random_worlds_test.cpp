// SPDX-License-Identifier: MIT
//
// Random small worlds: terrain, walls, shapes of all kinds, masses from a hundredth to a hundred, springs. No
// step gives them energy, whatever lands, slides, jams or turns over in it.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <numeric>
#include <string>
#include <vector>

#include "tests/support/draw.h"
#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace random_worlds_test {

constexpr double kStep = 1.0 / 60;

class RandomWorld : private test::Draw {
 public:
  enum class Kind : std::uint8_t { Crowd, Springs, Few };

  RandomWorld(const char* stepper, unsigned seed, Kind kind) : Draw(seed), world_(by(stepper)) {
    friction_ = one_in(5) ? 0 : uniform(0.1, one_in(3) ? 2 : 0.8);
    restitution_ = one_in(3) ? uniform(0, 1) : 0;
    const bool few = kind == Kind::Few;
    rolling_ = few && one_in(3) ? 0.01 : 0;
    add_ground();
    const int count = few ? 3 : 5 + pick(12);
    const bool heavy = one_in(2), fast = one_in(3);
    for (int i = 0; i < count; ++i) {
      const int row = i / 13;
      const Vec2 at{-6.0 + (i % 13) + uniform(-0.15, 0.15), 1.8 + row + uniform(-0.15, 0.15)};
      const double speed = fast ? 15 : 2, mass = heavy ? std::pow(10, uniform(-2, 2)) : uniform(0.5, 2);
      bodies_.push_back(test::add(world_, at, surface(shape()), mass,
                                  {uniform(-speed, speed), uniform(-speed, speed)}, uniform(-speed, speed),
                                  one_in(2) ? 0 : uniform(0, 3)));
    }
    if (few && one_in(2)) {
      world_.create_joint({.kind = JointKind::Rope,
                           .a = bodies_[0],
                           .b = bodies_[1],
                           .anchor_a = world_.position(bodies_[0]),
                           .anchor_b = world_.position(bodies_[1])});
    }
    if (kind != Kind::Springs) return;
    for (std::size_t i = 1; i < bodies_.size(); i += 2) {
      world_.create_joint({.kind = JointKind::Spring,
                           .a = bodies_[i - 1],
                           .b = bodies_[i],
                           .anchor_a = world_.position(bodies_[i - 1]),
                           .anchor_b = world_.position(bodies_[i]),
                           .stiffness = std::pow(10, uniform(1, 5)),
                           .damping = uniform(0, 10)});
    }
  }

  /// What `steps` steps added to the energy that moves, at most in one, as a share of it.
  double largest_gain(int steps) {
    double largest = 0;
    for (int k = 0; k < steps; ++k) {
      const double before = energy(), moved = moving();
      world_.step(kStep);
      largest = std::max(largest, (energy() - before) / (1 + std::max(moved, moving())));
    }
    return largest;
  }

  /// Where all bodies are after some steps of that length.
  std::vector<Vec2> places(int steps, double length) {
    for (int k = 0; k < steps; ++k) world_.step(length);
    std::vector<Vec2> out;
    for (const BodyId body : bodies_) out.push_back(world_.position(body));
    return out;
  }

 private:
  static WorldConfig by(const char* stepper) {
    WorldConfig config;
    config.stepper = stepper;
    return config;
  }

  void add_ground() {
    const BodyId ground = world_.create_body({.type = BodyType::Static});
    std::vector<Vec2> line{{-9, 30}};
    const double rough = one_in(2) ? 1 : 0;
    for (int i = 0; i <= 18; ++i) line.push_back({-8.9 + 17.8 * i / 18, rough * uniform(0, 1)});
    line.push_back({9, 30});
    world_.add_shape(ground, surface(make_chain(line)));
  }

  ShapeDef surface(Shape shape) const {
    ShapeDef def = test::rough(std::move(shape), friction_, restitution_);
    def.material.rolling_resistance = rolling_;
    return def;
  }

  Shape shape() {
    const double size = uniform(0.25, 0.7);
    switch (pick(4)) {
      case 0: {
        std::vector<Vec2> corners(static_cast<std::size_t>(3 + pick(6)));
        const double first = uniform(0, 6), turn = 2 * kPi / static_cast<double>(corners.size());
        for (std::size_t i = 0; i < corners.size(); ++i) {
          const double angle = first + turn * static_cast<double>(i);
          corners[i] = 0.5 * size * Vec2{std::cos(angle), std::sin(angle)};
        }
        return make_polygon(corners);
      }
      case 1:
        return make_capsule({-0.3 * size, 0}, {0.3 * size, 0}, 0.2 * size);
      case 2:
        return make_disc(0.5 * size);
      default:
        return make_box({size, uniform(0.25, 0.7)});
    }
  }

  double energy() const { return world_.kinetic_energy() + world_.potential_energy(); }
  double moving() const { return world_.kinetic_energy() + world_.spring_energy(); }

  World world_;
  std::vector<BodyId> bodies_;
  double friction_ = 0, restitution_ = 0, rolling_ = 0;
};

class RandomWorlds : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(By, RandomWorlds, testing::Values("time_stepping", "event_driven"),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(RandomWorlds, GainNoEnergyInAnyStep) {
  // The last ones gained when all 120 of others did not.
  std::vector<unsigned> seeds(static_cast<std::size_t>(test_scale(120)));
  std::iota(seeds.begin(), seeds.end(), 0u);
  seeds.insert(seeds.end(), {421u, 787u, 856u, 1350u});
  double worst = 0;
  for (const unsigned seed : seeds) {
    const double gain = RandomWorld(GetParam(), seed, RandomWorld::Kind::Crowd).largest_gain(240);
    EXPECT_LT(gain, 3e-3) << "seed " << seed;
    worst = std::max(worst, gain);
  }
  std::printf("largest gain of a step: %.2g of what moved\n", worst);
}

TEST_P(RandomWorlds, WithStiffSpringsGainLittleInAnyStep) {
  // What swings to and fro 80 times a second wants many steps of events.
  const int worlds = test_scale(GetParam() == std::string("event_driven") ? 20 : 120);
  std::vector<unsigned> seeds(static_cast<std::size_t>(worlds));
  std::iota(seeds.begin(), seeds.end(), 0u);
  // Here springs that turned fast were stretched.
  if (GetParam() == std::string("time_stepping")) seeds.insert(seeds.end(), {1349u, 1693u});
  double worst = 0;
  int gained = 0;
  for (const unsigned seed : seeds) {
    const double gain = RandomWorld(GetParam(), seed, RandomWorld::Kind::Springs).largest_gain(240);
    if (gain >= 0.02) std::printf("seed %u gains %.2g\n", seed, gain);
    gained += gain >= 0.02;
    worst = std::max(worst, gain);
  }
  std::printf("largest gain of a step: %.2g of what moved\n", worst);
  // One world of 700 or so gains: bodies that are jammed, or stiff springs that are struck along their line.
  EXPECT_LE(gained, 1);
}

/// What events locate does not depend on where steps begin. It did where round bodies rolled over a ridge,
/// came to the other side of a valley from beyond its end, or were held more than once (by two points and
/// resistance to rolling, by friction and a rope): the step was made without events then.
TEST(RandomWorldsByEvents, DoNotDependOnTheLengthOfSteps) {
  const auto apart = [](unsigned seed) {
    const auto places = [&](int cuts) {
      return RandomWorld("event_driven", seed, RandomWorld::Kind::Few).places(30 * cuts, kStep / cuts);
    };
    const std::vector<Vec2> whole = places(1), quarters = places(4);
    double worst = 0;
    for (std::size_t i = 0; i < whole.size(); ++i) worst = std::max(worst, length(whole[i] - quarters[i]));
    return worst;
  };
  const int worlds = test_scale(150);
  int same = 0;
  for (int seed = 0; seed < worlds; ++seed) {
    const double d = apart(static_cast<unsigned>(seed));
    same += d < 1e-5;
    if (d >= 1e-5) std::printf("seed %d: %.1e m apart\n", seed, d);
  }
  // Impacts of much friction may have several answers, and bounces that die away are cut short.
  EXPECT_GE(same, 0.96 * worlds);
  // Those that did depend on it.
  for (const unsigned seed : {14u, 43u, 53u, 65u, 66u, 86u, 89u, 123u, 127u, 130u, 148u})
    EXPECT_LT(apart(seed), 1e-9) << seed;
}

}  // namespace random_worlds_test
}  // namespace skerry
