// SPDX-License-Identifier: MIT
//
// Many bodies made at one place, as by a script that forgets to move on: they come apart, sink into nothing,
// and cost a bounded amount of work.
#include <algorithm>
#include <gtest/gtest.h>
#include <string>
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

}  // namespace crowd_test
}  // namespace skerry
