// SPDX-License-Identifier: MIT
#include "physics/stepping/auto.h"

#include <algorithm>

#include "physics/resting.h"
#include "physics/stepping/event_driven.h"
#include "physics/stepping/time_stepping.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// More events than this in a step, and time stepping is as good and costs less.
constexpr int kMostEvents = 8;
// Steps until an island that was busy is looked at again: a try that fails costs about as much as the step.
constexpr int kPatience = 8;
// Forces of an event-driven step with contacts are found by dense elimination, a dozen times for every inner
// step; beyond this many unknowns that costs more than a thousand time steps.
constexpr int kMostUnknowns = 48;

/// Points with their friction, and joint rows.
int unknowns(const WorldState& state, const Island& island) {
  int count = 2 * static_cast<int>(island.joints.size());
  for (const std::uint32_t index : island.contacts) count += 2 * state.contacts[index].manifold.count;
  return count;
}

}  // namespace

void step_island_by_choice(WorldState& state, const Island& island, double h, IslandResult& result) {
  int busy = 0;
  for (const std::uint32_t i : island.bodies) busy = std::max(busy, state.step_memory[i].busy);
  // Joints alone are eliminated one by one, and an accuracy asked for costs a method of second order far
  // more.
  const bool small = unknowns(state, island) <= kMostUnknowns ||
                     (island.contacts.empty() && state.config.accuracy.has_value());
  bool failed = false;
  if (small && busy == 0) {
    if (try_island_by_events(state, island, h, kMostEvents, result)) return;
    failed = true;
  }
  step_island_by_time_stepping(state, island, h, result);
  // Half the number that ended it, so that the choice does not flicker.
  const bool lively = result.impacts + result.mode_changes > kMostEvents / 2;
  // What rests has no events to look for: the count waits, so that the next step is the same.
  const bool rests = busy > 0 && result.impacts == 0 && stood_still(state, island);
  result.step_memory.busy = failed || lively ? kPatience : rests ? busy : std::max(busy - 1, 0);
}

}  // namespace skerry
