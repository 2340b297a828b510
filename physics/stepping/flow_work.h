// SPDX-License-Identifier: MIT
//
// What a step of an island in flow may cost, in row visits for each of its bodies.
#pragma once

#include <algorithm>

#include "physics/world_state.h"

namespace skerry {

constexpr double kUsualFlowWork = 400;
// Joints make sweeps converge slower: the work of an island grows by so many bodies for each. With 2 sweeps
// of thousands of people leave 0.7 of the residual, and the same overlaps and errors of hinges.
constexpr double kJointWork = 0.5;

/// What it costs in a large world, by which exact answers are judged dear; 0: nothing flows.
inline double usual_flow_work(const WorldState& state) {
  return state.config.flow_work.value_or(kUsualFlowWork);
}

inline bool may_flow(const WorldState& state) {
  return usual_flow_work(state) > 0;
}

/// Whether what flows may be left to it: with an accuracy asked for it is not.
inline bool flow_serves(const WorldState& state) {
  return may_flow(state) && !state.config.accuracy;
}

// Work of a body with which what sweeps leave is small, an interior point fits in behind them, and overlaps
// that come from elsewhere count.
constexpr double kFineWork = 1000;

// Dynamic bodies, asleep or not, from which on a world is a large one.
constexpr double kLargeWorld = 1000;

// Bodies of the world that an island stands for whose work the world does not share.
constexpr double kAlone = 100;

inline bool is_small(const WorldState& state, const Island& island) {
  return island.alone || static_cast<double>(state.dynamic_bodies) < kLargeWorld;
}

/// What it may cost in this one. In a small world sweeps that are far from an answer, as with a heavy body on
/// light ones, may go on, and an interior point after them, until a step takes some milliseconds; without
/// joints each of up to a thousand bodies has `kFineWork`. Where there are joints what is more than usual is
/// for the interior point alone: if these contradict each other, sweeps end nowhere.
/// @param dynamic  bodies that share it
inline double flow_work(const WorldState& state, double dynamic, std::size_t joints) {
  constexpr double kShared = 4e5;
  const double usual = usual_flow_work(state);
  if (state.config.flow_work) return usual;
  const double bodies = dynamic + kJointWork * static_cast<double>(joints);
  return std::max(joints > 0 || bodies >= kLargeWorld ? usual : kFineWork, kShared / std::max(bodies, 1.0));
}
inline double flow_work(const WorldState& state, const Island& island) {
  const auto dynamic = static_cast<double>(state.dynamic_bodies);
  return flow_work(state, island.alone ? std::min(dynamic, kAlone) : dynamic, island.joints.size());
}

/// Whether there is so much of it.
inline bool works_finely(const WorldState& state, const Island& island) {
  return flow_work(state, island) >= kFineWork;
}
/// The same of an island without joints.
inline bool works_finely(const WorldState& state) {
  return flow_work(state, static_cast<double>(state.dynamic_bodies), 0) >= kFineWork;
}

}  // namespace skerry
