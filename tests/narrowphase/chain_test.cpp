// SPDX-License-Identifier: MIT
#include "physics/narrowphase/chain.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "physics/narrowphase/collide.h"
#include "physics/narrowphase/queries.h"
#include "physics/narrowphase/time_of_impact.h"
#include "tests/narrowphase/oracle.h"

namespace skerry {
namespace chain_test {

using oracle::Scenes;

std::vector<Manifold> contacts(const Shape& chain, const Shape& other, const Transform& pose, double margin) {
  std::vector<Manifold> out;
  std::vector<int> near;
  chain_segments_near(chain, {}, grown(bounding_box(other, pose), margin), near);
  for (const int i : near) {
    const Manifold m = collide_chain_segment(chain, i, {}, other, pose, margin);
    if (m.count > 0) out.push_back(m);
  }
  return out;
}

TEST(Chain, ABoxThatSlidesOverAThousandFlatSegmentsFeelsTheFlatNormalOnly) {
  for (const double slope : {0.0, 0.3}) {
    const Rot turn = Rot::from_angle(slope);
    std::vector<Vec2> corners;
    for (int i = 0; i <= 1000; ++i) corners.push_back(rotate(turn, {0.37 * i, 0}));
    const Shape chain = make_chain(corners);
    const Vec2 up = rotate(turn, {0, 1});
    for (const Shape& shape : {make_box({1, 1}), make_disc(0.5), make_capsule({-0.5, 0}, {0.5, 0}, 0.5)}) {
      for (int k = 0; k < 5147; ++k) {
        const double x = 1 + 0.0713 * k;
        for (const double depth : {1e-3, 1e-9, -1e-4}) {
          const Transform pose{rotate(turn, {x, 0.5 - depth}), turn};
          const auto list = contacts(chain, shape, pose, 0.005);
          ASSERT_FALSE(list.empty()) << x;
          int points = 0;
          double left = kInfinity, right = -kInfinity;
          for (const Manifold& m : list) {
            ASSERT_NEAR(length(m.normal - up), 0, 1e-9) << x << " " << depth;
            for (int i = 0; i < m.count; ++i) {
              const auto& point = m.points[static_cast<std::size_t>(i)];
              ASSERT_NEAR(point.separation, -depth, 1e-12);
              const double along = dot(rotate(turn, {1, 0}), point.position);
              left = std::min(left, along);
              right = std::max(right, along);
              ++points;
            }
          }
          // The extremes of the contact are there, and inner corners are not.
          const double half = shape.kind == ShapeKind::Disc ? 0 : 0.5;
          ASSERT_NEAR(left, x - half, 1e-9) << x;
          ASSERT_NEAR(right, x + half, 1e-9) << x;
          // A corner of the box right above a corner of the chain is reported by both its segments.
          ASSERT_LE(points, half > 0 ? 4 : 2);
        }
      }
    }
  }
}

TEST(Chain, SlidingOverAFlatChainIsNoImpact) {
  std::vector<Vec2> corners;
  for (int i = 0; i <= 1000; ++i) corners.push_back({0.1 * i, 0});
  const Shape chain = make_chain(corners);
  for (const Shape& shape : {make_box({1, 1}), make_disc(0.5)}) {
    EXPECT_FALSE(time_of_impact(chain, {}, shape, {.p0 = {1, 0.5}, .v = {100, 0}}, 0.9).hit);
    const ImpactTime lands = time_of_impact(chain, {}, shape, {.p0 = {1, 1.5}, .v = {30, -4}}, 1);
    ASSERT_TRUE(lands.hit);
    EXPECT_NEAR(lands.t, 0.25, 1e-12);
    EXPECT_FALSE(time_of_impact(chain, {}, shape, {.p0 = {50, -5}, .v = {0, 10}}, 2).hit) << "from below";
  }
}

TEST(Chain, AnswersARidgeOnceWithANormalBetweenItsSides) {
  const Shape ridge = make_chain(std::vector<Vec2>{{-2, -1}, {0, 0}, {2, -1}});
  for (int k = -20; k <= 20; ++k) {
    const double x = 0.01 * k;
    const double reach = 0.499;
    const auto disc = contacts(ridge, make_disc(0.5), {{x, std::sqrt(reach * reach - x * x)}, {}}, 0.0);
    ASSERT_EQ(disc.size(), 1u) << x;
    EXPECT_NEAR(disc[0].normal.x, x / reach, 1e-12);
    EXPECT_NEAR(disc[0].points[0].separation, -1e-3, 1e-12);
    const auto box = contacts(ridge, make_box({1, 1}), {{x, 0.5 - 1e-3}, {}}, 0.0);
    ASSERT_EQ(box.size(), 1u) << x;
    EXPECT_NEAR(box[0].normal.y, 1, 1e-12);
    EXPECT_NEAR(box[0].points[0].separation, -1e-3, 1e-12);
    EXPECT_NEAR(box[0].points[0].position.x, 0, 1e-12);
  }
}

TEST(Chain, ADiscInAValleyTouchesBothSides) {
  const Shape valley = make_chain(std::vector<Vec2>{{-2, 2}, {0, 0}, {2, 2}});
  const double rest = 0.5 * std::sqrt(2.0);
  const auto list = contacts(valley, make_disc(0.5), {{0, rest - 1e-6}, {}}, 0.0);
  ASSERT_EQ(list.size(), 2u);
  EXPECT_NEAR(list[0].normal.x, std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(list[1].normal.x, -std::sqrt(0.5), 1e-12);
}

TEST(Chain, ACornerThatSlidesIntoAValleyMeetsTheOtherSide) {
  Scenes scenes(23);
  const Shape box = make_box({1, 0.4});
  for (int i = 0; i < 200; ++i) {
    const double down = scenes.uniform(0, 0.7), up = scenes.uniform(down > 0.1 ? 0 : 0.1, 0.7);
    const double speed = scenes.uniform(0.1, 3), faster = scenes.uniform(0, 9),
                 time = scenes.uniform(1e-6, 0.1);
    const double way = time * (speed + 0.5 * faster * time);
    for (const double side : {1.0, -1.0}) {
      std::vector<Vec2> corners{
          {-3 * std::cos(down), 3 * std::sin(down)}, {0, 0}, {std::cos(up), std::sin(up)}};
      if (side < 0) {
        for (Vec2& corner : corners) corner.x = -corner.x;
        std::reverse(corners.begin(), corners.end());
      }
      const Vec2 there{scenes.uniform(-9, 9), scenes.uniform(-9, 9)};
      for (Vec2& corner : corners) corner += there;
      const Shape valley = make_chain(corners);
      const int other = side > 0 ? 1 : 0;
      // The box lies on one side, its lower corner `way` from the bottom.
      const double angle = -side * down;
      const Vec2 start = there + rotate(Rot::from_angle(angle), {-side * (way + 0.5), 0.2});
      const Vec2 along = rotate(Rot::from_angle(angle), {side, 0});
      const ImpactTime impact = time_of_impact_chain_segment(
          valley, other, {}, box, {.p0 = start, .angle0 = angle, .v = speed * along, .a = faster * along},
          2 * time);
      ASSERT_TRUE(impact.hit) << down << " " << up << " " << way;
      ASSERT_NEAR(impact.t, time, 1e-12 / speed);
      const Transform pose{start + impact.t * (speed + 0.5 * faster * impact.t) * along,
                           Rot::from_angle(angle)};
      const Manifold m = collide_chain_segment(valley, other, {}, box, pose, 1e-9);
      ASSERT_GE(m.count, 1) << down << " " << up << " " << way;
      ASSERT_NEAR(m.points[0].separation, 0, 1e-12);
      // It is foreseen, with the normal of the face that it comes to.
      const double near = std::min(way, 1e-3);
      const Transform before{pose.p - near * along, Rot::from_angle(angle)};
      const Manifold early = collide_chain_segment(valley, other, {}, box, before, 2 * near);
      ASSERT_GE(early.count, 1);
      ASSERT_NEAR(dot(early.normal, valley.normals[static_cast<std::size_t>(other)]), 1, 1e-12);
      ASSERT_GE(early.points[0].separation, near * std::sin(down + up) - 1e-12);
    }
  }
}

/// What has sunk into both sides of a valley was reported by one of them only, and slid down into the other.
TEST(Chain, ACornerThatHasSunkIntoTheBottomOfAValleyIsHeldByBothSides) {
  Scenes scenes(27);
  for (int i = 0; i < 4000; ++i) {
    const double left = scenes.uniform(0.1, 1.5), right = scenes.uniform(0.1, 1.5);
    const Shape valley =
        make_chain(std::vector<Vec2>{{-5, 9}, {-3, 3 * left}, {0, 0}, {3, 3 * right}, {5, 9}});
    const double wide = scenes.uniform(0.1, 0.5);
    const Shape wedge =
        make_polygon(std::vector<Vec2>{{0, 0}, {wide, 0.8}, {-scenes.uniform(0.1, 0.5), 0.8}});
    // Its right edge lies along the right side, or leans away from it.
    const double lean = i % 2 == 0 ? 1e-3 : 0.2;
    const double angle = std::atan(right) - std::atan2(0.8, wide) + scenes.uniform(0, lean);
    const double depth = std::pow(10, scenes.uniform(-13, -3));
    const Vec2 away{scenes.uniform(-1, 1), scenes.uniform(-1, 0)};
    const Vec2 sides[] = {valley.normals[1], valley.normals[2]};
    if (dot(sides[0], away) > 0 || dot(sides[1], away) > 0) continue;
    for (const int side : {0, 1}) {
      const Manifold m =
          collide_chain_segment(valley, 1 + side, {}, wedge, {depth * away, Rot::from_angle(angle)}, 0.005);
      ASSERT_GE(m.count, 1) << "wedge " << i << ", depth " << depth << ", side " << side;
      ASSERT_NEAR(dot(m.normal, sides[side]), 1, 1e-12) << i;
      double nearest = kInfinity;
      for (int k = 0; k < m.count; ++k) nearest = std::min(nearest, m.points[k].separation);
      ASSERT_LE(std::abs(nearest), 4 * depth) << i;
    }
  }
}

TEST(Chain, AFlatStretchAnswersAsAHalfPlane) {
  Scenes scenes(29);
  const Shape plane = make_half_plane({0, 0}, {0, 1});
  for (int i = 0; i < 2000; ++i) {
    const double scale = std::pow(10, scenes.uniform(-3, 2));
    std::vector<Vec2> corners{{-9 * scale, 0}};
    while (corners.back().x < 9 * scale)
      corners.push_back(corners.back() + Vec2{scenes.uniform(0.1, 3) * scale, 0});
    const Shape chain = make_chain(corners);
    const Shape box = make_box({scenes.uniform(0.5, 2) * scale, scenes.uniform(0.5, 2) * scale});
    const double tilt = std::pow(10, scenes.uniform(-13, -0.5)),
                 gap = scale * std::pow(10, scenes.uniform(-13, -2));
    Transform pose{{scenes.uniform(-5, 5) * scale, scenes.uniform(0, 9)},
                   Rot::from_angle(i % 2 == 0 ? tilt : -tilt)};
    pose.p.y += gap - bounding_box(box, pose).lower.y;
    const double margin = 0.1 * scale, rounding = 1e-12 * scale;
    const Manifold whole = collide(plane, {}, box, pose, margin);
    std::vector<double> gaps;
    for (const Manifold& m : contacts(chain, box, pose, margin)) {
      ASSERT_NEAR(m.normal.y, 1, 1e-15);
      for (int k = 0; k < m.count; ++k) gaps.push_back(m.points[k].separation);
    }
    ASSERT_EQ(static_cast<int>(gaps.size()), whole.count) << i;
    std::sort(gaps.begin(), gaps.end());
    const double low = whole.points[0].separation, high = whole.points[whole.count - 1].separation;
    ASSERT_NEAR(gaps.front(), std::min(low, high), rounding) << i;
    ASSERT_NEAR(gaps.back(), std::max(low, high), rounding) << i;
  }
}

TEST(Chain, DoesNotPushFromItsSolidSideAndLetsRollOffItsEnds) {
  const Shape chain = make_chain(std::vector<Vec2>{{0, 0}, {1, 0}});
  EXPECT_TRUE(contacts(chain, make_disc(0.5), {{0.5, -0.3}, {}}, 0.0).empty());
  EXPECT_TRUE(contacts(chain, make_box({1, 1}), {{0.5, -0.3}, {}}, 0.0).empty());
  const auto end = contacts(chain, make_disc(0.5), {{1.3, 0.39}, {}}, 0.0);
  ASSERT_EQ(end.size(), 1u);
  EXPECT_NEAR(end[0].normal.x, 0.3 / std::hypot(0.3, 0.39), 1e-12);
  EXPECT_THROW(collide_chain_segment(chain, 1, {}, make_disc(1), {}, 0), std::invalid_argument);
  EXPECT_THROW(collide(chain, {}, make_disc(1), {}, 0), std::invalid_argument);
}

TEST(Chain, ADiscThatFollowsRandomTerrainIsNeverWithoutContactAndNeverSeesSteepNormals) {
  Scenes scenes(17);
  std::vector<Vec2> corners;
  for (int i = 0; i <= 200; ++i) corners.push_back({0.5 * i, scenes.uniform(-0.1, 0.1)});
  const Shape chain = make_chain(corners), disc = make_disc(0.4);
  double steepest = 1;
  for (const Vec2 n : chain.normals) steepest = std::min(steepest, n.y);
  for (int k = 0; k < 5664; ++k) {
    const double x = 1 + 0.0173 * k;
    // Lower the disc until it touches.
    const ImpactTime lands = time_of_impact(chain, {}, disc, {.p0 = {x, 2}, .v = {0, -1}}, 5);
    ASSERT_TRUE(lands.hit) << x;
    const auto list = contacts(chain, disc, {{x, 2 - lands.t}, {}}, 1e-9);
    ASSERT_FALSE(list.empty()) << x;
    for (const Manifold& m : list) {
      ASSERT_NEAR(m.points[0].separation, 0, 1e-9);
      ASSERT_GE(m.normal.y, steepest - 1e-9);
    }
  }
}

TEST(Chain, ClosedChainsJoinTheirLastCornerToTheFirst) {
  // Counter-clockwise around a room walks with the solid on the right, outside.
  const Shape room = make_chain(std::vector<Vec2>{{0, 0}, {4, 0}, {4, 3}, {0, 3}}, true);
  EXPECT_EQ(chain_segment_count(room), 4);
  const Shape box = make_box({1, 1});
  EXPECT_EQ(contacts(room, box, {{0.499, 0.499}, {}}, 0.0).size(), 2u);
  EXPECT_EQ(contacts(room, box, {{2, 1.5}, {}}, 0.0).size(), 0u);
  const auto left = contacts(room, box, {{0.499, 1.5}, {}}, 0.0);
  ASSERT_EQ(left.size(), 1u);
  EXPECT_EQ(left[0].normal, (Vec2{1, 0}));
}

/// The middle of the box is below the line of the segment that has the corner of the ridge: the box lay on
/// that corner, and went through it.
TEST(Chain, RidgeHoldsABoxWhoseMiddleIsBehindOneOfItsLines) {
  const Shape chain = make_chain(std::vector<Vec2>{{-3.15632821, -0.336547498},
                                                   {-1.99279701, -0.390712065},
                                                   {-0.264639575, -0.0792064061},
                                                   {0.440038903, -0.229785527}});
  const Transform pose{{0.082539971, -0.0179473937}, Rot::from_angle(2.96586636)};
  const Shape box = make_box({2 * 0.484685, 2 * 0.121018});
  const Manifold m = collide_chain_segment(chain, 1, {}, box, pose, 0.02);
  ASSERT_EQ(m.count, 1);
  EXPECT_NEAR(m.points[0].separation, -7e-6, 1e-6);
  EXPECT_NEAR(m.points[0].position.x, -0.264639575, 1e-5);
  EXPECT_EQ(collide_chain_segment(chain, 2, {}, box, pose, 0.02).count, 0);
}

/// A box that stands beside a ridge, 0.24 m away, was half a metre deep in it: its short edge pushes within
/// the ridge's normals, and nobody asked whether another edge has the ridge in front of it.
TEST(Chain, RidgeBesideABoxDoesNotTouchIt) {
  const Shape chain = make_chain(std::vector<Vec2>{{-4.07477565, -0.30470397},
                                                   {-3.36270833, 0.204457354},
                                                   {-2.90821092, -0.243726487},
                                                   {-2.19475987, 0.0206114077}});
  const Transform pose{{-3.0775, 0.4113}, Rot::from_angle(5.0476)};
  const Shape box = make_box({2 * 0.580975, 2 * 0.101617});
  EXPECT_EQ(collide_chain_segment(chain, 0, {}, box, pose, 0.03).count, 0);
  EXPECT_EQ(collide_chain_segment(chain, 1, {}, box, pose, 0.03).count, 1);
}

/// An edge that lies on a ridge turns over to the next segment: its far corner is seen before it lands there,
/// at its height. It was seen when it had landed, and nothing stopped it.
TEST(Chain, WhatTurnsOverARidgeIsForeseenBeyondIt) {
  const Shape chain = make_chain(std::vector<Vec2>{{-2, 0}, {0, 0}, {2, -0.35}});
  const double flat = std::atan2(-0.35, 2), half = 0.06;
  for (const Shape& shape : {make_box({0.8, 2 * half}), make_capsule({-0.4, 0}, {0.4, 0}, half)}) {
    for (const double lean : {0.05, 1e-3, 1e-6, 1e-9, 1e-11, 1e-13, 0.0, -1e-13, -1e-9, -1e-3}) {
      SCOPED_TRACE(lean);
      // The edge touches the ridge 0.3 m left of its middle, 0.7 m from its far corner.
      const Rot turn = Rot::from_angle(flat + lean);
      const Transform pose{-rotate(turn, {-0.3, -half}), turn};
      const Manifold before = collide_chain_segment(chain, 0, {}, shape, pose, 0.1);
      const Manifold beyond = collide_chain_segment(chain, 1, {}, shape, pose, 0.1);
      ASSERT_GE(before.count, 1);
      ASSERT_GE(beyond.count, 1);
      EXPECT_NEAR(dot(beyond.normal, rotate(Rot::from_angle(flat), {0, 1})), 1, 1e-12);
      const double height = 0.7 * std::sin(lean) - shape.radius * (1 - std::cos(lean));
      EXPECT_NEAR(beyond.points[0].separation, height, 1e-15 + 1e-3 * std::max(0.0, -lean));
      EXPECT_EQ(beyond.points[0].feature & 0xffffu, corner_code(1));
    }
  }
}

/// A heptagon comes down beside a ridge: the ridge is in front of the line of its lowest edge, 33 mm deep,
/// but the edge ends before that.
TEST(Chain, WhatTurnsOnARidgeDoesNotLandOnTheSideThatItLeaves) {
  // The box lies flat on the right side of the ridge, to rounding, and turns about the ridge as it slides:
  // its corner leaves that side. What goes down at the ridge is the contact of the left side.
  const Shape chain = make_chain(std::vector<Vec2>{
      {-1.5, 0x1.0856e5a10e057p-5}, {-1, 0x1.32c0a4de6d44fp-3}, {-0.5, 0x1.881baa52637b5p-5}});
  const Shape box = make_box({0x1.766145b2p-1, 0x1.3ddbb3fb33334p-2});
  Motion motion;
  motion.p0 = {-0x1.52c35045bec44p+0, 0x1.7f0d84c0f685ap-2};
  motion.angle0 = 0x1.7862c15c3bc9p+1;
  motion.v = {-0x1.81735bf3c569ap+0, -0x1.b39af6d051e91p+0};
  motion.omega = 0x1.5c58583b0a624p+2;
  motion.a = {0x1.145fd4f96951fp-2, -0x1.2fa1c5e1d293ep+3};
  motion.alpha = 0x1.90bdd788a28a4p+1;
  const ImpactTime left = time_of_impact_chain_segment(chain, 0, {}, box, motion, 0.0145);
  EXPECT_TRUE(left.hit);
  EXPECT_EQ(left.t, 0);
  EXPECT_FALSE(time_of_impact_chain_segment(chain, 1, {}, box, motion, 0.0145).hit);
}

TEST(Chain, RidgeBesideTheEndOfAnEdgeDoesNotTouchIt) {
  const Shape chain =
      make_chain(std::vector<Vec2>{{1.819559, -0.046565}, {3.479829, 0.223362}, {4.724185, -0.006169}});
  std::vector<Vec2> corners;
  corners.reserve(7);
  for (int i = 0; i < 7; ++i) corners.push_back(rotate(Rot::from_angle(2 * kPi * i / 7), {0.31682, 0}));
  const Shape shape = make_polygon(corners);
  const Transform pose{{3.6613, 0.4885}, Rot::from_angle(4.3303)};
  EXPECT_EQ(collide_chain_segment(chain, 0, {}, shape, pose, 0.03).count, 0);
  EXPECT_EQ(collide_chain_segment(chain, 1, {}, shape, pose, 0.03).count, 1);
}

/// A box that lies on one side of a ridge, but for rounding, and reaches over it: the other side, which it
/// has left, does not push at the ridge.
TEST(Chain, AnEdgeThatLiesOnOneSideOfARidgeIsNoContactOfTheOther) {
  const Shape chain = make_chain(std::vector<Vec2>{{-6, -1.5}, {0, 0}, {6, -0.3}}), box = make_box({1, 0.3});
  for (const int side : {0, 1}) {
    for (const double turn : {-1e-10, 0.0, 1e-10}) {
      const Vec2 along = -perp(chain.normals[static_cast<std::size_t>(side)]);
      const double angle = std::atan2(along.y, along.x) + (side == 0 ? turn : -turn);
      const Vec2 middle = (side == 0 ? -0.3 : 0.3) * along + (0.15 + 1e-11) * perp(along);
      const Transform pose{middle, Rot::from_angle(angle)};
      EXPECT_GE(collide_chain_segment(chain, side, {}, box, pose, 1e-9).count, 1) << side << turn;
      // The ridge itself, along the edge's normal, belongs to the segment that ends there.
      const Manifold other = collide_chain_segment(chain, 1 - side, {}, box, pose, 1e-9);
      const Vec2 own = chain.normals[static_cast<std::size_t>(1 - side)];
      EXPECT_TRUE(other.count == 0 || dot(other.normal, own) < 0.99) << side << " " << turn;
    }
  }
}

/// The corner of a triangle has gone over the ridge and below it; its edge leans over the ridge, which is
/// beside it.
TEST(Chain, ACornerThatSankInBelowARidgeIsPushedUp) {
  const Shape chain = make_chain(std::vector<Vec2>{{-6.9222, 0.0201}, {-5.9333, 0.6095}, {-4.9444, 0.5223}});
  const Shape triangle =
      make_polygon(std::vector<Vec2>{{-5.5119, 0.5724}, {-5.6961, 0.9554}, {-5.9357, 0.6044}});
  const Manifold m = collide_chain_segment(chain, 1, {}, triangle, {}, 0.01);
  ASSERT_EQ(m.count, 2);
  EXPECT_NEAR(std::min(m.points[0].separation, m.points[1].separation), -0.0053, 1e-4);
}

// However sharp a ridge is, its two sides together say what a triangle says: how far off the nearest of both
// is.
TEST(Chain, SharpRidgesAnswerAsTriangles) {
  Scenes random(97);
  for (const double degrees : {20.0, 60.0, 80.0, 88.0, 100.0, 120.0, 150.0}) {
    const double half = 0.5 * degrees * kPi / 180;
    const Vec2 left{-3 * std::sin(half), -3 * std::cos(half)}, right{-left.x, left.y};
    const Shape chain = make_chain(std::vector<Vec2>{left, {0, 0}, right});
    const Shape triangle = make_polygon(std::vector<Vec2>{right, {0, 0}, left});
    for (const Shape& shape : {make_box({0.8, 0.5}), make_box({0.8, 0.5}, {}, 0, 0.1),
                               make_capsule({-0.4, 0}, {0.4, 0}, 0.1), make_disc(0.3)}) {
      for (int k = 0; k < 2000; ++k) {
        Transform pose{{random.uniform(-1, 1), random.uniform(-0.2, 1)},
                       Rot::from_angle(random.uniform(-3, 3))};
        const ClosestPoints now = distance(triangle, {}, shape, pose);
        pose.p -= (now.distance - 1e-4) * now.normal;
        if (std::abs(distance(triangle, {}, shape, pose).distance - 1e-4) > 1e-9) continue;
        double nearest = kInfinity;
        for (const Manifold& m : contacts(chain, shape, pose, 0.005))
          for (int i = 0; i < m.count; ++i) nearest = std::min(nearest, m.points[i].separation);
        ASSERT_NEAR(nearest, 1e-4, 1e-9)
            << degrees << " degrees, at " << pose.p.x << ' ' << pose.p.y << ", try " << k;
      }
    }
  }
}

}  // namespace chain_test
}  // namespace skerry
