// SPDX-License-Identifier: MIT
//
// Forgiving names: what somebody who typed a wrong word may have meant.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace skerry::sandbox {

/// Number of single-character insertions, deletions, exchanges and swaps of neighbours that turn `a` into
/// `b`; upper and lower case count as equal, and so do '-', '_' and ' ' [Damerau 1964; restricted form].
int edit_distance(std::string_view a, std::string_view b);

/// The candidates nearest to `word`, best first, at most `limit`; none when all are too far away to be meant.
/// A candidate that begins with `word` or contains it counts as near.
std::vector<std::string> nearest_names(std::string_view word, std::span<const std::string> candidates,
                                       std::size_t limit = 3);

/// `; did you mean "stack"?`, or the list of candidates when none is near and there are few, or nothing.
std::string suggestion(std::string_view word, std::span<const std::string> candidates);

/// Joins with ", ".
std::string join(std::span<const std::string> words, std::string_view separator = ", ");

}  // namespace skerry::sandbox
