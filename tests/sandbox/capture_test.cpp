// SPDX-License-Identifier: MIT
//
// Captures from the command line to decoded frames. ffprobe and ffmpeg are the independent judges.
#include <cstdio>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <set>

#include "render/image.h"
#include "sandbox/errors.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace {

using testing::HasSubstr;

std::string shell(const std::string& command) {
  std::string text;
  FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  char buffer[4096];
  while (const std::size_t count = fread(buffer, 1, sizeof buffer, pipe)) text.append(buffer, count);
  return pclose(pipe) == 0 ? text : "failed: " + text;
}

bool have_ffprobe() {
  return shell("ffprobe -version").rfind("failed", 0) != 0;
}

class Capture : public testing::Test {
 protected:
  Outcome capture(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"capture", "--demos", demo_tree()});
    return run(arguments);
  }
  TemporaryFolder folder_;
};

TEST_F(Capture, VideoIsH264ThatEveryPlayerTakes) {
  if (!have_ffprobe()) GTEST_SKIP() << "no ffprobe; apt install ffmpeg";
  const std::string path = folder_ / "c.mp4";
  const Outcome outcome =
      capture({"newtons_cradle", "-o", path, "--seconds", "0.6", "--size", "640x360", "--fps", "30"});
  // The clip ends before the checks are due.
  ASSERT_EQ(outcome.code, kGood) << outcome.out << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("c.mp4: 0.60 s, 18 frames, "));
  const std::string probe = shell("ffprobe -v error -count_frames -show_streams -show_format " + path);
  for (const char* fact : {"codec_name=h264", "pix_fmt=yuv420p", "width=640", "height=360",
                           "r_frame_rate=30/1", "avg_frame_rate=30/1", "nb_read_frames=18",
                           "TAG:title=Newton's cradle", "TAG:comment=skerry capture"})
    EXPECT_THAT(probe, HasSubstr(fact));
  // faststart: the index comes before the pictures.
  const std::string bytes = read_file(path);
  EXPECT_LT(bytes.find("moov"), bytes.find("mdat"));
  EXPECT_EQ(folder_.files(), 1u) << "no partial file is left";
}

TEST_F(Capture, TwoCapturesDecodeToTheSameFrames) {
  if (!have_ffprobe()) GTEST_SKIP() << "no ffmpeg; apt install ffmpeg";
  std::string sums[2];
  for (int i = 0; i < 2; ++i) {
    const std::string path = folder_ / (std::to_string(i) + ".mp4");
    ASSERT_EQ(capture({"four_body_chain", "-o", path, "--seconds", "0.5", "--size", "640x360"}).code, kGood);
    sums[i] = shell("ffmpeg -v error -i " + path + " -f framemd5 -");
  }
  EXPECT_THAT(sums[0], HasSubstr("#format: frame checksums"));
  EXPECT_EQ(sums[0], sums[1]);
}

// Distinct colours, and the share of pixels that are not background.
struct Content {
  std::size_t colors = 0;
  double covered = 0;
};

Content content_of(const render::Image& image) {
  std::set<std::uint32_t> colors;
  const render::Color background = image.at(image.width / 3, image.height - 45 * image.height / 720);
  std::size_t covered = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const render::Color c = image.at(x, y);
      colors.insert(static_cast<std::uint32_t>(c.r << 16 | c.g << 8 | c.b));
      covered += !(c == background);
    }
  }
  return {colors.size(), static_cast<double>(covered) / (image.width * image.height)};
}

TEST_F(Capture, StillShowsTheSceneInBothThemes) {
  for (const char* theme : {"light", "dark"}) {
    const std::string path = folder_ / (std::string(theme) + ".png");
    const Outcome outcome = capture({"four_body_chain", "-o", path, "--at", "0.3", "--theme", theme});
    ASSERT_EQ(outcome.code, kGood) << outcome.err;
    const Content content = content_of(render::read_png(path));
    EXPECT_GT(content.colors, 200u);
    EXPECT_GT(content.covered, 0.03);
  }
  EXPECT_FALSE(render::read_png(folder_ / "light.png") == render::read_png(folder_ / "dark.png"));
}

TEST_F(Capture, EveryOverlayChangesThePicture) {
  const auto picture = [&](const std::string& overlay) {
    const std::string path = folder_ / "o.png";
    const Outcome outcome =
        capture({"stack", "-o", path, "--at", "0.3", "--size", "640x360", "--overlay", overlay});
    EXPECT_EQ(outcome.code, kGood) << overlay << outcome.err;
    return render::read_png(path);
  };
  const render::Image bare = picture("none");
  // Nothing moves in this demo, so there are no velocities to see.
  for (const char* overlay : {"contacts", "impulses", "islands", "matrix", "energy", "checks"})
    EXPECT_FALSE(picture(std::string("none,") + overlay) == bare) << overlay;
}

TEST_F(Capture, PngSequenceHasOneFileAFrame) {
  ASSERT_EQ(capture({"free_fall", "-o", folder_ / "f%03d.png", "--seconds", "0.1", "--size", "320x180"}).code,
            kGood);
  EXPECT_EQ(folder_.files(), 6u);
}

TEST_F(Capture, FolderTakesSeveralDemosByName) {
  const Outcome outcome =
      capture({"stack", "free_fall", "-o", folder_ / "out/", "--at", "0.1", "--size", "320x180"});
  ASSERT_EQ(outcome.code, kGood) << outcome.err;
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/stack.png"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/free_fall.png"));
}

TEST_F(Capture, SlowMotionMovesInEveryFrame) {
  const std::string path = folder_ / "h.hash";
  ASSERT_EQ(
      capture({"free_fall", "-o", path, "--seconds", "0.02", "--speed", "0.1", "--size", "320x180"}).code,
      kGood);
  std::istringstream lines(read_file(path));
  std::set<std::string> distinct;
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) distinct.insert(line);
  EXPECT_GE(count, 12);
  EXPECT_GE(distinct.size(), 12u);
}

TEST_F(Capture, UnwritablePathIsAnEnvironmentErrorWithTheName) {
  const Outcome outcome = capture({"free_fall", "-o", "/proc/skerry/x.mp4", "--seconds", "0.1"});
  EXPECT_EQ(outcome.code, kEnvironmentError);
  EXPECT_THAT(outcome.err, HasSubstr("/proc/skerry/x.mp4"));
}

TEST_F(Capture, FullDiskLeavesNoFileAndSaysSo) {
  // /dev/full takes no byte; a link to it in the place of the partial file is a full disk.
  const std::string path = folder_ / "x.png";
  std::filesystem::create_symlink("/dev/full", path + ".part");
  const Outcome outcome = capture({"free_fall", "-o", path, "--at", "0.1", "--size", "320x180"});
  if (outcome.code == kGood) GTEST_SKIP() << "the partial file has another name";
  EXPECT_EQ(outcome.code, kEnvironmentError);
  EXPECT_THAT(outcome.err, HasSubstr("x.png"));
  EXPECT_FALSE(std::filesystem::exists(path));
}

}  // namespace
}  // namespace skerry::sandbox
