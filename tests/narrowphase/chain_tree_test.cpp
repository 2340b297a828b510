// SPDX-License-Identifier: MIT
//
// Long chains: what the boxes around runs of segments leave out is never needed.
#include "physics/narrowphase/chain_tree.h"

#include <algorithm>
#include <gtest/gtest.h>

#include "physics/narrowphase/chain.h"
#include "physics/narrowphase/queries.h"
#include "physics/narrowphase/time_of_impact.h"
#include "tests/narrowphase/oracle.h"

namespace skerry {
namespace chain_tree_test {

using oracle::Scenes;

/// Terrain, a spiral, a scribble that crosses itself, and a flat stretch; any number of segments from 1 up.
Shape random_chain(Scenes& scenes) {
  const int n = 2 + scenes.below(scenes.below(3) == 0 ? 6 : 300);
  std::vector<Vec2> corners;
  const int kind = scenes.below(4);
  for (int i = 0; i < n; ++i) {
    const double t = 0.1 * i;
    switch (kind) {
      case 0:
        corners.push_back({t, scenes.uniform(-0.2, 0.2)});
        break;
      case 1:
        corners.push_back((1 + t) * Vec2{sin_cos(t).cos, sin_cos(t).sin});
        break;
      case 2:
        corners.push_back(5 * scenes.direction());
        break;
      default:
        corners.push_back({-t, 0});
    }
  }
  const Shape chain = make_chain(corners, n >= 3 && scenes.below(3) == 0);
  return scenes.below(3) == 0 ? translated(chain, 1e3 * scenes.direction()) : chain;
}

/// Every segment as a chain of its own.
std::vector<Shape> pieces(const Shape& chain) {
  std::vector<Shape> out;
  for (std::size_t i = 0; i < chain.normals.size(); ++i) {
    out.push_back(
        make_chain(std::vector<Vec2>{chain.vertices[i], chain.vertices[(i + 1) % chain.vertices.size()]}));
  }
  return out;
}

/// Does the segment meet the box? Clipped in long double [Liang, Barsky 1984].
bool meets(Vec2 p, Vec2 q, const Aabb& box) {
  long double enter = 0, leave = 1;
  const auto clip = [&](long double start, long double way, long double low, long double high) {
    if (way == 0) {
      if (start < low || start > high) leave = -1;
      return;
    }
    const long double first = (low - start) / way, last = (high - start) / way;
    enter = std::max(enter, std::min(first, last));
    leave = std::min(leave, std::max(first, last));
  };
  clip(p.x, static_cast<long double>(q.x) - p.x, box.lower.x, box.upper.x);
  clip(p.y, static_cast<long double>(q.y) - p.y, box.lower.y, box.upper.y);
  return enter <= leave;
}

Vec2 somewhere(Scenes& scenes, const Shape& chain) {
  const auto i = static_cast<std::size_t>(scenes.below(static_cast<int>(chain.vertices.size())));
  return chain.vertices[i] + scenes.uniform(0, 2) * scenes.direction();
}

TEST(ChainTree, FindsTheSegmentsThatBruteForceFinds) {
  const unsigned seed = 404;
  Scenes scenes(seed);
  int found = 0;
  for (int k = 0; k < test_scale(20000); ++k) {
    const Shape chain = random_chain(scenes);
    const Transform pose{scenes.below(2) == 0 ? Vec2{} : 1e6 * scenes.direction(),
                         Rot::from_angle(scenes.angle())};
    const Vec2 at = to_world(pose, somewhere(scenes, chain));
    Aabb box{at, at};
    // A point, a box of any size, or everything.
    if (scenes.below(4) != 0) box = grown(box, std::pow(10.0, scenes.uniform(-9, 2)));
    if (scenes.below(50) == 0) box = {{-kInfinity, -kInfinity}, {kInfinity, kInfinity}};
    std::vector<int> near, boxes;
    chain_segments_near(chain, pose, box, near);
    for (int i = 0; i < chain_segment_count(chain); ++i) {
      const Vec2 p = to_world(pose, chain.vertices[static_cast<std::size_t>(i)]);
      const Vec2 q = to_world(pose, chain.vertices[static_cast<std::size_t>(i + 1) % chain.vertices.size()]);
      const Aabb own{{std::min(p.x, q.x), std::min(p.y, q.y)}, {std::max(p.x, q.x), std::max(p.y, q.y)}};
      if (!overlap(own, box)) continue;
      boxes.push_back(i);
      // What really meets the box must be there; of what only its box does, some may be missing.
      if (meets(p, q, box)) {
        ASSERT_TRUE(std::binary_search(near.begin(), near.end(), i))
            << "segment " << i << " case " << k << " seed " << seed;
        ++found;
      }
    }
    ASSERT_TRUE(std::includes(boxes.begin(), boxes.end(), near.begin(), near.end()))
        << "case " << k << " seed " << seed;
    if (pose.q == Rot{}) {
      ASSERT_EQ(near, boxes) << "case " << k << " seed " << seed;
    }
  }
  EXPECT_GT(found, 10000);
}

TEST(ChainTree, LooksAtAFewBoxesOfAMillionSegments) {
  std::vector<Vec2> corners;
  Scenes scenes(1);
  const int count = 1000000;
  for (int i = 0; i <= count; ++i) corners.push_back({0.1 * i, scenes.uniform(-0.1, 0.1)});
  const Shape chain = make_chain(corners);
  for (int k = 0; k < 100; ++k) {
    const double x = scenes.uniform(0, 0.1 * count);
    const Aabb box{{x - 0.5, -1}, {x + 0.5, 1}};  // over 11 segments
    int boxes = 0, segments = 0;
    narrow::visit_segments(
        chain,
        [&](const Aabb& part) {
          ++boxes;
          return overlap(part, box);
        },
        [&](int) { ++segments; });
    // At most three leaves of 8 segments, and two paths of 17 levels with their siblings.
    EXPECT_LE(segments, 3 * 8);
    EXPECT_LE(boxes, 2 * 2 * 18);
  }
}

TEST(ChainTree, RaysDistancesAndFlightsAreThoseOfTheSegmentsOneByOne) {
  const unsigned seed = 405;
  Scenes scenes(seed);
  int rays = 0, flights = 0;
  for (int k = 0; k < test_scale(800); ++k) {
    const Shape chain = random_chain(scenes);
    const auto parts = pieces(chain);
    const Transform pose{10 * scenes.direction(), Rot::from_angle(scenes.angle())};
    const Vec2 from = to_world(pose, somewhere(scenes, chain)), to = to_world(pose, somewhere(scenes, chain));
    if (from == to) continue;
    const Ray ray{from, to - from, scenes.below(4) == 0 ? kInfinity : scenes.uniform(0, 3)};
    const auto hit = ray_cast(chain, pose, ray);
    double first = kInfinity;
    for (const Shape& part : parts) {
      if (const auto one = ray_cast(part, pose, ray)) first = std::min(first, one->t);
    }
    ASSERT_EQ(hit.has_value(), first < kInfinity) << "case " << k << " seed " << seed;
    if (hit) {
      ASSERT_NEAR(hit->t, first, 1e-11 * (1 + first)) << "case " << k << " seed " << seed;
    }
    rays += hit ? 1 : 0;

    const Shape other = scenes.shape(1);
    const Transform at{from, Rot::from_angle(scenes.angle())};
    const double near = distance(chain, pose, other, at).distance;
    double nearest = kInfinity;
    for (const Shape& part : parts) nearest = std::min(nearest, distance(part, pose, other, at).distance);
    ASSERT_NEAR(near, nearest, 1e-11) << "case " << k << " seed " << seed;

    // A start that touches may be on either side of a one-sided segment.
    if (near <= 0) continue;
    const Motion still{.p0 = pose.p, .angle0 = std::atan2(pose.q.s, pose.q.c)};
    Motion flight{.p0 = from, .angle0 = scenes.angle(), .v = to - from, .omega = scenes.uniform(-2, 2)};
    if (scenes.below(2) == 0) flight.a = {0, -9.81};
    const ImpactTime impact = time_of_impact(chain, still, other, flight, 1);
    double earliest = 1;
    bool any = false;
    for (int i = 0; i < chain_segment_count(chain); ++i) {
      const ImpactTime one = time_of_impact_chain_segment(chain, i, still, other, flight, 1);
      any = any || one.hit;
      earliest = std::min(earliest, one.t);
    }
    ASSERT_EQ(impact.hit, any) << "case " << k << " seed " << seed;
    // Where the approach is slow, a gap within rounding lasts: it is open at the one time and at the other.
    // What comes through a one-sided segment from behind is in it, and meets it at no certain time.
    const auto gap = [&](double t) { return distance(chain, still.at(t), other, flight.at(t)).distance; };
    const double slack = std::abs(impact.t - earliest);
    if (slack > 1e-12 && gap(earliest) > -1e-11) {
      ASSERT_LT(slack, 1e-5) << "case " << k << " seed " << seed;
      ASSERT_LT(gap(impact.t), 1e-11) << "case " << k << " seed " << seed;
    }
    flights += impact.hit ? 1 : 0;
  }
  EXPECT_GT(rays, 40);
  EXPECT_GT(flights, 40);
}

}  // namespace chain_tree_test
}  // namespace skerry
