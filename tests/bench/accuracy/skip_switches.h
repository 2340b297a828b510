// SPDX-License-Identifier: MIT
//
// The skips of a step as switches, and the counters of what they leave out: shared by the parts `skips`
// (scenes of this benchmark) and `demos`.
#pragma once

#include <span>
#include <string>

#include "physics/world.h"

namespace skerry::bench {

/// One way to step: with all skips (the first of `skip_switches`), or with one of them off.
struct SkipSwitch {
  const char* name;
  void (*off)(WorldConfig& config);
  bool report_all = false;  ///< everything is reported although nobody looks
};
std::span<const SkipSwitch> skip_switches();

/// What a world reports where nobody is spared anything; the wall time of stages is left out.
Observe everything();

/// Counters of a run, summed over its steps.
struct SkipCounters {
  double pairs = 0, pairs_out_of_reach = 0, manifolds_reused = 0, axes_tested = 0, axes_skipped = 0;
  double rows = 0, friction_rows = 0, factorisations = 0, resolves = 0, symbolic_skipped = 0;
  double islands = 0, islands_asleep = 0, islands_at_rest = 0, islands_in_flight = 0;
  std::uint64_t state_hash = 0;  ///< after the last step

  void add(const StepReport& report);
  /// The numbers a step, with commas between them, in the order of `columns`.
  std::string row(double steps) const;
  static const char* columns();
};

}  // namespace skerry::bench
