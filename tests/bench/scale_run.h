// SPDX-License-Identifier: MIT
//
// What a run of an engine through a large scene is asked for and gives. Every engine has a file of its own:
// Box2D 2.4 and 3 share their headers' names.
#pragma once

#include <algorithm>
#include <cstdint>
#include <ctime>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/bench/scale_overlap.h"
#include "tests/bench/scale_scenes.h"

namespace skerry::scale {

struct Options {
  int steps = 120;
  double budget = 20;  ///< of one engine in one scene [s]
  int threads = 1;
  std::string solver = "auto";
  std::optional<double> flow_work{};  ///< of ours
  std::string stepper = "time_stepping";
  bool awake = false;       ///< nothing sleeps
  bool fresh = false;       ///< nor are islands at rest kept: every step solves everything
  bool overlaps = false;    ///< measured after every step, which disturbs the times
  int peer_work = 1;        ///< so many times a peer's usual iterations or sub-steps
  bool peer_stiff = false;  ///< with contacts of Box2D 3 so many times as stiff, too
  int copies = 0;           ///< disturbed ones of each scene; 0: the scene itself
  bool by_clock = false;    ///< times are not those of the processor with one thread, too
};

/// What a run of one engine gave.
struct Run {
  std::string scene, engine;
  std::size_t bodies = 0;
  std::vector<double> ms;           ///< of each step
  std::vector<double> collision{};  ///< of it pairs and narrow phase [ms]
  double deepest = -1;              ///< overlap of all steps [m]; < 0: not measured
  double mean_deepest = 0;          ///< of the steps' deepest overlaps [m]
  double apart = 0;                 ///< largest distance of the two anchors of a hinge [m]
  double residual = -1;             ///< of the last step; < 0: unknown
  int asleep = 0;
  std::uint64_t state_hash = 0;  ///< ours, of the last step

  /// Goes on with a run of another copy of the scene.
  void append(const Run& run) {
    const double share = static_cast<double>(run.ms.size()) / static_cast<double>(ms.size() + run.ms.size());
    mean_deepest += share * (run.mean_deepest - mean_deepest);
    deepest = std::max(deepest, run.deepest);
    apart = std::max(apart, run.apart);
    residual = std::max(residual, run.residual);
    asleep = std::min(asleep, run.asleep);
    state_hash = run.state_hash;
    ms.insert(ms.end(), run.ms.begin(), run.ms.end());
    collision.insert(collision.end(), run.collision.begin(), run.collision.end());
  }
  /// Leaves out the times of later steps.
  void cut(std::size_t steps) {
    ms.resize(std::min(steps, ms.size()));
    collision.resize(std::min(steps, collision.size()));
  }
  double mean() const { return mean_of(ms); }
  double mean_collision() const { return mean_of(collision); }
  double median() const {
    std::vector<double> sorted = ms;
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() / 2];
  }

 private:
  static double mean_of(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
  }
};

/// Processor time of this thread where it does all the work, which neighbours on the machine do not change;
/// else the time of the clock [s].
inline double now(const Options& options) {
  timespec t{};
  clock_gettime(options.threads == 1 && !options.by_clock ? CLOCK_THREAD_CPUTIME_ID : CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Calls `step` until the steps or the budget are spent, and `after` untimed.
template <class Step, class After>
void measure(const Options& options, Run& row, Step&& step, After&& after) {
  double seconds = 0;
  for (int i = 0; i < options.steps && seconds < options.budget; ++i) {
    const double start = now(options);
    step();
    const double spent = now(options) - start;
    row.ms.push_back(1e3 * spent);
    seconds += spent;
    after();
  }
}

/// Measures overlaps, if that is wanted. @param pose_of  gives the pose of item i of the scene
template <class PoseOf>
class OverlapLog {
 public:
  OverlapLog(const Scene& scene, const Options& options, PoseOf pose_of)
      : on_(options.overlaps), overlaps_(scene), pose_(scene.items.size()), pose_of_(std::move(pose_of)) {}
  void note(Run& row) {
    if (!on_) return;
    for (std::size_t i = 0; i < pose_.size(); ++i) pose_[i] = pose_of_(i);
    const double deepest = overlaps_.deepest(pose_);
    const auto steps = static_cast<double>(row.ms.size());
    row.deepest = std::max(row.deepest, deepest);
    row.mean_deepest += (deepest - row.mean_deepest) / steps;
  }

 private:
  bool on_;
  Overlaps overlaps_;
  std::vector<Transform> pose_;
  PoseOf pose_of_;
};

#ifdef SKERRY_WITH_BOX2D
Run run_box2d(const char* name, const Scene& scene, const Options& options, bool continuous);
#endif
#ifdef SKERRY_WITH_BOX2D3
/// Without a residual: its impulses are those of four sub-steps, each with its own softened contact problem.
Run run_box2d3(const char* name, const Scene& scene, const Options& options);
#endif

}  // namespace skerry::scale
