// SPDX-License-Identifier: MIT
#include "render/svg.h"

#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>

#include "tests/render/support.h"

namespace skerry::render {
namespace svg_test {

class Svg : public GlTest {
 protected:
  Svg() : GlTest(1280, 720) {
    camera.height = 7.2;
    camera.centre = {100, -50};
  }

  Point at(double x, double y) const { return {camera.centre.x + x, camera.centre.y + y}; }

  /// As another program draws it.
  Image drawn_by_others(const std::string& svg) {
    const Scratch scratch;
    std::ofstream(scratch / "a.svg") << svg;
    const std::string folder = scratch.path().string();
    const Output output = run("xmllint --noout " + folder + "/a.svg 2>&1 && ffmpeg -v error -i " + folder +
                              "/a.svg -frames:v 1 " + folder + "/a.png 2>&1");
    EXPECT_EQ(output.status, 0) << "ffmpeg and xmllint are needed (apt install ffmpeg libxml2-utils)\n"
                                << output.text;
    return read_png(scratch / "a.png");
  }

  void expect_alike(const char* what) {
    const Image ours = draw(), theirs = drawn_by_others(to_svg(list, camera));
    ASSERT_EQ(theirs.width, ours.width);
    double sum = 0;
    std::int64_t far = 0;
    for (std::size_t i = 0; i < ours.rgba.size(); ++i) {
      const int d = std::abs(static_cast<int>(ours.rgba[i]) - static_cast<int>(theirs.rgba[i]));
      sum += d;
      far += d > 100;
    }
    // Antialiasing differs along the edges, nothing else.
    EXPECT_LT(sum / static_cast<double>(ours.rgba.size()), 0.25) << what;
    EXPECT_LT(far, 40) << what;
    EXPECT_GT(ink(ours), 1000) << what;
  }
};

TEST_F(Svg, LooksLikeTheRendering) {
  const Style& s = style(Theme::Light);
  list.background = s.background;
  for (int i = 0; i < kHueCount; ++i) {
    const Paint& p = body_paint(s, i);
    const double x = -5.6 + 1.6 * i;
    list[Layer::Bodies].discs.push_back({at(x, 2.4), 0.5, p.fill, p.outline, 3, 0.5 * i, i % 2 == 0});
    list[Layer::Bodies].capsules.push_back({at(x - 0.3, 0.8), at(x + 0.3, 1.2), 0.3, p.fill, p.outline, 3});
  }
  expect_alike("discs and capsules");
  list.clear();
  for (int i = 0; i < 14; ++i) {
    const Paint& p = body_paint(s, i);
    Point corners[64];
    const int n = i == 13 ? 64 : 3 + i;
    for (int k = 0; k < n; ++k) {
      const double a = 0.3 * i + 6.283185307 * k / n;
      corners[k] = at(-5.4 + 1.8 * (i % 7) + 0.6 * std::cos(a), 1.5 - 2 * (i / 7) + 0.6 * std::sin(a));
    }
    list[Layer::Bodies].polygon(corners, static_cast<std::size_t>(n), p.fill, p.outline,
                                i % 3 == 0 ? 0.15 : 0, 4);
  }
  const Point ground[] = {at(-1e9, -1e9), at(1e9, -1e9), at(1e9, -2.503), at(-1e9, -2.503)};
  list[Layer::Bodies].polygon(ground, 4, s.ground.fill, s.ground.outline, 0, 3);
  expect_alike("polygons");
  list.clear();
  for (int i = 0; i < 12; ++i) {
    const double a = 0.53 * i, length = 0.05 + 0.2 * i;
    list[Layer::Contacts].arrows.push_back(
        {at(0, 0), at(length * std::cos(a), length * std::sin(a)), s.impulse, 6, 24});
    list[Layer::Structure].lines.push_back(
        {at(-6, -3 + 0.5 * i), at(6, -3 + 0.52 * i), faded(s.friction, 0.5), 2, i % 2 * 8.0f});
    list[Layer::Contacts].markers.push_back({at(-5 + i, -1), s.contact, s.warning, 6});
  }
  expect_alike("arrows, lines, markers");
}

TEST_F(Svg, LongShapesPointWhereTheyPoint) {
  for (const double angle : {0.3004, 1e-5, -2.0003}) {
    list.clear();
    list[Layer::Structure].lines.push_back(
        {at(0, 0), at(6 * std::cos(angle), 6 * std::sin(angle)), kBlack, 2});
    const std::string svg = to_svg(list, camera);
    const std::size_t from = svg.find("matrix(");
    ASSERT_NE(from, std::string::npos);
    double m[4];
    ASSERT_EQ(std::sscanf(svg.c_str() + from, "matrix(%lf %lf %lf %lf", m, m + 1, m + 2, m + 3), 4);
    const double expected[] = {std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle)};
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(m[i], expected[i], 1e-7) << angle;
    EXPECT_EQ(svg.find("e-0"), std::string::npos) << angle;
  }
}

TEST_F(Svg, KeepsTextAsTextAndEscapesIt) {
  list[Layer::Labels].labels.push_back(
      {at(0, 0), "a < b & \"c\"\nsecond \xc2\xb5", kBlack, kWhite, 15, Anchor::Left});
  const std::string svg = to_svg(list, camera, "<title>");
  EXPECT_NE(svg.find("a &lt; b &amp; &quot;c&quot;</text>"), std::string::npos);
  EXPECT_NE(svg.find("second \xc2\xb5</text>"), std::string::npos);
  EXPECT_NE(svg.find("<title>&lt;title&gt;</title>"), std::string::npos);
  EXPECT_NE(svg.find("text-anchor=\"end\""), std::string::npos);
  EXPECT_GT(ink(drawn_by_others(svg)), 50);
}

TEST_F(Svg, IsTheSameEveryTimeAndFiniteForAnyInput) {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  for (const double bad : {nan, inf, 1e300, -1e18}) {
    list[Layer::Bodies].discs.push_back({{bad, 0}, 1, kRed, kBlack});
    list[Layer::Bodies].discs.push_back({at(0, 0), std::abs(bad), kRed, kBlack, 2, bad, true});
    list[Layer::Contacts].arrows.push_back({at(0, 0), {bad, bad}, kBlack});
    list[Layer::Labels].labels.push_back({{bad, bad}, "x", kBlack, kWhite});
  }
  const std::string svg = to_svg(list, camera);
  EXPECT_EQ(svg, to_svg(list, camera));
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  EXPECT_EQ(svg.find("e+"), std::string::npos);
}

}  // namespace svg_test
}  // namespace skerry::render
