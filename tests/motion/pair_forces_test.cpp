// SPDX-License-Identifier: MIT
//
// Forces between bodies that do not touch: orbits, charges, what they keep, and their potential.
#include "physics/pair_forces.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/draw.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace pair_forces_test {

constexpr double kPi = std::numbers::pi;

class PairForcesBy : public testing::TestWithParam<const char*> {
 protected:
  static World make_world() {
    WorldConfig config = test::weightless();
    config.stepper = GetParam();
    return World(config);
  }
};

void advance(World& world, const PairForces& forces, double h, int steps) {
  for (int i = 0; i < steps; ++i) {
    forces.apply(world, h);
    world.step(h);
  }
}

/// Two bodies of 3 and 1 kg at apocentre, a semi-major axis of 1 m, a period of 2 pi s, eccentricity `e`.
std::vector<BodyId> add_binary(World& world, double e) {
  const double apart = 1 + e, speed = std::sqrt((1 - e) / (1 + e));
  const ShapeDef small = test::smooth(make_disc(0.01));
  return {test::add(world, {-0.25 * apart, 0}, small, 3, {0, -0.25 * speed}),
          test::add(world, {0.75 * apart, 0}, small, 1, {0, 0.75 * speed})};
}

const PairLaw kKepler{.strength = 0.25};

TEST_P(PairForcesBy, OrbitsComeBackWithAnErrorOfSecondOrder) {
  std::vector<double> errors;
  for (const int steps : {200, 400, 800}) {
    World world = make_world();
    const BodyId light = add_binary(world, 0.5)[1];
    const Vec2 start = world.position(light);
    advance(world, PairForces(kKepler), 2 * kPi / steps, steps);
    errors.push_back(length(world.position(light) - start));
  }
  EXPECT_LT(errors[0], 0.02);
  EXPECT_NEAR(errors[0] / errors[1], 4, 0.3);
  EXPECT_NEAR(errors[1] / errors[2], 4, 0.3);
}

TEST_P(PairForcesBy, AHundredOrbitsKeepWhatTheyHave) {
  World world = make_world();
  add_binary(world, 0.5);
  const PairForces forces(kKepler);
  const auto energy = [&] { return world.kinetic_energy() + forces.potential_energy(world); };
  const double first = energy(), spin = world.angular_momentum();
  EXPECT_NEAR(first, -0.5 * kKepler.strength * 3, 1e-15);  // - strength m M / 2a
  double worst = 0;
  for (int orbit = 0; orbit < 100; ++orbit) {
    advance(world, forces, 2 * kPi / 400, 400);
    worst = std::max(worst, std::abs(energy() - first));
  }
  // Forces of the beginning of each step would give a quarter of it in the first orbit.
  EXPECT_LT(worst, 1e-3 * std::abs(first));
  EXPECT_LT(length(world.momentum()), 1e-13);
  EXPECT_NEAR(world.angular_momentum(), spin, 1e-12);
}

/// [Chenciner & Montgomery 2000]: three equal masses chase each other along a figure of eight.
TEST_P(PairForcesBy, ThreeBodiesGoAlongTheFigureOfEight) {
  World world = make_world();
  const ShapeDef small = test::smooth(make_disc(0.01));
  const Vec2 place{0.97000436, -0.24308753}, speed{0.93240737, 0.86473146};
  const std::vector<BodyId> bodies{test::add(world, place, small, 1, 0.5 * speed),
                                   test::add(world, -place, small, 1, 0.5 * speed),
                                   test::add(world, {}, small, 1, -speed)};
  constexpr double kPeriod = 6.32591398;
  advance(world, PairForces({.strength = 1}), kPeriod / 3000, 3000);
  EXPECT_LT(length(world.position(bodies[0]) - place), 2e-4);
  EXPECT_LT(length(world.position(bodies[1]) + place), 2e-4);
  EXPECT_LT(length(world.position(bodies[2])), 2e-4);
}

/// A charge that flies by a fixed one of the same sign is turned by theta, tan(theta / 2) = k / (m v^2 b)
/// [Rutherford 1911].
TEST_P(PairForcesBy, ChargesScatterAsRutherfordFound) {
  for (const double offset : {0.5, 1.0, 2.0}) {
    World world = make_world();
    const BodyId fixed = world.create_body({.type = BodyType::Static});
    const ShapeDef small = test::smooth(make_disc(0.001));
    const BodyId flying = test::add(world, {-400, offset}, small, 2, {10, 0});
    PairForces forces({.strength = -40});
    forces.set_weight(fixed, 3);
    forces.set_weight(flying, 1);
    advance(world, forces, 0.005, 16000);
    const Vec2 v = world.velocity(flying);
    EXPECT_NEAR(std::atan2(v.y, v.x), 2 * std::atan(120 / (2 * 100 * offset)), 2e-3) << offset;
    EXPECT_NEAR(length(v), 10, 0.02) << offset;
  }
}

INSTANTIATE_TEST_SUITE_P(Steppers, PairForcesBy, testing::Values("time_stepping", "event_driven", "auto"),
                         [](const testing::TestParamInfo<const char*>& each) {
                           return std::string(each.param);
                         });

TEST_P(PairForcesBy, AHeapThatTurnsKeepsItsAngularMomentum) {
  // Discs that fall together while they turn about each other, and go on turning as one.
  for (const int count : {9, 20}) {
    for (const bool by_field : {false, true}) {
      if (count > 9 && GetParam() == std::string("event_driven")) continue;
      test::Draw draw(1);
      World world = make_world();
      const int side = static_cast<int>(std::ceil(std::sqrt(count)));
      for (int i = 0; i < count; ++i) {
        const int row = i / side;
        const Vec2 place{(i % side - 0.5 * (side - 1)) * 1.3, (row - 0.5 * (side - 1)) * 1.3};
        const double radius = draw.uniform(0.3, 0.6), mass = 1000 * kPi * radius * radius;
        test::add(world, place, test::rough(make_disc(radius), 0.5), mass, 0.6 * perp(place), 0.6);
      }
      if (by_field)
        world.set_force_field([](const FieldSample& sample) {
          return Wrench{-6 * sample.mass * sample.position, 0};
        });
      const double first = world.angular_momentum();
      advance(world, PairForces({.strength = by_field ? 0 : 0.005}), 1.0 / 60, 360);
      EXPECT_NEAR(world.angular_momentum() / first, 1, by_field ? 0.03 : 0.003)
          << count << " discs" << (by_field ? ", by a field" : "");
    }
  }
}

TEST(PairForces, AreTheSlopeOfTheirPotential) {
  for (const double power : {-1.0, 0.0, 0.5, 1.0, 2.0, 2.5, 3.0, 6.0}) {
    for (const double softening : {0.0, 0.3}) {
      World world(test::weightless());
      const BodyId left = test::add(world, {0, 0}, test::smooth(make_disc(0.01)), 2);
      const BodyId right = test::add(world, {0.6, 0.8}, test::smooth(make_disc(0.01)), 5);
      PairForces forces({.strength = 3, .power = power, .softening = softening});
      constexpr double kWay = 1e-5, kStep = 1e-4;
      const auto energy_at = [&](double distance) {
        world.set_pose(right, distance * Vec2{0.6, 0.8}, 0);
        return forces.potential_energy(world);
      };
      const double slope = (energy_at(1 + kWay) - energy_at(1 - kWay)) / (2 * kWay);
      energy_at(1);
      advance(world, forces, kStep, 1);
      const Vec2 force = 5 / kStep * world.velocity(right);
      EXPECT_NEAR(length(force + slope * Vec2{0.6, 0.8}), 0, 1e-7 * slope) << power << ", " << softening;
      EXPECT_NEAR(length(2 / kStep * world.velocity(left) + force), 0, 1e-9 * slope);
    }
  }
}

TEST(PairForces, AreAmongThoseThatAreNamed) {
  World world(test::weightless());
  const ShapeDef small = test::smooth(make_disc(0.01));
  const BodyId plus = test::add(world, {0, 0}, small), minus = test::add(world, {1, 0}, small),
               other = test::add(world, {0, 1}, small);
  const BodyId wall = world.create_body({.type = BodyType::Static, .position = {-1, 0}});
  PairForces forces({.strength = -1});
  forces.set_weight(plus, 2);
  forces.set_weight(minus, -3);
  forces.set_weight(wall, 1);
  constexpr double kStep = 1e-3;
  advance(world, forces, kStep, 1);
  // 6 N to the right, and 2 N from the wall; the other one by 3 / 4 to the wall.
  EXPECT_NEAR(world.velocity(plus).x, 8 * kStep, 1e-12);
  EXPECT_NEAR(world.velocity(minus).x, -6.75 * kStep, 1e-12);
  EXPECT_EQ(world.velocity(other), Vec2{});
  EXPECT_EQ(world.position(wall), (Vec2{-1, 0}));

  world.destroy(minus);
  const double before = world.velocity(plus).x;
  advance(world, forces, kStep, 1);
  EXPECT_NEAR(world.velocity(plus).x - before, 2 * kStep, 1e-7);
}

TEST(PairForces, OfOnePlaceHaveNoDirection) {
  World world(test::weightless());
  const ShapeDef ghost{.shape = make_disc(0.1), .filter = {.group = -1}};
  const BodyId a = test::add(world, {1, 1}, ghost), b = test::add(world, {1, 1}, ghost);
  PairForces forces({.strength = 1});
  advance(world, forces, 0.1, 3);
  EXPECT_EQ(world.velocity(a), Vec2{});
  EXPECT_EQ(forces.potential_energy(world), 0);
  world.set_pose(b, {1 + 1e-9, 1}, 0);
  EXPECT_NO_THROW(forces.apply(world, 0.1));
  world.set_pose(a, {0, 0}, 0);
  world.set_pose(b, {1e-155, 0}, 0);
  try {
    PairForces({.strength = 1, .power = 3}).apply(world, 0);
    ADD_FAILURE() << "taken";
  } catch (const std::invalid_argument& error) {
    const std::string words = error.what();
    EXPECT_NE(words.find("bodies 0 and 1, "), std::string::npos) << words;
    EXPECT_NE(words.find("e-156 m apart, is not finite"), std::string::npos) << words;
  }
}

TEST(PairForces, RefuseWhatIsNoNumber) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(PairForces({.strength = kNan}), std::invalid_argument);
  EXPECT_THROW(PairForces({.strength = 1, .power = INFINITY}), std::invalid_argument);
  EXPECT_THROW(PairForces({.strength = 1, .softening = -0.1}), std::invalid_argument);
  World world(test::weightless());
  const BodyId body = test::add(world, {0, 0}, test::smooth(make_disc(0.1)));
  PairForces forces({.strength = 1});
  EXPECT_THROW(forces.set_weight(body, kNan), std::invalid_argument);
  EXPECT_THROW(forces.apply(world, -1), std::invalid_argument);
  EXPECT_THROW(forces.apply(world, kNan), std::invalid_argument);
  EXPECT_THROW(forces.set_law({.strength = 2, .softening = kNan}), std::invalid_argument);
  EXPECT_EQ(forces.law().strength, 1);
}

/// Discs that attract each other come to lie on each other, and go on doing so.
TEST(PairForces, PressWhatTouches) {
  World world(test::weightless());
  std::vector<BodyId> discs;
  discs.reserve(7);
  for (int i = 0; i < 7; ++i)
    discs.push_back(test::add(world, {1.3 * i - 4, 0.3 * (i % 2)}, test::rough(make_disc(0.5), 0.4), 1));
  PairForces forces({.strength = 5, .softening = 0.1});
  advance(world, forces, 1.0 / 60, 900);
  EXPECT_LT(world.kinetic_energy(), 1e-4);
  for (const BodyId disc : discs) EXPECT_LT(length(world.position(disc)), 4.0);
  EXPECT_LT(world.report().worst_penetration, 1e-6);
}

TEST(PairForces, AWeightIsSetAnew) {
  World world(test::weightless());
  const BodyId a = test::add(world, {0, 0}, test::smooth(make_disc(0.1))),
               b = test::add(world, {2, 0}, test::smooth(make_disc(0.1)));
  PairForces forces({.strength = 4});
  forces.set_weight(a, 1);
  forces.set_weight(b, 5);
  forces.set_weight(b, 1);
  EXPECT_NEAR(forces.potential_energy(world), -4.0 / 2, 1e-12);
  advance(world, forces, 1e-6, 1);
  EXPECT_NEAR(world.velocity(a).x, 1e-6, 1e-12);
}

TEST(PairForces, PowersMayBeOfAnySize) {
  for (const double power : {100.0, 1e5, 1e10, 1e15}) {
    World world(test::weightless());
    const BodyId a = test::add(world, {0, 0}, test::smooth(make_disc(0.1)));
    test::add(world, {1 + 1 / power, 0}, test::smooth(make_disc(0.1)));
    advance(world, PairForces({.strength = 1, .power = power}), 1e-3, 1);
    EXPECT_NEAR(world.velocity(a).x, 1e-3 * std::pow(1 + 1 / power, -power), 1e-6) << power;
  }
}

TEST(PairForces, WeightsAreSetAnewInAnyOrder) {
  World world(test::weightless());
  std::vector<BodyId> bodies;
  bodies.reserve(4);
  for (int i = 0; i < 4; ++i) bodies.push_back(test::add(world, {1.0 * i, 0}, test::smooth(make_disc(0.1))));
  PairForces forces({.strength = 4});
  for (const double weight : {5.0, 1.0})
    for (const std::size_t i : {3, 1, 2, 0}) forces.set_weight(bodies[i], i == 0 || i == 3 ? weight : 0);
  EXPECT_NEAR(forces.potential_energy(world), -4.0 / 3, 1e-12);
}

TEST(PairForces, ThatAreRefusedChangeNothing) {
  World world(test::weightless());
  const ShapeDef small = test::smooth(make_disc(0.1));
  // Springs so stiff that two of them are too far from each other for a number, up or to the right.
  const PairForces springs({.strength = 1e300, .power = -1});
  for (const Vec2 way : {Vec2{0, 1e8}, Vec2{1e8, 0}}) {
    const BodyId bodies[] = {test::add(world, {0, 0}, small), test::add(world, -way, small),
                             test::add(world, 0.9 * way, small)};
    EXPECT_THROW(springs.apply(world, 0), std::invalid_argument);
    for (const BodyId body : bodies) {
      EXPECT_EQ(world.bodies().force[body.index], Vec2{});
      world.destroy(body);
    }
  }
}

TEST(PairForces, AreBoundedBySofteningAsTheirLawSays) {
  constexpr double kStep = 1e-6;
  for (const double power : {1.0, 2.0, 3.0}) {
    World world(test::weightless());
    const ShapeDef small = test::smooth(make_disc(0.01));
    const BodyId a = test::add(world, {0, 0}, small, 2);
    test::add(world, {0.4, 0}, small, 5);
    const PairForces forces({.strength = 3, .power = power, .softening = 0.3});
    EXPECT_EQ(forces.law().softening, 0.3);
    forces.apply(world, kStep);
    world.step(kStep);
    // The root distance is 0.5 m.
    EXPECT_NEAR(world.velocity(a).x / kStep, 3 * 5 * 0.4 * std::pow(0.5, -power - 1), 1e-6) << power;
  }
}

TEST(PairForces, WhatOnlyActsWakesNobody) {
  WorldConfig config;
  config.sleep = true;
  World world(config);
  const BodyId ground = test::add_ground(world, test::rough(make_disc(1), 0.5));
  const BodyId box = test::add(world, {0, 0.5}, test::rough(make_box({1, 1}), 0.5));
  const BodyId moon = test::add(world, {0, 50}, test::smooth(make_disc(1)), 1, {1, 0});
  PairForces forces({.strength = 1});
  forces.set_weight(ground, 10);
  forces.set_weight(moon, 1);
  advance(world, forces, 1.0 / 60, 120);
  EXPECT_NE(world.bodies().asleep[box.index], 0);
  forces.apply(world, 1.0 / 60);
  EXPECT_NE(world.bodies().asleep[box.index], 0);
  EXPECT_EQ(world.bodies().force[ground.index], Vec2{});
}

}  // namespace pair_forces_test
}  // namespace skerry
