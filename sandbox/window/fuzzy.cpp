// SPDX-License-Identifier: MIT
#include "sandbox/window/fuzzy.h"

#include <algorithm>
#include <cctype>
#include <string>

namespace skerry::sandbox {
namespace {

constexpr int kLetter = 2, kInRow = 5, kWordStart = 8, kNameBonus = 30;
constexpr int kNever = -1'000'000;

char lower(char c) {
  return static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
}

bool separates(char c) {
  return c == ' ' || c == '_' || c == '-' || c == '/' || c == '\'';
}

bool contains(std::string_view text, std::string_view query) {
  return std::search(text.begin(), text.end(), query.begin(), query.end(),
                     [](char a, char b) { return lower(a) == lower(b); }) != text.end();
}

}  // namespace

std::optional<int> fuzzy_score(std::string_view query, std::string_view text) {
  std::string letters;
  for (const char c : query)
    if (!separates(c)) letters += lower(c);
  if (letters.empty()) return 0;
  const std::size_t n = text.size();
  // best[j]: of the letters so far with the last one at text[j].
  std::vector<int> best(n, kNever), next(n, kNever);
  for (std::size_t i = 0; i < letters.size(); ++i) {
    int before = i == 0 ? 0 : kNever;  // best end before j - 1
    for (std::size_t j = 0; j < n; ++j) {
      next[j] = kNever;
      if (lower(text[j]) == letters[i]) {
        const int here = kLetter + (j == 0 || separates(text[j - 1]) ? kWordStart : 0);
        int from = before;
        if (i > 0 && j > 0 && best[j - 1] != kNever) from = std::max(from, best[j - 1] + kInRow);
        if (from != kNever) next[j] = from + here;
      }
      if (i > 0) before = std::max(before, best[j]);
    }
    std::swap(best, next);
  }
  const int score = n == 0 ? kNever : *std::max_element(best.begin(), best.end());
  if (score == kNever) return std::nullopt;
  // Of two texts that fit equally well the shorter one was meant.
  return 4 * score - static_cast<int>(std::min<std::size_t>(n, 60)) / 4;
}

std::vector<std::size_t> fuzzy_find(std::string_view query, const std::vector<FuzzyItem>& items) {
  std::vector<std::pair<int, std::size_t>> found;
  for (std::size_t i = 0; i < items.size(); ++i) {
    const std::optional<int> name = fuzzy_score(query, items[i].name);
    // In a long text any letters occur somewhere: there the query counts as it stands.
    std::optional<int> more;
    if (contains(items[i].more, query)) more = fuzzy_score(query, items[i].more);
    if (!name && !more) continue;
    found.emplace_back(std::max(name ? *name + kNameBonus : kNever, more.value_or(kNever)), i);
  }
  const bool all = std::all_of(query.begin(), query.end(), separates);
  if (!all)
    std::stable_sort(found.begin(), found.end(),
                     [](const auto& x, const auto& y) { return x.first > y.first; });
  std::vector<std::size_t> places;
  places.reserve(found.size());
  for (const auto& [score, place] : found) places.push_back(place);
  return places;
}

}  // namespace skerry::sandbox
