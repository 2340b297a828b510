// SPDX-License-Identifier: MIT
//
// The command line: exit codes, messages, reports.
#include "sandbox/cli.h"

#include <filesystem>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "sandbox/errors.h"
#include "sandbox/progress.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace cli_test {

using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* kGoodDemo =
    "demo{ title = 'Flight', lesson = 'L', seconds = 0.5, gravity = {0, -10} }\n"
    "local v = param('speed', 2, 0, 10, 'm/s')\n"
    "local b = disc{ at = {0, 0}, radius = 1, velocity = {v, 0}, name = 'ball' }\n"
    "watch('distance', function() return b.x end, 'm')\n"
    "expect('x', function() return b.x end, { equals = 1, within = 1e-12, unit = 'm' })\n";

class CommandLine : public testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string good_ = folder_.write("flight.lua", kGoodDemo);
};

TEST_F(CommandLine, HelpAndVersionAreGood) {
  EXPECT_THAT(run({"--help"}).out, HasSubstr("Exit codes: 0 good"));
  EXPECT_EQ(run({"--help"}).code, kGood);
  EXPECT_THAT(run({"--version"}).out, StartsWith("skerry "));
  for (const Command& command : commands()) {
    const Outcome help = run({std::string(command.name), "--help"});
    EXPECT_EQ(help.code, kGood) << command.name;
    EXPECT_THAT(help.out, HasSubstr("Example:"));
  }
}

TEST_F(CommandLine, WithoutACommandItShowsHelpAndIsUsage) {
  const Outcome outcome = run({});
  EXPECT_EQ(outcome.code, kUsage);
  EXPECT_THAT(outcome.err, HasSubstr("skerry capture"));
}

TEST_F(CommandLine, UnknownWordsAreUsageErrorsThatHelp) {
  const auto complains = [](const std::vector<std::string>& words, const std::string& expected) {
    const Outcome outcome = run(words);
    EXPECT_EQ(outcome.code, kUsage) << expected << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(expected));
  };
  complains({"captuer", "stack"}, "no command \"captuer\"; did you mean \"capture\"?");
  complains({"run", good_, "--sede", "3"}, "unknown option --sede; did you mean \"--seed\"");
  complains({"run"}, "DEMO is required");
  complains({"run", good_, "--dt", "-1"}, "--dt");
  complains({"run", good_, "--dt", "abc"}, "--dt");
  complains({"run", good_, "--steps", "3", "--seconds", "1"}, "--s");
  complains({"run", good_, "--solver", "bodyspace"},
            "--solver: no \"bodyspace\"; did you mean \"body_space\"?");
  complains({"run", good_, "--broadphase", "brute"},
            "--broadphase: no \"brute\"; did you mean \"brute_force\"?");
  complains({"run", good_, "--impact", "reflection"}, "did you mean \"reflections\"?");
  complains({"run", good_, "--set", "speed"}, "--set expected name=value, got \"speed\"");
  complains({"run", good_, "--set", "spede=3"}, "flight has no parameter \"spede\"; did you mean \"speed\"?");
  complains({"run", good_, "--set", "speed=11"}, "\"speed=11\": expected a number from 0 to 10 m/s");
  complains({"capture", good_, "--size", "12"}, "--size expected WIDTHxHEIGHT");
  complains({"capture", good_, "--theme", "pink"}, "--theme expected light or dark");
  complains({"capture", good_, "--overlay", "matrx"}, "--overlay: no \"matrx\"; did you mean \"matrix\"?");
  complains({"capture", good_, good_, "-o", folder_ / "x.mp4"}, "2 demos need a folder");
  complains({"capture", good_, "-o", folder_ / "x.xyz"}, ".xyz");
}

TEST_F(CommandLine, MissingAndWrongFilesAreScriptErrors) {
  const Outcome unknown = run({"run", "newton_cradle", "--demos", demo_tree()});
  EXPECT_EQ(unknown.code, kScriptOrFile);
  EXPECT_THAT(unknown.err, HasSubstr("no demo \"newton_cradle\"; did you mean \"newtons_cradle\""));
  EXPECT_EQ(run({"run", folder_ / "absent.lua"}).code, kScriptOrFile);
  EXPECT_EQ(run({"list", "--demos", folder_ / "absent"}).code, kScriptOrFile);
  const Outcome broken = run({"run", folder_.write("broken.lua", "demo{ title = 'x' }\nbox{ size = 3 }")});
  EXPECT_EQ(broken.code, kScriptOrFile);
  EXPECT_THAT(broken.err, HasSubstr("broken.lua:2: box: size expected {w, h}"));
  const Outcome unwritable = run({"run", good_, "--report", "/proc/skerry/out.json"});
  EXPECT_EQ(unwritable.code, kScriptOrFile);
  EXPECT_THAT(unwritable.err, HasSubstr("/proc/skerry/out.json"));
}

TEST_F(CommandLine, AFailedCheckIsCodeOneWithThePlace) {
  const Outcome outcome = run({"run", good_, "--set", "speed=3"});
  EXPECT_EQ(outcome.code, kCheckFailed);
  EXPECT_THAT(outcome.out, HasSubstr("FAIL  x: 1.5 (expected 1 +- 1e-12 m, at 0.5 s, "));
  EXPECT_THAT(outcome.out, HasSubstr("flight.lua:5"));
  EXPECT_THAT(outcome.out, HasSubstr("0 of 1 checks hold"));
}

TEST_F(CommandLine, ErrorsInCallbacksNameTheirLine) {
  const Outcome outcome =
      run({"run",
           folder_.write("late.lua", "demo{ title = 'x' }\non_step(function(t)\n  local a = nil + t\nend)")});
  EXPECT_EQ(outcome.code, kScriptOrFile);
  EXPECT_THAT(outcome.err, HasSubstr("late.lua:3: attempt to perform arithmetic on a nil value"));
}

TEST_F(CommandLine, AccuracyIsTakenFromTheCommandLineBeforeTheScript) {
  const std::string swinging =
      folder_.write("swing.lua",
                    "demo{ title = 'T', seconds = 0.5, accuracy = 1e-3 }\n"
                    "rod{ from = {0, 2}, to = disc{ at = {1, 2}, radius = 0.2, mass = 1 } }\n");
  const std::string report = folder_ / "out.json";
  std::uint64_t steps[2];
  for (int i = 0; i < 2; ++i) {
    std::vector<std::string> words{"run", swinging, "--report", report};
    if (i == 1) words.insert(words.end(), {"--accuracy", "1e-6"});
    ASSERT_EQ(run(words).code, kGood);
    const auto json = nlohmann::json::parse(read_file(report));
    EXPECT_EQ(json["config"]["accuracy"], i == 0 ? 1e-3 : 1e-6);
    EXPECT_GT(json["stepping"]["error_estimate"].get<double>(), 0);
    steps[i] = json["stepping"]["inner_steps"].get<std::uint64_t>();
  }
  EXPECT_GT(steps[1], steps[0]);
  const auto refused = run({"run", swinging, "--accuracy", "2"});
  EXPECT_EQ(refused.code, kUsage);
  EXPECT_THAT(refused.err, HasSubstr("--accuracy: expected a number from 1e-14 to 0.01, got 2"));
}

TEST_F(CommandLine, SleepSpeedStopsWhatIsSlow) {
  const std::string rolling =
      folder_.write("roll.lua",
                    "demo{ title = 'T', seconds = 1, sleep_speed = 0.01 }\n"
                    "ground{}\n"
                    "local d = disc{ at = {0, 0.5}, radius = 0.5, velocity = {0.02, 0}, omega = -0.04 }\n"
                    "expect('rolls on', function() return d.vx end, { equals = 0.02, within = 1e-6 })\n");
  EXPECT_EQ(run({"run", rolling}).code, kGood);
  const auto stopped = run({"run", rolling, "--sleep-speed", "0.05"});
  EXPECT_EQ(stopped.code, kCheckFailed) << stopped.out << stopped.err;
  const auto refused = run({"run", rolling, "--sleep-speed", "-1"});
  EXPECT_EQ(refused.code, kUsage);
  EXPECT_THAT(refused.err, HasSubstr("--sleep-speed: expected a number of at least 0, got -1"));
}

TEST_F(CommandLine, ReportAndSeriesHoldTheRun) {
  const std::string report = folder_ / "out.json";
  const std::string series = folder_ / "series.csv";
  const Outcome outcome = run({"run", good_, "--report", report, "--csv", series});
  ASSERT_EQ(outcome.code, kGood) << outcome.err;
  const auto json = nlohmann::json::parse(read_file(report));
  EXPECT_EQ(json["title"], "Flight");
  EXPECT_EQ(json["steps"], 30);
  EXPECT_EQ(json["passed"], true);
  EXPECT_EQ(json["parameters"]["speed"], 2);
  EXPECT_EQ(json["checks"][0]["state"], "ok");
  EXPECT_EQ(json["broad_phase"]["name"], "brute_force");
  EXPECT_EQ(json["broad_phase"]["reason"], "few boxes");
  EXPECT_EQ(json["broad_phase"]["switches"], 0);
  EXPECT_EQ(json["bodies"][0]["name"], "ball");
  EXPECT_NEAR(json["bodies"][0]["position"][1].get<double>(), -10 * 0.125, 1e-12);

  std::istringstream lines(read_file(series));
  std::string line;
  std::getline(lines, line);
  EXPECT_THAT(line, StartsWith("time [s],kinetic energy [J]"));
  EXPECT_THAT(line, testing::EndsWith(",distance [m]"));
  const auto columns = std::count(line.begin(), line.end(), ',');
  int rows = 0;
  for (; std::getline(lines, line); ++rows) EXPECT_EQ(std::count(line.begin(), line.end(), ','), columns);
  EXPECT_EQ(rows, 30);
  EXPECT_EQ(folder_.files(), 3u) << "nothing but the demo and the two results";
}

TEST_F(CommandLine, ReportIsTheSameEachTime) {
  EXPECT_EQ(run({"run", good_, "--report", "-"}).out, run({"run", good_, "--report", "-"}).out);
}

TEST_F(CommandLine, StepsAndDtChangeTheRun) {
  const auto json =
      nlohmann::json::parse(run({"run", good_, "--dt", "0.01", "--steps", "7", "--report", "-"}).out);
  EXPECT_EQ(json["steps"], 7);
  EXPECT_DOUBLE_EQ(json["time"].get<double>(), 0.07);
}

TEST_F(CommandLine, ListNamesEveryDemoWithItsLesson) {
  const Outcome outcome = run({"list", "--json", "--demos", demo_tree()});
  ASSERT_EQ(outcome.code, kGood) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_GE(json.size(), 7u);
  for (const auto& demo : json) {
    EXPECT_FALSE(demo["title"].get<std::string>().empty()) << demo["name"];
    EXPECT_FALSE(demo["lesson"].get<std::string>().empty()) << demo["name"];
    EXPECT_GT(demo["checks"], 0) << demo["name"];
  }
}

TEST(ProgressLine, TellsRateAndTimeLeft) {
  EXPECT_EQ(Progress::line("stack", 0, 300, 0), "stack  [....................]  0/300 frames");
  EXPECT_EQ(Progress::line("stack", 150, 300, 2),
            "stack  [##########..........]  150/300 frames  75 frames/s  2.0 s left");
  EXPECT_EQ(format_seconds(125), "2 min 05 s");
  EXPECT_EQ(format_bytes(640), "640 B");
  EXPECT_EQ(format_bytes(1536), "1.5 KiB");
  EXPECT_EQ(format_bytes(3u << 20), "3.0 MiB");
}

}  // namespace cli_test
}  // namespace skerry::sandbox
