// SPDX-License-Identifier: MIT
//
// Many bodies made at one place, as by a script that forgets to move on: they come apart, sink into nothing,
// and cost a bounded amount of work.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <tuple>
#include <vector>

#include "tests/support/worlds.h"

namespace skerry {
namespace crowd_test {

using test::add;
using test::add_ground;
using test::rough;

constexpr double kStep = 1.0 / 60;

struct Crowd {
  const char* name;
  int count;
  Shape (*shape)(int k);
};

class Crowds : public testing::TestWithParam<std::tuple<const char*, Crowd>> {};

TEST_P(Crowds, ComeApartAndSinkNowhere) {
  const auto& [stepper, crowd] = GetParam();
  WorldConfig config;
  config.stepper = stepper;
  World world(config);
  add_ground(world, rough(make_disc(1), 0.5));
  std::vector<BodyId> bodies;
  bodies.reserve(static_cast<std::size_t>(crowd.count));
  for (int k = 0; k < crowd.count; ++k) bodies.push_back(add(world, {0, 2}, rough(crowd.shape(k), 0.5)));
  double most = 0;
  for (int i = 0; i < 40; ++i) most = std::max(most, world.step(kStep).work.visits);
  EXPECT_LT(world.report().worst_penetration, 1e-3);
  for (const BodyId body : bodies) EXPECT_GT(world.position(body).y, 0.1);
  EXPECT_LT(most, 5e7);
}

constexpr Crowd kCrowds[] = {
    {"boxes", 200,
     [](int) {
       return make_box({1, 1});
     }},
    {"mixed", 100,
     [](int k) {
       return k % 3 == 0 ? make_disc(0.2 + 0.002 * k) : make_box({0.3 + 0.005 * k, 0.8 - 0.004 * k});
     }},
};

INSTANTIATE_TEST_SUITE_P(By, Crowds,
                         testing::Combine(testing::Values("time_stepping", "event_driven", "auto"),
                                          testing::ValuesIn(kCrowds)),
                         [](const auto& instance) {
                           return std::string(std::get<0>(instance.param)) + "_" +
                                  std::get<1>(instance.param).name;
                         });

TEST(CrowdOfDiscs, ACoincidentColumnOfDiscsIsNoRest) {
  // Hundreds of discs at one place stay in one vertical line, and their overlaps carry nothing. What is
  // pushed out of each other has no velocity: 300 fell asleep in each other after two seconds.
  for (const int count : {200, 300}) {
    World world;
    add_ground(world, rough(make_disc(1), 0.5));
    std::vector<BodyId> discs;
    discs.reserve(static_cast<std::size_t>(count));
    for (int k = 0; k < count; ++k) discs.push_back(add(world, {0, 2}, rough(make_disc(0.5), 0.5)));
    for (int i = 0; i < 2 * count; ++i) world.step(kStep);
    EXPECT_LT(world.report().worst_penetration, 1e-6) << count;
    for (const BodyId disc : discs) EXPECT_GT(world.position(disc).y, 0.49);
  }
}

/// A floor, two walls and, if it has a height, a ceiling.
void add_room(World& world, double width, double height) {
  const BodyId room = world.create_body({.type = BodyType::Static});
  world.add_shape(room, {.shape = make_half_plane({0, 0}, {0, 1})});
  world.add_shape(room, {.shape = make_half_plane({-0.5 * width, 0}, {1, 0})});
  world.add_shape(room, {.shape = make_half_plane({0.5 * width, 0}, {-1, 0})});
  if (height > 0) world.add_shape(room, {.shape = make_half_plane({0, height}, {0, -1})});
}

class SqueezedDiscs : public testing::TestWithParam<std::tuple<const char*, double>> {};

TEST_P(SqueezedDiscs, LeaveTheLineOnWhichTheyHaveNoRoom) {
  const auto& [stepper, gravity] = GetParam();
  const WorldConfig config{.gravity = {0, -gravity}, .stepper = stepper};
  // Made at one place they want out along one line. They slept there, the last ones in the walls.
  for (const int count : {6, 12, 24}) {
    const double side = 1.8 * std::sqrt(count) + 0.4;
    World world(config);
    add_room(world, side, side);
    std::vector<BodyId> discs;
    discs.reserve(static_cast<std::size_t>(count));
    for (int k = 0; k < count; ++k) discs.push_back(add(world, {0, 0.5 * side}, rough(make_disc(0.5), 0.5)));
    for (int i = 0; i < 60; ++i) world.step(kStep);
    EXPECT_LT(world.report().worst_penetration, 1e-6) << count;
    EXPECT_EQ(world.report().inexact_islands, 0) << count;
    for (const BodyId disc : discs) {
      const Vec2 p = world.position(disc);
      EXPECT_LT(std::max(std::abs(p.x), std::abs(p.y - 0.5 * side)), 0.5 * side - 0.4999) << count;
    }
  }
}

TEST_P(SqueezedDiscs, OnAFloorBetweenWallsGoUp) {
  const auto& [stepper, gravity] = GetParam();
  const WorldConfig config{.gravity = {0, -gravity}, .stepper = stepper};
  for (const int count : {6, 10}) {
    World world(config);
    add_room(world, 4, 0);
    for (int k = 0; k < count; ++k)
      add(world, {-1.4 + 2.8 * k / (count - 1), 0.5}, rough(make_disc(0.5), 0.5));
    for (int i = 0; i < 60; ++i) world.step(kStep);
    EXPECT_LT(world.report().worst_penetration, 1e-6) << count;
  }
}

INSTANTIATE_TEST_SUITE_P(By, SqueezedDiscs,
                         testing::Combine(testing::Values("time_stepping", "event_driven", "auto"),
                                          testing::Values(0.0, 9.81)),
                         [](const auto& each) {
                           return std::string(std::get<0>(each.param)) +
                                  (std::get<1>(each.param) > 0 ? "" : "_weightless");
                         });

TEST(Wedged, WhatHasNoRoomAtAllIsReported) {
  // A box of 1 m in a slot: what is left of an overlap is no exact answer, asleep or not.
  for (const double height : {0.9, 0.999, 1.0, 1.1}) {
    World world;
    add_room(world, 10, height);
    add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5));
    for (int i = 0; i < 200; ++i) {
      world.step(kStep);
      ASSERT_EQ(world.report().inexact_islands, height < 1) << height << " in step " << i;
    }
  }
}

}  // namespace crowd_test
}  // namespace skerry
