// SPDX-License-Identifier: MIT
//
// What bounces off ground that moves: seen from the ground it is as if that were at rest, and what the ground
// brings is neither lost nor more than its work.
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <tuple>
#include <vector>

#include "physics/solver/impact_law.h"
#include "tests/support/draw.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace moving_bounce_test {

using test::add;
using test::Draw;
using test::rough;
using test::smooth;

constexpr double kStep = 1.0 / 60;

WorldConfig by(std::string_view stepper, std::string_view law = "reflections", Vec2 gravity = {0, 0}) {
  WorldConfig config;
  config.stepper = std::string(stepper);
  config.impact_law = std::string(law);
  config.gravity = gravity;
  return config;
}

using ByStepperAndLaw = std::tuple<const char*, const char*>;
class MovingBounce : public testing::TestWithParam<ByStepperAndLaw> {};

/// Ground that comes or goes slowly, and may go fast along itself.
struct Case {
  Vec2 ground;
  double belt, friction, bounce;
};

TEST_P(MovingBounce, IsThatOffGroundAtRestAsSeenFromTheGround) {
  const auto& [stepper, law] = GetParam();
  constexpr double kFall = 2;
  for (const Case& c :
       {Case{{5, 0}, 0, 0.5, 0.9}, Case{{5, 0.01}, 0, 0.5, 0.9}, Case{{5, -0.01}, 0, 0.5, 0.9},
        Case{{0, 0}, 5, 0.5, 0.9}, Case{{0, 0.01}, 5, 0.5, 0.9}, Case{{0, 0.1}, -5, 0.5, 0.9},
        Case{{0, 0.01}, 0, 0, 1}, Case{{0, 0.007}, 0, 0, 1}, Case{{0, -0.007}, 0, 0, 1},
        Case{{0, 0.001}, 0, 0.3, 0.5}}) {
    SCOPED_TRACE(testing::Message() << "ground " << c.ground.x << ", " << c.ground.y << ", belt " << c.belt);
    World world(by(stepper, law));
    const BodyId ground = world.create_body({.type = BodyType::Kinematic, .velocity = c.ground});
    ShapeDef floor = rough(make_half_plane({0, 0}, {0, 1}), c.friction, c.bounce);
    floor.material.surface_velocity = c.belt;
    world.add_shape(ground, floor);
    const BodyId ball = add(world, {0, 0.15}, rough(make_disc(0.1), c.friction, c.bounce), 0.7, {0, -kFall});
    for (int k = 0; k < 6; ++k) world.step(kStep);
    const double approach = kFall + c.ground.y;
    EXPECT_NEAR(world.velocity(ball).y, c.ground.y + c.bounce * approach, 1e-12);
    // Friction turns a solid disc until it rolls, a third of the way, or pushes as far as it goes.
    const double along = c.ground.x - c.belt;
    const double most = c.friction * (1 + c.bounce) * approach;
    EXPECT_NEAR(std::abs(world.velocity(ball).x), std::min(std::abs(along) / 3, most), 1e-12);
  }
}

TEST_P(MovingBounce, StaysAsFastInABoxThatMoves) {
  const auto& [stepper, law] = GetParam();
  for (const double speed : {0.001, 0.01, 0.015, 1.0}) {
    World world(by(stepper, law));
    const BodyId box = world.create_body({.type = BodyType::Kinematic, .velocity = {speed, 0}});
    for (const double side : {-1, 1}) world.add_shape(box, smooth(make_box({0.5, 4}, {1.25 * side, 0}), 1));
    const BodyId ball = add(world, {0, 0}, smooth(make_disc(0.1), 1), 1, {5 + speed, 0});
    for (int k = 0; k < 600; ++k) world.step(kStep);
    EXPECT_NEAR(std::abs(world.velocity(ball).x - speed), 5, 1e-9) << "box at " << speed << " m/s";
  }
}

TEST_P(MovingBounce, ComesOutOfAGrooveThatMoves) {
  const auto& [stepper, law] = GetParam();
  for (const double steep : {0.3, 0.8, 1.2}) {
    for (const double bounce : {0.5, 1.0}) {
      World world(by(stepper, law));
      const BodyId groove = world.create_body({.type = BodyType::Kinematic, .velocity = {0, 2}});
      for (const double side : {-1, 1})
        world.add_shape(groove,
                        smooth(make_half_plane({0, 0}, {side * std::sin(steep), std::cos(steep)}), bounce));
      const BodyId ball = add(world, {0, 0.1 / std::cos(steep) + 0.02}, smooth(make_disc(0.1), bounce));
      for (int k = 0; k < 6; ++k) world.step(kStep);
      EXPECT_NEAR(world.velocity(ball).y, 2 + 2 * bounce, 1e-9) << "walls at " << steep << " rad";
    }
  }
}

TEST_P(MovingBounce, OfADoorIsWholeWhereverItIsStruck) {
  // A disc at 2 m/s that nothing stops strikes a bar of 1 m near its hinge, or far from it.
  const auto& [stepper, law] = GetParam();
  for (const double bounce : {0.3, 1.0}) {
    for (const double far : {0.95, 0.6, 0.4, 0.2}) {
      World world(by(stepper, law));
      const BodyId bar = world.create_body({.position = {0.5, 0}, .mass = 1.0, .inertia = 1.0 / 12});
      world.add_shape(bar, smooth(make_box({1, 0.02}), bounce));
      world.create_joint({.kind = JointKind::Revolute, .b = bar, .anchor_a = {0, 0}});
      const BodyId disc =
          world.create_body({.type = BodyType::Kinematic, .position = {far, -0.12}, .velocity = {0, 2}});
      world.add_shape(disc, smooth(make_disc(0.1), bounce));
      while (world.step(kStep / 4).impacts == 0 && world.time() < 0.1) {
      }
      EXPECT_NEAR(far * world.omega(bar), 2 * (1 + bounce), 2e-3) << "struck at " << far << " m";
    }
  }
}

TEST_P(MovingBounce, OfABoxThatLandsFlatIsExact) {
  // It moves along with the ground: what friction has to change is rounding.
  const auto& [stepper, law] = GetParam();
  for (unsigned seed = 0; seed < 40; ++seed) {
    Draw draw(seed);
    const Vec2 speed{draw.uniform(-2, 2), draw.uniform(-2, 2)};
    World world(by(stepper, law, {0, -9.81}));
    const BodyId ground = world.create_body({.type = BodyType::Kinematic, .velocity = speed});
    world.add_shape(ground, rough(make_half_plane({0, 0}, {0, 1}), 0.5, 0.5));
    add(world, {0, 0.1 + draw.uniform(0.02, 0.3)}, rough(make_box({0.2, 0.2}), 0.5, 0.5), 40, speed);
    for (int k = 0; k < 60; ++k) EXPECT_EQ(world.step(kStep).inexact_islands, 0) << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Registry, MovingBounce,
                         testing::Combine(testing::Values("time_stepping", "event_driven", "auto"),
                                          testing::Values("reflections", "poisson", "simultaneous")),
                         [](const auto& made) {
                           return std::string(std::get<0>(made.param)) + "_" + std::get<1>(made.param);
                         });

/// A floor on which heavy bodies come down on light ones, seen from where it is at rest.
enum class Floor { Static, Kinematic, Sideways, Belt };

/// The most that one of the steps brings, as a share of the energy at the beginning, seen from the floor.
/// @param brought  a step may have it from the floor [J/s]
double worst_gain(const char* stepper, Floor kind, unsigned seed) {
  constexpr double kSlow = 0.1;
  Draw draw(seed);
  const double h = draw.one_in(2) ? kStep : kStep / 4;
  const double bounces[] = {0.5, 0.7, 0.9, 0.95}, light[] = {0.1, 0.01, 0.003}, heavy[] = {1, 10, 100};
  const double bounce = bounces[draw.pick(4)], friction = draw.one_in(2) ? 0.3 : 0;
  World world(by(stepper, "reflections", {0, -9.81}));
  const Vec2 speed{kind == Floor::Sideways ? kSlow : 0, 0};
  const bool told = kind == Floor::Kinematic || kind == Floor::Sideways;
  const BodyId floor = world.create_body(
      {.type = told ? BodyType::Kinematic : BodyType::Static, .velocity = told ? speed : Vec2{}});
  ShapeDef ground = rough(make_box({40, 2}, {0, -1}), friction, bounce);
  if (kind == Floor::Belt) ground.material.surface_velocity = kSlow;
  world.add_shape(floor, ground);
  std::vector<BodyId> bodies;
  const int count = 1 + draw.pick(3);
  bodies.reserve(count + 1);
  for (int i = 0; i < count; ++i)
    bodies.push_back(add(world, {0.15 * (i - 0.5 * (count - 1)), 0.05 + draw.uniform(0, 0.03)},
                         rough(make_disc(0.05), friction, bounce), light[draw.pick(3)], speed));
  const bool box = draw.one_in(2);
  bodies.push_back(add(world, {draw.uniform(-0.02, 0.02), box ? 0.24 : 0.44},
                       rough(box ? make_box({0.8, 0.2}) : make_disc(0.3), friction, bounce),
                       heavy[draw.pick(3)], speed + Vec2{0, -draw.uniform(0.5, 8)}, 0,
                       box ? draw.uniform(-0.05, 0.05) : 0));
  const auto energy = [&] {
    double sum = world.potential_energy();
    for (const BodyId body : bodies) {
      const double w = world.omega(body);
      sum += 0.5 * world.mass(body) * length_squared(world.velocity(body) - speed) +
             0.5 * world.inertia(body) * w * w;
    }
    return sum;
  };
  const double first = energy();
  double worst = 0;
  for (int k = 0; k < std::lround(0.4 / h); ++k) {
    const double before = energy();
    world.step(h);
    worst = std::max(worst, (energy() - before) / first);
  }
  return worst;
}

TEST(HeavyOnLight, GainsNoEnergyFromGroundThatCouldMove) {
  // A belt works on what slides over it: 0.1 m/s against the momentum of a fall.
  for (const auto& [kind, most] : {std::pair(Floor::Static, 1e-3), std::pair(Floor::Kinematic, 1e-3),
                                   std::pair(Floor::Sideways, 1e-3), std::pair(Floor::Belt, 2e-2)}) {
    for (unsigned seed = 0; seed < 60; ++seed) {
      for (const char* stepper : {"time_stepping", "event_driven"}) {
        EXPECT_LE(worst_gain(stepper, kind, seed), most)
            << stepper << ", floor " << static_cast<int>(kind) << ", seed " << seed;
      }
    }
  }
}

TEST(HeavyOnLight, LeavesAloneWhatTouchesNothing) {
  // A pinch between a heavy disc and the floor took, or gave, three quarters of the speed of a bystander.
  for (const BodyType type : {BodyType::Static, BodyType::Kinematic}) {
    World world(by("time_stepping"));
    world.add_shape(world.create_body({.type = type}), smooth(make_box({40, 2}, {0, -1}), 0.9));
    add(world, {0, 0.06}, smooth(make_disc(0.05), 0.9), 0.01);
    add(world, {0, 0.5}, smooth(make_disc(0.3), 0.9), 10, {0, -5});
    const BodyId bystander = add(world, {0.8, 0.4}, smooth(make_disc(0.1), 0.9), 1, {0, 3});
    for (int k = 0; k < 12; ++k) world.step(kStep);
    EXPECT_EQ(world.velocity(bystander).y, 3);
  }
}

/// How a pit goes, and what a step may gain of the energy at the beginning: by its own work.
struct Pit {
  Vec2 velocity;
  double turn, belt, most;
};

TEST(PileInFlow, GainsNoEnergyFromAPitThatMoves) {
  // 120 bodies of masses from 0.1 to 10 that bounce well; energy is seen from the pit, belts are not.
  for (const Pit& pit : {Pit{{0, 0}, 0, 0, 1e-4}, Pit{{0.1, 0}, 0, 0, 1e-4}, Pit{{0, 0}, 0, 0.1, 5e-3},
                         Pit{{0, 0}, 1e-4, 0, 1e-4}, Pit{{0, 0}, 0.01, 0, 1e-3}}) {
    Draw draw(5);
    World world(by("time_stepping", "reflections", {0, -9.81}));
    const BodyId ground =
        world.create_body({.type = BodyType::Kinematic, .velocity = pit.velocity, .omega = pit.turn});
    for (const Shape& shape :
         {make_box({20, 1}, {0, -0.5}), make_box({1, 40}, {-2.5, 20}), make_box({1, 40}, {2.5, 20})}) {
      ShapeDef def = rough(shape, 0.3, 0.9);
      def.material.surface_velocity = pit.belt;
      world.add_shape(ground, def);
    }
    std::vector<BodyId> bodies;
    bodies.reserve(120);
    for (int i = 0; i < 120; ++i) {
      const int row = i / 10;
      const Vec2 place{-1.6 + 0.35 * (i % 10), 0.3 + 0.35 * row};
      bodies.push_back(add(world, place, rough(i % 2 ? make_disc(0.15) : make_box({0.25, 0.25}), 0.3, 0.9),
                           std::pow(10, draw.uniform(-1, 1)), pit.velocity + Vec2{draw.uniform(-1, 1), -6}));
    }
    const auto energy = [&] {
      double sum = world.potential_energy();
      for (const BodyId body : bodies)
        sum += 0.5 * world.mass(body) * length_squared(world.velocity(body) - pit.velocity) +
               0.5 * world.inertia(body) * world.omega(body) * world.omega(body);
      return sum;
    };
    const double first = energy();
    int flowing = 0;
    for (int k = 0; k < 90; ++k) {
      const double before = energy();
      flowing += world.step(kStep).islands_in_flow;
      EXPECT_LE(energy() - before, pit.most * first) << "at " << pit.velocity.x << " m/s, turning by "
                                                     << pit.turn << ", belts " << pit.belt << ", step " << k;
    }
    EXPECT_GT(flowing, 20);
  }
}

TEST(MovingBounceOfSeveral, GainsNoEnergyAsSeenFromTheGround) {
  // A heavy disc pinches a light one at a rough wall, and each pair bounces as it likes.
  for (unsigned seed = 0; seed < 300; ++seed) {
    for (const Vec2 speed : {Vec2{0, 3}, Vec2{5, 0}, Vec2{5, -5}}) {
      Draw draw(seed);
      const double bounces[] = {0, 0.5, 1}, masses[] = {0.1, 0.3, 1};
      World world(by(draw.one_in(2) ? "time_stepping" : "event_driven"));
      const double friction = draw.uniform(0.3, 1);
      const auto shape = [&](const Shape& of) {
        ShapeDef def = rough(of, friction, bounces[draw.pick(3)]);
        def.restitution_rule = MixingRule::Average;
        return def;
      };
      world.add_shape(world.create_body({.type = BodyType::Kinematic, .velocity = speed}),
                      shape(make_half_plane({0, 0}, {0, 1})));
      const double angle = draw.uniform(-1.2, 1.2), light = masses[draw.pick(3)];
      const Vec2 along{std::sin(angle), std::cos(angle)}, low{0, 0.1};
      const BodyId bodies[] = {add(world, low, shape(make_disc(0.1)), light, speed),
                               add(world, low + 0.45 * along, shape(make_disc(0.3)), 10, speed - 4 * along)};
      const auto energy = [&] {
        double sum = 0;
        for (const BodyId body : bodies)
          sum += 0.5 * world.mass(body) * length_squared(world.velocity(body) - speed) +
                 0.5 * world.inertia(body) * world.omega(body) * world.omega(body);
        return sum;
      };
      const double first = energy();
      for (int k = 0; k < 10; ++k) world.step(kStep);
      EXPECT_LE(energy(), first * (1 + 1e-9))
          << "seed " << seed << ", ground at " << speed.x << ", " << speed.y;
    }
  }
}

/// A hinged chain that bounces about in a box without loss.
Vec2 chain_in_a_box(const char* stepper, BodyType type, unsigned seed) {
  Draw draw(seed);
  World world(by(stepper));
  const BodyId box = world.create_body({.type = type});
  for (const Vec2 side : {Vec2{1, 0}, Vec2{-1, 0}, Vec2{0, 1}, Vec2{0, -1}})
    world.add_shape(box, smooth(make_half_plane(-1.5 * side, side), 1));
  BodyId last;
  Vec2 joint{0, 0.3};
  for (int i = 0; i < 3; ++i) {
    const double angle = draw.uniform(-3, 3), half = draw.uniform(0.12, 0.2);
    const Vec2 along{std::cos(angle), std::sin(angle)};
    const BodyId link =
        add(world, joint + half * along, smooth(make_capsule({-0.8 * half, 0}, {0.8 * half, 0}, 0.03), 1), 1,
            {draw.uniform(-2, 2), draw.uniform(-2, 2)}, draw.uniform(-5, 5), angle);
    if (i > 0) world.create_joint({.kind = JointKind::Revolute, .a = last, .b = link, .anchor_a = joint});
    joint += 2 * half * along;
    last = link;
  }
  for (int k = 0; k < 60; ++k) world.step(kStep);
  return world.position(last);
}

TEST(GroundThatCouldMove, IsLikeGroundThatCannot) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    for (const char* stepper : {"time_stepping", "event_driven"}) {
      EXPECT_EQ(chain_in_a_box(stepper, BodyType::Static, seed),
                chain_in_a_box(stepper, BodyType::Kinematic, seed))
          << stepper << ", seed " << seed;
    }
  }
}

TEST(LandingOnATableThatShakes, IsFoundWhereTheTableIs) {
  // First bounces at random phases. What is left is the polynomial of the motion in a step (kinematic.h).
  for (const double frequency : {3.0, 10.0}) {
    double worst = 0;
    int bounces = 0;
    for (unsigned seed = 0; seed < 150; ++seed) {
      Draw draw(seed);
      const double omega = 2 * kPi * frequency, amplitude = draw.uniform(0.3, 2) / omega;
      const double phase = draw.uniform(0, 2 * kPi), height = amplitude + draw.uniform(0.1, 0.6);
      const auto table = [=](double t) { return amplitude * std::sin(omega * t + phase); };
      const auto gap = [&](double t) { return height - 0.5 * 9.81 * t * t - table(t); };
      double before = 0, after = 1e-4;
      while (gap(after) > 0) after = (before = after) + 1e-4;
      for (int k = 0; k < 60; ++k) {
        const double t = 0.5 * (before + after);
        (gap(t) > 0 ? before : after) = t;
      }
      const double speed = amplitude * omega * std::cos(omega * after + phase);
      const double leaves = speed + 0.9 * (speed + 9.81 * after);
      if (speed + 9.81 * after < 0.5) continue;
      World world(by("time_stepping", "reflections", {0, -9.81}));
      const BodyId ground = world.create_body({.type = BodyType::Kinematic, .position = {0, table(0)}});
      world.add_shape(ground, smooth(make_half_plane({0, 0}, {0, 1}), 0.9));
      world.set_motion(ground, [=](double t) { return Placement{{0, table(t)}, 0}; });
      const BodyId ball = add(world, {0, height + 0.1}, smooth(make_disc(0.1), 0.9));
      int impacts = 0;
      while (impacts == 0 && world.time() < 2) impacts = world.step(kStep).impacts;
      if (impacts > 1) continue;
      ++bounces;
      worst = std::max(worst, std::abs(world.velocity(ball).y + 9.81 * (world.time() - after) - leaves));
    }
    EXPECT_GT(bounces, 100);
    EXPECT_LE(worst, 1e-6) << frequency << " Hz";
  }
}

}  // namespace moving_bounce_test
}  // namespace skerry
