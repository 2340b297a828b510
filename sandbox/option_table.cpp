// SPDX-License-Identifier: MIT
#include "sandbox/option_table.h"

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>

#include "physics/text.h"
#include "sandbox/errors.h"

namespace skerry::sandbox {

OptionRow& OptionRow::type(const std::string& name) {
  option_->type_name(name);
  return *this;
}

OptionRow& OptionRow::group(const std::string& name) {
  option_->group(name);
  return *this;
}

OptionRow& OptionRow::required() {
  option_->required();
  return *this;
}

namespace {

/// A number for which `test` holds. CLI11's own checks write bounds with six decimals, 1e-14 as 0.
/// @param what  it has to be, for the message @param name  for `--help`
template <class Test>
CLI::Validator number_that(const std::string& what, const std::string& name, const Test& test) {
  const auto check = [what, test](const std::string& word) -> std::string {
    double value = 0;
    if (CLI::detail::lexical_cast(word, value) && test(value)) return {};
    return "expected " + what + ", got " + word;
  };
  return {check, name};
}

CLI::Validator number_within(double least, double most) {
  const std::string low = to_text(least), high = to_text(most);
  return number_that("a number from " + low + " to " + high, "in [" + low + " - " + high + "]",
                     [least, most](double value) { return value >= least && value <= most; });
}

/// CLI11 takes "-1" for the largest number there is, and cuts off what is too large.
CLI::Validator whole_within(std::uint64_t least, std::uint64_t most) {
  const std::string low = std::to_string(least), high = std::to_string(most);
  const auto check = [low, high, least, most](const std::string& word) -> std::string {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    const bool read = error == std::errc() && end == word.data() + word.size();
    if (read && value >= least && value <= most) return {};
    return "expected a whole number from " + low + " to " + high + ", got " + word;
  };
  return {check, "in [" + low + " - " + high + "]"};
}

}  // namespace

OptionRow& OptionRow::positive() {
  option_->check(number_that("a number above 0", "POSITIVE",
                             [](double value) { return value > 0 && std::isfinite(value); }));
  return *this;
}

OptionRow& OptionRow::non_negative() {
  option_->check(number_that("a number of at least 0", "NONNEGATIVE",
                             [](double value) { return value >= 0 && std::isfinite(value); }));
  return *this;
}

OptionRow& OptionRow::whole(std::uint64_t least, std::uint64_t most) {
  option_->check(whole_within(least, most));
  return *this;
}

OptionRow& OptionRow::range(double least, double most) {
  option_->check(number_within(least, most));
  return *this;
}

OptionRow& OptionRow::needs(const OptionRow& other) {
  option_->needs(other.option_);
  return *this;
}

OptionRow& OptionRow::excludes(const OptionRow& other) {
  option_->excludes(other.option_);
  return *this;
}

OptionRow& OptionRow::shows_default() {
  option_->capture_default_str();
  return *this;
}

OptionRow& OptionRow::repeatable(char delimiter) {
  if (delimiter != 0) option_->delimiter(delimiter);
  option_->take_all()->expected(1);
  return *this;
}

OptionRow& OptionRow::one() {
  option_->expected(1);
  return *this;
}

OptionRow& OptionRow::many() {
  option_->expected(1, 1 << 20);
  return *this;
}

OptionRow OptionTable::add(const std::string& names, std::string& value, const std::string& help) {
  return OptionRow(app_.add_option(names, value, help));
}

OptionRow OptionTable::add(const std::string& names, std::optional<std::string>& value,
                           const std::string& help) {
  return OptionRow(app_.add_option(names, value, help));
}

OptionRow OptionTable::add(const std::string& names, std::vector<std::string>& values,
                           const std::string& help) {
  return OptionRow(app_.add_option(names, values, help));
}

OptionRow OptionTable::add(const std::string& names, int& value, const std::string& help) {
  return OptionRow(app_.add_option(names, value, help));
}

OptionRow OptionTable::add(const std::string& names, std::optional<int>& value, const std::string& help) {
  return OptionRow(app_.add_option(names, value, help));
}

OptionRow OptionTable::add(const std::string& names, std::uint64_t& value, const std::string& help) {
  return OptionRow(app_.add_option(names, value, help));
}

OptionRow OptionTable::add(const std::string& names, std::optional<std::uint64_t>& value,
                           const std::string& help) {
  return OptionRow(app_.add_option(names, value, help));
}

OptionRow OptionTable::add(const std::string& names, double& value, const std::string& help) {
  return OptionRow(app_.add_option(names, value, help));
}

OptionRow OptionTable::add(const std::string& names, std::optional<double>& value, const std::string& help) {
  return OptionRow(app_.add_option(names, value, help));
}

OptionRow OptionTable::add(const std::string& names,
                           std::function<void(const std::vector<std::string>&)> take,
                           const std::string& help) {
  return OptionRow(app_.add_option_function<std::vector<std::string>>(names, std::move(take), help));
}

OptionRow OptionTable::add_flag(const std::string& names, bool& value, const std::string& help) {
  return OptionRow(app_.add_flag(names, value, help));
}

std::vector<std::string> parse_options(const std::string& line,
                                       const std::function<void(OptionTable&)>& describe,
                                       const std::vector<std::string>& names) {
  CLI::App app;
  OptionTable table(app);
  describe(table);
  try {
    app.parse(line);
  } catch (const CLI::ParseError& error) {
    throw UsageError(error.what());
  }
  std::vector<std::string> given;
  for (const std::string& name : names)
    if (app.count(name) > 0) given.push_back(name);
  return given;
}

}  // namespace skerry::sandbox
