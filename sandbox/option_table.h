// SPDX-License-Identifier: MIT
//
// What the commands need of CLI11. Its header costs seconds in every file that includes it, so one file does.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace skerry::sandbox {

/// An option while it is described.
class OptionRow {
 public:
  explicit OptionRow(CLI::Option* option) : option_(option) {}

  /// What stands for the value in --help.
  OptionRow& type(const std::string& name);
  /// The heading under which --help lists it.
  OptionRow& group(const std::string& name);
  OptionRow& required();
  /// Numbers are finite; whole ones are written in digits alone.
  OptionRow& positive();
  OptionRow& non_negative();
  OptionRow& whole(std::uint64_t least, std::uint64_t most);
  OptionRow& range(double least, double most);
  OptionRow& needs(const OptionRow& other);
  OptionRow& excludes(const OptionRow& other);
  /// --help shows the value that it has now.
  OptionRow& shows_default();
  /// One word each time it is given, split at the delimiter (0: not split); all are kept.
  OptionRow& repeatable(char delimiter = 0);
  /// So many words; one or more with `many`.
  OptionRow& one();
  OptionRow& many();

 private:
  CLI::Option* option_;
};

/// The options of a command. Names as in "-o,--out"; a name without dashes is an argument by place.
class OptionTable {
 public:
  explicit OptionTable(CLI::App& app) : app_(app) {}

  OptionRow add(const std::string& names, std::string& value, const std::string& help);
  OptionRow add(const std::string& names, std::optional<std::string>& value, const std::string& help);
  OptionRow add(const std::string& names, std::vector<std::string>& values, const std::string& help);
  OptionRow add(const std::string& names, int& value, const std::string& help);
  OptionRow add(const std::string& names, std::optional<int>& value, const std::string& help);
  OptionRow add(const std::string& names, std::uint64_t& value, const std::string& help);
  OptionRow add(const std::string& names, std::optional<std::uint64_t>& value, const std::string& help);
  OptionRow add(const std::string& names, double& value, const std::string& help);
  OptionRow add(const std::string& names, std::optional<double>& value, const std::string& help);
  /// Hands over all words at once.
  OptionRow add(const std::string& names, std::function<void(const std::vector<std::string>&)> take,
                const std::string& help);
  OptionRow add_flag(const std::string& names, bool& value, const std::string& help);

 private:
  CLI::App& app_;
};

/// Reads options from a line of text, as a command would from its arguments.
/// @param describe adds the options
/// @return the names that were given, of those asked for
/// @throws UsageError
std::vector<std::string> parse_options(const std::string& line,
                                       const std::function<void(OptionTable&)>& describe,
                                       const std::vector<std::string>& names);

}  // namespace skerry::sandbox
