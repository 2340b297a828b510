// SPDX-License-Identifier: MIT
//
// Bodies that fly.
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

#include "tests/support/pile.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace flight_test {

using test::add;
using test::add_ground;
using test::smooth;

TEST(Flight, IsAParabolaWhateverTheStep) {
  for (const double h : {1.0 / 10, 1.0 / 60, 1.0 / 1000}) {
    World world;
    const auto ball = add(world, {0, 0}, smooth(make_disc(0.1)), 1, {3, 20}, 2);
    const int steps = static_cast<int>(std::lround(2 / h));
    for (int i = 0; i < steps; ++i) world.step(h);
    EXPECT_NEAR(world.position(ball).x, 6, 1e-11);
    EXPECT_NEAR(world.position(ball).y, 40 - 0.5 * 9.81 * 4, 1e-11);
    EXPECT_NEAR(world.angle(ball), 4, 1e-11);
    EXPECT_EQ(world.report().islands_in_flight, 1);
    EXPECT_EQ(world.report().rows, 0);
  }
}

/// For an observer of paths bodies that fly alone are stepped as all islands are.
TEST(Flight, OfBodiesThatFlyAloneTellsWhatThatOfAnyIslandDoes) {
  for (const double bounce : {0.6, 0.8}) {
    World worlds[2];
    for (World& world : worlds) {
      test::add_pit(world, bounce);
      test::add_pile(world, 280, bounce);
    }
    worlds[1].observe({.paths = true});
    int alone = 0, retries = 0;
    for (int step = 0; step < 60; ++step) {
      const StepReport& r = worlds[0].step(1.0 / 60);
      const StepReport& other = worlds[1].step(1.0 / 60);
      ASSERT_EQ(r.state_hash, other.state_hash) << bounce << ", step " << step;
      alone += r.islands_in_flight;
      retries += r.island_retries;
      EXPECT_EQ(r.islands_in_flight, other.islands_in_flight) << bounce << ", step " << step;
      EXPECT_EQ(r.island_retries, other.island_retries) << bounce << ", step " << step;
      EXPECT_EQ(r.islands, other.islands) << bounce << ", step " << step;
      EXPECT_EQ(r.substeps, other.substeps) << bounce << ", step " << step;
      EXPECT_EQ(r.contacts, other.contacts) << bounce << ", step " << step;
      EXPECT_EQ(r.work.visits, other.work.visits) << bounce << ", step " << step;
      ASSERT_EQ(r.islands_list.size(), other.islands_list.size());
      for (std::size_t n = 0; n < r.islands_list.size(); ++n) {
        const IslandReport &x = r.islands_list[n], &y = other.islands_list[n];
        EXPECT_EQ(x.bodies, y.bodies) << n;
        EXPECT_EQ(x.contacts, y.contacts) << n;
        EXPECT_EQ(x.stepper, y.stepper) << n;
        EXPECT_EQ(x.method, y.method) << n;
        EXPECT_EQ(x.status, y.status) << n;
        EXPECT_EQ(x.flowing, y.flowing) << n;
      }
    }
    EXPECT_GT(alone, 500) << bounce;
    EXPECT_GT(retries, 3) << bounce;
  }
}

TEST(Flight, BouncingBallKeepsItsHeightForAHundredBounces) {
  World world;
  add_ground(world, smooth(make_disc(1), 1));
  const auto ball = add(world, {0, 1.5}, smooth(make_disc(0.5), 1));
  const double energy = world.kinetic_energy() + world.potential_energy();
  double top = 0;
  int bounces = 0;
  while (bounces < 100) {
    bounces += world.step(1.0 / 60).impacts;
    top = world.position(ball).y + world.velocity(ball).y * world.velocity(ball).y / (2 * 9.81);
  }
  EXPECT_NEAR(top, 1.5, 1e-9);
  EXPECT_NEAR(world.kinetic_energy() + world.potential_energy(), energy, 1e-9);
}

}  // namespace flight_test
}  // namespace skerry
