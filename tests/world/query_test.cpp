// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "tests/support/worlds.h"

namespace skerry {
namespace query_test {

using test::add;
using test::add_ground;
using test::smooth;
using test::weightless;

class QueriesOn : public testing::TestWithParam<std::string> {
 protected:
  World world() const {
    WorldConfig config;
    config.broad_phase = GetParam();
    return World(config);
  }
};

TEST_P(QueriesOn, AgreeWithLookingAtEveryShape) {
  const unsigned seed = 17;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  World w = world();
  add_ground(w, smooth(make_disc(1)));
  for (int i = 0; i < 60; ++i) {
    ShapeDef def = smooth(i % 3 == 0   ? make_disc(0.3)
                          : i % 3 == 1 ? make_box({0.5, 0.3})
                                       : make_capsule({0, 0}, {0.4, 0.2}, 0.1));
    def.filter.category = 1u << (i % 4);
    add(w, {5 * unit(random), 3 + 2.5 * unit(random)}, def, 1, {unit(random), unit(random)}, unit(random),
        3 * unit(random));
  }
  for (int i = 0; i < 5; ++i) w.step(1.0 / 60);
  // One body moved by hand and one added since: their boxes are out of date.
  w.set_pose(w.body_id(7), {0, 9}, 0.4);
  add(w, {0, 9}, smooth(make_disc(0.2)));

  const auto shapes = w.shapes();
  const auto pose = [&](std::size_t i) { return w.pose(shapes[i].body); };
  for (int trial = 0; trial < 200; ++trial) {
    Filter filter;
    filter.mask = static_cast<std::uint32_t>(random() % 16);
    const auto meets = [&](std::size_t i) {
      return shapes[i].alive && may_collide(shapes[i].filter, filter);
    };
    const Vec2 p{5 * unit(random), 4 + 6 * unit(random)};
    std::vector<std::uint32_t> at;
    double nearest = 0.7;
    for (std::uint32_t i = 0; i < shapes.size(); ++i) {
      if (!meets(i)) continue;
      if (contains(shapes[i].shape, pose(i), p)) at.push_back(i);
      nearest = std::min(nearest, closest_point(shapes[i].shape, pose(i), p).distance);
    }
    std::vector<std::uint32_t> found;
    for (const ShapeId id : w.shapes_at(p, filter)) found.push_back(id.index);
    ASSERT_EQ(found, at) << "seed " << seed << " trial " << trial;
    const auto closest = w.closest(p, 0.7, filter);
    ASSERT_EQ(closest.has_value(), nearest < 0.7);
    if (closest) {
      ASSERT_EQ(closest->distance, nearest);
    }

    const Ray ray{p, {8 * unit(random), 8 * unit(random)}};
    double first = 2;
    for (std::uint32_t i = 0; i < shapes.size(); ++i) {
      if (!meets(i)) continue;
      const auto hit = ray_cast(shapes[i].shape, pose(i), ray);
      if (hit) first = std::min(first, hit->t);
    }
    const auto hit = w.ray_cast(ray, filter);
    ASSERT_EQ(hit.has_value(), first <= 1) << "seed " << seed << " trial " << trial;
    if (hit) {
      ASSERT_EQ(hit->t, first);
    }

    const Shape probe = make_box({0.4, 0.4});
    const Transform at_p{p, Rot::from_angle(unit(random))};
    double share = 2;
    std::vector<std::uint32_t> touching;
    for (std::uint32_t i = 0; i < shapes.size(); ++i) {
      if (!meets(i)) continue;
      if (overlaps(probe, at_p, shapes[i].shape, pose(i))) touching.push_back(i);
      const auto cast = shape_cast(probe, at_p, ray.direction, shapes[i].shape, pose(i));
      if (cast) share = std::min(share, cast->t);
    }
    found.clear();
    for (const ShapeId id : w.shapes_overlapping(probe, at_p, filter)) found.push_back(id.index);
    ASSERT_EQ(found, touching) << "seed " << seed << " trial " << trial;
    const auto cast = w.shape_cast(probe, at_p, ray.direction, filter);
    ASSERT_EQ(cast.has_value(), share <= 1);
    if (cast) {
      ASSERT_EQ(cast->t, share);
    }
  }
}

std::vector<std::string> names() {
  std::vector<std::string> all;
  for (const BroadPhaseEntry& entry : broad_phases()) all.emplace_back(entry.name);
  return all;
}

INSTANTIATE_TEST_SUITE_P(Registry, QueriesOn, testing::ValuesIn(names()),
                         [](const testing::TestParamInfo<std::string>& param) { return param.param; });

TEST(Queries, FindNothingInAnEmptyWorldAndRefuseNonsense) {
  World world;
  EXPECT_TRUE(world.shapes_at({0, 0}).empty());
  EXPECT_FALSE(world.ray_cast({{0, 0}, {1, 0}}));
  EXPECT_FALSE(world.closest({0, 0}, 10));
  EXPECT_THROW(world.ray_cast({{0, 0}, {0, 0}}), std::invalid_argument);
  EXPECT_THROW(world.closest({0, NAN}, 1), std::invalid_argument);
  EXPECT_THROW(world.closest({0, 0}, -1), std::invalid_argument);
  EXPECT_THROW(world.shapes_in_box({{1, 0}, {0, 1}}), std::invalid_argument);
}

TEST(Queries, RaysMayHaveDirectionsWhoseSquaresAreNoNumbers) {
  World world;
  add(world, {0, 3}, smooth(make_box({1, 1})));
  add(world, {4, 0}, smooth(make_disc(1)));
  const BodyId ground = world.create_body({.type = BodyType::Static});
  world.add_shape(ground, smooth(make_chain(std::vector<Vec2>{{-5, -2}, {5, -2}})));
  for (const double size : {1e300, 1e-300}) {
    for (const Vec2 direction : {Vec2{0, 1}, Vec2{1, 0.1}, Vec2{0.2, -1}}) {
      const std::optional<QueryHit> usual = world.ray_cast({{0.1, 0.2}, direction, 8}),
                                    hit = world.ray_cast({{0.1, 0.2}, size * direction, 8 / size});
      ASSERT_TRUE(usual && hit) << size;
      EXPECT_EQ(hit->shape, usual->shape);
      EXPECT_NEAR(hit->t * size, usual->t, 1e-12 * usual->t);
      EXPECT_NEAR(length(hit->point - usual->point), 0, 1e-12);
      EXPECT_NEAR(length(hit->normal - usual->normal), 0, 1e-12);
    }
    EXPECT_FALSE(world.ray_cast({{0.1, 0.2}, {0, size}, 2 / size}));
  }
}

TEST(Queries, DistanceBetweenTwoShapesOfTheWorld) {
  World world;
  const auto a = world.create_body({.position = {0, 0}});
  const auto b = world.create_body({.position = {3, 0}});
  const auto disc = world.add_shape(a, smooth(make_disc(0.5)));
  const auto box = world.add_shape(b, smooth(make_box({1, 1})));
  EXPECT_NEAR(world.distance(disc, box).distance, 2, 1e-15);
  world.destroy(box);
  EXPECT_THROW(world.distance(disc, box), std::invalid_argument);
}

// A pile in flow takes what little its discs overlap to the next step, and some leave the boxes that were
// made for this one by centimetres.
TEST(Queries, FindWhatLeftItsBoxInFlow) {
  World w;
  const BodyId pit = w.create_body({.type = BodyType::Static});
  for (const Shape& side :
       {make_half_plane({0, 0}, {0, 1}), make_half_plane({-4, 0}, {1, 0}), make_half_plane({4, 0}, {-1, 0})})
    w.add_shape(pit, {.shape = side});
  const std::size_t sides = w.shapes().size();
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int row = 0; row < 150; ++row) {
    for (int column = 0; column < 10; ++column) {
      const double across = 3 * unit(random);
      add(w, {-3.6 + 0.8 * column, 1 + 0.8 * row}, smooth(make_disc(0.3)), 1, {across, -10});
    }
  }
  int outside = 0;
  for (int t = 0; t < 20; ++t) {
    w.step(1.0 / 60);
    const auto shapes = w.shapes();
    for (std::uint32_t i = static_cast<std::uint32_t>(sides); i < shapes.size(); ++i) {
      const Vec2 middle = w.pose(shapes[i].body).p;
      for (const Vec2 way : {Vec2{1, 0}, Vec2{0, 1}, Vec2{-1, 0}, Vec2{0, -1}}) {
        const Vec2 tip = middle + (0.3 - 1e-6) * way;
        if (contains(shapes[i].box, tip)) continue;
        ++outside;
        const auto is_it = [&](ShapeId id) { return id.index == i; };
        const auto at = w.shapes_at(tip), near = w.shapes_in_box({tip, tip});
        const auto hits = w.ray_cast_all({tip + 1e-3 * way, -1e-2 * way, 1});
        ASSERT_TRUE(std::any_of(at.begin(), at.end(), is_it)) << "step " << t << " shape " << i;
        ASSERT_TRUE(std::any_of(near.begin(), near.end(), is_it)) << "step " << t << " shape " << i;
        ASSERT_TRUE(
            std::any_of(hits.begin(), hits.end(), [&](const QueryHit& hit) { return is_it(hit.shape); }))
            << "step " << t << " shape " << i;
      }
    }
  }
  EXPECT_GT(outside, 10);
}

TEST(Queries, FindWhatIsMovedByHandOnceAndNotAfterItIsGone) {
  World world(weightless());
  const BodyId body = add(world, {0, 0}, smooth(make_disc(1)));
  world.step(0.01);
  world.set_pose(body, {0.01, 0}, 0);
  EXPECT_EQ(world.shapes_at({0, 0}).size(), 1u);
  EXPECT_EQ(world.ray_cast_all({{-5, 0}, {10, 0}}).size(), 1u);
  world.destroy(body);
  EXPECT_TRUE(world.shapes_at({0, 0}).empty());
  EXPECT_TRUE(world.shapes_in_box({{-1, -1}, {1, 1}}).empty());
}

TEST(Queries, ByChainsAndHalfPlanesMeetNoneOfTheirKind) {
  World world;
  add_ground(world, smooth(make_disc(1)));
  const BodyId line = world.create_body({.type = BodyType::Static});
  world.add_shape(line, smooth(make_chain(std::vector<Vec2>{{-1, 0}, {1, 0}})));
  add(world, {0, 0.2}, smooth(make_disc(0.5)));
  for (const Shape& shape :
       {make_half_plane({0, 0}, {0, 1}), make_chain(std::vector<Vec2>{{-1, 0.1}, {1, 0.1}})}) {
    EXPECT_EQ(world.shapes_overlapping(shape, {}).size(), 1u);
    EXPECT_NO_THROW((void)world.shape_cast(shape, {}, {0, 1}));
  }
}

TEST(Queries, NameTheFirstOfShapesThatAreEquallyNear) {
  World world(weightless()), row(weightless());
  for (const double x : {2.0, -2.0}) add(world, {x, 0}, smooth(make_disc(1)));
  const auto closest = world.closest({0, 0}, 5);
  ASSERT_TRUE(closest);
  EXPECT_EQ(closest->body.index, 0u);
  for (const double y : {1.5, -1.5}) add(row, {3, y}, smooth(make_disc(1)));
  const auto hit = row.shape_cast(make_disc(1), {}, {4, 0});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->body.index, 0u);
}

TEST(Queries, TellWhatTheShapesThemselvesTell) {
  const unsigned seed = 23;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  World w(weightless());
  for (int i = 0; i < 40; ++i) {
    ShapeDef def = smooth(i % 3 == 0   ? make_disc(0.3)
                          : i % 3 == 1 ? make_box({0.5, 0.3})
                                       : make_capsule({0, 0}, {0.4, 0.2}, 0.1));
    def.filter.category = 1u << (i % 4);
    add(w, {4 * unit(random), 3 * unit(random)}, def, 1, {3 * unit(random), 3 * unit(random)}, 0,
        3 * unit(random));
  }
  for (int i = 0; i < 3; ++i) w.step(1.0 / 60);
  const auto shapes = w.shapes();
  const auto expect_hit = [&](const QueryHit& hit, const auto& of, const char* query) {
    EXPECT_EQ(hit.body, shapes[hit.shape.index].body) << query;
    EXPECT_EQ(hit.point, of.point) << query;
    EXPECT_EQ(hit.normal, of.normal) << query;
    EXPECT_GT(length(hit.normal), 0.9) << query;
  };
  int rays = 0, casts = 0, nearest = 0, in_boxes = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Filter filter{.mask = static_cast<std::uint32_t>(random() % 16)};
    const Vec2 p{5 * unit(random), 4 * unit(random)}, way{4 * unit(random), 4 * unit(random)};
    const auto shape_of = [&](const QueryHit& hit) -> const Shape& { return shapes[hit.shape.index].shape; };
    const auto pose_of = [&](const QueryHit& hit) { return w.pose(shapes[hit.shape.index].body); };
    if (const auto hit = w.ray_cast({p, way}, filter)) {
      expect_hit(*hit, *ray_cast(shape_of(*hit), pose_of(*hit), {p, way}), "ray");
      ++rays;
    }
    const Shape probe = make_box({0.3, 0.2});
    const Transform at{p, Rot::from_angle(unit(random))};
    if (const auto hit = w.shape_cast(probe, at, way, filter); hit && hit->t > 0) {
      expect_hit(*hit, *shape_cast(probe, at, way, shape_of(*hit), pose_of(*hit)), "shape");
      ++casts;
    }
    if (const auto hit = w.closest(p, 3, filter)) {
      expect_hit(*hit, closest_point(shape_of(*hit), pose_of(*hit), p), "closest");
      if (hit->distance > 0) {
        EXPECT_TRUE(w.closest(p, hit->distance, filter));
        EXPECT_FALSE(w.closest(p, std::nextafter(hit->distance, 0), filter));
      }
      ++nearest;
    }
    const Aabb box{p, p + Vec2{std::abs(way.x), std::abs(way.y)}};
    std::vector<std::uint32_t> found, all;
    for (const ShapeId id : w.shapes_in_box(box, filter)) found.push_back(id.index);
    for (std::uint32_t i = 0; i < shapes.size(); ++i) {
      if (may_collide(shapes[i].filter, filter) &&
          overlap(bounding_box(shapes[i].shape, w.pose(shapes[i].body)), box))
        all.push_back(i);
    }
    EXPECT_EQ(found, all) << "trial " << trial;
    in_boxes += static_cast<int>(all.size());
  }
  EXPECT_GT(std::min({rays, casts, nearest, in_boxes}), 30);
}

TEST(Queries, TakeNoBoxWithoutEndAndRaysOfNoLength) {
  World world;
  add(world, {0, 0}, smooth(make_disc(1)));
  for (const Aabb& box : {Aabb{{0, 0}, {INFINITY, 1}}, Aabb{{0, 0}, {1, NAN}}, Aabb{{-INFINITY, 0}, {1, 1}}})
    EXPECT_THROW(world.shapes_in_box(box), std::invalid_argument);
  EXPECT_TRUE(world.ray_cast({{-1, 0}, {1, 0}, 0}));
}

}  // namespace query_test
}  // namespace skerry
