// SPDX-License-Identifier: MIT
//
// Snapshots and recordings on the command line.
#include <filesystem>
#include <gtest/gtest.h>

#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace window_files_test {

constexpr const char* kPlain =
    "demo{ title = 'Plain', seconds = 1 }\nground{ y = 0 }\n"
    "for i = 1, 4 do box{ at = {0.1 * i, 0.6 * i}, size = {0.5, 0.5}, angle = 0.1 * i } end\n"
    "expect('early', function() return time() end, { at = 0.2, above = 0 })\n"
    "expect('end', function() return time() end, { equals = 1, within = 1e-9 })\n";

constexpr const char* kActing =
    "demo{ title = 'Acting', seconds = 1, friction = 0 }\nground{ y = 0 }\n"
    "local b = box{ at = {0, 0.5}, size = {1, 1}, mass = 1 }\nlocal push = param('push', 1, 0, 5)\n"
    "on_step(function(t) b:force(push * math.random(), 0) end)\n";

std::string state_of(const std::string& out) {
  const std::size_t at = out.find("state ");
  return at == std::string::npos ? out : out.substr(at, 22);
}

TEST(RunCommand, ASavedStateGoesOnToTheSameEnd) {
  const TemporaryFolder folder;
  for (const char* source : {kPlain, kActing}) {
    const std::string script = folder.write("d.lua", source), file = folder / "s.skerry";
    const Outcome whole = run({"run", script});
    ASSERT_EQ(whole.code, 0) << whole.err;
    const Outcome saved = run({"run", script, "--save", file, "--at", "0.5"});
    ASSERT_EQ(saved.code, 0) << saved.err;
    EXPECT_EQ(state_of(saved.out), state_of(whole.out));
    const Outcome loaded = run({"run", script, "--load", file});
    ASSERT_EQ(loaded.code, 0) << loaded.err;
    EXPECT_EQ(state_of(loaded.out), state_of(whole.out));
    EXPECT_EQ(loaded.out.find("early"), std::string::npos) << "checks before the snapshot are left out";
  }
}

TEST(RunCommand, SnapshotsOfOtherScenesAreRefused) {
  const TemporaryFolder folder;
  const std::string plain = folder.write("plain.lua", kPlain), acting = folder.write("acting.lua", kActing);
  const std::string file = folder / "s.skerry";
  ASSERT_EQ(run({"run", acting, "--save", file, "--at", "0.5"}).code, 0);
  const Outcome other = run({"run", plain, "--load", file});
  EXPECT_EQ(other.code, 3);
  EXPECT_NE(other.err.find("other bodies than plain"), std::string::npos) << other.err;
  const Outcome changed = run({"run", acting, "--load", file, "--set", "push=2"});
  EXPECT_EQ(changed.code, 3);
  EXPECT_NE(changed.err.find("comes to another state"), std::string::npos) << changed.err;
  const Outcome script = run({"run", plain, "--load", plain});
  EXPECT_EQ(script.code, 3);
  EXPECT_NE(script.err.find("offset 0: not a Skerry file"), std::string::npos) << script.err;
  EXPECT_EQ(run({"run", plain, "--load", folder / "none"}).code, 3);
  EXPECT_EQ(run({"run", plain, "--save", folder / "no/such/folder"}).code, 3);
}

TEST(RunCommand, ASavedStateGoesOnAsTheCommandLineSays) {
  const TemporaryFolder folder;
  const std::string script = folder.write("d.lua", std::string(kPlain)), file = folder / "s.skerry";
  ASSERT_EQ(run({"run", script, "--save", file, "--at", "0.5"}).code, 0);
  const Outcome json =
      run({"run", script, "--load", file, "--solver", "pgs", "--impact", "poisson", "--report", "-"});
  ASSERT_EQ(json.code, 0) << json.err;
  EXPECT_NE(json.out.find("\"pgs\""), std::string::npos) << json.out;
  EXPECT_NE(json.out.find("\"poisson\""), std::string::npos) << json.out;
  const Outcome steps = run({"run", script, "--load", file, "--dt", "0.001"});
  EXPECT_EQ(steps.code, 3);
  EXPECT_NE(steps.err.find("give the --dt that it was saved with"), std::string::npos) << steps.err;
  // Another mass, or another shape, is another scene.
  for (const char* change : {"size = {0.5, 0.5}, mass = 7", "size = {0.25, 1}"}) {
    std::string other = kPlain;
    const std::string before = "size = {0.5, 0.5}";
    const std::size_t at = other.find(before);
    ASSERT_NE(at, std::string::npos);
    const Outcome refused =
        run({"run", folder.write("e.lua", other.replace(at, before.size(), change)), "--load", file});
    EXPECT_EQ(refused.code, 3) << change;
    EXPECT_NE(refused.err.find("other bodies than e"), std::string::npos) << refused.err;
  }
}

TEST(RecordCommand, ReplaySaysThatAllStatesAreTheSameOrWhichIsNot) {
  const TemporaryFolder folder;
  const std::string script = folder.write("acting.lua", kActing), file = folder / "a.skerry";
  const Outcome recorded = run({"record", script, "-o", file, "--seed", "3"});
  ASSERT_EQ(recorded.code, 0) << recorded.err;
  EXPECT_NE(recorded.out.find("60 steps"), std::string::npos) << recorded.out;
  const Outcome same = run({"replay", file});
  EXPECT_EQ(same.code, 0) << same.out << same.err;
  EXPECT_NE(same.out.find("60 steps"), std::string::npos) << same.out;
  EXPECT_NE(same.out.find("every state the same by the bit"), std::string::npos);
  // Another script under the same name: it is told, and so is the first difference.
  std::string text = kActing;
  text.replace(text.find("math.random()"), 13, "(t < 0.5 and math.random() or 0.1)");
  folder.write("acting.lua", text);
  const Outcome differs = run({"replay", file});
  EXPECT_EQ(differs.code, 1);
  EXPECT_NE(differs.err.find("is not the script that was recorded"), std::string::npos) << differs.err;
  EXPECT_NE(differs.out.find("step 31 (t = 0.516667 s): "), std::string::npos) << differs.out;
  EXPECT_NE(differs.out.find(" of body 1"), std::string::npos) << differs.out;
  EXPECT_EQ(run({"replay", script}).code, 3);
}

}  // namespace window_files_test
}  // namespace skerry::sandbox
