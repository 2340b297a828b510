// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <random>

#include "render/image_diff.h"
#include "tests/render/support.h"

namespace skerry::render {
namespace renderer_test {

/// A busy picture that uses every program.
void fill_busy(DrawList& list) {
  const Style& s = style(Theme::Light);
  list.background = s.background;
  for (int i = 0; i < 400; ++i) {
    const double x = -6 + 0.61 * (i % 20), y = -3 + 0.31 * (i / 20), a = 0.37 * i;
    const Paint& p = body_paint(s, i);
    Point corners[8];
    for (int k = 0; k < 3 + i % 6; ++k) {
      const double b = a + 2 * std::numbers::pi * k / (3 + i % 6);
      corners[k] = {x + 0.2 * std::cos(b), y + 0.2 * std::sin(b)};
    }
    list[Layer::Bodies].polygon(corners, 3 + i % 6, p.fill, p.outline, i % 2 * 0.03);
    list[Layer::Bodies].discs.push_back({{x + 0.3, y}, 0.12, p.fill, p.outline, 1.5f, a, true});
    list[Layer::Contacts].arrows.push_back(
        {{x, y}, {x + 0.4 * std::cos(a), y + 0.4 * std::sin(a)}, faded(s.impulse, 0.7), s.normal_px, 8});
    list[Layer::Labels].labels.push_back({{x, y}, std::to_string(i), s.text, s.halo, 11});
  }
}

class Renderer : public GlTest {
 protected:
  DrawLayer& bodies() { return list[Layer::Bodies]; }
  void box(Point centre, double width, double height, double angle = 0, double rounding = 0,
           Color fill = kBlack) {
    const double c = std::cos(angle), s = std::sin(angle), w = 0.5 * width, h = 0.5 * height;
    const Point corners[] = {{centre.x - c * w + s * h, centre.y - s * w - c * h},
                             {centre.x + c * w + s * h, centre.y + s * w - c * h},
                             {centre.x + c * w - s * h, centre.y + s * w + c * h},
                             {centre.x - c * w - s * h, centre.y - s * w + c * h}};
    bodies().polygon(corners, 4, fill, fill, rounding, 0);
  }
  void regular(Point centre, double radius, int corners, double angle, double rounding = 0) {
    std::vector<Point> points;
    for (int i = 0; i < corners; ++i) {
      const double a = angle + 2 * std::numbers::pi * i / corners;
      points.push_back({centre.x + radius * std::cos(a), centre.y + radius * std::sin(a)});
    }
    bodies().polygon(points.data(), points.size(), kBlack, kBlack, rounding, 0);
  }
};

TEST_F(Renderer, UsesTheSoftwareDeviceAndTellsWhichWaysItTried) {
  if (test_device() == EglDevice::Software) {
    EXPECT_TRUE(context.software());
  }
  ASSERT_FALSE(context.attempts().empty());
  EXPECT_TRUE(context.attempts().back().ok);
  EXPECT_FALSE(context.version().empty());
  bool any = false;
  for (const EglAttempt& attempt : probe_egl()) any = any || attempt.ok;
  EXPECT_TRUE(any);
  // The context of this test is still current.
  bodies().discs.push_back({{0, 0}, 1, kBlack, kBlack, 0});
  EXPECT_EQ(draw().at(200, 150), kBlack);
}

TEST_F(Renderer, ClearsToTheBackground) {
  list.background = {12, 34, 56, 255};
  const Image image = draw();
  EXPECT_EQ(image, Image(400, 300, {12, 34, 56, 255}));
}

TEST_F(Renderer, PutsShapesWhereTheCameraSaysWithUpUp) {
  bodies().discs.push_back({{1, 0.5}, 0.3, kRed, kBlue, 4});
  const Image image = draw();
  EXPECT_EQ(image.at(300, 100), kRed);         // centre
  EXPECT_EQ(image.at(300 + 28, 100), kBlue);   // outline: 4 px of the style are 2.4 here
  EXPECT_EQ(image.at(300 + 23, 100), kRed);    // just inside of the outline
  EXPECT_EQ(image.at(300 + 31, 100), kWhite);  // just outside
  EXPECT_EQ(image.at(300, 200), kWhite);       // not mirrored
  EXPECT_EQ(image.at(100, 100), kWhite);
}

// Antialiasing is right when the ink is the area, wherever the shape lies between the pixels.
TEST_F(Renderer, CoversTheAreaOfEveryShape) {
  for (int trial = 0; trial < 12; ++trial) {
    const Point at{0.00317 * trial, -0.00171 * trial};
    const double angle = 0.13 * trial;
    list.clear();
    bodies().discs.push_back({at, 0.6, kBlack, kBlack, 0});
    EXPECT_NEAR(ink(draw()), std::numbers::pi * 3600, 12) << "disc " << trial;
    list.clear();
    box(at, 1.3, 0.7, angle);
    EXPECT_NEAR(ink(draw()), 130 * 70, 12) << "box " << trial;
    list.clear();
    box(at, 1, 0.5, angle, 0.2);
    EXPECT_NEAR(ink(draw()), 100 * 50 + 300 * 20 + std::numbers::pi * 400, 12) << "rounded box " << trial;
    list.clear();
    bodies().capsules.push_back({{at.x - 0.5, at.y}, {at.x + 0.4, at.y + 0.2}, 0.25, kBlack, kBlack, 0});
    EXPECT_NEAR(ink(draw()), std::hypot(90, 20) * 50 + std::numbers::pi * 625, 12) << "capsule " << trial;
    for (const int corners : {3, 5, 7, 64}) {
      list.clear();
      regular(at, 0.9, corners, angle);
      const double area = 0.5 * corners * 8100 * std::sin(2 * std::numbers::pi / corners);
      EXPECT_NEAR(ink(draw()), area, 15) << corners << " corners, " << trial;
    }
    list.clear();
    regular(at, 0.6, 5, angle, 0.2);
    const double side = 120 * std::sin(std::numbers::pi / 5);
    const double area =
        2.5 * 3600 * std::sin(0.4 * std::numbers::pi) + 5 * side * 20 + std::numbers::pi * 400;
    EXPECT_NEAR(ink(draw()), area, 15) << "rounded pentagon " << trial;
    list.clear();
    // 300 lines: the factor of the style is 0.6
    list[Layer::Contacts].lines.push_back({{at.x - 1, at.y}, {at.x + 1, at.y + 0.5}, kBlack, 5, 0});
    EXPECT_NEAR(ink(draw()), std::hypot(200, 50) * 3 + std::numbers::pi * 2.25, 6) << "line " << trial;
  }
}

TEST_F(Renderer, EdgesAreShadedByTheShareOfThePixelTheyCover) {
  // The right edge of the box crosses pixel column 300 at a quarter, half, three quarters.
  for (const double share : {0.25, 0.5, 0.75}) {
    list.clear();
    box({0.5 + 0.005 * share, 0}, 1 + 0.01 * share, 1);
    const Image image = draw();
    EXPECT_EQ(image.at(299, 150), kBlack);
    EXPECT_NEAR(image.at(300, 150).r, 255 * (1 - share), 1.5);
    EXPECT_EQ(image.at(301, 150), kWhite);
  }
}

TEST_F(Renderer, AcceptsPolygonsInEitherOrientation) {
  const Point corners[] = {{-0.5, -0.5}, {0.7, -0.3}, {0.1, 0.8}};
  const Point turned[] = {corners[0], corners[2], corners[1]};
  bodies().polygon(corners, 3, kRed, kBlack, 0.05);
  const Image image = draw();
  list.clear();
  bodies().polygon(turned, 3, kRed, kBlack, 0.05);
  const DiffResult same = compare(image, draw());
  EXPECT_LE(same.max_difference, 2) << same.reason;
  EXPECT_EQ(image.at(205, 150), kRed);
}

TEST_F(Renderer, SeeThroughFillsBlendWithWhatLiesBelow) {
  bodies().discs.push_back({{0, 0}, 0.5, kRed, kRed, 0});
  list[Layer::Structure].discs.push_back({{0, 0}, 0.5, {0, 0, 200, 128}, {0, 0, 200, 128}, 0});
  const Color c = draw().at(200, 150);
  EXPECT_NEAR(c.r, 200 * 127 / 255.0, 1.5);
  EXPECT_NEAR(c.b, 200 * 128 / 255.0, 1.5);
  EXPECT_EQ(c.a, 255);
}

TEST_F(Renderer, LaterLayersAndItemsCoverEarlierOnes) {
  list[Layer::Contacts].markers.push_back({{0, 0}, kBlue, kBlue, 10});
  bodies().discs.push_back({{0, 0}, 0.5, kRed, kRed, 0});
  bodies().discs.push_back({{0.3, 0}, 0.2, kBlack, kBlack, 0});
  regular({0, 0}, 1, 6, 0);
  const Image image = draw();
  EXPECT_EQ(image.at(200, 150), kBlue);
  EXPECT_EQ(image.at(180, 150), kRed);
  EXPECT_EQ(image.at(235, 150), kBlack);
}

TEST_F(Renderer, ArrowsEndInAHeadAndShrinkWhole) {
  camera.width_px = 1280;
  camera.height_px = 720;
  camera.height = 7.2;
  DrawLayer& layer = list[Layer::Contacts];
  layer.arrows.push_back({{-1, 0}, {1, 0}, kBlack, 4, 20});
  const Image image = draw();
  const auto thickness = [&](int x) {
    double sum = 0;
    for (int y = 0; y < image.height; ++y) sum += (255 - image.at(x, y).r) / 255.0;
    return sum;
  };
  EXPECT_NEAR(thickness(600), 4, 0.1);              // shaft
  EXPECT_NEAR(thickness(721), 2 * 0.42 * 19, 1.2);  // widest part of the head
  EXPECT_NEAR(thickness(730), 2 * 0.42 * 9.5, 1.2);
  EXPECT_EQ(thickness(741), 0);  // the tip is the end
  EXPECT_EQ(thickness(536), 0);  // and nothing before the start
  // A tenth of the head's length: a tenth of everything, a hundredth of the ink.
  const auto head_ink = [&](double length) {
    layer.arrows[0] = {{0, 0}, {length, 0}, kBlack, 4, 20};
    return ink(draw());
  };
  EXPECT_NEAR(head_ink(0.2), 0.42 * 400, 6);
  EXPECT_NEAR(head_ink(0.1), 0.42 * 100, 5);
  EXPECT_EQ(head_ink(0), 0);
}

TEST_F(Renderer, DashesCoverHalfOfTheLineAndStayWhenTheLineGrows) {
  camera.width_px = 1280;
  camera.height_px = 720;
  camera.height = 7.2;
  DrawLayer& layer = list[Layer::Structure];
  layer.lines.push_back({{-5, 0}, {5, 0}, kBlack, 2, 10});
  const Image image = draw();
  int dark = 0;
  for (int x = 140; x < 1140; ++x) dark += image.at(x, 360).r < 128;
  EXPECT_NEAR(dark, 600, 30);  // half, and the round ends
  layer.lines[0].to.x = 500;
  const Image longer = draw();
  for (int x = 140; x < 1100; ++x) ASSERT_EQ(image.at(x, 360), longer.at(x, 360)) << x;
}

TEST_F(Renderer, WritesLabelsOnAHalo) {
  camera.width_px = 1280;
  camera.height_px = 720;
  camera.height = 7.2;
  list.background = {100, 100, 100, 255};
  const auto bounds = [&](const Image& image, Color color) {
    DiffBox box{1280, 720, -1, -1};
    for (int y = 0; y < 720; ++y) {
      for (int x = 0; x < 1280; ++x) {
        if (image.at(x, y) != color) continue;
        box = {std::min(box.x, x), std::min(box.y, y), std::max(box.width, x), std::max(box.height, y)};
      }
    }
    return box;
  };
  for (const Anchor anchor : {Anchor::Centre, Anchor::Left, Anchor::Right, Anchor::Above, Anchor::Below}) {
    list[Layer::Labels].labels.assign(1, {{0, 0}, "HHHH", kBlack, kWhite, 30, anchor, 10});
    const Image image = draw();
    const DiffBox ink = bounds(image, kBlack), halo = bounds(image, kWhite);
    ASSERT_GT(ink.width, 0);
    // Capitals of DejaVu Sans are 0.73 em high; the stems touch full pixels.
    EXPECT_NEAR(ink.height - ink.y + 1, 0.73 * 30, 1.5);
    EXPECT_NEAR(ink.width - ink.x + 1, text_width("HHHH", 30), 8);
    EXPECT_LT(halo.x, ink.x);
    EXPECT_GT(halo.width, ink.width);
    const double x = 0.5 * (ink.x + ink.width + 1), y = 0.5 * (ink.y + ink.height + 1);
    if (anchor == Anchor::Centre) {
      EXPECT_NEAR(std::hypot(x - 640, y - 360), 0, 2);
    }
    if (anchor == Anchor::Left) {
      EXPECT_NEAR(ink.width, 640 - 10, 5);
    }
    if (anchor == Anchor::Right) {
      EXPECT_NEAR(ink.x, 640 + 10, 5);
    }
    if (anchor == Anchor::Above) {
      EXPECT_NEAR(ink.height, 360 - 10, 2);
    }
    if (anchor == Anchor::Below) {
      EXPECT_NEAR(ink.y, 360 + 10, 2);
    }
  }
}

TEST_F(Renderer, SurvivesAnyTextAndManySizes) {
  std::string bytes;
  for (int i = 1; i < 256; ++i) bytes += static_cast<char>(i);
  list[Layer::Labels].labels.push_back({{0, 0}, bytes, kBlack, kWhite, 15});
  list[Layer::Labels].labels.push_back({{0, 0}, "", kBlack, kWhite, 15});
  list[Layer::Labels].labels.push_back({{0, 0}, "a\n\nb", kBlack, kWhite, 15});
  for (int i = 0; i < 60; ++i) {
    const auto size = static_cast<float>(10 + 2 * i);
    list[Layer::Labels].labels.push_back(
        {{-1, 0.02 * i}, "Growing text \xc2\xb5 \xe2\x88\x91", kBlack, kWhite, size});
  }
  const Image first = draw();
  EXPECT_GT(ink(first), 100);
  EXPECT_EQ(first, draw());
}

TEST_F(Renderer, LargeLabelsAreThereInTheFirstPicture) {
  auto& labels = list[Layer::Labels].labels;
  for (int i = 0; i < 8; ++i)
    labels.push_back(
        {{0, 1.2 - 0.3 * i}, "abcdefghijklmnop", kBlack, {}, 290 + 10.0f * static_cast<float>(i)});
  const Image first = draw();
  EXPECT_EQ(stats.culled, 0);
  EXPECT_EQ(first, draw());
  // Beyond the largest letters there are, words stay words.
  list.clear();
  labels.push_back({{0, 0}, "ab", kBlack, {}, 900});
  const Image largest = draw();
  labels[0].size_px = 3000;
  EXPECT_EQ(draw(), largest);
  // What is too much leaves room for the rest.
  list.clear();
  for (int i = 0; i < 20; ++i)
    labels.push_back({{90, 0}, "abcdefghijklmnop", kBlack, {}, 700 + static_cast<float>(i)});
  labels.push_back({{0, 0}, "small", kBlack, {}, 20});
  EXPECT_GT(ink(draw()), 50);
  EXPECT_GT(stats.culled, 100);
}

// Everything a scene shows, moved far away: the same picture, as far as the coordinates can tell it.
TEST_F(Renderer, LooksTheSameFarFromTheOrigin) {
  const auto scene = [&](double x, double y) {
    list.clear();
    camera.centre = {x, y};
    bodies().discs.push_back({{x + 0.25, y}, 0.5, kRed, kBlack, 2, 0.7, true});
    box({x - 1, y - 0.5}, 0.5, 0.75, 0.3, 0.0625, kBlue);
    regular({x - 1, y + 0.75}, 0.5, 5, 0.1);
    list[Layer::Contacts].arrows.push_back({{x, y}, {x + 1, y + 1}, kBlack, 3, 12});
    list[Layer::Labels].labels.push_back({{x + 1, y - 1}, "far", kBlack, kWhite, 20});
    return draw();
  };
  const Image near = scene(0, 0);
  for (const double distance : {1e4, 1e7, -1e9}) {
    const DiffResult result = compare(near, scene(distance, distance));
    EXPECT_LE(result.max_difference, distance < 0 ? 8 : 2) << distance << ": " << result.reason;
  }
}

// Rasterisers lose their way in quads far larger than the picture, at some angles and sizes only.
TEST_F(Renderer, LargeShapesFillTheirSideAtEveryAngle) {
  std::mt19937 random(20261121);
  std::uniform_real_distribution<double> unit(0, 1);
  for (int trial = 0; trial < 120; ++trial) {
    // 100 pixels a metre; the edge passes near the middle.
    const double angle = 2 * M_PI * unit(random), size = 2 * std::pow(1e4, unit(random));
    const Point n{-std::sin(angle), std::cos(angle)}, t{n.y, -n.x};
    const Point foot{2 * unit(random) - 1, 2 * unit(random) - 1};
    list.clear();
    list.background = kWhite;
    const bool disc = trial % 3 == 2;
    if (disc) {
      list[Layer::Bodies].discs.push_back(
          {{foot.x - size * n.x, foot.y - size * n.y}, size, kBlue, kRed, 1.5f, angle, true});
    } else {
      const double depth = trial % 3 ? size : 0.4 * size;
      const Point corners[] = {{foot.x - size * t.x - depth * n.x, foot.y - size * t.y - depth * n.y},
                               {foot.x + size * t.x - depth * n.x, foot.y + size * t.y - depth * n.y},
                               {foot.x + size * t.x, foot.y + size * t.y},
                               {foot.x - size * t.x, foot.y - size * t.y}};
      list[Layer::Bodies].polygon(corners, 4, kBlue, kRed);
    }
    const Image image = draw();
    int wrong = 0;
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; ++x) {
        const Point at{(x + 0.5 - 200) / 100, (150 - y - 0.5) / 100};
        const double up = (at.x - foot.x) * n.x + (at.y - foot.y) * n.y;
        const double across = (at.x - foot.x) * t.x + (at.y - foot.y) * t.y;
        double out = 0;  // signed distance [m]
        if (disc)
          out = std::hypot(up + size, across) - size;
        else
          out = std::max({up, -up - (trial % 3 ? size : 0.4 * size), std::abs(across) - size});
        const bool spoke = disc && size - std::hypot(up + size, across) > 0;
        if (std::abs(out) < 0.05) continue;
        const Color c = image.at(x, y);
        wrong += out > 0 ? !(c == kWhite) : !(c == kBlue) && !(spoke && c.r > 0);
      }
    }
    EXPECT_EQ(wrong, 0) << "trial " << trial << ": size " << size << " m, angle " << angle;
  }
}

TEST_F(Renderer, KeepsTheEdgesOfShapesMuchLargerThanThePicture) {
  for (const double size : {1e3, 1e6, 1e9, 1e12}) {
    const double h = 0.5 * size;
    list.clear();
    box({0.3 * h, -h - 0.205}, size, size);
    const Image ground = draw();
    list.clear();
    bodies().discs.push_back({{0, -size - 0.205}, size, kBlack, kBlack, 0});
    const Image planet = draw();
    list.clear();
    const Point corners[] = {{-size, -0.205}, {0, -size}, {size, -0.205}};
    bodies().polygon(corners, 3, kBlack, kBlack, 0, 0);
    const Image wedge = draw();
    list.clear();
    bodies().capsules.push_back({{-size, -1.205}, {size, -1.205}, 1, kBlack, kBlack, 0});
    const Image bar = draw();
    for (const Image* image : {&ground, &planet, &wedge, &bar}) {
      for (const int x : {150, 200, 250}) {
        const int tolerance = image == &planet && size < 1e4 ? 40 : 5;
        EXPECT_EQ(image->at(x, 168), kWhite) << size;
        EXPECT_EQ(image->at(x, 173), kBlack) << size;
        EXPECT_NEAR(image->at(x, 170).r, 128, tolerance) << size << " shape " << image - &ground;
      }
    }
  }
}

TEST_F(Renderer, LeavesOutWhatIsNotFiniteAndDrawsTheRest) {
  const double bad[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                        1e308};
  bodies().discs.push_back({{0, 0}, 0.5, kRed, kRed, 0});
  const Image clean = draw();
  for (const double b : bad) {
    list.clear();
    bodies().discs.push_back({{0, 0}, 0.5, kRed, kRed, 0});
    bodies().discs.push_back({{b, 0}, 0.5, kBlack, kBlack, 0});
    bodies().discs.push_back({{1, b}, 0.5, kBlack, kBlack, 0});
    bodies().capsules.push_back({{b, 1}, {b, b}, 0.5, kBlack, kBlack});
    const Point corners[] = {{b, b}, {-b, 0}, {5, b}};
    bodies().polygon(corners, 3, kBlack, kBlack);
    list[Layer::Contacts].arrows.push_back({{0, b}, {b, b}, kBlack});
    list[Layer::Contacts].lines.push_back({{b, b}, {b, b}, kBlack, 2, 5});
    list[Layer::Contacts].markers.push_back({{b, 0}, kBlack, kBlack});
    list[Layer::Labels].labels.push_back({{b, 0}, "bad", kBlack, kBlack});
    if (b < 1e300) {
      bodies().discs.push_back({{0, 0}, -1, kBlack, kBlack, 0});
    }
    EXPECT_EQ(draw(), clean) << b;
    EXPECT_GT(stats.culled, 5);
  }
}

TEST_F(Renderer, LinesAndPolygonsBeyondAllMeasureEndAndDrawWhatTheyCan) {
  for (const double far : {1e10, 1e16, 1e100}) {
    list.clear();
    list[Layer::Structure].lines.push_back({{-far, 0.005}, {far, 0.005}, kBlack, 4, 6});
    const double all = 2.4 * camera.width_px;
    // Half of it are dashes, their round ends aside.
    EXPECT_NEAR(ink(draw()), far < 1e12 ? 0.78 * all : all, 0.05 * all) << far;
  }
  bodies().discs.push_back({{0, 0}, 0.5, kRed, kRed, 0});
  const Image clean = draw();
  const double far = 1e100;
  const Point corners[] = {{-far, -far}, {far, -far}, {far, 0.1 * far}, {0, far}, {-far, 0.2 * far}};
  bodies().polygon(corners, 5, kBlack, kBlack, 0.1 * far);
  EXPECT_EQ(draw(), clean);
  EXPECT_EQ(stats.culled, 1);
}

// Polygons that are only a point or a line: rounded, a disc or a capsule.
TEST_F(Renderer, FlatPolygonsStayWithinTheirRounding) {
  for (const int count : {3, 5, 12}) {
    for (const double length : {0.0, 1.0}) {
      std::vector<Point> corners;
      for (int i = 0; i < count; ++i) corners.push_back({i < count / 2 ? 0 : length, 0.005});
      list.clear();
      bodies().polygon(corners.data(), corners.size(), kRed, kRed, 0.3);
      const double polygon = ink(draw());
      EXPECT_EQ(draw().at(390, 149), kWhite) << count;
      list.clear();
      bodies().capsules.push_back({{0, 0.005}, {length, 0.005}, 0.3, kRed, kRed});
      EXPECT_NEAR(polygon, ink(draw()), 2) << count << " corners, length " << length;
      if (length > 0) continue;
      list.clear();
      bodies().polygon(corners.data(), corners.size(), kRed, kRed);
      EXPECT_EQ(ink(draw()), 0) << count;
    }
  }
}

TEST(DrawLists, AreEqualWhenEveryItemIs) {
  DrawList a, b;
  fill_busy(a);
  fill_busy(b);
  EXPECT_EQ(a, b);
  b[Layer::Labels].labels[17].text += ".";
  EXPECT_NE(a, b);
  b.clear();
  fill_busy(b);
  EXPECT_EQ(a, b);
  b[Layer::Bodies].points[3].x += 1e-12;
  EXPECT_NE(a, b);
  EXPECT_THROW(b[Layer::Bodies].polygon(nullptr, 2, kRed, kRed), std::invalid_argument);
}

TEST_F(Renderer, SkipsWhatCannotBeSeen) {
  for (int i = 0; i < 1000; ++i) bodies().discs.push_back({{10.0 + i, 0}, 0.5, kRed, kBlack});
  draw();
  EXPECT_EQ(stats.culled, 1000);
  EXPECT_EQ(stats.draw_calls, 0);
}

TEST_F(Renderer, SupersamplingKeepsPositionsAndColours) {
  box({0, 0}, 1, 0.5, 0.2, 0, kRed);
  bodies().discs.push_back({{-1, 0.3}, 0.4, kBlue, kBlack, 3});
  list[Layer::Labels].labels.push_back({{1, -1}, "text", kBlack, kWhite, 20});
  const Image plain = draw(1);
  for (const int ssaa : {2, 3, 4}) {
    const Image fine = draw(ssaa);
    ASSERT_EQ(fine.width, 400);
    EXPECT_NEAR(ink(fine), ink(plain), 0.01 * ink(plain));
    EXPECT_EQ(fine.at(200, 150), kRed);
    EXPECT_EQ(fine.at(100, 120), kBlue);
    EXPECT_NE(fine, plain);
  }
}

TEST_F(Renderer, RefusesBadCamerasAndTargets) {
  EXPECT_THROW(Target(0, 10), std::invalid_argument);
  EXPECT_THROW(Target(10, 10, 5), std::invalid_argument);
  Target target(100, 100);
  EXPECT_THROW(renderer.draw(list, camera, target), std::invalid_argument);
  camera.height = 0;
  EXPECT_THROW(draw(), std::invalid_argument);
  camera.height = std::nan("");
  EXPECT_THROW(draw(), std::invalid_argument);
}

// What has no counterpart in OpenGL: rows narrower than a group of four pixels, and pictures handed over.
TEST(Canvases, DrawNarrowPicturesAndHandThemOut) {
  for (const int width : {1, 2, 3, 4, 5, 7}) {
    Canvas canvas(width, 9);
    Camera camera;
    camera.width_px = width;
    camera.height_px = 9;
    camera.height = 9;
    DrawList list;
    list.background = {200, 200, 200, 255};
    list[Layer::Bodies].discs.push_back({{0, 0}, 20, kRed, kBlack, 1});
    list[Layer::Bodies].discs.push_back({{0.5 * width - 0.5, -4}, 0.4, kBlue, kBlue, 0});
    Image image, again;
    canvas.draw(list, camera);
    canvas.take(image);
    EXPECT_EQ(image.at(0, 0), kRed) << width;
    EXPECT_GT(image.at(width - 1, 8).b, 50) << width;  // half of the pixel
    EXPECT_EQ(image.rgba.size(), 4u * 9u * static_cast<std::size_t>(width));
    // The memory of the first goes round; nothing of it shows.
    Image third = image;
    canvas.draw(list, camera);
    canvas.take(third);
    list.clear();
    canvas.draw(list, camera);
    canvas.take(again);
    EXPECT_EQ(third, image);
    EXPECT_EQ(again, Image(width, 9, list.background));
  }
  EXPECT_THROW(Canvas(0, 10), std::invalid_argument);
  EXPECT_THROW(Canvas(10, 10, 5), std::invalid_argument);
  Canvas canvas(10, 10);
  EXPECT_THROW(canvas.draw(DrawList{}, Camera{}), std::invalid_argument);
}

// The canvas keeps the background from frame to frame: whatever changes shows as on a new canvas.
TEST(Canvases, ShowEveryChangeOfTheBackground) {
  Camera camera;
  camera.width_px = 200;
  camera.height_px = 100;
  DrawList list;
  list[Layer::Background].lines.push_back({{-5, 1}, {5, 2}, kRed, 2});
  list[Layer::Background].labels.push_back({{2, 2}, "grid", kBlack, kWhite, 20});
  list[Layer::Bodies].discs.push_back({{0, 0}, 2, kBlue, kBlack, 2});
  Canvas kept(200, 100);
  const auto check = [&](const char* what) {
    Canvas fresh(200, 100);
    Image expected, image;
    const DrawStats wanted = fresh.draw(list, camera);
    fresh.take(expected);
    for (int again = 0; again < 2; ++again) {
      const DrawStats stats = kept.draw(list, camera);
      kept.take(image);
      EXPECT_EQ(image, expected) << what;
      EXPECT_EQ(stats.shapes, wanted.shapes) << what;
    }
  };
  check("first");
  list[Layer::Bodies].discs[0].centre = {1, 0.5};
  check("a body");
  list[Layer::Background].lines[0].from.y = 3;
  check("a line");
  list[Layer::Background].labels[0].text = "other";
  check("a word");
  list.background = {10, 20, 30, 255};
  check("the colour");
  camera.centre.x = 0.7;
  check("the camera's place");
  camera.height = 6;
  check("the camera's height");
}

TEST(RendererDeterminism, FramesAreTheSameBitsForAnyThreadCountAndProcess) {
  // The number of rasteriser threads is read when the first context is made: each count needs a process of
  // its own, and the parent may not have touched GL in this test.
  const std::string program = std::filesystem::read_symlink("/proc/self/exe").string();
  const Output output =
      run("unset GTEST_TOTAL_SHARDS GTEST_SHARD_INDEX; for threads in 0 1 2 4; do LP_NUM_THREADS=$threads "
          "SKERRY_TEST_DIGEST=1 " +
          program + " --gtest_filter=RendererDeterminism.PrintsTheDigestOfABusyFrame & done; wait");
  std::vector<std::string> digests;
  for (std::size_t at = 0; (at = output.text.find("digest=", at)) != std::string::npos; ++at)
    digests.push_back(output.text.substr(at + 7, 33));
  ASSERT_EQ(digests.size(), 4u) << output.text;
  for (const std::string& both : digests) EXPECT_EQ(both, digests[0]);
}

TEST(RendererDeterminism, PrintsTheDigestOfABusyFrame) {
  const EglContext context(test_device());
  GlRenderer renderer;
  DrawList list;
  fill_busy(list);
  Camera camera;
  camera.height = 7.2;
  Image first, own;
  for (int i = 0; i < 3; ++i) {
    Target target(1280, 720);
    renderer.draw(list, camera, target);
    Image image;
    target.read(image);
    if (i == 0) first = image;
    EXPECT_EQ(image, first);
    Canvas canvas(1280, 720);
    canvas.draw(list, camera);
    canvas.take(image);
    if (i == 0) own = image;
    EXPECT_EQ(image, own);
  }
  if (std::getenv("SKERRY_TEST_DIGEST") != nullptr) {
    std::printf("digest=%016llx %016llx\n", static_cast<unsigned long long>(digest(first)),
                static_cast<unsigned long long>(digest(own)));
  }
}

}  // namespace renderer_test
}  // namespace skerry::render
