// SPDX-License-Identifier: MIT
//
// Bodies that fly.
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "tests/support/pile.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace flight_test {

using test::add;
using test::add_ground;
using test::smooth;

TEST(Flight, IsAParabolaWhateverTheStep) {
  for (const double h : {1.0 / 10, 1.0 / 60, 1.0 / 1000}) {
    World world;
    const auto ball = add(world, {0, 0}, smooth(make_disc(0.1)), 1, {3, 20}, 2);
    const int steps = static_cast<int>(std::lround(2 / h));
    for (int i = 0; i < steps; ++i) world.step(h);
    EXPECT_NEAR(world.position(ball).x, 6, 1e-11);
    EXPECT_NEAR(world.position(ball).y, 40 - 0.5 * 9.81 * 4, 1e-11);
    EXPECT_NEAR(world.angle(ball), 4, 1e-11);
    EXPECT_EQ(world.report().islands_in_flight, 1);
    EXPECT_EQ(world.report().rows, 0);
  }
}

/// For an observer of paths bodies that fly alone are stepped as all islands are.
TEST(Flight, OfBodiesThatFlyAloneTellsWhatThatOfAnyIslandDoes) {
  for (const double bounce : {0.6, 0.8}) {
    World worlds[2];
    for (World& world : worlds) {
      test::add_pit(world, bounce);
      test::add_pile(world, 280, bounce);
    }
    worlds[1].observe({.paths = true});
    int alone = 0, retries = 0;
    for (int step = 0; step < 60; ++step) {
      const StepReport& r = worlds[0].step(1.0 / 60);
      const StepReport& other = worlds[1].step(1.0 / 60);
      ASSERT_EQ(r.state_hash, other.state_hash) << bounce << ", step " << step;
      alone += r.islands_in_flight;
      retries += r.island_retries;
      EXPECT_EQ(r.islands_in_flight, other.islands_in_flight) << bounce << ", step " << step;
      EXPECT_EQ(r.island_retries, other.island_retries) << bounce << ", step " << step;
      EXPECT_EQ(r.islands, other.islands) << bounce << ", step " << step;
      EXPECT_EQ(r.substeps, other.substeps) << bounce << ", step " << step;
      EXPECT_EQ(r.contacts, other.contacts) << bounce << ", step " << step;
      EXPECT_EQ(r.work.visits, other.work.visits) << bounce << ", step " << step;
      ASSERT_EQ(r.islands_list.size(), other.islands_list.size());
      for (std::size_t n = 0; n < r.islands_list.size(); ++n) {
        const IslandReport &x = r.islands_list[n], &y = other.islands_list[n];
        EXPECT_EQ(x.bodies, y.bodies) << n;
        EXPECT_EQ(x.contacts, y.contacts) << n;
        EXPECT_EQ(x.stepper, y.stepper) << n;
        EXPECT_EQ(x.method, y.method) << n;
        EXPECT_EQ(x.status, y.status) << n;
        EXPECT_EQ(x.flowing, y.flowing) << n;
      }
    }
    EXPECT_GT(alone, 500) << bounce;
    EXPECT_GT(retries, 3) << bounce;
  }
}

/// A chain of boxes, 1 m apart, joined by one joint of each of these kinds, that flies off as one.
struct Mechanism {
  std::vector<BodyId> bodies;
  std::vector<JointId> joints;

  explicit Mechanism(World& world) {
    constexpr JointKind kKinds[] = {JointKind::Revolute, JointKind::Weld,      JointKind::Distance,
                                    JointKind::Rope,     JointKind::Prismatic, JointKind::Wheel,
                                    JointKind::Gear};
    const auto add_link = [&] {
      const double x = static_cast<double>(bodies.size());
      bodies.push_back(add(world, {x, 0.1 * x * x}, smooth(make_box({0.6, 0.2})), 1 + x, {3, 4}, 0, 0.3 * x));
    };
    add_link();
    for (const JointKind kind : kKinds) {
      add_link();
      JointDef def;
      def.kind = kind;
      def.a = bodies[bodies.size() - 2];
      def.b = bodies.back();
      def.anchor_a = world.position(def.a) + Vec2{0.3, 0.1};
      def.anchor_b = world.position(def.b) - Vec2{0.3, 0.1};
      def.axis = {1, 2};
      if (kind == JointKind::Rope) def.length = 2;
      if (kind == JointKind::Revolute) def.lower = def.upper = 0;
      joints.push_back(world.create_joint(def));
    }
  }

  /// From the centre of the first body to that of the last.
  JointDef across(const World& world, JointKind kind) const {
    const BodyId a = bodies.front(), b = bodies.back();
    return {.kind = kind, .a = a, .b = b, .anchor_a = world.position(a), .anchor_b = world.position(b)};
  }
};

TEST(Flight, OfWhatFallsAsOneTakesNoForces) {
  for (const Vec2 gravity : {Vec2{0, -9.81}, Vec2{0, 0}}) {
    WorldConfig config;
    config.gravity = gravity;
    World skips(config);
    config.skips.flight = false;
    World solves(config);
    const std::vector<BodyId> bodies = Mechanism(skips).bodies;
    const Mechanism same(solves);
    for (int step = 1; step <= 200; ++step) {
      const StepReport& r = skips.step(1.0 / 60);
      EXPECT_EQ(r.islands, 1);
      EXPECT_EQ(r.islands_in_flight, 1) << step;
      EXPECT_EQ(r.work.visits, 0) << step;
      EXPECT_EQ(solves.step(1.0 / 60).islands_in_flight, 0);
      const double t = step / 60.0;
      for (std::size_t k = 0; k < bodies.size(); ++k) {
        const double x = static_cast<double>(k);
        const Vec2 there = Vec2{x, 0.1 * x * x} + t * Vec2{3, 4} + (0.5 * t * t) * gravity;
        EXPECT_LT(length(skips.position(bodies[k]) - there), 1e-11);
        EXPECT_LT(length(solves.position(same.bodies[k]) - there), 1e-11);
        EXPECT_EQ(skips.angle(bodies[k]), 0.3 * x);
        EXPECT_LT(std::abs(solves.angle(same.bodies[k]) - 0.3 * x), 1e-11);
      }
    }
    // A blow ends it, and joints pull from then on.
    for (World* world : {&skips, &solves}) {
      world->apply_impulse(bodies[2], {2, 5}, world->position(bodies[2]) + Vec2{0.1, 0});
      for (int step = 0; step < 20; ++step) EXPECT_EQ(world->step(1.0 / 60).islands_in_flight, 0);
    }
    for (const BodyId body : bodies) EXPECT_LT(length(skips.position(body) - solves.position(body)), 1e-9);
  }
}

/// What is at rest does not fly: it sleeps.
TEST(Flight, IsNothingForAMechanismAtRestInEmptySpace) {
  World world(test::weightless());
  for (const BodyId body : Mechanism(world).bodies) world.set_velocity(body, {0, 0}, 0);
  for (int step = 0; step < 120; ++step) EXPECT_EQ(world.step(1.0 / 60).islands_in_flight, 0);
  EXPECT_EQ(world.report().bodies_asleep, 8);
}

/// What gives the joints something to do, each by itself.
TEST(Flight, OfJointsThatAreAtWorkIsSolved) {
  struct Case {
    const char* name;
    void (*change)(World&, const Mechanism&);
  };
  const Case cases[] = {
      {"one is faster",
       [](World& w, const Mechanism& m) {
         w.set_velocity(m.bodies[3], {3.001, 4}, 0);
       }},
      {"one turns",
       [](World& w, const Mechanism& m) {
         w.set_velocity(m.bodies[3], {3, 4}, 1e-3);
       }},
      {"one falls faster", [](World& w, const Mechanism& m) { w.set_gravity_scale(m.bodies[3], 1.01); }},
      {"one is pushed", [](World& w, const Mechanism& m) { w.apply_torque(m.bodies[3], 0.01); }},
      {"two rods contradict each other",
       [](World& w, const Mechanism& m) {
         JointDef def = m.across(w, JointKind::Distance);
         w.create_joint(def);
         def.length = length(def.anchor_b - def.anchor_a) + 0.1;
         w.create_joint(def);
       }},
      {"one is driven", [](World& w, const Mechanism& m) { w.set_motor(m.joints[0], 1, 5); }},
      {"a motor presses against its limit",
       [](World& w, const Mechanism& m) { w.set_motor(m.joints[0], 1); }},
      {"a spring pulls",
       [](World& w, const Mechanism& m) {
         JointDef def = m.across(w, JointKind::Spring);
         def.length = 1;
         def.stiffness = 10;
         w.create_joint(def);
       }},
      {"a pulley hangs somewhere",
       [](World& w, const Mechanism& m) {
         JointDef def = m.across(w, JointKind::Pulley);
         def.pulley_a = {0, 30};
         def.pulley_b = {4, 30};
         w.create_joint(def);
       }},
      {"one is held",
       [](World& w, const Mechanism& m) {
         JointDef def;
         def.b = m.bodies.front();
         def.anchor_a = w.position(def.b);
         w.create_joint(def);
       }},
  };
  for (const Case& one : cases) {
    World worlds[2] = {World(WorldConfig{}), World([] {
                         WorldConfig config;
                         config.skips.flight = false;
                         return config;
                       }())};
    std::vector<BodyId> bodies;
    for (World& world : worlds) {
      const Mechanism mechanism(world);
      bodies = mechanism.bodies;
      one.change(world, mechanism);
      for (int step = 0; step < 3; ++step)
        EXPECT_EQ(world.step(1.0 / 60).islands_in_flight, 0) << one.name << ", step " << step;
    }
    for (const BodyId body : bodies)
      EXPECT_EQ(worlds[0].position(body), worlds[1].position(body)) << one.name;
  }
}

TEST(Flight, BouncingBallKeepsItsHeightForAHundredBounces) {
  World world;
  add_ground(world, smooth(make_disc(1), 1));
  const auto ball = add(world, {0, 1.5}, smooth(make_disc(0.5), 1));
  const double energy = world.kinetic_energy() + world.potential_energy();
  double top = 0;
  int bounces = 0;
  while (bounces < 100) {
    bounces += world.step(1.0 / 60).impacts;
    top = world.position(ball).y + world.velocity(ball).y * world.velocity(ball).y / (2 * 9.81);
  }
  EXPECT_NEAR(top, 1.5, 1e-9);
  EXPECT_NEAR(world.kinetic_energy() + world.potential_energy(), energy, 1e-9);
}

}  // namespace flight_test
}  // namespace skerry
