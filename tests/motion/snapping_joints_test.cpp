// SPDX-License-Identifier: MIT
//
// Light bars that hold a heavy bob, with a kink: they snap straight, and for a moment are a hundred times as
// fast as the bob.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "tests/support/draw.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace snapping_joints_test {

using test::add;
using test::Draw;
using test::smooth;

constexpr double kStep = 1.0 / 60, kLength = 0.5, kGravity = 9.81;

/// A chain of bars that each turn by a little against the last one.
struct Chain {
  World world;
  BodyId last;
  Vec2 end;
  double angle;
  int bars = 0;

  Chain(double from, const char* stepper) : world(by(stepper)), angle(from) {}

  static WorldConfig by(const char* stepper) {
    WorldConfig config;
    config.stepper = stepper;
    return config;
  }

  void hang(BodyId body) {
    world.create_joint({.kind = JointKind::Revolute, .a = last, .b = body, .anchor_a = end});
    last = body;
  }

  void add_bar(double mass, double kink) {
    const Vec2 next = end + kLength * Vec2{std::sin(angle), -std::cos(angle)};
    const BodyId bar = world.create_body({.position = 0.5 * (end + next), .angle = angle, .mass = mass});
    world.add_shape(bar, {.shape = make_box({0.1, kLength}), .filter = {.mask = 0}});
    hang(bar);
    end = next;
    angle += kink;
    ++bars;
  }

  double energy() const { return world.kinetic_energy() + world.potential_energy(); }

  /// How far a hinge is off [m].
  double gap() const {
    const auto tip = [&](std::uint32_t bar, double along) {
      const double a = world.bodies().angle[bar];
      return world.bodies().position[bar] + along * Vec2{std::sin(a), -std::cos(a)};
    };
    double worst = length(tip(0, -0.5 * kLength));
    for (std::uint32_t i = 1; i < static_cast<std::uint32_t>(bars); ++i)
      worst = std::max(worst, length(tip(i, -0.5 * kLength) - tip(i - 1, 0.5 * kLength)));
    return worst;
  }
};

class SnappingJoints : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(By, SnappingJoints, testing::Values("time_stepping", "event_driven"),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(SnappingJoints, ABobOnTwoLightBarsKeepsItsEnergy) {
  for (const double kink : {0.05, 0.15, 0.3, 0.5}) {
    Chain chain(0.6, GetParam());
    chain.add_bar(0.1, -kink);
    chain.add_bar(0.1, 0);
    chain.hang(add(chain.world, chain.end, smooth(make_disc(0.15)), 100));
    const double before = chain.energy();
    for (int k = 0; k < 240; ++k) {
      chain.world.step(kStep);
      ASSERT_LT(chain.gap(), 1e-9) << "kink " << kink << ", step " << k;
      ASSERT_NEAR(chain.energy(), before, 0.02) << "kink " << kink << ", step " << k;
    }
  }
}

TEST(SnappingJoints, ChainsOfLightBarsHoldAndKeepTheirEnergy) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    Draw draw(seed);
    const double light = std::pow(10, draw.uniform(-4, -2));
    Chain chain(draw.uniform(-1.2, 1.2), "time_stepping");
    const int bars = 2 + draw.pick(4);
    for (int k = 0; k < bars; ++k) chain.add_bar(light, draw.uniform(-0.2, 0.2));
    chain.hang(add(chain.world, chain.end, smooth(make_box({0.4, 0.3})), 1));
    const double before = chain.energy();
    for (int k = 0; k < 120; ++k) {
      chain.world.step(kStep);
      ASSERT_LT(chain.gap(), 1e-9) << "seed " << seed << ", step " << k;
      ASSERT_EQ(chain.world.report().inexact_islands, 0) << "seed " << seed << ", step " << k;
    }
    EXPECT_NEAR(chain.energy(), before, 2e-3 * kGravity * kLength * bars) << "seed " << seed;
  }
}

}  // namespace snapping_joints_test
}  // namespace skerry
