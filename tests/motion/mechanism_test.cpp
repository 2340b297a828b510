// SPDX-License-Identifier: MIT
//
// Mechanisms that nobody would build: bodies of uneven masses at random places, in each other, with joints of
// all kinds, limits, motors and springs whose anchors are apart. They gain no energy, are not torn apart, and
// cost a bounded amount of work.
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace mechanism_test {

using test::add;
using test::add_ground;
using test::rough;

constexpr double kStep = 1.0 / 60;

struct Mechanism {
  World world;
  std::vector<BodyId> bodies;
};

enum class Drives {
  None,
  Motors,  ///< with a limit, and springs
  Told,    ///< besides: motors without limit, a body that moves as told, and drag
};

Mechanism random_mechanism(unsigned seed, const char* stepper, Drives drives) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (random() / 4294967296.0);
  };
  const auto below = [&](unsigned count) { return static_cast<std::size_t>(random() % count); };
  WorldConfig config;
  config.stepper = stepper;
  Mechanism made{World(config), {}};
  World& world = made.world;
  add_ground(world, rough(make_disc(1), 0.5));
  const std::size_t count = 3 + below(10);
  const double spread = uniform(0.3, 2.5), heavy = below(4) == 0 ? 1000 : 1;
  for (std::size_t i = 0; i < count; ++i) {
    const double a = uniform(0.2, 0.8), b = uniform(0.2, 0.8);
    const Vec2 at{uniform(-spread, spread), 1.2 + uniform(0, spread)};
    const Shape shape = below(3) > 0 ? make_box({a, b}) : make_disc(a / 2);
    const double mass = below(5) == 0 ? heavy : uniform(0.5, 2);
    const Vec2 velocity{uniform(-2, 2), uniform(-2, 2)};
    made.bodies.push_back(
        add(world, at, rough(shape, uniform(0, 1)), mass, velocity, uniform(-3, 3), uniform(-3, 3)));
  }
  constexpr JointKind kKinds[] = {JointKind::Revolute, JointKind::Revolute, JointKind::Weld,
                                  JointKind::Distance, JointKind::Rope,     JointKind::Prismatic,
                                  JointKind::Wheel,    JointKind::Spring};
  const bool driven = drives != Drives::None;
  if (drives == Drives::Told) {
    const BodyId told = world.create_body({.type = BodyType::Kinematic,
                                           .position = {uniform(-spread, spread), 1.2 + uniform(0, spread)},
                                           .velocity = {uniform(-1, 1), uniform(-0.2, 0.2)},
                                           .omega = uniform(-3, 3)});
    world.add_shape(told, rough(make_box({uniform(0.2, 0.8), 0.3}), 0.5));
    world.set_drag(made.bodies[below(static_cast<unsigned>(count))], {.linear = uniform(0, 1)});
    made.bodies[below(static_cast<unsigned>(count))] = told;
  }
  const std::size_t joints = count - 1 + below(3);
  for (std::size_t i = 0; i < joints; ++i) {
    const bool chains = i + 1 < count;
    const std::size_t a = below(static_cast<unsigned>(chains ? i + 1 : count)),
                      b = chains ? i + 1 : below(static_cast<unsigned>(count));
    if (a == b) continue;
    JointDef joint;
    joint.kind = kKinds[below(driven ? 8 : 7)];
    joint.a = made.bodies[a];
    joint.b = made.bodies[b];
    const Vec2 pa = world.position(joint.a), pb = world.position(joint.b);
    const bool reaches =
        joint.kind == JointKind::Distance || joint.kind == JointKind::Rope || joint.kind == JointKind::Spring;
    joint.anchor_a = reaches ? pa : 0.5 * (pa + pb);
    joint.anchor_b = pb;
    joint.collide = below(2) == 1;
    joint.axis = {uniform(-1, 1), uniform(-1, 1)};
    if (joint.kind == JointKind::Spring) {
      joint.stiffness = uniform(1, 1000);
      joint.damping = uniform(0, 5);
    } else if (joint.kind != JointKind::Weld && joint.kind != JointKind::Rope && below(4) == 0) {
      joint.lower = joint.kind == JointKind::Distance ? 0.1 : -0.3;
      joint.upper = joint.kind == JointKind::Distance ? 1.5 : 0.4;
    } else if (driven && !reaches && joint.kind != JointKind::Weld && below(3) == 0) {
      joint.motor_speed = uniform(-3, 3);
      joint.motor_limit = drives == Drives::Told && below(2) == 0 ? kInfinity : uniform(0.1, 50);
    }
    world.create_joint(joint);
  }
  return made;
}

class Mechanisms : public testing::TestWithParam<const char*> {};

TEST_P(Mechanisms, GainNoEnergyAndCostABoundedAmountOfWork) {
  const auto trials = static_cast<unsigned>(test_scale(10));
  for (unsigned seed = 55; seed < 55 + trials; ++seed) {
    SCOPED_TRACE(seed);
    Mechanism made = random_mechanism(seed, GetParam(), Drives::None);
    World& world = made.world;
    const double energy = world.kinetic_energy() + world.potential_energy();
    double most = energy, visits = 0;
    for (int i = 0; i < 120; ++i) {
      visits = std::max(visits, world.step(kStep).work.visits);
      most = std::max(most, world.kinetic_energy() + world.potential_energy());
    }
    // Bodies that were in each other are lifted.
    EXPECT_LE(most, 1.7 * energy);
    // Of 40 by `time_stepping` one takes 3e7, the next one 1.3e7, the median 1e5.
    EXPECT_LE(visits, 4e7);
  }
}

TEST_P(Mechanisms, WithMotorsAndSpringsStayWhereTheyAre) {
  const auto trials = static_cast<unsigned>(test_scale(10));
  std::vector<unsigned> seeds(trials);
  std::iota(seeds.begin(), seeds.end(), 98u);
  // Near the ground, which did not push them, open joints gave these any angular momentum.
  const std::array open = {147u, 153u, 183u, 215u, 281u};
  seeds.insert(seeds.end(), open.begin(), open.begin() + std::min(5, test_scale(5)));
  for (const unsigned seed : seeds) {
    SCOPED_TRACE(seed);
    Mechanism made = random_mechanism(seed, GetParam(), Drives::Motors);
    double fastest = 0, farthest = 0;
    for (int i = 0; i < 120; ++i) {
      made.world.step(kStep);
      for (const BodyId body : made.bodies) {
        fastest = std::max(fastest, length(made.world.velocity(body)));
        farthest = std::max(farthest, length(made.world.position(body)));
      }
    }
    // Springs that are stretched by 2 m hold energy for some 90 m/s; seed 153 throws a bar off at 101 m/s
    // with no more than was in them.
    EXPECT_LT(fastest, 110);
    EXPECT_LT(farthest, 80);
  }
}

/// What is told to move, and motors without limit, may want anything where joints contradict each other. Here
/// nothing is told to be faster than some 20 m/s at the far end of what turns.
TEST_P(Mechanisms, ThatAreToldToMoveDoNotExplodeAndCostABoundedAmountOfWork) {
  // Now and then heavy bodies take light ones along: of seeds 13 to 100 by `time_stepping` 5 are faster.
  const auto trials = static_cast<unsigned>(test_scale(3));
  unsigned fast = 0;
  for (unsigned seed = 13; seed < 13 + trials; ++seed) {
    SCOPED_TRACE(seed);
    Mechanism made = random_mechanism(seed, GetParam(), Drives::Told);
    double fastest = 0, visits = 0;
    for (int i = 0; i < 120; ++i) {
      visits = std::max(visits, made.world.step(kStep).work.visits);
      for (const BodyId body : made.bodies) fastest = std::max(fastest, length(made.world.velocity(body)));
    }
    fast += fastest >= 150;
    EXPECT_LT(fastest, 1000);
    // Rods that are pulled hard cut a step, up to 3e7 visits of it: seed 32 has one such step.
    EXPECT_LT(visits, 4e7);
  }
  EXPECT_LE(fast, trials / 10);
}

INSTANTIATE_TEST_SUITE_P(All, Mechanisms, testing::Values("time_stepping", "event_driven", "auto"));

}  // namespace mechanism_test
}  // namespace skerry
