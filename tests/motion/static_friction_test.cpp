// SPDX-License-Identifier: MIT
//
// Friction that holds more than it brakes.
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "tests/support/worlds.h"

namespace skerry {
namespace static_friction_test {

using test::add;
using test::add_ground;

constexpr double kG = 9.81;

ShapeDef held(Shape shape, double kinetic, double still) {
  ShapeDef def;
  def.shape = std::move(shape);
  def.material.friction = kinetic;
  def.material.static_friction = still;
  return def;
}

class StaticFriction : public testing::TestWithParam<std::string> {
 protected:
  WorldConfig config() const {
    WorldConfig c;
    c.stepper = GetParam();
    return c;
  }
};
INSTANTIATE_TEST_SUITE_P(By, StaticFriction, testing::Values("time_stepping", "event_driven"),
                         [](const auto& stepper) { return stepper.param; });

TEST_P(StaticFriction, HoldsABlockUpToItsAngleAndLetsItSlideWithTheOtherOneBeyond) {
  const double kinetic = 0.3, still = 0.6;
  for (const double share : {0.999, 1.001}) {
    World world(config());
    const double angle = std::atan(share * still);
    add_ground(world, held({}, kinetic, still), angle);
    const Rot q = Rot::from_angle(angle);
    const auto box =
        add(world, rotate(q, {0, 0.25}), held(make_box({1, 0.5}), kinetic, still), 2, {}, 0, angle);
    for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
    const double way = -dot(world.position(box), rotate(q, {1, 0}));
    const double a = share < 1 ? 0 : kG * (std::sin(angle) - kinetic * std::cos(angle));
    EXPECT_NEAR(way, 0.5 * a, 1e-9) << share;
    EXPECT_EQ(world.report().inexact_islands, 0);
    EXPECT_EQ(world.report().fallbacks, 0);
  }
}

TEST_P(StaticFriction, HasAHysteresis) {
  // Pulled by a force that rises and falls: it starts at mu_s m g and stops when the speed is used up, after
  // which it stays at forces at which it had gone on sliding.
  World world(config());
  const double kinetic = 0.2, still = 0.5, mass = 2, weight = mass * kG;
  add_ground(world, held({}, kinetic, still));
  const auto box = add(world, {0, 0.25}, held(make_box({1, 0.5}), kinetic, still), mass);
  const auto pull = [&](double share, int steps) {
    for (int i = 0; i < steps; ++i) {
      world.apply_force(box, {share * weight, 0}, {world.position(box).x, 0.25});
      world.step(1.0 / 60);
    }
  };
  pull(0.499, 30);
  EXPECT_EQ(world.velocity(box).x, 0);
  pull(0.501, 30);
  EXPECT_NEAR(world.velocity(box).x, 0.5 * kG * (0.501 - 0.2), 1e-9);
  const double before = world.velocity(box).x;
  pull(0.3, 30);  // less than static friction would hold, yet it goes on
  EXPECT_NEAR(world.velocity(box).x, before + 0.5 * kG * 0.1, 1e-9);
  pull(0, 240);
  EXPECT_NEAR(world.velocity(box).x, 0, 1e-12);
  const double stopped = world.position(box).x;
  pull(0.3, 30);  // and now the same force does not move it
  EXPECT_NEAR(world.position(box).x, stopped, 1e-12);
}

TEST_P(StaticFriction, OfAStackLetsOneInterfaceGo) {
  // A force on the upper of two boxes: it slides on the lower one, which the smaller friction then leaves at
  // rest.
  World world(config());
  add_ground(world, held({}, 0.3, 0.6));
  const auto lower = add(world, {0, 0.25}, held(make_box({2, 0.5}), 0.3, 0.6), 1);
  const auto upper = add(world, {0, 0.75}, held(make_box({1, 0.5}), 0.3, 0.6), 1);
  for (int i = 0; i < 30; ++i) {
    world.apply_force(upper, {0.61 * kG, 0}, {world.position(upper).x, 0.5});
    world.step(1.0 / 60);
  }
  EXPECT_NEAR(world.position(lower).x, 0, 1e-12);
  EXPECT_NEAR(world.velocity(upper).x, 0.5 * 0.31 * kG, 1e-9);
}

/// On a plate that tilts slowly what lies there stays until the angle of static friction, though it takes
/// more than sliding friction would give on most of the way, and the plate turns under it all the time.
TEST_P(StaticFriction, HoldsOnAPlateThatTiltsUpToItsAngle) {
  const double kinetic = 0.3, still = 0.8, turn = 0.3;
  for (const Shape& shape :
       {make_box({0.4, 0.2}), make_polygon(std::vector<Vec2>{{-0.2, -0.1}, {0.2, -0.1}, {0, 0.3}})}) {
    World world(config());
    const BodyId plate = world.create_body({.type = BodyType::Kinematic, .omega = turn});
    world.add_shape(plate, held(make_box({6, 0.2}), kinetic, still));
    const BodyId body = add(world, {1, 0.2}, held(shape, kinetic, still), 1, {-0.2 * turn, turn}, turn);
    const Vec2 place = to_local(world.pose(plate), world.position(body));
    const auto moved = [&] { return length(to_local(world.pose(plate), world.position(body)) - place); };
    while (std::tan(world.angle(plate)) < 0.97 * still) {
      world.step(1.0 / 60);
      ASSERT_LT(moved(), 1e-5) << world.angle(plate);
    }
    while (std::tan(world.angle(plate)) < 1.1 * still) world.step(1.0 / 60);
    EXPECT_GT(moved(), 1e-3);
  }
}

TEST_P(StaticFriction, EqualToKineticChangesNothing) {
  std::uint64_t hash[2] = {};
  for (const bool given : {false, true}) {
    World world(config());
    ShapeDef like = held({}, 0.4, 0.4);
    if (!given) like.material.static_friction.reset();
    add_ground(world, like, 0.3);
    like.shape = make_box({1, 1});
    const Rot q = Rot::from_angle(0.3);
    add(world, rotate(q, {0, 0.5}), like, 1, 2.0 * rotate(q, {1, 0}), 0, 0.3);
    for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
    hash[given] = world.state_hash();
  }
  EXPECT_EQ(hash[0], hash[1]);
}

TEST(StaticFrictionDefinition, BelowKineticIsRefused) {
  World world;
  const auto body = world.create_body({});
  EXPECT_THROW(world.add_shape(body, held(make_disc(1), 0.5, 0.4)), std::invalid_argument);
  EXPECT_THROW(world.add_shape(body, held(make_disc(1), 0.5, NAN)), std::invalid_argument);
}

}  // namespace static_friction_test
}  // namespace skerry
