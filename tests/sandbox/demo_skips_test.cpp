// SPDX-License-Identifier: MIT
//
// Work that a step leaves out must not show: the beginning of every demo with each skip off, to the bit where
// the skip promises that, else to a tolerance.
#include <algorithm>
#include <gtest/gtest.h>

#include "sandbox/demo.h"
#include "tests/sandbox/demo_names.h"
#include "tests/sandbox/temporary.h"
#include "tests/support/scale.h"

namespace skerry::sandbox {
namespace demo_skips_test {

struct Switch {
  const char* name;
  void (*off)(WorldConfig& config);
};

constexpr Switch kSameBits[] = {
    {"sleep", [](WorldConfig& c) { c.sleep = false; }},
    {"resting islands", [](WorldConfig& c) { c.reuse_resting = false; }},
    {"kept manifolds", [](WorldConfig& c) { c.skips.manifolds = false; }},
    {"kept axes", [](WorldConfig& c) { c.skips.axes = false; }},
};

// The same to rounding, or to the tolerance of the solver, which a motion that is sensitive makes more of.
constexpr Switch kNearly[] = {
    {"kept factors", [](WorldConfig& c) { c.skips.factors = false; }},
    {"smooth rows", [](WorldConfig& c) { c.skips.smooth_rows = false; }},
    {"pairs of what flies alike", [](WorldConfig& c) { c.skips.alike = false; }},
    {"closed-form flight", [](WorldConfig& c) { c.skips.flight = false; }},
    {"rows of welds", [](WorldConfig& c) { c.solve.welds_as_one = false; }},
};
constexpr double kTolerance = 1e-7;  // [m], [rad]

void switch_off(Demo& demo, const Switch& skip) {
  WorldConfig config = demo.world().config();
  skip.off(config);
  demo.world_for_input().reconfigure(config);
}

class EveryDemoSkips : public testing::TestWithParam<DemoFile> {};

TEST_P(EveryDemoSkips, HasTheSameBitsWithEachSkipOff) {
  const std::uint64_t steps = static_cast<std::uint64_t>(test_scale(40));
  Demo with(GetParam().path, {});
  std::vector<std::uint64_t> hashes;
  while (hashes.size() < std::min(steps, with.total_steps())) {
    with.step();
    hashes.push_back(with.world().report().state_hash);
  }
  for (const Switch& skip : kSameBits) {
    Demo without(GetParam().path, {});
    switch_off(without, skip);
    for (std::size_t i = 0; i < hashes.size(); ++i) {
      without.step();
      ASSERT_EQ(without.world().report().state_hash, hashes[i]) << skip.name << " off, step " << i + 1;
    }
  }
}

TEST_P(EveryDemoSkips, HasTheSameBitsForAnObserver) {
  const std::uint64_t steps = static_cast<std::uint64_t>(test_scale(240));
  Demo alone(GetParam().path, {}), observed(GetParam().path, {});
  observed.observe(
      {.contacts = true, .systems = true, .solve_traces = true, .stage_times = true, .paths = true});
  while (alone.steps_done() < std::min(steps, alone.total_steps())) {
    alone.step();
    observed.step();
    ASSERT_EQ(observed.world().report().state_hash, alone.world().report().state_hash)
        << "step " << alone.steps_done();
  }
}

TEST_P(EveryDemoSkips, MovesAlikeWithEachSkipOffThatMayRoundOtherwise) {
  // Not more of them for longer runs: a gas makes millimetres of a rounding in 120 steps.
  constexpr std::uint64_t steps = 40;
  Demo with(GetParam().path, {});
  while (with.steps_done() < std::min(steps, with.total_steps())) with.step();
  for (const Switch& skip : kNearly) {
    Demo without(GetParam().path, {});
    switch_off(without, skip);
    while (without.steps_done() < with.steps_done()) without.step();
    const std::size_t slots = with.world().bodies().alive.size();
    ASSERT_EQ(without.world().bodies().alive, with.world().bodies().alive) << skip.name;
    double worst = 0;
    for (std::size_t slot = 0; slot < slots; ++slot) {
      if (!with.world().bodies().alive[slot]) continue;
      const BodyState a = with.shown(slot), b = without.shown(slot);
      worst = std::max({worst, length(a.position - b.position), std::abs(a.angle - b.angle)});
    }
    EXPECT_LT(worst, kTolerance) << skip.name << " off, after " << with.steps_done() << " steps";
  }
}

INSTANTIATE_TEST_SUITE_P(Demos, EveryDemoSkips, testing::ValuesIn(find_demos(demo_tree())),
                         [](const testing::TestParamInfo<DemoFile>& demo) { return demo.param.name; });

}  // namespace demo_skips_test
}  // namespace skerry::sandbox
