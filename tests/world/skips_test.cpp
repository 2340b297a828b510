// SPDX-License-Identifier: MIT
//
// Work that is left out must not show: worlds with each skip off, against the world with all of them.
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <random>

#include "tests/support/draw.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace skips_test {

using test::add;
using test::add_ground;
using test::rough;

struct Switch {
  const char* name;
  void (*off)(WorldConfig& config);
  double tolerance;  ///< of positions after 40 steps [m]; 0: the same bits
};

void PrintTo(const Switch& s, std::ostream* out) {
  *out << s.name;
}

const Switch kSwitches[] = {
    {"Sleep", [](WorldConfig& c) { c.sleep = false; }, 0},
    {"Resting", [](WorldConfig& c) { c.reuse_resting = false; }, 0},
    {"Manifolds", [](WorldConfig& c) { c.skips.manifolds = false; }, 0},
    {"Axes", [](WorldConfig& c) { c.skips.axes = false; }, 0},
    {"Alike", [](WorldConfig& c) { c.skips.alike = false; }, 1e-9},
    {"Flight", [](WorldConfig& c) { c.skips.flight = false; }, 1e-9},
    {"Factors", [](WorldConfig& c) { c.skips.factors = false; }, 1e-9},
    // Rows that carry nothing make islands go to another rung; a landing found a little later is amplified.
    {"SmoothRows", [](WorldConfig& c) { c.skips.smooth_rows = false; }, 1e-4},
};

/// Rough boxes and smooth discs that fall beside a stack.
World make_world(const WorldConfig& config, unsigned seed, int falling) {
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (random() / 4294967296.0);
  };
  World world(config);
  add_ground(world, rough(make_disc(1), 0.4));
  for (int i = 0; i < 4; ++i) add(world, {0, i + 0.5}, rough(make_box({1, 1}), 0.4));
  for (int i = 0; i < falling; ++i) {
    const double size = uniform(0.3, 0.8);
    const bool box = i % 2 == 0;
    const ShapeDef shape = rough(box ? make_box({size, size}) : make_disc(size / 2), box ? 0.4 : 0);
    add(world, {2.0 + 1.2 * i, 0.6 + uniform(0, 1)}, shape, uniform(0.5, 2), {uniform(-1, 1), 0},
        uniform(-1, 1));
  }
  return world;
}

class EverySkip : public testing::TestWithParam<Switch> {};

TEST_P(EverySkip, ChangesNothingWhenItIsOff) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    WorldConfig off;
    GetParam().off(off);
    World with = make_world({}, seed, 6), without = make_world(off, seed, 6);
    double worst = 0;
    for (int step = 0; step < 40; ++step) {
      with.step(1.0 / 60);
      without.step(1.0 / 60);
      if (GetParam().tolerance == 0) {
        ASSERT_EQ(with.state_hash(), without.state_hash()) << "step " << step;
      }
      for (std::size_t i = 0; i < with.bodies().size(); ++i)
        worst = std::max(worst, length(with.bodies().position[i] - without.bodies().position[i]));
    }
    EXPECT_LE(worst, GetParam().tolerance);
  }
}

TEST_P(EverySkip, ChangesNothingAtRest) {
  WorldConfig off;
  GetParam().off(off);
  World world = make_world(off, 1, 0);
  for (int step = 0; step < 60; ++step) world.step(1.0 / 60);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(world.position(world.body_id(1 + i)).y, i + 0.5, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Skips, EverySkip, testing::ValuesIn(kSwitches),
                         [](const testing::TestParamInfo<Switch>& test) { return test.param.name; });

// Whoever turns the traces on to look at a pile must see the pile that falls when nobody looks.
TEST(Skips, NoObserverChangesAPileInFlow) {
  for (const char* solver : {"auto", "pgs", "nncg", "tgs_soft"}) {
    SCOPED_TRACE(solver);
    WorldConfig config;
    config.solver = solver;
    World alone(config), observed(config);
    observed.observe(
        {.contacts = true, .systems = true, .solve_traces = true, .stage_times = true, .paths = true});
    for (World* world : {&alone, &observed}) {
      const ShapeDef box = rough(make_box({1, 1}), 0.5);
      add_ground(*world, box);
      for (int i = 0; i < 60; ++i) {
        const int row = i / 6;
        add(*world, {1.05 * (i % 6) + 0.1 * (row % 2), 0.6 + 1.1 * row}, box, 1, {i % 6 - 2.5, -3});
      }
    }
    int flowing = 0;
    for (int step = 0; step < 40; ++step) {
      alone.step(1.0 / 60);
      observed.step(1.0 / 60);
      flowing += alone.report().islands_in_flow;
      ASSERT_EQ(observed.state_hash(), alone.state_hash()) << "step " << step;
      for (const IslandTrace& island : observed.report().traces) {
        if (island.trace == nullptr || island.trace->iterations.empty()) continue;
        EXPECT_TRUE(std::isfinite(island.trace->iterations.back().residual));
      }
    }
    EXPECT_GT(flowing, 10);
  }
}

/// A world that keeps manifolds of what has not moved, and one that makes all of them anew.
struct KeptAndMade {
  World kept, made;

  explicit KeptAndMade(const WorldConfig& config = {}) : kept(config), made(without_manifolds(config)) {}

  static WorldConfig without_manifolds(WorldConfig config) {
    config.skips.manifolds = false;
    return config;
  }
};

TEST(Skips, OfManifoldsChangesNoBitInFlow) {
  // Overlaps are taken out by shifts that may be below the rounding of a place: the manifold is another one
  // all the same.
  for (unsigned seed = 0; seed < 10; ++seed) {
    KeptAndMade worlds;
    for (World* world : {&worlds.kept, &worlds.made}) {
      test::Draw draw(seed);
      add_ground(*world, rough(make_disc(1), 0.5));
      const BodyId walls = world->create_body({.type = BodyType::Static});
      for (const double side : {-1.0, 1.0})
        world->add_shape(walls, rough(make_half_plane({2 * side, 0}, {-side, 0}), 0.5));
      for (int i = 0; i < 30; ++i) {
        const int row = i / 5;
        const double size = draw.uniform(0.25, 0.6), x = -1.5 + 0.7 * (i % 5) + draw.uniform(-0.03, 0.03);
        const Shape shape =
            draw.one_in(3) ? make_disc(0.5 * size) : make_box({size, draw.uniform(0.3, 1) * size});
        add(*world, {x, 0.6 + 0.7 * row}, rough(shape, 0.5), 1, {}, 0, draw.uniform(0, 6));
      }
    }
    for (int step = 0; step < 120; ++step) {
      worlds.kept.step(1.0 / 60);
      worlds.made.step(1.0 / 60);
      ASSERT_EQ(worlds.kept.state_hash(), worlds.made.state_hash()) << "seed " << seed << ", step " << step;
    }
  }
}

TEST(Skips, OfManifoldsChangesNoBitAfterAnotherMass) {
  // The centre of mass is found again, off by rounding: shapes move by that, and their body does not.
  for (unsigned seed = 0; seed < 10; ++seed) {
    WorldConfig config;
    config.reuse_resting = false;
    config.flow_work = 0;
    KeptAndMade worlds(config);
    for (World* world : {&worlds.kept, &worlds.made}) {
      test::Draw draw(seed);
      add_ground(*world, rough(make_disc(1), 0.5));
      for (int i = 0; i < 6; ++i) {
        BodyDef def;
        def.position = {draw.uniform(-0.2, 0.2), 0.5 + 0.6 * i};
        def.angle = draw.uniform(-0.1, 0.1);
        const BodyId body = world->create_body(def);
        const double size = draw.uniform(0.4, 0.6);
        world->add_shape(body, rough(make_box({size, 0.3 * size}, {0, -0.35 * size}), 0.5));
        world->add_shape(body, rough(make_box({0.3 * size, 0.7 * size}, {-0.35 * size, 0.15 * size}), 0.5));
        world->add_shape(body, rough(make_disc(0.1 * size, {0.3 * size, 0}), 0.5));
      }
    }
    test::Draw draw(seed + 7);
    for (int step = 0; step < 200; ++step) {
      if (step > 60 && step % 5 == 0) {
        const auto body = static_cast<std::uint32_t>(1 + draw.pick(6));
        const double mass = draw.uniform(50, 150);
        for (World* world : {&worlds.kept, &worlds.made}) world->set_mass(world->body_id(body), mass);
      }
      worlds.kept.step(1.0 / 60);
      worlds.made.step(1.0 / 60);
      ASSERT_EQ(worlds.kept.state_hash(), worlds.made.state_hash()) << "seed " << seed << ", step " << step;
    }
  }
}

TEST(Skips, AreCounted) {
  WorldConfig awake;
  awake.sleep = false;
  World world = make_world(awake, 1, 0);
  for (int step = 0; step < 5; ++step) world.step(1.0 / 60);
  EXPECT_GT(world.report().manifolds_reused, 0);
  WorldConfig off = awake;
  off.skips.manifolds = false;
  World slow = make_world(off, 1, 0);
  for (int step = 0; step < 5; ++step) slow.step(1.0 / 60);
  EXPECT_EQ(slow.report().manifolds_reused, 0);
  EXPECT_EQ(slow.report().islands_at_rest, 0);
}

}  // namespace skips_test
}  // namespace skerry
