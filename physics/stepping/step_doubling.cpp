// SPDX-License-Identifier: MIT
#include "physics/stepping/step_doubling.h"

#include <algorithm>
#include <cmath>

#include "physics/stepping/applied_forces.h"
#include "physics/stepping/hold_margins.h"
#include "physics/stepping/island_backup.h"
#include "physics/stepping/island_notes.h"
#include "physics/stepping/motion_breaks.h"
#include "physics/stepping/time_stepping.h"

namespace skerry {
namespace {

// Inner steps are not shorter than this share of the step: what is left to resolve there is one event.
constexpr double kShortest = 1e-6;
// Relative to the accuracy: how much an inner step with an event may cost.
constexpr double kEventShare = 0.1;
// Differences below this are rounding.
constexpr double kRounding = 1e-15;
// Differences up to this may be what the solver's tolerance and the projection leave: if they do not fall
// below a share of what they were in so many tries in turn, shorter steps are in vain.
constexpr double kNoise = 1e-9, kFalls = 0.5;
constexpr int kInVain = 2;
// Tries a step, and their share of the work that an island may cost, after which the rest is made in at most
// `kLastSteps` steps, whatever their error.
constexpr int kMostTries = 100000, kLastSteps = 16;
constexpr double kTryShare = 0.5;
// Visits that a piece costs for each body, contact and joint besides its solves: rows, manifolds, flights;
// and pieces of a try at least.
constexpr double kPieceVisits = 100;
constexpr int kFewestPieces = 3;

/// Positions and velocities of an island, six numbers a body.
std::vector<double> state_of(const WorldState& state, const Island& island) {
  std::vector<double> y;
  y.reserve(6 * island.bodies.size());
  const BodyArrays& all = state.bodies;
  for (const std::uint32_t i : island.bodies) {
    y.insert(y.end(), {all.position[i].x, all.position[i].y, all.angle[i], all.velocity[i].x,
                       all.velocity[i].y, all.omega[i]});
  }
  return y;
}

bool all_finite(const std::vector<double>& y) {
  return std::all_of(y.begin(), y.end(), [](double value) { return std::isfinite(value); });
}

/// Infinite if a value is not finite.
double largest_difference(const std::vector<double>& x, const std::vector<double>& y) {
  if (!all_finite(x) || !all_finite(y)) return kInfinity;
  double worst = 0;
  for (std::size_t i = 0; i < x.size(); ++i)
    worst = std::max(worst, std::abs(x[i] - y[i]) / std::max(1.0, std::abs(y[i])));
  return worst;
}

/// A result that goes on from what the step has cost so far, so that its solves keep within its budget.
void begin_from(IslandResult& so_far, IslandResult& next) {
  next.memories = std::move(so_far.memories);
  next.work = so_far.work;
  next.thrown_away = so_far.thrown_away;
}

/// Work that was done, whether or not its result is kept. @param from  began from `to`
void book_work(IslandResult& from, IslandResult& to) {
  to.work = from.work;
  to.manifolds_reused += from.manifolds_reused;
  to.narrow += from.narrow;
  for (std::size_t k = 0; k < to.stage_seconds.size(); ++k) to.stage_seconds[k] += from.stage_seconds[k];
  to.report.iterations += from.report.iterations;
  to.memories = std::move(from.memories);
}

void keep(IslandResult& from, IslandResult& to) {
  to.substeps += from.substeps;
  to.impacts += from.impacts;
  to.reflections += from.reflections;
  to.mode_changes += from.mode_changes;
  to.friction_rows += from.friction_rows;
  to.report.rows = from.report.rows;
  to.report.method = from.report.method;
  note_status(to, from.report.status, from.report.residual);
  to.path.insert(to.path.end(), from.path.begin(), from.path.end());
  for (IslandTrace& trace : from.traces) to.traces.push_back(std::move(trace));
}

void step_span(WorldState& state, const Island& island, const SmoothSpan& span, double accuracy,
               IslandResult& result) {
  const double h = span.to - span.from;
  double wanted = h;
  for (const std::uint32_t i : island.bodies) {
    const double last = state.step_memory[i].inner_step;
    if (last > 0) wanted = std::min(wanted, last);
  }
  double elapsed = span.from, last_error = kInfinity, visits_beside = 0;
  int tries = 0, in_vain = 0;
  bool gave_up = false;
  // Flight between contacts that do not act is exact unless it passed ground that moves as told; what rests
  // stays at rest unless its ground moves.
  const bool flies = !has_varying_forces(state, island) && !meets_prescribed_motion(state, island);
  const bool stays = flies && !meets_motion(state, island);
  std::vector<double> ends;
  const double most_work = kTryShare * state.config.solve.work_limit;
  const auto parts =
      static_cast<double>(island.bodies.size() + island.contacts.size() + island.joints.size());
  while (elapsed < span.to) {
    ++tries;
    if (!gave_up &&
        (tries >= kMostTries || (most_work > 0 && result.work.visits + visits_beside > most_work))) {
      gave_up = true;
      wanted = std::max(wanted, (span.to - elapsed) / kLastSteps);
    }
    // Two equal steps rather than one and a crumb; what has no work left has no choice.
    const double left = span.to - elapsed;
    const bool all = wanted >= left || (gave_up && is_spent(state, result));
    const double length = all ? left : wanted > 0.5 * left ? 0.5 * left : wanted;
    const double to = length < left ? elapsed + length : span.to;

    const IslandBackup backup(state, island);
    const std::vector<double> before = state_of(state, island);
    IslandResult whole;
    begin_from(result, whole);
    ends.clear();
    advance_island(state, island, {}, elapsed, to, whole, &ends);
    const std::vector<double> once = state_of(state, island);
    book_work(whole, result);
    if ((flies && whole.report.rows == 0 && whole.impacts == 0) || (stays && once == before)) {
      keep(whole, result);
      ++result.inner_steps;
      wanted = std::max(wanted, 4 * length);
      elapsed = to;
      visits_beside += kPieceVisits * parts * kFewestPieces;
      continue;
    }

    backup.restore(state, island);
    IslandResult halves;
    begin_from(result, halves);
    // Whatever cuts a step cuts it in the same places in both ways: what lies between is halved.
    LateRelease late;
    double from = elapsed;
    for (const double end : ends) {
      const double middle = from + 0.5 * (end - from);
      advance_island(state, island, {}, from, middle, halves, nullptr, 0.5 * length);
      const std::vector<HoldMargin> margins = hold_margins(state, island);
      advance_island(state, island, {}, middle, end, halves, nullptr, 0.5 * length);
      const LateRelease now =
          late_release(margins, hold_margins(state, island), end - from, kEventShare * accuracy);
      late = {std::max(late.velocity, now.velocity), now.ahead};
      from = end;
    }
    book_work(halves, result);
    visits_beside += kPieceVisits * parts * std::max(kFewestPieces, whole.substeps + halves.substeps);
    const std::vector<double> twice = state_of(state, island);
    const double error = std::max(largest_difference(once, twice) / 3, late.velocity);
    const bool eventful = halves.mode_changes > 0 || halves.impacts > 0 || late.velocity > 0;
    const double allowed = std::max(kRounding, accuracy * (eventful ? kEventShare : length));
    const double ratio = error > 0 ? allowed / error : 1e6;
    const double next = length * std::clamp(0.9 * std::sqrt(ratio), 0.1, 4.0);
    in_vain = error <= kNoise && error > kFalls * last_error ? in_vain + 1 : 0;
    last_error = error;
    const bool vain = in_vain >= kInVain;
    if (!(error <= allowed) && length > kShortest * h && !vain && !gave_up) {
      backup.restore(state, island);
      ++result.rejected_steps;
      wanted = std::max(std::min(next, 0.9 * length), kShortest * h);
      continue;
    }
    last_error = kInfinity;
    keep(halves, result);
    ++result.inner_steps;
    result.report.error_estimate += error;
    // The world contains what is lost.
    if (!all_finite(twice)) break;
    // A last step that was cut short says nothing against longer ones.
    if (!gave_up) wanted = length < wanted || vain ? std::max(wanted, next) : next;
    // The next one ends where something lets go.
    if (!gave_up) wanted = std::min(wanted, late.ahead);
    wanted = std::max(wanted, kShortest * h);
    elapsed = to;
  }
  result.step_memory.inner_step = wanted;
}

}  // namespace

void step_with_error_control(WorldState& state, const Island& island, double h, double accuracy,
                             IslandResult& result) {
  const std::vector<SmoothSpan> spans = smooth_spans(state, island, h);
  if (spans.empty()) return step_span(state, island, {0, h}, accuracy, result);
  for (const SmoothSpan& span : spans) {
    begin_span(state, island, span, result);
    step_span(state, island, span, accuracy, result);
  }
}

}  // namespace skerry
