// SPDX-License-Identifier: MIT
//
// The command `skerry golden`, its files, and what its scenes must cover.
#include "sandbox/golden.h"

#include <algorithm>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <set>

#include "render/image.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "sandbox/report.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace golden_test {

using testing::HasSubstr;
using testing::Not;

constexpr const char* kDemo =
    "demo{ title = 'Fall', lesson = 'It falls.', view = { x = 0, y = 1, height = 4 } }\n"
    "ground{}\n"
    "disc{ at = {0, 2}, radius = 0.25, mass = 1 }\n";

// A folder with one demo and two scenes, blessed.
class Golden : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_ / "demos");
    std::filesystem::create_directories(folder_ / "golden");
    folder_.write("demos/fall.lua", kDemo);
    scenes("early fall --at 0.1 --size 160x90\nlate fall --at 0.3 --size 160x90 --theme dark\n");
    const Outcome outcome = golden({"--bless"});
    ASSERT_EQ(outcome.code, kGood) << outcome.out << outcome.err;
    ASSERT_THAT(outcome.out, HasSubstr("blessed 2 pictures and 2 states"));
  }
  void scenes(const std::string& rows) { folder_.write("golden/scenes.txt", rows); }
  Outcome golden(std::vector<std::string> words) {
    words.insert(words.begin(), {"golden", "--demos", folder_ / "demos", "--folder", folder_ / "golden"});
    return run(words);
  }
  render::Image picture(const std::string& name) {
    return render::read_png(folder_ / ("golden/" + name + ".png"));
  }
  void write(const std::string& name, const render::Image& image) {
    render::write_png(folder_ / ("golden/" + name + ".png"), image);
  }
  // Replaces the accepted digests of all scenes, so that pixels decide.
  void forget_digests() {
    std::vector<Accepted> list = read_accepted(folder_ / "golden/accepted.txt");
    for (Accepted& entry : list) entry.digests = {1};
    write_accepted(folder_ / "golden/accepted.txt", list);
  }
  TemporaryFolder folder_;
};

TEST_F(Golden, WhatWasBlessedPasses) {
  const Outcome outcome = golden({});
  EXPECT_EQ(outcome.code, kGood) << outcome.out;
  EXPECT_THAT(outcome.out, HasSubstr("2 scenes: 0 pictures and 0 states are not as blessed"));
}

TEST_F(Golden, AcceptedDigestsPassWithoutThePng) {
  std::filesystem::remove(folder_ / "golden/early.png");
  EXPECT_EQ(golden({}).code, kGood);
  forget_digests();
  const Outcome outcome = golden({"early"});
  EXPECT_EQ(outcome.code, kCheckFailed);
  EXPECT_THAT(outcome.out, HasSubstr("early.png is missing"));
}

TEST_F(Golden, RoundingPassesAndMoreDoesNot) {
  forget_digests();
  EXPECT_EQ(golden({}).code, kGood) << "same pixels, unknown digest";
  render::Image image = picture("early");
  render::Color c = image.at(80, 45);
  c.g = static_cast<std::uint8_t>(c.g > 128 ? c.g - 2 : c.g + 2);
  image.set(80, 45, c);
  write("early", image);
  EXPECT_EQ(golden({"early"}).code, kGood);
  c.g = static_cast<std::uint8_t>(c.g > 128 ? c.g - 1 : c.g + 1);
  image.set(80, 45, c);
  write("early", image);
  const Outcome outcome = golden({"early"});
  EXPECT_EQ(outcome.code, kCheckFailed);
  EXPECT_THAT(outcome.out, HasSubstr("picture differs, state as blessed"));
  EXPECT_THAT(outcome.out, HasSubstr("the largest has 1 at (80, 45), 1 x 1 px"));
}

TEST_F(Golden, AnotherDriverMayMoveSinglePixels) {
  std::vector<Accepted> list = read_accepted(folder_ / "golden/accepted.txt");
  for (Accepted& entry : list) {
    entry.digests = {1};
    entry.driver = "another driver";
  }
  write_accepted(folder_ / "golden/accepted.txt", list);
  render::Image image = picture("early");
  for (int i = 0; i < 30; ++i) image.set(5 * i, 40, {200, 30, 30, 255});
  write("early", image);
  EXPECT_EQ(golden({"early"}).code, kGood);
  for (int i = 0; i < 9; ++i) image.set(10 + i, 60, {200, 30, 30, 255});
  write("early", image);
  EXPECT_EQ(golden({"early"}).code, kCheckFailed);
}

TEST_F(Golden, StateAndPictureAreJudgedApart) {
  // The same picture of another state: the body moves a little, far outside of the frame.
  folder_.write("demos/fall.lua", std::string(kDemo) + "disc{ at = {1000, 50}, radius = 0.25, mass = 1 }\n");
  Outcome outcome = golden({});
  EXPECT_EQ(outcome.code, kCheckFailed);
  EXPECT_THAT(outcome.out, HasSubstr("early: picture as blessed, state moved"));
  EXPECT_THAT(outcome.out, HasSubstr("2 scenes: 0 pictures and 2 states are not as blessed"));
  // The same state in another picture.
  std::string aside = kDemo;
  aside.replace(aside.find("x = 0,"), 6, "x = 0.5,");
  folder_.write("demos/fall.lua", aside);
  outcome = golden({});
  EXPECT_THAT(outcome.out, HasSubstr("early: picture differs, state as blessed"));
  EXPECT_THAT(outcome.out, HasSubstr("2 scenes: 2 pictures and 0 states are not as blessed"));
}

TEST_F(Golden, BlessingRewritesOnlyWhatMoved) {
  const auto age = [&](const char* name) {
    return std::filesystem::last_write_time(folder_ / (std::string("golden/") + name + ".png"));
  };
  const auto early = age("early");
  scenes("early fall --at 0.1 --size 160x90\nlate fall --at 0.2 --size 160x90\n");
  const Outcome outcome = golden({"--bless"});
  EXPECT_EQ(outcome.code, kGood);
  EXPECT_THAT(outcome.out, HasSubstr("blessed 1 pictures and 1 states"));
  EXPECT_EQ(age("early"), early);
  EXPECT_EQ(golden({}).code, kGood);
  // Scenes that are gone take their pictures along.
  scenes("late fall --at 0.2 --size 160x90\n");
  EXPECT_EQ(golden({"--bless"}).code, kGood);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "golden/early.png"));
  EXPECT_EQ(read_accepted(folder_ / "golden/accepted.txt").size(), 1u);
}

TEST_F(Golden, RoundingIsRememberedByBlessing) {
  std::vector<Accepted> list = read_accepted(folder_ / "golden/accepted.txt");
  const std::uint64_t digest = list[0].digests[0];
  list[0].digests[0] = 1;
  write_accepted(folder_ / "golden/accepted.txt", list);
  EXPECT_EQ(golden({"--bless"}).code, kGood);
  list = read_accepted(folder_ / "golden/accepted.txt");
  EXPECT_THAT(list[0].digests, testing::ElementsAre(1u, digest));
}

TEST_F(Golden, ScenesAreChosenByNameOrPrefix) {
  EXPECT_THAT(golden({"late"}).out, HasSubstr("1 scenes"));
  EXPECT_THAT(golden({"e*", "late"}).out, HasSubstr("2 scenes"));
  const Outcome outcome = golden({"lata"});
  EXPECT_EQ(outcome.code, kUsage);
  EXPECT_THAT(outcome.err, HasSubstr("did you mean \"late\""));
  EXPECT_THAT(golden({"--list"}).out, HasSubstr("late  fall --at 0.3 --size 160x90 --theme dark"));
}

TEST_F(Golden, BrokenRowsAndScriptsAreNamed) {
  for (const auto& [row, message] :
       {std::pair{"early fall", "--at"},
        std::pair{"early fall --at 0.1 --overlay contact", "did you mean \"contacts\""},
        std::pair{"early fall --at 0.1 --theme blue", "light or dark"},
        std::pair{"early fall --at 0.1\nearly fall --at 0.2", "scenes.txt:2: two scenes called early"},
        std::pair{"early fall --at 0.1 --size 10", "WIDTHxHEIGHT"}}) {
    scenes(row);
    const Outcome outcome = golden({});
    EXPECT_EQ(outcome.code, kScriptOrFile) << row;
    EXPECT_THAT(outcome.err, HasSubstr("scenes.txt:"));
    EXPECT_THAT(outcome.err, HasSubstr(message)) << row;
  }
  // A demo that is gone is a failure of its scene; the others are still judged and blessed.
  scenes("early fall --at 0.1 --size 160x90\nlate nowhere --at 0.3\n");
  const Outcome outcome = golden({});
  EXPECT_EQ(outcome.code, kScriptOrFile);
  EXPECT_THAT(outcome.out, HasSubstr("late: no demo \"nowhere\""));
  EXPECT_THAT(outcome.out, HasSubstr("2 scenes: 1 pictures and 1 states"));
  folder_.write("golden/accepted.txt", "early 12 34 driver\n");
  EXPECT_THAT(golden({}).err, HasSubstr("accepted.txt:1: expected NAME STATE DIGEST"));
}

TEST(GoldenScene, IsThePictureThatCaptureMakesOfTheSameWords) {
  const TemporaryFolder folder;
  for (const char* words :
       {"newtons_cradle --at 0.6 --theme dark --size 400x225", "stack --at 0.5 --set boxes=3"}) {
    const GoldenScene scene = golden_scene("a", words);
    const GoldenShot shot = take_golden_shot(scene, demo_tree());
    std::vector<std::string> arguments{"capture", "--demos", demo_tree(), "-o", folder / "a.png"};
    std::istringstream stream(scene.words);
    for (std::string word; stream >> word;) arguments.push_back(word);
    const Outcome outcome = run(arguments);
    ASSERT_EQ(outcome.code, kGood) << outcome.err;
    EXPECT_TRUE(render::read_png(folder / "a.png") == shot.image) << words;
    EXPECT_NE(shot.state, 0u);
    EXPECT_THAT(shot.driver, Not(HasSubstr("bits")));
  }
}

}  // namespace golden_test
}  // namespace skerry::sandbox
