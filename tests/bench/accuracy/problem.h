// SPDX-License-Identifier: MIT
//
// Problems with known answers: a scene, how long it runs, and one number that says how wrong an engine was.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "tests/bench/accuracy/engine.h"

namespace skerry::bench {

/// One engine with one setting.
struct Trial {
  const EngineEntry* engine = nullptr;
  Setting setting;
  double time_limit = 1.5;  ///< a run that takes longer is given up [s]
};

/// What has to be run again to time it: without anybody looking.
struct Replay {
  Scene scene;
  int steps = 0;
};

struct Outcome {
  double error = 0;  ///< infinite: not a number, or given up
  std::vector<Replay> runs;
  bool gave_up = false;  ///< for lack of time
};

struct Problem {
  std::string name;                     ///< file name of its plot
  std::string title;                    ///< for people
  std::string measure;                  ///< of the error, with its unit
  std::string source;                   ///< formula, reference
  bool polygons = false, rods = false;  ///< what an engine must have
  bool large = false;                   ///< one step of a dense solver would take minutes
  std::function<Outcome(const Trial&)> run;
};

/// Steps `scene` for `seconds` and calls `look` after each step; it stops the run by returning false.
/// Adds the run to `outcome`; returns false when the state ceased to be finite or the time was up.
bool simulate(const Trial& trial, const Scene& scene, double seconds, Outcome& outcome,
              const std::function<bool(Engine&, double)>& look, bool forces = false);

/// Largest distance of a body from where it began [m], over all that are not fixed.
double displacement(const Scene& scene, const Engine& engine);

std::vector<Problem> impact_problems();
std::vector<Problem> motion_problems();
std::vector<Problem> rest_problems();
std::vector<Problem> joint_problems();
/// All of them.
const std::vector<Problem>& problems();

// Scenes that stress and scaling use, too.
Scene stack_scene(int count);
/// `light` boxes of 1 kg with one of `ratio` kg on top.
Scene heavy_scene(int light, double ratio);
Scene pyramid_scene(int base);
Scene chain_scene(int links, double heavy, bool lying);
Scene gas_scene(int discs, double share, double speed);

}  // namespace skerry::bench
