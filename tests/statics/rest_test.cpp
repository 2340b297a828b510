// SPDX-License-Identifier: MIT
//
// Worlds at rest: forces by formula, what falls, and agreement with the step.
#include "physics/statics/rest.h"

#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <stdexcept>
#include <utility>
#include <vector>

#include "tests/support/worlds.h"

namespace skerry::statics::test {
namespace rest_test {

using skerry::test::add;
using skerry::test::add_ground;
using skerry::test::rough;
using skerry::test::smooth;

/// Fixed discs of radius 0.5, centres at height 0.
void add_posts(World& world, const std::vector<double>& places) {
  for (const double x : places) {
    const BodyId post = world.create_body({.type = BodyType::Static, .position = {x, 0}});
    world.add_shape(post, smooth(make_disc(0.5)));
  }
}

/// What slides has a friction of `sliding`, what stands one of `standing`.
ShapeDef gripping(Shape shape, double sliding, double standing) {
  ShapeDef def = rough(std::move(shape), sliding);
  def.material.static_friction = standing;
  return def;
}

/// A box that its weight pulls down to where a spring of 2 m from (0, 2) bears it.
void hang_on_a_spring(World& world, double mass, double stiffness) {
  const Vec2 at{0, -9.81 * mass / stiffness};
  const BodyId load = add(world, at, smooth(make_box({1, 0.2})), mass);
  world.create_joint({.kind = JointKind::Spring,
                      .b = load,
                      .anchor_a = {0, 2},
                      .anchor_b = at,
                      .length = 2,
                      .stiffness = stiffness});
}

TEST(Rest, ContactKOfAColumnCarriesTheWeightAboveIt) {
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  const int count = 12;
  for (int i = 0; i < count; ++i) add(world, {0, i + 0.5}, rough(make_box({1, 1}), 0.5), 2);
  const RestAnalysis rest = analyse_rest(world);
  EXPECT_TRUE(rest.stands);
  const std::vector<PairForce> pairs = pair_forces(rest);
  ASSERT_EQ(pairs.size(), static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    EXPECT_NEAR(pairs[static_cast<std::size_t>(k)].normal, 2 * 9.81 * (count - k), 1e-9);
    EXPECT_NEAR(pairs[static_cast<std::size_t>(k)].eccentricity, 0, 1e-9);
  }
  for (const RestContact& contact : rest.contacts) EXPECT_TRUE(contact.normal_unique);
  EXPECT_EQ(fate_of(rest), Fate::Stands);
}

TEST(Rest, SupportsOfAPlankShareItByMoments) {
  World world;
  add_posts(world, {-1.0, 2.0});
  const BodyId plank = add(world, {0, 0.6}, smooth(make_box({6, 0.2})), 10);
  (void)plank;
  const RestAnalysis rest = analyse_rest(world);
  ASSERT_EQ(rest.contacts.size(), 2u);
  EXPECT_NEAR(rest.contacts[0].normal_force, 10 * 9.81 * 2 / 3, 1e-9);
  EXPECT_NEAR(rest.contacts[1].normal_force, 10 * 9.81 * 1 / 3, 1e-9);
  EXPECT_TRUE(rest.stands);
}

TEST(Rest, BlockOnAnInclineStandsSlidesOrTips) {
  // Tips at tan A = width / height, slides at tan A = mu.
  const auto fate = [](double width, double mu, double tangent) {
    World world;
    const double angle = std::atan(tangent);
    add_ground(world, rough(make_disc(1), mu), angle);
    const Vec2 at = rotate(Rot::from_angle(angle), {0, 0.5});
    add(world, at, rough(make_box({width, 1}), mu), 1, {}, 0, angle);
    return fate_of(analyse_rest(world));
  };
  EXPECT_EQ(fate(1, 0.5, 0.499), Fate::Stands);
  EXPECT_EQ(fate(1, 0.5, 0.501), Fate::Slides);
  EXPECT_EQ(fate(0.3, 0.5, 0.299), Fate::Stands);
  EXPECT_EQ(fate(0.3, 0.5, 0.301), Fate::Tips);
}

TEST(Rest, BodyInTheAirFallsAndAnEmptyWorldStands) {
  World world;
  EXPECT_TRUE(analyse_rest(world).stands);
  add(world, {0, 5}, smooth(make_disc(0.5)));
  EXPECT_EQ(fate_of(analyse_rest(world)), Fate::Falls);
}

TEST(Rest, PlankBeyondItsSupportTipsAndTheFarContactDoesNotPull) {
  World world;
  const BodyId post = world.create_body({.type = BodyType::Static});
  world.add_shape(post, rough(make_box({2, 1}), 0.5));
  add(world, {1.2, 0.6}, rough(make_box({4, 0.2}), 0.5), 3);
  const RestAnalysis rest = analyse_rest(world);
  EXPECT_EQ(fate_of(rest), Fate::Tips);
  for (const RestContact& contact : rest.contacts) EXPECT_GE(contact.normal_force, 0);
}

TEST(Rest, RopesAndHingesCarryWhatHangsOnThem) {
  World world;
  const BodyId ball = add(world, {0, -2}, smooth(make_disc(0.2)), 5);
  world.create_joint({.kind = JointKind::Rope, .b = ball, .anchor_a = {0, 0}, .anchor_b = {0, -2}});
  const BodyId lamp = add(world, {3, -1}, smooth(make_disc(0.2)), 2);
  world.create_joint({.kind = JointKind::Revolute, .b = lamp, .anchor_a = {3, 0}, .anchor_b = {3, 0}});
  const RestAnalysis rest = analyse_rest(world);
  EXPECT_TRUE(rest.stands);
  ASSERT_EQ(rest.joints.size(), 2u);
  EXPECT_NEAR(rest.joints[0].force.y, 5 * 9.81, 1e-10);
  EXPECT_NEAR(rest.joints[1].force.y, 2 * 9.81, 1e-10);
  EXPECT_TRUE(rest.joints[0].unique);
}

TEST(Rest, TableOnFourLegsIsIndeterminateAndSaysSo) {
  World world;
  add_posts(world, {-2.0, 0.0, 2.0});
  add(world, {0, 0.6}, smooth(make_box({6, 0.2})), 9);
  const RestAnalysis rest = analyse_rest(world);
  EXPECT_EQ(rest.indeterminacy, 1);
  double sum = 0;
  for (const RestContact& contact : rest.contacts) {
    EXPECT_FALSE(contact.normal_unique);
    sum += contact.normal_force;
  }
  EXPECT_NEAR(sum, 9 * 9.81, 1e-9);
  const std::vector<PairForce> pairs = pair_forces(rest);
  EXPECT_EQ(pairs.size(), 3u);
  for (const PairForce& pair : pairs) EXPECT_FALSE(pair.unique);
}

TEST(Rest, ThrustRunsThroughTheMiddleOfAColumn) {
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  for (int i = 0; i < 4; ++i) add(world, {0, i + 0.5}, rough(make_box({1, 1}), 0.5));
  const std::vector<ThrustSegment> line = thrust_line(analyse_rest(world));
  ASSERT_EQ(line.size(), 3u);  // the top box touches one other only
  for (const ThrustSegment& segment : line) {
    EXPECT_NEAR(segment.from.x, 0, 1e-9);
    EXPECT_NEAR(length(segment.to - segment.from), 1, 1e-9);
  }
}

TEST(Rest, StepAndStaticsAgreeOnACrookedTower) {
  World world;
  world.observe({.contacts = true});
  add_ground(world, rough(make_disc(1), 0.5));
  for (int i = 0; i < 8; ++i)
    add(world, {0.11 * (i * 5 % 8), i + 0.5}, rough(make_box({2.0 - 0.05 * i, 1}), 0.5), 1 + i % 3);
  for (int i = 0; i < 10; ++i) world.step(1.0 / 60);
  const RestAnalysis rest = analyse_rest(world);
  ASSERT_TRUE(rest.stands);
  std::map<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>, double> forces;
  for (const ContactReport& report : world.report().contacts_list)
    for (int k = 0; k < report.count; ++k) {
      const ContactPointReport& point = report.points[static_cast<std::size_t>(k)];
      forces[{report.shape_a.index, report.shape_b.index, point.feature}] =
          point.normal_impulse / world.report().h;
    }
  int compared = 0;
  for (const RestContact& contact : rest.contacts) {
    const auto found = forces.find({contact.shape_a.index, contact.shape_b.index, contact.feature});
    ASSERT_NE(found, forces.end());
    if (!contact.normal_unique) continue;
    EXPECT_NEAR(found->second, contact.normal_force, 1e-9 * 16 * 9.81);
    ++compared;
  }
  EXPECT_EQ(compared, 16);
}

/// A running bond wall of `courses` on rough ground; bricks 2 m x 1 m, every other course begins with a half.
void build_wall(World& world, int courses, int length, double mu) {
  add_ground(world, rough(make_disc(1), mu));
  for (int j = 0; j < courses; ++j) {
    const bool shifted = j % 2 != 0;
    for (int i = 0; i < length; ++i) add(world, {2.0 * i + shifted, j + 0.5}, rough(make_box({2, 1}), mu), 1);
  }
}

TEST(Rest, StepAndStaticsAgreeOnEveryForceOfAWallOf300BricksThatEquilibriumDoesNotDecide) {
  World world;
  world.observe({.contacts = true});
  build_wall(world, 15, 20, 0.6);
  for (int i = 0; i < 5; ++i) world.step(1.0 / 60);
  const RestAnalysis rest = analyse_rest(world, {.uniqueness = false});
  ASSERT_TRUE(rest.stands);
  EXPECT_TRUE(rest.from_last_step);
  std::map<std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>, Vec2> forces;
  const double h = world.report().h;
  for (const ContactReport& report : world.report().contacts_list)
    for (int k = 0; k < report.count; ++k) {
      const ContactPointReport& point = report.points[static_cast<std::size_t>(k)];
      forces[{report.shape_a.index, report.shape_b.index, point.feature}] = {point.normal_impulse / h,
                                                                             point.friction_impulse / h};
    }
  ASSERT_GT(rest.contacts.size(), 1000u);
  for (const RestContact& contact : rest.contacts) {
    const Vec2 step = forces[{contact.shape_a.index, contact.shape_b.index, contact.feature}];
    EXPECT_NEAR(step.x, contact.normal_force, 1e-9 * 300 * 9.81);
    EXPECT_NEAR(step.y, contact.friction_force, 1e-9 * 300 * 9.81);
  }
  // The ground carries all of it, whichever way.
  double sum = 0;
  for (const PairForce& pair : pair_forces(rest)) {
    const RestContact& contact = rest.contacts[static_cast<std::size_t>(pair.first)];
    if (world.bodies().type[contact.body_a.index] == BodyType::Static) sum += pair.force.y;
  }
  EXPECT_NEAR(sum, 300 * 9.81, 1e-8);
}

TEST(Rest, AWallThatCarriesNothingHoldsNoShareOfItsFriction) {
  // Two boxes, one on the other, touch a wall that they do not need.
  for (const double width : {0.7, 0.77, 0.83, 0.9, 1.0}) {
    World world;
    add_ground(world, rough(make_disc(1), 0.5));
    const BodyId wall = world.create_body({.type = BodyType::Static, .position = {0, 5}});
    world.add_shape(wall, rough(make_box({1, 10}), 0.5));
    add(world, {0.5 + width / 2, 0.35}, rough(make_box({width, 0.7}), 0.5));
    add(world, {0.5 + width / 4, 1}, rough(make_box({width / 2, 0.6}), 0.5));
    const RestAnalysis rest = analyse_rest(world);
    ASSERT_TRUE(rest.stands);
    int idle = 0;
    for (const PairForce& pair : pair_forces(rest)) {
      if (rest.contacts[static_cast<std::size_t>(pair.first)].body_a != wall) {
        EXPECT_GT(pair.normal, 1);
        continue;
      }
      EXPECT_LT(pair.normal, 1e-6);
      EXPECT_EQ(pair.grip, 0);
      EXPECT_EQ(pair.eccentricity, 0);
      ++idle;
    }
    EXPECT_EQ(idle, 2);
  }
}

TEST(Rest, WhatIsMarkedUniqueIsTheSameFromTheLastStepAndFromNothing) {
  // A box on two rough corners: each corner's friction is open, the resultant is not.
  World world;
  world.observe({.contacts = true});
  const double angle = 0.3;
  add_ground(world, rough(make_disc(1), 0.5), angle);
  add(world, rotate(Rot::from_angle(angle), {0, 0.5}), rough(make_box({1, 1}), 0.5), 3, {}, 0, angle);
  for (int i = 0; i < 3; ++i) world.step(1.0 / 60);
  const RestAnalysis rest = analyse_rest(world), cold = analyse_rest(world, {.last_step = false});
  EXPECT_EQ(rest.indeterminacy, 1);
  EXPECT_TRUE(rest.contacts[0].normal_unique);
  EXPECT_FALSE(rest.contacts[0].friction_unique);
  for (const RestAnalysis* one : {&rest, &cold}) {
    const std::vector<PairForce> pairs = pair_forces(*one);
    ASSERT_EQ(pairs.size(), 1u);
    EXPECT_TRUE(pairs[0].unique);
    EXPECT_NEAR(pairs[0].normal, 3 * 9.81 * std::cos(angle), 1e-9);
    EXPECT_NEAR(std::abs(pairs[0].friction), 3 * 9.81 * std::sin(angle), 1e-9);
  }
}

TEST(Rest, StaticFrictionHoldsWhatSlidingFrictionWouldNot) {
  const double angle = std::atan(0.4);
  World world;
  add_ground(world, gripping(make_disc(1), 0.3, 0.5), angle);
  add(world, rotate(Rot::from_angle(angle), {0, 0.5}), gripping(make_box({1, 1}), 0.3, 0.5), 1, {}, 0, angle);
  EXPECT_EQ(fate_of(analyse_rest(world)), Fate::Stands);
}

TEST(Rest, WhatSlidesIsHeldByTheFrictionOfSliding) {
  // Static friction 0.6 lets go on a slope of 0.7; then 0.3 acts, in statics as in the step.
  const double angle = std::atan(0.7);
  World world;
  add_ground(world, gripping(make_disc(1), 0.3, 0.6), angle);
  const BodyId body = add(world, rotate(Rot::from_angle(angle), {0, 0.1}),
                          gripping(make_box({1, 0.2}), 0.3, 0.6), 1, {}, 0, angle);
  RestSolver solver(world);
  const RestAnalysis rest = solver.analysis();
  EXPECT_EQ(fate_of(rest), Fate::Slides);
  const double expected = 9.81 * (std::sin(angle) - 0.3 * std::cos(angle));
  EXPECT_NEAR(rest.largest_acceleration, expected, 1e-9);
  EXPECT_NEAR(pair_forces(rest)[0].grip, 1, 1e-9);
  // Pushed up the slope it is held by static friction again.
  EXPECT_TRUE(solver.solve({{3 * std::cos(angle), -9.81 + 3 * std::sin(angle), 0}}).stands);
  EXPECT_NEAR(solver.solve(rest.load).largest_acceleration, expected, 1e-9);
  for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
  EXPECT_NEAR(length(world.velocity(body)), expected, 1e-6);
}

TEST(Rest, LoadsThatBalanceLeaveRoundingAndNoFall) {
  // Weight and spring differ by rounding: that share of what they cancel is rest.
  for (const double stiffness : {10.0, 70.0, 100.0, 1e3, 7e3, 1e6}) {
    World world;
    hang_on_a_spring(world, 1, stiffness);
    RestSolver solver(world);
    EXPECT_EQ(fate_of(solver.analysis()), Fate::Stands) << stiffness;
    const BodyLoads same = solver.analysis().load;
    EXPECT_TRUE(solver.solve(same).stands) << stiffness;
  }
}

TEST(Rest, BodyThatBeginsToMoveIsSeenBesideOneThatIsPressedHard) {
  // A light bead under a strong spring on a shelf; a block on a slope that is a little too steep for it.
  for (const double bead : {1.0, 1e-3, 1e-6, 1e-9}) {
    World world;
    const double angle = std::atan(0.3) + 0.01;
    add_ground(world, rough(make_disc(1), 0.3), angle);
    add(world, rotate(Rot::from_angle(angle), {0, 0.5}), rough(make_box({1, 1}), 0.3), 1, {}, 0, angle);
    const BodyId shelf = world.create_body({.type = BodyType::Static, .position = {0, 20}});
    world.add_shape(shelf, smooth(make_box({4, 1})));
    const BodyId ball = add(world, {0, 20.6}, smooth(make_box({0.2, 0.2})), bead);
    world.create_joint({.kind = JointKind::Spring,
                        .b = ball,
                        .anchor_a = {0, 30},
                        .anchor_b = {0, 20.6},
                        .length = 10.4,
                        .stiffness = 1000});
    const RestAnalysis rest = analyse_rest(world);
    EXPECT_EQ(fate_of(rest), Fate::Slides) << bead;
    const double expected = 9.81 * (std::sin(angle) - 0.3 * std::cos(angle));
    EXPECT_NEAR(rest.acceleration[0][0], -expected * std::cos(angle), 1e-6) << bead;
    EXPECT_LE(rest.size(1, rest.acceleration[1]), rest.rounding[1]) << bead;
  }
}

TEST(Rest, AFieldActsOnWhatRestsInIt) {
  World world(skerry::test::weightless());
  add_ground(world, rough(make_disc(1), 0.5));
  add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5), 2);
  world.set_force_field([](const FieldSample& s) {
    return Wrench{{3 - s.velocity.x, -9.81 * s.mass}, 0.25};
  });
  const RestAnalysis rest = analyse_rest(world);
  EXPECT_TRUE(rest.stands);
  const std::vector<PairForce> pairs = pair_forces(rest);
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_NEAR(pairs[0].normal, 2 * 9.81, 1e-9);
  EXPECT_NEAR(pairs[0].friction, 3, 1e-9);
  EXPECT_NEAR(pairs[0].at.x, (3 * 0.5 - 0.25) / (2 * 9.81), 1e-9);
  world.set_force_field([](const FieldSample&) { return Wrench{{NAN, 0}, 0}; });
  EXPECT_THROW(analyse_rest(world), std::invalid_argument);
}

TEST(RestSolver, AColumnIsFactorisedOnceForAThousandLoads) {
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  const int count = 40;
  for (int i = 0; i < count; ++i) add(world, {0, i + 0.5}, rough(make_box({1, 1}), 0.5), 2);
  RestSolver solver(world);
  BodyLoads load = solver.analysis().load;
  for (int k = 0; k < 1000; ++k) {
    load[static_cast<std::size_t>(k * 7 % count)][1] -= 0.5;
    const RestAnalysis& rest = solver.solve(load);
    ASSERT_TRUE(rest.stands);
    if (k % 50 != 0) continue;
    double above = 0;
    const std::vector<PairForce> pairs = pair_forces(rest);
    for (std::size_t i = count; i-- > 0;) {
      above -= load[i][1];
      EXPECT_NEAR(pairs[i].normal, above, 1e-11 * 2 * 9.81 * count);
    }
  }
  EXPECT_EQ(solver.work().factorisations, 1);
  EXPECT_EQ(solver.work().symbolic_analyses, 1);
  // A solve and a correction each, or little more.
  EXPECT_LE(solver.work().resolves, 4 * 1001);
}

TEST(RestSolver, NewLoadsOnAWallAreSolvedWithTheKeptFactor) {
  World world;
  const int courses = 6, length = 8;
  build_wall(world, courses, length, 0.7);
  RestSolver solver(world, {.uniqueness = false});
  ASSERT_TRUE(solver.analysis().stands);
  const BodyLoads dead = solver.analysis().load;
  // Which of the 180 points carry took a few factors to find; the one of the answer is made at the first
  // load.
  solver.solve(dead);
  const int factors = solver.work().factorisations;
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  const int loads = 500, before = solver.work().resolves;
  for (int k = 0; k < loads; ++k) {
    BodyLoads load = dead;
    for (auto& one : load)
      one = {0.02 * (unit(random) - 0.5), one[1] - 0.5 * unit(random), 0.01 * unit(random)};
    const RestAnalysis& rest = solver.solve(load);
    ASSERT_TRUE(rest.stands) << k;
    // In balance, and no contact pulls or slides.
    EXPECT_LT(rest.largest_acceleration, 1e-9);
    double vertical = 0, applied = 0;
    for (const RestContact& contact : rest.contacts) {
      EXPECT_GE(contact.normal_force, 0);
      EXPECT_LE(std::abs(contact.friction_force), contact.mu * contact.normal_force * (1 + 1e-12));
      if (world.bodies().type[contact.body_a.index] == BodyType::Static) vertical += contact.normal_force;
    }
    for (const auto& one : load) applied -= one[1];
    EXPECT_NEAR(vertical, applied, 1e-9 * applied);
  }
  EXPECT_LE(solver.work().factorisations - factors, 1);
  EXPECT_LE(solver.work().resolves - before, 10 * loads);
}

TEST(RestSolver, AnswersAreThoseOfAWorldWithTheseForces) {
  // Determinate: a smooth plank on two posts; the load runs out over the end until the far post lets go.
  World world;
  add_posts(world, {-1.0, 1.0});
  const BodyId plank = add(world, {0, 0.6}, smooth(make_box({6, 0.2})), 10);
  RestSolver solver(world);
  const double weight = 10 * 9.81, force = 60;
  for (const double x : {0.0, 0.7, 2.5, 2.9, -2.9, 0.3, -1.0}) {
    const RestAnalysis& rest = solver.solve({{0, -weight - force, -x * force}});
    World fresh;
    add_posts(fresh, {-1.0, 1.0});
    const BodyId same = add(fresh, {0, 0.6}, smooth(make_box({6, 0.2})), 10);
    fresh.apply_force(same, {0, -force}, {x, 0.6});
    const RestAnalysis expected = analyse_rest(fresh);
    EXPECT_EQ(fate_of(rest), fate_of(expected)) << x;
    // R = W/2 + F (1 + x) / 2 on the right, while the left one presses.
    const double right = 0.5 * weight + 0.5 * force * (1 + x), left = weight + force - right;
    EXPECT_EQ(rest.stands, right >= 0 && left >= 0) << x;
    if (rest.stands) {
      EXPECT_NEAR(rest.contacts[0].normal_force, left, 1e-9);
      EXPECT_NEAR(rest.contacts[1].normal_force, right, 1e-9);
    }
    for (std::size_t k = 0; k < 2; ++k)
      EXPECT_NEAR(rest.contacts[k].normal_force, expected.contacts[k].normal_force, 1e-9) << x;
  }
  EXPECT_EQ(plank.index, 2u);
  EXPECT_THROW(solver.solve({}), std::invalid_argument);
  EXPECT_THROW(solver.solve({{0, kInfinity, 0}}), std::invalid_argument);
}

TEST(Rest, IslandsThatAreNotSteppedKeepTheirExactForcesInTheReport) {
  World world;
  world.observe({.contacts = true});
  add_ground(world, rough(make_disc(1), 0.5));
  for (int i = 0; i < 6; ++i) add(world, {0, i + 0.5}, rough(make_box({1, 1}), 0.5), 3);
  for (int i = 0; i < 10; ++i) world.step(1.0 / 60);
  ASSERT_EQ(world.report().islands_at_rest, 1);
  ASSERT_EQ(world.report().work.factorisations, 0);
  const std::vector<PairForce> pairs = pair_forces(analyse_rest(world));
  ASSERT_EQ(world.report().contacts_list.size(), pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const ContactReport& contact = world.report().contacts_list[k];
    double force = 0;
    for (int i = 0; i < contact.count; ++i)
      force += contact.points[static_cast<std::size_t>(i)].normal_impulse / world.report().h;
    EXPECT_NEAR(force, pairs[k].normal, 1e-9 * 18 * 9.81);
  }
}

TEST(Rest, ASpringIsReportedWithItsForce) {
  World world;
  hang_on_a_spring(world, 3, 3 * 9.81);
  RestSolver solver(world);
  ASSERT_EQ(solver.analysis().joints.size(), 1u);
  EXPECT_TRUE(solver.analysis().stands);
  EXPECT_NEAR(solver.analysis().joints[0].force.y, 3 * 9.81, 1e-12);
  EXPECT_NEAR(solver.solve({{0, 5, 0}}).joints[0].force.y, 3 * 9.81, 1e-12);
}

TEST(Rest, WhatIsHeldByAllOfItsStaticFrictionStands) {
  World world;
  add_ground(world, gripping(make_disc(1), 0.3, 0.5));
  const BodyId body = add(world, {0, 0.5}, gripping(make_box({2, 1}), 0.3, 0.5), 4);
  const double most = 0.5 * 4 * 9.81;
  world.apply_force(body, {most, 0}, {0, 0});
  const RestAnalysis rest = analyse_rest(world);
  EXPECT_TRUE(rest.stands);
  EXPECT_NEAR(pair_forces(rest)[0].friction, most, 1e-9);
  EXPECT_NEAR(pair_forces(rest)[0].grip, 1, 1e-9);
}

TEST(Rest, WhatSlidesLetsGoOfWhatItHeld) {
  // The upper block is pulled off to the left; the lower one is pulled to the right, and would stay if the
  // upper one went on gripping it.
  World world;
  add_ground(world, gripping(make_disc(1), 0.1, 0.6));
  const BodyId lower = add(world, {0, 0.1}, gripping(make_box({6, 0.2}), 0.1, 0.6));
  const BodyId upper = add(world, {0, 0.3}, gripping(make_box({2, 0.2}), 0.1, 0.6));
  const double g = 9.81;
  world.apply_force(upper, {-0.8 * g, 0}, {0, 0.2});
  world.apply_force(lower, {1.5 * g, 0}, {0, 0});
  const RestAnalysis rest = analyse_rest(world);
  EXPECT_NEAR(rest.acceleration[1][0], (-0.8 + 0.1) * g, 1e-9);
  EXPECT_NEAR(rest.acceleration[0][0], (1.5 - 0.1 - 0.2) * g, 1e-9);
}

TEST(RestSolver, OnlyForcesOfTheLastStepThatBalanceAreTakenOver) {
  World world;
  world.observe({.contacts = true});
  add_ground(world, rough(make_disc(1), 0.5));
  const BodyId box = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5), 2);
  for (int i = 0; i < 3; ++i) world.step(1.0 / 60);
  RestSolver solver(world);
  EXPECT_TRUE(solver.analysis().from_last_step);
  EXPECT_FALSE(solver.solve({{0, -30, 0}}).from_last_step);
  world.apply_force(box, {0, -10}, {0, 0.5});
  EXPECT_FALSE(analyse_rest(world).from_last_step);
}

TEST(RestSolver, WhereContactsOpenUnderANewLoadTheOthersAreDecided) {
  World world;
  add_posts(world, {-2.0, 0.0, 2.0});
  add(world, {0, 0.6}, smooth(make_box({8, 0.2})), 9);
  RestSolver solver(world);
  const BodyLoads own = solver.analysis().load;
  EXPECT_EQ(solver.analysis().indeterminacy, 1);
  // So much at the right end that it turns about the last post.
  EXPECT_EQ(solver.solve({{0, -300, -900}}).indeterminacy, 0);
  for (const RestContact& contact : solver.analysis().contacts) EXPECT_TRUE(contact.normal_unique);
  EXPECT_EQ(solver.solve(own).indeterminacy, 1);
}

TEST(Rest, ASlackRopeHoldsNothing) {
  World world;
  const BodyId ball = add(world, {0, -2}, smooth(make_disc(0.2)), 5);
  world.create_joint(
      {.kind = JointKind::Rope, .b = ball, .anchor_a = {0, 0}, .anchor_b = {0, -2}, .length = 2.001});
  const RestAnalysis rest = analyse_rest(world);
  EXPECT_FALSE(rest.stands);
  EXPECT_NEAR(rest.acceleration[0][1], -9.81, 1e-12);
  ASSERT_EQ(rest.joints.size(), 1u);
  EXPECT_EQ(rest.joints[0].force, Vec2{});
}

TEST(Rest, AMotorHoldsUpToItsLimitEitherWay) {
  for (const double side : {-1.0, 1.0}) {
    World world;
    const BodyId block = add(world, {0, 0}, smooth(make_box({1, 1})));
    JointDef slider{.kind = JointKind::Prismatic, .b = block, .anchor_a = {0, 0}, .axis = {0, side}};
    slider.motor_speed = 0;
    slider.motor_limit = 5;
    world.create_joint(slider);
    const RestAnalysis rest = analyse_rest(world);
    EXPECT_NEAR(rest.acceleration[0][1], -9.81 + 5, 1e-9) << side;
    EXPECT_NEAR(rest.joints[0].force.y, 5, 1e-9) << side;
  }
}

TEST(Rest, JointsBetweenWhatIsHeldCarryNothing) {
  World world;
  add(world, {0, -2}, smooth(make_disc(0.2)), 5);
  const BodyId arm = world.create_body({.type = BodyType::Kinematic});
  world.add_shape(arm, smooth(make_disc(0.2)));
  world.create_joint({.kind = JointKind::Revolute, .b = arm, .anchor_a = {1, 0}, .anchor_b = {1, 0}});
  const RestAnalysis rest = analyse_rest(world);
  EXPECT_TRUE(rest.joints.empty());
  EXPECT_EQ(rest.system.size(), 0);
}

TEST(Rest, SensorsFiltersAndJointsKeepBodiesFromTouchingAsInTheStep) {
  ShapeDef box = rough(make_box({1, 1}), 0.5), plate = rough(make_box({4, 1}), 0.5);
  // `joined`: 1 from the plate to the box, -1 the other way round, 0 not at all.
  const auto stands = [&](int joined = 0, bool collide = false) {
    World world;
    const BodyId ground = world.create_body({.type = BodyType::Static});
    world.add_shape(ground, plate);
    const BodyId body = add(world, {0, 1}, box);
    if (joined != 0)
      world.create_joint({.kind = JointKind::Rope,
                          .a = joined > 0 ? ground : body,
                          .b = joined > 0 ? body : ground,
                          .anchor_a = {0, 0.5},
                          .anchor_b = {0, 0.5},
                          .length = 5,
                          .collide = collide});
    return analyse_rest(world).stands;
  };
  EXPECT_TRUE(stands());
  for (const int joined : {1, -1}) {
    EXPECT_FALSE(stands(joined)) << joined;
    EXPECT_TRUE(stands(joined, true)) << joined;
  }
  box.sensor = true;
  EXPECT_FALSE(stands());
  box.sensor = false;
  box.filter = {.category = 4, .mask = 4};
  plate.filter = {.category = 2, .mask = 2};
  EXPECT_FALSE(stands());
}

TEST(Rest, FrictionIsMixedByTheStrongerOfTheTwoRules) {
  for (const bool first : {true, false}) {
    World world;
    ShapeDef plate = rough(make_box({4, 1}), 0.9), box = rough(make_box({1, 1}), 0.1);
    plate.friction_rule = first ? MixingRule::Maximum : MixingRule::GeometricMean;
    box.friction_rule = first ? MixingRule::GeometricMean : MixingRule::Maximum;
    world.add_shape(world.create_body({.type = BodyType::Static}), plate);
    add(world, {0, 1}, box);
    const RestAnalysis rest = analyse_rest(world);
    EXPECT_EQ(rest.contacts.size(), 2u);
    for (const RestContact& contact : rest.contacts) EXPECT_EQ(contact.mu, 0.9) << first;
  }
}

TEST(Rest, PointsOfAChainAreToldApartByTheirPlaces) {
  // A box on two peaks, which meet one edge of it: their points have one feature.
  World world;
  world.observe({.contacts = true});
  const BodyId ground = world.create_body({.type = BodyType::Static});
  world.add_shape(ground,
                  rough(make_chain(std::vector<Vec2>{{-3, 0}, {-1, 1}, {0, 0}, {1.5, 1}, {3, 0}}), 0.5));
  add(world, {0, 1.5}, rough(make_box({4, 1}), 0.5), 2);
  for (int i = 0; i < 3; ++i) world.step(1.0 / 60);
  const RestAnalysis rest = analyse_rest(world);
  ASSERT_EQ(rest.contacts.size(), 2u);
  EXPECT_EQ(rest.contacts[0].feature, rest.contacts[1].feature);
  EXPECT_TRUE(rest.from_last_step);
  EXPECT_NEAR(rest.contacts[0].normal_force, 2 * 9.81 * 0.6, 1e-9);
}

TEST(Rest, WhatSlidesIsKnownWhicheverBodyWasMadeFirst) {
  World world;
  const double angle = std::atan(0.6);
  add(world, rotate(Rot::from_angle(angle), {0, 0.5}), rough(make_box({2, 1}), 0.5), 1, {}, 0, angle);
  add_ground(world, rough(make_disc(1), 0.5), angle);
  EXPECT_EQ(fate_of(analyse_rest(world)), Fate::Slides);
}

TEST(Rest, OneThatTipsBesideOneThatSlidesIsACollapse) {
  World world;
  const double angle = std::atan(0.4);
  const Rot q = Rot::from_angle(angle);
  add_ground(world, rough(make_disc(1), 1), angle);
  add(world, rotate(q, {0, 0.5}), rough(make_box({0.3, 1}), 1), 1, {}, 0, angle);
  EXPECT_EQ(fate_of(analyse_rest(world)), Fate::Tips);
  add(world, rotate(q, {5, 0.5}), smooth(make_box({3, 1})), 1, {}, 0, angle);
  EXPECT_EQ(fate_of(analyse_rest(world)), Fate::Collapses);
}

TEST(Rest, ThrustRunsThroughWhatTwoPairsLoad) {
  // A column beside a wall that it does not lean on.
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  for (int i = 0; i < 3; ++i) add(world, {0, i + 0.5}, rough(make_box({1, 1}), 0.5));
  const BodyId wall = world.create_body({.type = BodyType::Static, .position = {1, 1.5}});
  world.add_shape(wall, smooth(make_box({1, 0.5})));
  EXPECT_EQ(thrust_line(analyse_rest(world)).size(), 2u);
  // A plank on two posts with a box on it: three load it, and there is no one line.
  World table;
  add_posts(table, {-2.0, 2.0});
  add(table, {0, 0.6}, smooth(make_box({6, 0.2})), 9);
  add(table, {0, 1.2}, smooth(make_box({1, 1})), 2);
  EXPECT_TRUE(thrust_line(analyse_rest(table)).empty());
}

/// Two bars on two hinges that lean against each other: with a third hinge between them, or welded.
TEST(Rest, AnArchOfTwoBarsIsIndeterminateOnceWithoutItsThirdHinge) {
  for (const bool welded : {false, true}) {
    for (const bool others : {false, true}) {
      World world;
      // Whether the bars are the first bodies must not matter.
      if (others) {
        const BodyId lamp = world.create_body({.position = {7, 0}, .mass = 1.0, .inertia = 1.0});
        world.create_joint({.kind = JointKind::Weld, .b = lamp, .anchor_a = {7, 0}, .anchor_b = {7, 0}});
      }
      const BodyId left = world.create_body({.position = {-0.5, 0.5}, .mass = 2.0, .inertia = 0.1}),
                   right = world.create_body({.position = {0.5, 0.5}, .mass = 2.0, .inertia = 0.1});
      world.create_joint({.kind = JointKind::Revolute, .b = left, .anchor_a = {-1, 0}, .anchor_b = {-1, 0}});
      world.create_joint({.kind = JointKind::Revolute, .b = right, .anchor_a = {1, 0}, .anchor_b = {1, 0}});
      world.create_joint({.kind = welded ? JointKind::Weld : JointKind::Revolute,
                          .a = left,
                          .b = right,
                          .anchor_a = {0, 1},
                          .anchor_b = {0, 1}});
      const RestAnalysis rest = analyse_rest(world);
      EXPECT_TRUE(rest.stands);
      EXPECT_EQ(rest.indeterminacy, welded ? 1 : 0) << others;
      ASSERT_EQ(rest.joints.size(), others ? 4u : 3u);
      for (std::size_t i = others ? 1 : 0; i < rest.joints.size(); ++i)
        EXPECT_EQ(rest.joints[i].unique, !welded) << i << ", " << others;
    }
  }
}

}  // namespace rest_test
}  // namespace skerry::statics::test
