// SPDX-License-Identifier: MIT
//
// Limit loads against the literature: Livesley's method on arches, overhangs and walls.
#include "physics/statics/limit_load.h"

#include <cmath>
#include <gtest/gtest.h>
#include <stdexcept>

namespace skerry::statics::test {
namespace limit_load_test {

/// Blocks and the contacts between them, in the shape of a contact problem.
struct Blocks {
  IslandSystem system;
  BodyLoads weight;

  /// A block of unit weight per area. @return its number
  int add(const std::vector<Vec2>& corners) {
    double area = 0;
    Vec2 centre{};
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vec2 p = corners[i], q = corners[(i + 1) % corners.size()];
      area += 0.5 * cross(p, q);
      centre += cross(p, q) / 6 * (p + q);
    }
    system.bodies.push_back({1, 1});
    system.positions.push_back(centre / area);
    weight.push_back({0, -area, 0});
    return static_cast<int>(system.bodies.size()) - 1;
  }
  int add_box(Vec2 low, Vec2 high) { return add({low, {high.x, low.y}, high, {low.x, high.y}}); }

  /// A contact point; the normal points from a (-1: the ground) to b.
  void touch(int a, int b, Vec2 at, Vec2 normal, double mu) {
    Row row;
    row.a = a;
    row.b = b;
    const auto along = [&](Vec2 d) {
      if (a >= 0) row.Ja = {-d.x, -d.y, -cross(at - system.positions[static_cast<std::size_t>(a)], d)};
      if (b >= 0) row.Jb = {d.x, d.y, cross(at - system.positions[static_cast<std::size_t>(b)], d)};
    };
    along(normal);
    row.source = system.rows.size();
    system.rows.push_back(row);
    system.b.push_back(0);
    if (!(mu > 0)) return;
    row.normal = static_cast<int>(system.rows.size()) - 1;
    row.kind = RowKind::Friction;
    row.mu = mu;
    row.lower = -kInfinity;
    along(perp(normal));
    row.source = system.rows.size();
    system.rows.push_back(row);
    system.b.push_back(0);
  }
  /// A joint along a segment: both its ends.
  void join(int a, int b, Vec2 from, Vec2 to, Vec2 normal, double mu) {
    touch(a, b, from, normal, mu);
    touch(a, b, to, normal, mu);
  }
};

/// Semicircle of mean radius 1 with n voussoirs between radial joints, straight inner and outer edges.
Blocks arch(int n, double thickness) {
  Blocks blocks;
  const double inner = 1 - 0.5 * thickness, outer = 1 + 0.5 * thickness;
  const auto direction = [&](int i) { return Vec2{std::cos(kPi * i / n), std::sin(kPi * i / n)}; };
  for (int i = 0; i < n; ++i)
    blocks.add(
        {inner * direction(i), outer * direction(i), outer * direction(i + 1), inner * direction(i + 1)});
  for (int i = 0; i <= n; ++i) {
    const int before = i == 0 ? -1 : i - 1, after = i == n ? -1 : i;
    blocks.join(before, after, inner * direction(i), outer * direction(i), perp(direction(i)), 1);
  }
  return blocks;
}

/// The same with curved edges: sectors, whose weight lies farther out.
Blocks arch_of_sectors(int n, double thickness) {
  Blocks blocks;
  const double inner = 1 - 0.5 * thickness, outer = 1 + 0.5 * thickness, half = 0.5 * kPi / n;
  const auto direction = [&](double i) { return Vec2{std::cos(kPi * i / n), std::sin(kPi * i / n)}; };
  for (int i = 0; i < n; ++i) {
    const double area = half * (outer * outer - inner * inner);
    const double moment = (outer * outer * outer - inner * inner * inner) * 2 / 3 * std::sin(half);
    blocks.system.bodies.push_back({1, 1});
    blocks.system.positions.push_back(moment / area * direction(i + 0.5));
    blocks.weight.push_back({0, -area, 0});
  }
  for (int i = 0; i <= n; ++i) {
    const int before = i == 0 ? -1 : i - 1, after = i == n ? -1 : i;
    blocks.join(before, after, inner * direction(i), outer * direction(i), perp(direction(i)), 1);
  }
  return blocks;
}

/// Smallest x in [low, high] that carries its own weight; everything above it does.
template <class Make>
double least(double low, double high, Sliding sliding, Make&& make) {
  while (high - low > 1e-10) {
    const double middle = 0.5 * (low + high);
    const Blocks blocks = make(middle);
    (missing_support(blocks.system, blocks.weight, sliding) > 1e-12 ? low : high) = middle;
  }
  return high;
}

class LimitLoadTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!limit_load_available()) GTEST_SKIP() << limit_load_missing();
  }
};

TEST_F(LimitLoadTest, SemicircularArchOf15VoussoirsNeeds0106068) {
  const double t = least(0.09, 0.12, Sliding::None, [](double x) { return arch(15, x); });
  EXPECT_NEAR(t, 0.106068, 1e-6);
}

TEST_F(LimitLoadTest, SemicircularArchOf121VoussoirsNeeds0107454) {
  const double t = least(0.1074, 0.1075, Sliding::None, [](double x) { return arch(121, x); });
  EXPECT_NEAR(t, 0.107454, 1e-6);
}

TEST_F(LimitLoadTest, ArchOf15SectorsNeeds0106266) {
  const double t = least(0.09, 0.12, Sliding::None, [](double x) { return arch_of_sectors(15, x); });
  EXPECT_NEAR(t, 0.106266, 1e-6);
}

TEST_F(LimitLoadTest, ArchOfManySectorsTendsToMilankovitchs01075) {
  // 0.107478 for a continuous arch [Makris & Alexakis 2013]; joints between voussoirs leave hinges fewer
  // places.
  double last = 0;
  for (const int n : {7, 15, 31, 61}) {
    const double t = least(0.09, 0.12, Sliding::None, [&](double x) { return arch_of_sectors(n, x); });
    EXPECT_GT(t, last) << n;
    last = t;
  }
  EXPECT_NEAR(last, 0.1075, 1.5e-4);
}

TEST_F(LimitLoadTest, HarmonicOverhangIsTheLimitTo1e9) {
  for (const int n : {1, 2, 5, 20}) {
    // Planks of length 2: from the top, each sticks out by scale / k beyond the one below.
    const auto stack = [&](double scale) {
      Blocks blocks;
      std::vector<double> x(static_cast<std::size_t>(n));
      double at = 0;
      for (int k = n; k >= 1; --k) {
        // Plank k from the top lies on the table (k = n) or on plank k + 1.
        at += scale / k;
        x[static_cast<std::size_t>(k) - 1] = at;
      }
      for (int k = 0; k < n; ++k) {
        const double y = n - 1 - k, left = x[static_cast<std::size_t>(k)] - 2;
        blocks.add_box({left, y}, {left + 2, y + 1});
      }
      for (int k = 0; k < n; ++k) {
        const double y = n - 1 - k, left = x[static_cast<std::size_t>(k)] - 2;
        const double edge = k + 1 < n ? x[static_cast<std::size_t>(k) + 1] : 0;
        blocks.join(k + 1 < n ? k + 1 : -1, k, {left, y}, {edge, y}, {0, 1}, 0);
      }
      return blocks;
    };
    const double scale = -least(-1.5, -0.5, Sliding::Coulomb, [&](double s) { return stack(-s); });
    EXPECT_NEAR(scale, 1, 1e-9) << n;
  }
}

TEST_F(LimitLoadTest, BlockPushedSidewaysSlidesOrTips) {
  // Width 1, height 2, weight 2, pushed at its centre: slides at mu W, tips at W (w/2) / (h/2).
  for (const double mu : {0.2, 0.4, 0.6, 0.9}) {
    Blocks blocks;
    blocks.add_box({0, 0}, {1, 2});
    blocks.join(-1, 0, {0, 0}, {1, 0}, {0, 1}, mu);
    const LimitLoad limit = limit_load(blocks.system, blocks.weight, {{1, 0, 0}});
    ASSERT_EQ(limit.status, LimitStatus::Optimal);
    EXPECT_NEAR(limit.factor, 2 * std::min(mu, 0.5), 1e-9);
    EXPECT_NEAR(limit_load(blocks.system, blocks.weight, {{1, 0, 0}}, Sliding::None).factor, 1, 1e-9);
    // The mechanism does the work 1 on the live load, turns when it tips, lifts by mu when it slides.
    EXPECT_NEAR(limit.mechanism[0][0], 1, 1e-9);
    if (mu > 0.5) {
      EXPECT_NEAR(limit.mechanism[0][2], -1, 1e-9);
    } else {
      EXPECT_NEAR(limit.mechanism[0][1], mu, 1e-9);
    }
  }
}

TEST_F(LimitLoadTest, RetainingWallTipsAtTheTextbookPressure) {
  // Wall 1 m thick, 3 m high, unit weight: earth pressure k y behind it, resultant k h^2 / 2 at h / 3.
  Blocks blocks;
  const double h = 3, b = 1;
  blocks.add_box({0, 0}, {b, h});
  blocks.join(-1, 0, {0, 0}, {b, 0}, {0, 1}, 0.8);
  const double push = h * h / 2, lever = h / 3;
  const LimitLoad limit = limit_load(blocks.system, blocks.weight, {{push, 0, -push * (lever - h / 2)}});
  // About the toe: W b / 2 = k push lever; sliding: mu W = k push.
  EXPECT_NEAR(limit.factor, std::min(b * h * b / 2 / (push * lever), 0.8 * b * h / push), 1e-9);
}

TEST_F(LimitLoadTest, DryWallTipsAsOneBlockOrSlidesInItsWeakestBed) {
  // Running bond, 3 bricks of 2 x 1 a course, 6 courses, with horizontal acceleration k g on every brick.
  for (const double mu : {0.3, 5.0}) {
    Blocks wall;
    std::vector<std::vector<std::pair<double, int>>> rows;
    for (int layer = 0; layer < 6; ++layer) {
      // Odd courses begin and end with half bricks.
      std::vector<double> edges =
          layer % 2 ? std::vector<double>{0, 1, 3, 5, 6} : std::vector<double>{0, 2, 4, 6};
      rows.emplace_back();
      for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
        const int brick = wall.add_box({edges[i], 1.0 * layer}, {edges[i + 1], layer + 1.0});
        if (layer == 0) wall.join(-1, brick, {edges[i], 0}, {edges[i + 1], 0}, {0, 1}, mu);
        if (i > 0)
          wall.join(rows.back().back().second, brick, {edges[i], 1.0 * layer}, {edges[i], layer + 1.0},
                    {1, 0}, mu);
        rows.back().push_back({edges[i], brick});
        if (layer == 0) continue;
        const auto& below = rows[static_cast<std::size_t>(layer) - 1];
        for (std::size_t j = 0; j < below.size(); ++j) {
          const double end = j + 1 < below.size() ? below[j + 1].first : 6;
          const double x0 = std::max(edges[i], below[j].first), x1 = std::min(edges[i + 1], end);
          if (x1 > x0) wall.join(below[j].second, brick, {x0, 1.0 * layer}, {x1, 1.0 * layer}, {0, 1}, mu);
        }
      }
    }
    BodyLoads sideways;
    for (const auto& load : wall.weight) sideways.push_back({-load[1], 0, 0});
    const LimitLoad limit = limit_load(wall.system, wall.weight, sideways);
    ASSERT_EQ(limit.status, LimitStatus::Optimal);
    // A monolith of 6 x 6 would tip at 1; bricks can do no better, and slide at mu.
    EXPECT_LE(limit.factor, std::min(mu, 1.0) + 1e-9);
    EXPECT_GT(limit.factor, 0.15);
    if (mu < 1) {
      EXPECT_NEAR(limit.factor, mu, 1e-9);
    }
    // No contact closes in the mechanism, and the dead load's work is the factor.
    double work = 0;
    for (std::size_t k = 0; k < wall.weight.size(); ++k) work -= wall.weight[k][1] * limit.mechanism[k][1];
    EXPECT_NEAR(work, limit.factor, 1e-8);
    for (const Row& row : wall.system.rows) {
      if (row.kind != RowKind::Normal) continue;
      double opening = 0;
      if (row.a >= 0) opening += along(row.Ja, limit.mechanism[static_cast<std::size_t>(row.a)]);
      if (row.b >= 0) opening += along(row.Jb, limit.mechanism[static_cast<std::size_t>(row.b)]);
      EXPECT_GT(opening, -1e-8);
    }
  }
}

TEST_F(LimitLoadTest, UnboundedAndInfeasibleAreSaid) {
  Blocks blocks;
  blocks.add_box({0, 0}, {1, 1});
  blocks.join(-1, 0, {0, 0}, {1, 0}, {0, 1}, 0.5);
  EXPECT_EQ(limit_load(blocks.system, blocks.weight, {{0, -1, 0}}).status, LimitStatus::Unbounded);
  EXPECT_EQ(limit_load(blocks.system, {{0, 1, 0}}, {{1, 0, 0}}).status, LimitStatus::Infeasible);
  EXPECT_GT(missing_support(blocks.system, {{0, 1, 0}}), 0.1);
  EXPECT_THROW((void)limit_load(blocks.system, {}, {}), std::invalid_argument);
}

TEST_F(LimitLoadTest, FrictionIsBoundedByItsNormalForceAlone) {
  // Whatever bounds of their own its rows have.
  Blocks blocks;
  blocks.add_box({0, 0}, {4, 1});
  blocks.join(-1, 0, {0, 0}, {4, 0}, {0, 1}, 0.5);
  for (Row& row : blocks.system.rows)
    if (row.kind == RowKind::Friction) row.lower = 0;
  for (const double side : {1.0, -1.0})
    EXPECT_NEAR(limit_load(blocks.system, blocks.weight, {{side, 0, 0}}).factor, 0.5 * 4, 1e-9) << side;
}

TEST_F(LimitLoadTest, MissingSupportIsTheShareOfTheLoadThatNothingCarries) {
  Blocks blocks;
  blocks.add_box({0, 0}, {4, 1});
  blocks.join(-1, 0, {0, 0}, {4, 0}, {0, 1}, 0.5);
  EXPECT_NEAR(missing_support(blocks.system, blocks.weight), 0, 1e-12);
  EXPECT_NEAR(missing_support(blocks.system, {{0, 4, 0}}), 1, 1e-9);
  // 10 down lets 5 be held sideways; of 8 along the ground 3 are missing.
  for (const double side : {1.0, -1.0})
    EXPECT_NEAR(missing_support(blocks.system, {{side * 8, -10, 0}}), 3.0 / 18, 1e-9) << side;
}

}  // namespace limit_load_test
}  // namespace skerry::statics::test
