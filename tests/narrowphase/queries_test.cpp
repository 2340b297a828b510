// SPDX-License-Identifier: MIT
#include "physics/narrowphase/queries.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>

#include "physics/narrowphase/collide.h"
#include "tests/narrowphase/oracle.h"

namespace skerry {
namespace queries_test {

using oracle::Scenes;

TEST(Distance, AgreesWithTheOracleAndItsPointsAreThatFarApart) {
  const unsigned seed = 61;
  Scenes scenes(seed);
  for (int k = 0; k < test_scale(20000); ++k) {
    const Shape a = scenes.shape(1), b = scenes.shape(scenes.uniform(0.2, 3));
    const auto [pose_a, pose_b] = scenes.poses(1, 1, 100);
    const ClosestPoints c = distance(a, pose_a, b, pose_b);
    const oracle::Distance truth = oracle::brute_force(a, pose_a, b, pose_b);
    ASSERT_NEAR(c.distance, static_cast<double>(truth.distance), 1e-13) << "case " << k << " seed " << seed;
    ASSERT_NEAR(length(c.point_b - c.point_a - c.distance * c.normal), 0, 1e-12);
    ASSERT_EQ(overlaps(a, pose_a, b, pose_b), c.distance <= 0);
    // Each point lies on its own surface.
    ASSERT_NEAR(closest_point(a, pose_a, c.point_a).distance, 0, 1e-12) << "case " << k << " seed " << seed;
    ASSERT_NEAR(closest_point(b, pose_b, c.point_b).distance, 0, 1e-12) << "case " << k << " seed " << seed;
  }
}

// The ends of the capsule's segment lie above the same point of the face, up to rounding of either sign.
TEST(Distance, OfACapsuleThatStandsUprightOnAFaceIsThatOfItsEnd) {
  const unsigned seed = 71;
  Scenes scenes(seed);
  for (int k = 0; k < test_scale(5000); ++k) {
    const double tilt = scenes.uniform(-kPi, kPi), lean = scenes.uniform(-kPi, kPi);
    const double height = scenes.uniform(-0.05, 0.2), along = scenes.uniform(-0.9, 0.9);
    const Shape face = scenes.below(2) == 0 ? make_box({2, 0.5}) : make_capsule({-1, 0}, {1, 0}, 0.25);
    const Vec2 axis = rotate(Rot::from_angle(lean), {0.2, 0});
    const Shape capsule = make_capsule(-axis, axis, 0.1);
    const Vec2 far = scenes.below(4) == 0 ? Vec2{1000, -300} : Vec2{};
    const Transform pose_a{far, Rot::from_angle(tilt)};
    const Vec2 normal = rotate(pose_a.q, {0, 1}), beside = rotate(pose_a.q, {along, 0});
    const Transform pose_b{far + beside + (0.25 + 0.3 + height) * normal,
                           Rot::from_angle(tilt + kPi / 2 - lean)};
    ASSERT_NEAR(distance(face, pose_a, capsule, pose_b).distance, height, 1e-12) << k << " seed " << seed;
    const Manifold manifold = collide(face, pose_a, capsule, pose_b, 0.3);
    ASSERT_GE(manifold.count, 1) << k << " seed " << seed;
    ASSERT_NEAR(manifold.points[0].separation, height, 1e-12) << k << " seed " << seed;
    ASSERT_NEAR(length(manifold.normal - normal), 0, 1e-9) << k << " seed " << seed;
  }
}

TEST(ClosestPoint, IsInsideWhereThePointIs) {
  const Shape box = make_box({2, 2});
  const Transform pose{{10, 0}, {}};
  EXPECT_TRUE(contains(box, pose, {10.5, 0.5}));
  EXPECT_TRUE(contains(box, pose, {11, 1}));
  EXPECT_FALSE(contains(box, pose, {11.0001, 0}));
  const ClosestPoint corner = closest_point(box, pose, {14, 5});
  EXPECT_EQ(corner.point, (Vec2{11, 1}));
  EXPECT_EQ(corner.distance, 5);
  EXPECT_NEAR(length(corner.normal - Vec2{0.6, 0.8}), 0, 1e-15);
  EXPECT_EQ(closest_point(box, pose, {10.75, 0}).distance, -0.25);
  const Shape ground = make_half_plane({0, 1}, {0, 1});
  EXPECT_EQ(closest_point(ground, {}, {5, 3}).distance, 2);
  EXPECT_EQ(closest_point(ground, {}, {5, 3}).point, (Vec2{5, 1}));
  EXPECT_TRUE(contains(ground, {}, {5, -3}));
  const Shape chain = make_chain(std::vector<Vec2>{{0, 0}, {1, 0}, {2, 1}});
  EXPECT_NEAR(closest_point(chain, {}, {0.5, 2}).distance, std::sqrt(0.5) * 2.5, 1e-15 * 4);
  EXPECT_EQ(closest_point(chain, {}, {-3, 4}).distance, 5);
  EXPECT_TRUE(contains(chain, {}, {0.5, 0}));
}

TEST(RayCast, HitsWhereFineSamplingEntersTheShape) {
  const unsigned seed = 62;
  Scenes scenes(seed);
  int hits = 0;
  for (int k = 0; k < test_scale(20000); ++k) {
    const int kind = scenes.below(8);
    // Also a box that is turned and moved within its body.
    const Shape shape = kind == 0 ? make_half_plane(scenes.direction(), scenes.direction())
                        : kind == 1
                            ? make_box({1, scenes.uniform(0.1, 1)}, 0.3 * scenes.direction(), scenes.angle())
                            : scenes.shape(1);
    const Transform pose{100 * scenes.direction(), Rot::from_angle(scenes.angle())};
    Ray ray;
    ray.origin = pose.p + 3 * scenes.direction();
    ray.direction = pose.p + 0.5 * scenes.direction() - ray.origin;
    ray.t_max = scenes.uniform(0.2, 2);
    const auto hit = ray_cast(shape, pose, ray);
    const auto height = [&](double t) {
      return closest_point(shape, pose, ray.origin + t * ray.direction).distance;
    };
    if (height(0) <= 0) {
      ASSERT_TRUE(hit && hit->t == 0);
      continue;
    }
    // Before the hit outside, at it on the surface.
    const double end = hit ? hit->t : ray.t_max;
    for (int i = 0; i < 40; ++i) ASSERT_GT(height(end * i / 40), -1e-12) << "case " << k << " seed " << seed;
    if (!hit) continue;
    ++hits;
    ASSERT_NEAR(height(hit->t), 0, 1e-12) << "case " << k << " seed " << seed;
    ASSERT_LE(dot(hit->normal, ray.direction), 0);
    ASSERT_NEAR(length(hit->normal), 1, 1e-12);
    ASSERT_NEAR(length(hit->normal - closest_point(shape, pose, hit->point + 1e-6 * hit->normal).normal), 0,
                1e-6);
    ASSERT_NEAR(length(hit->point - (ray.origin + hit->t * ray.direction)), 0, 1e-13);
  }
  EXPECT_GT(hits, 1000);
}

TEST(RayCast, MeetsAChainOnItsFreeSideOnlyAndNeverSlipsThroughACorner) {
  const Shape chain = make_chain(std::vector<Vec2>{{0, 0}, {1, 0.3}, {2, -0.1}, {3, 0}});
  for (int i = 1; i < 300; ++i) {
    const double x = i * 0.01;
    const auto hit = ray_cast(chain, {}, {{x, 5}, {0, -1}, 10});
    ASSERT_TRUE(hit) << x;
    EXPECT_GT(hit->normal.y, 0.9);
    EXPECT_FALSE(ray_cast(chain, {}, {{x, -5}, {0, 1}, 10})) << x;
  }
  const auto corner = ray_cast(chain, {}, {{1, 5}, {0, -1}, 10});
  ASSERT_TRUE(corner);
  EXPECT_NEAR(corner->t, 4.7, 1e-15);
}

TEST(RayCast, WithoutAnEndMissesWhatIsNotThere) {
  const Ray up{{0, 5}, {0, 1}, kInfinity};
  for (const Shape& shape :
       {make_disc(1), make_capsule({-1, 0}, {1, 0}, 0.5), make_box({1, 1}), make_box({1, 1}, {}, 0.3, 0.1),
        make_half_plane({0, 0}, {0, 1}), make_chain(std::vector<Vec2>{{1, 0}, {-1, 0}}),
        make_polygon(std::vector<Vec2>{{-1, 0}, {1, 0}, {0, 1}})}) {
    EXPECT_FALSE(ray_cast(shape, {}, up));
    const auto down = ray_cast(shape, {}, {{0, 5}, {0, -1}, kInfinity});
    EXPECT_EQ(down.has_value(), shape.kind != ShapeKind::Chain);
  }
}

TEST(RayCast, AlongTheSideOfABoxAndThroughACornerTouchesIt) {
  const Shape box = make_box({2, 2}), triangle = make_polygon(std::vector<Vec2>{{0, 0}, {2, 0}, {1, 1}});
  for (const double side : {-1.0, 1.0}) {
    const auto along = ray_cast(box, {}, {{-3, side}, {1, 0}, 10});
    ASSERT_TRUE(along) << side;
    EXPECT_EQ(along->t, 2);
    EXPECT_EQ(along->normal, (Vec2{-1, 0}));
    EXPECT_FALSE(ray_cast(box, {}, {{-3, side * 1.0000001}, {1, 0}, 10}));
    // Through the upper corner of a triangle, from either side.
    const auto corner = ray_cast(triangle, {}, {{1 + 3 * side, 1}, {-side, 0}, 10});
    ASSERT_TRUE(corner) << side;
    EXPECT_EQ(corner->t, 3);
  }
  const auto edge = ray_cast(triangle, {}, {{-1, 0}, {1, 0}, 10});
  ASSERT_TRUE(edge);
  EXPECT_EQ(edge->t, 1);
  EXPECT_EQ(ray_cast(triangle, {}, {{1, 0.5}, {1, 0}, 10})->t, 0) << "from inside";
  EXPECT_FALSE(ray_cast(triangle, {}, {{3, 0.5}, {1, 0}, 10})) << "behind it";
}

TEST(RayCast, AlongEachSideOfABoxFromBothEndsHitsAtItsEndWithFiniteResults) {
  const Shape box = make_box({2, 2});
  for (const double side : {-1.0, 1.0}) {
    for (const double way : {-1.0, 1.0}) {
      for (const double zero : {-0.0, 0.0}) {
        const Ray level{{-3 * way, side}, {way, zero}, 10}, upright{{side, -3 * way}, {zero, way}, 10};
        const auto across = ray_cast(box, {}, level), along = ray_cast(box, {}, upright);
        ASSERT_TRUE(across && along) << side << " " << way << " " << zero;
        EXPECT_EQ(across->t, 2);
        EXPECT_EQ(across->point, (Vec2{-way, side}));
        EXPECT_EQ(across->normal, (Vec2{-way, 0}));
        EXPECT_EQ(along->t, 2);
        EXPECT_EQ(along->point, (Vec2{side, -way}));
        EXPECT_EQ(along->normal, (Vec2{0, -way}));
        // Beside it, and away from it.
        EXPECT_FALSE(ray_cast(box, {}, {{-3 * way, 1.5 * side}, {way, zero}, kInfinity}));
        EXPECT_FALSE(ray_cast(box, {}, {{3 * way, side}, {way, zero}, kInfinity}));
        EXPECT_FALSE(ray_cast(box, {}, {{side, 3 * way}, {zero, way}, kInfinity}));
      }
    }
  }
}

// Where they enter is a quotient of roundings.
TEST(RayCast, AlongAnEdgeOfTurnedShapesHitsBetweenItsCornersOrNotAtAll) {
  const unsigned seed = 72;
  Scenes scenes(seed);
  int hits = 0;
  for (int k = 0; k < test_scale(20000); ++k) {
    const int kind = scenes.below(5), corners = 3 + scenes.below(8);
    std::vector<Vec2> ring(static_cast<std::size_t>(corners));
    for (int i = 0; i < corners; ++i)
      ring[static_cast<std::size_t>(i)] = rotate(Rot::from_angle(2 * kPi * (i + 0.3) / corners), {1, 0});
    const Shape shape = kind == 0   ? make_box({2, 1}, {0.1, 0.2}, 0.3)
                        : kind == 1 ? make_box({2, 1}, {}, 0, 0.1)
                        : kind == 2 ? make_capsule({-1, 0}, {1, 0.3}, 0.2)
                        : kind == 3 ? make_chain(ring)
                                    : make_polygon(ring);
    const Transform pose{5 * scenes.direction(), Rot::from_angle(scenes.angle())};
    const std::size_t edge = static_cast<std::size_t>(scenes.below(static_cast<int>(shape.normals.size())));
    const Vec2 out = shape.radius * shape.normals[edge];
    Vec2 p = to_world(pose, shape.vertices[edge] + out);
    Vec2 q = to_world(pose, shape.vertices[(edge + 1) % shape.vertices.size()] + out);
    if (scenes.below(2) == 0) std::swap(p, q);
    // From before the edge, from its end, or past it.
    const int place = scenes.below(3);
    const double before = place == 0 ? 0 : scenes.uniform(place == 1 ? -3 : 0, 2);
    const Ray ray{p - before * (q - p), scenes.uniform(1, 4) * (q - p), 3};
    const auto hit = ray_cast(shape, pose, ray);
    if (!hit) continue;
    ++hits;
    ASSERT_NEAR(closest_point(shape, pose, hit->point).distance, 0, 1e-12) << k << " seed " << seed;
    ASSERT_NEAR(length(hit->normal), 1, 1e-12) << k << " seed " << seed;
  }
  EXPECT_GT(hits, 1000);
}

TEST(RayCast, FromAPointOfACircleAlongItHitsThereOrNotAtAll) {
  const unsigned seed = 73;
  Scenes scenes(seed);
  int hits = 0;
  for (int k = 0; k < test_scale(20000); ++k) {
    const Vec2 n = rotate(Rot::from_angle(scenes.angle()), {1, 0});
    const bool is_disc = scenes.below(2) == 0;
    const Shape shape = is_disc ? make_disc(1) : make_capsule({0, 0}, -0.7 * n, 1);
    const Transform pose{5 * scenes.direction(), {}};
    const auto hit = ray_cast(shape, pose, {pose.p + n, scenes.uniform(0.5, 5) * perp(n), 10});
    if (!hit) continue;
    ++hits;
    ASSERT_NEAR(length(hit->point - (pose.p + n)), 0, 1e-7) << k << " seed " << seed;
    ASSERT_NEAR(closest_point(shape, pose, hit->point).distance, 0, 1e-12) << k << " seed " << seed;
    ASSERT_NEAR(length(hit->normal), 1, 1e-12) << k << " seed " << seed;
  }
  EXPECT_GT(hits, 1000);
}

TEST(RayCast, RefusesAZeroDirectionAndNumbersThatAreNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Shape& shape :
       {make_disc(1), make_disc(1, {0.1, 0}), make_box({1, 1}), make_box({1, 1}, {0.1, 0}),
        make_polygon(std::vector<Vec2>{{-1, 0}, {1, 0}, {0, 1}})}) {
    for (const Ray& ray :
         {Ray{{0, 3}, {0, 0}, 1}, Ray{{nan, 3}, {0, -1}, 9}, Ray{{0, nan}, {0, -1}, 9},
          Ray{{0, 3}, {nan, -1}, 9}, Ray{{0, 3}, {0, nan}, 9}, Ray{{0, 3}, {0, -1}, nan},
          Ray{{0, 3}, {0, -1}, -1}, Ray{{kInfinity, 3}, {0, -1}, 9}, Ray{{0, 3}, {0, -kInfinity}, 9}}) {
      EXPECT_THROW(ray_cast(shape, {}, ray), std::invalid_argument)
          << ray.origin.x << " " << ray.origin.y << " " << ray.direction.x << " " << ray.direction.y << " "
          << ray.t_max << " corners " << shape.vertices.size();
    }
  }
}

TEST(RayCast, SaysWhatItRefuses) {
  try {
    ray_cast(make_disc(1), {}, {{0, 3}, {0, -1e300}, 9});
    ADD_FAILURE() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_THAT(error.what(), testing::EndsWith("got origin (0, 3), direction (0, -1e+300), t_max 9"));
  }
}

TEST(ShapeCast, RefusesAWayThatIsNotFiniteWhereverTheShapesAre) {
  for (const double x : {0.0, 5.0}) {
    try {
      shape_cast(make_disc(1), {{x, 0}, {}}, {kInfinity, 0}, make_disc(1), {});
      ADD_FAILURE() << "accepted at " << x;
    } catch (const std::invalid_argument& error) {
      EXPECT_STREQ(error.what(), "shape_cast: translation must be finite, got (inf, 0)");
    }
  }
}

TEST(ShapeCast, StopsAtTheFirstTouch) {
  const unsigned seed = 63;
  Scenes scenes(seed);
  int hits = 0;
  for (int k = 0; k < test_scale(5000); ++k) {
    const Shape moving = scenes.shape(1), target = scenes.shape(1);
    const Transform from{3 * scenes.direction(), Rot::from_angle(scenes.angle())};
    const Transform pose{{}, Rot::from_angle(scenes.angle())};
    const Vec2 way = scenes.uniform(0.5, 2) * (scenes.direction() - from.p);
    const auto hit = shape_cast(moving, from, way, target, pose);
    const auto gap = [&](double t) {
      return distance(target, pose, moving, {from.p + t * way, from.q}).distance;
    };
    const double end = hit ? hit->t : 1;
    for (int i = 0; i <= 20; ++i) ASSERT_GT(gap(end * i / 20), -1e-12) << "case " << k << " seed " << seed;
    if (!hit || hit->t == 0) continue;
    ++hits;
    ASSERT_NEAR(gap(hit->t), 0, 1e-12) << "case " << k << " seed " << seed;
    ASSERT_LT(dot(hit->normal, way), 1e-9);
  }
  EXPECT_GT(hits, 500);
  const auto landed = shape_cast(make_disc(0.5), {{0, 3}, {}}, {0, -5}, make_half_plane({0, 0}, {0, 1}), {});
  ASSERT_TRUE(landed);
  EXPECT_EQ(landed->t, 0.5);
  EXPECT_EQ(landed->normal, (Vec2{0, 1}));
  const Shape chain = make_chain(std::vector<Vec2>{{-2, 0}, {0, 0}, {2, 0}});
  const auto on_chain = shape_cast(make_box({1, 1}), {{0, 3}, {}}, {0.1, -5}, chain, {});
  ASSERT_TRUE(on_chain);
  EXPECT_NEAR(on_chain->t, 0.5, 1e-15);
  EXPECT_THROW(shape_cast(chain, {}, {1, 0}, chain, {}), std::invalid_argument);
}

// When the box comes to the ceiling it is half through a floor that it passes from below.
TEST(ShapeCast, AgainstAChainTellsTheSegmentThatStopsItNotOnePassedFromBehind) {
  const Shape chain = make_chain(std::vector<Vec2>{{-3, 1}, {3, 1}, {4, 1}, {4, 1.6}, {3, 1.6}, {-3, 1.6}});
  const Shape box = make_box({1, 1});
  const auto up = shape_cast(box, {}, {0, 5}, chain, {});
  ASSERT_TRUE(up);
  EXPECT_NEAR(up->t, 0.22, 1e-15);
  EXPECT_NEAR(up->point.y, 1.6, 1e-15);
  EXPECT_EQ(up->normal, (Vec2{0, -1}));
  // The chain moves: point and normal are those of the box.
  const auto down = shape_cast(chain, {}, {0, -5}, box, {});
  ASSERT_TRUE(down);
  EXPECT_NEAR(down->t, 0.22, 1e-15);
  EXPECT_NEAR(down->point.y, 0.5, 1e-15);
  EXPECT_EQ(down->normal, (Vec2{0, 1}));
}

TEST(ShapeCast, AgainstAChainTouchesThereWithANormalAgainstTheMotion) {
  const unsigned seed = 74;
  Scenes scenes(seed);
  int hits = 0;
  for (int k = 0; k < test_scale(5000); ++k) {
    std::vector<Vec2> way(10);
    for (Vec2& p : way) p = {scenes.uniform(-2, 2), scenes.uniform(-2, 2)};
    const Shape chain = make_chain(way), moving = scenes.shape(0.5);
    const Transform from{4 * scenes.direction(), Rot::from_angle(scenes.angle())};
    const Transform pose{{}, Rot::from_angle(scenes.angle())};
    const Vec2 translation = -2 * from.p;
    const auto hit = shape_cast(moving, from, translation, chain, pose);
    if (!hit || hit->t == 0) continue;
    ++hits;
    ASSERT_LT(dot(hit->normal, translation), 1e-9) << k << " seed " << seed;
    ASSERT_NEAR(closest_point(chain, pose, hit->point).distance, 0, 1e-12) << k << " seed " << seed;
  }
  EXPECT_GT(hits, 500);
}

TEST(ShapeCast, OntoAChainNamesTheSegmentThatIsMetFirst) {
  // Down into a valley, beside its middle: one slope is met, and the other would be later.
  const Shape valley = make_chain(std::vector<Vec2>{{-4, 4}, {0, 0}, {4, 4}}), disc = make_disc(0.5);
  for (const double x : {-0.2, 0.2}) {
    const auto hit = shape_cast(disc, {{x, 3}, {}}, {0, -6}, valley, {});
    ASSERT_TRUE(hit);
    EXPECT_NEAR(hit->normal.x, (x > 0 ? -1 : 1) * std::sqrt(0.5), 1e-9) << x;
    EXPECT_NEAR(hit->t, (3 - (0.2 + 0.5 * std::sqrt(2.0))) / 6, 1e-9) << x;
  }
}

TEST(ShapeCast, MeetsWhatItTouchesAtTheStartWhicheverWayItGoes) {
  const Shape disc = make_disc(1);
  for (const double way : {1.0, -1.0}) {
    const auto hit = shape_cast(disc, {{2, 0}, {}}, {way, 0}, disc, {});
    ASSERT_TRUE(hit) << way;
    EXPECT_EQ(hit->t, 0);
    EXPECT_NEAR(hit->normal.x, 1, 1e-12);
  }
}

TEST(RayCast, MeetsABoxThatIsOffItsBodyAlongOneAxis) {
  for (const Vec2 middle : {Vec2{0, 0.75}, Vec2{0.75, 0}}) {
    const Shape box = make_box({1, 1}, middle);
    const auto down = ray_cast(box, {}, {.origin = {middle.x, 10}, .direction = {0, -1}, .t_max = 100});
    ASSERT_TRUE(down);
    EXPECT_NEAR(down->point.y, middle.y + 0.5, 1e-14);
    const auto left = ray_cast(box, {}, {.origin = {10, middle.y}, .direction = {-1, 0}, .t_max = 100});
    ASSERT_TRUE(left);
    EXPECT_NEAR(left->point.x, middle.x + 0.5, 1e-14);
  }
}

}  // namespace queries_test
}  // namespace skerry
