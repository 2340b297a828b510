// SPDX-License-Identifier: MIT
#include "physics/stepping/one_piece_rule.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "physics/stepping/applied_forces.h"
#include "physics/stepping/flow_work.h"
#include "physics/stepping/island_energy.h"
#include "physics/stepping/island_notes.h"
#include "physics/stepping/one_piece_joints.h"
#include "physics/stepping/touching.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// Exact forces of fewer points cost no more than a step in one piece.
constexpr int kFewPoints = 30;
// Shares of fast points from which on an island flows, and down to which it goes on to.
constexpr double kEnter = 0.2, kLeave = 0.05;
// Landings in a step, each of which would cut it, that count like the larger share, and pieces of an exact
// step after which the smaller shares serve.
constexpr int kLandings = 8, kFewLandings = 2, kPieces = 4;
// So many pieces are dear for few points, too.
constexpr int kManyPieces = 16, kFewestPoints = 8;
// In a large world a step in flow costs less than two pieces, and leaves no more of overlaps and joints, from
// fewer points on. Pieces of islands of which a point is fast, and of those that are but lightly disturbed.
constexpr int kFewestInLarge = 4, kFastPiecesInLarge = 1, kSlowPiecesInLarge = 16;
// Share of a slow speed below which all points of an island are calm, and its pieces are not limited: a tower
// taps to rest with some twenty, and what flow leaves after sixteen would shake it for ever.
constexpr double kCalm = 0.1;
// Points from which on an impact of all of them, from nothing, costs more than the forces that it is solved
// with here.
constexpr int kManyPoints = 100;
// Share of the smaller body's size by which joints are off in what is jammed.
constexpr double kDisplaced = 0.01;
// The same that exact steps never leave where they find the places of the bodies.
constexpr double kApart = 1e-5;
// Restitution up to which a pile flows by its motion: balls that keep more of their speed are no pile.
constexpr double kMostBounce = 0.5;
// The same up to which a large one does after a piece in which something rests.
constexpr double kMostBounceOfPile = 0.9;
// Exact forces that cost so many times what the step of an island in flow does are given up.
constexpr double kBusy = 50;
// The same of a large one that flowed in the last step: attempts are many there, and mostly vain. Most, as
// long as that is no more visits than the number behind it, and least.
constexpr double kMostBusyInFlow = 15, kBusyVisits = 2e6, kBusyInFlow = 2;
// A sweep hands a blow of a heavy body on by the mass of a light one. Where at least this share of the bodies
// is so many times as heavy as the lightest one, work is that many visits a body and more, in proportion to
// their number, by which they come to rest. More bodies than the last number do not, for any work that a step
// may have, and get what makes overlaps small.
constexpr double kHeavyShare = 0.02, kHeavy = 100;
constexpr double kHeavyWork = 4000, kHeavyWorkOfEach = 10, kMostHeavyBodies = 700;
// Points of islands that are crowded: at least, and of each body.
constexpr std::size_t kCrowd = 1000, kCrowdOfBody = 24;
// Steps for which nobody asks for an exact answer after the first attempt that failed, which doubles with
// each, and the most. In a large world a pile that is not ready in this step is not in the next one, either;
// what flow leaves of joints wants exact steps sooner.
constexpr int kFirstWait = 1, kFirstWaitInLarge = 16, kLongestWait = 256;
// Contacts that a thread takes at a time.
// Pieces in which everything bounces; from the next on what is slow does not, at first what is slower than a
// fourteenth of g h. That doubles every so many pieces, up to g h itself.
constexpr int kBouncingPieces = 8, kLowBouncePieces = 24;
constexpr double kBouncePiecesADoubling = 4;
// The hops that are none [touch tolerances], which from then on doubles every so many pieces.
constexpr double kLeastHop = 1e-3, kHopPiecesADoubling = 2;
// Share of a fall in the step by which a landing corner may have sunk, and most of it in touch tolerances.
constexpr double kSunk = 1e-3, kMostSunk = 1e3;
// Height of bounces [touch tolerances] that are none from then on where something turns.
constexpr double kLowBounce = 16;

constexpr std::size_t kContactsAPiece = 256;

/// Points beside so many joints up to which exact forces cost no more than a step in one piece.
int few_points(int joints) {
  return std::max(kFewPoints - joints, kFewestPoints);
}

/// Points of the island, or 0 where they are too few to flow.
/// @param fewest  that are too few @param bounce  set to the largest restitution of any of them
int points_that_flow(const WorldState& state, const Island& island, int fewest, double& bounce) {
  std::atomic<int> points = 0;
  std::atomic<double> largest = 0;
  share(state.island_threads, island.contacts.size(), kContactsAPiece, [&](std::size_t from, std::size_t to) {
    int count = 0;
    double most = 0;
    for (std::size_t k = from; k < to; ++k) {
      const Contact& contact = state.contacts[island.contacts[k]];
      most = std::max(most, contact.restitution);
      count += contact.manifold.count;
    }
    points += count;
    raise_to(largest, most);
  });
  bounce = largest;
  return points > fewest && flow_serves(state) ? points.load() : 0;
}

/// @param elapsed  since the beginning of the step [s]
bool has_parted(const WorldState& state, const Island& island, double elapsed) {
  return !island.joints.empty() && joints_are_off(state, island, elapsed, kApart);
}

/// What is wedged has no place to go to.
bool has_overlaps(const WorldState& state, const Island& island) {
  return any_of(state.island_threads, island.contacts.size(), kContactsAPiece,
                [&](std::size_t k) { return is_deep(state, state.contacts[island.contacts[k]], kApart); });
}

struct PointCounts {
  int points = 0, fast = 0, strikes = 0, landings = 0;
  int stirring = 0;     ///< that are not calm
  int approaching = 0;  ///< of the fast ones
};

/// Points of some contacts that come near within the step, and what they do.
PointCounts count_points(const WorldState& state, const Island& island, double h, double slow,
                         std::size_t from, std::size_t to) {
  PointCounts count;
  for (std::size_t k = from; k < to; ++k) {
    const Contact& contact = state.contacts[island.contacts[k]];
    for (int i = 0; i < contact.manifold.count; ++i) {
      const ManifoldPoint& point = contact.manifold.points[i];
      const Vec2 u = relative_velocity(state, contact, point.position, 0);
      const double approach = -dot(contact.manifold.normal, u);
      if (point.separation - h * approach > state.config.contact_margin) continue;
      ++count.points;
      if (is_touching(state, point))
        count.strikes += approach > state.config.rest_speed;
      else
        count.landings += point.separation < h * approach;
      count.approaching += approach > slow;
      const double speed =
          std::max(approach, std::abs(dot(perp(contact.manifold.normal), u) - contact.surface_velocity));
      count.fast += speed > slow;
      count.stirring += speed > kCalm * slow;
    }
  }
  return count;
}

}  // namespace

double slow_speed(const WorldState& state, const Island& island, double h) {
  return h * largest_acceleration(state, island) + state.config.rest_speed;
}

SmallGaps small_gaps(const WorldState& state, const Island& island, double h, int piece) {
  SmallGaps gaps{.hop = kLeastHop};
  if (!state.config.accuracy) {
    const double doublings = (piece - kBouncingPieces) / kHopPiecesADoubling;
    gaps.hop = std::clamp(kLeastHop * std::exp2(doublings), kLeastHop, 1.0);
  }
  const double fall = 0.5 * h * h * largest_acceleration(state, island);
  if (fall > 0) gaps.sunk = std::clamp(kSunk * fall / state.config.touch_tolerance, 1.0, kMostSunk);
  return gaps;
}

double slowest_bounce(const WorldState& state, const Island& island, double h, int piece) {
  if (piece <= kBouncingPieces || state.config.accuracy) return 0;
  const double share = std::exp2((piece - kLowBouncePieces) / kBouncePiecesADoubling);
  // What turns is thrown against what it touches far harder than by gravity: its lowest bounces are shorter
  // than what landings are found by.
  double turning = 0;
  for (const std::uint32_t i : island.bodies)
    turning = std::max(turning, state.bodies.omega[i] * state.bodies.omega[i] * state.radius[i]);
  const double low = std::sqrt(2 * turning * kLowBounce * state.config.touch_tolerance);
  return std::max(low, std::min(1.0, share) * slow_speed(state, island, h));
}

bool is_crowded(const WorldState& state, const Island& island) {
  const std::size_t least = std::max(kCrowd, kCrowdOfBody * island.bodies.size());
  if (2 * island.contacts.size() <= least || !flow_serves(state)) return false;
  std::size_t points = 0;
  for (const std::uint32_t i : island.contacts)
    points += static_cast<std::size_t>(state.contacts[i].manifold.count);
  return points > least;
}

bool was_in_flow(const WorldState& state, const Island& island) {
  return std::any_of(island.bodies.begin(), island.bodies.end(),
                     [&](std::uint32_t i) { return state.step_memory[i].flow > 0; });
}

bool flows_on(const WorldState& state, const Island& island, double h) {
  const bool moved = std::any_of(island.bodies.begin(), island.bodies.end(), [&](std::uint32_t i) {
    return state.step_memory[i].flow > 0 && state.step_memory[i].flow != kParted;
  });
  return moved && one_piece_rule(state, island, h).flows;
}

OnePieceRule one_piece_rule(const WorldState& state, const Island& island, double h) {
  int flow = 0;
  for (const std::uint32_t i : island.bodies) flow = std::max(flow, state.step_memory[i].flow);
  const bool must = flow == kMustFlow;
  const int usual = few_points(static_cast<int>(island.joints.size()));
  const bool in_large = flow_serves(state) && !works_finely(state, island);
  const int fewest = in_large ? kFewestInLarge : kFewestPoints;
  const int few = in_large || (flow > 1 && !must) || !state.solver->exact ? fewest : usual;
  OnePieceRule rule;
  const bool jointed = !island.joints.empty() && flow_serves(state);
  if (jointed)
    rule.vain_limit =
        kBusy * usual_flow_work(state) *
        (static_cast<double>(island.bodies.size()) + kJointWork * static_cast<double>(island.joints.size()));
  rule.flows =
      is_crowded(state, island) || (flow == kParted && flow_serves(state) && has_parted(state, island, 0));
  if (rule.flows) return rule;
  double bounce = 0;
  const int all = points_that_flow(state, island, fewest, bounce);
  rule.bounces_well = bounce > kMostBounce;
  const auto limit_pieces = [&](int fast, int stirring) {
    if (!in_large || rule.bounces_well || (!jointed && (all == 0 || all > usual))) return;
    if (fast > 0)
      rule.most_pieces = kFastPiecesInLarge;
    else if (jointed || stirring > 0)
      rule.most_pieces = kSlowPiecesInLarge;
  };
  if (all > usual) {
    const double step = usual_flow_work(state) * static_cast<double>(island.bodies.size());
    rule.work_limit = flow > 0 && all > kManyPoints
                          ? std::clamp(kBusyVisits, kBusyInFlow * step, kMostBusyInFlow * step)
                          : kBusy * step;
  }
  // Only flow leaves joints off by more than exact steps take out at once: what it has jammed would be torn
  // apart.
  if (flow > 0 && all > 0 && joints_are_off(state, island, 0, kDisplaced)) rule.flows = true;
  if (rule.flows) return rule;
  if (all <= few) {
    if (in_large && jointed) {
      const PointCounts count =
          count_points(state, island, h, slow_speed(state, island, h), 0, island.contacts.size());
      limit_pieces(count.fast, count.stirring);
    }
    return rule;
  }
  rule.flows = must || (!state.solver->exact && !rule.bounces_well);
  if (rule.flows) return rule;
  const double slow = slow_speed(state, island, h);
  std::atomic<int> points = 0, fast = 0, stirring = 0, strikes = 0, landings = 0, approaching = 0;
  share(state.island_threads, island.contacts.size(), kContactsAPiece, [&](std::size_t from, std::size_t to) {
    const PointCounts some = count_points(state, island, h, slow, from, to);
    points += some.points;
    fast += some.fast;
    stirring += some.stirring;
    strikes += some.strikes;
    landings += some.landings;
    approaching += some.approaching;
  });
  limit_pieces(fast, stirring);
  // Flights are no pieces: a gas goes from impact to impact for as long as nothing in it rests.
  if (rule.bounces_well && flow_serves(state) && bounce <= kMostBounceOfPile && points > kManyPoints &&
      landings > kLandings)
    rule.most_pieces = 1;
  if (points <= few) return rule;
  // A few that were cut often and merely slide on are not cut any more.
  const int busy = all > usual || in_large || approaching > 0 ? fast.load() : 0;
  // What bounces well flows only where exact steps proved to be dear.
  rule.flows = flow > 0            ? busy > kLeave * points || landings > kFewLandings
               : rule.bounces_well ? false
                                   : fast > kEnter * points || landings > kLandings;
  if (bounce > 0) return rule;
  rule.light = fast == 0 && points > kFewPoints && (strikes > 0 || landings > kFewLandings);
  rule.large = points > kManyPoints && island.joints.empty();
  // A cloud that drifts together does not come to rest by being stepped exactly.
  if (rule.large && rule.light && in_large && is_free(state, island)) {
    rule.flows = true;
    rule.light = false;
  }
  return rule;
}

void note_parted(const WorldState& state, const Island& island, double h, IslandResult& result) {
  // What will be made again has not moved yet, and what flew was looked at before.
  if (result.unmoved || result.in_flight) return;
  const bool exact = !result.report.flowing;
  const bool parted = has_parted(state, island, h);
  if (!parted && !(exact && has_overlaps(state, island))) return;
  note_status(result, SolveStatus::Inexact, 0);
  if (exact && parted) result.step_memory.flow = kParted;
}

int restlessness(const IslandResult& result) {
  // Rods cut what flows, however calm it is.
  const int pieces = result.substeps - std::max(result.flow_pieces - 1, 0);
  return pieces > kManyPieces ? 2 : pieces > kPieces ? 1 : 0;
}

void wait_after_failure(const WorldState& state, const Island& island, StepMemory& memory) {
  const bool in_large = may_flow(state) && island.joints.empty() && !works_finely(state, island);
  const int first = in_large ? kFirstWaitInLarge : kFirstWait;
  memory.light_wait = std::min(first << memory.light_failures, kLongestWait);
  if (memory.light_wait < kLongestWait) ++memory.light_failures;
}

double work_for_heavy(const WorldState& state, const Island& island) {
  const std::vector<double>& mass = state.bodies.mass;
  double lightest = kInfinity;
  for (const std::uint32_t i : island.bodies) lightest = std::min(lightest, mass[i]);
  const auto bodies = static_cast<double>(island.bodies.size());
  const auto heavy = std::count_if(island.bodies.begin(), island.bodies.end(),
                                   [&](std::uint32_t i) { return mass[i] > kHeavy * lightest; });
  if (static_cast<double>(heavy) < kHeavyShare * bodies) return 0;
  return bodies > kMostHeavyBodies ? kFineWork : std::max(kHeavyWork, kHeavyWorkOfEach * bodies);
}

}  // namespace skerry
