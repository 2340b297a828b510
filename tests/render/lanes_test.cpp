// SPDX-License-Identifier: MIT
//
// The loops over pixels are compiled for four and for eight floats at a time: the pictures are the same.
#include <cmath>
#include <numbers>
#include <random>

#include "render/raster_kernels.h"
#include "render/yuv.h"
#include "tests/render/support.h"

namespace skerry::render {
namespace lanes_test {

/// Shapes of every program and of sizes from a hair to more than the picture, opaque and not.
DrawList random_list(std::mt19937& random, double extent) {
  const auto number = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto chance = [&](double share) { return number(0, 1) < share; };
  const auto byte = [&] { return static_cast<std::uint8_t>(number(0, 255.99)); };
  const auto color = [&](double opaque) {
    return Color{byte(), byte(), byte(), chance(opaque) ? std::uint8_t{255} : byte()};
  };
  const auto size = [&] { return extent * std::exp(number(std::log(1e-3), std::log(0.7))); };
  const auto point = [&] { return Point{number(-0.6, 0.6) * extent, number(-0.6, 0.6) * extent}; };
  DrawList list;
  list.background = color(1);
  for (DrawLayer& layer : list.layers) {
    for (int i = 0; i < 12; ++i) {
      // A fill and an outline: both opaque, both not, or the same.
      const double opaque = chance(0.5) ? 1 : 0;
      const Color fill = color(opaque), outline = chance(0.2) ? fill : color(opaque);
      const auto width = static_cast<float>(chance(0.2) ? 0 : number(0.2, 6));
      const Point at = point();
      const double radius = size(), turn = number(0, 7);
      layer.discs.push_back({at, radius, fill, outline, width, turn, chance(0.5)});
      const Point end = point();
      layer.capsules.push_back({at, end, size(), fill, outline, width});
      layer.lines.push_back({end, point(), fill, width, static_cast<float>(chance(0.3) ? number(1, 9) : 0)});
      layer.arrows.push_back({point(), end, outline, width, static_cast<float>(number(2, 20))});
      // Upright ones, too: their rows begin and end where those of the picture do.
      const Point across{chance(0.5) ? end.x : end.x + size(), chance(0.5) ? end.y : end.y - size()};
      layer.arrows.push_back({end, across, fill, width, 9});
      layer.markers.push_back({at, fill, outline, static_cast<float>(number(0.5, 9))});
      Point corners[12];
      const int count = 3 + static_cast<int>(number(0, 9.99));
      for (int k = 0; k < count; ++k) {
        const double angle = turn + 2 * std::numbers::pi * k / count;
        corners[k] = {end.x + radius * std::cos(angle), end.y + 0.4 * radius * std::sin(angle)};
      }
      layer.polygon(corners, static_cast<std::size_t>(count), fill, outline, chance(0.4) ? size() : 0, width);
      const Point box[] = {
          at, {at.x + radius, at.y}, {at.x + radius, at.y + 0.3 * radius}, {at.x, at.y + 0.3 * radius}};
      layer.polygon(box, 4, outline, fill, 0, width);
    }
    layer.labels.push_back({point(), "lanes", color(1), color(0), 15});
  }
  return list;
}

TEST(Lanes, FourAndEightDrawTheSameBits) {
  if (&raster_kernels(true) == &raster_kernels(false)) GTEST_SKIP() << "this processor has no AVX2";
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  struct Size {
    int width, height, ssaa;
  };
  for (const Size size :
       {Size{320, 180, 1}, {321, 67, 1}, {90, 200, 2}, {3, 40, 1}, {9, 9, 3}, {640, 360, 1}}) {
    Canvas four(size.width, size.height, size.ssaa, false), eight(size.width, size.height, size.ssaa, true);
    Camera camera;
    camera.width_px = size.width;
    camera.height_px = size.height;
    for (int round = 0; round < 6; ++round) {
      const DrawList list = random_list(random, camera.height);
      Image a, b;
      four.draw(list, camera);
      four.take(a);
      eight.draw(list, camera);
      eight.take(b);
      ASSERT_EQ(a, b) << size.width << " x " << size.height << ", round " << round;
    }
  }
}

TEST(Lanes, FourAndEightMakeTheSameVideo) {
  if (&raster_kernels(true) == &raster_kernels(false)) GTEST_SKIP() << "this processor has no AVX2";
  const unsigned seed = std::random_device{}();
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (const int width : {2, 62, 64, 126, 130, 640, 1918}) {
    Image image(width, 6);
    for (std::uint8_t& byte : image.rgba) byte = static_cast<std::uint8_t>(random());
    const auto planes = [&](bool avx2, int divisor) {
      const auto convert = divisor == 1 ? to_yuv444 : to_yuv420;
      std::vector<std::uint8_t> out[3];
      for (std::vector<std::uint8_t>& plane : out) plane.assign(static_cast<std::size_t>(width) * 6, 7);
      convert(image,
              {{out[0].data(), out[1].data(), out[2].data()}, {width, width / divisor, width / divisor}},
              avx2);
      return std::vector<std::vector<std::uint8_t>>(out, out + 3);
    };
    EXPECT_EQ(planes(true, 1), planes(false, 1)) << width;
    EXPECT_EQ(planes(true, 2), planes(false, 2)) << width;
  }
}

}  // namespace lanes_test
}  // namespace skerry::render
