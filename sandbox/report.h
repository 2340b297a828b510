// SPDX-License-Identifier: MIT
//
// Results of a run as text for people, JSON and CSV.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <string>

#include "sandbox/demo.h"

namespace skerry::sandbox {

/// One line a check, then a summary line.
void print_checks(std::ostream& out, const Demo& demo);

/// What a check found: "ok", "FAIL" or "not reached".
std::string state_word(CheckState state);

/// 16 hexadecimal digits: how hashes are written.
std::string hex(std::uint64_t value);

/// Title, configuration, parameters, checks, bodies, conserved quantities, accuracy, counts, state hash.
/// Depends on nothing but the input: no clocks, no paths but the demo's.
std::string json_report(const Demo& demo, const std::string& command_line);

/// A CSV series, a row a step.
class Series {
 public:
  explicit Series(const Demo& demo);
  void add(Demo& demo);
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

}  // namespace skerry::sandbox
