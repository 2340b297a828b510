// SPDX-License-Identifier: MIT
#include "physics/shape.h"

#include <functional>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <limits>

#include "tests/narrowphase/oracle.h"

namespace skerry {
namespace shape_test {

using oracle::Scenes;
using ::testing::HasSubstr;

std::string refusal(const std::function<void()>& make) {
  try {
    make();
  } catch (const std::invalid_argument& e) {
    return e.what();
  }
  return "accepted";
}

std::string polygon_refusal(std::vector<Vec2> corners, double rounding = 0) {
  return refusal([&] { make_polygon(corners, rounding); });
}

TEST(Polygon, RefusesBadOutlinesAndNamesTheCorner) {
  const double nan = std::nan("");
  EXPECT_THAT(polygon_refusal({{0, 0}, {1, 0}}), HasSubstr("3 to 64 corners expected, got 2"));
  EXPECT_THAT(polygon_refusal(std::vector<Vec2>(65)), HasSubstr("got 65"));
  EXPECT_THAT(polygon_refusal({{0, 0}, {1, 0}, {nan, 1}}), HasSubstr("corner 2"));
  EXPECT_THAT(polygon_refusal({{0, 0}, {kInfinity, 0}, {0, 1}}), HasSubstr("corner 1"));
  EXPECT_THAT(polygon_refusal({{0, 0}, {1, 0}, {1, 0}, {0, 1}}), HasSubstr("corner 2 repeats corner 1"));
  EXPECT_THAT(polygon_refusal({{0, 0}, {1, 0}, {0, 1}, {0, 0}}), HasSubstr("corner 3 repeats corner 0"));
  EXPECT_THAT(polygon_refusal({{0, 0}, {0.5, 0}, {1, 0}, {0, 1}}),
              HasSubstr("corner 1 at (0.5, 0) lies on a line"));
  EXPECT_THAT(polygon_refusal({{0, 0}, {0.1, 0.1}, {0.3, 0.3}, {0, 1}}), HasSubstr("corner 1"));
  EXPECT_THAT(polygon_refusal({{0, 0}, {2, 0}, {2, 2}, {1, 0.5}}), HasSubstr("corner 3"));
  EXPECT_THAT(polygon_refusal({{0, 0}, {2, 0}, {2, 2}, {1, 0.5}}), HasSubstr("non-convex"));
  // The same backwards: numbers are the caller's.
  EXPECT_THAT(polygon_refusal({{1, 0.5}, {2, 2}, {2, 0}, {0, 0}}), HasSubstr("corner 0"));
  EXPECT_THAT(polygon_refusal({{0, 0}, {1, 0}, {0, 1}}, -1), HasSubstr("rounding must be >= 0"));
  EXPECT_THAT(polygon_refusal({{0, 0}, {1, 1}, {0, 1}, {1, 0}}), HasSubstr("non-convex"));
  // A star turns left everywhere, but twice around.
  std::vector<Vec2> star;
  for (int i = 0; i < 5; ++i) star.push_back({sin_cos(4 * kPi * i / 5).cos, sin_cos(4 * kPi * i / 5).sin});
  EXPECT_THAT(polygon_refusal(star), HasSubstr("non-convex"));
}

TEST(Polygon, AcceptsEitherOrientationAndThinSlivers) {
  EXPECT_EQ(make_polygon(std::vector<Vec2>{{0, 0}, {1, 0}, {0, 1}}).vertices.size(), 3u);
  const Shape clockwise = make_polygon(std::vector<Vec2>{{0, 0}, {0, 1}, {1, 0}});
  EXPECT_EQ(clockwise.vertices[1], (Vec2{1, 0}));
  EXPECT_NO_THROW(make_polygon(std::vector<Vec2>{{0, 0}, {1, 0}, {0.5, 1e-9}}));
  EXPECT_NO_THROW(make_polygon(std::vector<Vec2>{{0, 0}, {1e-6, 0}, {0, 1e-6}}));
  EXPECT_NO_THROW(make_polygon(std::vector<Vec2>{{0, 0}, {1e6, 0}, {0, 1e6}}));
}

TEST(Shapes, RefuseBadSizesWithTheValue) {
  EXPECT_THAT(refusal([] { make_disc(0); }), HasSubstr("radius must be positive"));
  EXPECT_THAT(refusal([] { make_disc(-2.5); }), HasSubstr("-2.5"));
  EXPECT_THAT(refusal([] { make_disc(std::nan("")); }), HasSubstr("nan"));
  EXPECT_THAT(refusal([] { make_disc(1, {kInfinity, 0}); }), HasSubstr("centre"));
  EXPECT_THAT(refusal([] { make_capsule({1, 2}, {1, 2}, 1); }), HasSubstr("coincide"));
  EXPECT_THAT(refusal([] { make_capsule({0, 0}, {1, 0}, 0); }), HasSubstr("radius"));
  EXPECT_THAT(refusal([] { make_box({1, 0}); }), HasSubstr("height"));
  EXPECT_THAT(refusal([] { make_box({1, 1}, {}, 0, 0.5); }), HasSubstr("rounding"));
  EXPECT_THAT(refusal([] { make_box({1, 1}, {}, kInfinity); }), HasSubstr("angle"));
  EXPECT_THAT(refusal([] { make_half_plane({0, 0}, {0, 0}); }), HasSubstr("normal"));
  EXPECT_THAT(refusal([] { make_chain(std::vector<Vec2>{{0, 0}}); }), HasSubstr("at least 2 corners"));
  EXPECT_THAT(refusal([] { make_chain(std::vector<Vec2>{{0, 0}, {1, 0}}, true); }), HasSubstr("at least 3"));
  EXPECT_THAT(refusal([] { make_chain(std::vector<Vec2>{{0, 0}, {1, 0}, {1, 0}}); }), HasSubstr("corner 2"));
}

/// Area, centroid and moment about the centroid by Gauss quadrature of slices in x.
AreaProperties integrated(const Shape& shape, int slices) {
  // Exact for polygons with many corners: round parts are replaced by fine arcs.
  std::vector<oracle::Point> outline;
  const std::size_t n = shape.vertices.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec2 from = n == 1 ? Vec2{1, 0} : shape.normals[(i + n - 1) % n];
    const Vec2 to = n == 1 ? Vec2{1, 0} : shape.normals[i];
    const double start = std::atan2(from.y, from.x);
    double turn = std::atan2(cross(from, to), dot(from, to));
    if (n == 1) turn = 2 * kPi;
    if (n == 2) turn = kPi;
    for (int k = 0; k <= slices; ++k) {
      const long double angle = start + static_cast<long double>(turn) * k / slices;
      outline.push_back({shape.vertices[i].x + shape.radius * std::cos(angle),
                         shape.vertices[i].y + shape.radius * std::sin(angle)});
    }
  }
  long double area = 0, x = 0, y = 0, second = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const oracle::Point a = outline[i], b = outline[(i + 1) % outline.size()];
    const long double twice = oracle::cross(a, b);
    area += twice / 2;
    x += twice / 6 * (a.x + b.x);
    y += twice / 6 * (a.y + b.y);
    second += twice / 12 * (oracle::dot(a, a) + oracle::dot(a, b) + oracle::dot(b, b));
  }
  x /= area;
  y /= area;
  return {static_cast<double>(area),
          {static_cast<double>(x), static_cast<double>(y)},
          static_cast<double>(second - area * (x * x + y * y))};
}

TEST(AreaProperties, AreThoseOfTheOutline) {
  Scenes scenes(12);
  for (int k = 0; k < 200; ++k) {
    const Shape shape = translated(scenes.shape(1), 2 * scenes.direction());
    const AreaProperties p = area_properties(shape);
    const bool round = shape.radius > 0;
    const AreaProperties q = integrated(shape, round ? 4000 : 1);
    // A sliver's area is a small difference of large products.
    const double tolerance = round ? 3e-6 : 1e-14 + 1e-15 / q.area;
    ASSERT_NEAR(p.area / q.area, 1, tolerance) << k;
    ASSERT_NEAR(length(p.centroid - q.centroid), 0, round ? 1e-6 : 1e-14 + 1e-15 / q.area);
    ASSERT_NEAR(p.second_moment, q.second_moment, round ? 3e-6 * q.area : 2e-15) << k;
  }
}

TEST(AreaProperties, AreExactForSimpleShapes) {
  const AreaProperties disc = area_properties(make_disc(2, {5, 7}));
  EXPECT_EQ(disc.area, 4 * kPi);
  EXPECT_EQ(disc.centroid, (Vec2{5, 7}));
  EXPECT_DOUBLE_EQ(disc.second_moment, 8 * kPi);
  const AreaProperties box = area_properties(make_box({3, 4}));
  EXPECT_DOUBLE_EQ(box.area, 12);
  EXPECT_NEAR(length(box.centroid), 0, 1e-15);
  EXPECT_NEAR(box.second_moment, 25, 1e-14);
  // A box that is almost all rounding is almost a disc; a capsule is a rounded sliver.
  const AreaProperties round = area_properties(make_box({2, 2}, {}, 0, 1 - 1e-9));
  EXPECT_NEAR(round.area, kPi, 1e-8);
  EXPECT_NEAR(round.second_moment, kPi / 2, 1e-8);
  EXPECT_EQ(area_properties(make_half_plane({0, 0}, {0, 1})).area, 0);
  // Far from the frame's origin nothing is lost but the centroid's last digits.
  const AreaProperties far = area_properties(make_box({1, 1}, {1e6, 1e6}));
  EXPECT_NEAR(far.second_moment, 1.0 / 6, 1e-9);
}

TEST(BoundingBox, HoldsTheShapeTightly) {
  Scenes scenes(4);
  for (int k = 0; k < 1000; ++k) {
    const Shape shape = scenes.shape(1);
    const Transform pose{3 * scenes.direction(), Rot::from_angle(scenes.angle())};
    const Aabb box = bounding_box(shape, pose);
    double low = kInfinity, high = -kInfinity;
    for (const Vec2 v : shape.vertices) {
      low = std::min(low, to_world(pose, v).x - shape.radius);
      high = std::max(high, to_world(pose, v).y + shape.radius);
      ASSERT_LE(length(v) + shape.radius, bounding_radius(shape) * (1 + 1e-15));
    }
    ASSERT_NEAR(box.lower.x, low, 1e-14);
    ASSERT_NEAR(box.upper.y, high, 1e-14);
  }
  const Shape ground = make_half_plane({0, 1}, {0, 1});
  const Aabb flat = bounding_box(ground, {{0, 2}, {}});
  EXPECT_EQ(flat.upper.y, 3);
  EXPECT_EQ(flat.upper.x, 1e12);
  EXPECT_EQ(flat.lower.y, -1e12);
  const Aabb sloped = bounding_box(make_half_plane({0, 0}, {1, 1}), {});
  EXPECT_EQ(sloped.upper.y, 1e12);
  EXPECT_EQ(bounding_radius(ground), kInfinity);
}

double area_of(const std::vector<Vec2>& outline) {
  long double twice = 0;
  for (std::size_t i = 1; i + 1 < outline.size(); ++i)
    twice += cross(outline[i] - outline[0], outline[i + 1] - outline[0]);
  return static_cast<double>(twice / 2);
}

void expect_good_parts(const std::vector<Vec2>& outline, std::size_t at_most, const std::string& name) {
  double sum = 0;
  const auto parts = convex_parts(outline);
  for (const auto& part : parts) {
    Shape shape;
    ASSERT_NO_THROW(shape = make_polygon(part)) << name;
    sum += area_properties(shape).area;
  }
  EXPECT_NEAR(sum / std::abs(area_of(outline)), 1, 1e-12) << name;
  EXPECT_LE(parts.size(), at_most) << name;
}

TEST(ConvexParts, KeepTheAreaAndAreConvex) {
  expect_good_parts({{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}, 2, "L");
  expect_good_parts({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, 1, "square");
  expect_good_parts({{0, 1}, {1, 1}, {1, 0}, {0, 0}}, 1, "clockwise square");
  expect_good_parts({{0, 0}, {0.5, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0.3}}, 1, "corners on lines");
  expect_good_parts(
      {{1, 0}, {2, 0}, {2, 1}, {3, 1}, {3, 2}, {2, 2}, {2, 3}, {1, 3}, {1, 2}, {0, 2}, {0, 1}, {1, 1}}, 5,
      "plus");
  std::vector<Vec2> comb{{0, 0}, {20, 0}};
  for (int i = 19; i >= 0; --i) {
    comb.push_back({i + 0.75, 3});
    comb.push_back({i + 0.5, 1});
    comb.push_back({i + 0.25, 3});
    comb.push_back({static_cast<double>(i), 1});
  }
  comb.pop_back();
  comb.push_back({0, 1.5});
  expect_good_parts(comb, 100, "comb");
  std::vector<Vec2> spiral;
  for (int i = 0; i <= 60; ++i)
    spiral.push_back((1 + 0.1 * i) * Vec2{sin_cos(0.2 * i).cos, sin_cos(0.2 * i).sin});
  for (int i = 60; i >= 0; --i)
    spiral.push_back((0.8 + 0.1 * i) * Vec2{sin_cos(0.2 * i).cos, sin_cos(0.2 * i).sin});
  expect_good_parts(spiral, 120, "spiral");
  std::vector<Vec2> many;
  for (int i = 0; i < 200; ++i)
    many.push_back({sin_cos(2 * kPi * i / 200).cos, sin_cos(2 * kPi * i / 200).sin});
  expect_good_parts(many, 12, "200 corners, split at 64");
}

TEST(ConvexParts, KeepTheAreaOfRandomStars) {
  Scenes scenes(6);
  for (int k = 0; k < 300; ++k) {
    const int n = 3 + scenes.below(60);
    std::vector<Vec2> star;
    for (int i = 0; i < n; ++i) {
      const SinCos sc = sin_cos(2 * kPi * (i + scenes.uniform(-0.3, 0.3)) / n);
      const double r = std::pow(10.0, scenes.uniform(-2, 0));
      star.push_back({1e3 + r * sc.cos, r * sc.sin});
    }
    // Three corners may leave the centre outside; such a "star" can be clockwise or flat, still simple.
    expect_good_parts(star, static_cast<std::size_t>(n), "star " + std::to_string(k));
  }
}

TEST(ConvexParts, RefuseOutlinesThatCrossOrTouchThemselves) {
  const auto why = [](std::vector<Vec2> outline) { return refusal([&] { convex_parts(outline); }); };
  EXPECT_THAT(why({{0, 0}, {1, 1}, {1, 0}, {0, 1}}), HasSubstr("crosses"));
  EXPECT_THAT(why({{0, 0}, {2, 0}, {2, 2}, {1, 0}, {0, 2}}), HasSubstr("crosses or touches"));
  EXPECT_THAT(why({{0, 0}, {2, 0}, {1, 0}, {1, 1}}), HasSubstr("crosses or touches"));
  EXPECT_THAT(why({{0, 0}, {1, 0}}), HasSubstr("at least 3"));
  EXPECT_THAT(why({{0, 0}, {1, 0}, {std::nan(""), 1}}), HasSubstr("corner 2"));
  EXPECT_THAT(why({{0, 0}, {1, 0}, {1, 0}, {0, 1}}), HasSubstr("repeats"));
}

}  // namespace shape_test
}  // namespace skerry
