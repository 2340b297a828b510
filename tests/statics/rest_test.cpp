// SPDX-License-Identifier: MIT
//
// Worlds at rest: forces by formula, what falls, and agreement with the step.
#include "physics/statics/rest.h"

#include <cmath>
#include <gtest/gtest.h>
#include <map>

#include "tests/support/worlds.h"

namespace skerry::statics::test {
namespace {

using skerry::test::add;
using skerry::test::add_ground;
using skerry::test::rough;
using skerry::test::smooth;

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
  for (const double x : {-1.0, 2.0}) {
    const BodyId post = world.create_body({.type = BodyType::Static, .position = {x, 0}});
    world.add_shape(post, smooth(make_disc(0.5)));
  }
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
  for (const double x : {-2.0, 0.0, 2.0}) {
    const BodyId post = world.create_body({.type = BodyType::Static, .position = {x, 0}});
    world.add_shape(post, smooth(make_disc(0.5)));
  }
  add(world, {0, 0.6}, smooth(make_box({6, 0.2})), 9);
  const RestAnalysis rest = analyse_rest(world);
  EXPECT_EQ(rest.indeterminacy, 1);
  double sum = 0;
  for (const RestContact& contact : rest.contacts) {
    EXPECT_FALSE(contact.normal_unique);
    sum += contact.normal_force;
  }
  EXPECT_NEAR(sum, 9 * 9.81, 1e-9);
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

}  // namespace
}  // namespace skerry::statics::test
