// SPDX-License-Identifier: MIT
//
// Work and precision: every problem, engine and setting once with somebody looking (the error), then several
// times without (the time).
#include <cmath>
#include <cstdio>

#include "tests/bench/accuracy/options.h"
#include "tests/bench/accuracy/problem.h"
#include "tests/bench/arguments.h"

namespace skerry::bench {
namespace {

constexpr int kRates[] = {30, 60, 120, 240, 480, 960, 1920};
constexpr double kAccuracies[] = {1e-3, 1e-6, 1e-9, 1e-13};

/// Seconds of all runs of an outcome, made again.
double time_once(const Trial& trial, const Outcome& outcome) {
  double sum = 0;
  for (const Replay& replay : outcome.runs) {
    const auto engine = trial.engine->make(replay.scene, trial.setting);
    const double start = thread_seconds();
    for (int i = 0; i < replay.steps; ++i) engine->step();
    sum += thread_seconds() - start;
  }
  return sum;
}

/// One setting: a row of the table. Returns the time of one run.
double measure(const Options& options, const Problem& problem, const Trial& trial,
               std::vector<std::string>& rows) {
  const double start = thread_seconds();
  const Outcome outcome = problem.run(trial);
  const double looked = thread_seconds() - start;
  std::vector<double> times;
  if (outcome.gave_up) times.push_back(looked);
  const int runs = outcome.gave_up ? 1 : options.runs;
  while (static_cast<int>(times.size()) < runs) times.push_back(time_once(trial, outcome));
  long steps = 0;
  for (const Replay& replay : outcome.runs) steps += replay.steps;
  const Setting& s = trial.setting;
  rows.push_back(
      joined({problem.name, trial.engine->name, trial.engine->version, s.label, number(s.dt),
              std::to_string(s.iterations), number(s.accuracy),
              outcome.gave_up ? "nan" : number(outcome.error), std::to_string(steps), std::to_string(runs),
              number(median(times)), number(*std::min_element(times.begin(), times.end())),
              number(*std::max_element(times.begin(), times.end()))}));
  return median(times);
}

std::string quoted(const std::string& text) {
  std::string quote(1, '"');
  return quote.append(text).append(1, '"');
}

}  // namespace

std::vector<std::string> precision_scenes() {
  return names_of(problems());
}

void run_precision(const Options& options) {
  for (const Problem& problem : problems()) {
    if (!options.wants_scene(problem.name)) continue;
    std::vector<std::string> rows;
    for (const EngineEntry& engine : engines()) {
      if (!options.wants_engine(engine.name)) continue;
      if ((problem.polygons && !engine.polygons) || (problem.rods && !engine.rods)) continue;
      for (const Setting& curve : engine.curves) {
        if (problem.large && curve.dense) continue;
        Trial trial{.engine = &engine, .setting = curve};
        double spent = 0;
        const bool preview = curve.solver == "nncg" || curve.solver == "tgs_soft";
        if (curve.stepper == "event_driven") {
          // Its answer depends on the accuracy asked for, hardly on the length of the step.
          for (const double accuracy : kAccuracies) {
            trial.setting.accuracy = accuracy;
            spent = measure(options, problem, trial, rows);
            if (spent > 2 * options.cap) break;
          }
        } else {
          for (const int rate : kRates) {
            trial.setting.dt = 1.0 / rate;
            if (rate > 60 && 2 * spent > options.cap) break;
            // The iterative previews are not what we recommend: the ends of their curves will do.
            if (preview && rate != 60 && rate != 240) continue;
            spent = measure(options, problem, trial, rows);
          }
        }
        std::fprintf(stderr, "%s  %s %s  %.2f s\n", problem.name.c_str(), engine.name.c_str(),
                     curve.label.c_str(), spent);
      }
    }
    merge_csv(options, "precision.csv",
              "scene,engine,version,curve,dt,iterations,accuracy,error,steps,runs,median_s,min_s,max_s",
              {problem.name}, rows);
  }
  std::vector<std::string> rows;
  std::vector<std::string> names;
  for (const Problem& problem : problems()) {
    rows.push_back(
        joined({problem.name, quoted(problem.title), quoted(problem.measure), quoted(problem.source)}));
    names.push_back(problem.name);
  }
  merge_csv(options, "scenes.csv", "scene,title,measure,source", names, rows);
}

}  // namespace skerry::bench
