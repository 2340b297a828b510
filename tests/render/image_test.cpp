// SPDX-License-Identifier: MIT
#include "render/image.h"

#include <cmath>
#include <fstream>
#include <gmock/gmock.h>
#include <random>
#include <stb_image_write.h>

#include "render/error.h"
#include "render/palette.h"
#include "render/yuv.h"
#include "tests/render/support.h"

namespace skerry::render {
namespace image_test {

using testing::HasSubstr;

Image noise(int width, int height, unsigned seed, bool opaque) {
  std::mt19937 random(seed);
  Image image(width, height);
  for (std::size_t i = 0; i < image.rgba.size(); ++i) {
    image.rgba[i] = i % 4 == 3 && opaque ? 255 : static_cast<std::uint8_t>(random());
  }
  return image;
}

TEST(Png, RoundTripKeepsEveryPixel) {
  const Scratch scratch;
  for (const auto& [width, height] :
       {std::pair{1, 1}, std::pair{7, 3}, std::pair{320, 201}, std::pair{1, 500}}) {
    for (const bool opaque : {true, false}) {
      const Image image = noise(width, height, 7, opaque);
      write_png(scratch / "a.png", image);
      EXPECT_EQ(read_png(scratch / "a.png"), image) << width << " x " << height;
    }
  }
  EXPECT_EQ(scratch.files(), 1u);
}

TEST(Png, SmallFilesKeepEveryPixelAndAreReadByOthers) {
  const Scratch scratch;
  Image flat(300, 200, {240, 240, 240, 255});
  for (int i = 0; i < 200; ++i) flat.set(i, i, {static_cast<std::uint8_t>(i), 40, 90, 255});
  Image smooth(300, 200);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 300; ++x)
      smooth.set(x, y, {static_cast<std::uint8_t>(x / 2), static_cast<std::uint8_t>(y), 90, 255});
  // A palette, a row filter, noise, one pixel, and transparency.
  for (const Image& image :
       {flat, smooth, noise(40, 30, 5, true), Image(1, 1, {1, 2, 3, 255}), noise(40, 30, 5, false)}) {
    const std::vector<std::uint8_t> bytes = encode_small_png(image);
    EXPECT_EQ(decode_png(bytes.data(), bytes.size()), image);
    write_file(scratch / "small.png", bytes.data(), bytes.size());
    const Output raw =
        run("ffmpeg -v error -i " + (scratch / "small.png").string() + " -f rawvideo -pix_fmt rgba -");
    ASSERT_EQ(raw.status, 0) << "ffmpeg is needed (apt install ffmpeg)";
    EXPECT_TRUE(raw.text == std::string(image.rgba.begin(), image.rgba.end()));
  }
  EXPECT_LT(encode_small_png(flat).size(), 2000u);
  EXPECT_LT(encode_small_png(smooth).size(), encode_png(smooth).size() / 5);
}

TEST(Png, QuantisedFilesAreSmallerAndLookTheSame) {
  const Image image = [] {
    Image made(300, 200);
    for (int y = 0; y < 200; ++y)
      for (int x = 0; x < 300; ++x)
        made.set(x, y, {static_cast<std::uint8_t>(x / 2), static_cast<std::uint8_t>(y), 90, 255});
    return made;
  }();
  const std::vector<std::uint8_t> bytes = encode_small_png(image, true);
  EXPECT_EQ(bytes[25], 3) << "colour type: palette";
  const Image read = decode_png(bytes.data(), bytes.size());
  ASSERT_EQ(read.width, 300);
  for (std::size_t i = 0; i < image.rgba.size(); ++i) ASSERT_NEAR(read.rgba[i], image.rgba[i], 16) << i;
  // What has few colours stays exact.
  const Image flat(20, 20, {1, 2, 3, 255});
  const std::vector<std::uint8_t> exact = encode_small_png(flat, true);
  EXPECT_EQ(decode_png(exact.data(), exact.size()), flat);
  EXPECT_THROW(static_cast<void>(encode_small_png(Image())), std::invalid_argument);
  EXPECT_THROW(static_cast<void>(decode_png("no", 2)), EnvironmentError);
}

TEST(Png, FilesOfOthersAreReadAndOursAreReadByOthers) {
  const Scratch scratch;
  const Image image = noise(64, 48, 3, true);
  ASSERT_NE(stbi_write_png((scratch / "stb.png").c_str(), 64, 48, 4, image.rgba.data(), 64 * 4), 0);
  EXPECT_EQ(read_png(scratch / "stb.png"), image);
  write_png(scratch / "ours.png", image);
  const Output raw =
      run("ffmpeg -v error -i " + (scratch / "ours.png").string() + " -f rawvideo -pix_fmt rgba -");
  ASSERT_EQ(raw.status, 0) << "ffmpeg is needed (apt install ffmpeg)";
  EXPECT_TRUE(raw.text == std::string(image.rgba.begin(), image.rgba.end()));
}

TEST(Png, RenderingsTakeNoMoreThanTheyDoWithStb) {
  const Scratch scratch;
  const EglContext context(test_device());
  GlRenderer renderer;
  DrawList list;
  list.background = style(Theme::Light).background;
  for (int i = 0; i < 300; ++i) {
    const Paint& p = body_paint(style(Theme::Light), i);
    list[Layer::Bodies].discs.push_back(
        {{-6 + 0.6 * (i % 20), -3 + 0.4 * (i / 20)}, 0.19, p.fill, p.outline, 1.5f, 0.3 * i, true});
  }
  Target target(1280, 720);
  Camera camera;
  camera.height = 7.2;
  renderer.draw(list, camera, target);
  Image image;
  target.read(image);
  std::vector<std::uint8_t> rgb;
  for (std::size_t i = 0; i < image.rgba.size(); ++i) {
    if (i % 4 != 3) rgb.push_back(image.rgba[i]);
  }
  ASSERT_NE(stbi_write_png((scratch / "stb.png").c_str(), 1280, 720, 3, rgb.data(), 1280 * 3), 0);
  EXPECT_LE(encode_png(image).size(), std::filesystem::file_size(scratch / "stb.png"));
}

TEST(Png, BrokenFilesAreErrorsWithTheirName) {
  const Scratch scratch;
  const auto path = scratch / "a.png";
  const auto message = [&] {
    try {
      (void)read_png(path);
    } catch (const EnvironmentError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(message(), HasSubstr(path.string()));
  EXPECT_THAT(message(), HasSubstr("No such file"));
  write_png(path, noise(50, 50, 1, true));
  std::filesystem::resize_file(path, 300);
  EXPECT_THAT(message(), HasSubstr(path.string()));
  std::ofstream(path) << "no picture";
  EXPECT_THAT(message(), HasSubstr(path.string()));
  EXPECT_THROW((void)encode_png(Image()), std::invalid_argument);
  EXPECT_THROW(Image(0, 5), std::invalid_argument);
  EXPECT_THROW(Image(5, 100000), std::invalid_argument);
}

TEST(Png, UnwritablePathsLeaveNothing) {
  const Scratch scratch;
  const Image image(4, 4);
  EXPECT_THROW(write_png(scratch / "no/a.png", image), EnvironmentError);
  std::filesystem::create_directory(scratch / "folder.png");
  EXPECT_THROW(write_png(scratch / "folder.png", image), EnvironmentError);
  EXPECT_EQ(scratch.files(), 1u);
}

TEST(ImageDigest, ChangesWithAnyPixelAndTheShape) {
  const Image image = noise(40, 30, 5, true);
  Image other = image;
  EXPECT_EQ(digest(image), digest(other));
  for (std::size_t i = 0; i < image.rgba.size(); i += 37) {
    other.rgba[i] ^= 1;
    EXPECT_NE(digest(image), digest(other));
    other.rgba[i] ^= 1;
  }
  std::swap(other.width, other.height);
  EXPECT_NE(digest(image), digest(other));
}

// The vector loops against the formula of BT.709 in floating point.
TEST(Yuv, IsBt709ToWithinALevel) {
  for (const auto& [width, height] :
       {std::pair{64, 32}, std::pair{50, 6}, std::pair{2, 2}, std::pair{34, 4}}) {
    Image image = noise(width, height, 11, true);
    const auto pixels = static_cast<std::size_t>(width) * height;
    std::vector<std::uint8_t> y(pixels), u(pixels), v(pixels), y4(pixels), u4(pixels), v4(pixels);
    to_yuv420(image, {{y.data(), u.data(), v.data()}, {width, width / 2, width / 2}});
    to_yuv444(image, {{y4.data(), u4.data(), v4.data()}, {width, width, width}});
    EXPECT_EQ(y, y4);
    const auto luma = [](double r, double g, double b) { return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
    const auto cb = [&](double r, double g, double b) {
      return 128 + 224.0 / 255 * (b - luma(r, g, b)) / 1.8556;
    };
    const auto cr = [&](double r, double g, double b) {
      return 128 + 224.0 / 255 * (r - luma(r, g, b)) / 1.5748;
    };
    for (int row = 0; row < height; ++row) {
      for (int x = 0; x < width; ++x) {
        const Color c = image.at(x, row);
        const std::size_t i = static_cast<std::size_t>(row) * width + x;
        ASSERT_NEAR(y[i], 16 + 219.0 / 255 * luma(c.r, c.g, c.b), 1.01) << width << ": " << x << ", " << row;
        ASSERT_NEAR(u4[i], cb(c.r, c.g, c.b), 1.3);
        ASSERT_NEAR(v4[i], cr(c.r, c.g, c.b), 1.3);
        if (x % 2 != 0 || row % 2 != 0) continue;
        double mean[3] = {0, 0, 0};
        for (int k = 0; k < 4; ++k) {
          const Color p = image.at(x + k % 2, row + k / 2);
          mean[0] += p.r / 4.0;
          mean[1] += p.g / 4.0;
          mean[2] += p.b / 4.0;
        }
        const std::size_t half = static_cast<std::size_t>(row / 2) * (width / 2) + x / 2;
        ASSERT_NEAR(u[half], cb(mean[0], mean[1], mean[2]), 1.3);
        ASSERT_NEAR(v[half], cr(mean[0], mean[1], mean[2]), 1.3);
      }
    }
  }
}

TEST(Yuv, GreysHaveNoColourAndTheEndsAreExact) {
  for (int grey = 0; grey < 256; ++grey) {
    const auto g = static_cast<std::uint8_t>(grey);
    const Image image(32, 2, {g, g, g, 255});
    std::vector<std::uint8_t> y(64), u(16), v(16);
    to_yuv420(image, {{y.data(), u.data(), v.data()}, {32, 16, 16}});
    EXPECT_EQ(u[3], 128);
    EXPECT_EQ(v[3], 128);
    if (grey == 0) {
      EXPECT_EQ(y[40], 16);
    }
    if (grey == 255) {
      EXPECT_EQ(y[40], 235);
    }
  }
}

TEST(PaletteOfGif, KeepsUpTo256FlatColoursExactly) {
  Image image(160, 100);
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 160; ++x) {
      image.set(x, y,
                {static_cast<std::uint8_t>(x / 10 * 16), static_cast<std::uint8_t>(y / 10 * 25), 40, 255});
    }
  }
  Palette palette(image);
  std::vector<std::uint8_t> index(160 * 100);
  EXPECT_EQ(palette.map(image, index.data(), 160), 0);
  EXPECT_EQ(palette.size(), 160);
  for (int y = 0; y < 100; ++y) {
    for (int x = 0; x < 160; ++x) {
      ASSERT_EQ(palette.colors()[index[static_cast<std::size_t>(y) * 160 + x]], image.at(x, y))
          << x << ", " << y;
    }
  }
  // Colours that it has not seen are noticed.
  EXPECT_GT(palette.map(noise(160, 100, 2, true), index.data(), 160), 0.5);
}

}  // namespace image_test
}  // namespace skerry::render
