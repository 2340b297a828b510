// SPDX-License-Identifier: MIT
//
// Clock and small helpers of the solver benchmarks.
#pragma once

#include <algorithm>
#include <ctime>
#include <string>
#include <vector>

#include "physics/solver/solver.h"

namespace skerry::bench {

/// Processor time of this thread [s]: on an idle machine the wall time, and on a shared one mostly free of
/// the neighbours.
inline double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Timing {
  double least = 0, median = 0;  ///< [s] a call
};

/// Calls `f` until `seconds` have passed, three times at least. Each timing is of `repeats` calls.
template <class F>
Timing time_calls(F&& f, int repeats = 1, double seconds = 0.1) {
  std::vector<double> times;
  const double begin = thread_seconds();
  while (times.size() < 3 || (thread_seconds() - begin < seconds && times.size() < 10000)) {
    const double start = thread_seconds();
    for (int k = 0; k < repeats; ++k) f();
    times.push_back((thread_seconds() - start) / repeats);
  }
  std::sort(times.begin(), times.end());
  return {times.front(), times[times.size() / 2]};
}

/// Time of `count` sweeps of projected Gauss-Seidel without the set-up: the difference between many and few.
inline double pgs_sweeps(const IslandSystem& system, int count) {
  static const SolverEntry& pgs = find_solver("pgs");
  const int repeats = system.size() < 100 ? 200 : 1;
  const auto run = [&](int sweeps) {
    return time_calls(
               [&] { (void)pgs.solve(system, {}, {.tolerance = 0, .max_iterations = sweeps}, nullptr); },
               repeats, 0.02)
        .least;
  };
  return std::max(1e-10, (run(21) - run(1)) / 20) * count;
}

}  // namespace skerry::bench
