// SPDX-License-Identifier: MIT
#include <cmath>
#include <gtest/gtest.h>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tests/support/worlds.h"

namespace skerry {
namespace joint_test {

using test::add;
using test::smooth;
using test::weightless;

TEST(Distance, PendulumKeepsItsLengthAndEnergyAndItsSmallPeriod) {
  World world;
  const double amplitude = 0.05;
  const double rod = 1;
  const auto ball =
      add(world, {rod * std::sin(amplitude), -rod * std::cos(amplitude)}, smooth(make_disc(0.1)), 2);
  world.create_joint(
      {.kind = JointKind::Distance, .b = ball, .anchor_a = {0, 0}, .anchor_b = world.position(ball)});
  const double energy = world.kinetic_energy() + world.potential_energy();
  int crossings = 0;
  double first = 0, last = 0, before = world.position(ball).x;
  for (int i = 0; i < 1200; ++i) {
    world.step(1.0 / 120);
    const double now = world.position(ball).x;
    if (before > 0 && now <= 0) {
      last = world.time() - now / (now - before) / 120;
      if (crossings++ == 0) first = last;
    }
    before = now;
    ASSERT_NEAR(length(world.position(ball)), rod, 1e-12);
  }
  const double period = 2 * kPi * std::sqrt(rod / 9.81) * (1 + amplitude * amplitude / 16);
  EXPECT_NEAR((last - first) / (crossings - 1), period, 2e-4 * period);
  EXPECT_NEAR(world.kinetic_energy() + world.potential_energy(), energy,
              1e-4 * 2 * 9.81 * amplitude * amplitude);
}

TEST(Prismatic, HoldsAlongAnAxisOfAnyLength) {
  for (const double size : {1.0, 1e200, 1e-170, 5e-324}) {
    World world;
    const auto box = add(world, {0, 5}, smooth(make_box({1, 1})));
    world.create_joint({.kind = JointKind::Prismatic, .b = box, .anchor_a = {0, 5}, .axis = {size, 0}});
    for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
    EXPECT_NEAR(world.position(box).y, 5, 1e-9) << size;
  }
}

TEST(Distance, KeepsItsLengthWhenItIsGivenAnotherDefinitionWithoutOne) {
  World world(weightless());
  const auto ball = add(world, {0, 0}, smooth(make_disc(0.1)), 1, {1, 0});
  const JointId rod = world.create_joint({.kind = JointKind::Distance, .b = ball, .length = 1});
  world.set_joint(rod, {.kind = JointKind::Distance, .b = ball, .break_force = 1e6});
  for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
  EXPECT_NEAR(length(world.position(ball)), 1, 1e-9);
  EXPECT_EQ(world.joints()[rod.index].length, 1);
}

TEST(Distance, ReactionOfAHangingBallIsItsWeight) {
  World world;
  const auto ball = add(world, {0, -1}, smooth(make_disc(0.1)), 3);
  const auto rod = world.create_joint({.kind = JointKind::Distance, .b = ball, .anchor_b = {0, -1}});
  for (int i = 0; i < 10; ++i) world.step(1.0 / 60);
  EXPECT_NEAR(world.joints()[rod.index].impulse.y * 60, 3 * 9.81, 1e-10);
  EXPECT_NEAR(world.joints()[rod.index].impulse.x, 0, 1e-14);
  EXPECT_NEAR(world.position(ball).y, -1, 1e-14);
}

TEST(Revolute, RodSwingsLikeAPhysicalPendulum) {
  World world;
  const auto rod = add(world, {0.5, 0}, smooth(make_box({1, 0.01})), 1);
  world.create_joint({.kind = JointKind::Revolute, .b = rod, .anchor_a = {0, 0}});
  for (int i = 0; i < 240; ++i) {
    world.step(1.0 / 240);
    ASSERT_NEAR(length(world.position(rod)), 0.5, 1e-11);
    // Energy of a rod about its end: I w^2 / 2 = m g drop.
    const double inertia = world.inertia(rod) + 0.25;
    const double w = world.omega(rod);
    ASSERT_NEAR(0.5 * inertia * w * w, -9.81 * world.position(rod).y, 2e-3);
  }
}

TEST(Revolute, ChainOfLinksHangsWithoutDrift) {
  World world;
  std::vector<BodyId> links;
  for (int i = 0; i < 20; ++i) {
    links.push_back(add(world, {i + 0.5, 0}, smooth(make_box({1, 0.1})), 1));
    JointDef def{.kind = JointKind::Revolute, .b = links.back(), .anchor_a = {static_cast<double>(i), 0}};
    if (i > 0) def.a = links[i - 1];
    world.create_joint(def);
  }
  for (int i = 0; i < 300; ++i) world.step(1.0 / 120);
  for (std::size_t i = 0; i + 1 < links.size(); ++i) {
    const Vec2 end = to_world(world.pose(links[i]), {0.5, 0});
    const Vec2 begin = to_world(world.pose(links[i + 1]), {-0.5, 0});
    EXPECT_NEAR(length(end - begin), 0, 1e-11) << i;
  }
}

TEST(Rope, LetsTheBallFallUntilItIsTautAndHoldsItThen) {
  World world;
  const auto ball = add(world, {0, -0.5}, smooth(make_disc(0.05)), 1);
  world.create_joint({.kind = JointKind::Rope, .b = ball, .anchor_b = {0, -0.5}, .length = 1.0});
  for (int i = 0; i < 12; ++i) world.step(1.0 / 60);
  EXPECT_NEAR(world.position(ball).y, -0.5 - 0.5 * 9.81 * 0.04, 1e-11);
  for (int i = 0; i < 120; ++i) {
    world.step(1.0 / 60);
    ASSERT_GE(world.position(ball).y, -1 - 1e-9);
  }
  EXPECT_NEAR(world.position(ball).y, -1, 1e-9);
  EXPECT_NEAR(world.velocity(ball).y, 0, 1e-9);
}

TEST(Cradle, HangingFromRodsPassesTheSwingToTheLastBall) {
  World world;
  const double angle = 0.5;
  std::vector<BodyId> balls;
  for (int i = 0; i < 5; ++i) {
    const Vec2 pivot{static_cast<double>(i), 0};
    const Vec2 at = i == 0 ? pivot + 4.0 * Vec2{-std::sin(angle), -std::cos(angle)} : pivot + Vec2{0, -4};
    balls.push_back(add(world, at, smooth(make_disc(0.5), 1)));
    world.create_joint({.kind = JointKind::Distance, .b = balls.back(), .anchor_a = pivot, .anchor_b = at});
  }
  const double energy = world.kinetic_energy() + world.potential_energy();
  double highest = -4;
  for (int i = 0; i < 240; ++i) {
    world.step(1.0 / 60);
    highest = std::max(highest, world.position(balls[4]).y);
    for (int k = 1; k < 4; ++k) ASSERT_NEAR(world.position(balls[k]).x, k, 2e-2) << "step " << i;
  }
  EXPECT_NEAR(highest, -4 * std::cos(angle), 2e-3);
  EXPECT_NEAR(world.kinetic_energy() + world.potential_energy(), energy, 1e-3 * 9.81);
}

TEST(Spring, HasTheEnergyOfTheStiffnessThatItIsGivenLater) {
  World world(weightless());
  const auto ball = add(world, {3, 0}, smooth(make_disc(0.1)));
  JointDef def{.kind = JointKind::Spring,
               .b = ball,
               .anchor_a = {0, 0},
               .anchor_b = {3, 0},
               .length = 2,
               .damping = 1};
  const JointId spring = world.create_joint(def);
  EXPECT_EQ(world.spring_energy(), 0);
  def.stiffness = 10;
  world.set_joint(spring, def);
  EXPECT_NEAR(world.spring_energy(), 5, 1e-12);
  def.stiffness = 0;
  world.set_joint(spring, def);
  EXPECT_EQ(world.spring_energy(), 0);
}

TEST(Rack, HasAnAxisOfTheWorldHoweverItsWheelIsTurned) {
  World world(weightless());
  const auto wheel = add(world, {0, 0}, smooth(make_disc(0.5)), 1, {}, 0, kPi / 2);
  const auto rack = add(world, {0, -1}, smooth(make_box({4, 0.2})), 1, {2, 0});
  const JointId joint = world.create_joint({.kind = JointKind::Rack,
                                            .a = wheel,
                                            .b = rack,
                                            .anchor_a = {0, 0},
                                            .anchor_b = {0, -1},
                                            .axis = {1, 0},
                                            .ratio = 0.5});
  EXPECT_NEAR(std::abs(world.joint_speed(joint)), 2, 1e-12);
}

TEST(Joints, TakeThePlaceOfDestroyedOnesUnderNewNames) {
  World world;
  const auto ball = add(world, {3, 0}, smooth(make_disc(0.1)));
  const JointDef def{.kind = JointKind::Rope, .b = ball, .anchor_a = {0, 0}, .anchor_b = {3, 0}};
  const JointId one = world.create_joint(def), two = world.create_joint(def), three = world.create_joint(def);
  for (const JointId id : {three, one, two}) world.destroy(id);
  const JointId fresh = world.create_joint(def);
  EXPECT_EQ(fresh.index, one.index);
  EXPECT_TRUE(world.alive(fresh));
  EXPECT_FALSE(world.alive(one));
  EXPECT_THROW((void)world.joint_force(one), std::invalid_argument);
}

TEST(Joints, BadOnesAreRefused) {
  World world;
  const auto ball = add(world, {0, -1}, smooth(make_disc(0.1)));
  EXPECT_THROW(world.create_joint({.kind = JointKind::Distance, .b = ball}), std::invalid_argument);
  EXPECT_THROW(world.create_joint({.a = ball, .b = ball}), std::invalid_argument);
  EXPECT_THROW(world.create_joint({.a = ball}), std::invalid_argument);
  EXPECT_THROW(world.create_joint({.kind = JointKind::Rope, .b = ball, .anchor_b = {0, -1}, .length = NAN}),
               std::invalid_argument);
}

TEST(Distance, SpringsAreInTheEnergyOfTheReport) {
  World world;
  const BodyId ball = add(world, {0, -1.5}, smooth(make_disc(0.1)), 2);
  JointDef spring{.kind = JointKind::Distance, .b = ball, .anchor_b = {0, -1.5}};
  spring.length = 1;
  spring.stiffness = 40;
  world.create_joint(spring);
  for (int i = 0; i < 30; ++i) {
    const StepReport& report = world.step(1.0 / 120);
    const double y = world.position(ball).y, stretch = -y - 1;
    EXPECT_NEAR(report.potential_energy, 2 * 9.81 * y + 20 * stretch * stretch, 1e-12) << i;
    EXPECT_NEAR(report.potential_energy, world.potential_energy(), 1e-12) << i;
  }
}

TEST(Revolute, LetsItsBodiesOverlapWhicheverIsTheFirst) {
  for (const bool exchanged : {false, true}) {
    World world(weightless());
    BodyId a = add(world, {0, 0}, smooth(make_box({1, 0.2}))),
           b = add(world, {0.8, 0}, smooth(make_box({1, 0.2})));
    if (exchanged) std::swap(a, b);
    world.create_joint({.kind = JointKind::Revolute, .a = a, .b = b, .anchor_a = {0.4, 0}});
    for (int i = 0; i < 10; ++i) EXPECT_EQ(world.step(1.0 / 60).contacts, 0) << exchanged;
    EXPECT_EQ(world.kinetic_energy(), 0);
  }
}

}  // namespace joint_test
}  // namespace skerry
