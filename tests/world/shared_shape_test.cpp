// SPDX-License-Identifier: MIT
//
// Equal shapes of a world are one.
#include "physics/shared_shape.h"

#include <array>
#include <gtest/gtest.h>
#include <set>

#include "physics/snapshot.h"
#include "physics/world.h"

namespace skerry {
namespace shared_shape_test {

std::set<const Shape*> shapes_of(const World& world) {
  std::set<const Shape*> all;
  for (const ShapeRecord& record : world.shapes())
    if (record.alive) all.insert(&*record.shape);
  return all;
}

BodyId add(World& world, const Shape& shape, Vec2 at) {
  const BodyId body = world.create_body({.type = BodyType::Dynamic, .position = at});
  world.add_shape(body, {.shape = shape, .density = 1});
  return body;
}

TEST(SharedShape, EmptyOnesHaveNoCorners) {
  const SharedShape shape;
  EXPECT_TRUE(shape->vertices.empty());
  EXPECT_EQ(&*shape, &*SharedShape());
}

TEST(SharedShape, EqualShapesAreOneWhateverBodyTheyAreOf) {
  World world;
  for (int i = 0; i < 10; ++i) {
    add(world, make_box({1, 0.5}), {2.0 * i, 0});
    add(world, make_disc(0.25), {2.0 * i, 3});
    // Off its body's origin: the same about the centre of mass.
    add(world, make_disc(0.25, {0.5, 0}), {2.0 * i, 6});
  }
  EXPECT_EQ(shapes_of(world).size(), 2u);
}

TEST(SharedShape, ShapesThatDifferInABitAreTwo) {
  ShapePool pool;
  SharedShape a(make_disc(1, {0.0, 0})), b(make_disc(1, {-0.0, 0})), c(make_disc(std::nextafter(1.0, 2.0)));
  SharedShape again(make_disc(1, {0.0, 0}));
  EXPECT_EQ(*a, *b);
  for (SharedShape* shape : {&a, &b, &c, &again}) pool.share(*shape);
  EXPECT_EQ(pool.size(), 3u);
  EXPECT_EQ(&*a, &*again);
  EXPECT_NE(&*a, &*b);
}

TEST(SharedShape, OfOneHashWithOthersAreThemselves) {
  // Only corners and radius are hashed.
  Shape plain = make_box({1, 1}), other = plain;
  other.rectangle = {};
  ShapePool pool;
  SharedShape a(plain), b(other), c(plain);
  for (SharedShape* shape : {&a, &b, &c}) pool.share(*shape);
  EXPECT_EQ(*a, plain);
  EXPECT_EQ(*b, other);
  EXPECT_EQ(*c, plain);
}

TEST(SharedShape, PoolForgetsWhatNobodyHas) {
  ShapePool pool;
  SharedShape kept(make_disc(2));
  pool.share(kept);
  for (int i = 0; i < 10000; ++i) {
    SharedShape passing(make_disc(1 + 1e-3 * i));
    pool.share(passing);
  }
  EXPECT_LE(pool.size(), 2u);
  SharedShape again(make_disc(2));
  pool.share(again);
  EXPECT_EQ(&*kept, &*again);
}

TEST(SharedShape, RemovingOneLeavesTheOthers) {
  World world;
  std::array<BodyId, 3> bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    bodies[i] = add(world, make_box({1, 1}), {2.0 * static_cast<double>(i), 0});
  world.destroy(bodies[0]);
  // A second shape moves the first one to the new centre of mass.
  world.add_shape(bodies[1], {.shape = make_disc(0.1, {2, 0}), .density = 1});
  const Shape box = make_box({1, 1});
  int boxes = 0;
  for (const ShapeRecord& record : world.shapes()) boxes += record.alive && *record.shape == box;
  EXPECT_EQ(boxes, 1);
  EXPECT_EQ(shapes_of(world).size(), 3u);
}

TEST(SharedShape, SnapshotsShareAgain) {
  World world;
  for (int i = 0; i < 5; ++i) add(world, make_box({1, 1}), {2.0 * i, 0});
  const World loaded = load_snapshot(save_snapshot(world));
  EXPECT_EQ(shapes_of(loaded).size(), 1u);
}

}  // namespace shared_shape_test
}  // namespace skerry
