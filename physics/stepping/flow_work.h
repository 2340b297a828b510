// SPDX-License-Identifier: MIT
//
// What a step of an island in flow may cost, in row visits for each of its bodies.
#pragma once

#include <algorithm>

#include "physics/world_state.h"

namespace skerry {

constexpr double kUsualFlowWork = 400;

/// What it costs in a large world, by which exact answers are judged dear; 0: nothing flows.
inline double usual_flow_work(const WorldState& state) {
  return state.config.flow_work.value_or(kUsualFlowWork);
}

inline bool may_flow(const WorldState& state) {
  return usual_flow_work(state) > 0;
}

/// What it may cost in this one. In a small world sweeps that are far from an answer, as with a heavy body on
/// light ones, may go on, and an interior point after them, until a step takes some milliseconds. Not where
/// there are joints: if these contradict each other, sweeps end nowhere, and more of them shake it more.
inline double flow_work(const WorldState& state, bool joints) {
  constexpr double kShared = 4e5;
  const double usual = usual_flow_work(state);
  if (state.config.flow_work || joints) return usual;
  return std::max(usual, kShared / static_cast<double>(std::max<std::size_t>(state.bodies.size(), 1)));
}
inline double flow_work(const WorldState& state, const Island& island) {
  return flow_work(state, !island.joints.empty());
}

/// Whether there is so much that what sweeps leave is small, and overlaps that come from elsewhere count.
inline bool works_finely(const WorldState& state, bool joints) {
  constexpr double kFine = 1000;
  return flow_work(state, joints) >= kFine;
}

}  // namespace skerry
