// SPDX-License-Identifier: MIT
//
// The words of a benchmark's command line: what is wrong there ends it with status 2, before anything runs.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace skerry::bench {

struct BadArgument : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The word after argv[i], on which i goes.
inline const char* value_of(int argc, char** argv, int& i) {
  if (i + 1 >= argc) throw BadArgument(std::string(argv[i]) + " needs a value");
  return argv[++i];
}

/// A number from `least` to `most`, and nothing else in the word.
inline double number_of(const std::string& option, const char* word, double least, double most) {
  char* end = nullptr;
  const double value = std::strtod(word, &end);
  if (end == word || *end != '\0' || !(value >= least && value <= most)) {
    char text[96];
    std::snprintf(text, sizeof text, ": expected a number from %g to %g, got '", least, most);
    throw BadArgument(option + text + word + "'");
  }
  return value;
}

inline int count_of(const std::string& option, const char* word, int least, int most = 1000000) {
  const double value = number_of(option, word, least, most);
  if (value != std::floor(value)) throw BadArgument(option + ": expected a whole number, got '" + word + "'");
  return static_cast<int>(value);
}

/// "no scene 'x'; there are: a, b"
inline BadArgument unknown(const std::string& kind, std::string_view word,
                           const std::vector<std::string>& names) {
  std::string text = "no " + kind + " '" + std::string(word) + "'; there are: ";
  for (const std::string& name : names) text.append(&name == &names.front() ? "" : ", ").append(name);
  return BadArgument(text);
}

inline void expect_name(const std::string& kind, std::string_view word,
                        const std::vector<std::string>& names) {
  if (std::find(names.begin(), names.end(), word) == names.end()) throw unknown(kind, word, names);
}

/// One name at least has the text in it.
inline void expect_part(const std::string& kind, std::string_view part,
                        const std::vector<std::string>& names) {
  if (std::none_of(names.begin(), names.end(),
                   [&](const std::string& name) { return name.find(part) != std::string::npos; }))
    throw unknown(kind + " with", part, names);
}

template <class List>
std::vector<std::string> names_of(const List& list) {
  std::vector<std::string> names;
  names.reserve(std::size(list));
  for (const auto& entry : list) names.emplace_back(entry.name);
  return names;
}

/// None of the options that are given may go with `option` but those of `allowed`; the others would do
/// nothing.
inline void expect_only(const std::string& option, const std::vector<std::string>& given,
                        std::initializer_list<std::string_view> allowed) {
  for (const std::string& other : given) {
    if (other != option && std::find(allowed.begin(), allowed.end(), other) == allowed.end())
      throw BadArgument(std::string(option).append(" does not go with ").append(other));
  }
}

/// Runs `run` and says what went wrong; where help is asked for, only the usage is printed. @return exit
/// status: 2 where the command line is wrong, 4 for other errors
template <class Run>
int run_with_arguments(const char* program, const char* usage, int argc, char** argv, Run&& run) {
  for (int i = 1; i < argc; ++i) {
    if (std::string_view(argv[i]) == "-h" || std::string_view(argv[i]) == "--help") {
      std::fputs(usage, stdout);
      return 0;
    }
  }
  try {
    return run(argc, argv);
  } catch (const BadArgument& wrong) {
    std::fprintf(stderr, "%s: %s\n", program, wrong.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", program, error.what());
    return 4;
  }
}

}  // namespace skerry::bench
