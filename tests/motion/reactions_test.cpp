// SPDX-License-Identifier: MIT
//
// What is reported of contacts and joints is what moved the bodies: m dv = m g h + sum of impulses, for each
// body and step.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <ostream>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "tests/support/random_mechanism.h"
#include "tests/support/scale.h"

namespace skerry {
namespace reactions_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;
using test::weightless;

constexpr double kStep = 1.0 / 60;

/// Impulses on each body of a world in its last step [N s], and the sum of their magnitudes.
struct Impulses {
  std::vector<Vec2> sum;
  std::vector<double> size;

  explicit Impulses(const World& world) : sum(world.bodies().size()), size(world.bodies().size()) {
    for (const ContactReport& contact : world.report().contacts_list)
      add(contact.body_a, contact.body_b, contact.impulse);
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
/// is told to move crushes something.
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
      if (k < from) continue;
      const Impulses impulses(world);
      for (std::size_t i = 0; i < bodies.size(); ++i) {
        const double mass = world.mass(bodies[i]);
        const Vec2 moved = mass * (world.velocity(bodies[i]) - before[i] - h * recipe.gravity);
        const std::uint32_t slot = bodies[i].index;
        if (mass > 0)
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

/// What bounces, is struck, slides off a table or over terrain, and tumbles: contacts of a step that are gone
/// when it ends, normals that turn within it, friction of impacts.
struct Scene {
  const char* name;
  void (*make)(World& world);
};

std::ostream& operator<<(std::ostream& out, const Scene& scene) {
  return out << scene.name;
}

void make_bouncing(World& world) {
  test::add_ground(world, test::rough(make_disc(1), 0.5, 0.5));
  for (int i = 0; i < 3; ++i)
    test::add(world, {1.2 * i, 1.0 + 0.4 * i}, test::rough(make_disc(0.5), 0.5, 0.8), 1, {1, -2}, 3);
}

void make_struck_stack(World& world) {
  test::add_ground(world, test::rough(make_disc(1), 0.6));
  for (int i = 0; i < 5; ++i) test::add(world, {0.02 * i, 0.5 + i}, test::rough(make_box({1, 1}), 0.6));
  test::add(world, {-6, 2.5}, test::rough(make_disc(0.4), 0.3, 0.3), 2, {12, 0});
}

void make_table(World& world) {
  const BodyId table = world.create_body({.type = BodyType::Static});
  world.add_shape(table, test::rough(make_box({2, 1}, {0, -0.5}), 0.3));
  test::add(world, {-0.4, 0.1}, test::rough(make_box({0.4, 0.2}), 0.3), 1, {4, 0});
}

void make_terrain(World& world) {
  const BodyId ground = world.create_body({.type = BodyType::Static});
  std::vector<Vec2> corners;
  for (int i = 0; i <= 40; ++i) corners.push_back({-10 + 0.5 * i, 0.3 * std::sin(0.9 * i)});
  world.add_shape(ground, test::rough(make_chain(corners), 0.3));
  for (int i = 0; i < 4; ++i)
    test::add(world, {-6.0 + 3 * i, 2},
              test::rough(i % 2 == 1 ? make_disc(0.4) : make_box({0.8, 0.5}), 0.3, 0.2 * i), 1, {1, 0}, 1);
}

void make_tumbler(World& world) {
  const BodyId drum = world.create_body({.type = BodyType::Kinematic, .omega = 0.8});
  for (const double side : {-2.0, 2.0}) {
    world.add_shape(drum, test::rough(make_box({4, 0.2}, {0, side}), 0.5));
    world.add_shape(drum, test::rough(make_box({0.2, 4}, {side, 0}), 0.5));
  }
  for (int i = 0; i < 6; ++i)
    test::add(world, {-1 + 0.4 * i, -1 + 0.3 * (i % 3)}, test::rough(make_box({0.3, 0.3}), 0.5));
}

class Books : public testing::TestWithParam<std::tuple<const char*, Scene>> {};

TEST_P(Books, OfEachBodyBalanceInEachStep) {
  const auto& [stepper, scene] = GetParam();
  WorldConfig config;
  config.stepper = stepper;
  World world(config);
  scene.make(world);
  world.observe({.contacts = true});
  double worst = 0;
  for (int k = 0; k < 120; ++k) {
    const std::vector<Vec2> before = world.bodies().velocity;
    world.step(kStep);
    const Impulses impulses(world);
    for (std::size_t i = 0; i < before.size(); ++i) {
      const double mass = world.bodies().mass[i];
      if (world.bodies().type[i] != BodyType::Dynamic) continue;
      const Vec2 moved = mass * (world.bodies().velocity[i] - before[i] - kStep * config.gravity);
      worst = std::max(worst, length(moved - impulses.sum[i]) / (9.81 * mass * kStep + impulses.size[i]));
    }
  }
  // What projections give back for the sake of the energy is no impulse, and of second order.
  EXPECT_LT(worst, std::string_view(stepper) == "event_driven" ? 3e-4 : 3e-3);
}

const Scene kScenes[] = {{"Bouncing", make_bouncing},
                         {"StruckStack", make_struck_stack},
                         {"Table", make_table},
                         {"Terrain", make_terrain},
                         {"Tumbler", make_tumbler}};

std::string name_of(const testing::TestParamInfo<Books::ParamType>& books) {
  return std::string(std::get<0>(books.param)) + std::get<1>(books.param).name;
}

INSTANTIATE_TEST_SUITE_P(All, Books,
                         testing::Combine(testing::Values("time_stepping", "event_driven"),
                                          testing::ValuesIn(kScenes)),
                         name_of);

/// The ball is over the next segment of the ground when the step of its bounce ends.
TEST(Reactions, OfABounceThatIsOverAreListed) {
  for (const char* stepper : {"event_driven", "time_stepping"}) {
    WorldConfig config = test::weightless();
    config.stepper = stepper;
    World world(config);
    const BodyId ground = world.create_body({.type = BodyType::Static});
    world.add_shape(ground, test::smooth(make_chain(std::vector<Vec2>{{-5, 0}, {2.1, 0}, {9, 0}}), 1));
    test::add(world, {2, 0.6}, test::smooth(make_disc(0.5), 1), 3, {5, -10});
    world.observe({.contacts = true});
    const StepReport& report = world.step(0.05);
    const auto struck = [](const ContactReport& contact) { return contact.points[0].impact_impulse > 0; };
    const auto& contacts = report.contacts_list;
    const auto contact = std::find_if(contacts.begin(), contacts.end(), struck);
    ASSERT_NE(contact, contacts.end()) << stepper;
    ASSERT_EQ(contact->count, 1);
    const ContactPointReport& point = contact->points[0];
    EXPECT_NEAR(point.impact_impulse, 60, 1e-12);
    EXPECT_NEAR(length(contact->impulse - Vec2{0, 60}), 0, 1e-12);
    EXPECT_NEAR(length(point.position - Vec2{2.05, 0}), 0, 1e-9);
    EXPECT_NEAR(point.separation, std::hypot(0.15, 0.9) - 0.5, 1e-12);
  }
}

/// Discs that meet aslant have turned about each other when the step ends.
TEST(Reactions, OfAnImpactHaveItsNormal) {
  for (const char* stepper : {"event_driven", "time_stepping"}) {
    WorldConfig config = test::weightless();
    config.stepper = stepper;
    World world(config);
    const BodyId still = test::add(world, {0, 0}, test::smooth(make_disc(0.5), 0));
    test::add(world, {-1.1, 0.6}, test::smooth(make_disc(0.5), 0), 1, {20, 0});
    world.observe({.contacts = true});
    const StepReport& report = world.step(0.05);
    ASSERT_EQ(report.contacts_list.size(), 1u) << stepper;
    const ContactReport& contact = report.contacts_list.front();
    const Vec2 normal{0.8, -0.6}, impulse = (contact.body_b == still ? 1.0 : -1.0) * contact.impulse;
    EXPECT_NEAR(length(impulse - 8 * normal), 0, 1e-9);
    EXPECT_NEAR(std::abs(dot(contact.impact_normal, normal)), 1, 1e-12);
    EXPECT_LT(std::abs(dot(contact.normal, normal)), 0.99);
  }
}

TEST(Reactions, OfAFaceThatBouncedOffAreInTheSums) {
  for (const char* stepper : {"event_driven", "time_stepping"}) {
    WorldConfig config = weightless();
    config.stepper = stepper;
    World world(config);
    add_ground(world, smooth(make_disc(1), 0.5));
    add(world, {0, 0.6}, smooth(make_box({1, 1}), 0.5), 3, {0, -10});
    world.observe({.contacts = true});
    const StepReport& report = world.step(0.05);
    ASSERT_EQ(report.contacts_list.size(), 1u) << stepper;
    const ContactReport& contact = report.contacts_list[0];
    EXPECT_NEAR(length(contact.impulse - Vec2{0, 45}), 0, 1e-9) << stepper;
    EXPECT_NEAR(contact.points[0].impact_impulse + contact.points[1].impact_impulse, 45, 1e-9) << stepper;
    EXPECT_NEAR(report.total_normal_impulse, 45, 1e-9) << stepper;
    EXPECT_EQ(report.total_friction_impulse, 0) << stepper;
  }
}

TEST(Reactions, OfWhatRestsHaveNoPlaceOfAnImpactButTheirOwn) {
  World world;
  world.observe({.contacts = true});
  add_ground(world, rough(make_disc(1), 0.5));
  add(world, {0, 0.501}, rough(make_box({1, 1}), 0.5), 1, {2, -1});
  bool struck = false;
  for (int i = 0; i < 60; ++i) {
    for (const ContactReport& contact : world.step(1.0 / 60).contacts_list) {
      for (int k = 0; k < contact.count; ++k) {
        const ContactPointReport& point = contact.points[static_cast<std::size_t>(k)];
        if (point.impact_impulse > 0)
          struck = true;
        else
          EXPECT_EQ(point.impact_position, point.position) << i;
      }
    }
  }
  EXPECT_TRUE(struck);
}

TEST(Reactions, OfABarThatTurnsPointAlongItInTheMiddleOfTheStep) {
  World world(weightless());
  const BodyId bob = add(world, {1, 0}, smooth(make_disc(0.1)), 2, {0, 3});
  const JointId bar =
      world.create_joint({.kind = JointKind::Distance, .b = bob, .anchor_a = {0, 0}, .anchor_b = {1, 0}});
  for (int i = 0; i < 20; ++i) {
    const Vec2 before = world.velocity(bob);
    world.step(0.02);
    const Vec2 change = 2 * (world.velocity(bob) - before);
    EXPECT_LT(length(world.joints()[bar.index].impulse - change), 2e-3 * length(change)) << i;
  }
}

}  // namespace reactions_test
}  // namespace skerry
