// SPDX-License-Identifier: MIT
//
// Surfaces, filters and joints that are given another definition while the world runs: what follows is what
// formulas say of the new one, and what slept wakes.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "physics/snapshot.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace changed_definitions_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;
using test::weightless;

constexpr double kStep = 1.0 / 60, kG = 9.81;

class ChangedDefinitions : public testing::TestWithParam<const char*> {
 protected:
  static World make_world(WorldConfig config = {}) {
    config.stepper = GetParam();
    return World(config);
  }
};

void run(World& world, int steps) {
  for (int i = 0; i < steps; ++i) world.step(kStep);
}

ShapeId shape_of(const World& world, BodyId body) {
  const auto shapes = world.shapes();
  const auto found = std::find_if(shapes.begin(), shapes.end(),
                                  [&](const ShapeRecord& s) { return s.alive && s.body == body; });
  return {static_cast<std::uint32_t>(found - shapes.begin()), found->generation};
}

void set_material(World& world, BodyId body, const Material& material) {
  world.set_material(shape_of(world, body), material);
}

const JointDef& definition(const World& world, JointId joint) {
  return world.joints()[joint.index].def;
}

TEST_P(ChangedDefinitions, AnotherFrictionBrakesOtherwise) {
  World world = make_world();
  const BodyId ground = add_ground(world, rough(make_disc(1), 0.5));
  const BodyId box = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5), 2, {8, 0});
  run(world, 30);
  EXPECT_NEAR(world.velocity(box).x, 8 - 0.5 * kG * 0.5, 1e-9);
  set_material(world, ground, {.friction = 0.02});
  set_material(world, box, {.friction = 0.5});
  const double mixed = mix(MixingRule::GeometricMean, 0.02, 0.5), before = world.velocity(box).x;
  run(world, 30);
  EXPECT_NEAR(world.velocity(box).x, before - mixed * kG * 0.5, 1e-9);
}

TEST_P(ChangedDefinitions, ABeltThatIsSwitchedOnCarriesWhatSleptOnIt) {
  for (const bool sleep : {true, false}) {
    World world = make_world({.sleep = sleep});
    const BodyId ground = add_ground(world, rough(make_disc(1), 0.5));
    const BodyId box = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5), 2);
    run(world, 120);
    ASSERT_EQ(world.asleep(box), sleep);
    // Counter-clockwise around the half-plane is to the left; it slips for 3 / (mu g) = 0.61 s.
    set_material(world, ground, {.friction = 0.5, .surface_velocity = 3});
    run(world, 30);
    EXPECT_NEAR(world.velocity(box).x, -0.5 * kG * 0.5, 1e-9) << sleep;
    run(world, 30);
    EXPECT_NEAR(world.velocity(box).x, -3, 1e-9) << sleep;
    set_material(world, ground, {.friction = 0.5});
    run(world, 60);
    EXPECT_NEAR(world.velocity(box).x, 0, 1e-9) << sleep;
  }
}

TEST_P(ChangedDefinitions, WhatSleepsOnASlopeSlidesWhenItGetsSmooth) {
  const double slope = 0.4;
  World world = make_world();
  const BodyId ground = add_ground(world, rough(make_disc(1), 0.6), slope);
  const BodyId box =
      add(world, rotate(Rot::from_angle(slope), Vec2{0, 0.5}), rough(make_box({1, 1}), 0.6), 2, {}, 0, slope);
  run(world, 120);
  ASSERT_TRUE(world.asleep(box));
  set_material(world, ground, {.friction = 0.2});
  set_material(world, box, {.friction = 0.2});
  run(world, 60);
  EXPECT_NEAR(length(world.velocity(box)), kG * (std::sin(slope) - 0.2 * std::cos(slope)), 1e-9);
}

TEST_P(ChangedDefinitions, WhatRestsElsewhereGoesOnResting) {
  World world = make_world({.sleep = false});
  const BodyId ground = add_ground(world, rough(make_disc(1), 0.5));
  std::vector<BodyId> boxes;
  for (int k = 0; k < 8; ++k) boxes.push_back(add(world, {2.0 * k, 0.5}, rough(make_box({1, 1}), 0.5), 2));
  const JointId rod = world.create_joint({.kind = JointKind::Distance,
                                          .a = boxes[0],
                                          .b = boxes[1],
                                          .anchor_a = {0, 0.5},
                                          .anchor_b = {2, 0.5}});
  run(world, 60);
  const auto expect_rest = [&](const char* what) {
    run(world, 3);
    EXPECT_EQ(world.report().islands, 7) << what;
    EXPECT_EQ(world.kinetic_energy(), 0) << what;
    for (const BodyId box : boxes) EXPECT_NEAR(world.position(box).y, 0.5, 1e-12) << what;
  };
  expect_rest("before");
  // Each box is an island; what is known of the others was found with the old surface, too.
  set_material(world, boxes[3], {.friction = 0.2});
  expect_rest("the surface of a box");
  JointDef softer = definition(world, rod);
  softer.break_force = 1000;
  world.set_joint(rod, softer);
  expect_rest("a joint");
  world.set_accuracy(1e-6);
  expect_rest("the accuracy");
  set_material(world, ground, {.friction = 0.4});
  expect_rest("the surface of the ground");
}

TEST_P(ChangedDefinitions, AnotherRestitutionBouncesOtherwise) {
  World world = make_world();
  const BodyId ground = add_ground(world, smooth(make_disc(1), 0));
  const BodyId ball = add(world, {0, 2}, smooth(make_disc(0.5), 0));
  run(world, 10);
  set_material(world, ground, {.friction = 0, .restitution = 0.8});
  double fastest = 0;
  for (int i = 0; i < 60; ++i) {
    world.step(kStep);
    fastest = std::max(fastest, world.velocity(ball).y);
  }
  // Time stepping finds the impact within its step; at the end of it the ball has been slowed for less than
  // that.
  const double exact = 0.8 * std::sqrt(2 * kG * 1.5);
  EXPECT_LE(fastest, exact + 1e-9);
  EXPECT_GT(fastest, exact - kG * kStep);
}

TEST_P(ChangedDefinitions, WhatMeansNothingIsRefusedAndChangesNothing) {
  World world = make_world();
  const BodyId ground = add_ground(world, rough(make_disc(1), 0.5));
  const ShapeId shape = shape_of(world, ground);
  const auto refused = [&](const Material& material) {
    try {
      world.set_material(shape, material);
    } catch (const std::invalid_argument& error) {
      EXPECT_EQ(world.shapes()[shape.index].material.friction, 0.5);
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  EXPECT_EQ(refused({.friction = -1}), "friction must be finite and >= 0, got -1");
  EXPECT_EQ(refused({.friction = 0.5, .restitution = 2}), "restitution must be between 0 and 1, got 2");
  EXPECT_EQ(refused({.friction = 0.5, .static_friction = 0.25}),
            "static_friction must be finite and at least friction, got 0.25 and 0.5");
  EXPECT_EQ(refused({.surface_velocity = std::nan("")}), "surface_velocity must be finite, got nan");
  world.destroy(shape);
  EXPECT_THROW(world.set_material(shape, {}), std::invalid_argument);
  EXPECT_THROW(world.set_filter(shape, {}), std::invalid_argument);
}

TEST_P(ChangedDefinitions, WhatNoLongerMeetsFallsAndWhatMeetsAgainLandsWithEveryBroadPhase) {
  for (const BroadPhaseEntry& broad_phase : broad_phases()) {
    for (const bool sleep : {true, false}) {
      const std::string which = std::string(broad_phase.name) + (sleep ? ", asleep" : ", awake");
      World world = make_world({.broad_phase = std::string(broad_phase.name), .sleep = sleep});
      add_ground(world, rough(make_disc(1), 0.5));
      const BodyId shelf = world.create_body({.type = BodyType::Static, .position = {0, 5}});
      world.add_shape(shelf, rough(make_box({4, 1}), 0.5));
      const BodyId box = add(world, {0, 6}, rough(make_box({1, 1}), 0.5), 2);
      run(world, 120);
      ASSERT_EQ(world.asleep(box), sleep) << which;
      world.set_filter(shape_of(world, shelf), {.mask = 0});
      EXPECT_EQ(world.shapes_at({0, 5}).size(), 0u) << which;
      EXPECT_EQ(world.shapes_at({0, 6}).size(), 1u) << which;
      run(world, 30);
      EXPECT_NEAR(world.position(box).y, 6 - 0.5 * kG * 0.25, 1e-9) << which;
      // Within the shelf still: it is pushed out of it.
      world.set_filter(shape_of(world, shelf), {});
      EXPECT_EQ(world.shapes_at({0, 5}).size(), 2u) << which;
      run(world, 180);
      EXPECT_LT(world.report().worst_penetration, 1e-9) << which;
      EXPECT_LT(length(world.velocity(box)), 1e-9) << which;
    }
  }
}

TEST_P(ChangedDefinitions, AFilterWorksBothWaysBetweenBodiesThatMove) {
  World world = make_world(weightless());
  const BodyId left = add(world, {0, 0}, smooth(make_disc(0.5), 1), 1, {1, 0});
  const BodyId right = add(world, {3, 0}, smooth(make_disc(0.5), 1));
  for (const BodyId body : {left, right}) world.set_filter(shape_of(world, body), {.group = -1});
  run(world, 150);
  EXPECT_EQ(world.velocity(left), (Vec2{1, 0}));
  // They overlap by half, and are taken apart without a blow.
  world.set_pose(left, {0, 0}, 0);
  run(world, 10);
  world.set_filter(shape_of(world, right), {});
  run(world, 150);
  EXPECT_NEAR(world.velocity(left).x, 0, 1e-12);
  EXPECT_NEAR(world.velocity(right).x, 1, 1e-12);
}

/// A joint whose bodies do not touch each other takes them apart, though both are at rest; without it they
/// meet.
TEST_P(ChangedDefinitions, JointsSayWhetherBodiesAtRestTouch) {
  for (const bool sleep : {true, false}) {
    World world = make_world({.sleep = sleep});
    const BodyId shelf = world.create_body({.type = BodyType::Static, .position = {0, 5}});
    world.add_shape(shelf, rough(make_box({4, 1}), 0.5));
    const BodyId box = add(world, {0, 6}, rough(make_box({1, 1}), 0.5), 2);
    run(world, 120);
    ASSERT_EQ(world.asleep(box), sleep);
    JointDef def{
        .kind = JointKind::Rope, .a = shelf, .b = box, .anchor_a = {0, 7}, .anchor_b = {0, 6}, .length = 4};
    def.collide = true;
    const JointId rope = world.create_joint(def);
    run(world, 60);
    EXPECT_NEAR(world.position(box).y, 6, 1e-9) << sleep;
    def.collide = false;
    world.set_joint(rope, def);
    run(world, 20);
    EXPECT_NEAR(world.position(box).y, 6 - 0.5 * kG / 9, 1e-9) << sleep;
    run(world, 240);
    EXPECT_NEAR(world.position(box).y, 3, 1e-6) << sleep;
    ASSERT_EQ(world.asleep(box), sleep);
    // Hung up within the shelf, and cut down there.
    def.length = 2.25;
    world.set_joint(rope, def);
    run(world, 240);
    EXPECT_NEAR(world.position(box).y, 4.75, 1e-6) << sleep;
    world.destroy(rope);
    run(world, 60);
    for (const ShapeId shape : world.shapes_at({0, 5})) EXPECT_EQ(shape.index, shape_of(world, shelf).index);
    EXPECT_LT(world.report().worst_penetration, 1e-9) << sleep;
  }
}

TEST_P(ChangedDefinitions, AJointThatIsMadeTakesBodiesAtRestApart) {
  for (const bool sleep : {true, false}) {
    World world = make_world({.sleep = sleep});
    const BodyId shelf = world.create_body({.type = BodyType::Static, .position = {0, 5}});
    world.add_shape(shelf, rough(make_box({4, 1}), 0.5));
    const BodyId box = add(world, {0, 6}, rough(make_box({1, 1}), 0.5), 2);
    run(world, 120);
    ASSERT_EQ(world.asleep(box), sleep);
    world.create_joint(
        {.kind = JointKind::Rope, .a = shelf, .b = box, .anchor_a = {0, 7}, .anchor_b = {0, 6}, .length = 4});
    run(world, 20);
    EXPECT_NEAR(world.position(box).y, 6 - 0.5 * kG / 9, 1e-9) << sleep;
  }
}

TEST_P(ChangedDefinitions, ALimitThatIsLiftedLetsGoAndANewOneHolds) {
  World world = make_world();
  const BodyId arm = add(world, {1, 0}, smooth(make_box({2, 0.1})), 3);
  const JointId hinge = world.create_joint({.kind = JointKind::Revolute,
                                            .b = arm,
                                            .anchor_a = {0, 0},
                                            .lower = 0.0,
                                            .motor_speed = 0.0,
                                            .motor_limit = 1});
  run(world, 180);
  EXPECT_NEAR(world.joint_position(hinge), 0, 1e-9);
  ASSERT_TRUE(world.asleep(arm));
  JointDef def = definition(world, hinge);
  def.lower = -0.5;
  world.set_joint(hinge, def);
  run(world, 180);
  EXPECT_NEAR(world.joint_position(hinge), -0.5, 1e-8);
  def.lower.reset();
  def.motor_limit = 2;
  world.set_joint(hinge, def);
  run(world, 1200);
  // It hangs, within what friction holds: sin(off) <= M / (m g l).
  EXPECT_LE(std::abs(std::sin(world.joint_position(hinge) + kPi / 2)), 2 / (3 * kG * 1) + 1e-9);
  EXPECT_NEAR(world.omega(arm), 0, 1e-9);
}

/// An arm of 2 m on a hinge at its end whose motor holds it.
JointId add_motor(World& world, BodyId& arm, double limit) {
  arm = add(world, {1, 0}, smooth(make_box({2, 0.1})));
  JointDef def{.kind = JointKind::Revolute, .b = arm, .anchor_a = {0, 0}, .anchor_b = {0, 0}};
  def.motor_speed = 0;
  def.motor_limit = limit;
  return world.create_joint(def);
}

TEST_P(ChangedDefinitions, AMotorAtRestThatIsSetTurnsAndPullsUpToItsNewLimit) {
  for (const bool sleep : {true, false}) {
    WorldConfig config = weightless();
    config.sleep = sleep;
    World world = make_world(config);
    BodyId arm;
    const JointId motor = add_motor(world, arm, 5);
    run(world, 200);
    EXPECT_EQ(world.asleep(arm), sleep);
    world.set_motor(motor, 1);
    run(world, 60);
    EXPECT_NEAR(world.omega(arm), 1, 1e-9) << sleep;
    // Against a torque that is too much for it.
    const auto hold = [&] {
      for (int i = 0; i < 60; ++i) {
        world.apply_torque(arm, -20);
        world.step(kStep);
      }
      return world.omega(arm);
    };
    EXPECT_LT(hold(), -1) << sleep;
    world.set_motor(motor, 1, 100);
    EXPECT_NEAR(hold(), 1, 1e-9) << sleep;
  }
}

TEST_P(ChangedDefinitions, AMotorAtRestThatIsMadeWeakLetsGo) {
  for (const bool sleep : {true, false}) {
    World world = make_world({.sleep = sleep});
    BodyId arm;
    const JointId motor = add_motor(world, arm, 20);
    run(world, 50);
    EXPECT_NEAR(world.omega(arm), 0, 1e-12) << sleep;
    world.set_motor(motor, 0, 5);
    run(world, 10);
    EXPECT_LT(world.omega(arm), -0.1) << sleep;
  }
}

TEST_P(ChangedDefinitions, AStifferSpringSwingsFaster) {
  World world = make_world(weightless());
  const BodyId ball = add(world, {2, 0}, smooth(make_disc(0.1)), 1);
  const JointId spring = world.create_joint({.kind = JointKind::Spring,
                                             .b = ball,
                                             .anchor_a = {0, 0},
                                             .anchor_b = {2, 0},
                                             .length = 2,
                                             .stiffness = 1});
  run(world, 60);
  JointDef def = definition(world, spring);
  def.stiffness = 100;
  def.length = 1.5;
  world.set_joint(spring, def);
  EXPECT_NEAR(world.spring_energy(), 0.5 * 100 * 0.25, 1e-9);
  // About 1.5 with an amplitude of 0.5 and omega = 10; symplectic steps of 1/60 s are 1 % off in phase.
  run(world, 60);
  EXPECT_NEAR(world.position(ball).x, 1.5 + 0.5 * std::cos(10), 0.02);
}

TEST_P(ChangedDefinitions, AHingeGetsASpringAndLosesIt) {
  World world = make_world(weightless());
  const BodyId arm = add(world, {1, 0}, smooth(make_box({2, 0.1})), 3, {0, 1}, 1);
  const JointId hinge = world.create_joint({.kind = JointKind::Revolute, .b = arm, .anchor_a = {0, 0}});
  run(world, 30);
  const double turned = world.joint_position(hinge), energy = world.kinetic_energy();
  EXPECT_NEAR(turned, 0.5, 1e-4);
  EXPECT_EQ(world.spring_energy(), 0);
  JointDef def = definition(world, hinge);
  def.stiffness = 8;
  world.set_joint(hinge, def);
  EXPECT_NEAR(world.spring_energy(), 0.5 * 8 * turned * turned, 1e-9);
  run(world, 30);
  EXPECT_NEAR(world.spring_energy() + world.kinetic_energy(), energy + 0.5 * 8 * turned * turned, 0.01);
  def.stiffness = 0;
  world.set_joint(hinge, def);
  EXPECT_EQ(world.spring_energy(), 0);
  const double speed = world.omega(arm);
  run(world, 30);
  EXPECT_NEAR(world.omega(arm), speed, 1e-4);
}

TEST_P(ChangedDefinitions, ARopeThatIsPaidOutOrHauledInHasItsNewLength) {
  World world = make_world();
  const BodyId ball = add(world, {0, -2}, smooth(make_disc(0.1)), 1);
  const JointId rope = world.create_joint(
      {.kind = JointKind::Rope, .b = ball, .anchor_a = {0, 0}, .anchor_b = {0, -2}, .length = 2});
  run(world, 120);
  ASSERT_TRUE(world.asleep(ball));
  JointDef def = definition(world, rope);
  def.length = 3;
  world.set_joint(rope, def);
  run(world, 20);
  EXPECT_NEAR(world.position(ball).y, -2 - 0.5 * kG / 9, 1e-9);
  run(world, 120);
  EXPECT_NEAR(world.position(ball).y, -3, 1e-9);
  for (int i = 0; i < 60; ++i) {
    def.length = *def.length - 0.01;
    world.set_joint(rope, def);
    world.step(kStep);
  }
  run(world, 120);
  EXPECT_NEAR(world.position(ball).y, -2.4, 1e-9);
}

TEST_P(ChangedDefinitions, AJointThatIsToBreakSoonerBreaks) {
  World world = make_world();
  const BodyId ball = add(world, {0, -2}, smooth(make_disc(0.1)), 1);
  const JointId rod = world.create_joint(
      {.kind = JointKind::Distance, .b = ball, .anchor_a = {0, 0}, .anchor_b = {0, -2}, .break_force = 20});
  run(world, 120);
  ASSERT_TRUE(world.alive(rod));
  JointDef def = definition(world, rod);
  def.break_force = 9;
  world.set_joint(rod, def);
  world.step(kStep);
  EXPECT_FALSE(world.alive(rod));
}

TEST_P(ChangedDefinitions, WhatAJointIsStays) {
  World world = make_world();
  const BodyId ball = add(world, {0, -2}, smooth(make_disc(0.1)), 1),
               other = add(world, {5, 0}, smooth(make_disc(0.1)));
  const JointId rod = world.create_joint(
      {.kind = JointKind::Distance, .b = ball, .anchor_a = {0, 0}, .anchor_b = {0, -2}, .stiffness = 50});
  const std::uint64_t before = world.state_hash();
  const auto refused = [&](auto change) {
    JointDef def = definition(world, rod);
    change(def);
    try {
      world.set_joint(rod, def);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  const std::string bodies = "set_joint: the kind and the bodies of a joint stay; make another one";
  const std::string frame =
      "set_joint: the anchors, the axis, the pulleys and the ratio of a joint stay; make another one";
  EXPECT_EQ(refused([](JointDef& d) { d.kind = JointKind::Spring; }), bodies);
  EXPECT_EQ(refused([&](JointDef& d) { d.b = other; }), bodies);
  EXPECT_EQ(refused([](JointDef& d) { d.anchor_b = {0, -1}; }), frame);
  EXPECT_EQ(refused([](JointDef& d) { d.axis = {0, 1}; }), frame);
  EXPECT_EQ(refused([](JointDef& d) { d.ratio = 2; }), frame);
  EXPECT_EQ(refused([](JointDef& d) { d.stiffness = -1; }),
            "joint: stiffness must be finite and >= 0, got -1");
  EXPECT_EQ(refused([](JointDef& d) { d.length = 0.0; }),
            "distance joint: length must be positive, got 0; use a revolute joint, or a spring");
  EXPECT_EQ(definition(world, rod).stiffness, 50);
  EXPECT_EQ(world.state_hash(), before);
  world.destroy(rod);
  EXPECT_THROW(world.set_joint(rod, {.kind = JointKind::Distance, .b = ball}), std::invalid_argument);
}

/// What is kept of the old definition must not show: a world that is written and read goes on like the one
/// that was changed, and so does one that was made with the new definition in that state.
TEST_P(ChangedDefinitions, GoOnAsAWorldThatIsReadDoes) {
  World world = make_world();
  const BodyId ground = add_ground(world, rough(make_disc(1), 0.5));
  std::vector<BodyId> boxes;
  boxes.reserve(6);
  for (int i = 0; i < 6; ++i) boxes.push_back(add(world, {0.1 * i, i + 0.5}, rough(make_box({1, 1}), 0.5)));
  const JointId rope = world.create_joint({.kind = JointKind::Rope,
                                           .a = boxes[0],
                                           .b = boxes[5],
                                           .anchor_a = world.position(boxes[0]),
                                           .anchor_b = world.position(boxes[5]),
                                           .length = 6});
  run(world, 60);
  set_material(world, ground, {.friction = 0.3, .surface_velocity = -1});
  world.set_filter(shape_of(world, boxes[2]), {.group = -2});
  world.set_filter(shape_of(world, boxes[3]), {.group = -2});
  JointDef def = definition(world, rope);
  def.length = 5.0;
  world.set_joint(rope, def);
  World read = load_snapshot(save_snapshot(world));
  for (int i = 0; i < 60; ++i) {
    world.step(kStep);
    read.step(kStep);
    ASSERT_EQ(world.state_hash(), read.state_hash()) << i;
  }
  // Boxes 2 and 3 went through each other.
  EXPECT_LT(world.position(boxes[5]).y, 5.2);
}

INSTANTIATE_TEST_SUITE_P(All, ChangedDefinitions, testing::Values("time_stepping", "event_driven", "auto"));

}  // namespace changed_definitions_test
}  // namespace skerry
