// SPDX-License-Identifier: MIT
//
// What is reported of contacts and joints is what moved the bodies: m dv = m g h + sum of impulses, for each
// body and step.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "tests/support/random_mechanism.h"
#include "tests/support/scale.h"

namespace skerry {
namespace reactions_test {

constexpr double kStep = 1.0 / 60;

/// Impulses on each body of a world in its last step [N s], and the sum of their magnitudes.
struct Impulses {
  std::vector<Vec2> sum;
  std::vector<double> size;
  std::vector<char> turned;  ///< some are of a contact with what turns, and act in the direction of the end

  explicit Impulses(const World& world)
      : sum(world.bodies().size()), size(world.bodies().size()), turned(world.bodies().size()) {
    for (const ContactReport& contact : world.report().contacts_list) {
      const bool still = world.bodies().type[contact.body_a.index] == BodyType::Static;
      for (int k = 0; k < contact.count; ++k) {
        const ContactPointReport& point = contact.points[static_cast<std::size_t>(k)];
        add(contact.body_a, contact.body_b,
            (point.normal_impulse + point.impact_impulse) * contact.normal +
                point.friction_impulse * perp(contact.normal));
        if (!still) turned[contact.body_a.index] = turned[contact.body_b.index] = 1;
      }
    }
    for (const JointRecord& joint : world.joints())
      if (joint.alive) add(joint.def.a, joint.def.b, joint.impulse);
  }

  void add(BodyId a, BodyId b, Vec2 on_b) {
    for (const auto& [body, impulse] : {std::pair{a, -on_b}, std::pair{b, on_b}}) {
      if (!body) continue;
      sum[body.index] += impulse;
      size[body.index] += length(impulse);
    }
  }
};

/// The largest part of the impulses on a body that its motion does not show, by mechanism; nothing where what
/// is told to move crushes something. What is struck is another matter: only normals of impacts are reported.
/// @param from  step to begin with
std::vector<double> worst_errors(const char* stepper, int parts, int from, int worlds) {
  std::vector<double> out;
  for (int seed = 0; seed < worlds; ++seed) {
    test::Recipe recipe = test::RandomMechanism(static_cast<unsigned>(seed)).recipe();
    for (test::Recipe::Part& part : recipe.parts) part.drag = {};
    // These push their two bodies in two directions.
    std::erase_if(recipe.links, [](const test::Recipe::Link& link) {
      return link.joint.kind == JointKind::Pulley || link.joint.kind == JointKind::Rack;
    });
    WorldConfig config;
    config.stepper = stepper;
    World world(config);
    const std::vector<BodyId> bodies = test::build(recipe, world);
    world.observe({.contacts = true});
    double worst = 0;
    bool squeezed = false;
    const double h = kStep / parts;
    for (int k = 0; k < 30 * parts && !squeezed; ++k) {
      std::vector<Vec2> before;
      before.reserve(bodies.size());
      for (const BodyId body : bodies) before.push_back(world.velocity(body));
      const StepReport& report = world.step(h);
      squeezed = report.inexact_islands > 0 || report.worst_penetration > 1e-6;
      if (report.impacts > 0 || k < from) continue;
      const Impulses impulses(world);
      for (std::size_t i = 0; i < bodies.size(); ++i) {
        const double mass = world.mass(bodies[i]);
        const Vec2 moved = mass * (world.velocity(bodies[i]) - before[i] - h * recipe.gravity);
        const std::uint32_t slot = bodies[i].index;
        if (mass > 0 && impulses.turned[slot] == 0)
          worst =
              std::max(worst, length(moved - impulses.sum[slot]) / (9.81 * mass * h + impulses.size[slot]));
      }
    }
    out.push_back(squeezed ? 0 : worst);
  }
  return out;
}

TEST(Reactions, OfEventsAreThoseThatMoveTheBodies) {
  const int worlds = test_scale(100);
  const std::vector<double> errors = worst_errors("event_driven", 1, 0, worlds);
  const auto exact = std::count_if(errors.begin(), errors.end(), [](double e) { return e < 1e-9; });
  const double worst = *std::max_element(errors.begin(), errors.end());
  std::printf("%d of %d exact, the worst %.2g\n", static_cast<int>(exact), worlds, worst);
  EXPECT_GE(static_cast<double>(exact), 0.7 * worlds);
  EXPECT_LT(worst, 0.3);
}

/// Of joints, too, what corrects their velocities belongs to it: without that, reactions were of first order,
/// and those that made a motor, or a weld, have its velocity in the first step were missing.
TEST(Reactions, OfTimeSteppingAreOfSecondOrder) {
  const int worlds = test_scale(100);
  const std::vector<double> whole = worst_errors("time_stepping", 1, 1, worlds);
  const std::vector<double> quarter = worst_errors("time_stepping", 4, 1, worlds);
  EXPECT_LT(*std::max_element(whole.begin(), whole.end()), 0.3);
  double logarithm = 0;
  int inexact = 0;
  for (std::size_t k = 0; k < whole.size(); ++k) {
    if (whole[k] < 1e-6 || quarter[k] < 1e-9) continue;
    logarithm += std::log2(whole[k] / quarter[k]);
    ++inexact;
  }
  std::printf("%d of %d inexact, in quarter steps %.2f times as near\n", inexact, worlds,
              std::exp2(logarithm / inexact));
  EXPECT_GT(inexact, worlds / 10);
  EXPECT_GT(std::exp2(logarithm / inexact), 8);
}

/// A box that tips over on its corner, which holds or slides.
TEST(Reactions, OfACornerHaveTheFrictionOfItsWay) {
  for (const double friction : {2.0, 0.2}) {
    World world;
    test::add_ground(world, test::rough(make_disc(1), friction));
    const double angle = 0.6;
    const Vec2 size{1, 0.4}, corner = rotate(Rot::from_angle(angle), Vec2{-0.5 * size.x, -0.5 * size.y});
    const BodyId box =
        test::add(world, {0, -corner.y}, test::rough(make_box(size), friction), 1, {}, 0, angle);
    world.observe({.contacts = true});
    for (int k = 0; k < 12; ++k) {
      const Vec2 before = world.velocity(box);
      ASSERT_EQ(world.step(kStep).impacts, 0);
      const Impulses impulses(world);
      const Vec2 moved = world.velocity(box) - before + Vec2{0, 9.81 * kStep};
      EXPECT_LT(length(moved - impulses.sum[box.index]), 5e-4 * 9.81 * kStep) << friction << ", step " << k;
    }
  }
}

/// A box that slides over the end of a table: its corner is followed by that of the table.
TEST(Reactions, OfAPointAreThoseOfThePointThatFollowsIt) {
  World world;
  const BodyId table = world.create_body({.type = BodyType::Static});
  world.add_shape(table, test::rough(make_box({4, 1}, {-2, -0.5}), 0.3));
  const BodyId box = test::add(world, {-1, 0.25}, test::rough(make_box({1, 0.5}), 0.3), 1, {3.7, 0});
  world.observe({.contacts = true});
  bool followed = false;
  for (int k = 0; k < 18; ++k) {
    world.step(kStep);
    const Vec2 centre = world.position(box);
    ASSERT_EQ(world.report().contacts_list.size(), 1u);
    const ContactReport& contact = world.report().contacts_list.front();
    ASSERT_EQ(contact.count, 2);
    double turn = 0;
    for (const ContactPointReport& point : contact.points) {
      turn += cross(point.position - centre,
                    point.normal_impulse * contact.normal + point.friction_impulse * perp(contact.normal));
      followed |= std::abs(point.position.x) < 1e-9;
    }
    if (centre.x > -0.1) break;
    EXPECT_NEAR(turn, 0, 0.05 * 9.81 * kStep) << k;
  }
  EXPECT_TRUE(followed);
}

/// What a rod takes from a ball that flies away from its end when it is made counts for breaking.
TEST(Reactions, OfARodThatIsMadeInFlightMayBreakIt) {
  for (const char* stepper : {"event_driven", "time_stepping"}) {
    for (const double strength : {0.9, 1.1}) {
      WorldConfig config = test::weightless();
      config.stepper = stepper;
      World world(config);
      const double mass = 2, speed = 3;
      const BodyId ball = test::add(world, {1, 0}, test::smooth(make_disc(0.1)), mass, {speed, 0});
      const JointId rod = world.create_joint({.kind = JointKind::Distance,
                                              .b = ball,
                                              .anchor_b = {1, 0},
                                              .break_force = strength * mass * speed / kStep});
      world.step(kStep);
      EXPECT_EQ(world.alive(rod), strength > 1) << stepper;
      EXPECT_NEAR(world.velocity(ball).x, 0, 1e-9) << stepper;
    }
  }
}

}  // namespace reactions_test
}  // namespace skerry
