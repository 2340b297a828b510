// SPDX-License-Identifier: MIT
#include "sandbox/selection.h"

#include <algorithm>
#include <charconv>
#include <vector>

#include "sandbox/errors.h"
#include "sandbox/names.h"

namespace skerry::sandbox {
namespace {

int positive(std::string_view key, std::string_view value, int least) {
  int number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc() || end != value.data() + value.size() || number < least)
    throw UsageError("select: " + std::string(key) + " expected a whole number from " +
                     std::to_string(least) + ", got \"" + std::string(value) + '"');
  return number;
}

BodyId find_body(const World& world, const SelectedBody& selected, const char* who) {
  if (selected.empty() || selected.id)
    return selected.id && world.alive(selected.id) ? selected.id : BodyId{};
  const std::string& name = selected.label;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < world.bodies().size(); ++i) {
    if (!world.bodies().alive[i]) continue;
    const BodyId body = world.body_id(i);
    names.push_back(body_label(world, body));
    if (names.back() == name) return body;
  }
  throw UsageError(std::string(who) + ": no body \"" + name + '"' + suggestion(name, names));
}

}  // namespace

SelectionText parse_selection(std::string_view text) {
  SelectionText result;
  while (!text.empty()) {
    const std::string_view word = text.substr(0, text.find(','));
    text.remove_prefix(std::min(word.size() + 1, text.size()));
    const std::size_t equals = word.find('=');
    const std::string_view key = word.substr(0, equals);
    const std::string_view value = equals == std::string_view::npos ? "" : word.substr(equals + 1);
    if (value.empty())
      throw UsageError("select: expected name=value as in row=3,col=5, got \"" + std::string(word) + '"');
    if (key == "row")
      result.row = positive(key, value, 1);
    else if (key == "col" || key == "column")
      result.column = positive(key, value, 1);
    else if (key == "island")
      result.island = positive(key, value, 1);
    else if (key == "body")
      result.body.label = value;
    else if (key == "other")
      result.other.label = value;
    else
      throw UsageError("select: row, col, island, body or other expected, got \"" + std::string(key) + '"');
  }
  if (result.column && !result.row) throw UsageError("select: col needs row");
  if (!result.other.empty() && result.body.empty()) throw UsageError("select: other needs body");
  return result;
}

SelectionText merged(const SelectionText& base, const SelectionText& over) {
  SelectionText result = base;
  if (over.row) {
    result.row = over.row;
    result.column = over.column;
  }
  if (over.island) result.island = over.island;
  if (!over.body.empty()) {
    result.body = over.body;
    result.other = over.other;
  }
  return result;
}

Selection resolve(const SelectionText& text, const World& world, const char* who) {
  Selection result;
  result.row = text.row.value_or(0) - 1;
  result.column = text.column.value_or(0) - 1;
  result.island = text.island.value_or(0) - 1;
  result.body = find_body(world, text.body, who);
  result.other = find_body(world, text.other, who);
  return result;
}

std::string body_label(const World& world, BodyId body) {
  if (!body || !world.alive(body)) return "ground";
  const std::string_view name = world.name(body);
  if (!name.empty()) return std::string(name);
  const std::int32_t number = world.bodies().number[body.index];
  if (number < 0) return "ground";
  return number < 26 ? std::string(1, static_cast<char>('A' + number)) : std::to_string(number + 1);
}

}  // namespace skerry::sandbox
