// SPDX-License-Identifier: MIT
//
// Bodies of several shapes: mass, contacts, events, and the pieces of concave polygons.
#include <gtest/gtest.h>
#include <numeric>

#include "tests/support/worlds.h"

namespace skerry {
namespace compound_test {

using test::add_ground;
using test::rough;
using test::smooth;

/// A body of these shapes; densities of 1 kg/m^2.
BodyId add_compound(World& world, Vec2 position, const std::vector<ShapeDef>& shapes, double angle = 0) {
  const BodyId body = world.create_body({.position = position, .angle = angle});
  for (ShapeDef def : shapes) {
    def.density = 1;
    world.add_shape(body, def);
  }
  return body;
}

TEST(Compound, MassCentroidAndInertiaAreThoseOfThePartsByTheParallelAxisTheorem) {
  World world;
  // A dumb-bell that is heavier on the left, with a capsule as its bar.
  const std::vector<ShapeDef> parts{smooth(make_disc(0.5, {-1, 0})), smooth(make_disc(0.25, {2, 0.5})),
                                    smooth(make_capsule({-1, 0}, {2, 0.5}, 0.1))};
  const BodyId body = add_compound(world, {3, 4}, parts, 0.7);
  double mass = 0, inertia = 0;
  Vec2 centre;
  for (const ShapeDef& part : parts) {
    const AreaProperties p = area_properties(part.shape);
    mass += p.area;
    centre += p.area * p.centroid;
  }
  centre = centre / mass;
  for (const ShapeDef& part : parts) {
    const AreaProperties p = area_properties(part.shape);
    inertia += p.second_moment + p.area * length_squared(p.centroid - centre);
  }
  EXPECT_NEAR(world.mass(body), mass, 1e-14 * mass);
  EXPECT_NEAR(world.inertia(body), inertia, 1e-14 * inertia);
  const Vec2 expected = Vec2{3, 4} + rotate(Rot::from_angle(0.7), centre);
  EXPECT_NEAR(length(world.position(body) - expected), 0, 1e-14);
  // In flight the parts turn about that point, which falls like any other.
  world.set_velocity(body, {1, 2}, 3);
  for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
  EXPECT_NEAR(world.position(body).x, expected.x + 1, 1e-13);
  EXPECT_NEAR(world.position(body).y, expected.y + 2 - 0.5 * 9.81, 1e-12);
  EXPECT_NEAR(world.angle(body), 0.7 + 3, 1e-13);
}

TEST(Compound, OfTheConvexPartsOfAConcaveOutlineHasItsMassCentroidAndInertia) {
  // An L by its closed form: two rectangles.
  const std::vector<Vec2> outline{{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 2}, {0, 2}};
  std::vector<ShapeDef> parts;
  for (const auto& part : convex_parts(outline)) parts.push_back(smooth(make_polygon(part)));
  ASSERT_GE(parts.size(), 2u);
  World world;
  const BodyId body = add_compound(world, {}, parts);
  const double m1 = 3, m2 = 1;  // 3 x 1 below, 1 x 1 above
  const Vec2 c1{1.5, 0.5}, c2{0.5, 1.5}, centre = (m1 * c1 + m2 * c2) / (m1 + m2);
  const double inertia = m1 * (9 + 1) / 12 + m1 * length_squared(c1 - centre) + m2 * (1 + 1) / 12 +
                         m2 * length_squared(c2 - centre);
  EXPECT_NEAR(world.mass(body), 4, 1e-14);
  EXPECT_NEAR(world.inertia(body), inertia, 1e-13);
  EXPECT_NEAR(length(world.position(body) - centre), 0, 1e-15);
}

TEST(Compound, ItsOwnPartsNeverTouchEachOther) {
  World world(test::weightless());
  world.observe({.contacts = true});
  // Parts that overlap deeply; a body of two such crosses beside it.
  const std::vector<ShapeDef> cross{smooth(make_box({3, 1})), smooth(make_box({1, 3}))};
  const BodyId body = add_compound(world, {}, cross);
  world.set_velocity(body, {0.1, 0}, 1);
  for (int i = 0; i < 30; ++i) {
    const StepReport& report = world.step(1.0 / 60);
    ASSERT_EQ(report.contact_points, 0);
    ASSERT_TRUE(report.contacts_list.empty());
    ASSERT_TRUE(report.events.empty());
  }
  EXPECT_NEAR(world.omega(body), 1, 1e-15);
}

TEST(Compound, TableOnTwoLegsSharesItsWeightBetweenItsFeet) {
  World world;
  world.observe({.contacts = true});
  add_ground(world, rough(make_disc(1), 0.5));
  // Top 4 x 0.2 m, legs at x = -1.5 and 1, 1 m high: mass 0.8 + 2 * 0.2.
  const BodyId table =
      add_compound(world, {},
                   {rough(make_box({4, 0.2}, {0, 1.1}), 0.5), rough(make_box({0.2, 1}, {-1.5, 0.5}), 0.5),
                    rough(make_box({0.2, 1}, {1, 0.5}), 0.5)});
  const double h = 1.0 / 60, weight = world.mass(table) * 9.81;
  for (int i = 0; i < 120; ++i) world.step(h);
  EXPECT_EQ(world.velocity(table), (Vec2{0, 0}));
  // Both feet carry; their forces and their moment about the centre of mass balance the weight.
  double force = 0, moment = 0;
  std::vector<ShapeId> feet;
  for (const ContactReport& contact : world.report().contacts_list) {
    const double sign = contact.body_b == table ? 1 : -1;
    for (int i = 0; i < contact.count; ++i) {
      const auto& point = contact.points[static_cast<std::size_t>(i)];
      force += sign * contact.normal.y * point.normal_impulse / h;
      moment +=
          sign * contact.normal.y * point.normal_impulse / h * (point.position.x - world.position(table).x);
    }
    feet.push_back(contact.body_b == table ? contact.shape_b : contact.shape_a);
  }
  ASSERT_EQ(feet.size(), 2u);
  EXPECT_NE(feet[0], feet[1]);
  EXPECT_NEAR(force, weight, 1e-10 * weight);
  EXPECT_NEAR(moment, 0, 1e-10 * weight);
}

TEST(Compound, WheelOfTwoDiscsRollsLikeOneBodyWithTheirInertia) {
  // Two equal discs of radius 0.5 at one place: a disc of twice the mass. Rolling down an incline without
  // slip: a = g sin / (1 + I / (m r^2)) = 2/3 g sin.
  const double tilt = 0.2;
  World world;
  add_ground(world, rough(make_disc(1), 0.9), tilt);
  const Rot q = Rot::from_angle(tilt);
  const BodyId wheel =
      add_compound(world, rotate(q, {0, 0.5}), {rough(make_disc(0.5), 0.9), rough(make_disc(0.5), 0.9)});
  for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
  const double a = 2.0 / 3 * 9.81 * std::sin(tilt);
  EXPECT_NEAR(length(world.velocity(wheel)), a, 1e-9);
  EXPECT_NEAR(std::abs(world.omega(wheel)), a / 0.5, 1e-9);
}

TEST(Compound, EachPartReportsItsOwnEventsWithItsOwnFilterAndMaterial) {
  World world(test::weightless());
  const BodyId wall = world.create_body({.type = BodyType::Static});
  world.add_shape(wall, smooth(make_box({1, 10})));
  // In front a part that the wall does not see, behind it one that bounces.
  ShapeDef ghost = smooth(make_disc(0.5, {-1, 0})), ball = smooth(make_disc(0.5), 1);
  ghost.filter.mask = 0;
  ghost.density = ball.density = 1;
  const BodyId body = world.create_body({.position = {3, 0}});
  const ShapeId front = world.add_shape(body, ghost), back = world.add_shape(body, ball);
  world.set_velocity(body, {-2, 0}, 0);
  int hits = 0;
  for (int i = 0; i < 120; ++i) {
    for (const ContactEvent& event : world.step(1.0 / 60).events) {
      EXPECT_TRUE(event.shape_a != front && event.shape_b != front);
      if (event.kind != ContactEventKind::Hit) continue;
      ++hits;
      EXPECT_TRUE(event.shape_a == back || event.shape_b == back);
      EXPECT_NEAR(event.approach_speed, 2, 1e-12);
    }
  }
  EXPECT_EQ(hits, 1);
  EXPECT_NEAR(world.velocity(body).x, 2, 1e-12);
}

}  // namespace compound_test
}  // namespace skerry
