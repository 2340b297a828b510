// SPDX-License-Identifier: MIT
//
// Scripts of a few lines, and what comes of them.
#pragma once

#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "sandbox/demo.h"
#include "sandbox/errors.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {

using Lines = std::vector<std::string>;

class ScriptFixture : public testing::Test {
 protected:
  /// Without gravity; the script's own lines begin with the second one.
  Demo load(const std::string& body, DemoOptions options = {}) {
    options.print = [this](std::string_view line) { printed_.emplace_back(line); };
    return Demo(folder_.write("arch.lua", kHead + body), options);
  }
  static void run_to_end(Demo& demo) {
    while (demo.steps_done() < demo.total_steps()) {
      demo.step();
      demo.watch_values();
    }
    demo.finish();
  }
  /// What it prints.
  Lines lines_of(const std::string& body, const DemoOptions& options = {}) {
    printed_.clear();
    Demo demo = load(body, options);
    run_to_end(demo);
    return printed_;
  }
  /// The message of loading it and of a run of it, without the folder: it begins with "arch.lua:".
  std::string error_of(const std::string& body) {
    try {
      lines_of(body);
    } catch (const ScriptError& error) {
      const std::string text = error.what();
      const std::size_t at = text.find("arch.lua");
      return at == std::string::npos ? text : text.substr(at);
    }
    return "no error";
  }
  /// The checks that do not hold, with what they measured.
  Lines failures_of(const std::string& body, const DemoOptions& options = {}) {
    Demo demo = load(body, options);
    run_to_end(demo);
    Lines failures;
    for (const Check& check : demo.checks())
      if (check.state != CheckState::Holds)
        failures.push_back(check.what + ": " + std::to_string(check.value));
    return failures;
  }

  static constexpr const char* kHead = "demo{ title = 'T', seconds = 1, gravity = {0, 0}, friction = 0 }\n";
  TemporaryFolder folder_;
  Lines printed_;
};

}  // namespace skerry::sandbox
