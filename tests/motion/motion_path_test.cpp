// SPDX-License-Identifier: MIT
//
// Prescribed motions within a step, as polynomials between their breaks.
#include "physics/stepping/motion_path.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "tests/support/draw.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace motion_path_test {

constexpr double kStep = 1.0 / 60;

TEST(MotionPaths, AreKnownOnBothSidesOfABreak) {
  WorldConfig config;
  World world(config);
  const BodyId body = world.create_body({.type = BodyType::Kinematic});
  const double kink = 2.4 * kStep, jump = 2.8 * kStep;
  const auto motion = [=](double t) {
    return Placement{{t < kink ? std::sin(3 * t) : std::sin(3 * kink) - 2 * (t - kink), t < jump ? 0.0 : 1.0},
                     t < kink ? t : kink};
  };
  world.set_motion(body, motion);
  world.observe({.paths = true});
  for (int step = 1; step <= 4; ++step) {
    world.step(kStep);
    for (int k = 0; k <= 100; ++k) {
      const double t = world.time() - kStep + 0.01 * k * kStep;
      if (std::min(std::abs(t - kink), std::abs(t - jump)) < 1e-9) continue;
      const BodyState state = world.interpolated(body, t);
      const Placement there = motion(t);
      EXPECT_LT(length(state.position - there.position), 1e-12) << t;
      EXPECT_NEAR(state.angle, there.angle, 1e-12) << t;
      EXPECT_NEAR(state.velocity.x, t < kink ? 3 * std::cos(3 * t) : -2, 1e-7) << t;
      EXPECT_NEAR(state.velocity.y, 0, 1e-7) << t;
      EXPECT_NEAR(state.omega, t < kink ? 1 : 0, 1e-7) << t;
    }
  }
}

TEST(MotionPaths, HaveTheirBreaksWhereTheyAre) {
  // At times at which seconds have few digits left, too.
  for (const double time : {0.0, 1e3, 1e5}) {
    int found = 0;
    double far = 0;
    for (unsigned seed = 0; seed < 400; ++seed) {
      test::Draw draw(seed);
      const double kink = draw.uniform(0.01, 0.99) * kStep, bend = std::pow(10, draw.uniform(-1, 1));
      MotionPath path;
      path.sample(
          [=](double t) {
            const double since = t - time;
            return Placement{{since + bend * std::max(since - kink, 0.0), 0}, 0};
          },
          time, kStep, {});
      EXPECT_FALSE(path.begins_with_jump() || path.ends_with_jump()) << seed;
      if (path.breaks().size() != 1) continue;
      ++found;
      far = std::max(far, std::abs(path.breaks()[0] - kink));
    }
    EXPECT_GE(found, 398) << time;
    EXPECT_LT(far, time < 1e4 ? 1e-11 : 1e-7) << time;
  }
}

TEST(MotionPaths, AreThereWhereRoundingHidesTheirBreaks) {
  // Small motions far away, and at times of which a step is few roundings.
  for (const double time : {0.0, 1e6, 1e9, 1e12}) {
    for (const double far : {0.0, 1e4, 1e9}) {
      for (const double way : {1e-12, 1e-9, 1e-6, 1e-3, 1.0}) {
        for (unsigned seed = 0; seed < 20; ++seed) {
          test::Draw draw(seed);
          const double kink = draw.uniform(0, 1) * kStep, jump = draw.pick(2) * way,
                       turn = draw.pick(2) * far;
          MotionPath path;
          path.sample(
              [=](double t) {
                const double since = t - time;
                const double gone = way * since / kStep + (since > kink ? jump + way * (since - kink) : 0);
                return Placement{{far + gone, gone}, turn + gone};
              },
              time, kStep, {{far, 0}, turn});
          for (int k = 0; k <= 16; ++k) {
            const KinematicState state = path.at(k * kStep / 16);
            ASSERT_TRUE(is_finite(state.p) && is_finite(state.v) && std::isfinite(state.omega));
            ASSERT_LT(length(state.p - Vec2{far, 0}), 1e2 * way + 1e-6 * far)
                << time << " s, " << way << " m";
          }
        }
      }
    }
  }
}

TEST(MotionPaths, AreAskedForTenTimesAStepAndNotForEver) {
  const auto asked_by = [](const PrescribedMotion& motion, double begin = 0) {
    World world{WorldConfig{}};
    const BodyId body = world.create_body({.type = BodyType::Kinematic});
    const auto count = std::make_shared<int>(0);
    world.set_motion(body, [=](double t) {
      ++*count;
      return motion(begin + t);
    });
    int most = 0;
    for (int step = 0; step < 60; ++step) {
      *count = 0;
      world.step(kStep);
      EXPECT_TRUE(is_finite(world.position(body)));
      most = std::max(most, *count);
    }
    return most;
  };
  EXPECT_EQ(asked_by([](double t) { return Placement{{std::sin(60 * t), std::cos(60 * t)}, 3 * t}; }), 10);
  EXPECT_EQ(asked_by([](double) { return Placement{{1e9, -1e-17}, 0}; }), 10);
  EXPECT_EQ(asked_by([](double t) { return Placement{{0.1 * t * t, 1e6 + t}, -t}; }, 1e5), 10);
  const auto noise = std::make_shared<std::mt19937>(68);
  EXPECT_LT(asked_by([=](double) { return Placement{{1e-10 * (*noise)(), 0}, 0}; }), 1000);
  EXPECT_LT(asked_by([](double t) { return Placement{{std::fmod(5000 * t, 1.0), 0}, 0}; }), 1000);
  EXPECT_LT(asked_by([](double t) { return Placement{{std::fmod(t, 0.01), 0}, 0}; }), 6000);
}

TEST(MotionPaths, HaveTheAccelerationsOfTheMotion) {
  const auto motion = [](double t) { return Placement{{std::sin(3 * t), std::cos(5 * t)}, std::sin(7 * t)}; };
  MotionPath path;
  path.sample(motion, 0.4, kStep, motion(0.4));
  EXPECT_FALSE(path.begins_with_jump() || path.ends_with_jump());
  for (int k = 0; k <= 10; ++k) {
    const double since = k * kStep / 10, t = 0.4 + since;
    EXPECT_NEAR(path.at(since).a.x, -9 * std::sin(3 * t), 1e-6);
    EXPECT_NEAR(path.at(since).a.y, -25 * std::cos(5 * t), 1e-6);
    EXPECT_NEAR(path.at(since).alpha, -49 * std::sin(7 * t), 1e-6);
  }
}

TEST(MotionPaths, KnowKinksOfAnAngleAsOfAWay) {
  for (const bool turns : {true, false}) {
    int found = 0;
    for (int k = 1; k < 200; ++k) {
      const double kink = k * kStep / 200;
      MotionPath path;
      path.sample(
          [=](double t) {
            const double x = std::max(t - kink, 0.0);
            return turns ? Placement{{0, 0}, x} : Placement{{x, 0}, 0};
          },
          0, kStep, {});
      if (path.breaks().size() != 1) continue;
      ++found;
      const double there = path.breaks()[0];
      const auto rate = [&](double t) { return turns ? path.at(t).omega : path.at(t).v.x; };
      EXPECT_NEAR(there, kink, 1e-11);
      EXPECT_NEAR(rate(there), 1, 1e-6) << "at a break is what is after it";
      EXPECT_NEAR(rate(there - 1e-9), 0, 1e-6);
    }
    EXPECT_GE(found, 198);
  }
}

/// In the very place in which steps are cut only the velocities on both sides tell of a kink.
TEST(MotionPaths, KnowKinksWhereTheyAreCut) {
  for (const bool turns : {true, false}) {
    const double kink = 0.4871 * kStep;
    MotionPath path;
    path.sample(
        [=](double t) {
          const double x = t + 1e-3 * std::max(t - kink, 0.0);
          return turns ? Placement{{0, 0}, x} : Placement{{x, 0}, 0};
        },
        0, kStep, {});
    ASSERT_EQ(path.breaks().size(), 1u) << turns;
    EXPECT_NEAR(path.breaks()[0], kink, 1e-11);
  }
}

TEST(MotionPaths, JumpWhereStepsBeginAndEnd) {
  for (const bool turns : {true, false}) {
    const auto place = [=](double x) { return turns ? Placement{{0, 0}, x} : Placement{{x, 0}, 0}; };
    MotionPath path;
    path.sample([=](double) { return place(1); }, 0, kStep, place(0));
    EXPECT_TRUE(path.begins_with_jump());
    EXPECT_FALSE(path.ends_with_jump());
    path.sample([=](double t) { return place(t < kStep ? 0 : 1); }, 0, kStep, place(0));
    EXPECT_FALSE(path.begins_with_jump());
    EXPECT_TRUE(path.ends_with_jump());
    const auto value = [&](double t) { return turns ? path.at(t).angle : path.at(t).p.x; };
    EXPECT_EQ(value(kStep), 0);
    EXPECT_EQ(value(std::nextafter(kStep, 1)), 0) << "a sum of times that is rounded";
    EXPECT_EQ(value(kStep * (1 + 1e-13)), 1);
  }
}

TEST(MotionPaths, OfAShortStrokeGoAsFarAsThat) {
  const auto stroke = [](double t) { return std::max(0.0, 1 - std::abs(t / kStep - 0.29) / 0.05); };
  MotionPath path;
  path.sample([&](double t) { return Placement{{stroke(t), 0}, -0.5 * stroke(t)}; }, 0, kStep, {});
  EXPECT_EQ(path.breaks().size(), 3u);
  EXPECT_GE(path.extent(), 1 - 1e-6);
  EXPECT_LE(path.extent(), 2);
  EXPECT_GE(path.turn(), 0.5 - 1e-6);
  EXPECT_LE(path.turn(), 1);
}

}  // namespace motion_path_test
}  // namespace skerry
