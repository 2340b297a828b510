// SPDX-License-Identifier: MIT
//
// What the parts of the benchmark share: the command line, tables of comma-separated values, the clock.
#pragma once

#include <algorithm>
#include <initializer_list>
#include <string>
#include <vector>

#include "tests/bench/accuracy/engine.h"

namespace skerry::bench {

struct Options {
  std::string out = "accuracy-results";  ///< folder
  std::vector<std::string> scenes;       ///< empty: all
  std::vector<std::string> engines;      ///< empty: all
  int runs = 5;                          ///< timed, of each setting
  double cap = 0.3;  ///< settings whose run would take longer are left out; 1/30 s and 1/60 s never [s]

  bool wants_scene(const std::string& name) const { return wants(scenes, name); }
  bool wants_engine(const std::string& name) const { return wants(engines, name); }

 private:
  static bool wants(const std::vector<std::string>& list, const std::string& name) {
    return list.empty() || std::find(list.begin(), list.end(), name) != list.end();
  }
};

/// Rows of the table `name` whose first field is not in `replaced` stay, and those of engines that were not
/// asked for; `rows` are added. The first line is `header`.
void merge_csv(const Options& options, const std::string& name, const std::string& header,
               const std::vector<std::string>& replaced, const std::vector<std::string>& rows);

/// The fields with commas between them.
std::string joined(std::initializer_list<std::string> fields);

/// Shortest text that reads back as the same number to 6 digits.
std::string number(double value);

/// Processor time of this thread [s]: on an idle machine the wall time, and on a shared one free of the
/// neighbours.
double thread_seconds();
/// The same of all threads.
double process_seconds();

inline double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n == 0 ? 0 : 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

// The parts, one file each.
void run_precision(const Options& options);
void run_stress(const Options& options);
void run_scaling(const Options& options);
void run_skips(const Options& options);
void run_demos(const Options& options);  ///< where the sandbox is built

// The names of their scenes.
std::vector<std::string> precision_scenes();
std::vector<std::string> stress_scenes();
std::vector<std::string> scaling_scenes();
std::vector<std::string> skip_scenes();
std::vector<std::string> demo_scenes();

}  // namespace skerry::bench
