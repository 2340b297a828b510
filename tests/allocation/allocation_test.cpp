// SPDX-License-Identifier: MIT
//
// A steady step allocates nothing. This program counts every call of operator new.
#include <atomic>
#include <cstdlib>
#include <gtest/gtest.h>
#include <new>

#include "tests/support/worlds.h"

namespace {
std::atomic<long> allocations{0};
}  // namespace

void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size > 0 ? size : 1)) return memory;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  ++allocations;
  const auto align = static_cast<std::size_t>(alignment);
  if (void* memory = std::aligned_alloc(align, (size + align - 1) / align * align)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}

namespace skerry {
namespace {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;

/// Allocations of the steps after `warm_up` others.
long allocations_of(World& world, int steps, int warm_up) {
  for (int i = 0; i < warm_up; ++i) world.step(1.0 / 60);
  const long before = allocations;
  for (int i = 0; i < steps; ++i) world.step(1.0 / 60);
  return allocations - before;
}

void add_stack(World& world, int boxes) {
  add_ground(world, rough(make_disc(1), 0.5));
  for (int i = 0; i < boxes; ++i) add(world, {0, i + 0.5}, rough(make_box({1, 1}), 0.5));
}

TEST(SteadyStep, TheCounterCounts) {
  const long before = allocations;
  World world;
  add_stack(world, 2);
  EXPECT_GT(allocations - before, 0);
}

TEST(SteadyStep, AllocatesNothingWhileAllSleep) {
  World world;
  add_stack(world, 10);
  EXPECT_EQ(allocations_of(world, 50, 10), 0);
  EXPECT_EQ(world.report().bodies_asleep, 10);
}

TEST(SteadyStep, AllocatesNothingWhereAnAwakeStackRests) {
  WorldConfig config;
  config.sleep = false;
  World world(config);
  add_stack(world, 10);
  EXPECT_EQ(allocations_of(world, 50, 10), 0);
  EXPECT_EQ(world.report().islands_at_rest, 1);
}

TEST(SteadyStep, AllocatesNothingInFlight) {
  WorldConfig config;
  config.gravity = {};
  config.broad_phase = "brute_force";  // the grid makes lists when it is built anew
  World world(config);
  for (int i = 0; i < 100; ++i)
    add(world, {3.0 * i, 0}, smooth(make_disc(0.5)), 1, {0.1 * (i % 7), 0.2 * (i % 5)}, 1);
  EXPECT_EQ(allocations_of(world, 50, 20), 0);
  EXPECT_EQ(world.report().islands_in_flight, 100);
}

TEST(SteadyStep, AllocatesNothingWhereDiscsRoll) {
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  for (int i = 0; i < 10; ++i) add(world, {5.0 * i, 0.5}, rough(make_disc(0.5), 0.5), 1, {1, 0}, -2);
  EXPECT_EQ(allocations_of(world, 50, 20), 0);
  EXPECT_EQ(world.report().contacts, 10);
  EXPECT_NEAR(world.velocity(world.body_id(1)).x, 1, 1e-9);
}

TEST(SteadyStep, AllocatesNothingWhereEveryStepOfAStackIsSolved) {
  WorldConfig config;
  config.sleep = config.reuse_resting = false;
  World world(config);
  add_stack(world, 10);
  EXPECT_EQ(allocations_of(world, 50, 10), 0);
}

}  // namespace
}  // namespace skerry
