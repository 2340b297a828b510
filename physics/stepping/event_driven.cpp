// SPDX-License-Identifier: MIT
#include "physics/stepping/event_driven.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "physics/joint_rows.h"
#include "physics/solver/contact_states.h"
#include "physics/spare.h"
#include "physics/stepping/flight_queue.h"
#include "physics/stepping/flow_work.h"
#include "physics/stepping/island_backup.h"
#include "physics/stepping/island_energy.h"
#include "physics/stepping/island_impact.h"
#include "physics/stepping/island_notes.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/joint_limits.h"
#include "physics/stepping/mode_choice.h"
#include "physics/stepping/mode_events.h"
#include "physics/stepping/mode_impulses.h"
#include "physics/stepping/motion_breaks.h"
#include "physics/stepping/one_piece_joints.h"
#include "physics/stepping/one_piece_rule.h"
#include "physics/stepping/projection.h"
#include "physics/stepping/runge_kutta.h"
#include "physics/stepping/time_stepping.h"
#include "physics/stepping/touching.h"
#include "physics/stepping/travel.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

using State = AccelerationProblem::State;

// More changes of the contact mode than this in a step are a case for time stepping.
constexpr int kMaxEvents = 16;
// Islands of no more bodies are stepped alike in worlds of any size.
constexpr std::size_t kFewBodies = 30;
// Local error of an inner step when no accuracy was asked for.
constexpr double kFinest = 1e-13;
// Forces that contacts share in nearly any way are found to 1e-11 or so only; then errors fall with the step,
// not with its eighth power, and what is as small as that needs no shorter ones: the error that is allowed
// where steps of a quarter have not had a sixteenth of it, over the usual one.
constexpr double kRough = 100, kTold = 4;
// Work of the force solves and landings of a step (see AccelerationProblem::work), and more for longer steps:
// what costs more than about 0.2 s is for time stepping.
constexpr double kMaxWork = 4e5, kMaxWorkPerSecond = 4e6;
// Share of the limit of the configuration after which the rest of it is for time stepping, and visits that a
// unit of the work above counts for there.
constexpr double kWorkShare = 0.5, kVisitsAUnit = 10;
// Inner steps: more mean that the accuracy cannot be had.
constexpr int kMaxInnerSteps = 4000;
// A mode in which this many were tried has found its pace, if steps do not get longer any more: where the
// rest of the step takes twice the steps or the work that there may be, its forces are too rough to follow
// (contacts that share them in many ways). That is told then, and after twice as many, not when all of it is
// spent.
constexpr int kPaceIsFound = 48;
constexpr double kTooSlow = 2;
// Quantities below this [m, m/s, rad, rad/s] are accurate absolutely, not relatively.
constexpr double kUnit = 1;
// Joints that are off by less of the smaller body's size are where they belong.
constexpr double kJoined = 1e-8;
// A trial that comes beyond this has diverged, and forces there say nothing.
constexpr double kFarthest = 1e100;
// Share of a step that is no time.
constexpr double kNothingLeft = 1e-14;
// Share of a step after which it shows what takes over a load, and the speed below which a point rests [m/s].
constexpr double kAhead = 1e-4, kRests = 1e-8;

bool is_wild(const State& state) {
  return std::any_of(state.begin(), state.end(), [](double y) { return !(std::abs(y) < kFarthest); });
}

/// Tells rough forces from motions that are too fast for a step, by what shorter steps gain.
class Roughness {
 public:
  /// To be asked where a step was not good enough.
  /// @param error  over the one that is allowed
  bool is_found(double length, double error) {
    if (length_ == 0) {
      length_ = length;
      error_ = error;
    }
    const double shorter = length_ / length;
    return shorter >= kTold && error <= kRough && error_ < shorter * shorter * error;
  }
  void forget() { length_ = 0; }

 private:
  double length_ = 0, error_ = 0;  // of the longest step from here
};

/// How fast error control comes on in a mode. Looks after 24 tries, and whenever they have doubled.
class InnerPace {
 public:
  /// @param work, most  work of the step so far, and what it may have
  InnerPace(double begin, double work, double most) : begin_(begin), work_(work), most_(most) {}

  void took(double length) { longest_ = std::max(longest_, length); }

  /// To be asked at each try.
  bool is_too_slow(double time, double left, double length, double work) {
    if (++tried_ <= look_) return false;
    // At the pace of now, or that since the last look, whichever is the better one. Where forces grow beyond
    // all bounds (a jam [Champneys & Varkonyi 2016]) steps shrink towards the time at which they would.
    const int tried = tried_ - looked_;
    const double ahead = left / std::max(length, (time - begin_) / tried);
    const bool slow = ahead > kTooSlow * kMaxInnerSteps || ahead * (work - work_) > kTooSlow * most_ * tried;
    const bool steady = tried_ > kPaceIsFound && longest_ < 2 * longest_before_;
    longest_before_ = std::exchange(longest_, 0);
    begin_ = time;
    work_ = work;
    looked_ = tried_;
    look_ *= 2;
    return slow && steady;
  }

 private:
  double begin_, work_, most_;  // time and work at the last look
  int tried_ = 0, looked_ = 0, look_ = kPaceIsFound / 2;
  double longest_ = 0, longest_before_ = kInfinity;  // of the steps since the last look, and before it
};

class EventStep {
 public:
  EventStep(WorldState& state, const Island& island, double h, IslandResult& result)
      : state_(state),
        island_(island),
        h_(h),
        limit_(state.config.solve.work_limit > 0 ? kWorkShare * state.config.solve.work_limit : kInfinity),
        result_(result),
        problem_(state, island, result),
        events_(state, island, problem_, mode_),
        spans_(smooth_spans(state, island, h)) {
    // Fields, drag and prescribed motions bend the paths of flight.
    parabolic_ = !has_varying_forces(state, island) && !meets_prescribed_motion(state, island);
    // Smooth motion goes on with the steps that served it last.
    for (const std::uint32_t i : island.bodies) {
      const double last = state.step_memory[i].inner_step;
      if (last > 0) inner_step_ = inner_step_ > 0 ? std::min(inner_step_, last) : last;
    }
  }

  ~EventStep() {
    // Who comes next knows nothing of this mode.
    for (const std::uint32_t slot : island_.joints) state_.held_rows[slot] = 0;
  }
  EventStep(const EventStep&) = delete;
  EventStep& operator=(const EventStep&) = delete;

  /// @param most_events  impacts and changes of the mode together
  /// @return false if the step has to be made in another way
  bool run(int most_events) {
    // As many impacts as time_stepping would carry out one by one.
    int points = 0;
    for (const std::uint32_t index : island_.contacts) points += state_.contacts[index].manifold.count;
    const int cuts = std::min(state_.config.max_impacts_per_step, std::max(4, 512 / std::max(points, 1)));
    obey();
    while (elapsed_ < h_) {
      if (result_.work.visits + result_.thrown_away.visits > limit_) return false;
      if (elapsed_ == until()) pass_break();
      if (!keep_mode_) {
        const double ahead = std::exchange(ahead_, 0);
        if (fly_in_turn()) continue;
        if (!impacts()) return false;
        if (!choose_mode(state_, island_, problem_, elapsed_, onsets_, ahead, mode_, forces_)) return false;
        onsets_.clear();
        forces_known_ = !mode_.free();
        if (rest()) return true;
      }
      keep_mode_ = false;
      if (!(mode_.free() && parabolic_ ? fly_on() : integrate())) return false;
      ++result_.substeps;
      // Pieces that end without an event that counts must not go on for ever either.
      const int struck = result_.impacts - queued_impacts_;
      if (changes_ > kMaxEvents || struck > cuts || result_.substeps > kMaxEvents + 2 * cuts ||
          changes_ + struck > most_events)
        return false;
    }
    result_.step_memory.inner_step = inner_step_;
    return true;
  }

 private:
  const Contact& contact_at(std::size_t k) const { return state_.contacts[island_.contacts[k]]; }

  /// The time after `length` [s] more. What is left by rounding is nothing to step through: an event there is
  /// one of the beginning of the next step.
  double sum_of_times(double length) const {
    const double then = elapsed_ + length;
    return until() - then > kNothingLeft * h_ ? then : until();
  }

  /// The end of the step, or the next break of a prescribed motion.
  double until() const { return spans_.empty() ? h_ : spans_[span_].to; }

  /// Goes on behind it.
  void pass_break() {
    elapsed_ = spans_[++span_].from;
    keep_mode_ = false;
    begin_span(state_, island_, spans_[span_], result_);
    obey();
  }

  /// What was set going, or its ground, may move as joints do not allow.
  void obey() {
    if (!joints_disobey(state_, island_, elapsed_)) return;
    double passed = 0;
    obey_joints(state_, island_, elapsed_, passed, result_);
  }

  double external_bound() const {
    double fastest = 0;
    for (const std::uint32_t i : island_.bodies) {
      fastest = std::max(fastest, length(state_.acceleration[i]) +
                                      std::abs(state_.angular_acceleration[i]) * state_.radius[i]);
    }
    return fastest;
  }

  void note(MotionEventKind kind, double time, BodyId a, BodyId b) {
    if (kind != MotionEventKind::Settle) ++result_.events_found;
    result_.motion_events.push_back({kind, time, a, b});
  }
  void note(MotionEventKind kind, double time, const Contact& contact) {
    note(kind, time, state_.shapes[contact.shape_a].body, state_.shapes[contact.shape_b].body);
  }

  bool impacts() {
    for (const std::uint32_t slot : island_.joints) note_stall(state_, state_.joints[slot], elapsed_);
    mode_ = {};
    const State y = problem_.gather(mode_);
    ImpactOptions options;
    options.normal_acceleration = [&](std::uint32_t index, int i) {
      return free_gap_acceleration(state_, problem_, state_.contacts[index], i, elapsed_, y);
    };
    const ImpactOutcome outcome = apply_impact(state_, island_, elapsed_, options, result_);
    for (const SettledContact& settled : outcome.settled)
      note(MotionEventKind::Settle, elapsed_ + settled.rest, state_.contacts[settled.contact]);
    return result_.report.status == SolveStatus::Solved;
  }

  /// Whether the user put something into a body, or away from a joint: the end of a step takes that out.
  bool is_out_of_place() const {
    return std::any_of(island_.contacts.begin(), island_.contacts.end(),
                       [&](std::uint32_t i) { return overlaps(state_, state_.contacts[i]); }) ||
           joints_are_off(state_, island_, elapsed_, kJoined);
  }

  /// The forces of the mode as the answer to a contact problem, for an observer.
  void keep_equations(const State& y) {
    if (!state_.observe.systems) return;
    IslandSystem system;
    Solution solution;
    problem_.equations(mode_, elapsed_, y, forces_, h_, system, solution.lambda);
    if (system.rows.empty()) return;
    conclude(system, state_.config.solve, solution);
    keep_trace(state_, island_, elapsed_, std::move(system), std::move(solution.lambda), solution.status,
               result_.report.method, solution.residual, false, nullptr, result_);
  }

  /// Nothing moves and nothing will: the rest of the step is known.
  bool rest() {
    // Drag is nothing where nothing moves.
    if (mode_.free() || state_.field || meets_prescribed_motion(state_, island_)) return false;
    const double g = external_bound();
    if (speed_bound(state_, island_) > 1e-11 * h_ * g || is_out_of_place()) return false;
    const double nothing = std::max(1e-10 * g, rounding_of_balance(state_, island_, forces_.scale));
    for (std::size_t k = 0; k < island_.bodies.size(); ++k) {
      const std::array<double, 3>& a = forces_.acceleration[k];
      const double turn = std::abs(a[2]) * state_.radius[island_.bodies[k]];
      if (std::max({std::abs(a[0]), std::abs(a[1]), turn}) > nothing) return false;
    }
    if (meets_motion(state_, island_)) return false;
    store_velocities(state_, island_, std::vector<Velocity>(island_.bodies.size(), Velocity{}));
    // What came to rest on its way strays from that from now on.
    for (const std::uint32_t i : island_.bodies) note_travel(state_, i, elapsed_, h_ - elapsed_, {}, {});
    if (state_.observe.paths)
      record_hermite(state_, island_.bodies, elapsed_, h_ - elapsed_, path_ends(state_, island_.bodies),
                     result_);
    State y = problem_.gather(mode_);
    const State none = y;
    State dy;
    keep_equations(y);
    problem_.derivative(y, forces_, dy);
    for (std::size_t i = 6 * island_.bodies.size(); i < y.size(); ++i) y[i] = (h_ - elapsed_) * dy[i];
    add_pushes(state_, island_, mode_, none, y, forces_, forces_, h_ - elapsed_);
    store_forces(state_, island_, h_, mode_, forces_, y);
    ++result_.substeps;
    return true;
  }

  // --- Flight
  // ---------------------------------------------------------------------------------------------------------

  /// Follows a gas from impact to impact, which are no events that anybody else has to wait for.
  bool fly_in_turn() {
    if (flights_ == kMostFlights) return false;
    const int before = result_.impacts;
    const double there = fly_by_queue(state_, island_, elapsed_, h_, true, result_);
    if (!(there > elapsed_)) return false;
    queued_impacts_ += result_.impacts - before;
    ++flights_;
    elapsed_ = there;
    return true;
  }

  bool fly_on() {
    const double left = h_ - elapsed_;
    const FlightEnd end = events_.end_of_flight(elapsed_, left);
    const double first = end.length;
    std::vector<PathEnd> start;
    if (state_.observe.paths) start = path_ends(state_, island_.bodies);
    for (const std::uint32_t body : island_.bodies) skerry::fly(state_, body, elapsed_, first);
    if (state_.observe.paths) record_hermite(state_, island_.bodies, elapsed_, first, start, result_);
    clear_forces(state_, island_, h_);
    elapsed_ = sum_of_times(first);
    result_.manifolds_reused += update_manifolds(state_, island_, elapsed_, result_.narrow);
    if (is_out_of_place()) arrive();
    if (end.limit != nullptr)
      note(MotionEventKind::Limit, elapsed_, end.limit->def.a, end.limit->def.b);
    else if (end.landing != nullptr)
      note(MotionEventKind::Landing, elapsed_, *end.landing);
    // A landing that changes nothing is an event all the same: too many of them must not go on for ever.
    if ((end.limit != nullptr || end.landing != nullptr) && first < 1e-12 * h_) ++changes_;
    return true;
  }

  // --- Constrained motion
  // ---------------------------------------------------------------------------------------------------------

  bool integrate() {
    State y = problem_.gather(mode_), dy, at_event;
    if (!forces_known_ && !problem_.evaluate(mode_, elapsed_, y, forces_)) return false;
    forces_known_ = false;
    keep_equations(y);
    problem_.derivative(y, forces_, dy);
    ModeForces latest, end;
    const std::vector<ModeWatch> watched = events_.watches(forces_);
    StageValues stages;
    RungeKutta method(
        [&](double t, const State& state, State& out) {
          if (is_wild(state) || !problem_.evaluate(mode_, t, state, latest)) return false;
          problem_.derivative(state, latest, out);
          events_.note_stage(t, watched, latest, stages);
          return true;
        },
        static_cast<int>(6 * island_.bodies.size()));
    if (!(inner_step_ > 0)) inner_step_ = 0.2 / rate();
    double accuracy = state_.config.accuracy.value_or(kFinest);
    bool may_be_rough = !state_.config.accuracy;
    Roughness roughness;
    const double most_work = std::min(kMaxWork + h_ * kMaxWorkPerSecond, limit_ / kVisitsAUnit);
    InnerPace pace(elapsed_, work(), most_work);

    for (;;) {
      const double left = until() - elapsed_;
      const double length = std::min(inner_step_, left);
      if (++inner_steps_ > kMaxInnerSteps || !(length > kNothingLeft * h_)) return false;
      const double spent = work();
      if (spent > most_work) return false;
      if (pace.is_too_slow(elapsed_, left, length, spent)) return false;
      // What is asked for is the error of a second of motion.
      const double allowed = state_.config.accuracy ? std::max(accuracy * length, kFinest) : accuracy;
      stages.begin(elapsed_, length);
      const double error = method.attempt(elapsed_, y, dy, length, allowed, kUnit);
      stages.end();
      if (!(error <= 1)) {
        ++result_.rejected_steps;
        if (may_be_rough && roughness.is_found(length, error)) {
          accuracy *= kRough;
          may_be_rough = false;
          inner_step_ = length;
          continue;
        }
        inner_step_ = length * std::min(step_factor(error), 0.9);
        continue;
      }
      roughness.forget();
      // The continuous output asks for more forces.
      std::swap(end, latest);
      ModeEvent event;
      if (!events_.find(method, watched, elapsed_, forces_, end, stages, event)) return false;
      if (state_.observe.paths && !record_path(method)) return false;
      ++result_.inner_steps;
      if (state_.config.accuracy) result_.report.error_estimate += error * allowed;
      if (event.found) {
        method.at(event.theta, at_event);
        travel(event.theta * length, method.end());
        elapsed_ = sum_of_times(event.theta * length);
        problem_.scatter(at_event, state_);
        std::swap(forces_, end);
        if (!problem_.evaluate(mode_, elapsed_, at_event, forces_)) return false;
        add_pushes(state_, island_, mode_, y, at_event, end, forces_, event.theta * length);
        change_mode(event, watched);
        store_forces(state_, island_, h_, mode_, forces_, at_event);
        arrive();
        pass_load_on(event.watch);
        ++changes_;
        return true;
      }
      travel(length, method.end());
      add_pushes(state_, island_, mode_, y, method.end(), forces_, end, length);
      y = method.end();
      dy = method.end_derivative();
      std::swap(forces_, end);
      problem_.scatter(y, state_);
      elapsed_ = sum_of_times(length);
      pace.took(length);
      const double factor = step_factor(error);
      if (length == inner_step_ || factor < 1) inner_step_ = length * factor;
      if (elapsed_ < until()) {
        // Landings are looked for from the manifolds of where the inner step begins.
        result_.manifolds_reused += update_manifolds(state_, island_, elapsed_, result_.narrow);
        continue;
      }
      store_forces(state_, island_, h_, mode_, forces_, y);
      arrive();
      return true;
    }
  }

  /// That of the step so far, in units of `AccelerationProblem::work`.
  double work() const { return problem_.work() + events_.work() - path_work_; }

  /// The continuous output of the inner step that was tried last; an event may end it early.
  bool record_path(RungeKutta& method) {
    // Who looks must not change what is done, and so what it costs does not count.
    const double work = problem_.work();
    if (!method.prepare_dense()) return false;
    path_work_ += problem_.work() - work;
    for (std::size_t k = 0; k < island_.bodies.size(); ++k) {
      PathPiece piece;
      piece.body = island_.bodies[k];
      piece.generation = state_.bodies.generation[piece.body];
      piece.begin = method.begin();
      piece.length = method.length();
      for (std::size_t c = 0; c < 3; ++c) piece.c[c] = method.coefficients(6 * k + c);
      result_.path.push_back(piece);
    }
    return true;
  }

  /// A frequency that the motion has [1/s], for the first inner step.
  double rate() const {
    double largest = 1e-3 / h_;
    for (std::size_t k = 0; k < island_.bodies.size(); ++k) {
      const std::uint32_t i = island_.bodies[k];
      const std::array<double, 3>& a = forces_.acceleration[k];
      const double size = std::max(state_.radius[i], 1e-3);
      largest = std::max({largest, std::abs(state_.bodies.omega[i]), std::sqrt(std::abs(a[2])),
                          length(state_.bodies.velocity[i]) / (10 * size),
                          std::sqrt(std::hypot(a[0], a[1]) / (10 * size))});
    }
    return largest;
  }

  /// Applies what the event says where the forces go on smoothly; otherwise the mode is chosen anew.
  void change_mode(const ModeEvent& event, const std::vector<ModeWatch>& watched) {
    note_event(event.watch);
    if (event.watch.kind != MotionEventKind::Release && event.watch.kind != MotionEventKind::Slip) return;
    keep_mode_ = true;
    const double zero = 1e-11 * forces_.scale;
    for (const ModeWatch& watch : watched) {
      const bool same = watch.kind == event.watch.kind && watch.index == event.watch.index;
      const bool smooth = watch.kind == MotionEventKind::Release || watch.kind == MotionEventKind::Slip;
      if (!same && !(smooth && events_.value(watch, forces_) <= zero)) continue;
      if (!same) note_event(watch);
      if (watch.kind == MotionEventKind::Release) mode_.points[watch.index].closed = false;
      if (watch.kind != MotionEventKind::Slip) continue;
      Grip& grip = mode_.grips[watch.index];
      grip.sign = forces_.grip_force[watch.index] > 0 ? -1 : 1;
      // Static friction lets go: the force jumps, and everything else is to be decided anew.
      if (!(grip.hold > grip.mu)) continue;
      // Where others hold the bodies all the same it does not slide, and goes on with what it held.
      if (others_hold(watch.index)) {
        grip.mu = grip.hold;
        continue;
      }
      onsets_.push_back({grip.contact, grip.rolling, grip.sign});
      keep_mode_ = false;
    }
  }

  /// A point that was left open where others carried its share, as at the next tile of a floor, may carry
  /// from now on what the one that was released carried.
  void pass_load_on(const ModeWatch& watch) {
    if (!keep_mode_ || watch.kind != MotionEventKind::Release) return;
    const ModePoint& released = mode_.points[watch.index];
    const auto rests_beside = [&](std::size_t k, const ManifoldPoint& point) {
      const bool known = std::any_of(mode_.points.begin(), mode_.points.end(), [&](const ModePoint& p) {
        return p.contact == k && p.feature == point.feature && (p.closed || &p == &released);
      });
      return !known && is_touching(state_, point) &&
             std::abs(normal_velocity(state_, contact_at(k), point.position, elapsed_)) < kRests;
    };
    for (std::size_t k = 0; k < island_.contacts.size(); ++k) {
      const Manifold& manifold = contact_at(k).manifold;
      if (std::none_of(manifold.points.begin(), manifold.points.begin() + manifold.count,
                       [&](const ManifoldPoint& point) { return rests_beside(k, point); }))
        continue;
      keep_mode_ = false;
      ahead_ = kAhead * h_;
      return;
    }
  }

  /// True if the motion does not depend on how much a grip carries that has reached its bound.
  bool others_hold(std::size_t k) const {
    constexpr double kLess = 0.9, kNothing = 1e-9;
    const State y = problem_.gather(mode_);
    ContactMode trial = mode_;
    ModeForces all, less;
    trial.grips[k].mu = mode_.grips[k].hold;
    if (!problem_.evaluate(trial, elapsed_, y, all)) return false;
    trial.grips[k].mu = kLess * mode_.grips[k].hold;
    if (!problem_.evaluate(trial, elapsed_, y, less)) return false;
    double change = 0, largest = 0;
    for (std::size_t i = 0; i < all.acceleration.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) {
        change = std::max(change, std::abs(all.acceleration[i][c] - less.acceleration[i][c]));
        largest = std::max(largest, std::abs(all.acceleration[i][c]));
      }
    }
    return change <= kNothing * (external_bound() + largest);
  }

  void note_event(const ModeWatch& watch) {
    switch (watch.kind) {
      case MotionEventKind::Release:
      case MotionEventKind::Feature:
        return note(watch.kind, elapsed_, contact_at(mode_.points[watch.index].contact));
      case MotionEventKind::Slip:
      case MotionEventKind::Stick:
        return note(watch.kind, elapsed_, contact_at(mode_.grips[watch.index].contact));
      case MotionEventKind::Landing:
        return note(watch.kind, elapsed_, contact_at(watch.index));
      default: {
        const ModeRow& row = mode_.rows[watch.index];
        const JointRecord& joint = state_.joints[island_.joints[row.joint]];
        const bool released = watch.kind == MotionEventKind::Limit && row.state == JointRowState::Holds;
        note(released ? MotionEventKind::Release : watch.kind, elapsed_, joint.def.a, joint.def.b);
      }
    }
  }

  /// Bounds how far the bodies went in `t`. @param end  state at the end of the inner step
  void travel(double t, const State& end) {
    for (std::size_t k = 0; k < island_.bodies.size(); ++k) {
      const std::uint32_t i = island_.bodies[k];
      const double* q = end.data() + 6 * k;
      const std::array<double, 3>& a = forces_.acceleration[k];
      const Velocity before{state_.bodies.velocity[i].x, state_.bodies.velocity[i].y, state_.bodies.omega[i]};
      note_travel(state_, i, elapsed_, t, before, {q[3], q[4], q[5]});
      const double bend = 0.25 * t * t * (std::hypot(a[0], a[1]) + std::abs(a[2]) * state_.radius[i]);
      state_.travelled[i] += bend;
      state_.strayed[i] += bend;
    }
  }

  /// Limits that carry hold both ways: the speed that integration leaves there must not let go of them.
  void note_held_limits() {
    for (const std::uint32_t slot : island_.joints) state_.held_rows[slot] = 0;
    if (mode_.free()) return;
    for (std::size_t i = 0; i < mode_.rows.size(); ++i) {
      const ModeRow& row = mode_.rows[i];
      if (row.kind == JointRowKind::Limit && row.state == JointRowState::Holds && forces_.row_force[i] > 0)
        state_.held_rows[island_.joints[row.joint]] |= static_cast<std::uint8_t>(1u << row.row);
    }
  }

  /// Brings manifolds to the new poses and takes out what the integration left of drift.
  void arrive() {
    note_held_limits();
    result_.manifolds_reused += update_manifolds(state_, island_, elapsed_, result_.narrow);
    Spare<Assembly> rows;
    const bool hold = project_positions(state_, island_, elapsed_, result_, *rows);
    project_velocities(state_, island_, elapsed_, 0, result_, hold ? &*rows : nullptr);
    if (state_.observe.paths) end_paths_here(state_, island_.bodies, elapsed_, result_);
  }

  WorldState& state_;
  const Island& island_;
  const double h_;
  const double limit_;  ///< in visits
  IslandResult& result_;
  AccelerationProblem problem_;
  ContactMode mode_;
  ModeEvents events_;
  ModeForces forces_;  ///< at the beginning of the inner step
  std::vector<SmoothSpan> spans_;
  std::size_t span_ = 0;       ///< the one of now
  std::vector<Onset> onsets_;  ///< since the mode was chosen last
  bool keep_mode_ = false;
  bool parabolic_ = true;      ///< free flight has constant acceleration
  bool forces_known_ = false;  ///< `forces_` are those of the mode and the present state
  double elapsed_ = 0;         ///< since the beginning of the step [s]
  double inner_step_ = 0;      ///< that error control wants next, 0: not known yet [s]
  double ahead_ = 0;           ///< by which the next mode is decided later [s]
  double path_work_ = 0;       ///< for the paths alone
  int inner_steps_ = 0;
  int changes_ = 0;         ///< of the mode
  int flights_ = 0;         ///< of the whole island by a queue of impacts
  int queued_impacts_ = 0;  ///< that those carried out
};

}  // namespace

namespace {

void step_by_events_or_time(WorldState& state, const Island& island, double h, IslandResult& result) {
  // What tumbles on as in the last step has more events than a step may have.
  if (flows_on(state, island, h))
    result.fallbacks = 1;
  else if (try_island_by_events(state, island, h, std::numeric_limits<int>::max(), result))
    return;
  step_island_by_time_stepping(state, island, h, result);
}

}  // namespace

void step_island_by_events(WorldState& state, const Island& island, double h, IslandResult& result) {
  if (is_small(state, island) || island.bodies.size() > kFewBodies) {
    step_by_events_or_time(state, island, h, result);
    return;
  }
  // Its events have been paid for, and what is left of a small scene is no work to be shared by all.
  Spare<Island> alone;
  *alone = island;
  alone->alone = true;
  step_by_events_or_time(state, *alone, h, result);
}

bool try_island_by_events(WorldState& state, const Island& island, double h, int most_events,
                          IslandResult& result) {
  if (fly_freely(state, island, h, result)) return true;
  if (is_crowded(state, island)) return false;
  const IslandBackup backup(state, island);
  result.report.stepper = "event_driven";
  std::optional<IslandEnergy> energy;
  // What jumps may do as much to springs.
  if (!island.joints.empty() && smooth_spans(state, island, h).empty())
    energy.emplace(state, island, false, 0.5 * h);
  // Where joints contradict each other what brings them together may bring any energy.
  if (EventStep(state, island, h, result).run(most_events) &&
      !(energy && energy->gained_much(state, island, h)))
    return true;

  // Only the work is kept of what was tried.
  backup.restore(state, island);
  IslandResult again;
  again.force_solves = result.force_solves;
  again.rejected_steps = result.rejected_steps;
  again.work = result.work;
  again.thrown_away = result.thrown_away;
  again.narrow = result.narrow;
  again.manifolds_reused = result.manifolds_reused;
  again.stage_seconds = result.stage_seconds;
  again.fallbacks = 1;
  result = std::move(again);
  return false;
}

}  // namespace skerry
