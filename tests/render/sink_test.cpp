// SPDX-License-Identifier: MIT
#include <algorithm>
#include <csignal>
#include <fstream>
#include <gmock/gmock.h>
#include <iterator>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "render/error.h"
#include "render/frame_sink.h"
#include "render/output_file.h"
#include "tests/render/support.h"

namespace skerry::render {
namespace sink_test {

using testing::HasSubstr;

/// A picture with flat areas, an edge and a small moving square, as our scenes have.
Image test_frame(int width, int height, int index) {
  Image image(width, height, {251, 251, 249, 255});
  for (int y = height / 2; y < height; ++y) {
    for (int x = 0; x < width; ++x) image.set(x, y, {217, 214, 206, 255});
  }
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 12; ++x)
      image.set((x + 3 * index) % width, (y + height / 3) % height, {200, 50, 31, 255});
  }
  return image;
}

SinkReport encode(const std::filesystem::path& path, int frames, const SinkOptions& options = {},
                  int fps = 60, int width = 320, int height = 180) {
  const auto sink = make_sink(path, options);
  sink->begin({width, height, fps, "Cradle", "skerry capture cradle", {}});
  for (int i = 0; i < frames; ++i) {
    if (i == frames / 2) sink->chapter("impact");
    sink->frame(test_frame(width, height, i));
  }
  return sink->end();
}

std::string probe(const std::filesystem::path& path, const std::string& what) {
  const Output output = run("ffprobe -v error -of default=noprint_wrappers=1 " + what + " " + path.string());
  EXPECT_EQ(output.status, 0) << "ffprobe is needed (apt install ffmpeg), or cannot read " << path;
  return output.text;
}

std::string decoded_digest(const std::filesystem::path& path) {
  const Output output = run("ffmpeg -v error -i " + path.string() + " -f framemd5 -");
  EXPECT_EQ(output.status, 0);
  return output.text;
}

std::string bytes_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

TEST(VideoSink, Mp4IsConstantRateH264WithIndexInFrontAndMetadata) {
  const Scratch scratch;
  const auto path = scratch / "a.mp4";
  const SinkReport report = encode(path, 90);
  EXPECT_EQ(report.frames, 90);
  EXPECT_EQ(report.bytes, std::filesystem::file_size(path));
  const std::string stream = probe(path, "-count_frames -show_streams");
  for (const char* line :
       {"codec_name=h264", "pix_fmt=yuv420p", "r_frame_rate=60/1", "avg_frame_rate=60/1", "nb_read_frames=90",
        "width=320", "height=180", "color_space=bt709", "color_range=tv"}) {
    EXPECT_THAT(stream, HasSubstr(line));
  }
  // Constant rate: presentation times are equidistant.
  std::string text = probe(path, "-show_entries frame=pts_time");
  std::vector<double> times;
  for (std::size_t at = text.find('='); at != std::string::npos; at = text.find('=', at + 1)) {
    times.push_back(std::stod(text.substr(at + 1)));
  }
  ASSERT_EQ(times.size(), 90u);
  std::sort(times.begin(), times.end());
  for (std::size_t i = 1; i < times.size(); ++i) EXPECT_NEAR(times[i] - times[i - 1], 1.0 / 60, 1e-5);
  const std::string format = probe(path, "-show_format -show_chapters");
  EXPECT_THAT(format, HasSubstr("TAG:title=Cradle"));
  EXPECT_THAT(format, HasSubstr("TAG:comment=skerry capture cradle"));
  EXPECT_THAT(format, HasSubstr("TAG:title=impact"));
  EXPECT_THAT(format, HasSubstr("start_time=0.750000"));
  const std::string bytes = bytes_of(path);
  EXPECT_LT(bytes.find("moov"), bytes.find("mdat"));
}

TEST(VideoSink, SameFramesGiveTheSameFile) {
  const Scratch scratch;
  for (const char* name : {"a.mp4", "a.mkv", "a.webm", "a.gif"}) {
    encode(scratch / name, 30);
    const std::string first = bytes_of(scratch / name);
    encode(scratch / name, 30);
    EXPECT_TRUE(first == bytes_of(scratch / name)) << name;
    EXPECT_FALSE(decoded_digest(scratch / name).empty());
  }
}

TEST(VideoSink, PicturesKeepTheirColours) {
  const Scratch scratch;
  struct Case {
    const char* name;
    SinkOptions options;
    int tolerance;
  };
  for (const Case& c : {Case{"a.mp4", {}, 6}, Case{"sharp.mp4", {true, false, 18}, 6}, Case{"a.webm", {}, 6},
                        Case{"a.gif", {}, 0}, Case{"exact.mp4", {false, true, 18}, 0},
                        Case{"exact.mkv", {false, true, 18}, 0}, Case{"exact.webm", {false, true, 18}, 0}}) {
    encode(scratch / c.name, 12, c.options, 25);
    const auto still = scratch / "still.png";
    const std::string command = "ffmpeg -v error -y -i " + (scratch / c.name).string() +
                                " -vf scale=in_color_matrix=bt709:out_range=pc -frames:v 1 -pix_fmt rgb24 " +
                                still.string();
    ASSERT_EQ(run(command).status, 0) << c.name << ": ffmpeg is needed (apt install ffmpeg)";
    const Image decoded = read_png(still), original = test_frame(320, 180, 0);
    for (const auto& [x, y] : {std::pair{5, 64}, std::pair{200, 20}, std::pair{100, 150}}) {
      const Color a = decoded.at(x, y), b = original.at(x, y);
      EXPECT_NEAR(a.r, b.r, c.tolerance) << c.name << " at " << x << ", " << y;
      EXPECT_NEAR(a.g, b.g, c.tolerance) << c.name;
      EXPECT_NEAR(a.b, b.b, c.tolerance) << c.name;
    }
    if (c.tolerance == 0) {
      EXPECT_EQ(decoded.rgba, original.rgba) << c.name;
    }
  }
}

TEST(VideoSink, WebmIsVp9AndSharpKeepsFullColour) {
  const Scratch scratch;
  encode(scratch / "a.webm", 10);
  EXPECT_THAT(probe(scratch / "a.webm", "-show_streams"), HasSubstr("codec_name=vp9"));
  encode(scratch / "b.mkv", 10, {true, false, 18}, 60, 321, 179);
  const std::string stream = probe(scratch / "b.mkv", "-show_streams -show_chapters");
  EXPECT_THAT(stream, HasSubstr("pix_fmt=yuv444p"));
  EXPECT_THAT(stream, HasSubstr("width=321"));
  EXPECT_THAT(stream, HasSubstr("TAG:title=impact"));
}

TEST(VideoSink, GifPlaysAtItsRateAndLeavesFramesOutAboveFifty) {
  const Scratch scratch;
  encode(scratch / "a.gif", 50, {}, 25);
  EXPECT_THAT(probe(scratch / "a.gif", "-count_frames -show_entries stream=nb_read_frames"),
              HasSubstr("nb_read_frames=50"));
  encode(scratch / "b.gif", 60, {}, 60);
  EXPECT_THAT(probe(scratch / "b.gif", "-count_frames -show_entries stream=nb_read_frames"),
              HasSubstr("nb_read_frames=30"));
}

TEST(VideoSink, RepeatedFramesDecodeLikeFramesThatWereGivenAgain) {
  const Scratch scratch;
  for (const char* name : {"a.mp4", "a.gif", "a.txt"}) {
    for (const bool repeat : {false, true}) {
      const auto sink = make_sink(scratch / (std::string(repeat ? "r_" : "f_") + name));
      sink->begin({320, 180, 60, "", "", {}});
      for (int i = 0; i < 20; ++i) {
        if (repeat && i % 3 != 0) {
          sink->repeat();
        } else {
          sink->frame(test_frame(320, 180, i - i % 3));
        }
      }
      EXPECT_EQ(sink->end().frames, 20);
    }
    EXPECT_EQ(bytes_of(scratch / (std::string("r_") + name)), bytes_of(scratch / (std::string("f_") + name)))
        << name;
  }
}

TEST(VideoSink, OtherEncodersLoseNothingOrSayWhatTheyLack) {
  const Scratch scratch;
  const auto complaint = [&](const char* file, bool sharp, bool lossless, const char* encoder) {
    try {
      encode(scratch / file, 3, {.sharp = sharp, .lossless = lossless, .encoder = encoder});
    } catch (const std::exception& error) {
      EXPECT_EQ(scratch.files(), 0u) << encoder;
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_THAT(complaint("a.mkv", false, false, "aac"), HasSubstr("a.mkv: the encoder aac is none for video"));
  EXPECT_THAT(complaint("a.mkv", true, false, "mpeg4"),
              HasSubstr("the encoder mpeg4 does not take the pixels yuv444p of this matroska in full colour, "
                        "only yuv420p"));
  EXPECT_THAT(complaint("a.mkv", false, true, "mpeg4"), HasSubstr("pixels bgr0"));
  if (run("ffmpeg -v error -encoders").text.find(" libaom-av1 ") != std::string::npos) {
    EXPECT_THAT(complaint("a.webm", false, true, "libaom-av1"),
                HasSubstr("libaom-av1 has no option lossless"));
  }
  EXPECT_EQ(complaint("a.mkv", false, true, "ffv1"), "none");
}

TEST(FrameSink, LeavesNothingBehindWithoutEnd) {
  const Scratch scratch;
  for (const char* name : {"a.mp4", "a.mkv", "a.webm", "a.gif", "f_%04d.png", "a.png", "a.txt"}) {
    {
      const auto sink = make_sink(scratch / name);
      sink->begin({320, 180, 60, "", "", {}});
      for (int i = 0; i < 15; ++i) sink->frame(test_frame(320, 180, i));
    }
    EXPECT_EQ(scratch.files(), 0u) << name;
  }
}

// A killed process cannot clean up, but must not leave half a video under the final name.
TEST(FrameSink, AKilledCaptureLeavesNothingUnderTheFinalName) {
  const Scratch scratch;
  for (const char* name : {"a.mp4", "a.webm", "a.gif", "a.png"}) {
    const pid_t child = fork();
    if (child == 0) {
      const auto sink = make_sink(scratch / name);
      sink->begin({320, 180, 60, "", "", {}});
      for (int i = 0; i < 30; ++i) sink->frame(test_frame(320, 180, i));
      _exit(0);
    }
    int status = -1;
    waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
    EXPECT_FALSE(std::filesystem::exists(scratch / name)) << name;
  }
}

TEST(FrameSink, WritesThePngSequenceThatWasDrawn) {
  const Scratch scratch;
  EXPECT_EQ(encode(scratch / "f_%04d.png", 25).frames, 25);
  EXPECT_EQ(scratch.files(), 25u);
  EXPECT_EQ(read_png(scratch / "f_0017.png"), test_frame(320, 180, 17));
  encode(scratch / "folder/", 3);
  EXPECT_EQ(read_png(scratch / "folder/frame_000002.png"), test_frame(320, 180, 2));
  encode(scratch / "one.png", 5);
  EXPECT_EQ(read_png(scratch / "one.png"), test_frame(320, 180, 4));
}

TEST(FrameSink, DigestsTellFramesApart) {
  const Scratch scratch;
  encode(scratch / "a.hash", 3);
  const std::string text = bytes_of(scratch / "a.hash");
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4);
  char line[64];
  std::snprintf(line, sizeof line, "000002 %016llx\n",
                static_cast<unsigned long long>(digest(test_frame(320, 180, 2))));
  EXPECT_THAT(text, HasSubstr(line));
}

TEST(FrameSink, NamesTheFileThatCannotBeWritten) {
  const Scratch scratch;
  for (const char* name : {"a.mp4", "a.gif", "a.webm", "a.txt", "a.png", "f_%d.png"}) {
    const auto path = scratch / (std::string("missing/") + name);
    try {
      encode(path, 3);
      ADD_FAILURE() << "no exception for " << path;
    } catch (const EnvironmentError& error) {
      EXPECT_THAT(error.what(), HasSubstr(path.string()));
      EXPECT_THAT(error.what(), HasSubstr("o such"));
    }
  }
}

// A limit on the size of files acts like a full disk, without one: writes fail half way.
TEST(FrameSink, AFullDiskIsAnErrorThatLeavesNoFile) {
  const Scratch scratch;
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  rlimit tight = before;
  tight.rlim_cur = 1500;
  for (const char* name : {"a.mp4", "a.mkv", "a.webm", "a.gif", "f_%04d.png", "a.png", "a.txt"}) {
    setrlimit(RLIMIT_FSIZE, &tight);
    std::string message;
    try {
      encode(scratch / name, 90, {}, 60, 640, 480);
    } catch (const EnvironmentError& error) {
      message = error.what();
    }
    setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_THAT(message, HasSubstr((scratch / std::string(name).substr(0, 2)).string())) << name;
    EXPECT_THAT(message, HasSubstr("File too large")) << name;
    EXPECT_EQ(scratch.files(), 0u) << name;
  }
}

// So many that the names of the new ones do not fit into a short list.
TEST(FrameSink, AnOldPngSequenceStaysUntilTheNewOneIsComplete) {
  constexpr int kFrames = 70;
  const Scratch scratch;
  const auto path = scratch / "f_%02d.png";
  encode(path, kFrames, {}, 60, 32, 18);
  const auto expect_old = [&](const char* when) {
    EXPECT_EQ(scratch.files(), kFrames) << when;
    for (const int i : {0, 1, kFrames - 1}) {
      const auto file = scratch / ("f_" + std::string(i < 10 ? "0" : "") + std::to_string(i) + ".png");
      EXPECT_EQ(read_png(file), test_frame(32, 18, i)) << when;
    }
  };
  {
    const auto sink = make_sink(path);
    sink->begin({64, 18, 60, "", "", {}});
    for (int i = 0; i < kFrames; ++i) sink->frame(test_frame(64, 18, i));
  }
  expect_old("no end()");
  const pid_t child = fork();
  if (child == 0) {
    const auto sink = make_sink(path);
    sink->begin({64, 18, 60, "", "", {}});
    for (int i = 0; i < kFrames; ++i) sink->frame(test_frame(64, 18, i));
    while (scratch.files() < 2 * kFrames) usleep(1000);
    remove_unfinished_files();
    _exit(0);
  }
  waitpid(child, nullptr, 0);
  expect_old("a signal");
  std::filesystem::create_directory(scratch / "f_70.png");
  try {
    encode(path, kFrames + 1, {}, 60, 64, 18);
    ADD_FAILURE() << "no exception";
  } catch (const EnvironmentError& error) {
    EXPECT_THAT(error.what(), HasSubstr("f_70.png"));
  }
  std::filesystem::remove(scratch / "f_70.png");
  expect_old("the last one cannot be written");
}

// Only the last part of a name has a counter, and only "%d" is one.
TEST(FrameSink, PercentSignsAreNamesWhereTheyCount) {
  const Scratch scratch;
  std::filesystem::create_directory(scratch / "100%d");
  encode(scratch / "100%d/50%.png", 2, {}, 60, 32, 18);
  encode(scratch / "100%d/5%-%02d-%.png", 2, {}, 60, 32, 18);
  encode(scratch / "100%d/", 1, {}, 60, 32, 18);
  for (const char* name : {"50%.png", "5%-00-%.png", "5%-01-%.png", "frame_000000.png"})
    EXPECT_TRUE(std::filesystem::exists(scratch / (std::string("100%d/") + name))) << name;
}

TEST(FrameSink, NothingCanBeCalledAfterAnEndThatFailed) {
  const Scratch scratch;
  std::filesystem::create_symlink("/dev/full", scratch / "full.mkv");
  const auto sink = make_sink(scratch / "full.mkv");
  sink->begin({320, 180, 60, "", "", {}});
  sink->frame(test_frame(320, 180, 0));
  EXPECT_THROW(sink->end(), EnvironmentError);
  EXPECT_THROW(sink->end(), std::logic_error);
  EXPECT_THROW(sink->frame(test_frame(320, 180, 0)), std::logic_error);
}

TEST(FrameSink, RefusesWhatItCannotDo) {
  const Scratch scratch;
  EXPECT_THROW(make_sink("a.avi"), std::invalid_argument);
  EXPECT_THROW(make_sink("a_%s.png"), std::invalid_argument);
  EXPECT_THROW(make_sink("a_%d_%d.png"), std::invalid_argument);
  EXPECT_THROW(make_sink("a_%0123d.png"), std::invalid_argument);
  EXPECT_THROW(make_sink("a.mp4", {false, false, 99}), std::invalid_argument);
  const auto sink = make_sink(scratch / "a.mp4");
  EXPECT_THROW(sink->frame(test_frame(320, 180, 0)), std::logic_error);
  EXPECT_THROW(sink->begin({321, 180, 60, "", "", {}}), std::invalid_argument);
  EXPECT_THROW(sink->begin({320, 180, 0, "", "", {}}), std::invalid_argument);
  sink->begin({320, 180, 60, "", "", {}});
  EXPECT_THROW(sink->repeat(), std::logic_error);
  EXPECT_THROW(sink->frame(test_frame(322, 180, 0)), std::invalid_argument);
  EXPECT_THROW(sink->end(), std::logic_error);
}

TEST(FrameSink, TeeFeedsAll) {
  const Scratch scratch;
  std::vector<std::unique_ptr<FrameSink>> both;
  both.push_back(make_sink(scratch / "a.mp4"));
  both.push_back(make_sink(scratch / "a.txt"));
  const auto sink = tee(std::move(both));
  sink->begin({320, 180, 60, "", "", {}});
  sink->frame(test_frame(320, 180, 0));
  sink->repeat();
  EXPECT_EQ(sink->end().frames, 2);
  EXPECT_EQ(scratch.files(), 2u);
}

}  // namespace sink_test
}  // namespace skerry::render
