// SPDX-License-Identifier: MIT
//
// Captures from the command line to decoded frames. ffprobe and ffmpeg are the independent judges.
#include <csignal>
#include <cstdio>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <set>
#include <sys/resource.h>
#include <unistd.h>

#include "render/frame_sink.h"
#include "render/image.h"
#include "render/style.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "sandbox/painter.h"
#include "tests/sandbox/apart.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace capture_test {

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

TEST_F(Capture, PngSequenceHasOneFileAFrame) {
  ASSERT_EQ(capture({"free_fall", "-o", folder_ / "f%03d.png", "--seconds", "0.1", "--size", "320x180"}).code,
            kGood);
  EXPECT_EQ(folder_.files(), 6u);
}

TEST_F(Capture, PercentSignsCanBePartOfNames) {
  for (const char* name : {"50%.png", "50%/"}) {
    const Outcome outcome = capture({"free_fall", "-o", folder_ / name, "--at", "0.05", "--size", "320x180"});
    EXPECT_EQ(outcome.code, kGood) << outcome.err;
  }
  EXPECT_TRUE(std::filesystem::exists(folder_ / "50%.png"));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "50%/free_fall.png"));
}

TEST_F(Capture, AVeryFastOneHasOneFrame) {
  for (const char* name : {"x.gif", "x%d.png"}) {
    const Outcome outcome = capture(
        {"free_fall", "-o", folder_ / name, "--seconds", "0.01", "--speed", "1e6", "--size", "320x180"});
    EXPECT_EQ(outcome.code, kGood) << outcome.err;
  }
  EXPECT_TRUE(std::filesystem::exists(folder_ / "x0.png"));
  EXPECT_EQ(folder_.files(), 2u);
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

TEST_F(Capture, UnknownEncoderIsAnEnvironmentErrorWithItsName) {
  const Outcome outcome =
      capture({"free_fall", "-o", folder_ / "x.mp4", "--seconds", "0.1", "--encoder", "libnothing"});
  EXPECT_EQ(outcome.code, kEnvironmentError);
  EXPECT_THAT(outcome.err, HasSubstr("lacks the encoder libnothing"));
  EXPECT_EQ(folder_.files(), 0u);
}

TEST_F(Capture, EveryContainerHasItsCodecTitleCommandAndChapters) {
  if (!have_ffprobe()) GTEST_SKIP() << "no ffprobe; apt install ffmpeg";
  const std::string demo =
      folder_.write("notes.lua",
                    "demo{ title = 'Notes', seconds = 0.4, view = { x = 0, y = 0, height = 4 } }\n"
                    "disc{ at = {0, 1}, radius = 0.3 }\n"
                    "at(0.1, function() note('first') end)\nat(0.2, function() note('second') end)\n");
  const struct {
    const char* name;
    std::vector<std::string> options;
    const char* codec;
    bool chapters;
  } cases[] = {{"c.mp4", {}, "codec_name=h264", true},
               {"s.mp4", {"--sharp"}, "pix_fmt=yuv444p", true},
               {"l.mkv", {"--lossless"}, "codec_name=h264", true},
               {"c.mkv", {"--encoder", "mpeg4"}, "codec_name=mpeg4", true},
               {"c.webm", {}, "codec_name=vp9", true},
               {"c.gif", {}, "codec_name=gif", false}};
  for (const auto& c : cases) {
    const std::string path = folder_ / c.name;
    std::vector<std::string> arguments{demo, "-o", path, "--size", "320x180", "--fps", "30"};
    arguments.insert(arguments.end(), c.options.begin(), c.options.end());
    const Outcome outcome = capture(arguments);
    ASSERT_EQ(outcome.code, kGood) << c.name << outcome.err;
    const std::string probe =
        shell("ffprobe -v error -count_frames -show_streams -show_format -show_chapters " + path);
    EXPECT_THAT(probe, HasSubstr(c.codec)) << c.name;
    EXPECT_THAT(probe, HasSubstr("nb_read_frames=12")) << c.name << outcome.out << outcome.err;
    if (!c.chapters) continue;
    for (const char* fact : {"title=Notes", "skerry capture", "title=first", "title=second"})
      EXPECT_THAT(probe, testing::AnyOf(HasSubstr(fact), HasSubstr(std::string("TAG:") + fact))) << c.name;
  }
}

TEST_F(Capture, SeveralDemosBecomeSeveralVideos) {
  const Outcome outcome = capture({"stack", "free_fall", "-o", folder_ / "out/", "--seconds", "0.1", "--size",
                                   "320x180", "--theme", "dark", "--ssaa", "2"});
  ASSERT_EQ(outcome.code, kGood) << outcome.err;
  for (const char* name : {"out/stack.mp4", "out/free_fall.mp4"})
    EXPECT_GT(std::filesystem::file_size(folder_ / name), 1000u);
}

// Slow motion of a scene at rest: only the clock changes, every sixth frame; the others are not drawn again.
TEST_F(Capture, AnUnchangedFrameIsNeitherDrawnNorConvertedAgain) {
  const std::string demo =
      folder_.write("still.lua",
                    "demo{ title = 'Still', seconds = 0.01, dt = 0.01, gravity = {0, 0},\n"
                    "      view = { x = 0, y = 0, height = 4 } }\n"
                    "box{ at = {0, 0}, size = {1, 1} }\n");
  const Outcome outcome =
      capture({demo, "-o", folder_ / "s.mp4", "--size", "320x180", "--speed", "0.01", "--seconds", "0.01"});
  ASSERT_EQ(outcome.code, kGood) << outcome.err;
  // 60 frames show 0.000 s to 0.010 s: eleven pictures.
  EXPECT_THAT(outcome.out, HasSubstr("60 frames, 49 of them unchanged")) << outcome.out;
  // Where something moves every frame is new.
  const Outcome moving =
      capture({"free_fall", "-o", folder_ / "m.mp4", "--size", "320x180", "--seconds", "0.2"});
  EXPECT_THAT(moving.out, testing::Not(HasSubstr("unchanged")));
}

TEST_F(Capture, SmallAndNarrowPicturesLeaveOutWhatHasNoRoom) {
  const std::string demo =
      folder_.write("one.lua",
                    "demo{ title = 'One', lesson = 'A long lesson about one disc.',\n"
                    "      view = { x = 0, y = 0, height = 4 } }\n"
                    "disc{ at = {0, 0}, radius = 1.5, type = 'static', color = 'vermilion' }\n");
  const std::string all = "energy,momentum,skips,profile,matrix,factor,solver,checks,compare,timeline";
  const render::Color fill = render::body_paint(render::style(render::Theme::Light), 3).fill;
  for (const auto& [width, height] : {std::pair{160, 90}, {16, 16}, {90, 160}, {96, 400}, {1080, 1920}}) {
    const std::string size = std::to_string(width) + "x" + std::to_string(height);
    const Outcome outcome =
        capture({demo, "-o", folder_ / "p.png", "--at", "0", "--size", size, "--overlay", all});
    ASSERT_EQ(outcome.code, kGood) << size << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr("no room for")) << size;
    const render::Image image = render::read_png(folder_ / "p.png");
    ASSERT_EQ(image.width, width);
    ASSERT_EQ(image.height, height);
    int filled = 0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) filled += image.at(x, y) == fill;
    EXPECT_GT(filled, std::min(width, height) * std::min(width, height) / 8) << size;
  }
}

// Without words nothing in the picture of a stack at rest changes.
TEST_F(Capture, FramesThatAreKeptLookLikeThoseThatAreDrawnAgain) {
  for (const bool reuse : {true, false}) {
    Demo demo(find_demo("stack", demo_tree()).path, {});
    const History history(demo, false, kFlashSeconds);
    PaintOptions options;
    options.width = 256;
    options.height = 144;
    options.reuse = reuse;
    Painter painter(options);
    painter.start(demo, {});
    render::Image first, image;
    painter.paint(demo, history, first);
    image = first;
    for (int frame = 0; frame < 20; ++frame) {
      demo.step();
      EXPECT_EQ(painter.paint(demo, history, image), !reuse) << frame;
      EXPECT_TRUE(image == first) << frame;
    }
  }
}

long resident_kib() {
  std::ifstream file("/proc/self/statm");
  long pages = 0, resident = 0;
  file >> pages >> resident;
  return resident * (sysconf(_SC_PAGESIZE) / 1024);
}

// The whole ten minutes: render_capture_bench 1 10 36000. A picture a frame would be 20 MiB here.
TEST_F(Capture, MemoryStaysFlat) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "freed memory is kept for a while";
#endif
  const std::vector<std::string> names{"contacts", "impulses"};
  Demo demo(find_demo("newtons_cradle", demo_tree()).path, {.seconds = 100});
  demo.observe(needs_of(names));
  History history(demo, true, kFlashSeconds);
  Painter painter({.width = 160, .height = 90});
  painter.start(demo, names);
  const auto sink = render::make_sink(folder_ / "long.mp4");
  sink->begin({.width = 160, .height = 90, .fps = 60, .title = "", .comment = "", .chapters = {}});
  render::Image image;
  long before = 0;
  for (int frame = 0; frame < 500; ++frame) {
    demo.step();
    history.update(demo);
    painter.paint(demo, history, image) ? sink->frame(image) : sink->repeat();
    // By then the encoder's look-ahead is full.
    if (frame == 150) before = resident_kib();
  }
  EXPECT_LT(resident_kib() - before, 4096);
  sink->end();
}

TEST_F(Capture, FullDiskIsAnEnvironmentErrorThatLeavesNoFile) {
  for (const char* name : {"x.mp4", "x.mkv", "x.webm", "x.gif", "f%04d.png", "x.png"}) {
    const std::string path = folder_ / name;
    std::vector<std::string> arguments{"capture", "--demos", demo_tree(), "newtons_cradle",
                                       "-o",      path,      "--size",    "320x180"};
    if (std::string(name) == "x.png")
      arguments.insert(arguments.end(), {"--at", "0.2"});
    else
      arguments.insert(arguments.end(), {"--seconds", "0.5"});
    const TemporaryFolder elsewhere;
    const int code = run_apart(
        arguments, elsewhere / "err",
        [] {
          // Files may not grow beyond 2 KiB: writing fails as on a full disk.
          signal(SIGXFSZ, SIG_DFL);
          const rlimit limit{2048, 2048};
          setrlimit(RLIMIT_FSIZE, &limit);
        },
        [](pid_t) {});
    const std::string message = read_file(elsewhere / "err");
    EXPECT_EQ(code, kEnvironmentError) << name << message;
    EXPECT_THAT(message, HasSubstr(folder_ / std::string(name).substr(0, 1)));
    EXPECT_EQ(folder_.files(), 0u) << name;
  }
}

TEST_F(Capture, CtrlCFinishesTheFile) {
  if (!have_ffprobe()) GTEST_SKIP() << "no ffprobe; apt install ffmpeg";
  const std::string path = folder_ / "long.mp4";
  const TemporaryFolder elsewhere;
  const int code = run_apart(
      {"capture", "--demos", demo_tree(), "newtons_cradle", "-o", path, "--size", "320x180", "--seconds",
       "3600"},
      elsewhere / "err", [] {},
      [&](pid_t child) {
        // Not before there is something to finish.
        for (int i = 0; i < 3000 && unfinished_bytes(folder_) <= 8192; ++i) usleep(10000);
        kill(child, SIGINT);
      });
  EXPECT_EQ(code, kInterrupted) << "it is not all that was asked for";
  EXPECT_THAT(read_file(elsewhere / "err"), HasSubstr("long.mp4 ends after "));
  const std::string probe = shell("ffprobe -v error -count_frames -show_streams " + path);
  EXPECT_THAT(probe, HasSubstr("codec_name=h264"));
  EXPECT_THAT(probe, testing::Not(HasSubstr("nb_read_frames=0")));
  EXPECT_EQ(folder_.files(), 1u);
}

TEST_F(Capture, SignalsThatEndItAtOnceLeaveNoUnfinishedFile) {
  for (const int number : {SIGPIPE, SIGQUIT}) {
    const TemporaryFolder elsewhere;
    bool begun = false;
    const int code = run_apart(
        {"capture", "--demos", demo_tree(), "newtons_cradle", "-o", folder_ / "long.mp4", "--size", "320x180",
         "--seconds", "3600"},
        elsewhere / "err",
        [number] {
          signal(number, SIG_DFL);
          const rlimit no_core{0, 0};
          setrlimit(RLIMIT_CORE, &no_core);
        },
        [&](pid_t child) {
          for (int i = 0; i < 3000 && folder_.files() == 0; ++i) usleep(10000);
          begun = folder_.files() > 0;
          kill(child, number);
        });
    EXPECT_TRUE(begun);
    EXPECT_EQ(code, -1) << number;
    EXPECT_EQ(folder_.files(), 0u) << number;
  }
}

TEST_F(Capture, ExportPlotsEnergyAndResiduals) {
  const std::string plot = folder_ / "p.svg";
  for (const auto& [curves, words] :
       {std::pair("energy", "potential"), std::pair("residual", "worst residual of the islands")}) {
    const Outcome outcome =
        run({"export", "--demos", demo_tree(), "stack", "--at", "0.5", "--plot", plot, "--curves", curves});
    ASSERT_EQ(outcome.code, kGood) << outcome.err;
    EXPECT_THAT(read_file(plot), HasSubstr(words));
  }
}

TEST_F(Capture, ExportWritesTheFrameAndCurvesAsFigures) {
  const std::string svg = folder_ / "f.svg", png = folder_ / "f.png", plot = folder_ / "p.svg";
  const Outcome outcome = run({"export", "--demos", demo_tree(), "four_body_chain", "--at", "0.6", "--svg",
                               svg, "--png", png, "--plot", plot, "--curves", "momentum"});
  ASSERT_EQ(outcome.code, kGood) << outcome.err;
  const std::string figure = read_file(svg);
  // Panels are text, not pixels.
  for (const char* words : {"<svg ", "Four bodies, four contacts", "Matrix W and impulses", "</svg>"})
    EXPECT_THAT(figure, HasSubstr(words));
  EXPECT_THAT(read_file(plot), HasSubstr("angular momentum"));
  EXPECT_EQ(render::read_png(png).width, 1280);
  if (shell("xmllint --version").rfind("failed", 0) != 0) {
    EXPECT_EQ(shell("xmllint --noout " + svg), "");
    EXPECT_EQ(shell("xmllint --noout " + plot), "");
  }
  EXPECT_EQ(run({"export", "--demos", demo_tree(), "four_body_chain"}).code, kUsage);
  EXPECT_EQ(run({"export", "--demos", demo_tree(), "four_body_chain", "--plot", plot, "--curves", "x"}).code,
            kUsage);
  EXPECT_EQ(run({"export", "--demos", demo_tree(), "free_fall", "--at", "0", "--svg", "/proc/x.svg"}).code,
            kEnvironmentError);
}

}  // namespace capture_test
}  // namespace skerry::sandbox
