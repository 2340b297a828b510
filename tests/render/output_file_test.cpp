// SPDX-License-Identifier: MIT
#include "render/output_file.h"

#include <fcntl.h>
#include <fstream>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iterator>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

#include "render/error.h"
#include "render/frame_sink.h"
#include "render/image.h"
#include "render/utf8.h"
#include "tests/render/support.h"

namespace skerry::render {
namespace output_file_test {

namespace fs = std::filesystem;
using testing::HasSubstr;

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void write_text(const fs::path& path, const std::string& text) {
  write_file(path, text.data(), text.size());
}

std::string complaint(const fs::path& path) {
  try {
    write_text(path, "x");
  } catch (const EnvironmentError& error) {
    return error.what();
  }
  return "none";
}

TEST(OutputFile, LinksStayAndTheirTargetsAreReplaced) {
  const Scratch scratch;
  fs::create_directory(scratch / "there");
  fs::create_symlink("there/real.txt", scratch / "near");
  fs::create_symlink("near", scratch / "far");
  for (const char* text : {"the target is not there yet", "now it is"}) {
    write_text(scratch / "far", text);
    EXPECT_TRUE(fs::is_symlink(scratch / "far"));
    EXPECT_TRUE(fs::is_symlink(scratch / "near"));
    EXPECT_EQ(text_of(scratch / "there/real.txt"), text);
  }
  EXPECT_EQ(scratch.files(), 3u);
  fs::create_symlink("b", scratch / "a");
  fs::create_symlink("a", scratch / "b");
  EXPECT_THAT(complaint(scratch / "a"), HasSubstr("symbolic links"));
}

TEST(OutputFile, FifosAndDevicesGetTheBytes) {
  const Scratch scratch;
  const fs::path fifo = scratch / "pipe";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  std::string got;
  std::thread reader([&] { got = text_of(fifo); });
  write_text(fifo, "through");
  reader.join();
  EXPECT_EQ(got, "through");
  EXPECT_TRUE(fs::is_fifo(fifo));
  write_text("/dev/null", "nothing");
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  EXPECT_THAT(complaint("/dev/full"), HasSubstr("/dev/full: cannot write: No space left"));
  fs::create_symlink("/dev/full", scratch / "full.txt");
  EXPECT_THAT(complaint(scratch / "full.txt"), HasSubstr("full.txt: cannot write: No space left"));
  EXPECT_EQ(scratch.files(), 2u);
}

TEST(OutputFile, OpenDescriptorsGoOnWhereTheyAre) {
  const Scratch scratch;
  const int file = open((scratch / "log").c_str(), O_WRONLY | O_CREAT, 0600);
  ASSERT_GE(file, 0);
  ASSERT_EQ(write(file, "one ", 4), 4);
  write_text("/dev/fd/" + std::to_string(file), "two ");
  ASSERT_EQ(write(file, "three", 5), 5);
  close(file);
  EXPECT_EQ(text_of(scratch / "log"), "one two three");
  EXPECT_EQ(descriptor_of("/dev/stdout"), STDOUT_FILENO);
  EXPECT_EQ(descriptor_of(scratch / "log"), -1);
}

TEST(OutputFile, TwoOnTheirWayToOneNameDoNotMeet) {
  const Scratch scratch;
  OutputFile one(scratch / "x"), other(scratch / "x");
  EXPECT_NE(one.target(), other.target());
  one.write("one", 3);
  other.write("other", 5);
  one.finish();
  EXPECT_EQ(text_of(scratch / "x"), "one");
  other.finish();
  EXPECT_EQ(text_of(scratch / "x"), "other");
  EXPECT_EQ(scratch.files(), 1u);
}

TEST(OutputFile, WhatIsNotFinishedLeavesTheOldFile) {
  const Scratch scratch;
  write_text(scratch / "x", "old");
  ASSERT_EQ(chmod((scratch / "x").c_str(), 0640), 0);
  { OutputFile(scratch / "x").write("new", 3); }
  EXPECT_EQ(text_of(scratch / "x"), "old");
  OutputFile cut(scratch / "x");
  remove_unfinished_files();
  EXPECT_EQ(scratch.files(), 1u);
  write_text(scratch / "x", "new");
  struct stat status {};
  ASSERT_EQ(stat((scratch / "x").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777u, 0640u);
  const std::string longest(250, 'n');
  write_text(scratch / longest, "as long as a name may be");
  EXPECT_EQ(scratch.files(), 2u);
  EXPECT_THAT(complaint(scratch / ""), HasSubstr("Is a directory"));
}

TEST(OutputFile, VideosThatNeedNoWayBackGoThroughFifos) {
  const Scratch scratch;
  for (const char* name : {"a.mkv", "a.gif"}) {
    ASSERT_EQ(mkfifo((scratch / name).c_str(), 0600), 0);
    std::string got;
    std::thread reader([&] { got = text_of(scratch / name); });
    const auto sink = make_sink(scratch / name);
    sink->begin({320, 180, 30, "", "", {}});
    for (int i = 0; i < 4; ++i) sink->frame(Image(320, 180, {static_cast<std::uint8_t>(60 * i), 9, 9, 255}));
    const SinkReport report = sink->end();
    reader.join();
    EXPECT_EQ(report.bytes, got.size()) << name;
    std::ofstream(scratch / "copy", std::ios::binary) << got;
    EXPECT_THAT(run("ffprobe -v error -count_frames -show_streams " + (scratch / "copy").string()).text,
                HasSubstr("nb_read_frames=4"))
        << name;
  }
  ASSERT_EQ(mkfifo((scratch / "a.mp4").c_str(), 0600), 0);
  const auto sink = make_sink(scratch / "a.mp4");
  EXPECT_THROW(sink->begin({320, 180, 30, "", "", {}}), std::invalid_argument);
}

TEST(Utf8, BytesThatAreNoneAreReplaced) {
  EXPECT_EQ(valid_utf8("caf\xC3\xA9 \xF0\x9F\x98\x80"), "caf\xC3\xA9 \xF0\x9F\x98\x80");
  EXPECT_EQ(valid_utf8("caf\xE9"), "caf\xEF\xBF\xBD");
  EXPECT_EQ(valid_utf8("\xC0\x80"), "\xEF\xBF\xBD");          // overlong
  EXPECT_EQ(valid_utf8("\xED\xA0\x80"), "\xEF\xBF\xBD");      // surrogate
  EXPECT_EQ(valid_utf8("\xF7\xBF\xBF\xBF"), "\xEF\xBF\xBD");  // beyond the last one
  EXPECT_EQ(valid_utf8("a\xC3"), "a\xEF\xBF\xBD");
}

}  // namespace output_file_test
}  // namespace skerry::render
