// SPDX-License-Identifier: MIT
//
// The examples of demos/README.md run, and their numbers hold.
#include <gtest/gtest.h>

#include "tests/sandbox/script_fixture.h"

namespace skerry::sandbox {
namespace readme_script_test {

/// The Lua blocks of a text.
Lines examples_of(const std::string& text) {
  constexpr const char* kBegin = "```lua\n";
  Lines examples;
  for (std::size_t at = text.find(kBegin); at != std::string::npos; at = text.find(kBegin, at)) {
    at += std::string(kBegin).size();
    examples.push_back(text.substr(at, text.find("```", at) - at));
  }
  return examples;
}

TEST(ReadmeScript, ExamplesDoWhatTheySay) {
  const TemporaryFolder folder;
  const Lines examples = examples_of(read_file(demo_tree() + "/README.md"));
  EXPECT_GE(examples.size(), 11u);
  for (const std::string& example : examples) {
    // Most of them are lines of a demo.
    const bool whole = example.find("demo{") != std::string::npos;
    const std::string head =
        "demo{ title = 'T', seconds = 1 }\nlocal ball = disc{ at = {0, 9}, radius = 0.25, mass = 1 }\n";
    Demo demo(folder.write("example.lua", (whole ? "" : head) + example), {});
    while (demo.steps_done() < demo.total_steps()) {
      demo.step();
      demo.watch_values();
    }
    demo.finish();
    for (const Check& check : demo.checks())
      EXPECT_EQ(check.state, CheckState::Holds) << check.what << ": " << check.value << "\n" << example;
  }
}

}  // namespace readme_script_test
}  // namespace skerry::sandbox
