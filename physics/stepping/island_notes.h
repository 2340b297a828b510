// SPDX-License-Identifier: MIT
//
// What steppers write down about a solve: status, work, times, and traces for an observer.
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "physics/world_state.h"

namespace skerry {

/// Adds the time of a scope to a stage when the observer wants times.
class StageTimer {
 public:
  StageTimer(const WorldState& state, IslandResult& result, Stage stage)
      : seconds_(state.observe.stage_times ? &result.stage_seconds[static_cast<int>(stage)] : nullptr) {
    if (seconds_ != nullptr) start_ = std::chrono::steady_clock::now();
  }
  ~StageTimer() {
    if (seconds_ == nullptr) return;
    *seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  double* seconds_;
  std::chrono::steady_clock::time_point start_;
};

inline void note_status(IslandResult& result, SolveStatus status, double residual) {
  if (status != SolveStatus::Solved) result.report.status = status;
  result.report.residual = std::max(result.report.residual, residual);
}

/// Counts the work of a solve. @param status  how it ended
inline void note_work(IslandResult& result, const SolveWork& work, SolveStatus status) {
  result.work += work;
  if (status != SolveStatus::Solved) result.vain += work.visits;
}

/// What the next solve of the island may cost of `limit` (`SolveOptions::work_limit`; 0: unlimited): half of
/// what the step has left, so that the problems after it get their share, too, and a sixteenth of the whole
/// at least. Beyond the limit that is halved with each quarter of it, so that a step of hundreds of hopeless
/// problems ends, too.
inline double work_left(double limit, double spent) {
  if (!(limit > 0)) return 0;
  const double over = std::max(0.0, spent / limit - 1);
  // A row's visit at least: nothing would be no limit at all.
  return std::max({1.0, limit / 16 * std::exp2(-4 * over), 0.5 * (limit - spent)});
}

/// Of the limit of the configuration, which rounds of the step that are made again share.
/// @param more  visits that are not booked yet
inline double work_left_of_all(const WorldState& state, const IslandResult& result, double more = 0) {
  return work_left(state.config.solve.work_limit, result.work.visits + result.thrown_away.visits + more);
}

/// Whether all of it is spent: what is left of the step has to do with one more look at everything.
inline bool is_spent(const WorldState& state, const IslandResult& result) {
  const double limit = state.config.solve.work_limit;
  return limit > 0 && result.work.visits + result.thrown_away.visits > limit;
}

/// What is left for forces and positions, which an island that may flow can give up.
inline double work_left(const WorldState& state, const IslandResult& result) {
  const double all = work_left_of_all(state, result), own = work_left(result.work_limit, result.work.visits);
  return all > 0 && own > 0 ? std::min(all, own) : std::max(all, own);
}

/// Keeps a system with its answer. @param elapsed  since the beginning of the step [s]
inline void keep_trace(const WorldState& state, const Island& island, double elapsed, IslandSystem system,
                       std::vector<double> lambda, SolveStatus status, std::string_view method,
                       double residual, bool impact, std::unique_ptr<SolveTrace> trace,
                       IslandResult& result) {
  IslandTrace kept;
  kept.impact = impact;
  kept.time = elapsed;
  for (const std::uint32_t body : island.bodies) kept.bodies.push_back({body, state.bodies.generation[body]});
  kept.system = std::move(system);
  kept.lambda = std::move(lambda);
  kept.status = status;
  kept.method = method;
  kept.residual = residual;
  kept.trace = std::move(trace);
  result.traces.push_back(std::move(kept));
}

}  // namespace skerry
