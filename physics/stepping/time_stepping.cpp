// SPDX-License-Identifier: MIT
#include "physics/stepping/time_stepping.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "physics/narrowphase/chain.h"
#include "physics/spare.h"
#include "physics/stepping/applied_forces.h"
#include "physics/stepping/coming_to_rest.h"
#include "physics/stepping/flight_queue.h"
#include "physics/stepping/flow_work.h"
#include "physics/stepping/free_flight.h"
#include "physics/stepping/island_energy.h"
#include "physics/stepping/island_impact.h"
#include "physics/stepping/island_notes.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/joint_limits.h"
#include "physics/stepping/joint_midpoint.h"
#include "physics/stepping/joint_stability.h"
#include "physics/stepping/kinematic.h"
#include "physics/stepping/motion_breaks.h"
#include "physics/stepping/next_contact.h"
#include "physics/stepping/next_corner.h"
#include "physics/stepping/one_piece.h"
#include "physics/stepping/piece_forces.h"
#include "physics/stepping/point_memory.h"
#include "physics/stepping/projection.h"
#include "physics/stepping/snapping_joints.h"
#include "physics/stepping/step_doubling.h"
#include "physics/stepping/touching.h"
#include "physics/stepping/travel.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// What is deeper in others than this share of it was made there.
constexpr double kMadeInside = 0.01;
// Visits in vain after which what is squeezed flows, some 20 ms.
constexpr double kVainOfSqueezed = 2e6;
// Pieces of a step at most for stability: a load of 1e6 times the links' mass wants 130 at 1/60 s.
constexpr double kStablePieces = 256;
// Share of a piece that stepped over what is faster than it, with which it is made again.
constexpr double kSnapped = 0.25;
// A piece is solved again where its own forces want one of less than this share of it.
constexpr double kMuchShorter = 0.7;
// How often a piece that something ends is solved again for what is left of it, where joints act, and the
// share of it that is too little for them.
constexpr int kShorterPieces = 3;
constexpr double kTooShort = 1e-6;
// The same where it ends before this share, and a body that is no disc turns so far on its contacts [rad].
constexpr double kPart = 0.7, kFarTurn = 0.1;

// How often a landing on ground that moves as told is looked for, and what of the piece it may be off by
// then.
constexpr int kMostAims = 8;
constexpr double kAimed = 1e-13;

// Contact points, summed over the pieces of a step, after which landings are plastic; but so many pieces
// always.
constexpr int kPieceBudget = 512;
constexpr int kFewPieces = 4;
// Ends of sliding that cut a step; further ones are of first order.
constexpr int kMostStops = 4;
// Limits of joints that cut a step, of islands with so many joints; fewer of those with more. Then limits
// hold at the ends of pieces, which is of first order.
constexpr int kMostLimits = 8;
constexpr std::size_t kJointsWithLimits = 16;
// The same of corners that contact points pass, of islands with at most so many points.
constexpr int kMostCorners = 4, kPointsWithCorners = 8;
// A piece in which nothing rests needs no solve and costs this much less.
constexpr int kFlightShare = 32;
// Of what the exact forces of a large island may cost, for an impact of its own where they were not found
// together with it.
constexpr double kImpactWork = 0.2;

// Of what flow may cost, for a step of an island in which nothing moves and that cannot rest, either.
constexpr double kWorkAfterLook = 10;

// Contacts, or joints, and bodies that a thread takes at a time.
constexpr std::size_t kContactsAPiece = 512, kBodiesAPiece = 256;

/// What the pieces of a step need for a moment.
struct StepVectors {
  std::vector<Velocity> before, after;
  Assembly rows;
};

/// Whether what moves as told may squeeze an island without joints, which may flow instead.
bool may_be_squeezed(const WorldState& state, const Island& island) {
  return island.joints.empty() && flow_serves(state) && may_be_given_energy(state, island);
}

/// Whether exact answers for such an island are too much in vain to go on with: where it is wedged each piece
/// of a step has none.
bool is_squeezed_in_vain(const WorldState& state, const Island& island, const IslandResult& result) {
  return result.vain > kVainOfSqueezed && may_be_squeezed(state, island);
}

class IslandStep {
 public:
  /// @param rule  impacts of what is large are solved together with the forces of the rest of the step
  IslandStep(WorldState& state, const Island& island, const OnePieceRule& rule, IslandResult& result)
      : state_(state),
        island_(island),
        rule_(rule),
        result_(result),
        resting_(take_spare<std::vector<std::uint8_t>>()),
        varying_(has_varying_forces(state, island)),
        told_(meets_prescribed_motion(state, island)),
        snaps_(may_snap(state, island)),
        holds_(std::any_of(island.joints.begin(), island.joints.end(),
                           [&](std::uint32_t slot) {
                             const JointDef& def = state.joints[slot].def;
                             return holds_always(def) || def.stiffness > 0;
                           })),
        limits_(take_spare<std::vector<std::uint8_t>>()),
        limits_left_(most_limits(state, island)) {
    resting_.resize(island.contacts.size());
    limits_.resize(island.joints.size());
  }
  ~IslandStep() {
    // What makes the rest of the step, or all of it again, knows nothing of this piece.
    for (const std::uint32_t slot : island_.joints) state_.held_rows[slot] = 0;
    give_spare(std::move(resting_));
    give_spare(std::move(limits_));
  }
  IslandStep(const IslandStep&) = delete;
  IslandStep& operator=(const IslandStep&) = delete;

  /// Brings the island from one time of the step to another [s]. @return where it came to: it gives up where
  /// the forces cost more than they may (`IslandResult::work_limit`), where nothing is left to find them
  /// with, a large one finds no exact impact, or it was cut too often (`OnePieceRule::most_pieces`)
  /// @param ends, part_of  see `advance_island`
  double run(double from, double to, std::vector<double>* ends = nullptr, double part_of = 0) {
    elapsed_ = from;
    // A piece costs in proportion to the island, and much less where nothing rests, so busy islands get
    // fewer: a heap of 100 contacts is cut 5 times, a row of balls or a gas as often as its bounces want.
    int points = 0, spent = 0, flights = 0;
    for (const std::uint32_t index : island_.contacts) points += state_.contacts[index].manifold.count;
    anew_ = begins_span(state_, island_, from) ? from : -1;
    // The manifolds of the beginning are those by which the island was found.
    int piece = 1;
    // What was made in others is lifted out of them, in the first piece, at nobody's expense.
    bool deep = from == anew_ && island_.joints.empty() &&
                std::any_of(island_.contacts.begin(), island_.contacts.end(), [&](std::uint32_t k) {
                  return is_deep(state_, state_.contacts[k], kMadeInside);
                });
    Spare<StepVectors> vectors;
    std::vector<Velocity>&before = vectors->before, &after = vectors->after;
    double unsnapped = kInfinity;  // the length up to which pieces go well [s]
    while (elapsed_ < to) {
      if (ends && elapsed_ > from) ends->push_back(elapsed_);
      if (rule_.vain_limit > 0 && result_.vain > rule_.vain_limit) return elapsed_;
      if (is_squeezed_in_vain(state_, island_, result_)) return elapsed_;
      if (rule_.most_pieces > 0 && piece > rule_.most_pieces) return elapsed_;
      const bool out_of_work = is_spent(state_, result_);
      // A gas goes from impact to impact, and no impact costs a piece.
      if (flights < kMostFlights && !out_of_work) {
        const double there = fly_by_queue(state_, island_, elapsed_, to, false, result_);
        if (there > elapsed_) {
          ++flights;
          elapsed_ = there;
          continue;
        }
      }
      for (const std::uint32_t slot : island_.joints) note_stall(state_, state_.joints[slot], elapsed_);
      // Before anything is struck; else the first piece says so.
      if (elapsed_ == anew_ && !obeyed_ && !island_.joints.empty() && is_struck(state_, island_, anew_) &&
          joints_disobey(state_, island_, anew_))
        obey();
      // After too many cuts, or too much work, the rest of the step takes landings as plastic, at its end.
      const bool last = piece > state_.config.max_impacts_per_step ||
                        (piece > kFewPieces && spent >= kPieceBudget) || out_of_work;
      if (out_of_work) note_status(result_, SolveStatus::Inexact, 0);
      if (!last && rule_.large && is_struck(state_, island_, elapsed_)) {
        if (step_island_exactly(state_, island_, elapsed_, to, result_)) return to;
        apply_impact(state_, island_, elapsed_,
                     {.normal_acceleration = {}, .work_limit = kImpactWork * rule_.work_limit}, result_);
        return elapsed_;
      }
      if (last && end_in_one_piece(to)) return to;
      if (!last) {
        const double slow = slowest_bounce(state_, island_, to - from, piece);
        const ImpactOutcome impact =
            apply_impact(state_, island_, elapsed_,
                         {.normal_acceleration = {}, .work_limit = rule_.work_limit, .slow = slow}, result_);
        if (impact.spent && rule_.work_limit > 0) return elapsed_;
      }
      // Joints that shake light bodies, drag, and ground that shakes, get shorter pieces, which are not cuts.
      const double left = to - elapsed_;
      const double foreseen = told_ ? foreseeable_length(state_, island_, elapsed_, left) : left;
      const double slowed = varying_ ? stable_length_of_drag(state_, island_, elapsed_, left) : left;
      const double shortest = std::max(to - from, part_of) / kStablePieces;
      const double stable = std::max(
          std::min({stable_length(state_, island_, left), stable_length_of_springs(state_, island_),
                    stable_length_of_turns(state_, island_, to - from), foreseen, slowed, unsnapped}),
          shortest);
      bool whole = to - elapsed_ <= stable || out_of_work;
      double length = whole ? to - elapsed_ : (to - elapsed_) / std::ceil((to - elapsed_) / stable);
      const bool by_limits = limits_left_ > 0 && !last;
      const bool by_corners = points <= kPointsWithCorners && corners_left_ > 0 && !last;
      choose_resting(last);
      gaps_ = small_gaps(state_, island_, to - from, piece);
      choose_limits(by_limits);
      island_velocities(state_, island_, before);
      PieceForces forces;
      double solved = length, hit = length;
      bool lost = false, at_limit = false, at_corner = false;
      // Of a piece in which a spring swings to and fro there is no part that ends where sliding does.
      const bool may_stop = stops_ < kMostStops && !swings_fast(state_, island_, length);
      // Points that would go down from where they are join the solve; each round adds at least one.
      const auto solve = [&] {
        Piece part{elapsed_,
                   solved,
                   resting_,
                   last,
                   may_stop,
                   varying_,
                   told_,
                   by_limits ? &limits_ : nullptr,
                   elapsed_ == anew_ && !obeyed_};
        do {
          aim_ = solved;
          forces = solve_piece(state_, island_, part, before, after, result_);
          if (forces.disobeyed) return false;
          lost = !forces.given_up && are_lost(state_, island_, after);
          if (forces.given_up || lost) return false;
          hit = last ? solved : next_hit(solved, before, after);
          if (told_ && !last) hit = std::min(aimed_hit(solved, before, after, hit), forces.stop);
        } while (sinking_);
        at_limit = by_limits && next_limit(solved, before, after, hit);
        at_corner = by_corners && next_corner(solved, before, after, hit);
        at_limit &= !at_corner;
        return true;
      };
      if (!solve()) {
        if (!forces.disobeyed) return lost ? to : elapsed_;
        obey();
        continue;
      }
      // Forces that no solve knew before this one: of bodies that were at rest, of joints that are new.
      if (const double now = std::max(stable_once_moving(after, length), shortest);
          now < kMuchShorter * length && !out_of_work) {
        whole = false;
        length = (to - elapsed_) / std::ceil((to - elapsed_) / now);
        solved = hit = length;
        if (!solve()) {
          if (!forces.disobeyed) return lost ? to : elapsed_;
          obey();
          continue;
        }
      }
      // What joints that hold do on the whole of a piece says little of a part (in large worlds, where it has
      // a price, enough), and nothing where springs swing to and fro; nor what contacts do while a body turns
      // far, beyond a corner, or beyond a stop on ground that moves unevenly.
      const auto is_of_whole = [&] {
        return at_corner || (holds_ && is_small(state_, island_)) || swings_fast(state_, island_, solved) ||
               (told_ && forces.stop < solved) ||
               (varying_ && is_small(state_, island_) &&
                !field_swings_fast(state_, island_, elapsed_, solved, before, after)) ||
               (hit < kPart * solved && turns_far(solved, before, after));
      };
      for (int k = 0; k < kShorterPieces && hit < solved && is_of_whole(); ++k) {
        if (hit < kTooShort * length) break;
        solved = hit;
        if (!solve()) return lost ? to : elapsed_;
      }
      // The end of sliding is an end of the piece.
      if (forces.stop < solved && forces.stop <= hit) {
        hit = forces.stop;
        ++stops_;
        at_limit = at_corner = false;
      }
      limits_left_ -= at_limit;
      corners_left_ -= at_corner;
      note_held_rows(by_limits, hit == solved);
      // Further pieces would cost more than they may.
      const bool over = hit == length && whole;
      if (!over && result_.work_limit > 0 && result_.work.visits > result_.work_limit) return elapsed_;
      spent += forces.act ? points : points / kFlightShare;
      if (state_.observe.paths) remember_start(last, after);
      std::optional<SnapGuard> guard;
      if (snaps_ && !last && hit * kSnapped > shortest) guard.emplace(state_, island_, elapsed_);
      const double start = elapsed_, passed = passed_;
      const bool jointed = !island_.joints.empty();
      const bool pushed = !jointed && may_be_given_energy(state_, island_);
      std::optional<IslandEnergy> energy;
      if (last || jointed || pushed) energy.emplace(state_, island_, true, elapsed_ + 0.5 * hit);
      if (pushed) bound_what_is_pushed(*energy, hit, solved, before, after);
      advance(hit, solved, before, after, last);
      if (pushed && !last) energy->end_motion(state_, island_);
      elapsed_ = hit < length || !whole ? elapsed_ + hit : to;
      refresh_manifolds();
      {
        StageTimer timer(state_, result_, Stage::Apply);
        const std::optional<IslandEnergy> carried =
            forces.moving && !deep
                ? std::optional<IslandEnergy>(std::in_place, state_, island_, false, elapsed_)
                : std::nullopt;
        Assembly& rows = vectors->rows;
        deep = false;
        const bool hold = project_positions(state_, island_, elapsed_, result_, rows);
        VelocityShift shift;
        // Motors would pay for what joints take, beyond their largest force, or for ever: they come after it
        // was given back.
        const bool motors = forces.moving && has_motors(state_, island_);
        if (forces.moving)
          shift =
              project_velocities(state_, island_, elapsed_, solved, result_, hold ? &rows : nullptr, !motors);
        if (carried) carried->keep(state_, island_, shift.friction);
        if (motors && hold_passed_motors(state_, island_, elapsed_))
          project_velocities(state_, island_, elapsed_, solved, result_);
        // The plastic end of a step is of first order and lifts what it lets sink in.
        if (energy && last)
          energy->take_gain(state_, island_, hit);
        else if (pushed)
          energy->take_push(state_, island_, hit);
        // Joints that contradict each other may want any velocity.
        else if (energy)
          energy->take_much(state_, island_, hit, hit / solved * forces.brought, passed_);
      }
      if (guard && guard->snapped(state_, island_, elapsed_, to - from, *energy)) {
        guard->restore(state_, island_);
        if (ends && start > from) ends->pop_back();
        passed_ = passed;
        elapsed_ = start;
        unsnapped = kSnapped * hit;
        continue;
      }
      unsnapped *= 2;
      if (state_.observe.paths) record_hermite(state_, island_.bodies, start, hit, start_, result_);
      if (hit < length || whole) ++piece;
      ++result_.substeps;
    }
    return elapsed_;
  }

 private:
  /// The length up to which a piece is stable under the forces that were found for it [s]; infinity where
  /// nothing moves at its end either.
  double stable_once_moving(const std::vector<Velocity>& after, double length) const {
    const auto moves = [&](const Velocity& v) {
      return std::max({std::abs(v[0]), std::abs(v[1]), std::abs(v[2])}) > state_.config.rest_speed;
    };
    return !island_.joints.empty() && std::any_of(after.begin(), after.end(), moves)
               ? stable_length(state_, island_, length, true)
               : kInfinity;
  }

  /// The rest of a step that was cut too often, with landings plastic. @return false, and nothing has
  /// happened, where joints want a piece like the others, or what bounces well under forces that depend on
  /// the state
  bool end_in_one_piece(double to) {
    if (!island_.joints.empty() || state_.config.accuracy || (varying_ && rule_.bounces_well)) return false;
    if (step_island_exactly(state_, island_, elapsed_, to, result_)) return true;
    if (may_flow(state_)) step_island_in_flow(state_, island_, elapsed_, to, result_);
    return may_flow(state_);
  }

  /// Bounds the velocities with which a piece ends at `hit` of `length` [s]. Beyond that, as where sliding
  /// stops, they are nothing.
  void bound_what_is_pushed(const IslandEnergy& energy, double hit, double length,
                            const std::vector<Velocity>& before, std::vector<Velocity>& after) const {
    const double share = hit / length;
    Spare<std::vector<Velocity>> end, bounded;
    *end = before;
    for (std::size_t k = 0; k < before.size(); ++k)
      for (std::size_t c = 0; c < 3; ++c) (*end)[k][c] += share * (after[k][c] - before[k][c]);
    *bounded = *end;
    energy.bound(state_, island_, hit, *bounded);
    if (*bounded == *end || !(share > 0)) return;
    for (std::size_t k = 0; k < before.size(); ++k)
      for (std::size_t c = 0; c < 3; ++c)
        after[k][c] = before[k][c] + ((*bounded)[k][c] - before[k][c]) / share;
  }

  void obey() {
    obey_joints(state_, island_, elapsed_, passed_, result_);
    obeyed_ = true;
  }

  /// Where the path of a piece begins; the plastic end of a step moves with its final velocity throughout.
  void remember_start(bool plastic, const std::vector<Velocity>& after) {
    start_ = path_ends(state_, island_.bodies);
    for (std::size_t k = 0; plastic && k < start_.size(); ++k) start_[k].v = after[k];
  }

  void refresh_manifolds() {
    StageTimer timer(state_, result_, Stage::Narrow);
    result_.manifolds_reused += update_manifolds(state_, island_, elapsed_, result_.narrow);
  }

  /// Points that touch and do not separate take part in the force solve; in the plastic end of a step all
  /// near ones.
  void choose_resting(bool all_near) {
    share_each(state_.island_threads, resting_.size(), kContactsAPiece, [&](std::size_t k) {
      const Contact& contact = state_.contacts[island_.contacts[k]];
      resting_[k] = 0;
      for (int i = 0; i < contact.manifold.count; ++i) {
        const ManifoldPoint& point = contact.manifold.points[i];
        const bool rests =
            is_touching(state_, point) &&
            normal_velocity(state_, contact, point.position, elapsed_) <= state_.config.rest_speed;
        if (rests || (all_near && point.separation <= contact.margin)) resting_[k] |= 1u << i;
      }
    });
  }

  /// How many limits of joints may cut the step.
  static int most_limits(const WorldState& state, const Island& island) {
    if (!is_small(state, island)) return 0;
    const auto limited = [&](std::uint32_t slot) { return has_limits(state.joints[slot].def); };
    if (std::none_of(island.joints.begin(), island.joints.end(), limited)) return 0;
    return static_cast<int>(kMostLimits * kJointsWithLimits /
                            std::max(kJointsWithLimits, island.joints.size()));
  }

  /// Notes the limits and motors that hold what they are at in the piece that begins where the bodies are.
  /// @param by_limits  only limits that were reached, not any that carry  @param whole  it is not cut
  void note_held_rows(bool by_limits, bool whole) {
    const std::uint8_t any = most_limits(state_, island_) > 0 ? 0xff : 0;
    share_each(state_.island_threads, limits_.size(), kContactsAPiece, [&](std::size_t k) {
      const JointRecord& joint = state_.joints[island_.joints[k]];
      const std::uint8_t reached = by_limits ? limits_[k] : any;
      state_.held_rows[island_.joints[k]] = held_rows_of(state_, joint, elapsed_, reached, whole);
    });
  }

  void choose_limits(bool by_limits) {
    for (std::size_t k = 0; by_limits && k < limits_.size(); ++k)
      limits_[k] = reached_limits(state_, state_.joints[island_.joints[k]], elapsed_);
  }

  /// How a body goes through a piece of the length `h` [s].
  Motion motion_of(std::uint32_t body, double h, const std::vector<Velocity>& before,
                   const std::vector<Velocity>& after) const {
    Motion m = free_flight(state_, body, elapsed_);
    const int k = body == BodyId::kNone ? -1 : state_.local_index[body];
    if (k < 0) {
      if (!(aim_ > 0) || body == BodyId::kNone || !state_.prescribed[body]) return m;
      const KinematicState there = kinematic_state(state_, body, elapsed_ + aim_);
      m.v = (there.p - m.p0) / aim_ - (0.5 * aim_) * m.a;
      m.omega = (there.angle - m.angle0) / aim_ - 0.5 * aim_ * m.alpha;
      return m;
    }
    m.v = {before[k][0], before[k][1]};
    m.omega = before[k][2];
    m.a = Vec2{after[k][0] - before[k][0], after[k][1] - before[k][1]} / h;
    m.alpha = (after[k][2] - before[k][2]) / h;
    return m;
  }

  /// Cuts the piece at the first of `count` times, none of which is later than the time given to it.
  /// @return whether there is one before `hit`, which is that time then
  template <class TimeOf>
  bool cut_at_first(std::size_t count, double& hit, const TimeOf& time_of) {
    StageTimer timer(state_, result_, Stage::Narrow);
    const double before_it = hit;
    for (std::size_t k = 0; k < count; ++k) {
      const std::optional<double> t = time_of(k, hit);
      if (t) hit = std::min(hit, *t);
    }
    return hit < before_it;
  }

  /// True if a limit of a joint is reached before the time `hit` within the piece, which is that time then.
  bool next_limit(double h, const std::vector<Velocity>& before, const std::vector<Velocity>& after,
                  double& hit) {
    return cut_at_first(limits_.size(), hit, [&](std::size_t k, double until) {
      const JointRecord& joint = state_.joints[island_.joints[k]];
      return next_limit_time(state_, joint, motion_of(joint.def.a.index, h, before, after),
                             motion_of(joint.def.b.index, h, before, after), limits_[k], until);
    });
  }

  /// The same of a point that rests and passes a corner.
  bool next_corner(double h, const std::vector<Velocity>& before, const std::vector<Velocity>& after,
                   double& hit) {
    return cut_at_first(resting_.size(), hit, [&](std::size_t k, double until) -> std::optional<double> {
      const Contact& contact = state_.contacts[island_.contacts[k]];
      if (resting_[k] == 0) return std::nullopt;
      return next_corner_time(state_, contact, motion_of(contact.body_a, h, before, after),
                              motion_of(contact.body_b, h, before, after), resting_[k], until);
    });
  }

  /// Time until the next landing within the piece, or its length. Points that sink are made resting ones.
  double next_hit(double h, const std::vector<Velocity>& before, const std::vector<Velocity>& after) {
    StageTimer timer(state_, result_, Stage::Narrow);
    const auto motion = [&](std::uint32_t body) { return motion_of(body, h, before, after); };
    // Most contacts of a large island that rests are neither.
    Spare<std::vector<std::uint8_t>> may_land;
    may_land->resize(resting_.size());
    share_each(state_.island_threads, resting_.size(), kContactsAPiece, [&](std::size_t k) {
      const Contact& contact = state_.contacts[island_.contacts[k]];
      (*may_land)[k] = !rests_wholly(state_, contact, resting_[k]) &&
                       (moves(contact.body_a, before, after) || moves(contact.body_b, before, after));
    });
    double first = h;
    sinking_ = false;
    for (std::size_t k = 0; k < resting_.size(); ++k) {
      if ((*may_land)[k] == 0) continue;
      const std::uint32_t index = island_.contacts[k];
      const Contact& contact = state_.contacts[index];
      const NextContact next =
          next_contact_time(state_, index, motion(contact.body_a), motion(contact.body_b), resting_[k], first,
                            resting_[k] != 0 ? free_beside(k) : FreeSegments{}, gaps_);
      first = std::min(first, next.t);
      if (!next.sinks) continue;
      for (int i = 0; i < contact.manifold.count; ++i) {
        const std::uint8_t bit = 1u << i;
        if ((resting_[k] & bit) != 0 || !is_touching(state_, contact.manifold.points[i])) continue;
        resting_[k] |= bit;
        sinking_ = true;
      }
    }
    return first;
  }

  /// The same where ground moves as told: seen along parabolas that are right where they begin, and where it
  /// was found to land.
  double aimed_hit(double h, const std::vector<Velocity>& before, const std::vector<Velocity>& after,
                   double hit) {
    for (int k = 0; k < kMostAims && hit < h && !sinking_; ++k) {
      aim_ = hit;
      hit = next_hit(h, before, after);
      if (std::abs(hit - aim_) <= kAimed * h) break;
    }
    return hit;
  }

  /// Beside the segment of a contact, on which it rests.
  FreeSegments free_beside(std::size_t k) const {
    const Contact& contact = state_.contacts[island_.contacts[k]];
    const Shape &a = state_.shapes[contact.shape_a].shape, &b = state_.shapes[contact.shape_b].shape;
    const Shape& chain = a.kind == ShapeKind::Chain ? a : b;
    const int count = chain_segment_count(chain);
    if (count == 0) return {};
    const auto free = [&](int segment) {
      if (segment < 0 || segment >= count) {
        if (!chain.closed) return -1;
        segment = (segment + count) % count;
      }
      if (segment == contact.child) return -1;
      // Contacts of the same shapes stand together.
      const ContactKey key{contact.shape_a, contact.shape_b, segment};
      const auto before = [this](std::uint32_t i, const ContactKey& wanted) {
        return state_.contacts[i].key() < wanted;
      };
      const auto there = std::lower_bound(island_.contacts.begin(), island_.contacts.end(), key, before);
      if (there == island_.contacts.end() || state_.contacts[*there].key() != key) return segment;
      return resting_[static_cast<std::size_t>(there - island_.contacts.begin())] == 0 ? segment : -1;
    };
    return {free(contact.child - 1), free(contact.child + 1)};
  }

  /// True if a body turns so far in a time `h` [s] under a contact on which it rests that its corners go
  /// another way.
  bool turns_far(double h, const std::vector<Velocity>& before, const std::vector<Velocity>& after) const {
    const auto turns = [&](std::uint32_t body, std::uint32_t shape) {
      const int k = state_.local_index[body];
      return k >= 0 && h * std::max(std::abs(before[k][2]), std::abs(after[k][2])) > kFarTurn &&
             state_.shapes[shape].shape->kind != ShapeKind::Disc;
    };
    for (std::size_t k = 0; k < resting_.size(); ++k) {
      if (resting_[k] == 0) continue;
      const Contact& contact = state_.contacts[island_.contacts[k]];
      if (turns(contact.body_a, contact.shape_a) || turns(contact.body_b, contact.shape_b)) return true;
    }
    return false;
  }

  bool moves(std::uint32_t body, const std::vector<Velocity>& before,
             const std::vector<Velocity>& after) const {
    const int k = state_.local_index[body];
    if (k >= 0) return before[k] != Velocity{} || after[k] != Velocity{};
    return state_.bodies.type[body] == BodyType::Kinematic;
  }

  void advance(double t, double h, const std::vector<Velocity>& before, const std::vector<Velocity>& after,
               bool plastic) {
    StageTimer timer(state_, result_, Stage::Apply);
    const double part = t < h ? t / h : 1;
    double excess = 0;  // of angular momentum, of a piece that is cut
    share_each(part < 1 ? nullptr : state_.island_threads, before.size(), kBodiesAPiece, [&](std::size_t k) {
      const std::uint32_t body = island_.bodies[k];
      Velocity v = after[k];
      Velocity path = after[k];
      for (int c = 0; c < 3; ++c) {
        if (part < 1) v[c] = before[k][c] + part * (after[k][c] - before[k][c]);
        if (!plastic) path[c] = 0.5 * (before[k][c] + v[c]);
      }
      BodyArrays& all = state_.bodies;
      if (part < 1) {
        // The impulses act at the middle of the whole piece; where it is cut that is not the middle any more.
        const Vec2 v0{before[k][0], before[k][1]};
        const Vec2 push = Vec2{v[0], v[1]} - v0 - t * state_.acceleration[body];
        excess += 0.5 * (t - h) * all.mass[body] * cross(v0, push);
      }
      all.position[body] += t * Vec2{path[0], path[1]};
      if (path[2] != 0) {
        all.angle[body] += t * path[2];
        all.rotation[body] = Rot::from_angle(all.angle[body]);
      }
      all.velocity[body] = {v[0], v[1]};
      all.omega[body] = v[2];
      note_travel(state_, body, elapsed_, t, plastic ? path : before[k], v);
    });
    if (excess != 0 && is_free(state_, island_)) give_spin(state_, island_, -excess);
    share_each(state_.island_threads, island_.contacts.size(), kContactsAPiece, [&](std::size_t k) {
      Contact& contact = state_.contacts[island_.contacts[k]];
      for (PointMemory& memory : contact.points) {
        memory.total_normal += part * memory.normal_impulse;
        memory.total_friction += part * memory.friction_impulse;
        contact.impulse += part * push_on_b(memory, memory.normal);
      }
    });
    share_each(state_.island_threads, island_.joints.size(), kContactsAPiece, [&](std::size_t k) {
      JointRecord& joint = state_.joints[island_.joints[k]];
      for (int row = 0; row < kMaxJointRows; ++row) joint.row_impulse[row] += t * joint.row_force[row];
    });
  }

  WorldState& state_;
  const Island& island_;
  OnePieceRule rule_;
  IslandResult& result_;
  std::vector<std::uint8_t> resting_;  ///< per contact of the island: bits of the points in the force solve
  bool varying_;                       ///< forces depend on the state
  bool told_;                          ///< something here moves as prescribed
  bool snaps_;                         ///< its joints may snap straight
  bool holds_;                         ///< a joint of the island acts wherever its bodies are
  std::vector<std::uint8_t> limits_;   ///< per joint of the island: bits of the limits in the force solve
  int limits_left_;                    ///< that may cut the step
  int corners_left_ = kMostCorners;    ///< that may cut the step
  int stops_ = 0;                      ///< of the step
  bool obeyed_ = false;                ///< joints were asked to hold at the beginning of the step
  double passed_ = 0;                  ///< energy that nothing explains, in the step so far [J]
  double elapsed_ = 0;                 ///< since the beginning of the step [s]
  double anew_ = 0;                    ///< where velocities may be other ones than joints allow; -1: nowhere
  double aim_ = 0;                     ///< when ground is where it is told to be, within the piece [s]
  SmallGaps gaps_;                     ///< of the piece
  bool sinking_ = false;               ///< `next_hit` found points that the solve has to hold
  std::vector<PathEnd> start_;         ///< of the piece, for the paths
};

}  // namespace

void step_island_by_time_stepping(WorldState& state, const Island& island, double h, IslandResult& result) {
  if (fly_freely(state, island, h, result)) return;
  result.report.stepper = "time_stepping";
  if (state.config.accuracy) return step_with_error_control(state, island, h, *state.config.accuracy, result);
  for (const std::uint32_t i : island.bodies) {
    const StepMemory& last = state.step_memory[i];
    result.step_memory.light_failures = std::max(result.step_memory.light_failures, last.light_failures);
    result.step_memory.light_wait = std::max(result.step_memory.light_wait, last.light_wait);
    result.step_memory.near_rest = std::max(result.step_memory.near_rest, last.near_rest);
  }
  if (is_held(state, island) && come_to_rest(state, island, h, result) == RestLook::Rests) return;
  const OnePieceRule rule = one_piece_rule(state, island, h);
  result.bounces_well = rule.bounces_well;
  if (step_over_breaks(state, island, rule, h, result)) return;
  // Exact forces of what hangs together, or is large, cost most where they are not found.
  const bool dear = rule.large || !island.joints.empty();
  const bool waits = result.step_memory.light_wait > 0 &&
                     (dear ? rule.work_limit > 0 || rule.vain_limit > 0 : may_be_squeezed(state, island));
  if (rule.light && step_island_lightly(state, island, h, result)) return;
  if (waits && !rule.light) --result.step_memory.light_wait;
  const bool flows = rule.flows || waits || (rule.light && rule.large);
  if (flows) {
    const RestLook look = come_to_rest(state, island, h, result);
    // What nearly rests is pushed on by what sweeps leave: better forces now and then end that.
    const double more = look == RestLook::Vain ? kWorkAfterLook : 1;
    if (look != RestLook::Rests) step_island_in_flow(state, island, 0, h, result, more);
    return;
  }
  // What a vain attempt took does not count.
  if (rule.work_limit > 0) result.work_limit = rule.work_limit + result.work.visits;
  const double there = advance_island(state, island, rule, 0, h, result);
  // What bounces well is cut often, and goes on exactly.
  const int cut = rule.bounces_well ? 0 : restlessness(result);
  result.step_memory.flow = std::max(cut, result.report.flowing ? 1 : 0);
  if (there < h) step_island_in_flow(state, island, there, h, result);
  if (!result.report.flowing) result.step_memory.near_rest = 0;
  if (result.report.flowing && (dear || is_squeezed_in_vain(state, island, result)))
    wait_after_failure(state, island, result.step_memory);
}

double advance_island(WorldState& state, const Island& island, const OnePieceRule& rule, double from,
                      double to, IslandResult& result, std::vector<double>* ends, double part_of) {
  const double there = IslandStep(state, island, rule, result).run(from, to, ends, part_of);
  if (ends && (ends->empty() || ends->back() < to)) ends->push_back(to);
  return there;
}

}  // namespace skerry
