// SPDX-License-Identifier: MIT
//
// The forces on a body in the last step: what they are in cases with a closed form, and that they account for
// the motion of whatever they act on.
#include "physics/body_forces.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "physics/snapshot.h"
#include "tests/support/random_mechanism.h"

namespace skerry {
namespace body_forces_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;
using test::weightless;

constexpr double kH = 1.0 / 120;

Wrench sum_of(const World& world, BodyId body) {
  Wrench sum;
  for (const BodyForce& force : forces_on(world, body)) {
    sum.force += force.force;
    sum.torque += force.torque + cross(force.point - world.position(body), force.force);
  }
  return sum;
}

std::vector<BodyForce> of(const World& world, BodyId body, ForceSource source) {
  std::vector<BodyForce> found = forces_on(world, body);
  std::erase_if(found, [&](const BodyForce& force) { return force.source != source; });
  return found;
}

TEST(BodyForces, ARopeOverAPulleyPullsEachLoadAlongItsOwnSide) {
  World world;
  const BodyId heavy = add(world, {-1, 0}, smooth(make_disc(0.2)), 3);
  const BodyId light = add(world, {1, 0}, smooth(make_disc(0.2)), 2);
  world.create_joint({.kind = JointKind::Pulley,
                      .a = heavy,
                      .b = light,
                      .anchor_a = {-1, 0},
                      .anchor_b = {1, 0},
                      .pulley_a = {-1, 5},
                      .pulley_b = {1, 5}});
  for (int i = 0; i < 60; ++i) world.step(kH);
  const double tension = 2 * 3 * 2 / 5.0 * 9.81;
  for (const BodyId body : {heavy, light}) {
    const std::vector<BodyForce> ropes = of(world, body, ForceSource::Joint);
    ASSERT_EQ(ropes.size(), 1u);
    EXPECT_NEAR(ropes[0].force.y, tension, 1e-9);
    EXPECT_NEAR(ropes[0].force.x, 0, 1e-9);
    EXPECT_EQ(ropes[0].other, body == heavy ? light : heavy);
  }
  EXPECT_NEAR(sum_of(world, heavy).force.y, -3 * 9.81 / 5, 1e-9);
  EXPECT_NEAR(sum_of(world, light).force.y, 2 * 9.81 / 5, 1e-9);
}

TEST(BodyForces, TeethTurnThePinionAndPushTheRack) {
  World world(weightless());
  const BodyId pinion = add(world, {0, 0}, smooth(make_disc(0.3)), 2);
  const BodyId bar = add(world, {0.4, 0}, smooth(make_box({0.2, 1})), 3);
  world.create_joint({.kind = JointKind::Revolute, .b = pinion});
  world.create_joint({.kind = JointKind::Prismatic, .b = bar, .anchor_a = {0.4, 0}, .axis = {0, 1}});
  world.create_joint({.kind = JointKind::Rack,
                      .a = pinion,
                      .b = bar,
                      .anchor_a = {0, 0},
                      .anchor_b = {0.3, 0},
                      .axis = {0, 1},
                      .ratio = 0.3});
  for (int i = 0; i < 20; ++i) {
    world.apply_torque(pinion, 1);
    world.step(kH);
  }
  // (I + r^2 m) alpha = 1 N m
  const double alpha = 1 / (0.5 * 2 * 0.09 + 0.09 * 3);
  EXPECT_NEAR(length(sum_of(world, pinion).force), 0, 1e-9);
  EXPECT_NEAR(sum_of(world, pinion).torque, 0.09 * alpha, 1e-9);
  EXPECT_NEAR(sum_of(world, bar).force.y, 3 * 0.3 * alpha, 1e-9);
  ASSERT_EQ(of(world, pinion, ForceSource::Joint).size(), 1u) << "the hinge carries nothing";
  EXPECT_EQ(of(world, pinion, ForceSource::Joint)[0].force, Vec2{});
  EXPECT_NEAR(of(world, pinion, ForceSource::Joint)[0].torque, -0.3 * 3 * 0.3 * alpha, 1e-9);
  ASSERT_EQ(of(world, pinion, ForceSource::Applied).size(), 1u);
  EXPECT_EQ(of(world, pinion, ForceSource::Applied)[0].torque, 1);
}

TEST(BodyForces, AtRestTheySumToNothing) {
  World world;
  world.observe({.contacts = true});
  add_ground(world, rough(make_disc(1), 0.5));
  const BodyId box = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5), 1);
  // A balloon of half its weight's worth of lift, tied to the ground off its centre by a rod and a spring.
  const BodyId held = world.create_body({.position = {5, 3}, .gravity_scale = -0.5, .mass = 4.0});
  world.add_shape(held, smooth(make_box({2, 1})));
  world.create_joint({.kind = JointKind::Distance, .b = held, .anchor_a = {4.2, 1}, .anchor_b = {4.2, 2.6}});
  world.create_joint({.kind = JointKind::Spring,
                      .b = held,
                      .anchor_a = {5.8, 1},
                      .anchor_b = {5.8, 2.6},
                      .stiffness = 100,
                      .damping = 50});
  world.set_drag(held, {.linear = 5, .angular = 5});
  const BodyId welded = add(world, {9, 3}, smooth(make_box({2, 0.2})), 2);
  world.create_joint({.kind = JointKind::Weld, .b = welded, .anchor_a = {8, 3}});
  for (int i = 0; i < 3000; ++i) {
    world.apply_force(box, {3, 0}, {0, 0.5});
    world.apply_force(welded, {1, 2}, {10, 3});
    world.step(kH);
  }
  for (const BodyId body : {box, held, welded}) {
    const Wrench sum = sum_of(world, body);
    EXPECT_NEAR(length(sum.force), 0, 1e-6) << body.index;
    EXPECT_NEAR(sum.torque, 0, 1e-6) << body.index;
  }
  ASSERT_EQ(of(world, box, ForceSource::Applied).size(), 1u);
  EXPECT_EQ(of(world, box, ForceSource::Applied)[0].force, (Vec2{3, 0}));
  EXPECT_EQ(of(world, held, ForceSource::Weight)[0].force, (Vec2{0, 0.5 * 4 * 9.81}));
  EXPECT_TRUE(of(world, held, ForceSource::Applied).empty());
  // They were for that step.
  world.step(kH);
  EXPECT_TRUE(of(world, box, ForceSource::Applied).empty());
}

TEST(BodyForces, AtTerminalSpeedDragIsTheWeightAndTheField) {
  World world;
  world.set_force_field([](const FieldSample& sample) { return Wrench{{0, 2 * sample.mass}, 0}; });
  const BodyId ball = add(world, {0, 0}, smooth(make_disc(0.5)), 2);
  world.set_drag(ball, {.linear = 1, .quadratic = 0.5});
  for (int i = 0; i < 120 * 30; ++i) world.step(kH);
  EXPECT_NEAR(length(sum_of(world, ball).force), 0, 1e-9);
  EXPECT_NEAR(of(world, ball, ForceSource::Drag)[0].force.y, 2 * (9.81 - 2), 1e-9);
  EXPECT_EQ(of(world, ball, ForceSource::Field)[0].force, (Vec2{0, 4}));
}

/// Largest difference between the sum of the forces on a body and what its velocity says, relative to the
/// forces, in steps without collisions.
double worst_balance(unsigned seed, const char* stepper, double h, int& checked) {
  const test::RandomMechanism mechanism(seed);
  WorldConfig config;
  config.stepper = stepper;
  World world(config);
  const std::vector<BodyId> bodies = build(mechanism.recipe(), world);
  world.observe({.contacts = true});
  if (seed % 3 == 0) {
    world.set_force_field([](const FieldSample& s) {
      return Wrench{s.mass * Vec2{-s.position.x, std::sin(s.position.y)}, 0.1};
    });
  }
  double worst = 0;
  for (int i = 0; i < 0.4 / h; ++i) {
    std::vector<Vec2> before;
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      before.push_back(world.velocity(bodies[k]));
      const double phase = static_cast<double>(k) + 3 * world.time();
      if (world.mass(bodies[k]) > 0 && k % 2 == 0)
        world.apply_force(bodies[k], {2 * std::sin(phase), std::cos(phase)},
                          world.position(bodies[k]) + Vec2{0.1, 0.2});
    }
    const StepReport& report = world.step(h);
    // Velocities that do not fit the joints yet are a collision, too.
    if (i < 2 || report.impacts > 0 || report.contained > 0) continue;
    for (std::size_t k = 0; k < bodies.size(); ++k) {
      const double mass = world.mass(bodies[k]);
      if (!(mass > 0)) continue;
      double size = 1e-3 * mass;
      for (const BodyForce& force : forces_on(world, bodies[k])) size += length(force.force);
      const Vec2 change = mass / h * (world.velocity(bodies[k]) - before[k]);
      worst = std::max(worst, length(sum_of(world, bodies[k]).force - change) / size);
      ++checked;
    }
  }
  return worst;
}

TEST(BodyForces, OfRandomMechanismsAccountForTheirMotion) {
  for (const char* stepper : {"time_stepping", "event_driven"}) {
    int checked = 0;
    for (unsigned seed = 0; seed < 60; ++seed) {
      const double worst = worst_balance(seed, stepper, 1e-3, checked);
      EXPECT_LT(worst, 0.01) << stepper << ' ' << seed;
    }
    EXPECT_GT(checked, 10000) << stepper;
  }
}

/// A body that sleeps on the ground wakes and rises, and what rests on it falls.
TEST(BodyForces, OfGravityCanBeSetInTheRun) {
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  const BodyId box = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5), 2);
  for (int i = 0; i < 30; ++i) world.step(kH);
  ASSERT_TRUE(world.asleep(box));
  world.set_gravity_scale(box, -0.5);
  const double begin = world.time();
  for (int i = 0; i < 30; ++i) world.step(kH);
  const double t = world.time() - begin;
  EXPECT_NEAR(world.position(box).y, 0.5 + 0.25 * 9.81 * t * t, 1e-9);
  EXPECT_NEAR(world.kinetic_energy() + world.potential_energy(), -0.5 * 2 * 9.81 * 0.5, 1e-9);
  EXPECT_THROW(world.set_gravity_scale(box, NAN), std::invalid_argument);
}

TEST(BodyForces, AreTheSameAfterASnapshot) {
  World world;
  const BodyId box = add(world, {0, 0.5}, smooth(make_box({1, 1})), 1);
  world.apply_force(box, {3, 1}, {0, 0.8});
  world.step(kH);
  const World loaded = load_snapshot(save_snapshot(world));
  const std::vector<BodyForce> applied = of(loaded, box, ForceSource::Applied);
  ASSERT_EQ(applied.size(), 1u);
  EXPECT_EQ(applied[0].force, (Vec2{3, 1}));
  EXPECT_DOUBLE_EQ(applied[0].torque, -0.9);
  EXPECT_THROW(forces_on(world, BodyId{7, 0}), std::invalid_argument);
}

TEST(BodyForces, AHingeTurnsNeitherOfItsBodies) {
  World world;
  const BodyId a = add(world, {1, 0}, smooth(make_box({2, 0.1}))),
               b = add(world, {3, 0}, smooth(make_box({2, 0.1})));
  world.create_joint({.kind = JointKind::Revolute, .b = a, .anchor_a = {0, 0}, .anchor_b = {0, 0}});
  world.create_joint({.kind = JointKind::Revolute, .a = a, .b = b, .anchor_a = {2, 0}, .anchor_b = {2, 0}});
  for (int i = 0; i < 20; ++i) world.step(kH);
  for (const BodyId body : {a, b}) {
    const std::vector<BodyForce> hinges = of(world, body, ForceSource::Joint);
    EXPECT_EQ(hinges.size(), body == a ? 2u : 1u);
    for (const BodyForce& hinge : hinges) {
      EXPECT_GT(length(hinge.force), 0.1);
      EXPECT_NEAR(hinge.torque, 0, 1e-9);
    }
  }
}

TEST(BodyForces, WhatIsNewerThanTheStepFeltNoDrag) {
  World world;
  add(world, {0, 0}, smooth(make_disc(1)));
  world.step(0.01);
  const BodyId fresh = add(world, {5, 0}, smooth(make_disc(1)), 1, {3, 0});
  world.set_drag(fresh, {.linear = 2});
  for (const BodyForce& force : forces_on(world, fresh)) EXPECT_EQ(force.source, ForceSource::Weight);
}

}  // namespace body_forces_test
}  // namespace skerry
