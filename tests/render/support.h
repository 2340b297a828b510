// SPDX-License-Identifier: MIT
//
// What the tests of the renderer share: a scratch folder, a GL context with one picture, running a program.
#pragma once

#include <cstdio>
#include <filesystem>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <string>

#include "render/canvas.h"
#include "render/egl_context.h"
#include "render/gl_renderer.h"
#include "render/image.h"
#include "render/image_diff.h"
#include "render/style.h"

namespace skerry::render {

/// A folder that is removed with everything in it.
class Scratch {
 public:
  Scratch() {
    std::string pattern = (std::filesystem::temp_directory_path() / "skerry_test_XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot make " + pattern);
    path_ = pattern;
  }
  ~Scratch() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::size_t files() const {
    std::size_t count = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(path_)) ++count;
    return count;
  }

 private:
  std::filesystem::path path_;
};

/// Standard output of a shell command, and its exit status.
struct Output {
  int status = -1;
  std::string text;
};
inline Output run(const std::string& command) {
  Output output;
  std::FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return output;
  char buffer[4096];
  while (const std::size_t got = std::fread(buffer, 1, sizeof buffer, pipe)) output.text.append(buffer, got);
  output.status = pclose(pipe);
  return output;
}

/// Software, so that every machine tests the same; with SKERRY_TEST_EGL=any the graphics processor where
/// there is one.
inline EglDevice test_device() {
  const char* wish = std::getenv("SKERRY_TEST_EGL");
  return wish != nullptr && std::string(wish) == "any" ? EglDevice::Any : EglDevice::Software;
}

/// A context, a renderer and a picture; 100 pixels a metre, the origin in the middle.
class GlTest : public testing::Test {
 protected:
  explicit GlTest(int width = 400, int height = 300) {
    camera.width_px = width;
    camera.height_px = height;
    camera.height = height / 100.0;
    list.background = {255, 255, 255, 255};
  }

  /// Drawn by OpenGL; the built-in rasteriser has to agree. What the two have in common is the list of
  /// instances: they blend and cover each for itself.
  Image draw(int ssaa = 1) {
    Target target(camera.width_px, camera.height_px, ssaa);
    stats = renderer.draw(list, camera, target);
    Image image, own;
    target.read(image);
    Canvas canvas(camera.width_px, camera.height_px, ssaa);
    const DrawStats same = canvas.draw(list, camera);
    canvas.take(own);
    EXPECT_EQ(same.shapes, stats.shapes);
    EXPECT_EQ(same.culled, stats.culled);
    expect_agreement(image, own);
    return image;
  }

  /// The rule of the golden images for another driver.
  static void expect_agreement(const Image& gl, const Image& own) {
    DiffRule rule;
    rule.other_driver = true;
    const DiffResult diff = compare(gl, own, rule);
    EXPECT_TRUE(diff.pass) << "the two renderers: " << diff.reason;
  }

  /// Sum of what is missing to white in the red channel, in pixels of full black.
  static double ink(const Image& image) {
    double sum = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) sum += 255 - image.rgba[i];
    return sum / 255;
  }

  EglContext context{test_device()};
  GlRenderer renderer;
  Camera camera;
  DrawList list;
  DrawStats stats;
};

inline constexpr Color kBlack{0, 0, 0, 255}, kWhite{255, 255, 255, 255}, kRed{200, 0, 0, 255},
    kBlue{0, 0, 200, 255};

}  // namespace skerry::render
