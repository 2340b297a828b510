// SPDX-License-Identifier: MIT
#include "sandbox/names.h"

#include <gtest/gtest.h>

namespace skerry::sandbox {
namespace names_test {

TEST(Names, CountsInsertionsDeletionsExchangesAndSwaps) {
  EXPECT_EQ(edit_distance("", ""), 0);
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(edit_distance("stack", "stack"), 0);
  EXPECT_EQ(edit_distance("stack", "stak"), 1);
  EXPECT_EQ(edit_distance("stack", "satck"), 1);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
}

TEST(Names, IgnoresCaseAndTheKindOfSeparator) {
  EXPECT_EQ(edit_distance("Brute-Force", "brute_force"), 0);
  EXPECT_EQ(edit_distance("mass ratio", "mass_ratio"), 0);
}

TEST(Names, OffersTheNearestFirstAndNothingForAnotherWord) {
  const std::vector<std::string> known{"stack", "see_saw", "newtons_cradle", "free_fall"};
  EXPECT_EQ(nearest_names("stakc", known), std::vector<std::string>{"stack"});
  EXPECT_EQ(nearest_names("cradle", known), std::vector<std::string>{"newtons_cradle"});
  EXPECT_TRUE(nearest_names("zzzzzzzz", known).empty());
  EXPECT_TRUE(nearest_names("", known).empty());
}

TEST(Names, SuggestionIsASentenceEndOrAListOfAFew) {
  const std::vector<std::string> known{"stack", "see_saw"};
  EXPECT_EQ(suggestion("stac", known), "; did you mean \"stack\"?");
  EXPECT_EQ(suggestion("hippopotamus", known), "; there are stack, see_saw");
  EXPECT_EQ(suggestion("anything", std::vector<std::string>{}), "");
}

}  // namespace names_test
}  // namespace skerry::sandbox
