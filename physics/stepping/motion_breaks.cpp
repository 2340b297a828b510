// SPDX-License-Identifier: MIT
#include "physics/stepping/motion_breaks.h"

#include <algorithm>

#include "physics/spare.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/one_piece.h"
#include "physics/stepping/one_piece_joints.h"
#include "physics/stepping/projection.h"
#include "physics/stepping/time_stepping.h"
#include "physics/stepping/touching.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// Share of the time before a break that is left out on each side of it, and by which breaks are one.
constexpr double kLeftOut = 1e-13, kOne = 1e-9;
// Joints that are off by less of the smaller body's size have not jumped.
constexpr double kJoined = 1e-8;
// What overlaps by more than this share of the smaller body is wedged.
constexpr double kWedged = 1e-5;

double later(double t) {
  return t * (1 + kLeftOut);
}

/// Of all that an island may meet, ascending.
std::vector<double> breaks_of(const WorldState& state, const Island& island) {
  std::vector<double> breaks;
  const auto take = [&](std::uint32_t body) {
    if (body == BodyId::kNone || !state.prescribed[body]) return;
    const std::vector<double>& own = state.paths[body].breaks();
    breaks.insert(breaks.end(), own.begin(), own.end());
  };
  for (const std::uint32_t index : island.contacts) {
    take(state.contacts[index].body_a);
    take(state.contacts[index].body_b);
  }
  for (const std::uint32_t slot : island.joints) {
    take(state.joints[slot].def.a.index);
    take(state.joints[slot].def.b.index);
  }
  std::sort(breaks.begin(), breaks.end());
  return breaks;
}

void forget_loads(WorldState& state, const Island& island) {
  for (const std::uint32_t index : island.contacts) {
    for (PointMemory& memory : state.contacts[index].points) memory.let_go();
  }
  for (const std::uint32_t slot : island.joints) state.held_rows[slot] = 0;
}

/// What is joined to a body that has jumped.
/// @param far  nothing flows, where joints are off anyway and crowds have no exact place
void take_along(WorldState& state, const Island& island, double elapsed, bool far, IslandResult& result) {
  if (island.joints.empty() || !joints_are_off(state, island, elapsed, kJoined)) return;
  // Loads were those of the place before: nothing is held that was pressed there.
  if (far) forget_loads(state, island);
  Spare<Assembly> rows;
  project_positions(state, island, elapsed, result, *rows, far);
  result.manifolds_reused += update_manifolds(state, island, elapsed, result.narrow);
}

}  // namespace

std::vector<SmoothSpan> smooth_spans(const WorldState& state, const Island& island, double h) {
  std::vector<SmoothSpan> spans;
  if (!state.scratch.motion_breaks) return spans;
  for (const double t : breaks_of(state, island)) {
    if (spans.empty()) spans.push_back({0, h});
    if (t - spans.back().from > kOne * t) {
      spans.back().to = t * (1 - kLeftOut);
      spans.push_back({t, h});
    }
    spans.back().from = later(t);
  }
  return spans;
}

bool begins_span(const WorldState& state, const Island& island, double elapsed) {
  if (elapsed == 0 || !state.scratch.motion_breaks) return elapsed == 0;
  const std::vector<double> breaks = breaks_of(state, island);
  return std::any_of(breaks.begin(), breaks.end(),
                     [=](double t) { return t < elapsed && elapsed <= later(t); });
}

void begin_span(WorldState& state, const Island& island, const SmoothSpan& span, IslandResult& result) {
  if (!(span.from > 0)) return;
  result.manifolds_reused += update_manifolds(state, island, span.from, result.narrow);
  take_along(state, island, span.from, !was_in_flow(state, island), result);
}

void follow_jump(WorldState& state, const Island& island, StepEnd where, double h, IslandResult& result) {
  const bool begins = where == StepEnd::Beginning;
  if (!state.scratch.motion_jumps && (!begins || state.displaced.empty())) return;
  const auto jumps = [&](std::uint32_t body) {
    if (body == BodyId::kNone) return false;
    if (begins && std::binary_search(state.displaced.begin(), state.displaced.end(), body)) return true;
    if (!state.prescribed[body]) return false;
    const MotionPath& path = state.paths[body];
    return begins ? path.begins_with_jump() : path.ends_with_jump();
  };
  const auto is_of_one = [&](std::uint32_t slot) {
    return jumps(state.joints[slot].def.a.index) || jumps(state.joints[slot].def.b.index);
  };
  if (std::none_of(island.joints.begin(), island.joints.end(), is_of_one)) return;
  const double there = begins ? 0 : later(h);
  // What flows has joints that are off anyway, and no exact place for all that it is wedged into.
  const auto is_off_anyway = [&](std::uint32_t slot) {
    return !is_of_one(slot) && how_far_off(state, slot, there) > kJoined;
  };
  const auto is_wedged = [&](std::uint32_t index) {
    const Contact& contact = state.contacts[index];
    return !jumps(contact.body_a) && !jumps(contact.body_b) && is_deep(state, contact, kWedged);
  };
  if (was_in_flow(state, island) && (std::any_of(island.joints.begin(), island.joints.end(), is_off_anyway) ||
                                     std::any_of(island.contacts.begin(), island.contacts.end(), is_wedged)))
    return;
  take_along(state, island, there, true, result);
}

bool step_over_breaks(WorldState& state, const Island& island, const OnePieceRule& rule, double h,
                      IslandResult& result) {
  const std::vector<SmoothSpan> spans = smooth_spans(state, island, h);
  if (spans.empty()) return false;
  for (const SmoothSpan& span : spans) {
    begin_span(state, island, span, result);
    if (rule.work_limit > 0) result.work_limit = rule.work_limit + result.work.visits;
    const double there =
        rule.flows ? span.from : advance_island(state, island, rule, span.from, span.to, result);
    if (there < span.to) step_island_in_flow(state, island, there, span.to, result);
  }
  result.step_memory.flow = result.report.flowing ? 1 : 0;
  return true;
}

}  // namespace skerry
