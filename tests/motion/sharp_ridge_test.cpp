// SPDX-License-Identifier: MIT
//
// Bodies thrown at the point of a spike made of a chain. Behind a sharp ridge what is in front of one face is
// far below the other's line: that is no overlap, and to take it out throws a body across the spike.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <numbers>
#include <string>
#include <vector>

#include "physics/narrowphase/chain.h"
#include "physics/narrowphase/queries.h"
#include "tests/support/draw.h"
#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace sharp_ridge_test {

constexpr double kPi = std::numbers::pi, kStep = 1.0 / 60;

Shape draw_body(test::Draw& draw) {
  const double size = std::exp(draw.uniform(std::log(0.1), 0));
  switch (draw.pick(3)) {
    case 0:
      return make_box({2 * size, 2 * size * draw.uniform(0.05, 0.5)});
    case 1: {
      const double radius = size * draw.uniform(0.02, 0.3);
      return make_capsule({radius - size, 0}, {size - radius, 0}, radius);
    }
    default:
      return make_polygon(std::vector<Vec2>{{-size, -0.2 * size}, {size, -0.2 * size}, {0, 0.3 * size}});
  }
}

/// A triangle with its point at the origin, counter-clockwise.
std::vector<Vec2> draw_spike(test::Draw& draw) {
  const double half = draw.uniform(0.05, 0.7), length = draw.uniform(1, 3);
  const Rot turn = Rot::from_angle(draw.uniform(-1, 1));
  std::vector<Vec2> corners{{0, 0}, {-length * std::tan(half), -length}, {length * std::tan(half), -length}};
  for (Vec2& corner : corners) corner = rotate(turn, corner);
  return corners;
}

/// The same solid as a chain.
Shape chain_of(std::vector<Vec2> corners) {
  std::reverse(corners.begin(), corners.end());
  return make_chain(corners, true);
}

struct Throws {
  int jumped = 0, sank = 0, gained = 0;
};

Throws throw_at_spikes(const char* stepper, int count, double slowest, double fastest) {
  Throws found;
  for (int seed = 0; seed < count; ++seed) {
    test::Draw draw(static_cast<unsigned>(seed));
    const std::vector<Vec2> corners = draw_spike(draw);
    const Shape solid = make_polygon(corners);
    WorldConfig config;
    config.stepper = stepper;
    if (draw.one_in(2)) config.gravity = {0, 0};
    World world(config);
    const Material surface{.friction = draw.one_in(2) ? 0 : draw.uniform(0, 1),
                           .restitution = draw.one_in(2) ? 0 : draw.uniform(0, 1)};
    const BodyId rock = world.create_body({.type = BodyType::Static});
    world.add_shape(rock, {.shape = chain_of(corners), .material = surface});
    const double speed = std::exp(draw.uniform(std::log(slowest), std::log(fastest))),
                 from = draw.uniform(0, 2 * kPi);
    const Vec2 place = 3.5 * Vec2{std::cos(from), std::sin(from)};
    const Vec2 way = Vec2{draw.uniform(-0.5, 0.5), draw.uniform(-0.5, 0.5)} - place;
    const BodyId body = world.create_body({.position = place,
                                           .angle = draw.uniform(-3, 3),
                                           .velocity = speed / length(way) * way,
                                           .omega = draw.uniform(-10, 10)});
    const ShapeId id = world.add_shape(body, {.shape = draw_body(draw), .material = surface});
    // About its centre of mass.
    const Shape shape = world.shapes()[id.index].shape;
    const auto gap = [&] { return distance(solid, {}, shape, world.pose(body)).distance; };
    if (gap() < 0.01) continue;
    const auto energy = [&] { return world.kinetic_energy() + world.potential_energy(); };
    const double first = energy();
    bool jumps = false, sinks = false, gains = false;
    for (int i = 0; i < std::clamp(static_cast<int>(360 / speed), 20, 120); ++i) {
      const Vec2 at = world.position(body), before = world.velocity(body);
      world.step(kStep);
      const double fast = std::max(length(before), length(world.velocity(body))) + 9.81 * kStep;
      jumps |= length(world.position(body) - at) > fast * kStep + 1e-3;
      sinks |= gap() < -1e-4;
      gains |= energy() - first > 1e-6 * std::abs(first) + 1e-6;
    }
    found.jumped += jumps;
    found.sank += sinks;
    found.gained += gains;
  }
  return found;
}

class SharpRidges : public testing::TestWithParam<const char*> {};

/// Of 3000 35 jumped, by up to 0.46 m, and three gained energy, with every stepper.
TEST_P(SharpRidges, NeverThrowBodies) {
  const Throws found = throw_at_spikes(GetParam(), test_scale(600), 0.3, 10);
  EXPECT_EQ(found.jumped, 0);
  EXPECT_LE(found.sank, test_scale(600) / 600);
  EXPECT_EQ(found.gained, 0);
}

/// Of 2000 68 jumped, by up to 1.6 m, and 16 sank in; by events 49 and 4. What turns by a radian and more
/// within a piece of `time_stepping` sinks in still, 7 of 2000.
TEST_P(SharpRidges, HoldWhatIsFast) {
  const int count = test_scale(400);
  const Throws found = throw_at_spikes(GetParam(), count, 10, 60);
  const int few = std::string(GetParam()) == "event_driven" ? count / 1000 : std::max(3, count / 100);
  EXPECT_LE(found.jumped, few);
  EXPECT_LE(found.sank, few);
  EXPECT_EQ(found.gained, 0);
}

INSTANTIATE_TEST_SUITE_P(Steppers, SharpRidges, testing::Values("time_stepping", "event_driven", "auto"),
                         [](const testing::TestParamInfo<const char*>& each) {
                           return std::string(each.param);
                         });

/// Bodies that are a nanometre or a millimetre inside of a spike: some segment tells, and none tells of more.
/// 60 of 37 800 had one that told of 5 mm to 0.2 m; now some ten of 200 000 are wrong.
TEST(SharpRidgeSegments, TellHowDeepThingsAre) {
  for (const double depth : {1e-9, 1e-3}) {
    int looked = 0, wrong = 0;
    for (int seed = 0; seed < test_scale(6000); ++seed) {
      test::Draw draw(static_cast<unsigned>(seed));
      const std::vector<Vec2> corners = draw_spike(draw);
      const Shape solid = make_polygon(corners), chain = chain_of(corners), body = draw_body(draw);
      const double from = draw.uniform(0, 2 * kPi);
      const Vec2 way{std::cos(from), std::sin(from)}, aim{draw.uniform(-0.5, 0.5), draw.uniform(-0.5, 0.5)};
      const Rot turn = Rot::from_angle(draw.uniform(-3, 3));
      const auto gap = [&](double t) { return distance(solid, {}, body, {aim + t * way, turn}).distance; };
      double in = 0, out = 8;
      if (gap(in) > -depth) continue;
      for (int i = 0; i < 80; ++i) (gap(0.5 * (in + out)) > -depth ? out : in) = 0.5 * (in + out);
      const Transform pose{aim + out * way, turn};
      // Segments have one side, and nothing is held past it.
      if (std::abs(gap(out) + depth) > 1e-9 + 1e-3 * depth || contains(solid, {}, pose.p)) continue;
      double deepest = kInfinity;
      for (int i = 0; i < 3; ++i) {
        const Manifold manifold = collide_chain_segment(chain, i, {}, body, pose, 0.1);
        for (int k = 0; k < manifold.count; ++k)
          deepest = std::min(deepest, manifold.points[static_cast<std::size_t>(k)].separation);
      }
      const bool right = deepest < -0.3 * depth + 1e-10 && deepest > -3 * depth - 1e-4;
      if (!right) std::printf("seed %d: %g m\n", seed, deepest);
      wrong += !right;
      ++looked;
    }
    EXPECT_LE(wrong, looked / 10000);
    EXPECT_GT(looked, test_scale(6000) / 3);
  }
}

}  // namespace sharp_ridge_test
}  // namespace skerry
