// SPDX-License-Identifier: MIT
//
// Boxes that are dropped on an edge rock ever faster and come to rest: to the bit, and without help of energy
// that was not there.
#include <cmath>
#include <gtest/gtest.h>

#include "tests/support/draw.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace settling_test {

struct Rocking {
  double tilt;      // [rad]
  double friction;  // [1]
  double width;     // [m], of a box 0.5 m high
};

class RockingBox : public testing::TestWithParam<Rocking> {};

TEST_P(RockingBox, ComesToRestAndGainsNoEnergy) {
  const Rocking p = GetParam();
  World world({.gravity = {0, -10}});
  const BodyId ground = world.create_body({.type = BodyType::Static});
  world.add_shape(ground, {.shape = make_half_plane({0, 0}, {0, 1}), .material = {.friction = p.friction}});
  const double height = 0.5 * (p.width * std::sin(p.tilt) + 0.5 * std::cos(p.tilt));
  const BodyId box = world.create_body({.position = {0, height}, .angle = p.tilt});
  world.add_shape(box, {.shape = make_box({p.width, 0.5}), .material = {.friction = p.friction}});

  double energy = kInfinity;
  for (int i = 0; i < 600; ++i) {
    const StepReport& report = world.step(1.0 / 60);
    const double now = report.kinetic_energy + report.potential_energy;
    // The method's own error: it is of second order, so a step of a rocking box may go up by some 1e-5.
    EXPECT_LT(now - energy, 2e-5 * report.potential_energy) << "step " << i;
    energy = now;
  }
  EXPECT_EQ(world.report().islands_at_rest, 1);
  EXPECT_EQ(world.report().kinetic_energy, 0);
  EXPECT_NEAR(world.position(box).y, 0.25, 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Settling, RockingBox,
                         testing::Values(Rocking{0.3, 1, 0.5}, Rocking{0.1, 0, 0.5}, Rocking{0.1, 1, 0.5},
                                         Rocking{0.1, 0.5, 0.8}, Rocking{0.03, 0.5, 0.2},
                                         Rocking{0.001, 0, 0.5}, Rocking{0.001, 1, 0.5}));

/// Corners of boxes that fell onto each other hop by less than anybody could see, and are soon at rest. A
/// step is cut at each landing, and its end is of first order after 64 of them: if hops of 1e-17 m were such,
/// 85 of 10 800 steps of these heaps would have more than 50 cuts.
TEST(Settling, TakesFewLandings) {
  int steps = 0, cut = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    test::Draw draw(seed);
    World world;
    test::add_ground(world, test::rough(make_box({1, 1}), 0.5));
    for (int k = 0; k < 6; ++k) {
      const Vec2 size{draw.uniform(0.3, 1), draw.uniform(0.3, 1)};
      test::add(world, {draw.uniform(-1, 1), 0.5 + 1.1 * k}, test::rough(make_box(size), 0.5), 1,
                {draw.uniform(-1, 1), 0}, draw.uniform(-2, 2));
    }
    for (int k = 0; k < 180; ++k, ++steps) cut += world.step(1.0 / 60).substeps > 50;
  }
  EXPECT_LE(cut, steps / 1000) << cut << " of " << steps;
}

/// What lies down does not wobble on: in short steps a corner falls by less than anybody could see, and if it
/// were lifted again by that without being stopped, each end of a face would fall in turn, and gain energy.
TEST(Settling, FacesLieDownInShortSteps) {
  constexpr double h = 1.0 / 3840;
  for (unsigned seed = 0; seed < 30; ++seed) {
    for (const bool box : {false, true}) {
      test::Draw draw(seed);
      World world;
      const double slope = draw.one_in(2) ? 0 : draw.uniform(0, 0.4);
      const double friction = draw.one_in(2) ? 0 : draw.uniform(0, 0.8);
      test::add_ground(world, test::rough(make_disc(1), friction), slope);
      const double half = draw.uniform(0.1, 0.4), radius = draw.uniform(0.05, 0.2);
      const Vec2 up = rotate(Rot::from_angle(slope), {0, 1});
      const Vec2 at = (radius + 0.05 * draw.uniform(0.1, 1) + 0.3 * half) * up;
      const double angle = slope + draw.uniform(-0.02, 0.02);
      const Vec2 velocity{draw.uniform(-1, 1), draw.uniform(-1, 0)};
      const Shape shape =
          box ? make_box({2 * half, 2 * radius}) : make_capsule({-half, 0}, {half, 0}, radius);
      const BodyId body =
          test::add(world, at, test::rough(shape, friction), 1, velocity, draw.uniform(-1, 1), angle);
      double turning = 0;
      for (int step = 0; step < 3840; ++step) {
        world.step(h);
        if (step > 3456) turning = std::max(turning, std::abs(world.omega(body)));
      }
      EXPECT_LT(turning, 1e-6) << (box ? "box " : "capsule ") << seed;
    }
  }
}

}  // namespace settling_test
}  // namespace skerry
