// SPDX-License-Identifier: MIT
//
// Joints over long times, in loops, doubled, with extreme masses, and wrong ones.
#include <cmath>
#include <functional>
#include <gtest/gtest.h>

#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace joint_robust_test {

using test::add;
using test::smooth;
using test::weightless;

WorldConfig by(const std::string& stepper, WorldConfig config = {}) {
  config.stepper = stepper;
  return config;
}

class Mechanism : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(By, Mechanism, testing::Values("time_stepping", "event_driven"),
                         [](const auto& stepper) { return stepper.param; });

/// A small machine and how far its joints are off [m or rad].
struct Machine {
  const char* name;
  std::function<std::function<double()>(World&)> build;
};

double apart(const World& world, BodyId a, Vec2 local_a, BodyId b, Vec2 local_b) {
  return length(to_world(world.pose(a), local_a) - to_world(world.pose(b), local_b));
}

const Machine kMachines[] = {
    {"revolute",
     [](World& world) {
       const auto a = add(world, {0.5, 0}, smooth(make_box({1, 0.1})), 1);
       const auto b = add(world, {1.5, 0}, smooth(make_box({1, 0.1})), 2);
       world.create_joint({.b = a, .anchor_a = {0, 0}});
       world.create_joint({.a = a, .b = b, .anchor_a = {1, 0}});
       return [&world, a, b] {
         return std::max(length(to_world(world.pose(a), {-0.5, 0})), apart(world, a, {0.5, 0}, b, {-0.5, 0}));
       };
     }},
    {"rods",
     [](World& world) {
       const auto a = add(world, {1, 0}, smooth(make_disc(0.1)), 1);
       const auto b = add(world, {2, 1}, smooth(make_disc(0.1)), 2);
       const Vec2 la{0, 0.1};
       world.create_joint({.kind = JointKind::Distance, .b = a, .anchor_b = {1, 0}});
       world.create_joint(
           {.kind = JointKind::Distance, .a = a, .b = b, .anchor_a = Vec2{1, 0} + la, .anchor_b = {2, 1}});
       const double l = length(Vec2{1, 1} - la);
       return [&world, a, b, la, l] {
         const double first = std::abs(length(world.position(a)) - 1);
         return std::max(first, std::abs(apart(world, a, la, b, {0, 0}) - l));
       };
     }},
    {"prismatic on a swing",
     [](World& world) {
       const auto rail = add(world, {1, 0}, smooth(make_box({2, 0.1})), 3);
       const auto car = add(world, {1, 0.2}, smooth(make_box({0.3, 0.2})), 1);
       world.create_joint({.b = rail, .anchor_a = {0, 0}});
       const auto slider = world.create_joint({.kind = JointKind::Prismatic,
                                               .a = rail,
                                               .b = car,
                                               .anchor_a = {1, 0.2},
                                               .axis = {1, 0},
                                               .lower = -0.8,
                                               .upper = 0.8});
       return [&world, rail, car, slider] {
         const Vec2 local = to_local(world.pose(rail), world.position(car));
         const double beyond = std::max(0.0, std::abs(world.joint_position(slider)) - 0.8);
         return std::max({std::abs(local.y - 0.2), std::abs(world.angle(rail) - world.angle(car)), beyond,
                          length(to_world(world.pose(rail), {-1, 0}))});
       };
     }},
    {"welded pair on a hinge",
     [](World& world) {
       const auto a = add(world, {1, 0}, smooth(make_box({2, 0.1})), 3);
       const auto b = add(world, {2, 0.5}, smooth(make_box({0.1, 1})), 1);
       world.create_joint({.b = a, .anchor_a = {0, 0}});
       world.create_joint({.kind = JointKind::Weld, .a = a, .b = b, .anchor_a = {2, 0}});
       return [&world, a, b] {
         return std::max({apart(world, a, {1, 0}, b, {0, -0.5}), std::abs(world.angle(a) - world.angle(b)),
                          length(to_world(world.pose(a), {-1, 0}))});
       };
     }},
    {"wheel on a swing",
     [](World& world) {
       const auto frame = add(world, {1, 0}, smooth(make_box({2, 0.1})), 3);
       const auto wheel = add(world, {2, -0.5}, smooth(make_disc(0.2)), 1);
       world.create_joint({.b = frame, .anchor_a = {0, 0}});
       world.create_joint({.kind = JointKind::Wheel,
                           .a = frame,
                           .b = wheel,
                           .anchor_a = {2, -0.5},
                           .axis = {0, 1},
                           .stiffness = 500});
       return [&world, frame, wheel] {
         const Vec2 local = to_local(world.pose(frame), world.position(wheel));
         return std::max(std::abs(local.x - 1), length(to_world(world.pose(frame), {-1, 0})));
       };
     }},
    {"pulley with swinging ends",
     [](World& world) {
       const auto a = add(world, {-1.2, 0}, smooth(make_disc(0.1)), 2);
       const auto b = add(world, {1.5, 0}, smooth(make_disc(0.1)), 1.5);
       world.create_joint({.kind = JointKind::Pulley,
                           .a = a,
                           .b = b,
                           .anchor_a = {-1.2, 0},
                           .anchor_b = {1.5, 0},
                           .ratio = 1.5,
                           .pulley_a = {-1, 3},
                           .pulley_b = {1, 3}});
       // Neither end may reach its wheel, where the rope has no direction.
       for (const auto& [body, wheel] : {std::pair{a, Vec2{-1, 3}}, std::pair{b, Vec2{1, 3}}}) {
         const Vec2 at = world.position(body);
         world.create_joint(
             {.kind = JointKind::Distance, .b = body, .anchor_a = wheel, .anchor_b = at, .lower = 0.5});
       }
       const auto rope = [&world, a, b] {
         return length(world.position(a) - Vec2{-1, 3}) + 1.5 * length(world.position(b) - Vec2{1, 3});
       };
       return [rope, l = rope()] { return std::abs(rope() - l); };
     }},
    {"gears and rack",
     [](World& world) {
       const auto a = add(world, {0, 0}, smooth(make_disc(0.5)), 1);
       const auto b = add(world, {1, 0}, smooth(make_disc(0.4)), 1);
       const auto bar = add(world, {1.4, 0}, smooth(make_box({0.1, 2})), 1);
       world.create_joint({.b = a, .anchor_a = {0, 0}});
       world.create_joint({.b = b, .anchor_a = {1, 0}});
       world.create_joint({.kind = JointKind::Prismatic, .b = bar, .axis = {0, 1}, .stiffness = 30});
       world.create_joint({.kind = JointKind::Gear, .a = a, .b = b, .ratio = 1.25});
       world.create_joint({.kind = JointKind::Rack, .a = b, .b = bar, .axis = {0, 1}, .ratio = 0.4});
       return [&world, a, b, bar] {
         return std::max({std::abs(world.angle(b) + 1.25 * world.angle(a)),
                          std::abs(world.position(bar).y - 0.4 * world.angle(b)), length(world.position(a)),
                          std::abs(world.position(bar).x - 1.4)});
       };
     }},
};

TEST_P(Mechanism, DoesNotDrift) {
  // With SKERRY_TEST_SCALE=100: 2e4 steps event-driven, 1e5 time-stepping.
  for (const Machine& machine : kMachines) {
    World world(by(GetParam()));
    const std::function<double()> error = machine.build(world);
    ASSERT_LT(error(), 1e-15) << machine.name;
    double worst = 0;
    const int steps = test_scale(GetParam() == "event_driven" ? 200 : 1000);
    for (int i = 0; i < steps; ++i) {
      world.step(1.0 / 60);
      worst = std::max(worst, error());
    }
    EXPECT_LT(worst, 1e-10) << machine.name;
    EXPECT_GT(world.kinetic_energy(), 1e-3) << machine.name << " must move to be a test";
  }
}

TEST_P(Mechanism, ThatIsFreeKeepsMomentumAndAngularMomentum) {
  World world(by(GetParam(), weightless()));
  std::vector<BodyId> links;
  for (int i = 0; i < 5; ++i) {
    links.push_back(
        add(world, {i + 0.5, 0}, smooth(make_box({1, 0.1})), 1 + i, {0.1 * i, 1.0 * i - 2}, 1.0 * i));
    if (i == 0) continue;
    JointDef def{.kind = i == 2 ? JointKind::Prismatic : JointKind::Revolute,
                 .a = links[i - 1],
                 .b = links[i],
                 .anchor_a = {static_cast<double>(i), 0}};
    def.stiffness = 5;
    if (i == 3) def.motor_speed = 2, def.motor_limit = 0.5;
    world.create_joint(def);
  }
  world.step(1.0 / 240);  // the velocities that were given do not fit the joints
  const Vec2 momentum = world.momentum();
  const double angular = world.angular_momentum();
  for (int i = 0; i < 240; ++i) world.step(1.0 / 240);
  EXPECT_NEAR(world.momentum().x, momentum.x, 1e-11);
  EXPECT_NEAR(world.momentum().y, momentum.y, 1e-11);
  // Velocity level constraints act along rows of the midpoint; their moments cancel to second order only in
  // time stepping.
  EXPECT_NEAR(world.angular_momentum(), angular, GetParam() == "event_driven" ? 1e-10 : 2e-2);
}

TEST_P(Mechanism, FourBarLoopWithDoubledConstraintsRuns) {
  // A parallelogram of welded and doubled joints: 3 moving bars, one degree of freedom, 8 revolute rows for
  // 8 unknowns, and each of them twice.
  World once(by(GetParam())), twice(by(GetParam()));
  std::vector<BodyId> bars;
  for (World* world : {&once, &twice}) {
    // It hangs, and does not swing as far as to its dead points, where it could go on in two ways.
    bars = {add(*world, {0, -0.5}, smooth(make_box({0.1, 1})), 1),
            add(*world, {1, -1}, smooth(make_box({2, 0.1})), 1),
            add(*world, {2, -0.5}, smooth(make_box({0.1, 1})), 1)};
    world->set_velocity(bars[1], {1, 0}, 0);
    world->set_velocity(bars[0], {0.5, 0}, 1);
    world->set_velocity(bars[2], {0.5, 0}, 1);
    for (int k = 0; k < (world == &twice ? 2 : 1); ++k) {
      world->create_joint({.b = bars[0], .anchor_a = {0, 0}});
      world->create_joint({.a = bars[0], .b = bars[1], .anchor_a = {0, -1}});
      world->create_joint({.a = bars[1], .b = bars[2], .anchor_a = {2, -1}});
      world->create_joint({.b = bars[2], .anchor_a = {2, 0}});
    }
  }
  for (int i = 0; i < 60; ++i) {
    once.step(1.0 / 60);
    const StepReport& report = twice.step(1.0 / 60);
    EXPECT_EQ(report.inexact_islands, 0) << i;
    EXPECT_EQ(report.fallbacks, 0) << i;
    ASSERT_NEAR(length(once.position(bars[1]) - twice.position(bars[1])), 0, 1e-8) << i;
    ASSERT_NEAR(apart(twice, bars[0], {0, -0.5}, bars[1], {-1, 0}), 0, 1e-11) << i;
  }
}

TEST_P(Mechanism, TwoWeldsOnOnePairAreAsGoodAsOne) {
  World world(by(GetParam()));
  const auto a = add(world, {0.5, 0}, smooth(make_box({1, 0.2})), 1);
  const auto b = add(world, {1.5, 0}, smooth(make_box({1, 0.2})), 1);
  world.create_joint({.b = a, .anchor_a = {0, 0}});
  world.create_joint({.kind = JointKind::Weld, .a = a, .b = b, .anchor_a = {1, 0}});
  world.create_joint({.kind = JointKind::Weld, .a = a, .b = b, .anchor_a = {1, 0.1}});
  const double begin = world.kinetic_energy() + world.potential_energy();
  for (int i = 0; i < 120; ++i) {
    world.step(1.0 / 120);
    ASSERT_NEAR(world.angle(a), world.angle(b), 1e-11);
    ASSERT_EQ(world.report().inexact_islands, 0);
  }
  EXPECT_NEAR(world.kinetic_energy() + world.potential_energy(), begin,
              GetParam() == "event_driven" ? 1e-9 : 1e-2);
}

TEST_P(Mechanism, HeavyLoadHangsFromLightLinks) {
  for (const double ratio : {1e3, 1e6}) {
    World world(by(GetParam()));
    std::vector<BodyId> links;
    for (int i = 0; i < 5; ++i) {
      const double mass = i == 4 ? ratio : 1;
      links.push_back(add(world, {0, -i - 0.5}, smooth(make_box({0.1, 1})), mass));
      JointDef def{.b = links.back(), .anchor_a = {0, -1.0 * i}};
      if (i > 0) def.a = links[i - 1];
      world.create_joint(def);
    }
    for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
    EXPECT_NEAR(world.position(links[4]).y, -4.5, 1e-10) << ratio;
    EXPECT_NEAR(world.joints()[0].impulse.y * 60 / (9.81 * (ratio + 4)), 1, 1e-9) << ratio;
    // And it swings without leaving its links.
    const double begin = world.potential_energy();
    world.apply_impulse(links[4], {ratio, 0}, world.position(links[4]));
    // At 1e6 the links' shaking (1e4 rad/s) is below what 1e-13 of accuracy can see: time stepping takes
    // over.
    const int steps = GetParam() == "event_driven" && ratio == 1e6 ? 2 : 60;
    for (int i = 0; i < steps; ++i) world.step(1.0 / 60);
    for (int i = 0; i < 4; ++i)
      EXPECT_NEAR(apart(world, links[i], {0, -0.5}, links[i + 1], {0, 0.5}), 0, 1e-10);
    EXPECT_NEAR(world.kinetic_energy() + world.potential_energy() - begin, 0.5 * ratio, 2e-3 * ratio);
  }
}

TEST_P(Mechanism, LosesTheJointsOfADestroyedBody) {
  World world(by(GetParam()));
  const auto a = add(world, {0, -1}, smooth(make_disc(0.1)), 1);
  const auto b = add(world, {0, -2}, smooth(make_disc(0.1)), 1);
  const auto upper = world.create_joint({.kind = JointKind::Weld, .b = a});
  const auto lower = world.create_joint({.kind = JointKind::Weld, .a = a, .b = b, .anchor_a = {0, -1}});
  world.step(1.0 / 60);
  world.destroy(a);
  EXPECT_FALSE(world.alive(upper));
  EXPECT_FALSE(world.alive(lower));
  EXPECT_THROW(world.joint_force(lower), std::invalid_argument);
  for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
  EXPECT_NEAR(world.position(b).y, -2 - 0.5 * 9.81, 1e-9);
}

TEST(JointDefinition, ThatMeansNothingIsRefusedWithItsValue) {
  World world;
  const auto ball = add(world, {0, -1}, smooth(make_disc(0.1)));
  const auto other = add(world, {1, -1}, smooth(make_disc(0.1)));
  const auto refused = [&](JointDef def, const std::string& why) {
    def.a = def.a ? def.a : other;
    def.b = ball;
    try {
      world.create_joint(def);
      ADD_FAILURE() << "accepted: " << why;
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  };
  refused({.a = ball}, "both ends");
  refused({.kind = JointKind::Prismatic, .axis = {0, 0}}, "axis must not be zero");
  refused({.kind = JointKind::Prismatic, .axis = {NAN, 0}}, "axis must be finite");
  refused({.kind = JointKind::Wheel, .anchor_a = {NAN, 0}}, "anchor_a must be finite");
  refused({.kind = JointKind::Distance}, "length must be positive, got 0");
  refused({.break_force = -1}, "break_force must be >= 0, got -1");
  refused({.break_torque = NAN}, "break_torque must be >= 0, got nan");
  refused({.motor_speed = 1, .motor_limit = -2}, "motor_limit must be >= 0, got -2");
  refused({.kind = JointKind::Weld, .lower = 0}, "a weld joint has no limits");
  refused({.kind = JointKind::Rope, .length = 1, .motor_speed = 1}, "a rope joint has no motor");
  refused({.kind = JointKind::Gear, .stiffness = 1}, "a gear joint has no spring");
  refused({.kind = JointKind::Rack, .length = 1}, "a rack joint has no length");
  refused({.kind = JointKind::Gear, .ratio = 0}, "ratio must not be 0");
  refused({.kind = JointKind::Pulley, .ratio = -1}, "ratio must be positive, got -1");
  refused({.kind = JointKind::Gear, .ratio = NAN}, "ratio must not be 0, got nan");
  refused({.kind = JointKind::Revolute, .lower = 1, .upper = -1},
          "must not exceed the upper one, got 1 and -1");
  refused({.kind = JointKind::Weld, .lower = 1}, "no limits");
  refused({.kind = JointKind::Weld, .stiffness = 1}, "no spring");
  refused({.kind = JointKind::Gear, .motor_speed = 1}, "no motor");
  refused({.kind = JointKind::Motor}, "motor_speed must be given");
  refused({.kind = JointKind::Motor, .motor_speed = 1, .motor_limit = -2}, "must be >= 0, got -2");
  refused({.kind = JointKind::Spring}, "stiffness or damping must be positive");
  refused({.kind = JointKind::Spring, .stiffness = -1}, "must be finite and >= 0, got -1");
  refused({.kind = JointKind::Revolute, .break_force = NAN}, "must be >= 0, got nan");
  EXPECT_TRUE(world.joints().empty());
  world.destroy(other);
  refused({.a = other}, "does not exist");
}

/// What is joined while it moves, or given another velocity, obeys its joints at once, and not half-way
/// through the step: two discs on a rod turn about their middle with the part of their velocities that the
/// rod allows.
TEST_P(Mechanism, WhatIsGivenAVelocityObeysItsJointsAtOnce) {
  World world(by(GetParam(), weightless()));
  const BodyId a = add(world, {0, 0}, smooth(make_disc(0.1)), 1, {1, -9});
  const BodyId b = add(world, {1, 0.5}, smooth(make_disc(0.1)), 1, {-7, 4});
  world.create_joint({.kind = JointKind::Distance, .a = a, .b = b, .anchor_a = {0, 0}, .anchor_b = {1, 0.5}});
  Vec2 middle{0.5, 0.25}, d{1, 0.5}, v{-3, -2.5}, apart{-8, 13};
  for (int part = 0; part < 2; ++part) {
    const double r = length(d), omega = cross(d, apart) / (r * r);
    for (int k = 1; k <= 30; ++k) {
      world.step(1.0 / 60);
      ASSERT_NEAR(world.kinetic_energy(), length_squared(v) + 0.25 * omega * omega * r * r, 1e-9) << k;
    }
    middle += 0.5 * v;
    d = rotate(Rot::from_angle(0.5 * omega), d);
    EXPECT_LT(length(0.5 * (world.position(a) + world.position(b)) - middle), 1e-9);
    EXPECT_LT(length(world.position(b) - world.position(a) - d), GetParam() == "event_driven" ? 1e-9 : 0.04);
    // Once more, in motion.
    middle = 0.5 * (world.position(a) + world.position(b));
    d = world.position(b) - world.position(a);
    v = {1, 1.5};
    apart = {3, -6};
    world.set_velocity(a, v - 0.5 * apart, 0);
    world.set_velocity(b, v + 0.5 * apart, 0);
  }
}

/// A blow cuts the step: the rods swing on with forces of what is left of it, not of the whole.
TEST_P(Mechanism, NewtonsCradleKeepsItsEnergy) {
  World world(by(GetParam()));
  constexpr int count = 5;
  const double radius = 0.5, length = 3;
  for (int i = 0; i < count; ++i) {
    const double angle = i == 0 ? 0.8 : 0;
    const Vec2 top{2 * radius * i, length};
    const Vec2 at = top - length * Vec2{std::sin(angle), std::cos(angle)};
    const BodyId ball = add(world, at, smooth(make_disc(radius), 1), 1);
    world.create_joint({.kind = JointKind::Distance, .b = ball, .anchor_a = top, .anchor_b = at});
  }
  const double start = world.kinetic_energy() + world.potential_energy();
  int impacts = 0;
  for (int k = 0; k < 600; ++k) {
    impacts += world.step(1.0 / 60).impacts;
    ASSERT_NEAR(world.kinetic_energy() + world.potential_energy(), start, 1e-11) << "step " << k;
  }
  EXPECT_GT(impacts, 4);
}

}  // namespace joint_robust_test
}  // namespace skerry
