// SPDX-License-Identifier: MIT
//
// Bodies that are held fast, let go and given another mass while the world runs: what follows is what
// formulas say of the new type, what slept wakes, and nothing is left of the old one.
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "physics/snapshot.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace changed_types_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;
using test::weightless;

constexpr double kStep = 1.0 / 60, kG = 9.81;

class ChangedTypes : public testing::TestWithParam<const char*> {
 protected:
  static World make_world(WorldConfig config = {}) {
    config.stepper = GetParam();
    return World(config);
  }
};

void run(World& world, int steps) {
  for (int i = 0; i < steps; ++i) world.step(kStep);
}

BodyType type_of(const World& world, BodyId body) {
  return world.bodies().type[body.index];
}

BodyId add_shelf(World& world, Vec2 position, BodyType type = BodyType::Static) {
  const BodyId shelf = world.create_body({.type = type, .position = position});
  world.add_shape(shelf, {.shape = make_box({4, 1}), .density = 100, .material = {.friction = 0.5}});
  return shelf;
}

TEST_P(ChangedTypes, AShelfThatIsLetGoFallsWithWhatSleptOnItWithEveryBroadPhase) {
  for (const BroadPhaseEntry& broad_phase : broad_phases()) {
    for (const bool sleep : {true, false}) {
      const std::string which = std::string(broad_phase.name) + (sleep ? ", asleep" : ", awake");
      World world = make_world({.broad_phase = std::string(broad_phase.name), .sleep = sleep});
      add_ground(world, rough(make_disc(1), 0.5));
      const BodyId shelf = add_shelf(world, {0, 5});
      const BodyId box = add(world, {0, 6}, rough(make_box({1, 1}), 0.5), 2);
      run(world, 120);
      ASSERT_EQ(world.asleep(box), sleep) << which;
      EXPECT_EQ(world.mass(shelf), 0) << which;
      world.set_type(shelf, BodyType::Dynamic);
      EXPECT_EQ(world.mass(shelf), 400) << which;
      EXPECT_NEAR(world.inertia(shelf), 400 * 17 / 12.0, 1e-9) << which;
      EXPECT_EQ(world.shapes_at({0, 5}).size(), 1u) << which;
      run(world, 30);
      EXPECT_NEAR(world.position(shelf).y, 5 - 0.5 * kG * 0.25, 1e-9) << which;
      EXPECT_NEAR(world.position(box).y, 6 - 0.5 * kG * 0.25, 1e-9) << which;
      // It lands on the ground, which it never met before.
      run(world, 150);
      EXPECT_NEAR(world.position(shelf).y, 0.5, 1e-9) << which;
      EXPECT_NEAR(world.position(box).y, 1.5, 1e-9) << which;
    }
  }
}

TEST_P(ChangedTypes, WhatIsHeldFastStopsAndCarriesWithEveryBroadPhase) {
  for (const BroadPhaseEntry& broad_phase : broad_phases()) {
    for (const BodyType type : {BodyType::Static, BodyType::Kinematic}) {
      World world = make_world({.broad_phase = std::string(broad_phase.name)});
      add_ground(world, rough(make_disc(1), 0.5));
      const BodyId shelf = add_shelf(world, {0, 5}, BodyType::Dynamic);
      const BodyId box = add(world, {0, 8}, rough(make_box({1, 1}), 0.5), 2);
      run(world, 30);
      world.set_type(shelf, type);
      if (type == BodyType::Kinematic) {
        EXPECT_NEAR(world.velocity(shelf).y, -kG * 0.5, 1e-12) << broad_phase.name;
        world.set_velocity(shelf, {}, 0);
      }
      EXPECT_EQ(world.velocity(shelf), Vec2()) << broad_phase.name;
      EXPECT_EQ(world.mass(shelf), 0) << broad_phase.name;
      const double held = world.position(shelf).y;
      run(world, 150);
      EXPECT_EQ(world.position(shelf).y, held) << broad_phase.name;
      EXPECT_NEAR(world.position(box).y, held + 1, 1e-9) << broad_phase.name;
      EXPECT_TRUE(world.asleep(box)) << broad_phase.name;
    }
  }
}

/// Two of three discs in a row, the middle one held: the struck one bounces as off a wall. Let go, it is
/// struck by an equal, and stops it.
TEST_P(ChangedTypes, ABallThatIsHeldBouncesBack) {
  World world = make_world(weightless());
  const std::vector<BodyId> balls = test::add_row(world, {2, 0}, 1, 1);
  world.set_type(balls[1], BodyType::Static);
  run(world, 60);
  EXPECT_NEAR(world.velocity(balls[0]).x, -2, 1e-12);
  world.set_type(balls[1], BodyType::Dynamic);
  world.set_velocity(balls[0], {2, 0}, 0);
  run(world, 90);
  EXPECT_NEAR(world.velocity(balls[0]).x, 0, 1e-12);
  EXPECT_NEAR(world.velocity(balls[1]).x, 2, 1e-12);
}

TEST_P(ChangedTypes, ABallOfAnotherMassIsStruckOtherwise) {
  World world = make_world(weightless());
  const std::vector<BodyId> balls = test::add_row(world, {2, 0}, 1, 1);
  world.set_mass(balls[1], 3.0);
  EXPECT_EQ(world.mass(balls[1]), 3);
  EXPECT_NEAR(world.inertia(balls[1]), 0.5 * 3 * 0.25, 1e-12);
  EXPECT_EQ(world.velocity(balls[0]), (Vec2{2, 0}));
  run(world, 90);
  EXPECT_NEAR(world.velocity(balls[0]).x, -1, 1e-12);
  EXPECT_NEAR(world.velocity(balls[1]).x, 1, 1e-12);
  // By its shapes: 1000 kg/m^2 of a disc.
  world.set_mass(balls[1], {}, 0.7);
  EXPECT_NEAR(world.mass(balls[1]), 1000 * kPi * 0.25, 1e-9);
  EXPECT_EQ(world.inertia(balls[1]), 0.7);
  world.apply_torque(balls[1], 0.07);
  world.step(kStep);
  EXPECT_NEAR(world.omega(balls[1]), 0.1 * kStep, 1e-15);
}

TEST_P(ChangedTypes, ASpringBearsTheNewMass) {
  World world = make_world();
  const BodyId weight = add(world, {0, -1}, smooth(make_box({0.2, 0.2})), 2);
  world.create_joint({.kind = JointKind::Spring,
                      .b = weight,
                      .anchor_b = {0, -1},
                      .length = 1,
                      .stiffness = 100,
                      .damping = 30});
  run(world, 600);
  EXPECT_NEAR(world.position(weight).y, -1 - 2 * kG / 100, 1e-6);
  world.set_mass(weight, 5.0);
  run(world, 900);
  EXPECT_NEAR(world.position(weight).y, -1 - 5 * kG / 100, 1e-6);
}

/// The heavy half takes the centre of mass to its side; no point of the body moves, and none changes its
/// velocity.
TEST_P(ChangedTypes, NothingMovesWhenTheCentreOfMassDoes) {
  World world = make_world(weightless());
  const BodyId body = world.create_body(
      {.type = BodyType::Kinematic, .position = {3, 2}, .angle = 0.3, .velocity = {1, 0}, .omega = 2});
  world.add_shape(body, {.shape = make_box({1, 1}, {-0.5, 0}), .density = 100});
  world.add_shape(body, {.shape = make_box({1, 1}, {0.5, 0}), .density = 300});
  const Transform before = world.pose(body);
  const Vec2 corner = to_world(before, {1, 0.5}), speed = world.velocity_at(body, corner);
  world.set_type(body, BodyType::Dynamic);
  EXPECT_EQ(world.mass(body), 400);
  EXPECT_NEAR(length(world.position(body) - to_world(before, {0.25, 0})), 0, 1e-15);
  EXPECT_NEAR(length(to_world(world.pose(body), {0.75, 0.5}) - corner), 0, 1e-15);
  EXPECT_NEAR(length(world.velocity_at(body, corner) - speed), 0, 1e-14);
  const Vec2 moves = world.velocity(body);
  run(world, 60);
  EXPECT_NEAR(length(world.velocity(body) - moves), 0, 1e-13);
  const Vec2 there = to_world(world.pose(body), {0.75, 0.5});
  world.set_type(body, BodyType::Static);
  EXPECT_NEAR(length(to_world(world.pose(body), {1, 0.5}) - there), 0, 1e-14);
}

TEST_P(ChangedTypes, WhatIsHeldNoLongerWeighsOnOthers) {
  // A brick on a plank that slides: once the brick is held the plank is braked by its own weight alone.
  for (const BodyType type : {BodyType::Static, BodyType::Kinematic}) {
    for (const double gravity : {kG, 0.0}) {
      World world = make_world();
      add_ground(world, rough(make_disc(1), 0.1));
      const BodyId plank = add(world, {0, 0.1}, rough(make_box({6, 0.2}), 0.1), 1, {3, 0});
      const BodyId brick = add(world, {-2, 0.4}, rough(make_box({0.4, 0.4}), 0.1), 5, {3, 0});
      run(world, 6);
      world.set_type(brick, type);
      world.set_velocity(plank, {3, 0}, 0);
      if (type == BodyType::Kinematic) world.set_velocity(brick, {}, 0);
      world.set_gravity({0, -gravity});
      run(world, 30);
      EXPECT_NEAR(world.velocity(plank).x, 3 - 0.1 * gravity * 0.5, 0.03) << gravity;
    }
  }
}

TEST_P(ChangedTypes, NothingOfTheOldTypeIsLeft) {
  World world = make_world();
  const BodyId ground = add_ground(world, rough(make_disc(1), 0.5));
  const BodyId lift = world.create_body({.type = BodyType::Kinematic, .position = {0, 5}});
  world.add_shape(lift, smooth(make_box({1, 1})));
  world.set_motion(lift, [](double t) { return Placement{.position = {0, 5 + 2 * t}}; });
  run(world, 30);
  world.set_type(lift, BodyType::Dynamic);
  run(world, 30);
  EXPECT_NEAR(world.position(lift).y, 6 + 2 * 0.5 - 0.5 * kG * 0.25, 1e-9);
  // Drag, and a force that was to act in the next step, are of what is dynamic.
  world.set_drag(lift, {.linear = 1e6});
  world.apply_force(lift, {1e6, 0}, world.position(lift));
  world.set_type(lift, BodyType::Static);
  EXPECT_THROW(world.set_velocity(lift, {1, 0}, 0), std::invalid_argument);
  world.set_type(lift, BodyType::Dynamic);
  EXPECT_THROW(world.set_motion(lift, [](double) { return Placement{}; }), std::invalid_argument);
  const double from = world.position(lift).y;
  run(world, 30);
  EXPECT_NEAR(world.position(lift).y, from - 0.5 * kG * 0.25, 1e-9);
  EXPECT_EQ(world.position(lift).x, 0);
  // The ground is endless.
  const std::uint64_t before = world.state_hash();
  EXPECT_THROW(world.set_type(ground, BodyType::Dynamic), std::invalid_argument);
  world.set_type(ground, BodyType::Static);
  EXPECT_THROW(world.set_mass(lift, 0.0), std::invalid_argument);
  EXPECT_THROW(world.set_mass(lift, 1.0, -1.0), std::invalid_argument);
  EXPECT_THROW(world.set_mass(lift, std::nan("")), std::invalid_argument);
  EXPECT_EQ(world.state_hash(), before);
  EXPECT_EQ(type_of(world, ground), BodyType::Static);
  world.destroy(lift);
  EXPECT_THROW(world.set_type(lift, BodyType::Static), std::invalid_argument);
  EXPECT_THROW(world.set_mass(lift, 1.0), std::invalid_argument);
}

/// One of a pile is held and let go again; the pile rests as before, and nobody asks what is between two that
/// are fixed.
TEST_P(ChangedTypes, APileWithOneThatIsHeldRestsOn) {
  World world = make_world();
  add_ground(world, rough(make_disc(1), 0.5));
  std::vector<BodyId> boxes;
  boxes.reserve(5);
  for (int i = 0; i < 5; ++i) boxes.push_back(add(world, {0, i + 0.5}, rough(make_box({1, 1}), 0.5), 2));
  run(world, 60);
  const int contacts = world.report().contacts;
  world.set_type(boxes[0], BodyType::Static);
  world.step(kStep);
  EXPECT_EQ(world.report().contacts, contacts - 1);
  run(world, 60);
  EXPECT_TRUE(world.asleep(boxes[4]));
  EXPECT_FALSE(world.asleep(boxes[0]));
  World read = load_snapshot(save_snapshot(world));
  for (World* one : {&world, &read}) {
    one->set_type(boxes[0], BodyType::Dynamic);
    one->step(kStep);
    EXPECT_EQ(one->report().contacts, contacts);
    run(*one, 60);
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      EXPECT_NEAR(one->position(boxes[i]).y, static_cast<double>(i) + 0.5, 1e-9);
      EXPECT_TRUE(one->asleep(boxes[i]));
    }
  }
  EXPECT_EQ(world.state_hash(), read.state_hash());
}

/// A kinematic body and the ground are no contact; nothing moves when they become one.
TEST_P(ChangedTypes, WhatLayThereRestsWhenItIsLetGoWithEveryBroadPhase) {
  for (const BroadPhaseEntry& broad_phase : broad_phases()) {
    for (const bool sleep : {true, false}) {
      World world = make_world({.broad_phase = std::string(broad_phase.name), .sleep = sleep});
      add_ground(world, rough(make_disc(1), 0.5));
      const BodyId shelf = add_shelf(world, {0, 0.5}, BodyType::Kinematic);
      const BodyId box = add(world, {0, 1.5}, rough(make_box({1, 1}), 0.5), 2);
      run(world, 60);
      world.set_type(shelf, BodyType::Dynamic);
      run(world, 60);
      EXPECT_NEAR(world.position(shelf).y, 0.5, 1e-9) << broad_phase.name;
      EXPECT_NEAR(world.position(box).y, 1.5, 1e-9) << broad_phase.name;
    }
  }
}

/// Forces of what rests are repeated: not those of another mass.
TEST_P(ChangedTypes, TheGroundBearsTheNewMass) {
  for (const bool sleep : {true, false}) {
    World world = make_world({.sleep = sleep});
    world.observe({.contacts = true});
    const BodyId ground = add_ground(world, rough(make_disc(1), 0.5));
    const BodyId low = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5), 2);
    const BodyId high = add(world, {0, 1.5}, rough(make_box({1, 1}), 0.5), 3);
    const auto load = [&] {
      double sum = 0;
      for (const ContactReport& contact : world.report().contacts_list) {
        if (contact.body_a != ground && contact.body_b != ground) continue;
        for (int k = 0; k < contact.count; ++k)
          sum += contact.points[static_cast<std::size_t>(k)].normal_impulse;
      }
      return sum / kStep;
    };
    run(world, 20);
    EXPECT_NEAR(load(), 5 * kG, 1e-9);
    run(world, 100);
    world.set_mass(high, 30.0);
    for (int i = 0; i < 3; ++i) {
      world.step(kStep);
      EXPECT_NEAR(load(), 32 * kG, 1e-8) << i;
    }
    world.set_type(low, BodyType::Static);
    world.step(kStep);
    EXPECT_EQ(load(), 0);
    world.set_type(low, BodyType::Dynamic);
    for (int i = 0; i < 3; ++i) {
      world.step(kStep);
      EXPECT_NEAR(load(), 32 * kG, 1e-8) << i;
    }
  }
}

/// A hinge between two that are fixed is nothing; it holds again when one of them moves.
TEST_P(ChangedTypes, AHingeOfWhatIsHeldHoldsAgain) {
  World world = make_world();
  const BodyId a = add(world, {0, 0}, smooth(make_disc(0.1)), 1);
  const BodyId b = add(world, {1, 0}, smooth(make_disc(0.1)), 1);
  world.create_joint({.kind = JointKind::Revolute, .a = a, .b = b, .anchor_a = {0, 0}});
  world.set_type(a, BodyType::Static);
  world.set_type(b, BodyType::Static);
  run(world, 30);
  EXPECT_EQ(world.position(b), (Vec2{1, 0}));
  world.set_type(b, BodyType::Dynamic);
  // A pendulum: v^2 = 2 g h (1 + k) with k of the disc's own inertia.
  double error = 0;
  for (int i = 0; i < 30; ++i) {
    world.step(kStep);
    error = std::max(error, std::abs(length(world.position(b)) - 1));
    const double fall = -world.position(b).y, own = 1 + 0.5 * 0.01;
    EXPECT_NEAR(length_squared(world.velocity(b)), 2 * kG * fall / own, 0.02 * kG);
  }
  EXPECT_LT(error, 1e-6);
  EXPECT_EQ(world.position(a), Vec2());
}

INSTANTIATE_TEST_SUITE_P(All, ChangedTypes, testing::Values("time_stepping", "event_driven", "auto"));

}  // namespace changed_types_test
}  // namespace skerry
