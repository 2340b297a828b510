// SPDX-License-Identifier: MIT
//
// A library that was built without COIN-OR Clp: limit loads say so, all else works.
#include "physics/statics/limit_load.h"

#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "physics/statics/stability.h"
#include "tests/support/worlds.h"

namespace skerry::statics::test {
namespace limit_load_test {

using skerry::test::add;
using skerry::test::add_ground;
using skerry::test::rough;

TEST(WithoutClp, LimitLoadIsUnavailableAndNamesThePackage) {
  EXPECT_FALSE(limit_load_available());
  EXPECT_THAT(limit_load_missing(), testing::HasSubstr("coinor-libclp-dev"));
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5));
  const RestAnalysis rest = analyse_rest(world);
  EXPECT_TRUE(rest.stands);
  const LimitLoad limit = limit_load(rest.system, rest.load, rest.load);
  EXPECT_EQ(limit.status, LimitStatus::Unavailable);
  EXPECT_STREQ(to_string(limit.status), "unavailable");
  EXPECT_TRUE(limit.forces.empty());
  EXPECT_TRUE(std::isinf(missing_support(rest.system, rest.load)));
}

TEST(WithoutClp, StabilityHasNoMarginAndDoesNotInventOne) {
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5));
  const Stability stability = stability_of(analyse_rest(world));
  EXPECT_EQ(stability.status, LimitStatus::Unavailable);
  EXPECT_EQ(stability.margin, 0);
  EXPECT_EQ(stability.contact, -1);
}

}  // namespace limit_load_test
}  // namespace skerry::statics::test
