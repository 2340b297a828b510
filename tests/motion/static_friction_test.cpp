// SPDX-License-Identifier: MIT
//
// Friction that holds more than it brakes.
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "tests/support/draw.h"
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

TEST_P(StaticFriction, HoldsNothingThatIsSetGoing) {
  // What stuck in the last step slides like anything else, however slowly it was sent off.
  for (const double speed : {0.03, 0.1, 0.14, 1.0}) {
    for (const bool pushed : {false, true}) {
      World world(config());
      add_ground(world, held(make_disc(1), 0.1, 0.9));
      const BodyId block = add(world, {0, 0.2}, held(make_box({1, 0.4}), 0.1, 0.9), 2);
      for (int k = 0; k < 10; ++k) world.step(1.0 / 60);
      if (pushed)
        world.apply_impulse(block, {2 * speed, 0}, world.position(block));
      else
        world.set_velocity(block, {speed, 0}, 0);
      for (int k = 0; k < 90; ++k) world.step(1.0 / 60);
      EXPECT_NEAR(world.position(block).x, speed * speed / (2 * 0.1 * kG), 1e-9) << speed << " m/s";
    }
  }
}

TEST(StaticFrictionInFlow, HoldsNothingThatIsSetGoing) {
  // A slab that 60 discs roll about in, and whose island flows; they push it by less than a tenth of its
  // weight.
  World world;
  add_ground(world, held(make_disc(1), 0.1, 0.9));
  const BodyId slab = add(world, {0, 0.25}, held(make_box({10, 0.5}), 0.1, 0.9), 5000);
  for (const double side : {-1, 1}) world.add_shape(slab, test::smooth(make_box({0.2, 2}, {4.9 * side, 1})));
  test::Draw draw(1);
  for (int i = 0; i < 60; ++i) {
    const int row = i / 12;
    add(world, {0.7 * (i % 12) - 3.9 + draw.uniform(-0.1, 0.1), 1 + 0.7 * row}, test::smooth(make_disc(0.25)),
        0.2, {draw.uniform(-3, 3), draw.uniform(-1, 1)});
  }
  for (int k = 0; k < 40; ++k) world.step(1.0 / 60);
  world.set_velocity(slab, {0.14, 0}, 0);
  int flowing = 0;
  for (int k = 0; k < 5; ++k) flowing += world.step(1.0 / 60).islands_in_flow;
  EXPECT_GT(flowing, 3);
  EXPECT_NEAR(world.velocity(slab).x, 0.14 - 0.1 * kG * 5 / 60, 3e-3);
}

TEST_P(StaticFriction, HoldsByAllContactsTogether) {
  // A belt that climbs a row of tiles as fast as it turns rests on several of them, and how they share the
  // load is nobody's choice: it holds as long as all together can.
  for (unsigned seed = 0; seed < 40; ++seed) {
    test::Draw draw(seed);
    const double angle = draw.uniform(0.1, 0.5), speed = draw.uniform(0.2, 2), width = draw.uniform(0.3, 2);
    const double kinetic = std::tan(angle) * draw.uniform(0.3, 0.95),
                 still = std::tan(angle) * draw.uniform(1.05, 1.6);
    const Vec2 along{std::cos(angle), std::sin(angle)}, up{-std::sin(angle), std::cos(angle)};
    World world(config());
    const BodyId ground = world.create_body({.type = BodyType::Static});
    for (double at = -6; at < 6;) {
      const double tile = width * draw.uniform(0.5, 1.5);
      world.add_shape(
          ground, held(make_box({tile, 0.5}, (at + 0.5 * tile) * along - 0.25 * up, angle), kinetic, still));
      at += tile;
    }
    ShapeDef belt = held(make_box({1.6, 0.4}), kinetic, still);
    belt.material.surface_velocity = -speed;
    const BodyId climber = add(world, 0.2 * up, belt, 3, speed * along, 0, angle);
    for (int k = 0; k < 60; ++k) world.step(1.0 / 60);
    EXPECT_NEAR(dot(world.position(climber), along), speed, 1e-3) << "seed " << seed;
  }
}

TEST_P(StaticFriction, IsNotBrokenByAPebble) {
  // 1 g bounces on 80 kg: each blow is far within what friction holds.
  for (unsigned seed = 0; seed < 20; ++seed) {
    test::Draw draw(seed);
    const double angle = draw.uniform(0.1, 0.4);
    const Vec2 up{-std::sin(angle), std::cos(angle)};
    World world(config());
    add_ground(world, held(make_disc(1), 0.6 * std::tan(angle), 2 * std::tan(angle)), angle);
    const BodyId block =
        add(world, 0.2 * up, held(make_box({2, 0.4}), 0.6 * std::tan(angle), 2 * std::tan(angle)), 80, {}, 0,
            angle);
    ShapeDef pebble = test::rough(make_disc(0.05), 0.5);
    pebble.material.restitution = 0.5;
    pebble.restitution_rule = MixingRule::Minimum;
    add(world, {draw.uniform(-0.3, 0.3), 1.2}, pebble, 1e-3);
    for (int k = 0; k < 50; ++k) world.step(1.0 / 60);
    EXPECT_LE(length(world.position(block) - 0.2 * up), 1e-4) << "seed " << seed;
  }
}

/// Where what is thrown up a slope between both angles stops by the formula, less where it did, and how fast
/// it is later on.
struct Miss {
  double way, speed;
};
Miss thrown_up(const WorldConfig& config, unsigned seed, bool tiles) {
  test::Draw draw(seed);
  const double h = 1.0 / (30 << draw.pick(4)), kinetic = draw.uniform(0.15, 0.6);
  const double more = draw.uniform(1.1, 2), still = more * kinetic;
  const double angle = std::atan(kinetic * (1 + (more - 1) * draw.uniform(0.1, 0.9)));
  const Rot q = Rot::from_angle(angle);
  World world(config);
  if (tiles) {
    const double width = draw.uniform(0.15, 0.6);
    const int tiles_up = static_cast<int>(6 / width);
    for (int k = -tiles_up; k < tiles_up; ++k) {
      const BodyId tile = world.create_body(
          {.type = BodyType::Static, .position = rotate(q, {(k + 0.5) * width, -0.2}), .angle = angle});
      world.add_shape(tile, held(make_box({width, 0.4}), kinetic, still));
    }
  } else {
    add_ground(world, held({}, kinetic, still), angle);
  }
  const double half = draw.uniform(0.2, 0.6), speed = draw.uniform(0.5, 3);
  const Vec2 up = rotate(q, {speed, 0});
  const BodyId block =
      add(world, rotate(q, {0, 0.1}), held(make_box({2 * half, 0.2}), kinetic, still), 1, up, 0, angle);
  const int bricks = tiles ? 0 : 4 + draw.pick(3);
  for (int k = 0; k < bricks; ++k)
    add(world, rotate(q, {0, 0.22 + 0.04 * k}), held(make_box({2 * half, 0.04}), 0.9, 1.8), 0.1, up, 0,
        angle);
  const double brake = kG * (std::sin(angle) + kinetic * std::cos(angle));
  while (world.time() < speed / brake + 1) world.step(h);
  return {0.5 * speed * speed / brake - dot(world.position(block), rotate(q, {1, 0})),
          length(world.velocity(block))};
}

TEST_P(StaticFriction, HoldsWhatComesToRestOnManyContacts) {
  // More rows than ends of sliding are looked for in: pieces end beyond them.
  for (unsigned seed = 0; seed < 60; ++seed) {
    for (const bool tiles : {true, false}) {
      const Miss miss = thrown_up(config(), seed, tiles);
      EXPECT_LT(std::abs(miss.way), 2e-3) << "seed " << seed << (tiles ? ", tiles" : ", tower");
      EXPECT_LT(miss.speed, 1e-9) << "seed " << seed << (tiles ? ", tiles" : ", tower");
    }
  }
}

TEST(StaticFrictionDefinition, BelowKineticIsRefused) {
  World world;
  const auto body = world.create_body({});
  EXPECT_THROW(world.add_shape(body, held(make_disc(1), 0.5, 0.4)), std::invalid_argument);
  EXPECT_THROW(world.add_shape(body, held(make_disc(1), 0.5, NAN)), std::invalid_argument);
}

}  // namespace static_friction_test
}  // namespace skerry
