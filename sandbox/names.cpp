// SPDX-License-Identifier: MIT
#include "sandbox/names.h"

#include <algorithm>

namespace skerry::sandbox {
namespace {

char folded(char c) {
  if (c >= 'A' && c <= 'Z') return static_cast<char>(c - 'A' + 'a');
  return c == '-' || c == ' ' ? '_' : c;
}

std::string folded(std::string_view word) {
  std::string result(word);
  std::transform(result.begin(), result.end(), result.begin(), [](char c) { return folded(c); });
  return result;
}

}  // namespace

int edit_distance(std::string_view a, std::string_view b) {
  const std::string s = folded(a);
  const std::string t = folded(b);
  const std::size_t width = t.size() + 1;
  // Three rows of the table are alive: this one, the last, and the one before that for swaps.
  std::vector<int> before(width), last(width), row(width);
  for (std::size_t j = 0; j < width; ++j) last[j] = static_cast<int>(j);
  for (std::size_t i = 1; i <= s.size(); ++i) {
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j < width; ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (s[i - 1] != t[j - 1])});
      const bool swapped = i > 1 && j > 1 && s[i - 1] == t[j - 2] && s[i - 2] == t[j - 1];
      if (swapped) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, row);
  }
  return last.back();
}

std::vector<std::string> nearest_names(std::string_view word, std::span<const std::string> candidates,
                                       std::size_t limit) {
  const std::string wanted = folded(word);
  std::vector<std::pair<int, std::string>> scored;
  for (const std::string& candidate : candidates) {
    const std::string name = folded(candidate);
    int distance = edit_distance(wanted, name);
    const bool inside = wanted.size() >= 3 && name.find(wanted) != std::string::npos;
    if (inside) distance = std::min(distance, 1);
    // Up to a third of the letters may be wrong; more than that is another word.
    if (distance <= 1 + static_cast<int>(wanted.size()) / 3 && distance < static_cast<int>(name.size()))
      scored.emplace_back(distance, candidate);
  }
  std::stable_sort(scored.begin(), scored.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  if (scored.size() > limit) scored.resize(limit);
  std::vector<std::string> result;
  result.reserve(scored.size());
  for (auto& [distance, name] : scored) result.push_back(std::move(name));
  return result;
}

std::string suggestion(std::string_view word, std::span<const std::string> candidates) {
  const std::vector<std::string> near = nearest_names(word, candidates);
  if (!near.empty()) {
    std::string text = "; did you mean ";
    for (std::size_t i = 0; i < near.size(); ++i) {
      if (i > 0) text += i + 1 == near.size() ? " or " : ", ";
      text += '"' + near[i] + '"';
    }
    return text + "?";
  }
  constexpr std::size_t kFew = 24;
  if (candidates.empty() || candidates.size() > kFew) return {};
  return "; there " + std::string(candidates.size() == 1 ? "is " : "are ") + join(candidates);
}

std::string join(std::span<const std::string> words, std::string_view separator) {
  std::string text;
  for (const std::string& word : words) {
    if (!text.empty()) text += separator;
    text += word;
  }
  return text;
}

}  // namespace skerry::sandbox
