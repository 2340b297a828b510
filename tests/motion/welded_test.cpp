// SPDX-License-Identifier: MIT
//
// Structures whose parts are welded: they are solved as one body, and move and carry as if they were not.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <string>

#include "tests/support/pile.h"

namespace skerry {
namespace welded_test {

constexpr double kStep = 1.0 / 60;

/// Welded blocks above a pit.
World falling_blocks(int count, int size, unsigned seed, WorldConfig config = {}) {
  World world(std::move(config));
  test::add_pit(world);
  test::add_blocks(world, count, size, seed);
  return world;
}

TEST(WeldedStructures, ComeToRestInAPile) {
  for (const int size : {2, 3, 4}) {
    for (const unsigned seed : {1u, 2u}) {
      SCOPED_TRACE("blocks of " + std::to_string(size) + ", seed " + std::to_string(seed));
      World world = falling_blocks(140, size, seed);
      double energy = kInfinity, visits = 0, deepest = 0;
      int left_out = 0;
      for (int step = 0; step < 900; ++step) {
        const StepReport& report = world.step(kStep);
        const double now = report.kinetic_energy + report.potential_energy;
        ASSERT_LE(now, energy + 1e-3) << "step " << step;
        energy = now;
        visits = std::max(visits, report.work.visits);
        deepest = std::max(deepest, report.worst_penetration);
        left_out = std::max(left_out, report.work.rows_left_out);
      }
      EXPECT_EQ(world.report().bodies_asleep, 140);
      EXPECT_LT(deepest, 0.012);
      EXPECT_LT(visits, 4e6);
      EXPECT_GT(left_out, 300);
    }
  }
}

/// A lattice welded to a wall, struck by a disc, and one on the floor, struck by a box. What the floor
/// carries of that is indeterminate: @param welds  those of the other one
World struck_lattices(const WorldConfig& config, std::vector<JointId>& welds) {
  World world(config);
  const ShapeDef box = test::rough(make_box({0.6, 0.6}), 0.5);
  const BodyId ground = test::add_ground(world, box);
  std::vector<BodyId> beam, block;
  for (const double y : {4.0, 4.7})
    for (int k = 0; k < 5; ++k) beam.push_back(test::add(world, {0.7 * k, y}, box));
  for (const double y : {0.3, 1.0, 1.7})
    for (int k = 0; k < 3; ++k) block.push_back(test::add(world, {6 + 0.7 * k, y}, box));
  test::weld_blocks(world, block, 3, 3);
  welds = test::weld_blocks(world, beam, 5, 5);
  for (const int i : {0, 5})
    welds.push_back(world.create_joint({.kind = JointKind::Weld,
                                        .a = ground,
                                        .b = beam[static_cast<std::size_t>(i)],
                                        .anchor_a = world.position(beam[static_cast<std::size_t>(i)])}));
  test::add(world, {2.2, 5.6}, test::rough(make_disc(0.2), 0.5), 0.5);
  test::add(world, {6.2, 2.6}, test::rough(make_box({0.4, 0.4}), 0.5, 0.4), 0.5, {}, 0, 0.3);
  return world;
}

TEST(WeldedStructures, MoveAndCarryAsWithAllRows) {
  WorldConfig all_rows;
  all_rows.solve.welds_as_one = false;
  std::vector<JointId> welds, same;
  World one = struck_lattices({}, welds), all = struck_lattices(all_rows, same);
  int left_out = 0;
  for (int step = 0; step < 45; ++step) {
    left_out = std::max(left_out, one.step(kStep).work.rows_left_out);
    EXPECT_EQ(all.step(kStep).work.rows_left_out, 0);
    // Velocities that joints do not allow by 1e-9 are taken out of one of them, and not of the other.
    for (std::size_t i = 0; i < one.bodies().alive.size(); ++i) {
      ASSERT_NEAR(one.bodies().position[i].x, all.bodies().position[i].x, 1e-6) << step << ": body " << i;
      ASSERT_NEAR(one.bodies().position[i].y, all.bodies().position[i].y, 1e-6) << step << ": body " << i;
    }
    double largest = 0;
    for (const JointId weld : same) largest = std::max(largest, length(all.joint_force(weld)));
    for (std::size_t k = 0; k < welds.size(); ++k)
      ASSERT_LT(length(one.joint_force(welds[k]) - all.joint_force(same[k])), 1e-5 * largest)
          << step << ": weld " << k;
  }
  EXPECT_GT(left_out, 50);
}

TEST(WeldedStructures, HaveTheSameBitsForAnyThreads) {
  WorldConfig threads;
  threads.threads = 3;
  World one = falling_blocks(140, 3, 4), three = falling_blocks(140, 3, 4, threads);
  for (int step = 0; step < 150; ++step)
    ASSERT_EQ(one.step(kStep).state_hash, three.step(kStep).state_hash) << step;
}

}  // namespace welded_test
}  // namespace skerry
