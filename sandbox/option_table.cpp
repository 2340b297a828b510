// SPDX-License-Identifier: MIT
#include "sandbox/option_table.h"

#include <CLI/CLI.hpp>

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

OptionRow& OptionRow::positive() {
  option_->check(CLI::PositiveNumber);
  return *this;
}

OptionRow& OptionRow::non_negative() {
  option_->check(CLI::NonNegativeNumber);
  return *this;
}

OptionRow& OptionRow::range(int least, int most) {
  option_->check(CLI::Range(least, most));
  return *this;
}

OptionRow& OptionRow::range(double least, double most) {
  option_->check(CLI::Range(least, most));
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
