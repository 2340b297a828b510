// SPDX-License-Identifier: MIT
//
// The parts of the window that need none: time control and search.
#include <gtest/gtest.h>

#include "sandbox/window/fuzzy.h"
#include "sandbox/window/time_control.h"

namespace skerry::sandbox {
namespace window_logic_test {

TEST(TimeControl, MakesAsManyStepsAsTheClockAndTheSpeedAsk) {
  for (const double speed : {0.25, 1.0, 4.0}) {
    TimeControl time;
    while (time.speed() < speed) time.faster();
    while (time.speed() > speed) time.slower();
    std::uint64_t steps = 0;
    for (int frame = 0; frame < 600; ++frame) steps += time.steps_for(1.0 / 60, 1.0 / 240);
    EXPECT_NEAR(static_cast<double>(steps), 10 * speed * 240, 1) << speed;
  }
}

TEST(TimeControl, OneStepAFrameAtEqualRates) {
  TimeControl time;
  for (int frame = 0; frame < 1000; ++frame) ASSERT_EQ(time.steps_for(1.0 / 60, 1.0 / 60), 1u) << frame;
}

TEST(TimeControl, PausedOrLateItDoesNotPileUpSteps) {
  TimeControl time;
  time.toggle();
  EXPECT_EQ(time.steps_for(1, 1.0 / 60), 0u);
  time.toggle();
  EXPECT_EQ(time.steps_for(100, 1.0 / 60), 6u);
  EXPECT_EQ(time.steps_for(-1, 1.0 / 60), 0u);
  for (int i = 0; i < 50; ++i) time.faster();
  EXPECT_EQ(time.speed(), 16);
  for (int i = 0; i < 50; ++i) time.slower();
  EXPECT_EQ(time.speed(), 1.0 / 64);
}

TEST(Fuzzy, FindsLettersInOrderAndPrefersBeginnings) {
  EXPECT_FALSE(fuzzy_score("xyz", "newtons_cradle"));
  EXPECT_FALSE(fuzzy_score("eldarc", "newtons_cradle"));
  EXPECT_FALSE(fuzzy_score("a", ""));
  EXPECT_TRUE(fuzzy_score("", "anything"));
  EXPECT_TRUE(fuzzy_score("NewCra", "newtons_cradle"));
  EXPECT_GT(*fuzzy_score("nc", "newtons_cradle"), *fuzzy_score("nc", "launch_pad"));
  EXPECT_GT(*fuzzy_score("stack", "stack"), *fuzzy_score("stack", "stacked_cards"));
  EXPECT_GT(*fuzzy_score("saw", "see_saw"), *fuzzy_score("saw", "seesaw"));
}

TEST(Fuzzy, SortsDemosByNameThenByTheirWords) {
  const std::vector<FuzzyItem> items{{"stack", "Stacked boxes stand still"},
                                     {"newtons_cradle", "Three in, three out"},
                                     {"see_saw", "A stack on a plank"},
                                     {"free_fall", "Parabola"}};
  EXPECT_EQ(fuzzy_find("", items), (std::vector<std::size_t>{0, 1, 2, 3}));
  EXPECT_EQ(fuzzy_find(" ", items).size(), 4u);
  EXPECT_EQ(fuzzy_find("stack", items), (std::vector<std::size_t>{0, 2}));
  EXPECT_EQ(fuzzy_find("cradle", items), (std::vector<std::size_t>{1}));
  EXPECT_EQ(fuzzy_find("ff", items).front(), 3u);
  EXPECT_TRUE(fuzzy_find("qqq", items).empty());
  EXPECT_EQ(fuzzy_find("on a PLANK", items), (std::vector<std::size_t>{2}));
  EXPECT_TRUE(fuzzy_find("tri", items).empty()) << "letters spread over a sentence are no find";
}

}  // namespace window_logic_test
}  // namespace skerry::sandbox
