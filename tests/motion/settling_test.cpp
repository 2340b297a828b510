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

}  // namespace settling_test
}  // namespace skerry
