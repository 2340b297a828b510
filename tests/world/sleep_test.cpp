// SPDX-License-Identifier: MIT
//
// Sleep must never show: the same bits with and without it, whatever the user does, and nothing to do while
// everything sleeps. The same for islands that are awake and kept as they are.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "physics/snapshot.h"
#include "physics/stepping/stepper.h"
#include "tests/support/draw.h"
#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace sleep_test {

using test::add;
using test::add_ground;
using test::rough;

WorldConfig with_sleep(bool sleep) {
  WorldConfig config;
  config.sleep = sleep;
  return config;
}

/// Stacks of boxes, 3 m apart.
std::vector<BodyId> add_stacks(World& world, int stacks, int height) {
  std::vector<BodyId> boxes;
  for (int i = 0; i < stacks; ++i) {
    for (int k = 0; k < height; ++k) {
      boxes.push_back(add(world, {3.0 * i, 0.5 + k}, rough(make_box({1, 1}), 0.5)));
    }
  }
  return boxes;
}

void step(World& world, int steps) {
  for (int i = 0; i < steps; ++i) world.step(1.0 / 60);
}

TEST(Sleep, IslandsAtRestLeaveTheWorkingSetAndKeepTheirForces) {
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  add_stacks(world, 4, 3);
  step(world, 10);
  world.observe({.contacts = true});
  const StepReport& report = world.step(1.0 / 60);
  EXPECT_EQ(report.islands_asleep, 4);
  EXPECT_EQ(report.bodies_asleep, 12);
  EXPECT_EQ(report.islands, 4);
  EXPECT_EQ(report.islands_list.size(), 4u);
  EXPECT_EQ(report.contacts, 12);
  ASSERT_EQ(report.contacts_list.size(), 12u);
  double weight = 0;
  for (const ContactReport& contact : report.contacts_list) {
    for (int i = 0; i < contact.count; ++i) weight += contact.points[i].normal_impulse;
  }
  // Each stack carries 3, 2 and 1 boxes of 1 kg.
  EXPECT_NEAR(weight, 4 * 6 * 9.81 / 60, 1e-9);
  EXPECT_NEAR(report.total_normal_impulse, weight, 1e-12);
}

TEST(Sleep, OnlyTheStruckIslandWakes) {
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  const auto boxes = add_stacks(world, 3, 2);
  step(world, 10);
  add(world, {3.0, 6}, rough(make_disc(0.3), 0.5));
  bool struck = false;
  for (int i = 0; i < 120; ++i) {
    world.step(1.0 / 60);
    EXPECT_TRUE(world.asleep(boxes[0])) << i;
    EXPECT_TRUE(world.asleep(boxes[5])) << i;
    struck |= !world.asleep(boxes[3]);
  }
  EXPECT_TRUE(struck);
}

TEST(Sleep, WhateverTheUserDoesToABodyWakesItsIsland) {
  const auto wakes = [](auto&& act) {
    World world;
    const BodyId ground = add_ground(world, rough(make_disc(1), 0.5));
    const auto boxes = add_stacks(world, 1, 2);
    const BodyId other = add(world, {20, 0.5}, rough(make_box({1, 1}), 0.5));
    step(world, 10);
    EXPECT_TRUE(world.asleep(boxes[0]));
    act(world, boxes[1], ground, other);
    return !world.asleep(boxes[0]);
  };
  EXPECT_TRUE(wakes([](World& w, BodyId b, BodyId, BodyId) { w.apply_force(b, {1, 0}, w.position(b)); }));
  EXPECT_TRUE(wakes([](World& w, BodyId b, BodyId, BodyId) { w.apply_torque(b, 1); }));
  EXPECT_TRUE(wakes([](World& w, BodyId b, BodyId, BodyId) { w.apply_impulse(b, {1, 0}, w.position(b)); }));
  EXPECT_TRUE(wakes([](World& w, BodyId b, BodyId, BodyId) { w.set_velocity(b, {1, 0}, 0); }));
  EXPECT_TRUE(wakes([](World& w, BodyId b, BodyId, BodyId) { w.set_pose(b, {0, 3}, 0); }));
  EXPECT_TRUE(wakes([](World& w, BodyId b, BodyId, BodyId) { w.add_shape(b, {.shape = make_disc(0.1)}); }));
  EXPECT_TRUE(wakes([](World& w, BodyId b, BodyId, BodyId) { w.destroy(b); }));
  EXPECT_TRUE(wakes([](World& w, BodyId b, BodyId, BodyId) { w.wake(b); }));
  EXPECT_TRUE(wakes([](World& w, BodyId, BodyId g, BodyId) { w.set_pose(g, {0, -1}, 0); }));
  EXPECT_TRUE(wakes([](World& w, BodyId, BodyId g, BodyId) { w.destroy(g); }));
  EXPECT_TRUE(wakes([](World& w, BodyId, BodyId, BodyId) { w.set_gravity({0, -5}); }));
  EXPECT_TRUE(wakes([](World& w, BodyId b, BodyId, BodyId o) {
    w.create_joint(
        {.kind = JointKind::Rope, .a = o, .b = b, .anchor_a = w.position(o), .anchor_b = w.position(b)});
  }));
  // The other island is none of their business.
  EXPECT_FALSE(wakes([](World& w, BodyId, BodyId, BodyId o) { w.apply_torque(o, 1); }));
}

TEST(Sleep, AnotherStepLengthWakesAll) {
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  const auto boxes = add_stacks(world, 2, 2);
  step(world, 10);
  EXPECT_EQ(world.step(1.0 / 60).islands_asleep, 2);
  EXPECT_EQ(world.step(1.0 / 120).islands_asleep, 0);
  EXPECT_NEAR(world.position(boxes[1]).y, 1.5, 1e-12);
}

TEST(Sleep, AKinematicTableThatStartsMovingWakesWhatStandsOnIt) {
  World world;
  const BodyId table = world.create_body({.type = BodyType::Kinematic, .position = {0, -0.5}});
  world.add_shape(table, rough(make_box({4, 1}), 0.5));
  const BodyId box = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5));
  step(world, 10);
  EXPECT_TRUE(world.asleep(box));
  world.set_velocity(table, {0, 1}, 0);
  step(world, 30);
  EXPECT_NEAR(world.position(box).y, 1.0, 1e-9);
  EXPECT_FALSE(world.asleep(box));
}

/// A lift that waits for half a second, goes up by half a metre within a second, and waits again. After two
/// seconds it is three metres farther up.
Placement lift(double t) {
  const double s = std::clamp(t - 0.5, 0.0, 1.0);
  return {{0, 0.5 * (3 - 2 * s) * s * s - 0.5 + (t < 2 ? 0 : 3)}, 0};
}

TEST(Sleep, WhatLiesOrHangsOnALiftThatWaitsSleepsUntilItSetsOff) {
  for (const char* stepper : {"time_stepping", "event_driven"}) {
    WorldConfig config;
    config.stepper = stepper;
    World world(config);
    const BodyId table = world.create_body({.type = BodyType::Kinematic, .position = {0, -0.5}});
    world.add_shape(table, rough(make_box({4, 1}), 0.5));
    const BodyId box = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5));
    const BodyId bob = add(world, {3, -1.5}, rough(make_disc(0.1), 0));
    world.create_joint(
        {.kind = JointKind::Revolute, .a = table, .b = bob, .anchor_a = {3, 0}, .anchor_b = {0, 1}});
    world.set_motion(table, lift);
    std::vector<int> asleep;
    for (int i = 1; i <= 180; ++i) {
      world.step(1.0 / 60);
      asleep.push_back(world.report().bodies_asleep);
      if (i >= 120) continue;
      EXPECT_NEAR(world.position(box).y, lift(world.time()).position.y + 1, 1e-6)
          << stepper << ", step " << i;
    }
    EXPECT_EQ(asleep[28], 2) << stepper;
    EXPECT_EQ(asleep[30], 0) << stepper;
    EXPECT_EQ(asleep[88], 0) << stepper;
    EXPECT_EQ(asleep[110], 2) << stepper;
    // What it jumps away from falls, what hangs on it comes along.
    EXPECT_EQ(asleep[179], 1) << stepper;
    EXPECT_NEAR(world.position(bob).y, lift(3).position.y - 1, 1e-9) << stepper;
    EXPECT_LT(world.position(box).y, -2) << stepper;
  }
}

TEST(Sleep, StepsInWhichAMotionThrowsChangeNothing) {
  bool fails = false;
  int asleep = 0;
  std::vector<World> worlds(2);
  for (std::size_t k = 0; k < 2; ++k) {
    World& world = worlds[k];
    const BodyId table = world.create_body({.type = BodyType::Kinematic, .position = {0, -0.5}});
    world.add_shape(table, rough(make_box({4, 1}), 0.5));
    add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5));
    world.set_motion(table, lift);
    const BodyId other = world.create_body({.type = BodyType::Kinematic, .position = {10, 0}});
    world.set_motion(other, [&fails, k](double) {
      if (k == 0 && fails) throw std::runtime_error("no such place");
      return Placement{{10, 0}, 0};
    });
  }
  for (int i = 0; i < 110; ++i) {
    if (i % 3 == 0) {
      fails = true;
      EXPECT_THROW(worlds[0].step(1.0 / 60), std::runtime_error);
      fails = false;
    }
    for (World& world : worlds) world.step(1.0 / 60);
    ASSERT_EQ(worlds[0].state_hash(), worlds[1].state_hash()) << i;
    asleep += worlds[0].report().bodies_asleep;
  }
  EXPECT_GT(asleep, 20);
}

TEST(Sleep, WhatRestsAwakeIsKeptUntilItsGroundIsMoved) {
  World world(with_sleep(false));
  const BodyId table = world.create_body({.type = BodyType::Static, .position = {0, 0.5}});
  world.add_shape(table, rough(make_box({4, 1}), 0.5));
  const BodyId box = add(world, {0, 1.5}, rough(make_box({1, 1}), 0.5));
  const BodyId far = add(world, {50, 0.5}, rough(make_disc(0.5), 0.5));
  add_ground(world, rough(make_disc(1), 0.5));
  step(world, 10);
  const std::uint64_t before = world.state_hash();
  step(world, 10);
  EXPECT_EQ(world.state_hash(), before);
  EXPECT_EQ(world.report().islands_at_rest, 2);
  EXPECT_EQ(world.report().manifolds_reused, world.report().pairs);
  world.set_pose(table, {0, -3}, 0);
  step(world, 10);
  EXPECT_LT(world.position(box).y, 1.5);
  EXPECT_EQ(world.position(far).y, 0.5);
}

/// Random worlds with random calls: each step has the same bits with sleep and without, and where every
/// island is stepped every time.
class SleepChangesNothing : public testing::TestWithParam<const char*> {};

TEST_P(SleepChangesNothing, WhateverHappens) {
  const std::uint32_t trials = static_cast<std::uint32_t>(test_scale(8));
  long asleep = 0, kept = 0;
  for (std::uint32_t seed = 1; seed <= trials; ++seed) {
    std::mt19937 random(seed);
    // What is as small as this falls far in a step, for its margins.
    const double scale = seed % 4 == 0 ? 0.01 : 1;
    const auto uniform = [&](double low, double high) {
      return low + (high - low) * static_cast<double>(random()) / 4294967296.0;
    };
    std::vector<World> worlds;
    for (const int kind : {0, 1, 2}) {
      WorldConfig config = with_sleep(kind == 0);
      config.stepper = GetParam();
      config.contact_margin *= scale;
      config.threads = kind == 0 ? 2 : 1;
      config.reuse_resting = kind != 2;
      config.sleep_speed = seed % 3 == 0 ? 0.05 : 0;
      worlds.emplace_back(config);
    }
    std::vector<std::vector<BodyId>> bodies(3);
    std::vector<BodyId> tables;
    const auto each = [&](auto&& call) {
      for (std::size_t k = 0; k < worlds.size(); ++k) call(worlds[k], bodies[k]);
    };
    each([&](World& w, std::vector<BodyId>&) {
      tables.push_back(w.create_body({.type = BodyType::Static, .position = scale * Vec2{5, 0.1}}));
      w.add_shape(tables.back(), rough(make_box({4 * scale, 0.2 * scale}), 0.5));
    });
    each([](World& w, std::vector<BodyId>&) { add_ground(w, rough(make_disc(1), 0.5)); });
    const double waits = uniform(0.5, 1), jumps = uniform(2, 3);
    const auto told = [=](double t) {
      const double up = std::clamp(t - waits, 0.0, 1.0), turned = t > jumps ? 0.1 : 0;
      return Placement{scale * Vec2{-5, 0.1 + 0.3 * up}, turned};
    };
    each([&](World& w, std::vector<BodyId>&) {
      const BodyId table = w.create_body({.type = BodyType::Kinematic, .position = scale * Vec2{-5, 0.1}});
      w.add_shape(table, rough(make_box({4 * scale, 0.2 * scale}), 0.5));
      w.set_motion(table, told);
    });
    const auto drop = [&] {
      const Vec2 at{scale * std::round(uniform(-8, 8)), scale * uniform(0.5, 4)};
      const bool disc = random() % 3 == 0;
      const double size = scale * uniform(0.4, 0.9);
      each([&](World& w, std::vector<BodyId>& all) {
        all.push_back(add(w, at, rough(disc ? make_disc(size / 2) : make_box({size, size}), 0.5)));
      });
    };
    for (int i = 0; i < 12; ++i) drop();
    for (int i = 0; i < 240; ++i) {
      if (random() % 12 == 0) {
        const std::size_t pick = random() % bodies[0].size();
        const Vec2 value{uniform(-2, 2), uniform(-1, 2)}, way = scale * value;
        const auto what = random() % 11;
        const std::size_t other = random() % bodies[0].size();
        each([&](World& w, std::vector<BodyId>& all) {
          if (!w.alive(all[pick])) return;
          if (what == 0) w.apply_impulse(all[pick], way, w.position(all[pick]));
          if (what == 1) w.apply_force(all[pick], 20 * way, w.position(all[pick]));
          if (what == 2) w.set_pose(all[pick], w.position(all[pick]) + Vec2{0, 1.5 * scale}, 0);
          if (what == 3) w.destroy(all[pick]);
          if (what == 4) w.set_velocity(all[pick], way, value.x);
          if (what == 5) w.set_gravity({0, -9.81 + 0.1 * value.x});
          if (what == 6) w.wake(all[pick]);
          if (what == 7) w.set_pose(tables[0], w.position(tables[0]) + Vec2{0, 0.01 * way.x}, 0);
          if (what == 8) w.set_drag(all[pick], {.quadratic = value.y > 0 ? 0.1 : 0.0});
          if (what == 9) w.set_accuracy(value.x > 1 ? std::optional<double>(1e-3) : std::nullopt);
          if (what == 10 && other != pick && w.alive(all[other])) {
            w.create_joint({.kind = JointKind::Revolute,
                            .a = all[pick],
                            .b = all[other],
                            .anchor_a = value.x > 0 ? w.position(all[pick]) : Vec2{}});
          }
        });
      }
      if (random() % 40 == 0) drop();
      if (i == 150 && seed % 2) {
        World loaded = load_snapshot(save_snapshot(worlds[0]));
        loaded.adopt(worlds[0].callbacks());
        worlds[0] = std::move(loaded);
      }
      const double h = i == 200 ? 1.0 / 90 : 1.0 / 60;
      const StepReport& with = worlds[0].step(h);
      const StepReport& without = worlds[1].step(h);
      ASSERT_EQ(without.state_hash, worlds[2].step(h).state_hash) << "seed " << seed << ", step " << i;
      kept += without.islands_at_rest;
      ASSERT_EQ(with.state_hash, without.state_hash) << "seed " << seed << ", step " << i;
      ASSERT_EQ(with.potential_energy, without.potential_energy) << "seed " << seed << ", step " << i;
      ASSERT_EQ(with.islands, without.islands) << "seed " << seed << ", step " << i;
      ASSERT_EQ(with.contacts, without.contacts) << "seed " << seed << ", step " << i;
      ASSERT_EQ(with.rows, without.rows) << "seed " << seed << ", step " << i;
      ASSERT_EQ(with.islands_at_rest, without.islands_at_rest) << "seed " << seed << ", step " << i;
      ASSERT_EQ(without.islands_asleep, 0);
      ASSERT_EQ(with.state_hash, worlds[0].state_hash()) << "kept sums, seed " << seed << ", step " << i;
      asleep += with.islands_asleep;
    }
  }
  EXPECT_GT(std::min(asleep, kept), 100 * trials);  // otherwise this tests nothing
}

INSTANTIATE_TEST_SUITE_P(Sleep, SleepChangesNothing, testing::Values("time_stepping", "event_driven", "auto"),
                         [](const auto& instance) { return std::string(instance.param); });

TEST(Sleep, NearIslandsThatFellAsleepOneAfterTheOtherShareTheirContactOnWaking) {
  // Two boxes 2 mm apart, near enough to be a pair; the second falls asleep later. Then the first is pushed.
  for (const bool sleep : {true, false}) {
    World world(with_sleep(sleep));
    add_ground(world, rough(make_disc(1), 0.5));
    const BodyId left = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5));
    step(world, 10);
    const BodyId right = add(world, {1.002, 0.5}, rough(make_box({1, 1}), 0.5));
    step(world, 10);
    EXPECT_EQ(world.asleep(left) && world.asleep(right), sleep);
    world.apply_impulse(left, {1, 0}, world.position(left));
    step(world, 1);
    EXPECT_FALSE(world.asleep(right));
    EXPECT_GT(world.velocity(right).x, 0);
  }
}

/// What is counted and summed up over sleepers, as their neighbours come, go, and are woken one by one.
std::vector<double> counts_of_neighbours(unsigned seed, bool sleep) {
  test::Draw draw(seed);
  const double gap = 0.005 * (seed % 40);
  const auto radius = [](int k) { return k % 2 == 0 ? 1.0 : 0.1; };
  const auto place = [&](int k, double up) { return Vec2{(0.7 + gap) * k, radius(k) + up}; };
  World world(with_sleep(sleep));
  add_ground(world, rough(make_disc(1), 0.5));
  std::vector<BodyId> discs(6);
  std::vector<double> seen;
  for (int act = 0; act < 30; ++act) {
    const int k = draw.pick(6), what = draw.pick(4);
    BodyId& disc = discs[static_cast<std::size_t>(k)];
    if (!disc) {
      disc = add(world, place(k, 0), rough(make_disc(radius(k)), 0.5));
    } else if (what == 0) {
      world.destroy(disc);
      disc = {};
    } else if (what == 1) {
      world.set_pose(disc, place(k, 3), 0);
    } else if (what == 2) {
      world.set_pose(disc, place(k, 0), 0);
      world.set_velocity(disc, {}, 0);
    } else {
      world.wake(disc);
    }
    for (int i = 0; i < 4; ++i) {
      const StepReport& report = world.step(1.0 / 60);
      for (const int count :
           {report.pairs, report.pairs_out_of_reach, report.contacts, report.contact_points, report.rows})
        seen.push_back(count);
      for (const double sum : {report.total_normal_impulse, report.total_friction_impulse,
                               report.worst_penetration, report.worst_residual})
        seen.push_back(sum);
    }
  }
  return seen;
}

TEST(Sleep, NeighboursThatComeAndGoAreCountedAsWithoutIt) {
  for (unsigned seed = 1; seed <= 160; ++seed) {
    const std::vector<double> with = counts_of_neighbours(seed, true),
                              without = counts_of_neighbours(seed, false);
    ASSERT_EQ(with.size(), without.size());
    for (std::size_t i = 0; i < with.size(); ++i) {
      ASSERT_NEAR(with[i], without[i], 1e-11 * std::abs(without[i]) + 1e-13)
          << "seed " << seed << ", step " << i / 9 << ", number " << i % 9;
    }
  }
}

TEST(Sleep, PairsWithWhatIsToldToMoveStayAwake) {
  std::vector<int> pairs[2];
  for (const bool sleep : {true, false}) {
    World world(with_sleep(sleep));
    add_ground(world, rough(make_disc(1), 0.5));
    add(world, {0, 1}, rough(make_disc(1), 0.5));
    const BodyId told =
        world.create_body({.type = BodyType::Kinematic, .position = {-1.9, 2.9}, .velocity = {0.5, 0}});
    world.add_shape(told, rough(make_disc(1), 0.5));
    for (int i = 0; i < 120; ++i) {
      if (i == 60) world.set_velocity(told, {-5, 0}, 0);
      world.step(1.0 / 60);
      pairs[sleep ? 1 : 0].push_back(world.report().pairs);
    }
  }
  EXPECT_EQ(pairs[0], pairs[1]);
}

TEST(Sleep, ReportsOfWhatLiesInAZoneAndOnASlopeAreTheSame) {
  std::vector<double> seen[2];
  for (const bool sleep : {true, false}) {
    World world(with_sleep(sleep));
    add_ground(world, rough(make_disc(1), 0.5), 0.2);
    for (const double x : {0.0, 3.0, -3.0})
      add(world, rotate(Rot::from_angle(0.2), {x, 0.5}), rough(make_box({1, 1}), 0.5), 1, {}, 0, 0.2);
    const BodyId zone = world.create_body({.type = BodyType::Static});
    world.add_shape(zone, {.shape = make_box({20, 20}), .sensor = true});
    step(world, 60);
    const StepReport& report = world.report();
    EXPECT_EQ(report.bodies_asleep, sleep ? 3 : 0);
    seen[sleep ? 1 : 0] = {static_cast<double>(report.pairs), static_cast<double>(report.pairs_out_of_reach),
                           report.total_friction_impulse, report.total_normal_impulse};
  }
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(seen[0][k], seen[1][k], 1e-12) << k;
}

TEST(Sleep, WhatHangsOnWhatTheUserMovesWakes) {
  for (const BodyType type : {BodyType::Static, BodyType::Kinematic}) {
    for (const char* act : {"set_pose", "set_velocity", "set_type"}) {
      const bool moves = act == std::string("set_velocity"), is_other = act == std::string("set_type");
      if (moves && type == BodyType::Static) continue;
      if (is_other && type == BodyType::Kinematic) continue;
      World world;
      const BodyId hook = world.create_body({.type = type});
      const BodyId bob = add(world, {0, -1}, rough(make_disc(0.1), 0));
      world.create_joint({.kind = JointKind::Revolute, .a = hook, .b = bob});
      step(world, 20);
      ASSERT_TRUE(world.asleep(bob));
      if (is_other) world.set_type(hook, BodyType::Kinematic);
      if (moves || is_other)
        world.set_velocity(hook, {0.5, 0}, 0);
      else
        world.set_pose(hook, {0.5, 0}, 0);
      step(world, 20);
      EXPECT_GT(world.position(bob).x, 1e-4) << act;
    }
  }
}

TEST(Sleep, HoldsForTheLengthOfTheStepsInWhichItBegan) {
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5));
  for (const double h : {1.0 / 60, 1.0 / 120, 1.0 / 60}) {
    for (int i = 0; i < 10; ++i) {
      const StepReport& report = world.step(h);
      if (i == 0 || i == 9) {
        EXPECT_EQ(report.islands_asleep, i == 0 ? 0 : 1) << h << " " << i;
      }
      EXPECT_NEAR(report.total_normal_impulse, 9.81 * h, 1e-9) << h << " " << i;
    }
  }
}

TEST(Sleep, ABarThatTurnsInItsPlaceWakesWhatItComesTo) {
  // Its box lies over that of the sleeper from the beginning, and its centre stays.
  std::vector<double> seen[2];
  for (const bool sleep : {true, false}) {
    World world(with_sleep(sleep));
    add_ground(world, rough(make_disc(1), 0.5));
    const BodyId box = add(world, {0.6, 0.15}, rough(make_box({0.3, 0.3}), 0.5));
    const BodyId bar = world.create_body({.type = BodyType::Kinematic, .position = {0, 2}, .angle = 1.2});
    world.add_shape(bar, rough(make_box({4, 0.1}), 0.5));
    world.set_velocity(bar, {}, 0.2);
    bool slept = false, wakes = false;
    for (int i = 0; i < 400; ++i) {
      const StepReport& report = world.step(1.0 / 60);
      slept |= world.asleep(box);
      wakes |= slept && !world.asleep(box);
      for (const double number : {static_cast<double>(report.pairs), static_cast<double>(report.contacts),
                                  report.total_normal_impulse, world.position(box).x})
        seen[sleep ? 1 : 0].push_back(number);
    }
    EXPECT_EQ(slept && wakes, sleep);
    EXPECT_GT(length(world.position(box) - Vec2{0.6, 0.15}), 0.1);
  }
  for (std::size_t k = 0; k < seen[0].size(); ++k)
    ASSERT_NEAR(seen[0][k], seen[1][k], 1e-11 * std::abs(seen[1][k]) + 1e-13)
        << "step " << k / 4 << ", number " << k % 4;
}

TEST(Sleep, SleepersHaveNoNumberOfAnIsland) {
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  std::vector<BodyId> boxes;
  boxes.reserve(3);
  for (int i = 0; i < 3; ++i) boxes.push_back(add(world, {2.0 * i, 0.5}, rough(make_box({1, 1}), 0.5)));
  add(world, {20, 100}, rough(make_disc(0.5), 0.5));
  step(world, 10);
  for (const BodyId box : boxes) {
    ASSERT_TRUE(world.asleep(box));
    EXPECT_EQ(world.bodies().island[box.index], -1);
  }
  // But in the list that is made for an observer.
  world.observe({.contacts = true});
  step(world, 1);
  for (const BodyId box : boxes) EXPECT_GE(world.bodies().island[box.index], 0);
  world.observe({});
  step(world, 1);
  for (const BodyId box : boxes) EXPECT_EQ(world.bodies().island[box.index], -1);
}

TEST(Sleep, GroundThatIsYoungerThanWhatLiesOnItWakesIt) {
  World world;
  const BodyId box = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5));
  const BodyId ground = add_ground(world, rough(make_disc(1), 0.5));
  step(world, 10);
  ASSERT_TRUE(world.asleep(box));
  world.set_pose(ground, {0, -1}, 0);
  step(world, 10);
  EXPECT_LT(world.position(box).y, 0.45);
}

TEST(Sleep, AJointInThePlaceOfAnotherOneIsAnotherOne) {
  // A rope that hangs loose is exchanged for a spring that lifts the box.
  for (const bool sleep : {true, false}) {
    World world(with_sleep(sleep));
    add_ground(world, rough(make_disc(1), 0.5));
    const BodyId box = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5));
    JointDef def{.kind = JointKind::Rope, .b = box, .anchor_a = {0, 3}, .anchor_b = {0, 0.5}};
    def.length = 4;
    const JointId rope = world.create_joint(def);
    step(world, 10);
    ASSERT_EQ(world.report().islands_at_rest, 1);
    world.destroy(rope);
    def = {.kind = JointKind::Distance, .b = box, .anchor_a = {0, 3}, .anchor_b = {0, 0.5}};
    def.length = 1;
    def.stiffness = 40;
    const JointId spring = world.create_joint(def);
    ASSERT_EQ(spring.index, rope.index);
    step(world, 20);
    EXPECT_GT(world.position(box).y, 0.6);
  }
}

TEST(Sleep, StepsThatThrewForgetNothingThatWasMovedBeforeThem) {
  // The table is taken away; the step that would see it throws, the next one does not.
  bool fails = false;
  World world;
  world.set_force_field([&fails](const FieldSample&) {
    if (fails) throw std::runtime_error("no force");
    return Wrench{};
  });
  const BodyId box = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5));
  const BodyId table = world.create_body({.type = BodyType::Static, .position = {0, -0.5}});
  world.add_shape(table, rough(make_box({4, 1}), 0.5));
  step(world, 10);
  world.set_pose(table, {0, -5}, 0);
  fails = true;
  EXPECT_THROW(world.step(1.0 / 60), std::runtime_error);
  fails = false;
  step(world, 30);
  EXPECT_NEAR(world.position(box).y, 0.5 - 9.81 / 2 * 0.25, 1e-9);
}

TEST(Sleep, ForcesAndTorquesOfTheUserThatMoveNothingAreGoneInTheNextStep) {
  // A box is pressed, pushed or turned a little for some steps, and rests all the time.
  for (const int what : {0, 1, 2}) {
    std::vector<double> seen[3];
    for (const int kind : {0, 1, 2}) {
      WorldConfig config = with_sleep(kind == 0);
      config.reuse_resting = kind != 2;
      World world(config);
      add_ground(world, rough(make_disc(1), 0.5));
      const BodyId box = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5));
      world.observe({.contacts = true});
      for (int i = 0; i < 40; ++i) {
        if (i % 20 >= 10) {
          if (what == 0) world.apply_force(box, {0, -5}, world.position(box));
          if (what == 1) world.apply_force(box, {1, 0}, world.position(box));
          if (what == 2) world.apply_torque(box, 1);
        }
        const StepReport& report = world.step(1.0 / 60);
        ASSERT_EQ(report.islands_list.size(), 1u);
        EXPECT_EQ(report.islands_list[0].bodies, 1);
        EXPECT_EQ(report.islands_list[0].contacts, 2);
        EXPECT_EQ(report.islands_list[0].rows, 4);
        EXPECT_EQ(report.friction_rows, 2);
        for (const ContactReport& contact : report.contacts_list) {
          for (int k = 0; k < contact.count; ++k) {
            seen[kind].push_back(contact.points[k].normal_impulse);
            seen[kind].push_back(contact.points[k].friction_impulse);
          }
        }
      }
      ASSERT_EQ(seen[kind].size(), 160u);
      const double left = seen[kind][4 * 15], right = seen[kind][4 * 15 + 2];
      EXPECT_NEAR((left + right) * 60, what == 0 ? 14.81 : 9.81, 1e-9);
      EXPECT_NEAR(std::abs(left - right) * 60, what == 0 ? 0 : what == 1 ? 1 : 2, 1e-9);
    }
    for (const int kind : {0, 1})
      for (std::size_t k = 0; k < seen[2].size(); ++k)
        ASSERT_NEAR(seen[kind][k], seen[2][k], 1e-12) << what << " " << kind << ", step " << k / 4;
  }
}

TEST(Islands, FollowBodiesThatGoAndBodiesThatAreHeld) {
  World world;
  std::vector<BodyId> discs;
  for (const double x : {0.0, 3.0, 6.0}) discs.push_back(add(world, {x, 50}, rough(make_disc(0.5), 0.5)));
  step(world, 5);
  EXPECT_EQ(world.report().islands, 3);
  world.destroy(discs[0]);
  step(world, 1);
  EXPECT_EQ(world.report().islands, 2);
  EXPECT_EQ(world.bodies().island[discs[2].index], 1);
  world.set_type(discs[1], BodyType::Static);
  const double y = world.position(discs[1]).y;
  step(world, 5);
  EXPECT_EQ(world.report().islands, 1);
  EXPECT_EQ(world.position(discs[1]).y, y);
}

TEST(Islands, AtRestAreSteppedWhenWhatTheyHangOnMoves) {
  // Awake ones, too, whichever end of the joint the hook is.
  for (const bool sleep : {true, false}) {
    for (const bool hook_first : {true, false}) {
      for (const bool by_hand : {true, false}) {
        World world(with_sleep(sleep));
        const BodyId hook = world.create_body({.type = BodyType::Kinematic});
        const BodyId bob = add(world, {0, -1}, rough(make_disc(0.1), 0));
        world.create_joint({.kind = JointKind::Revolute,
                            .a = hook_first ? hook : bob,
                            .b = hook_first ? bob : hook,
                            .anchor_a = {0, 0}});
        step(world, 20);
        ASSERT_EQ(world.report().islands_at_rest, 1);
        if (by_hand)
          world.set_pose(hook, {0.5, 0}, 0);
        else
          world.set_velocity(hook, {0.5, 0}, 0);
        step(world, 20);
        EXPECT_GT(world.position(bob).x, 1e-4) << sleep << hook_first << by_hand;
      }
    }
  }
}

TEST(Sleep, WhatANeighbourLeavesBehindStillWakesWithItsGround) {
  // Boxes about the two discs overlap, so the second one to fall asleep keeps what is between them.
  World world;
  const BodyId ground = add_ground(world, rough(make_disc(1), 0.5));
  const BodyId left = add(world, {0, 1}, rough(make_disc(1), 0.5));
  step(world, 10);
  const BodyId right = add(world, {1, 0.1}, rough(make_disc(0.1), 0.5));
  step(world, 10);
  ASSERT_TRUE(world.asleep(left) && world.asleep(right));
  world.destroy(left);
  step(world, 10);
  ASSERT_TRUE(world.asleep(right));
  world.set_pose(ground, {0, -1}, 0);
  step(world, 10);
  EXPECT_LT(world.position(right).y, 0.05);
}

}  // namespace sleep_test
}  // namespace skerry
