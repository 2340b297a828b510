// SPDX-License-Identifier: MIT
//
// Manifolds against the brute-force oracle, and the symmetries that they keep.
#include <cstring>
#include <gtest/gtest.h>

#include "physics/narrowphase/collide.h"
#include "physics/narrowphase/queries.h"
#include "tests/narrowphase/oracle.h"

namespace skerry {
namespace collide_oracle_test {

using oracle::Scenes;

bool same_bits(const Manifold& a, const Manifold& b) {
  if (a.count != b.count) return false;
  if (a.count > 0 && a.normal != b.normal) return false;
  for (int i = 0; i < a.count; ++i) {
    const auto &p = a.points[static_cast<std::size_t>(i)], &q = b.points[static_cast<std::size_t>(i)];
    if (p.position != q.position || p.separation != q.separation || p.feature != q.feature) return false;
  }
  return true;
}

double deepest(const Manifold& m) {
  double low = kInfinity;
  for (int i = 0; i < m.count; ++i) low = std::min(low, m.points[static_cast<std::size_t>(i)].separation);
  return low;
}

TEST(Collide, AgreesWithMinkowskiDifferenceInLongDouble) {
  const unsigned seed = 4711;
  Scenes scenes(seed);
  long double worst = 0;
  int touching = 0, apart = 0;
  const int count = test_scale(100000);
  for (int k = 0; k < count; ++k) {
    const double size_a = scenes.size();
    const double size_b = scenes.below(5) == 0 ? scenes.size() : size_a * scenes.uniform(0.3, 3);
    const Shape a = scenes.shape(size_a), b = scenes.shape(size_b);
    const auto [pose_a, pose_b] = scenes.poses(size_a, size_b, 1e6);
    const double margin = 10 * (size_a + size_b);
    const Manifold m = collide(a, pose_a, b, pose_b, margin);
    const oracle::Distance truth = oracle::brute_force(a, pose_a, b, pose_b);
    ASSERT_GE(m.count, 1) << "case " << k << " seed " << seed;
    const long double error = std::abs(deepest(m) - truth.distance);
    (truth.distance > 0 ? apart : touching) += 1;
    worst = std::max(worst, error / truth.scale);
    // Roundings of the coordinates and the bias between equal axes, and so 1e-12 of any distance that is not
    // tiny beside them.
    ASSERT_LE(error, 3e-14L * truth.scale)
        << "case " << k << " seed " << seed << " distance " << truth.distance << " scale " << truth.scale;
    // The normal is as good as the distance that it comes from, or as the lead over the next axis; where two
    // axes tie to rounding either is right.
    if (truth.clearance > 1e-2L * truth.scale) {
      const oracle::Point normal{m.normal.x, m.normal.y};
      const long double sine = std::abs(oracle::cross(truth.normal, normal));
      const long double lost = truth.core - oracle::separation_along(a, pose_a, b, pose_b, normal);
      ASSERT_TRUE(sine <= 1e-12L || lost <= 1e-15L * truth.scale)
          << "case " << k << " seed " << seed << " sine " << sine << " lost " << lost;
      ASSERT_GT(oracle::dot(normal, truth.normal), 0) << "case " << k << " seed " << seed;
    }
    ASSERT_NEAR(length(m.normal), 1, 1e-15 * 4);
  }
  EXPECT_GT(touching, count / 4);
  EXPECT_GT(apart, count / 20);
  RecordProperty("worst_relative_error", std::to_string(static_cast<double>(worst)));
  std::printf("worst error relative to the coordinates: %.2Lg (%d touching, %d apart)\n", worst, touching,
              apart);
}

TEST(Collide, FindsTinyDistancesOfShapesOfEqualSizeToTwelveDigits) {
  const unsigned seed = 99;
  Scenes scenes(seed);
  for (int k = 0; k < test_scale(20000); ++k) {
    const double size = std::pow(10.0, scenes.uniform(-6, 6));
    const Shape a = scenes.shape(size), b = scenes.shape(size);
    const auto [pose_a, pose_b] = scenes.poses(size, size, 1e6 * size);
    const Manifold m = collide(a, pose_a, b, pose_b, 100 * size);
    const oracle::Distance truth = oracle::brute_force(a, pose_a, b, pose_b);
    if (std::abs(truth.distance) < 1e-2L * truth.scale) continue;
    ASSERT_NEAR(static_cast<double>(deepest(m) / truth.distance), 1, 1e-12)
        << "case " << k << " seed " << seed;
  }
}

TEST(Collide, MirrorsExactlyWhenTheShapesAreExchanged) {
  const unsigned seed = 7;
  Scenes scenes(seed);
  int points = 0;
  for (int k = 0; k < test_scale(100000); ++k) {
    const double size = scenes.size();
    const Shape a = scenes.shape(size);
    const Shape b = scenes.below(3) == 0 ? a : scenes.shape(size);
    const auto [pose_a, pose_b] = scenes.poses(size, size, 1e6);
    if (a == b && pose_a.p == pose_b.p && pose_a.q.c == pose_b.q.c && pose_a.q.s == pose_b.q.s) continue;
    const double margin = scenes.below(2) == 0 ? 0 : 0.1 * size;
    const Manifold m = collide(a, pose_a, b, pose_b, margin), w = collide(b, pose_b, a, pose_a, margin);
    ASSERT_TRUE(same_bits(m, mirrored(w))) << "case " << k << " seed " << seed;
    points += m.count;
  }
  EXPECT_GT(points, 1000);
}

TEST(Collide, IsTheSameInAMovedAndTurnedScene) {
  const unsigned seed = 8;
  Scenes scenes(seed);
  for (int k = 0; k < test_scale(30000); ++k) {
    const Shape a = scenes.shape(1), b = scenes.shape(scenes.uniform(0.5, 2));
    const auto [pose_a, pose_b] = scenes.poses(1, 1, 0);
    const oracle::Distance truth = oracle::brute_force(a, pose_a, b, pose_b);
    if (truth.clearance < 1e-3L) continue;
    const Rot turn = Rot::from_angle(scenes.uniform(-4, 4));
    const Vec2 shift = 10 * scenes.direction();
    const auto moved = [&](const Transform& t) { return Transform{shift + rotate(turn, t.p), turn * t.q}; };
    const Manifold m = collide(a, pose_a, b, pose_b, 0.05),
                   w = collide(a, moved(pose_a), b, moved(pose_b), 0.05);
    if (std::abs(truth.distance - 0.05L) < 1e-12L) continue;
    ASSERT_EQ(m.count > 0, w.count > 0) << "case " << k << " seed " << seed;
    if (m.count == 0) continue;
    ASSERT_NEAR(deepest(m), deepest(w), 1e-13);
    ASSERT_NEAR(length(rotate(turn, m.normal) - w.normal), 0, 1e-11) << "case " << k << " seed " << seed;
  }
}

TEST(Collide, GivesTheSameBitsWithAndWithoutACache) {
  const unsigned seed = 21;
  Scenes scenes(seed);
  NarrowPhaseStats with, without;
  for (int k = 0; k < test_scale(2000); ++k) {
    const Shape a = scenes.shape(1), b = scenes.below(3) == 0 ? a : scenes.shape(1);
    auto [pose_a, pose_b] = scenes.poses(1, 1, 0);
    double angle_a = scenes.angle(), angle_b = scenes.below(2) == 0 ? angle_a : scenes.angle();
    const double pace = std::pow(10.0, scenes.uniform(-8, -1));
    const Vec2 v = pace * scenes.direction();
    const double w = scenes.below(2) == 0 ? 0 : pace * scenes.uniform(-1, 1);
    // The first moves, too, and both may be far away.
    const double spin = scenes.below(2) == 0 ? 0 : pace * scenes.uniform(-1, 1);
    const Vec2 drift = scenes.below(2) == 0 ? Vec2{} : pace * scenes.direction();
    const double margin = scenes.below(2) == 0 ? 0.01 : 0.3;
    SatCache cache;
    for (int step = 0; step < 30; ++step) {
      pose_a.q = Rot::from_angle(angle_a);
      pose_b.q = Rot::from_angle(angle_b);
      const Manifold plain = collide(a, pose_a, b, pose_b, margin, nullptr, &without);
      const Manifold cached = collide(a, pose_a, b, pose_b, margin, &cache, &with);
      ASSERT_TRUE(same_bits(plain, cached)) << "case " << k << " step " << step << " seed " << seed;
      pose_a.p += drift;
      pose_b.p += v;
      angle_a += spin;
      angle_b += w;
    }
  }
  EXPECT_LT(with.axes_tested, without.axes_tested / 2);
  EXPECT_GT(with.axes_skipped, with.axes_tested);
}

TEST(Collide, KeepsFeaturesWhileAStackTrembles) {
  // Boxes in an aligned stack, moved by less than the solver leaves: same ids, same order.
  const Shape box = make_box({1, 1}), wide = make_box({3, 0.5});
  Scenes scenes(5);
  for (const Shape* upper : {&box, &wide}) {
    const double height = upper == &box ? 1.0 : 0.75;
    const Manifold rest = collide(box, {{0, 0}, {}}, *upper, {{0, height}, {}}, 0.005);
    ASSERT_EQ(rest.count, 2);
    for (int k = 0; k < 1000; ++k) {
      const Vec2 jitter{scenes.uniform(-1e-9, 1e-9), scenes.uniform(-1e-9, 1e-9)};
      const Transform pose{Vec2{0, height} + jitter, Rot::from_angle(scenes.uniform(-1e-9, 1e-9))};
      const Manifold m = collide(box, {{0, 0}, {}}, *upper, pose, 0.005);
      ASSERT_EQ(m.count, 2);
      for (std::size_t i = 0; i < 2; ++i) {
        ASSERT_EQ(m.points[i].feature, rest.points[i].feature);
        ASSERT_NEAR(length(m.points[i].position - rest.points[i].position), 0, 1e-8);
      }
    }
  }
}

/// Upright boxes on a grid, moved by hairs.
Manifold boxes_on_a_grid(Scenes& scenes, const Shape& a, const Shape& b, double margin, Transform& pose_b) {
  const auto hair = [&] { return (scenes.below(2) == 0 ? 1 : -1) * std::pow(10.0, scenes.uniform(-16, -6)); };
  const Vec2 offset{0.25 * scenes.below(9) - 1.0 + hair(), 0.25 * scenes.below(9) - 1.0 + hair()};
  pose_b = {offset, Rot::from_angle(kPi / 2 * scenes.below(4) + (scenes.below(2) == 0 ? hair() : 0))};
  return collide(a, {}, b, pose_b, margin);
}

TEST(Collide, PointsLieBetweenTheSurfacesWhereEdgesMeetAtTheirEnds) {
  const unsigned seed = 77;
  Scenes scenes(seed);
  const Shape boxes[] = {make_box({1, 1}), make_box({2, 0.5}), make_box({0.5, 1})};
  int points = 0;
  for (int k = 0; k < test_scale(40000); ++k) {
    const Shape &a = boxes[scenes.below(3)], &b = boxes[scenes.below(3)];
    Transform pose_b;
    const Manifold m = boxes_on_a_grid(scenes, a, b, scenes.below(2) == 0 ? 0 : 0.02, pose_b);
    for (int i = 0; i < m.count; ++i) {
      const ManifoldPoint& point = m.points[static_cast<std::size_t>(i)];
      if (point.separation < -1e-5) continue;
      const double most = 0.5 * std::max(0.0, point.separation) + 1e-5;
      ASSERT_LE(closest_point(a, {}, point.position).distance, most) << "pair " << k << " seed " << seed;
      ASSERT_LE(closest_point(b, pose_b, point.position).distance, most) << "pair " << k << " seed " << seed;
      ++points;
    }
  }
  EXPECT_GT(points, test_scale(10000));
}

TEST(Collide, KeepsOnePointAndItsFeatureWhereCornersTremble) {
  const Shape box = make_box({1, 1});
  Scenes scenes(6);
  for (const Vec2 offset : {Vec2{1, 1}, Vec2{-1, 1}, Vec2{-1, -1}, Vec2{1, -1}}) {
    const Manifold rest = collide(box, {}, box, {offset, {}}, 0.005);
    ASSERT_EQ(rest.count, 1);
    for (int k = 0; k < 2000; ++k) {
      const double size = std::pow(10.0, scenes.uniform(-16, -8));
      const Vec2 jitter = size * Vec2{scenes.uniform(-1, 1), scenes.uniform(-1, 1)};
      const Manifold m = collide(box, {}, box, {offset + jitter, {}}, 0.005);
      ASSERT_EQ(m.count, 1) << jitter.x << ' ' << jitter.y;
      ASSERT_EQ(m.points[0].feature, rest.points[0].feature) << jitter.x << ' ' << jitter.y;
      ASSERT_NEAR(length(m.points[0].position - 0.5 * offset), 0, 1e-7);
    }
  }
}

TEST(Collide, SettledPairsTestTwoAxesAndSeparatedPairsOneOrNone) {
  const Shape box = make_box({1, 1});
  SatCache cache;
  NarrowPhaseStats stats;
  collide(box, {{0, 0}, {}}, box, {{0.1, 1}, {}}, 0.005, &cache, &stats);
  stats = {};
  collide(box, {{0, 0}, {}}, box, {{0.1, 1 + 1e-9}, {}}, 0.005, &cache, &stats);
  EXPECT_EQ(stats.axes_tested, 2u);
  EXPECT_EQ(stats.axes_skipped, 6u);
  cache = {};
  collide(box, {{0, 0}, {}}, box, {{0.1, 1.5}, {}}, 0.005, &cache, &stats);
  stats = {};
  EXPECT_EQ(collide(box, {{0, 0}, {}}, box, {{0.2, 1.4}, {}}, 0.005, &cache, &stats).count, 0);
  EXPECT_EQ(stats.axes_tested, 1u);
  EXPECT_EQ(stats.axes_skipped, 7u);
  // While it moves by less than what is to spare, not even that one.
  stats = {};
  EXPECT_EQ(collide(box, {{0, 0}, {}}, box, {{0.3, 1.35}, {}}, 0.005, &cache, &stats).count, 0);
  EXPECT_EQ(stats.axes_tested, 0u);
  EXPECT_EQ(stats.axes_skipped, 8u);
}

}  // namespace collide_oracle_test
}  // namespace skerry
