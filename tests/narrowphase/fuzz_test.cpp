// SPDX-License-Identifier: MIT
//
// Random bytes as shapes and poses: whatever the constructors accept must give finite answers in finite time.
#include <cstring>
#include <gtest/gtest.h>

#include "physics/narrowphase/chain.h"
#include "physics/narrowphase/collide.h"
#include "physics/narrowphase/queries.h"
#include "physics/narrowphase/time_of_impact.h"
#include "tests/narrowphase/oracle.h"

namespace skerry {
namespace fuzz_test {

/// Doubles of all kinds: raw bit patterns, special values, small integers, nearly equal ones.
class Bytes {
 public:
  explicit Bytes(unsigned seed) : random_(seed) {}
  int below(int n) { return static_cast<int>(random_() % static_cast<std::uint64_t>(n)); }
  double number() {
    static const double special[] = {
        0,      -0.0, 1,    -1,    0.5,     1e-300,    1e300,      5e-324,
        1e-9,   1e9,  1e12, 1e-12, 2.2e-16, kInfinity, -kInfinity, std::numeric_limits<double>::quiet_NaN(),
        1.7e308};
    switch (below(8)) {
      case 0: {
        const std::uint64_t bits = random_();
        double value;
        std::memcpy(&value, &bits, sizeof value);
        return value;
      }
      case 1:
        return special[below(static_cast<int>(std::size(special)))];
      case 2:
        return last_ * (1 + 2.2e-16 * (below(5) - 2));
      default:
        return last_ = static_cast<double>(below(33) - 16) / 8 * (below(4) == 0 ? 1e-7 : 1);
    }
  }
  Vec2 vec() {
    const double x = number();
    return {x, number()};
  }
  Transform pose() { return {vec(), Rot::from_angle(number())}; }
  Motion motion() {
    Motion m;
    m.p0 = vec();
    m.angle0 = number();
    m.v = vec();
    m.omega = number();
    if (below(2) == 0) m.a = vec();
    if (below(4) == 0) m.alpha = number();
    return m;
  }
  /// Made from random bytes; empty if refused.
  std::optional<Shape> shape() {
    try {
      switch (below(7)) {
        case 0:
          return make_disc(number(), vec());
        case 1:
          return make_capsule(vec(), vec(), number());
        case 2:
          return make_half_plane(vec(), vec());
        case 3:
          return make_box(vec(), vec(), number(), below(2) == 0 ? 0 : number());
        case 4:
          return make_chain(corners(2 + below(5)), below(2) == 0);
        default: {
          auto list = corners(3 + below(3));
          // Random corners are seldom convex: turn them around their middle.
          if (below(2) == 0) {
            Vec2 middle;
            for (const Vec2 v : list) middle += v / static_cast<double>(list.size());
            std::sort(list.begin(), list.end(), [&](Vec2 a, Vec2 b) {
              return std::atan2(a.y - middle.y, a.x - middle.x) < std::atan2(b.y - middle.y, b.x - middle.x);
            });
          }
          return make_polygon(list, below(2) == 0 ? 0 : std::abs(number()));
        }
      }
    } catch (const std::invalid_argument&) {
      return std::nullopt;
    }
  }

 private:
  std::vector<Vec2> corners(int n) {
    std::vector<Vec2> out(static_cast<std::size_t>(n));
    for (Vec2& corner : out) corner = vec();
    return out;
  }
  std::mt19937_64 random_;
  double last_ = 1;
};

bool is_finite(const Transform& t) {
  return skerry::is_finite(t.p) && std::isfinite(t.q.c) && std::isfinite(t.q.s);
}

void expect_finite(const Manifold& m, int k) {
  ASSERT_GE(m.count, 0);
  ASSERT_LE(m.count, 2);
  for (int i = 0; i < m.count; ++i) {
    const auto& p = m.points[static_cast<std::size_t>(i)];
    ASSERT_TRUE(is_finite(p.position)) << k;
    ASSERT_TRUE(std::isfinite(p.separation)) << k;
  }
  if (m.count > 0) {
    ASSERT_NEAR(length(m.normal), 1, 1e-9) << k;
  }
}

TEST(Fuzz, RandomBytesGiveFiniteAnswersInFiniteTime) {
  const unsigned seed = 20261121;
  Bytes bytes(seed);
  int pairs = 0, hits = 0;
  for (int k = 0; k < test_scale(60000); ++k) {
    const auto a = bytes.shape(), b = bytes.shape();
    const Transform pose_a = bytes.pose(), pose_b = bytes.pose();
    const Motion motion_a = bytes.motion(), motion_b = bytes.motion();
    const Vec2 point = bytes.vec(), direction = bytes.vec();
    const double margin = std::abs(bytes.number()), t_max = std::abs(bytes.number());
    if (!a || !b) continue;
    ++pairs;
    const bool chain = a->kind == ShapeKind::Chain || b->kind == ShapeKind::Chain;
    // Beyond that the middle of two places is no number.
    const auto has_middle = [](const Transform& pose) {
      return is_finite(pose) && std::max(std::abs(pose.p.x), std::abs(pose.p.y)) < 8e307;
    };
    if (has_middle(pose_a) && has_middle(pose_b)) {
      const double usable_margin = margin <= 1e12 ? margin : 0.01;
      if (!chain) expect_finite(collide(*a, pose_a, *b, pose_b, usable_margin), k);
      for (int i = 0; i < chain_segment_count(*a); ++i) {
        expect_finite(collide_chain_segment(*a, i, pose_a, *b, pose_b, usable_margin), k);
      }
      try {
        const ClosestPoints c = distance(*a, pose_a, *b, pose_b);
        const double size = length(pose_a.p) + length(pose_b.p);
        if (size < 1e100) {
          ASSERT_TRUE(std::isfinite(c.distance)) << k;
        }
      } catch (const std::invalid_argument&) {
      }
      try {
        const auto hit = ray_cast(*a, pose_a, {point, direction, margin});
        if (hit) {
          ASSERT_TRUE(hit->t >= 0 && hit->t <= margin) << k;
        }
      } catch (const std::invalid_argument&) {
      }
    }
    try {
      const ImpactTime impact = time_of_impact(*a, motion_a, *b, motion_b, t_max);
      ASSERT_TRUE(impact.t >= 0 && impact.t <= t_max) << k;
      hits += impact.hit ? 1 : 0;
    } catch (const std::invalid_argument&) {
    }
    if (::testing::Test::HasFatalFailure()) return;
  }
  EXPECT_GT(pairs, 1000);
  EXPECT_GT(hits, 10);
}

}  // namespace fuzz_test
}  // namespace skerry
