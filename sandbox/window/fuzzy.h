// SPDX-License-Identifier: MIT
//
// Search as people type: the letters in order, gaps allowed, capitals ignored.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace skerry::sandbox {

/// How well `query` fits `text`, larger is better; none if its letters do not occur in this order. Beginnings
/// of words and letters in a row count more, letters left out count less; blanks in the query are ignored.
std::optional<int> fuzzy_score(std::string_view query, std::string_view text);

/// Something to find: by letters of its name, or by words as they stand in what else is said of it.
struct FuzzyItem {
  std::string_view name, more;
};

/// Positions of the items that fit, best first; all of them, in their order, for an empty query.
std::vector<std::size_t> fuzzy_find(std::string_view query, const std::vector<FuzzyItem>& items);

}  // namespace skerry::sandbox
