// SPDX-License-Identifier: MIT
//
// What commands write and what they answer when they cannot: nothing is lost, half written or passed over.
#include "sandbox/output.h"

#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "physics/import.h"
#include "sandbox/errors.h"
#include "tests/sandbox/apart.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace output_test {

namespace fs = std::filesystem;
using testing::HasSubstr;

constexpr const char* kBox =
    "demo{ title = 'Box', seconds = 0.5, view = { x = 0, y = 0, height = 4 } }\nground{}\n"
    "local b = box{ at = {0, 0.5}, size = {1, 1}, name = 'box' }\n"
    "watch('height', function() return b.y end, 'm')\n"
    "expect('height', function() return b.y end, { equals = LEVEL, within = 1e-9 })\n";

std::string box_demo(const std::string& level = "0.5") {
  std::string text = kBox;
  return text.replace(text.find("LEVEL"), 5, level);
}

class Outputs : public testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string box_ = folder_.write("box.lua", box_demo());

  /// A run that would take hours, interrupted while it steps.
  void interrupt(std::vector<std::string> words, int signal, int code) {
    const std::string endless =
        folder_.write("endless.lua",
                      "demo{ title = 'E', seconds = 1e6 }\nlocal b = disc{ at = {0, 0}, radius = 1 }\n"
                      "local said = false\n"
                      "on_step(function() if not said then said = true print('steps') end end)\n");
    words.insert(words.begin() + 1, endless);
    const TemporaryFolder elsewhere;
    const std::string err = elsewhere / "err";
    const std::size_t before = folder_.files();
    const int got = run_apart(
        words, err, [] {},
        [&](pid_t child) {
          for (int i = 0; i < 3000 && read_file(err).find("steps") == std::string::npos; ++i) usleep(2000);
          kill(child, signal);
        });
    EXPECT_EQ(got, code) << words.front();
    EXPECT_THAT(read_file(err), HasSubstr("interrupted; ")) << words.front();
    EXPECT_EQ(folder_.files(), before) << words.front();
  }
};

TEST_F(Outputs, CtrlCLeavesTheOldFilesAndSaysSo) {
  const std::string old = folder_.write("old.png", "old");
  for (const std::vector<std::string>& words : {std::vector<std::string>{"run", "--save", old},
                                                {"run", "--report", old},
                                                {"run", "--csv", old},
                                                {"export", "--png", old},
                                                {"capture", "-o", old},
                                                {"analyze", "--at", "1e6", "-o", old}}) {
    interrupt(words, SIGINT, kInterrupted);
    EXPECT_EQ(read_file(old), "old") << words.front();
  }
  interrupt({"test"}, SIGTERM, 128 + SIGTERM);
}

TEST_F(Outputs, AStillOfADemoThatFailsIsNoSuccess) {
  const std::string bad = folder_.write("bad.lua", box_demo("3"));
  const Outcome outcome = run({"capture", bad, "-o", folder_ / "b.png", "--size", "320x180"});
  EXPECT_EQ(outcome.code, kCheckFailed);
  EXPECT_THAT(outcome.err, HasSubstr("FAIL  height"));
  EXPECT_TRUE(fs::exists(folder_ / "b.png")) << "to look at";
  EXPECT_EQ(run({"export", bad, "--svg", folder_ / "b.svg"}).code, kCheckFailed);
  EXPECT_EQ(run({"capture", box_, "-o", folder_ / "b.PNG", "--size", "320x180"}).code, kGood);
}

TEST_F(Outputs, NumbersOutOfRangeAreRefusedWithTheRange) {
  const auto complains = [&](std::vector<std::string> words, const std::string& expected) {
    words.insert(words.begin() + 1, box_);
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.code, kUsage) << words.back();
    EXPECT_THAT(outcome.err, HasSubstr(expected)) << words.back();
  };
  complains({"run", "--seconds", "inf"}, "--seconds: expected a number from 1e-09 to 1e+09, got inf");
  complains({"run", "--seconds", "nan"}, "got nan");
  complains({"run", "--seconds", "1e300"}, "got 1e300");
  complains({"run", "--dt", "1e300"}, "--dt: expected a number from 1e-09 to 1e+06, got 1e300");
  complains({"run", "--seconds", "1e9", "--dt", "1e-9"}, "at most 1000000000000 steps");
  complains({"run", "--steps", "99999999999999999999"},
            "--steps: expected a whole number from 1 to 1000000000000, got 99999999999999999999");
  complains({"run", "--steps", "1.5"}, "got 1.5");
  complains({"run", "--seed", "-1"},
            "--seed: expected a whole number from 0 to 18446744073709551615, got -1");
  complains({"run", "--seed", "99999999999999999999999"}, "--seed");
  complains({"run", "--budget", "inf"}, "--budget: expected a number of at least 0, got inf");
  complains({"capture", "--at", "1e300", "-o", "x.png"}, "--at: expected a number from 0 to 1e+09");
  complains({"capture", "--speed", "1e-300", "-o", "x.mp4"},
            "--speed: expected a number from 1e-06 to 1e+06");
  for (const char* size :
       {"4294967936x720", "1280x720x", "1280", "x720", "-1280x720", "99999999999x20", "8x8"})
    complains({"capture", "--size", size, "-o", "x.png"}, "--size expected WIDTHxHEIGHT from 16x16");
  complains({"capture", "--size", "16384x16384", "--ssaa", "4", "-o", "x.png"}, "--ssaa 4");
  const Outcome late = run({"run", box_, "--save", folder_ / "s", "--at", "9"});
  EXPECT_EQ(late.code, kUsage);
  EXPECT_THAT(late.err, HasSubstr("--at expected a time from 0 to 0.5 s"));
  const Outcome script = run({"run", folder_.write("dt.lua", "demo{ title = 'T', dt = 1e9 }")});
  EXPECT_THAT(script.err, HasSubstr("dt.lua:1: demo: dt expected a number from 1e-09 to 1e+06, got 1e+09"));
  // A step longer than the run is one step.
  EXPECT_THAT(run({"run", box_, "--dt", "1e6"}).out, HasSubstr(" 1 steps, "));
}

TEST_F(Outputs, TheStateOfTheBeginningCanBeSaved) {
  ASSERT_EQ(run({"run", box_, "--save", folder_ / "s0", "--at", "0"}).code, kGood);
  ASSERT_EQ(run({"run", box_, "--save", folder_ / "s2", "--at", "0.25"}).code, kGood);
  const std::string whole = run({"run", box_, "--report", "-"}).out;
  const auto hash = [](const std::string& report) { return nlohmann::json::parse(report)["state_hash"]; };
  for (const char* state : {"s0", "s2"})
    EXPECT_EQ(hash(run({"run", box_, "--load", folder_ / state, "--report", "-"}).out), hash(whole)) << state;
  const auto steps = [&](const char* state) {
    const std::string out = run({"run", box_, "--load", folder_ / state, "--csv", "-"}).out;
    return std::count(out.begin(), out.end(), '\n') - 1;
  };
  EXPECT_EQ(steps("s0"), 30);
  EXPECT_EQ(steps("s2"), 15);
}

TEST_F(Outputs, OptionsThatWouldDoNothingAreRefused) {
  const auto complains = [&](std::vector<std::string> words, const std::string& expected) {
    words.insert(words.begin() + 1, box_);
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.code, kUsage) << expected;
    EXPECT_THAT(outcome.err, HasSubstr(expected));
  };
  complains({"capture", "--small", "-o", "x.mp4"}, "--small is for one picture (.png), got \"x.mp4\"");
  complains({"capture", "--fps", "30", "-o", "x.png"}, "--fps is for");
  complains({"capture", "--encoder", "libx265", "-o", "x.gif"}, "--encoder is for videos");
  complains({"capture", "--sharp", "-o", "x.png"}, "--sharp is for videos");
  complains({"capture", "--lossless", "-o", "x.gif"}, "--lossless is for videos");
  complains({"analyze", "--select", "body=box"}, "analyze: --select needs -o");
  complains({"analyze", "--member", "1"}, "--influence");
  complains({"export", "--matrix", "--json", "x"}, "export: --matrix needs --svg or --png");
  complains({"export", "--curves", "momentum", "--png", "x"}, "--plot");
  complains({"export", "--island", "1", "--plot", "x"}, "export: --island needs");
  complains({"run", "--at", "0.1"}, "--save");
  complains({"export", "--svg", folder_ / "x", "--plot", folder_ / "./x"}, "--plot and --svg: both go to");
}

TEST_F(Outputs, AnalyzeLightsUpWhatIsSelected) {
  for (const char* body : {"", "body=box"}) {
    std::vector<std::string> words{"analyze", box_, "-o", folder_ / (std::string("p") + body + ".svg")};
    if (*body) words.insert(words.end(), {"--select", body});
    ASSERT_EQ(run(words).code, kGood);
  }
  EXPECT_NE(read_file(folder_ / "p.svg"), read_file(folder_ / "pbody=box.svg"));
  const Outcome unknown = run({"analyze", box_, "-o", folder_ / "p.svg", "--select", "body=bix"});
  EXPECT_EQ(unknown.code, kUsage);
  EXPECT_THAT(unknown.err, HasSubstr("no body \"bix\"; did you mean \"box\"?"));
}

TEST_F(Outputs, TwoDemosOfOneNameDoNotOverwriteEachOther) {
  fs::create_directory(folder_ / "a");
  fs::create_directory(folder_ / "b");
  const std::string one = folder_.write("a/x.lua", box_demo()), other = folder_.write("b/x.lua", box_demo());
  const Outcome outcome = run({"capture", one, other, "-o", folder_ / "out/", "--at", "0"});
  EXPECT_EQ(outcome.code, kUsage);
  EXPECT_THAT(outcome.err, HasSubstr("would both become"));
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(Outputs, StandardOutputTakesFiguresAndNothingElse) {
  const Outcome json = run({"export", box_, "--json", "-"});
  ASSERT_EQ(json.code, kGood) << json.err;
  EXPECT_EQ(nlohmann::json::parse(json.out)["format"], "skerry-island");
  EXPECT_THAT(json.err, HasSubstr("forces of island 1 at 0.4833 s, 4 rows: b in m/s, lambda in N s"));
  EXPECT_THAT(run({"export", box_, "--svg", "/dev/stdout"}).out, testing::EndsWith("</svg>\n"));
  EXPECT_THAT(run({"capture", box_, "-o", "-", "--at", "0", "--size", "64x64"}).out,
              testing::StartsWith("\x89PNG"));
  EXPECT_EQ(run({"export", box_, "--svg", "-", "--json", "-"}).code, kUsage);
  ASSERT_EQ(run({"run", box_, "--save", folder_ / "state"}).code, kGood);
  EXPECT_EQ(run({"run", box_, "--save", "-"}).out, read_file(folder_ / "state"));
}

TEST_F(Outputs, AFullDiskLeavesNoPartOfASetOfFiles) {
  const std::string set = folder_ / "set";
  fs::create_directory(set);
  fs::create_symlink("/dev/full", set + "/box_b.mtx");
  const Outcome outcome = run({"export", box_, "--matrix-market", set, "--json", folder_ / "x.json"});
  EXPECT_EQ(outcome.code, kEnvironmentError);
  EXPECT_THAT(outcome.err, HasSubstr("set/box_b.mtx: cannot write: No space left"));
  EXPECT_EQ(std::distance(fs::directory_iterator(set), {}), 1);
  EXPECT_FALSE(fs::exists(folder_ / "x.json"));
  EXPECT_THAT(run({"run", box_, "--save", "/dev/full"}).err, HasSubstr("/dev/full: cannot write"));
}

TEST_F(Outputs, BytesThatAreNoUtf8BreakNoFormat) {
  const std::string latin = folder_.write("caf\xE9.lua",
                                          "demo{ title = 'Caf\xE9', lesson = '\xFF', seconds = 0.1 }\n"
                                          "local b = disc{ at = {0, 0}, radius = 1, name = '\xE9' }\n"
                                          "watch('\xE9', function() return b.y end)\n");
  const Outcome list = run({"list", "--json", "--demos", folder_ / ""});
  ASSERT_EQ(list.code, kGood) << list.err;
  EXPECT_THAT(nlohmann::json::parse(list.out)[1]["title"], "Caf\xEF\xBF\xBD");
  ASSERT_EQ(
      run({"export", latin, "--svg", folder_ / "f.svg", "--plot", folder_ / "p.svg", "--curves", "watches"})
          .code,
      kGood);
  for (const char* file : {"f.svg", "p.svg"}) {
    EXPECT_THAT(read_file(folder_ / file), HasSubstr("Caf\xEF\xBF\xBD")) << file;
    EXPECT_THAT(read_file(folder_ / file), testing::Not(HasSubstr("\xE9"))) << file;
  }
  const std::string island = folder_ / "\xE9.json";
  ASSERT_EQ(run({"export", box_, "--json", island}).code, kGood);
  EXPECT_THAT(nlohmann::json::parse(run({"solve", island, "--json"}).out)["file"].get<std::string>(),
              HasSubstr("\xEF\xBF\xBD.json"));
}

TEST_F(Outputs, AHighlightOfNobodyIsAnErrorOfItsLine) {
  const std::string start = "demo{ title = 'T', seconds = 0.2 }\n";
  const std::string disc = "disc{ radius = 1, name = 'moon' }\n";
  const Outcome outcome =
      run({"run", folder_.write("a.lua", start + "highlight{ body = 'mooon' }\n" + disc)});
  EXPECT_EQ(outcome.code, kScriptOrFile);
  EXPECT_THAT(outcome.err, HasSubstr("a.lua:2: highlight: no body \"mooon\"; did you mean \"moon\"?"));
  EXPECT_EQ(run({"run", folder_.write("b.lua", start + "highlight{ body = 'moon' }\n" + disc)}).code, kGood);
  const Outcome late =
      run({"run",
           folder_.write("c.lua", start + disc + "at(0.1, function()\n  highlight{ body = 'sun' }\nend)\n")});
  EXPECT_EQ(late.code, kScriptOrFile);
  EXPECT_THAT(late.err, HasSubstr("c.lua:4: highlight: no body \"sun\""));
}

TEST_F(Outputs, TheForcesOfTheEventDrivenStepperAreExported) {
  const std::string demo = folder_.write(
      "slope.lua",
      "demo{ title = 'T', seconds = 0.5, stepper = 'event_driven', friction = 0.2 }\n"
      "ground{ tilt = 0.4 }\nbox{ at = {0, 0.5 / math.cos(0.4)}, size = {1, 1}, mass = 2, angle = 0.4 }\n");
  for (const char* at : {"0.01", "0.5"}) {
    const Outcome outcome = run({"export", demo, "--at", at, "--json", folder_ / "x.json"});
    ASSERT_EQ(outcome.code, kGood) << outcome.err;
    EXPECT_THAT(outcome.out, HasSubstr("of island 1 at "));
    EXPECT_THAT(run({"solve", folder_ / "x.json", "--warm"}).out, HasSubstr("status      solved"));
  }
}

TEST_F(Outputs, AnImpactIsExportedWhereNoForcesCameLater) {
  const std::string demo =
      folder_.write("hit.lua",
                    "demo{ title = 'T', seconds = 0.5, gravity = {0, 0}, restitution = 1 }\n"
                    "disc{ at = {-1.5, 0}, radius = 0.5, mass = 1, velocity = {10, 0} }\n"
                    "disc{ at = {0, 0}, radius = 0.5, mass = 1 }\n");
  EXPECT_EQ(run({"export", demo, "--at", "0.02", "--json", "-"}).code, kUsage);
  EXPECT_THAT(run({"export", demo, "--json", "-"}).err, HasSubstr("impact of island "));
}

}  // namespace output_test
}  // namespace skerry::sandbox
