// SPDX-License-Identifier: MIT
//
// Work that a step leaves out must not show: the beginning of every demo with each skip off that promises the
// same bits. Skips that promise a tolerance are compared in tests/world/skips_test.cpp.
#include <algorithm>
#include <gtest/gtest.h>

#include "sandbox/demo.h"
#include "sandbox/demo_files.h"
#include "tests/sandbox/temporary.h"
#include "tests/support/scale.h"

namespace skerry::sandbox {

static void PrintTo(const DemoFile& demo, std::ostream* out) {
  *out << demo.name;
}

namespace {

struct Switch {
  const char* name;
  void (*off)(WorldConfig& config);
};

constexpr Switch kSwitches[] = {
    {"sleep", [](WorldConfig& c) { c.sleep = false; }},
    {"resting islands", [](WorldConfig& c) { c.reuse_resting = false; }},
    {"kept manifolds", [](WorldConfig& c) { c.skips.manifolds = false; }},
    {"kept axes", [](WorldConfig& c) { c.skips.axes = false; }},
};

class EveryDemoSkips : public testing::TestWithParam<DemoFile> {};

TEST_P(EveryDemoSkips, HasTheSameBitsWithEachSkipOff) {
  const std::uint64_t steps = static_cast<std::uint64_t>(test_scale(40));
  Demo with(GetParam().path, {});
  std::vector<std::uint64_t> hashes;
  while (hashes.size() < std::min(steps, with.total_steps())) {
    with.step();
    hashes.push_back(with.world().report().state_hash);
  }
  for (const Switch& skip : kSwitches) {
    Demo without(GetParam().path, {});
    WorldConfig config = without.world().config();
    skip.off(config);
    without.world_for_input().reconfigure(config);
    for (std::size_t i = 0; i < hashes.size(); ++i) {
      without.step();
      ASSERT_EQ(without.world().report().state_hash, hashes[i]) << skip.name << " off, step " << i + 1;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Demos, EveryDemoSkips, testing::ValuesIn(find_demos(demo_tree())),
                         [](const testing::TestParamInfo<DemoFile>& demo) { return demo.param.name; });

}  // namespace
}  // namespace skerry::sandbox
