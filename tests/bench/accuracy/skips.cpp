// SPDX-License-Identifier: MIT
//
// What is skipped, and what it would cost: scenes with all skips, and with one of them off at a time.
#include <cmath>
#include <cstdio>

#include "tests/bench/accuracy/engine_skerry.h"
#include "tests/bench/accuracy/options.h"
#include "tests/bench/accuracy/problem.h"
#include "tests/bench/accuracy/skip_switches.h"
#include "tests/bench/arguments.h"

namespace skerry::bench {
namespace {

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
  // Side by side, a hand apart, on their way down to nothing.
  Scene rain;
  for (int i = 0; i < 900; ++i)
    rain.add({.shape = box(0.5, 0.5), .position = {0.6 * (i % 30), 0.6 * (i / 30)}, .velocity = {0, -2}});
  // Diamonds with parallel faces, 0.03 m apart, whose bounding boxes overlap; each on a way of its own.
  Scene apart;
  apart.gravity = {};
  for (int i = 0; i < 900; ++i) {
    const int row = i / 30, column = 2 * (i % 30) + row % 2;
    apart.add({.shape = box(0.5, 0.5),
               .position = {0.375 * column, 0.375 * row},
               .angle = kPi / 4,
               .velocity = {0.005 * (i % 3 - 1), 0.005 * (i % 5 - 2)}});
  }
  return {{"cradle of 50", cradle, 60, -1},
          {"stack of 30 at rest", stack_scene(30), 120, -1},
          {"stack of 30 pushed", stack_scene(30), 120, 15},
          {"pyramid of 20 at rest", pyramid_scene(20), 60, -1},
          {"pyramid of 20 pushed", pyramid_scene(20), 60, 100},
          {"chain of 100 swinging", chain_scene(100, 1000, true), 60, -1},
          {"elastic gas of 300", gas_scene(300, 0.3, 5), 60, -1},
          {"1000 discs in flight", flight, 60, -1},
          {"smooth stack of 30", smooth, 60, -1},
          {"smooth stack of 30 pushed", smooth, 60, 15},
          {"900 boxes falling side by side", rain, 60, -1},
          {"900 boxes drifting a gap apart", apart, 60, -1}};
}

/// @return processor time of the whole example [s]
double run_once(const Example& example, const SkipSwitch& way, SkipCounters& counters) {
  WorldConfig config;
  way.off(config);
  std::vector<BodyId> bodies;
  World world = make_world(example.scene, config, bodies);
  if (way.report_all) world.observe(everything());
  counters = {};
  double seconds = 0;
  for (int step = 0; step < example.steps; ++step) {
    if (example.pushed >= 0) {
      const BodyId body = bodies[static_cast<std::size_t>(example.pushed)];
      world.apply_impulse(body, {0.001 * (1 + step % 7), 0}, world.position(body));
    }
    const double start = thread_seconds();
    const StepReport& report = world.step(1.0 / 60);
    seconds += thread_seconds() - start;
    counters.add(report);
  }
  return seconds;
}

}  // namespace

std::vector<std::string> skip_scenes() {
  return names_of(examples());
}

void run_skips(const Options& options) {
  std::vector<std::string> rows, names;
  for (const Example& example : examples()) {
    if (!options.wants_scene(example.name)) continue;
    names.push_back(example.name);
    const std::span<const SkipSwitch> ways = skip_switches();
    std::vector<std::vector<double>> times(ways.size());
    std::vector<SkipCounters> counters(ways.size());
    // In turns, so that a neighbour's load hits them all.
    for (int k = 0; k < options.runs; ++k) {
      for (std::size_t way = 0; way < ways.size(); ++way)
        times[way].push_back(1e6 * run_once(example, ways[way], counters[way]) / example.steps);
    }
    for (std::size_t way = 0; way < ways.size(); ++way) {
      rows.push_back(joined({example.name, ways[way].name, number(median(times[way])),
                             number(*std::min_element(times[way].begin(), times[way].end())),
                             number(*std::max_element(times[way].begin(), times[way].end())),
                             counters[way].state_hash == counters[0].state_hash ? "same" : "differs",
                             counters[way].row(example.steps)}));
    }
    std::fprintf(stderr, "%s\n", example.name);
  }
  merge_csv(options, "skips.csv",
            std::string("scene,switch,median_us,min_us,max_us,bits,") + SkipCounters::columns(), names, rows);
}

}  // namespace skerry::bench
