// SPDX-License-Identifier: MIT
//
// What is skipped, and what it would cost: scenes with all skips, and with one of them off at a time.
#include <cmath>
#include <cstdio>

#include "tests/bench/accuracy/engine_skerry.h"
#include "tests/bench/accuracy/options.h"
#include "tests/bench/accuracy/problem.h"

namespace skerry::bench {
namespace {

struct Switch {
  const char* name;
  void (*off)(WorldConfig& config);
};

constexpr Switch kSwitches[] = {
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
};

struct Example {
  const char* name;
  Scene scene;
  int steps;
  int pushed;  ///< this body is pushed at every step; -1: none
};

std::vector<Example> examples() {
  Scene cradle;
  cradle.gravity = {};
  cradle.friction = 0;
  cradle.restitution = 1;
  for (int i = 0; i < 50; ++i)
    cradle.add(
        {.shape = disc(0.5), .position = {i - (i == 0 ? 1.0 : 0.0), 0}, .velocity = {i == 0 ? 2.0 : 0.0, 0}});
  Scene flight = gas_scene(1000, 0.001, 1);
  Scene smooth = stack_scene(30);
  smooth.friction = 0;
  return {{"cradle of 50", cradle, 60, -1},
          {"stack of 30 at rest", stack_scene(30), 120, -1},
          {"stack of 30 pushed", stack_scene(30), 120, 15},
          {"pyramid of 20 at rest", pyramid_scene(20), 60, -1},
          {"pyramid of 20 pushed", pyramid_scene(20), 60, 100},
          {"chain of 100 swinging", chain_scene(100, 1000, true), 60, -1},
          {"elastic gas of 300", gas_scene(300, 0.3, 5), 60, -1},
          {"1000 discs in flight", flight, 60, -1},
          {"smooth stack of 30", smooth, 60, -1}};
}

/// Processor time of the whole example [s]; the report of its last step stays in `report`.
double run_once(const Example& example, const WorldConfig& config, StepReport& sum) {
  std::vector<BodyId> bodies;
  World world = make_world(example.scene, config, bodies);
  sum = {};
  double seconds = 0;
  for (int step = 0; step < example.steps; ++step) {
    if (example.pushed >= 0) {
      const BodyId body = bodies[static_cast<std::size_t>(example.pushed)];
      world.apply_impulse(body, {0.001 * (1 + step % 7), 0}, world.position(body));
    }
    const double start = thread_seconds();
    const StepReport& report = world.step(1.0 / 60);
    seconds += thread_seconds() - start;
    sum.pairs += report.pairs;
    sum.pairs_out_of_reach += report.pairs_out_of_reach;
    sum.manifolds_reused += report.manifolds_reused;
    sum.narrow.axes_tested += report.narrow.axes_tested;
    sum.narrow.axes_skipped += report.narrow.axes_skipped;
    sum.rows += report.rows;
    sum.friction_rows += report.friction_rows;
    sum.work.factorisations += report.work.factorisations;
    sum.work.resolves += report.work.resolves;
    sum.work.symbolic_skipped += report.work.symbolic_skipped;
    sum.islands += report.islands;
    sum.islands_at_rest += report.islands_at_rest;
    sum.islands_in_flight += report.islands_in_flight;
    sum.state_hash = report.state_hash;
  }
  return seconds;
}

}  // namespace

void run_skips(const Options& options) {
  std::vector<std::string> rows, names;
  for (const Example& example : examples()) {
    if (!options.wants_scene(example.name)) continue;
    names.push_back(example.name);
    std::uint64_t hash = 0;
    for (const Switch& s : kSwitches) {
      WorldConfig config;
      s.off(config);
      StepReport sum;
      std::vector<double> times;
      for (int k = 0; k < options.runs; ++k) times.push_back(run_once(example, config, sum) / example.steps);
      if (hash == 0) hash = sum.state_hash;
      const auto per_step = [&](double total) { return number(total / example.steps); };
      rows.push_back(joined(
          {example.name, s.name, number(1e6 * median(times)),
           number(1e6 * *std::min_element(times.begin(), times.end())),
           number(1e6 * *std::max_element(times.begin(), times.end())),
           hash == sum.state_hash ? "same" : "differs", per_step(sum.pairs), per_step(sum.pairs_out_of_reach),
           per_step(sum.manifolds_reused), per_step(static_cast<double>(sum.narrow.axes_tested)),
           per_step(static_cast<double>(sum.narrow.axes_skipped)), per_step(sum.rows),
           per_step(sum.friction_rows), per_step(sum.work.factorisations), per_step(sum.work.resolves),
           per_step(sum.work.symbolic_skipped), per_step(sum.islands), per_step(sum.islands_at_rest),
           per_step(sum.islands_in_flight)}));
    }
    std::fprintf(stderr, "%s\n", example.name);
  }
  merge_csv(
      options.out + "/skips.csv",
      "scene,switch,median_us,min_us,max_us,bits,pairs,pairs_out_of_reach,manifolds_reused,axes_tested,"
      "axes_skipped,rows,friction_rows,factorisations,resolves,symbolic_skipped,islands,islands_at_rest,"
      "islands_in_flight",
      names, rows);
}

}  // namespace skerry::bench
