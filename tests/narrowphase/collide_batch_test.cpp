// SPDX-License-Identifier: MIT
//
// Batches of pairs against the same pairs one by one, to the bit.
#include "physics/narrowphase/collide_batch.h"

#include <algorithm>
#include <cstring>
#include <gtest/gtest.h>
#include <vector>

#include "physics/narrowphase/collide.h"
#include "tests/narrowphase/oracle.h"

namespace skerry {
namespace collide_batch_test {

using oracle::Scenes;

bool same(double a, double b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}
bool same(Vec2 a, Vec2 b) {
  return same(a.x, b.x) && same(a.y, b.y);
}

/// Signs of zeros included.
bool same_bits(const Manifold& a, const Manifold& b) {
  if (a.count != b.count) return false;
  if (a.count > 0 && !same(a.normal, b.normal)) return false;
  for (int i = 0; i < a.count; ++i) {
    const auto &p = a.points[static_cast<std::size_t>(i)], &q = b.points[static_cast<std::size_t>(i)];
    if (!same(p.position, q.position) || !same(p.separation, q.separation) || p.feature != q.feature)
      return false;
  }
  return true;
}

/// Pairs with everything that a batch points to.
struct Batch {
  std::vector<Shape> a, b;
  std::vector<Transform> pose_a, pose_b;
  std::vector<double> margin;
  std::vector<SatCache> cache;
  std::vector<Manifold> manifold;

  void add(Shape shape_a, const Transform& at_a, Shape shape_b, const Transform& at_b, double m) {
    a.push_back(std::move(shape_a));
    b.push_back(std::move(shape_b));
    pose_a.push_back(at_a);
    pose_b.push_back(at_b);
    margin.push_back(m);
    cache.emplace_back();
    manifold.emplace_back();
  }
  void collide(void (*all)(const PairArrays&, NarrowPhaseStats*), bool cached, NarrowPhaseStats& stats) {
    std::vector<const Shape*> to_a, to_b;
    std::vector<SatCache*> to_cache;
    std::vector<Manifold*> to_manifold;
    for (std::size_t i = 0; i < a.size(); ++i) {
      to_a.push_back(&a[i]);
      to_b.push_back(&b[i]);
      to_cache.push_back(&cache[i]);
      to_manifold.push_back(&manifold[i]);
    }
    if (!cached) to_cache.clear();
    all({to_a, to_b, pose_a, pose_b, margin, to_cache, to_manifold}, &stats);
  }
  Manifold alone(std::size_t i, NarrowPhaseStats& stats) const {
    return skerry::collide(a[i], pose_a[i], b[i], pose_b[i], margin[i], nullptr, &stats);
  }
};

/// A rectangle of about this size: upright, turned, moved away from its body's origin, rounded, or thin.
Shape rectangle(Scenes& scenes, double size) {
  const Vec2 extent{size, size * (scenes.below(4) == 0 ? std::pow(10.0, scenes.uniform(-4, 0)) : 1.0)};
  const Vec2 centre = scenes.below(3) == 0 ? size * scenes.uniform(0, 2) * scenes.direction() : Vec2{};
  const double angle = scenes.below(3) == 0 ? scenes.angle() : 0;
  const double rounding = scenes.below(4) == 0 ? 0.2 * std::min(extent.x, extent.y) : 0;
  return make_box(extent, centre, angle, rounding);
}

/// Boxes on, beside and in each other as in stacks and grids: equal axes, touching faces, corners on corners.
void add_stacked(Scenes& scenes, Batch& batch) {
  const auto grid = [&] { return 0.25 * scenes.below(9) - 1.0; };
  const auto hair = [&] { return scenes.below(2) == 0 ? 0.0 : std::pow(10.0, scenes.uniform(-16, -6)); };
  const double quarter = kPi / 2 * scenes.below(4);
  const Shape box = make_box({1, 1}), wide = make_box({2, 0.5});
  const Vec2 base = scenes.below(2) == 0 ? Vec2{} : Vec2{grid(), 100 * grid()};
  batch.add(scenes.below(2) == 0 ? box : wide, {base, {}}, scenes.below(2) == 0 ? box : wide,
            {base + Vec2{grid() + hair(), grid() - hair()}, Rot::from_angle(quarter + hair())},
            scenes.below(2) == 0 ? 0 : 0.3);
}

void expect_same(Batch& batch, void (*all)(const PairArrays&, NarrowPhaseStats*), unsigned seed) {
  NarrowPhaseStats together, alone;
  batch.collide(all, false, together);
  int points = 0;
  for (std::size_t i = 0; i < batch.a.size(); ++i) {
    const Manifold one = batch.alone(i, alone);
    ASSERT_TRUE(same_bits(batch.manifold[i], one)) << "pair " << i << " seed " << seed;
    points += one.count;
  }
  EXPECT_EQ(together.pairs, alone.pairs);
  EXPECT_EQ(together.manifolds, alone.manifolds);
  EXPECT_GT(points, static_cast<int>(batch.a.size()) / 4);
  EXPECT_LT(alone.manifolds, batch.a.size());
}

TEST(CollideBatch, GivesTheBitsOfBoxesOneByOne) {
  const unsigned seed = 1234;
  Scenes scenes(seed);
  Batch batch;
  for (int k = 0; k < test_scale(40000); ++k) {
    if (scenes.below(3) == 0) {
      add_stacked(scenes, batch);
      continue;
    }
    const double size = scenes.size(), other = scenes.below(3) == 0 ? scenes.size() : size;
    const auto [pose_a, pose_b] = scenes.poses(size, other, 1e6);
    const double margin = scenes.below(2) == 0 ? 0 : scenes.uniform(0, 1) * size;
    batch.add(rectangle(scenes, size), pose_a, rectangle(scenes, other), pose_b, margin);
  }
  for (const narrow::BatchVersion& version : narrow::batch_versions()) {
    SCOPED_TRACE(version.name);
    expect_same(batch, version.boxes, seed);
  }
}

TEST(CollideBatch, GivesTheBitsOfDiscsOneByOne) {
  const unsigned seed = 1235;
  Scenes scenes(seed);
  Batch batch;
  for (int k = 0; k < test_scale(40000); ++k) {
    const double size = scenes.size(), other = scenes.below(3) == 0 ? scenes.size() : size;
    const auto disc = [&](double diameter) {
      return make_disc(0.5 * diameter, scenes.below(2) == 0 ? Vec2{} : 0.3 * diameter * scenes.direction());
    };
    const auto [pose_a, pose_b] = scenes.poses(size, other, 1e6);
    batch.add(disc(size), pose_a, disc(other), pose_b, scenes.below(2) == 0 ? 0 : 0.1 * size);
  }
  for (const narrow::BatchVersion& version : narrow::batch_versions()) {
    SCOPED_TRACE(version.name);
    expect_same(batch, version.discs, seed);
  }
}

TEST(CollideBatch, GivesTheBitsOfBoxesAndDiscsOnHalfPlanesOneByOne) {
  const unsigned seed = 1240;
  Scenes scenes(seed);
  Batch batch;
  for (int k = 0; k < test_scale(40000); ++k) {
    const double size = scenes.size();
    const Shape body =
        scenes.below(3) == 0
            ? make_disc(0.5 * size, scenes.below(2) == 0 ? Vec2{} : 0.3 * size * scenes.direction())
            : rectangle(scenes, size);
    auto [pose_a, pose_b] = scenes.poses(size, size, 1e6);
    Shape plane = make_half_plane(0.1 * size * scenes.direction(), scenes.direction());
    // Boxes that lie flat, or nearly, on level ground.
    if (scenes.below(3) == 0) {
      const double tilt = scenes.below(2) == 0 ? 0.0 : std::pow(10.0, scenes.uniform(-16, -3));
      plane = make_half_plane({0, 0.1 * size * scenes.uniform(-1, 1)}, {0, 1});
      pose_a.q = {};
      pose_b = {pose_a.p + size * Vec2{scenes.uniform(-1, 1), 0.5 * (1 + 0.1 * scenes.below(3))},
                Rot::from_angle(kPi / 2 * scenes.below(4) + tilt)};
    }
    double margin = scenes.below(2) == 0 ? 0 : scenes.uniform(0, 0.2) * size;
    // On a corner, with both edges of it in the same slope and their other ends in reach.
    if (scenes.below(10) == 0) {
      plane = make_half_plane({}, {0, 1});
      pose_a.q = {};
      pose_b.q = {std::sqrt(0.5), std::sqrt(0.5)};
      margin = 2 * size;
    }
    if (scenes.below(2) == 0) {
      batch.add(plane, pose_a, body, pose_b, margin);
    } else {
      batch.add(body, pose_b, plane, pose_a, margin);
    }
  }
  // Bodies too far away for squares of their distance meet nothing.
  batch.add(make_half_plane({}, {0, 1}), {}, make_disc(1), {{0, -1e101}, {}}, 0);
  for (const narrow::BatchVersion& version : narrow::batch_versions()) {
    SCOPED_TRACE(version.name);
    expect_same(batch, version.planes, seed);
  }
}

TEST(CollideBatch, GivesTheBitsOfBoxesWithDiscsOneByOne) {
  const unsigned seed = 1241;
  Scenes scenes(seed);
  Batch batch;
  for (int k = 0; k < test_scale(40000); ++k) {
    const double size = scenes.size(), other = scenes.below(3) == 0 ? scenes.size() : size;
    Shape box = rectangle(scenes, size);
    const Shape disc =
        make_disc(0.5 * other, scenes.below(2) == 0 ? Vec2{} : 0.3 * other * scenes.direction());
    auto [pose_a, pose_b] = scenes.poses(size, other, 1e6);
    double margin = scenes.below(2) == 0 ? 0 : scenes.uniform(0, 0.2) * size;
    // On a corner, on the line of an edge beyond its end, in the middle, or on a face, with or without a
    // hair.
    if (scenes.below(3) == 0) {
      box = make_box({size, size}, {}, 0, scenes.below(2) == 0 ? 0 : 0.1 * size);
      const double hair = scenes.below(2) == 0 ? 0.0 : size * std::pow(10.0, scenes.uniform(-16, -6));
      const auto grid = [&] { return 0.25 * (scenes.below(9) - 4) * size; };
      pose_a.q = Rot::from_angle(kPi / 2 * scenes.below(4));
      pose_b.p = pose_a.p + Vec2{grid() + hair, grid() - hair};
      margin = scenes.below(2) == 0 ? 0 : 2 * size;
    }
    if (scenes.below(2) == 0) {
      batch.add(box, pose_a, disc, pose_b, margin);
    } else {
      batch.add(disc, pose_b, box, pose_a, margin);
    }
  }
  // Bodies too far away for squares of their distance meet nothing.
  batch.add(make_box({1, 1}), {}, make_disc(1), {{0, -1e101}, {}}, 0);
  for (const narrow::BatchVersion& version : narrow::batch_versions()) {
    SCOPED_TRACE(version.name);
    expect_same(batch, version.boxes_and_discs, seed);
  }
}

TEST(CollideBatch, MirrorsExactlyWhenTheShapesAreExchanged) {
  const unsigned seed = 1236;
  Scenes scenes(seed);
  Batch batch;
  for (int k = 0; k < test_scale(20000); ++k) {
    const double size = scenes.size();
    const auto [pose_a, pose_b] = scenes.poses(size, size, 1e6);
    // Equal boxes in one place have no order.
    if (pose_a.p != pose_b.p) batch.add(rectangle(scenes, size), pose_a, rectangle(scenes, size), pose_b, 0);
  }
  NarrowPhaseStats stats;
  batch.collide(collide_boxes, false, stats);
  Batch swapped;
  for (std::size_t i = 0; i < batch.a.size(); ++i)
    swapped.add(batch.b[i], batch.pose_b[i], batch.a[i], batch.pose_a[i], 0);
  swapped.collide(collide_boxes, false, stats);
  for (std::size_t i = 0; i < batch.a.size(); ++i) {
    const Manifold &m = batch.manifold[i], w = mirrored(swapped.manifold[i]);
    ASSERT_EQ(m.count, w.count) << "pair " << i << " seed " << seed;
    for (int j = 0; j < m.count; ++j) {
      const auto &p = m.points[static_cast<std::size_t>(j)], &q = w.points[static_cast<std::size_t>(j)];
      ASSERT_TRUE(m.normal == w.normal && p.position == q.position && p.separation == q.separation &&
                  p.feature == q.feature)
          << "pair " << i << " seed " << seed;
    }
  }
}

TEST(CollideBatch, GivesTheSameBitsInEveryOrderAndNumberOfPairs) {
  const unsigned seed = 1237;
  Scenes scenes(seed);
  Batch batch;
  for (int k = 0; k < 100; ++k) add_stacked(scenes, batch);
  NarrowPhaseStats stats;
  batch.collide(collide_boxes, false, stats);
  for (std::size_t from = 0; from + 7 < batch.a.size(); ++from) {
    Batch part;
    for (std::size_t i = from + 1 + from % 7; i > from; --i)
      part.add(batch.a[i], batch.pose_a[i], batch.b[i], batch.pose_b[i], batch.margin[i]);
    part.collide(collide_boxes, false, stats);
    for (std::size_t i = 0; i < part.a.size(); ++i)
      ASSERT_TRUE(same_bits(part.manifold[i], batch.manifold[from + part.a.size() - i])) << from << " " << i;
  }
}

TEST(CollideBatch, SkipsPairsThatItKnowsToBeApartAndNeverAnother) {
  const unsigned seed = 1238;
  Scenes scenes(seed);
  Batch batch;
  std::vector<Vec2> velocity;
  std::vector<double> spin, angle;
  const int count = test_scale(500);
  for (int k = 0; k < count; ++k) {
    const auto [pose_a, pose_b] = scenes.poses(1, 1, 0);
    batch.add(rectangle(scenes, 1), pose_a, rectangle(scenes, 1), pose_b, 0.02);
    const double pace = std::pow(10.0, scenes.uniform(-6, -1));
    velocity.push_back(pace * scenes.direction());
    spin.push_back(scenes.below(2) == 0 ? 0 : pace * scenes.uniform(-1, 1));
    angle.push_back(scenes.angle());
  }
  NarrowPhaseStats stats, alone;
  for (int step = 0; step < 40; ++step) {
    batch.collide(collide_boxes, true, stats);
    for (std::size_t i = 0; i < batch.a.size(); ++i) {
      const Manifold one = batch.alone(i, alone);
      ASSERT_TRUE(same_bits(batch.manifold[i], one)) << "pair " << i << " step " << step << " seed " << seed;
      // One by one with what the batch left behind, too.
      if (i % 3 == 0) {
        SatCache copy = batch.cache[i];
        const Manifold next =
            collide(batch.a[i], batch.pose_a[i], batch.b[i], batch.pose_b[i], batch.margin[i], &copy);
        ASSERT_TRUE(same_bits(next, one)) << "pair " << i << " step " << step << " seed " << seed;
      }
      batch.pose_b[i].p += velocity[i];
      angle[i] += spin[i];
      batch.pose_b[i].q = Rot::from_angle(angle[i]);
      batch.pose_a[i].p += 0.3 * velocity[i];
    }
  }
  EXPECT_EQ(stats.pairs, alone.pairs);
  EXPECT_EQ(stats.manifolds, alone.manifolds);
  EXPECT_GT(stats.axes_skipped, stats.axes_tested / 10);
}

TEST(CollideBatch, TakesOtherShapesOneByOne) {
  const unsigned seed = 1239;
  Scenes scenes(seed);
  for (const auto all : {collide_boxes, collide_discs, collide_half_planes, collide_boxes_and_discs}) {
    Batch batch;
    for (int k = 0; k < 2000; ++k) {
      const auto [pose_a, pose_b] = scenes.poses(1, 1, 0);
      batch.add(scenes.shape(1), pose_a, scenes.shape(1), pose_b, 0);
    }
    expect_same(batch, all, seed);
  }
}

}  // namespace collide_batch_test
}  // namespace skerry
