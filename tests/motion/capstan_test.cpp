// SPDX-License-Identifier: MIT
//
// A rope of light links over a rough drum, which does not turn, with a load at each end.
#include <cmath>
#include <gtest/gtest.h>

#include "tests/support/worlds.h"

namespace skerry {
namespace capstan_test {

constexpr double kG = 9.81;

struct Capstan {
  World world;
  BodyId light, heavy;
};

/// `count` hinged links of a gram over the upper half of a drum of 0.5 m, loads of 1 and `ratio` kg, all at
/// rest.
Capstan capstan(const char* stepper, int count, double friction, double ratio) {
  WorldConfig config;
  config.stepper = stepper;
  Capstan made{World(config), {}, {}};
  World& world = made.world;
  const double drum = 0.5, thickness = 0.04, middle = drum + thickness / 2;
  const BodyId ground = world.create_body({.type = BodyType::Static});
  world.add_shape(ground, test::rough(make_disc(drum), friction));
  const auto on_drum = [&](double angle) { return drum * Vec2{std::cos(angle), std::sin(angle)}; };
  BodyId first, last;
  for (int i = 0; i < count; ++i) {
    const double angle = kPi * (1 - (i + 0.5) / count);
    ShapeDef link = test::rough(make_box({kPi * middle / count * 0.9, thickness}), friction);
    link.filter.group = -1;
    const BodyId body =
        test::add(world, (middle / drum) * on_drum(angle), link, 1e-3, {}, 0, angle - kPi / 2);
    const Vec2 joint = on_drum(kPi * (1 - static_cast<double>(i) / count));
    if (last)
      world.create_joint(
          {.kind = JointKind::Revolute, .a = last, .b = body, .anchor_a = joint, .anchor_b = joint});
    if (!first) first = body;
    last = body;
  }
  const auto load = [&](double x, BodyId link, double mass) {
    const BodyId body = test::add(world, {x, -1}, test::rough(make_box({0.2, 0.2}), friction), mass);
    world.create_joint(
        {.kind = JointKind::Rope, .a = link, .b = body, .anchor_a = {x, 0}, .anchor_b = {x, -1}});
    return body;
  };
  made.light = load(-drum, first, 1);
  made.heavy = load(drum, last, ratio);
  return made;
}

/// Acceleration of the loads on a rope without mass [Euler 1769; Eytelwein 1808].
double acceleration(double friction, double ratio) {
  const double grip = std::exp(friction * kPi);
  return ratio > grip ? kG * (ratio - grip) / (ratio + grip) : 0;
}

TEST(Capstan, HoldsAndSlidesAsEulerSays) {
  for (const auto& [friction, ratio] : {std::pair{0.2, 1.8}, std::pair{0.2, 2.2}, std::pair{0.05, 1.2}}) {
    SCOPED_TRACE(testing::Message() << "friction " << friction << ", ratio " << ratio);
    const double way = acceleration(friction, ratio) / 2;
    double events = 0;
    for (const char* stepper : {"event_driven", "time_stepping", "auto"}) {
      for (const double h : {1.0 / 60, 1.0 / 240}) {
        SCOPED_TRACE(testing::Message() << stepper << ", " << h << " s");
        Capstan made = capstan(stepper, 40, friction, ratio);
        const int steps = static_cast<int>(std::lround(1 / h));
        for (int k = 0; k < steps; ++k) made.world.step(h);
        const double found = -1 - made.world.position(made.heavy).y;
        // The rope weighs 40 g, and the links take some grip less than a thin rope does.
        EXPECT_NEAR(found, way, way > 0 ? 0.15 * way : 1e-9);
        if (events == 0) events = found;
        EXPECT_NEAR(found, events, 2e-3 * std::abs(events) + 1e-12);
      }
    }
  }
}

// Of three links some stick in the first instant, and that mode has no motion left by the end of the step:
// what they were held with was more than friction can do, and the loads stood still.
TEST(Capstan, SticksNoHarderThanFrictionCan) {
  for (const int count : {3, 5}) {
    SCOPED_TRACE(count);
    Capstan made = capstan("time_stepping", count, 0.05, 2.2);
    made.world.observe({.contacts = true});
    const double h = 1e-3;
    const StepReport& report = made.world.step(h);
    const double way = -1 - made.world.position(made.heavy).y, speed = -made.world.velocity(made.heavy).y;
    EXPECT_NEAR(speed, 2 * way / h, 1e-2 * speed);
    EXPECT_GT(speed, 2e-3);
    for (const ContactReport& contact : report.contacts_list)
      for (int i = 0; i < contact.count; ++i) {
        const ContactPointReport& point = contact.points[static_cast<std::size_t>(i)];
        EXPECT_LE(std::abs(point.friction_impulse), 0.05 * point.normal_impulse * (1 + 1e-5) + 1e-12);
      }
  }
}

}  // namespace capstan_test
}  // namespace skerry
