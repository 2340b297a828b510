// SPDX-License-Identifier: MIT
//
// Forces that fall to zero and are back before the inner step ends.
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <span>

#include "physics/stepping/stage_values.h"
#include "tests/support/draw.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace event_dips_test {

using test::add;
using test::add_ground;
using test::rough;

constexpr double kG = 9.81;

WorldConfig by_events() {
  WorldConfig config;
  config.stepper = "event_driven";
  return config;
}

/// The time of the first event of a kind within two seconds of steps of 1/60 s, or -1.
double first(World& world, MotionEventKind kind) {
  for (int i = 0; i < 120; ++i) {
    for (const MotionEvent& event : world.step(1.0 / 60).motion_events) {
      if (event.kind == kind) return event.time;
    }
  }
  return -1;
}

TEST(EventDips, WhatIsLiftedForAMomentLeavesTheTable) {
  for (const double omega : {10.0, 17.0, 23.0}) {
    for (const double peak : {1.0001 * kG, 1.01 * kG, 1.2 * kG}) {
      World world(by_events());
      const auto table = world.create_body({.type = BodyType::Kinematic, .position = {0, -0.5}});
      world.add_shape(table, rough(make_box({10, 1}), 0.5));
      const auto box = add(world, {0, 0.25}, rough(make_box({0.5, 0.5}), 0.5));
      world.set_velocity(box, {0, -peak / omega}, 0);
      world.set_motion(table, [=](double t) {
        return Placement{{0, -0.5 - peak / (omega * omega) * std::sin(omega * t)}, 0};
      });
      EXPECT_NEAR(first(world, MotionEventKind::Release), (kPi + std::asin(kG / peak)) / omega, 2e-7)
          << omega << ' ' << peak;
    }
  }
}

TEST(EventDips, WhatIsPulledForAMomentSlides) {
  constexpr double kMu = 0.5;
  for (const double omega : {10.0, 17.0, 23.0}) {
    for (const double peak : {1.0001 * kMu * kG, 1.01 * kMu * kG, 1.2 * kMu * kG}) {
      World world(by_events());
      const ShapeDef block = rough(make_box({2, 0.5}), kMu);
      add_ground(world, block);
      add(world, {0, 0.25}, block);
      world.set_force_field([=](const FieldSample& at) {
        return Wrench{{at.mass * peak * std::sin(omega * at.time), 0}, 0};
      });
      EXPECT_NEAR(first(world, MotionEventKind::Slip), std::asin(kMu * kG / peak) / omega, 2e-7)
          << omega << ' ' << peak;
    }
  }
}

/// A part of a wave that is above zero at both ends, and where it is deepest.
struct Wave {
  double mean, phase, turn;
  double operator()(double theta) const { return mean + std::sin(phase + turn * theta); }
  double deepest() const {
    const double theta = (1.5 * kPi - phase) / turn;
    return theta > 0 && theta < 1 ? mean - 1 : std::min((*this)(0), (*this)(1));
  }
};

TEST(StageValues, FindWhatFallsBelowZeroAndNothingElse) {
  constexpr unsigned kSeed = 20261130;
  constexpr double kFrom = 3, kLength = 0.02;
  test::Draw draw(kSeed);
  int dips = 0;
  for (int i = 0; i < 20000; ++i) {
    // Two of them: what is known of one says nothing about the other.
    const auto wave = [&] {
      const double share = draw.uniform(-1, 1);
      return Wave{1 - std::copysign(std::pow(std::abs(share), 4), share), draw.uniform(0, 2 * kPi),
                  draw.uniform(0.2, 3)};
    };
    const Wave waves[2] = {wave(), wave()};
    if (waves[0](0) <= 0 || waves[0](1) < 0) continue;
    StageValues stages;
    stages.begin(kFrom, kLength);
    for (const double theta : {0.053, 0.079, 0.118, 0.282, 0.333, 0.25, 0.308, 0.651, 0.6, 0.857, 1.0}) {
      const double t = kFrom + theta * kLength;
      if (!stages.wants(t)) continue;
      const std::span<double> values = stages.add(t, 2);
      // Stages are not exact.
      for (std::size_t k = 0; k < 2; ++k) values[k] = waves[k](theta) + draw.uniform(-1e-4, 1e-4);
    }
    const double before = i % 2 == 0 ? 1 : draw.uniform(0, 1);
    const std::optional<double> found =
        stages.dip(0, waves[0](0), waves[0](1), before, 1e-8, std::cref(waves[0]));
    if (found) {
      ++dips;
      EXPECT_LT(waves[0](*found), 0) << "seed " << kSeed << " wave " << i;
      EXPECT_LT(*found, before) << "seed " << kSeed << " wave " << i;
    } else if (before == 1) {
      EXPECT_GT(waves[0].deepest(), -1e-7) << "seed " << kSeed << " wave " << i;
    }
  }
  EXPECT_GT(dips, 500);
}

}  // namespace event_dips_test
}  // namespace skerry
