// SPDX-License-Identifier: MIT
#include "tests/bench/accuracy/skip_switches.h"

#include "tests/bench/accuracy/options.h"

namespace skerry::bench {
namespace {

constexpr SkipSwitch kSwitches[] = {
    {"all on", [](WorldConfig&) {}},
    {"no sleep", [](WorldConfig& c) { c.sleep = false; }},
    {"no resting islands", [](WorldConfig& c) { c.reuse_resting = false; }},
    {"no kept manifolds",
     [](WorldConfig& c) {
       c.reuse_resting = false;
       c.skips.manifolds = false;
     }},
    {"no kept axes", [](WorldConfig& c) { c.skips.axes = false; }},
    {"no kept factors",
     [](WorldConfig& c) {
       c.reuse_resting = false;
       c.skips.factors = false;
     }},
    {"friction rows at mu 0", [](WorldConfig& c) { c.skips.smooth_rows = false; }},
    {"pairs of what flies alike", [](WorldConfig& c) { c.skips.alike = false; }},
    {"no closed-form flight", [](WorldConfig& c) { c.skips.flight = false; }},
    {"reports for nobody", [](WorldConfig&) {}, true},
};

}  // namespace

std::span<const SkipSwitch> skip_switches() {
  return kSwitches;
}

Observe everything() {
  Observe all;
  all.contacts = all.systems = all.solve_traces = all.paths = true;
  return all;
}

void SkipCounters::add(const StepReport& report) {
  pairs += report.pairs;
  pairs_out_of_reach += report.pairs_out_of_reach;
  manifolds_reused += report.manifolds_reused;
  axes_tested += static_cast<double>(report.narrow.axes_tested);
  axes_skipped += static_cast<double>(report.narrow.axes_skipped);
  rows += report.rows;
  friction_rows += report.friction_rows;
  factorisations += report.work.factorisations;
  resolves += report.work.resolves;
  symbolic_skipped += report.work.symbolic_skipped;
  islands += report.islands;
  islands_asleep += report.islands_asleep;
  islands_at_rest += report.islands_at_rest;
  islands_in_flight += report.islands_in_flight;
  state_hash = report.state_hash;
}

std::string SkipCounters::row(double steps) const {
  const auto per_step = [&](double total) { return number(total / steps); };
  return joined({per_step(pairs), per_step(pairs_out_of_reach), per_step(manifolds_reused),
                 per_step(axes_tested), per_step(axes_skipped), per_step(rows), per_step(friction_rows),
                 per_step(factorisations), per_step(resolves), per_step(symbolic_skipped), per_step(islands),
                 per_step(islands_asleep), per_step(islands_at_rest), per_step(islands_in_flight)});
}

const char* SkipCounters::columns() {
  return "pairs,pairs_out_of_reach,manifolds_reused,axes_tested,axes_skipped,rows,friction_rows,"
         "factorisations,resolves,symbolic_skipped,islands,islands_asleep,islands_at_rest,islands_in_flight";
}

}  // namespace skerry::bench
