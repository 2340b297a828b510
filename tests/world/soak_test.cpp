// SPDX-License-Identifier: MIT
//
// Long runs of small worlds: no growth, in memory or in error. SKERRY_TEST_SCALE=500 makes 1e7 steps of each.
#include <cmath>
#include <gtest/gtest.h>
#include <malloc.h>

#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace soak_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;

const int kSteps = test_scale(20000);

/// Memory that the program holds [bytes].
std::size_t memory_in_use() {
  const struct mallinfo2 info = mallinfo2();
  return info.uordblks + info.hblkhd;
}

/// Steps a tenth of the way, then the rest, between which nothing may grow.
template <class AfterStep>
void soak(World& world, AfterStep&& after_step) {
  for (int i = 0; i < kSteps / 10; ++i) {
    world.step(1.0 / 60);
    after_step(i);
  }
  const std::size_t before = memory_in_use();
  for (int i = kSteps / 10; i < kSteps; ++i) {
    world.step(1.0 / 60);
    after_step(i);
  }
  // The heads of recycled lists may differ by a little; a leak of one byte a step would be seen.
  EXPECT_LE(memory_in_use(), before + static_cast<std::size_t>(kSteps) / 2);
}

TEST(Soak, AStackThatIsSolvedAtEveryStepStaysToTheBit) {
  WorldConfig config;
  config.sleep = config.reuse_resting = false;
  World world(config);
  add_ground(world, rough(make_disc(1), 0.5));
  for (int i = 0; i < 3; ++i) add(world, {0.1 * i, i + 0.5}, rough(make_box({1, 1}), 0.5));
  for (int i = 0; i < 10; ++i) world.step(1.0 / 60);
  const std::uint64_t hash = world.state_hash();
  soak(world, [](int) {});
  EXPECT_EQ(world.state_hash(), hash);
  EXPECT_LE(world.report().worst_residual, 1e-10);
}

TEST(Soak, ElasticBallsKeepTheirEnergyAndTheirBox) {
  World world(test::weightless());
  add_ground(world, smooth(make_disc(1), 1));
  const BodyId box = world.create_body({.type = BodyType::Static});
  world.add_shape(box, smooth(make_half_plane({0, 4}, {0, -1}), 1));
  world.add_shape(box, smooth(make_half_plane({0, 0}, {1, 0}), 1));
  world.add_shape(box, smooth(make_half_plane({4, 0}, {-1, 0}), 1));
  add(world, {1, 1}, smooth(make_disc(0.4), 1), 1, {1, 2});
  add(world, {3, 3}, smooth(make_disc(0.5), 1), 2, {-1.5, 0.5});
  const double energy = world.kinetic_energy();
  soak(world, [](int) {});
  // Rounding errors of impacts add up like a random walk at worst linearly: 1e-15 for each of about one a
  // step.
  EXPECT_NEAR(world.kinetic_energy(), energy, energy * 1e-15 * kSteps);
  for (const int i : {2, 3}) {
    const Vec2 at = world.bodies().position[static_cast<std::size_t>(i)];
    EXPECT_TRUE(at.x > 0 && at.x < 4 && at.y > 0 && at.y < 4) << at.x << ' ' << at.y;
  }
}

TEST(Soak, BodiesThatComeAndGoLeaveNothingBehind) {
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  std::vector<BodyId> bodies;
  soak(world, [&](int i) {
    if (i % 10 == 0) bodies.push_back(add(world, {0.2 * (i % 30), 1}, rough(make_disc(0.1), 0.3, 0.5)));
    if (bodies.size() > 5) {
      world.destroy(bodies.front());
      bodies.erase(bodies.begin());
    }
  });
  EXPECT_LE(world.bodies().size(), 8u);
}

}  // namespace soak_test
}  // namespace skerry
