// SPDX-License-Identifier: MIT
//
// Every demo of the tree: its numbers, with every broad phase.
#include <gtest/gtest.h>

#include "sandbox/errors.h"
#include "tests/sandbox/demo_names.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace demos_test {

class EveryDemo : public testing::TestWithParam<DemoFile> {};

TEST_P(EveryDemo, KeepsItsPromisesWithEveryBroadPhase) {
  const Outcome outcome = run({"test", GetParam().path});
  EXPECT_EQ(outcome.code, kGood) << outcome.out << outcome.err;
}

std::string name_of(const testing::TestParamInfo<DemoFile>& info) {
  return info.param.name;
}

INSTANTIATE_TEST_SUITE_P(Demos, EveryDemo, testing::ValuesIn(find_demos(demo_tree())), name_of);

struct Variant {
  const char* name;
  std::vector<std::string> arguments;
};

void PrintTo(const Variant& variant, std::ostream* out) {
  *out << variant.name;
}

class DemoVariant : public testing::TestWithParam<Variant> {};

TEST_P(DemoVariant, HoldsForOtherParametersToo) {
  std::vector<std::string> arguments = GetParam().arguments;
  arguments.insert(arguments.begin(), "run");
  arguments.insert(arguments.end(), {"--demos", demo_tree()});
  const Outcome outcome = run(arguments);
  EXPECT_EQ(outcome.code, kGood) << outcome.out << outcome.err;
}

const Variant kVariants[] = {
    {"FreeCradle1of5", {"newtons_cradle_free", "--set", "moving=1"}},
    {"FreeCradle3of5", {"newtons_cradle_free", "--set", "moving=3"}},
    {"FreeCradle4of5", {"newtons_cradle_free", "--set", "moving=4"}},
    {"FreeCradle1of50", {"newtons_cradle_free", "--set", "moving=1", "--set", "discs=50"}},
    {"FreeCradle4of50", {"newtons_cradle_free", "--set", "moving=4", "--set", "discs=50"}},
    {"CradleLift2", {"newtons_cradle", "--set", "lifted=2"}},
    {"CradleLift3", {"newtons_cradle", "--set", "lifted=3"}},
    {"LawSimultaneous", {"impact_laws", "--set", "law=simultaneous"}},
    {"LawPoisson", {"impact_laws", "--set", "law=poisson"}},
    {"LawFromTheFlag", {"impact_laws", "--impact", "simultaneous"}},
    {"ChainElastic", {"four_body_chain", "--set", "restitution=1"}},
    {"ChainPlastic", {"four_body_chain", "--set", "restitution=0"}},
    {"SeeSawHeavy", {"see_saw", "--set", "weight=40"}},
    {"SeeSawLight", {"see_saw", "--set", "weight=10"}},
    {"StackOf10", {"stack", "--set", "boxes=10"}},
    {"LoopTooLowForARing", {"loop_the_loop", "--set", "what=ring"}},
    {"LoopOfARing", {"loop_the_loop", "--set", "what=ring", "--set", "height=3.1"}},
    {"LoopOfWhatSlides", {"loop_the_loop", "--set", "what=slider", "--set", "height=2.6"}},
    {"FallWithoutBounce", {"free_fall", "--set", "restitution=0"}},
};

INSTANTIATE_TEST_SUITE_P(Demos, DemoVariant, testing::ValuesIn(kVariants),
                         [](const auto& variant) { return variant.param.name; });

}  // namespace demos_test
}  // namespace skerry::sandbox
