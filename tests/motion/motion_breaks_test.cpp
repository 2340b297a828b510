// SPDX-License-Identifier: MIT
//
// Prescribed motions that are not smooth: what lies on ground that sets off, stops or turns about within a
// step feels it then, and what jumps is elsewhere and strikes nothing on its way.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <random>
#include <string>

#include "physics/stepping/motion_path.h"
#include "tests/support/draw.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace motion_breaks_test {

using test::add;
using test::Draw;
using test::rough;

constexpr double kStep = 1.0 / 60, kGravity = 10;

struct Way {
  const char* stepper;
  double accuracy;  ///< 0: none asked for
};

class MotionBreaks : public testing::TestWithParam<Way> {
 protected:
  static World make(Vec2 gravity = {0, -kGravity}) {
    WorldConfig config;
    config.gravity = gravity;
    config.stepper = GetParam().stepper;
    if (GetParam().accuracy > 0) config.accuracy = GetParam().accuracy;
    return World(config);
  }
};
INSTANTIATE_TEST_SUITE_P(Ways, MotionBreaks,
                         testing::Values(Way{"time_stepping", 0}, Way{"time_stepping", 1e-6},
                                         Way{"event_driven", 0}, Way{"auto", 0}),
                         [](const testing::TestParamInfo<Way>& way) {
                           return std::string(way.param.stepper) +
                                  (way.param.accuracy > 0 ? "_accurate" : "");
                         });

BodyId add_table(World& world, double width, double friction, double restitution) {
  const BodyId table = world.create_body({.type = BodyType::Kinematic});
  world.add_shape(table, rough(make_box({width, 1}), friction, restitution));
  return table;
}

/// A lift that sets off at a time [s] with a speed [m/s], up or down, and a box on it. @return how far the
/// gap between the two is from its closed form at worst [m], until the box lands
double error_of_lift(World world, double start, double speed, double restitution) {
  const BodyId lift = add_table(world, 10, 0.5, restitution);
  const BodyId box = add(world, {0, 1}, rough(make_box({1, 1}), 0.5, restitution));
  const auto height = [=](double t) { return t > start ? speed * (t - start) : 0; };
  world.set_motion(lift, [=](double t) { return Placement{{0, height(t)}, 0}; });
  // Struck from below it leaves with e v against the lift; where the lift leaves it, with -v.
  const double away = speed > 0 ? restitution * speed : -speed;
  double worst = 0;
  while (world.time() < start + 0.8 * std::max(2 * away / kGravity, 0.1)) {
    world.step(kStep);
    const double since = std::max(world.time() - start, 0.0);
    const double gap = away > 0 ? since * (away - 0.5 * kGravity * since) : 0;
    worst = std::max(worst, std::abs(world.position(box).y - 1 - height(world.time()) - gap));
  }
  return worst;
}

TEST_P(MotionBreaks, ALiftSetsOffWithinAStep) {
  for (const double speed : {1.0, -1.0, 5.0}) {
    for (const double restitution : {0.0, 0.5}) {
      for (int tenth = 0; tenth <= 10; ++tenth)
        EXPECT_LT(error_of_lift(make(), (10 + 0.1 * tenth) * kStep, speed, restitution), 1e-11)
            << speed << " m/s, e " << restitution << ", after " << tenth << " tenths of the step";
    }
  }
}

TEST_P(MotionBreaks, ATurntableThatSetsOffTakesAlongWhatIsHingedToIt) {
  // A wheel on a hinge at the rim: its centre goes round with the table, and nothing turns it.
  World world = make();
  const double start = 7.37 * kStep, turning = 2;
  const BodyId table = world.create_body({.type = BodyType::Kinematic});
  const BodyId wheel = add(world, {2, 0}, rough(make_disc(0.3), 0));
  world.create_joint(
      {.kind = JointKind::Revolute, .a = table, .b = wheel, .anchor_a = {2, 0}, .anchor_b = {2, 0}});
  const auto angle = [=](double t) { return t > start ? turning * (t - start) : 0; };
  world.set_motion(table, [=](double t) { return Placement{{0, 0}, angle(t)}; });
  while (world.time() < 1) {
    world.step(kStep);
    const double now = angle(world.time()), speed = world.time() > start ? 2 * turning : 0;
    EXPECT_LT(length(world.position(wheel) - 2.0 * Vec2{std::cos(now), std::sin(now)}), 1e-10);
    EXPECT_LT(length(world.velocity(wheel) - speed * Vec2{-std::sin(now), std::cos(now)}), 1e-9);
    EXPECT_NEAR(world.omega(wheel), 0, 1e-9);
  }
}

TEST_P(MotionBreaks, OnePlankOnTwoLiftsThatSetOffOneAfterTheOther) {
  // Each lift gives its end of the plank the speed; where both are off, the plank goes up with them. The
  // plank's ends have a gap of nothing all along, as plastic impacts at one end press the other down: half a
  // step later.
  World world = make();
  const double first = 5.25 * kStep, second = 5.75 * kStep, speed = 0.5;
  for (const double side : {-1.0, 1.0}) {
    const BodyId lift = world.create_body({.type = BodyType::Kinematic, .position = {3 * side, 0}});
    world.add_shape(lift, rough(make_box({1, 1}), 0.5));
    const double start = side < 0 ? first : second;
    world.set_motion(lift, [=](double t) {
      return Placement{{3 * side, t > start ? speed * (t - start) : 0}, 0};
    });
  }
  const BodyId plank = add(world, {0, 0.6}, rough(make_box({7, 0.2}), 0.5), 3);
  double pushed = 0;
  world.observe({.contacts = true});
  while (world.time() < 0.5) {
    const Vec2 before = world.velocity(plank);
    const StepReport& report = world.step(kStep);
    double push = 0;
    for (const ContactReport& contact : report.contacts_list)
      push += contact.body_b == plank ? contact.impulse.y : -contact.impulse.y;
    // All that contacts tell is what the plank got.
    EXPECT_NEAR(push, 3 * (world.velocity(plank).y - before.y + kGravity * kStep), 1e-9);
    pushed += push;
  }
  EXPECT_GT(pushed, 3 * kGravity * 0.4);
  EXPECT_LT(world.report().worst_penetration, 1e-8);
}

TEST_P(MotionBreaks, ATableThatJumpsAwayLeavesItsLoadToFall) {
  for (const double part : {0.0, 0.3, 0.77}) {
    World world = make();
    const double start = (20 + part) * kStep;
    const BodyId table = add_table(world, 2, 0.5, 0);
    const BodyId box = add(world, {0, 1}, rough(make_box({1, 1}), 0.5));
    world.set_motion(table, [=](double t) { return Placement{{t < start ? 0.0 : 3.0, 0}, 0}; });
    while (world.time() < 0.9) world.step(kStep);
    const double since = world.time() - start;
    EXPECT_NEAR(world.position(box).y, 1 - 0.5 * kGravity * since * since, 1e-12);
    EXPECT_EQ(world.position(box).x, 0);
    EXPECT_EQ(world.velocity(box).x, 0);
  }
}

TEST_P(MotionBreaks, APaddleThatJumpsBackStrikesNothing) {
  // Frictionless, so the box keeps the speed that the paddle gave it, and is far away when that comes again.
  for (const double period : {0.5, 0.61, 0.677}) {
    World world = make();
    test::add_ground(world, rough(make_disc(1), 0));
    const BodyId paddle = world.create_body({.type = BodyType::Kinematic, .position = {-1, 0.6}});
    world.add_shape(paddle, rough(make_box({0.2, 1}), 0));
    const BodyId box = add(world, {0.6, 0.5}, rough(make_box({1, 1}), 0));
    const double speed = 2 / period;
    world.set_motion(paddle, [=](double t) {
      return Placement{{-1 + speed * std::fmod(t, period), 0.6}, 0};
    });
    while (world.time() < 2.1) {
      world.step(kStep);
      EXPECT_LT(length(world.velocity(box)), speed * (1 + 1e-9)) << world.time() << ", period " << period;
    }
    // Struck where the paddle's face is at 0.1 m.
    const double struck = (0.1 + 1 - 0.1) / speed;
    EXPECT_NEAR(world.position(box).x, 0.6 + speed * (world.time() - struck), 1e-9) << "period " << period;
  }
}

TEST_P(MotionBreaks, WhatHangsOnWhatJumpsIsTakenAlong) {
  for (const double part : {0.0, 0.3, 0.77}) {
    World world = make();
    const double start = (20 + part) * kStep;
    const BodyId carrier = world.create_body({.type = BodyType::Kinematic});
    const BodyId bob = add(world, {0, -1}, rough(make_box({0.2, 0.2}), 0));
    world.create_joint({.kind = JointKind::Revolute, .a = carrier, .b = bob});
    world.set_motion(carrier, [=](double t) { return Placement{{t < start ? 0.0 : 1.0, 0}, 0}; });
    while (world.time() < 0.9) {
      world.step(kStep);
      // From wherever it is put it swings, and its own height is all the energy that it has.
      EXPECT_LT(length(world.velocity(bob)), std::sqrt(2 * kGravity * 2));
    }
    EXPECT_NEAR(length(world.position(bob) - Vec2{1, 0}), 1, 1e-9);
  }
}

/// What lifts it takes nothing of its speed.
TEST_P(MotionBreaks, ABarSwingsOnOnAHingeThatJumps) {
  const auto turns = [](double up, double start) {
    World world = make();
    const BodyId carrier = world.create_body({.type = BodyType::Kinematic});
    const BodyId bar = add(world, {0.5, 0}, rough(make_box({1, 0.1}), 0), 1);
    world.create_joint({.kind = JointKind::Revolute, .a = carrier, .b = bar});
    world.set_motion(carrier, [=](double t) { return Placement{{0, t < start ? 0.0 : up}, 0}; });
    for (int i = 0; i < 16; ++i) {
      world.step(kStep);
      EXPECT_NEAR(length(world.position(bar) - world.position(carrier)), 0.5, 1e-9);
    }
    EXPECT_EQ(world.position(carrier).y, up);
    return world.omega(bar);
  };
  // Within a step, where one ends and another begins, and a little before and after that.
  for (const double step : {15.3, 15.0, 15 * (1 - 1e-12), 15 * (1 + 1e-12)}) {
    const double start = step * kStep, without = turns(0, start);
    EXPECT_LT(without, -3);
    for (const double up : {-0.05, -0.01, 0.01, 0.05})
      EXPECT_NEAR(turns(up, start), without, 0.2 * std::abs(up * without)) << up << " at step " << step;
  }
}

TEST_P(MotionBreaks, WhatHangsAtRestGoesWithAHookThatJumps) {
  // Asleep, and where a step ends or begins; then it swings from where the jump has put it.
  for (const double step : {130.0, 130 * (1 - 1e-12), 130 * (1 + 1e-12)}) {
    World world = make();
    const BodyId hook = world.create_body({.type = BodyType::Kinematic});
    const BodyId bar = add(world, {0, -0.5}, rough(make_box({0.1, 1}), 0), 1);
    world.create_joint({.kind = JointKind::Revolute, .a = hook, .b = bar});
    world.set_motion(hook, [=](double t) { return Placement{{0, t < step * kStep ? 0.0 : 0.1}, 0}; });
    for (int i = 0; i < 140; ++i) {
      world.step(kStep);
      EXPECT_NEAR(length(world.position(bar) - world.position(hook) + Vec2{0, 0.5}), 0, 1e-9) << i;
      EXPECT_NEAR(length(world.velocity(bar)), 0, 1e-9) << i;
    }
    EXPECT_EQ(world.position(hook).y, 0.1);
  }
}

TEST_P(MotionBreaks, WhatIsWeldedOnTurnsWithWhatJumps) {
  for (const double step : {5.4, 5.0, 5 * (1 - 1e-12), 5 * (1 + 1e-12)}) {
    World world = make({0, 0});
    const BodyId carrier = world.create_body({.type = BodyType::Kinematic});
    const BodyId bar = add(world, {0.5, 0}, rough(make_box({1, 0.1}), 0), 1);
    world.create_joint({.kind = JointKind::Weld, .a = carrier, .b = bar});
    world.set_motion(carrier, [=](double t) {
      return t < step * kStep ? Placement{} : Placement{{0.2, 0.1}, 0.3};
    });
    for (int i = 0; i < 8; ++i) {
      world.step(kStep);
      EXPECT_NEAR(world.angle(bar), world.angle(carrier), 1e-12) << step << ", after step " << i;
      const Vec2 arm = rotate(Rot::from_angle(world.angle(carrier)), {0.5, 0});
      EXPECT_LT(length(world.position(bar) - world.position(carrier) - arm), 1e-12) << step << ", " << i;
      EXPECT_LT(world.kinetic_energy(), 1e-20) << step << ", after step " << i;
    }
    EXPECT_EQ(world.angle(carrier), 0.3);
  }
}

TEST_P(MotionBreaks, ABarGoesOnTurningAboutAHingeThatStops) {
  // Its hinge takes what goes along the arm: w = V r m / (I + m r^2), for ever.
  const double speed = 5, stop = 3.3 * kStep;
  World world = make({0, 0});
  const BodyId carrier = world.create_body({.type = BodyType::Kinematic});
  const BodyId bar = add(world, {0.5, 0}, rough(make_box({1, 0.1}), 0), 1, {0, speed});
  world.create_joint({.kind = JointKind::Revolute, .a = carrier, .b = bar});
  world.set_motion(carrier, [=](double t) { return Placement{{0, speed * std::min(t, stop)}, 0}; });
  const double turning = 0.5 * speed / (world.inertia(bar) + 0.25);
  while (world.time() < 1) {
    world.step(kStep);
    const double angle = turning * std::max(world.time() - stop, 0.0);
    const Vec2 hinge{0, speed * std::min(world.time(), stop)};
    EXPECT_LT(length(world.position(bar) - hinge - 0.5 * Vec2{std::cos(angle), std::sin(angle)}),
              GetParam().accuracy > 0                              ? 1e-5
              : std::string(GetParam().stepper) == "time_stepping" ? 2e-2
                                                                   : 1e-9)
        << world.time();
  }
  EXPECT_NEAR(world.omega(bar), turning, 1e-3 * turning);
}

TEST_P(MotionBreaks, AShortStrokeThrowsWhatLiesOnIt) {
  // Up at a speed for a tenth of a step: what lies there goes on when it ends.
  for (const double speed : {1.0, 20.0}) {
    World world = make();
    const double start = 3.26 * kStep, end = 3.36 * kStep;
    const BodyId lift = add_table(world, 4, 0.5, 0);
    const BodyId box = add(world, {0, 1}, rough(make_box({1, 1}), 0.5));
    world.set_motion(lift, [=](double t) {
      return Placement{{0, speed * std::clamp(t - start, 0.0, end - start)}, 0};
    });
    while (world.time() < 3.9 * kStep) world.step(kStep);
    EXPECT_NEAR(world.velocity(box).y, speed - kGravity * (world.time() - end), 1e-9) << speed;
  }
}

TEST_P(MotionBreaks, GroundThatJumpsIntoABodyDoesNotHoldIt) {
  // Up by a little, and then down faster than the box falls: it is left behind.
  for (const double jump : {1e-6, 1e-2}) {
    World world = make();
    const double start = 3.3 * kStep;
    const BodyId lift = add_table(world, 4, 0.5, 0);
    const BodyId box = add(world, {0, 1}, rough(make_box({1, 1}), 0.5));
    world.set_motion(lift, [=](double t) {
      return Placement{{0, t < start ? 0.0 : jump - 1.0 * (t - start)}, 0};
    });
    world.observe({.contacts = true});
    while (world.time() < 3.5 * kStep) {
      const double before = world.velocity(box).y;
      const StepReport& report = world.step(kStep);
      double push = 0;
      for (const ContactReport& contact : report.contacts_list)
        push += contact.body_b == box ? contact.impulse.y : -contact.impulse.y;
      EXPECT_NEAR(push, world.velocity(box).y - before + kGravity * kStep, 1e-9);
    }
    EXPECT_NEAR(world.velocity(box).y, -kGravity * (world.time() - start), 1e-9) << jump;
  }
}

TEST_P(MotionBreaks, ASpringWhoseEndJumpsPullsFromThere) {
  const double jump = 3.3 * kStep;
  const auto after_a_step = [&](bool by_hand) {
    World world = make({0, 0});
    const BodyId end = world.create_body({.type = BodyType::Kinematic});
    const BodyId body = add(world, {1, 0}, rough(make_box({1, 0.1}), 0));
    world.create_joint({.kind = JointKind::Spring,
                        .a = end,
                        .b = body,
                        .anchor_a = {0, 0},
                        .anchor_b = {1, 0},
                        .stiffness = 100});
    world.set_motion(end, [=](double t) { return Placement{{0, by_hand || t < jump ? 0 : 0.5}, 0}; });
    for (int k = 0; k < 3; ++k) world.step(kStep);
    if (by_hand) {
      world.step(jump - world.time());
      world.set_motion(end, [](double) { return Placement{{0, 0.5}, 0}; });
    }
    world.step(4 * kStep - world.time());
    return world.velocity(body);
  };
  EXPECT_LT(length(after_a_step(false) - after_a_step(true)), 1e-6);
  EXPECT_GT(length(after_a_step(true)), 0.1);
}

TEST_P(MotionBreaks, AreWhereTheyAreAfterALongTimeToo) {
  // Sums of steps drift from round times by more than their rounding: jumps come just before and after steps
  // begin. What goes along with the paddle, and is put onto it anew before each step, has its speed after it.
  World world = make({0, 0});
  const BodyId paddle = world.create_body({.type = BodyType::Kinematic});
  world.add_shape(paddle, rough(make_box({0.2, 1}), 0));
  const BodyId box = add(world, {0.35, 0}, rough(make_box({0.5, 0.5}), 0));
  world.set_motion(paddle, [](double t) { return Placement{{std::fmod(t, 0.2), 0}, 0}; });
  while (world.time() < 500) {
    world.set_pose(box, {world.position(paddle).x + 0.35, 0}, 0);
    world.set_velocity(box, {1, 0}, 0);
    world.step(kStep);
    ASSERT_NEAR(world.velocity(box).x, 1, 1e-6) << world.time();
  }
}

TEST_P(MotionBreaks, AHeapOnATableThatStartsKeepsTogether) {
  // Enough to flow: what contacts say is what the heap got in each step, the break included. Half of 40 such
  // heaps say that to 1e-12 in all of their steps; a tenth are off by 3e-5 in one, one heap by 1e-4.
  if (GetParam().accuracy > 0) GTEST_SKIP() << "nothing flows where an accuracy is asked for";
  World world = make();
  const double start = 60.4 * kStep, speed = 1.5;
  const BodyId table = add_table(world, 30, 0.5, 0);
  Draw draw(68);
  double mass = 0;
  std::vector<BodyId> heap;
  for (int k = 0; k < 60; ++k) {
    const int course = k / 10;
    heap.push_back(add(world, {0.9 * (k % 10) - 4 + draw.uniform(-0.05, 0.05), 1.1 + 1.1 * course},
                       rough(make_box({draw.uniform(0.5, 0.9), draw.uniform(0.5, 0.9)}), 0.5)));
    mass += 1;
  }
  world.set_motion(table, [=](double t) { return Placement{{t > start ? speed * (t - start) : 0, 0}, 0}; });
  world.observe({.contacts = true});
  const auto momentum = [&] {
    Vec2 sum;
    for (const BodyId body : heap) sum += world.velocity(body);
    return sum;
  };
  while (world.time() < 1.5) {
    const Vec2 before = momentum();
    const StepReport& report = world.step(kStep);
    Vec2 push;
    for (const ContactReport& contact : report.contacts_list) {
      if (contact.body_a == table) push += contact.impulse;
      if (contact.body_b == table) push -= contact.impulse;
    }
    const Vec2 got = momentum() - before + Vec2{0, kGravity * kStep * mass};
    EXPECT_LT(length(push - got), 3e-4 * (1 + length(got))) << world.time();
    if (world.time() > 1) {
      EXPECT_LT(report.worst_penetration, 0.02);
      for (const BodyId body : heap) EXPECT_LT(length(world.velocity(body)), 3 * speed + 3);
    }
  }
}

TEST(FlowWithBreaks, AHeapGoesOnWhereItsTableChangesItsSpeed) {
  WorldConfig config;
  config.flow_work = 1;
  World world(config);
  const BodyId table = world.create_body({.type = BodyType::Kinematic});
  world.add_shape(table, rough(make_box({100, 1}), 0.5));
  const double kink = 30.4 * kStep;
  world.set_motion(table, [=](double t) { return Placement{{t + 0.5 * std::max(t - kink, 0.0), 0}, 0}; });
  std::vector<BodyId> discs;
  for (int i = 0; i < 100; ++i) {
    const int row = i / 10;
    const Vec2 at{0.3 * (i % 10) + 0.013 * (row * 7 % 5), 0.7 + 0.29 * row};
    discs.push_back(add(world, at, rough(make_disc(0.15 - 0.002 * (i % 7)), 0.5), 1, {1, 0}));
  }
  int flowing = 0;
  for (int i = 0; i < 40; ++i) {
    double way = 0, speed = 0;
    for (const BodyId disc : discs) {
      way -= world.position(disc).x;
      speed += world.velocity(disc).x;
    }
    world.step(kStep);
    for (const BodyId disc : discs) way += world.position(disc).x;
    if (i == 30) {
      for (const IslandReport& island : world.report().islands_list) flowing += island.flowing ? 1 : 0;
    }
    if (i > 20) {
      EXPECT_NEAR(way, speed * kStep, 0.3 * speed * kStep) << i;
    }
  }
  EXPECT_GT(flowing, 0);
}

}  // namespace motion_breaks_test
}  // namespace skerry
