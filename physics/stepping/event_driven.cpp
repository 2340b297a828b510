// SPDX-License-Identifier: MIT
#include "physics/stepping/event_driven.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "physics/joint_rows.h"
#include "physics/spare.h"
#include "physics/stepping/acceleration.h"
#include "physics/stepping/flight_queue.h"
#include "physics/stepping/free_flight.h"
#include "physics/stepping/island_backup.h"
#include "physics/stepping/island_impact.h"
#include "physics/stepping/island_notes.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/projection.h"
#include "physics/stepping/root.h"
#include "physics/stepping/runge_kutta.h"
#include "physics/stepping/time_stepping.h"
#include "physics/stepping/touching.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

using State = AccelerationProblem::State;

// More changes of the contact mode than this in a step are a case for time stepping.
constexpr int kMaxEvents = 16;
// Local error of an inner step when no accuracy was asked for.
constexpr double kFinest = 1e-13;
// Work of the force solves of a step (see AccelerationProblem::work), and more for longer steps: what costs
// more than about 0.2 s is for time stepping.
constexpr double kMaxWork = 4e5, kMaxWorkPerSecond = 4e6;
// Inner steps: more mean that the accuracy cannot be had.
constexpr int kMaxInnerSteps = 4000;
// Quantities below this [m, m/s, rad, rad/s] are accurate absolutely, not relatively.
constexpr double kUnit = 1;
// A contact has passed a corner when it is this far beyond [m]: then the narrow phase sees it, too.
constexpr double kBeyond = 1e-10;

/// Something that falls to zero when the mode ends.
struct Watch {
  MotionEventKind kind;
  std::size_t index;  ///< of the point, grip or joint
};

class EventStep {
 public:
  EventStep(WorldState& state, const Island& island, double h, IslandResult& result)
      : state_(state), island_(island), h_(h), result_(result), problem_(state, island, result) {
    // Fields, drag and prescribed motions bend the paths of flight.
    parabolic_ = !has_varying_forces(state, island) && !meets_prescribed_motion(state, island);
  }

  /// @param most_events  impacts and changes of the mode together
  /// @return false if the step has to be made in another way
  bool run(int most_events) {
    // As many impacts as time_stepping would carry out one by one.
    int points = 0;
    for (const std::uint32_t index : island_.contacts) points += state_.contacts[index].manifold.count;
    const int cuts = std::min(state_.config.max_impacts_per_step, std::max(4, 512 / std::max(points, 1)));
    obey_joints();
    while (elapsed_ < h_) {
      if (!keep_mode_) {
        if (fly_in_turn()) continue;
        if (!impacts()) return false;
        if (!begin_mode()) return false;
        if (rest()) return true;
      }
      keep_mode_ = false;
      if (!(mode_.free() && parabolic_ ? fly_on() : integrate())) return false;
      ++result_.substeps;
      // Pieces that end without an event that counts must not go on for ever either.
      const int struck = result_.impacts - queued_impacts_;
      if (events_ > kMaxEvents || struck > cuts || result_.substeps > kMaxEvents + 2 * cuts ||
          events_ + struck > most_events)
        return false;
    }
    return true;
  }

 private:
  const Contact& contact_at(std::size_t k) const { return state_.contacts[island_.contacts[k]]; }

  double speed_bound() const {
    double fastest = 0;
    for (const std::uint32_t i : island_.bodies) {
      fastest = std::max(
          fastest, length(state_.bodies.velocity[i]) + std::abs(state_.bodies.omega[i]) * state_.radius[i]);
    }
    return fastest;
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

  std::optional<ContactKinematics> point_kinematics(const Contact& contact, int i, const State& y,
                                                    std::optional<ContactFeatures>& features) const {
    features =
        features_of(contact, state_.shapes[contact.shape_a].shape, pose_at(state_, contact.body_a, elapsed_),
                    state_.shapes[contact.shape_b].shape, pose_at(state_, contact.body_b, elapsed_), i);
    if (!features) return std::nullopt;
    return kinematics_of(*features, problem_.motion(contact.body_a, elapsed_, y),
                         problem_.motion(contact.body_b, elapsed_, y));
  }

  /// Second derivative of a gap while nothing but external forces acts.
  double free_normal_acceleration(std::uint32_t index, int i, const State& y) const {
    const Contact& contact = state_.contacts[index];
    std::optional<ContactFeatures> features;
    const std::optional<ContactKinematics> k = point_kinematics(contact, i, y, features);
    if (!k) return 0;
    const auto external = [&](std::uint32_t body) {
      if (state_.local_index[body] < 0) return Vec2{};
      return state_.acceleration[body] +
             state_.angular_acceleration[body] * perp(k->position - state_.bodies.position[body]);
    };
    return dot(k->normal, external(contact.body_b) - external(contact.body_a)) + k->normal_bias;
  }

  bool impacts() {
    mode_ = {};
    const State y = problem_.gather(mode_);
    ImpactOptions options;
    options.normal_acceleration = [&](std::uint32_t index, int i) {
      return free_normal_acceleration(index, i, y);
    };
    const ImpactOutcome outcome = apply_impact(state_, island_, elapsed_, options, result_);
    for (const SettledContact& settled : outcome.settled)
      note(MotionEventKind::Settle, elapsed_ + settled.rest, state_.contacts[settled.contact]);
    return result_.report.status == SolveStatus::Solved;
  }

  /// Ends that were given another velocity, and motors another speed, between the steps: what joints cannot
  /// but obey happens at once.
  void obey_joints() {
    const State y = problem_.gather(mode_);
    double worst = 0;
    for (const std::uint32_t slot : island_.joints) {
      const JointRecord& joint = state_.joints[slot];
      JointRows rows;
      const int count = joint_rows(joint, problem_.joint_end(joint.def.a.index, 0, y),
                                   problem_.joint_end(joint.def.b.index, 0, y), rows);
      for (int i = 0; i < count; ++i) {
        const JointRow& row = rows[static_cast<std::size_t>(i)];
        if (row.kind == JointRowKind::Hold) worst = std::max(worst, std::abs(row.rate));
        if (row.kind == JointRowKind::Motor && row.most == kInfinity)
          worst = std::max(worst, std::abs(row.rate - row.speed));
      }
    }
    if (worst > 1e-9 * (1 + speed_bound())) project_velocities(state_, island_, 0, false, result_);
  }

  /// Which contacts are closed from here on, and how.
  bool begin_mode() {
    mode_ = {};
    forces_known_ = false;
    const double fastest = speed_bound();
    const double still = 1e-11 * (1 + fastest);
    const State y = problem_.gather(mode_);
    for (std::size_t k = 0; k < island_.contacts.size(); ++k) {
      const Contact& contact = contact_at(k);
      const std::size_t first = mode_.points.size();
      double sliding = 0;
      bool held = false;
      for (int i = 0; i < contact.manifold.count; ++i) {
        const ManifoldPoint& point = contact.manifold.points[static_cast<std::size_t>(i)];
        if (!is_touching(state_, point)) continue;
        std::optional<ContactFeatures> features;
        const std::optional<ContactKinematics> kinematics = point_kinematics(contact, i, y, features);
        if (!kinematics || std::abs(kinematics->gap - point.separation) > 1e-6) return false;
        if (kinematics->gap_rate > still) continue;
        mode_.points.push_back({k, i, point.feature, *features, false});
        sliding = kinematics->sliding - contact.surface_velocity;
        held |= contact.points[static_cast<std::size_t>(i)].sticking;
      }
      const int count = static_cast<int>(mode_.points.size() - first);
      if (count == 0) continue;
      const auto add_grip = [&](bool rolling, double mu, double hold, double surface, double speed) {
        if (!(mu > 0)) return;
        Grip grip;
        grip.contact = k;
        grip.rolling = rolling;
        grip.mu = mu;
        grip.hold = hold;
        grip.surface = surface;
        // What stuck before moves by rounding only.
        const double limit = held ? 1e-9 : 0.1 * still;
        grip.sign = std::abs(speed) <= limit ? 0 : speed > 0 ? 1 : -1;
        for (const Onset& onset : onsets_) {
          if (onset.contact == k && onset.rolling == rolling && grip.sign == 0) grip.sign = onset.sign;
        }
        grip.count = count;
        for (int i = 0; i < count; ++i)
          grip.points[static_cast<std::size_t>(i)] = static_cast<int>(first) + i;
        mode_.grips.push_back(grip);
      };
      add_grip(false, contact.friction, contact.static_friction, contact.surface_velocity, sliding);
      add_grip(true, contact.rolling_resistance, contact.rolling_resistance, 0,
               problem_.motion(contact.body_b, elapsed_, y).omega -
                   problem_.motion(contact.body_a, elapsed_, y).omega);
    }
    onsets_.clear();
    for (std::size_t j = 0; j < island_.joints.size(); ++j) add_rows(j, still, y);
    if (mode_.points.empty() && mode_.free()) return true;
    return problem_.choose(mode_, elapsed_, problem_.gather(mode_)) && is_consistent();
  }

  /// Rows of a joint: what holds always, limits when reached and not about to slacken, motors by how they
  /// compare with their speed.
  void add_rows(std::size_t j, double still, const State& y) {
    const JointRecord& joint = state_.joints[island_.joints[j]];
    const JointEnd b = problem_.joint_end(joint.def.b.index, elapsed_, y);
    JointRows rows;
    const int count = joint_rows(joint, problem_.joint_end(joint.def.a.index, elapsed_, y), b, rows);
    for (int i = 0; i < count; ++i) {
      const JointRow& row = rows[static_cast<std::size_t>(i)];
      RowState state = RowState::Holds;
      if (row.kind == JointRowKind::Spring) state = RowState::Off;
      if (row.kind == JointRowKind::Limit) {
        const bool reached = row.error <= touch_tolerance(state_, b.p) && row.rate <= still;
        state = reached ? RowState::Holds : RowState::Off;
      }
      // Drift while it held is taken out by the projection of velocities, which knows motors by this.
      if (row.kind == JointRowKind::Motor && row.most < kInfinity) {
        const double missing = row.speed - row.rate;
        const bool held = std::abs(joint.row_force[i]) < row.most * (1 - 1e-9);
        if (std::abs(missing) > (held ? 1e-9 * (1 + std::abs(row.speed)) : still))
          state = missing > 0 ? RowState::Forward : RowState::Backward;
      }
      mode_.rows.push_back({j, i, row.kind, state});
    }
  }

  /// The forces of the mode must be of the kind the mode assumes.
  bool is_consistent() {
    if (mode_.free()) return true;
    if (!problem_.evaluate(mode_, elapsed_, problem_.gather(mode_), forces_)) return false;
    forces_known_ = true;
    const double slack = 1e-8 * forces_.scale;
    for (std::size_t p = 0; p < mode_.points.size(); ++p) {
      if (forces_.point_force[p] < -slack) return false;
    }
    for (std::size_t k = 0; k < mode_.grips.size(); ++k) {
      if (mode_.grips[k].sign == 0 && std::abs(forces_.grip_force[k]) > forces_.grip_limit[k] + slack)
        return false;
    }
    for (std::size_t i = 0; i < mode_.rows.size(); ++i) {
      if (mode_.rows[i].state != RowState::Holds) continue;
      if (mode_.rows[i].kind == JointRowKind::Limit && forces_.row_force[i] < -slack) return false;
      if (mode_.rows[i].kind == JointRowKind::Motor &&
          std::abs(forces_.row_force[i]) > forces_.rows[i].most + slack) {
        return false;
      }
    }
    return true;
  }

  /// Nothing moves and nothing will: the rest of the step is known.
  bool rest() {
    if (mode_.free() || !parabolic_) return false;
    const double g = external_bound();
    if (speed_bound() > 1e-11 * h_ * g) return false;
    for (std::size_t k = 0; k < island_.bodies.size(); ++k) {
      const std::array<double, 3>& a = forces_.acceleration[k];
      const double turn = std::abs(a[2]) * state_.radius[island_.bodies[k]];
      if (std::max({std::abs(a[0]), std::abs(a[1]), turn}) > 1e-10 * g) return false;
    }
    for (const std::uint32_t index : island_.contacts) {
      const Contact& contact = state_.contacts[index];
      for (const std::uint32_t body : {contact.body_a, contact.body_b}) {
        if (state_.bodies.type[body] == BodyType::Kinematic &&
            (state_.bodies.velocity[body] != Vec2{} || state_.bodies.omega[body] != 0)) {
          return false;
        }
      }
    }
    store_velocities(state_, island_, std::vector<Velocity>(island_.bodies.size(), Velocity{}));
    State y = problem_.gather(mode_);
    State dy;
    problem_.derivative(y, forces_, dy);
    for (std::size_t i = 6 * island_.bodies.size(); i < y.size(); ++i) y[i] = (h_ - elapsed_) * dy[i];
    store_forces(y);
    // The piece before this one may reach beyond its event.
    if (state_.observe.paths)
      record_hermite(state_, island_.bodies, elapsed_, h_ - elapsed_, path_ends(state_, island_.bodies),
                     result_);
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

  Motion flight_of(std::uint32_t body) const { return free_flight(state_, body, elapsed_); }

  /// Largest speed at which any gap between two bodies can change within `h`.
  double gap_speed(std::uint32_t a, std::uint32_t b, double h) const {
    double sum = 1e-9;
    for (const std::uint32_t body : {a, b}) {
      if (body == BodyId::kNone) continue;
      const Motion m = flight_of(body);
      const double radius = std::isfinite(state_.radius[body]) ? state_.radius[body] : 0;
      double acceleration = length(m.a), angular = std::abs(m.alpha);
      const int k = state_.local_index[body];
      if (k >= 0 && !(mode_.free() && parabolic_)) {
        const std::array<double, 3>& f = forces_.acceleration[static_cast<std::size_t>(k)];
        acceleration = std::max(acceleration, std::hypot(f[0], f[1]));
        angular = std::max(angular, std::abs(f[2]));
      }
      sum += length(m.v) + h * acceleration + (std::abs(m.omega) + h * angular) * radius;
    }
    return sum;
  }

  /// True if a point touches without parting: it was released a moment ago, or rests beside.
  bool lingers(const Contact& contact) const {
    for (int i = 0; i < contact.manifold.count; ++i) {
      const ManifoldPoint& point = contact.manifold.points[static_cast<std::size_t>(i)];
      if (is_touching(state_, point) &&
          std::abs(normal_velocity(state_, contact, point.position, elapsed_)) < 1e-8) {
        return true;
      }
    }
    return false;
  }

  /// Smallest separation at these poses, closed points left out; the contact's margin if there is none.
  double open_gap(std::size_t k, const Transform& a, const Transform& b) const {
    const Contact& contact = contact_at(k);
    const Manifold manifold =
        contact_manifold(contact, state_.shapes[contact.shape_a].shape, a,
                         state_.shapes[contact.shape_b].shape, b, contact.margin, nullptr, nullptr);
    double smallest = contact.margin;
    for (int i = 0; i < manifold.count; ++i) {
      const ManifoldPoint& point = manifold.points[static_cast<std::size_t>(i)];
      const bool closed = std::any_of(mode_.points.begin(), mode_.points.end(), [&](const ModePoint& p) {
        return p.closed && p.contact == k && p.feature == point.feature;
      });
      if (!closed) smallest = std::min(smallest, point.separation);
    }
    return smallest;
  }

  static JointEnd end_at(const Motion& m, double t) {
    const Motion then = later(m, t);
    return {then.p0, Rot::from_angle(then.angle0), then.angle0, then.v, then.omega};
  }

  /// About the largest rate at which a flight of length `h` changes the slack of a limit.
  static double limit_speed(const JointRow& row, const Motion& a, const Motion& b, double h) {
    double sum = 1e-9;
    const auto add = [&](const std::array<double, 3>& J, const Motion& m) {
      sum += std::hypot(J[0], J[1]) * (length(m.v) + h * length(m.a)) +
             (std::abs(J[2]) + h * length(m.v)) * (std::abs(m.omega) + h * std::abs(m.alpha));
    };
    add(row.Ja, a);
    add(row.Jb, b);
    return sum;
  }

  bool fly_on() {
    const double left = h_ - elapsed_;
    double first = left;
    const Contact* landing = nullptr;
    const JointRecord* limit = nullptr;
    for (std::size_t k = 0; k < island_.contacts.size(); ++k) {
      const Contact& contact = contact_at(k);
      const Motion a = flight_of(contact.body_a), b = flight_of(contact.body_b);
      double from = 0;
      if (lingers(contact)) {
        const double tolerance = touch_tolerance(state_, state_.bodies.position[contact.body_b]);
        from = 1e-6 * first;
        double gap = open_gap(k, a.at(from), b.at(from));
        while (std::abs(gap) <= tolerance && from < first) {
          from = std::min(2 * from, first);
          gap = open_gap(k, a.at(from), b.at(from));
        }
        if (gap < -tolerance) {
          first = from;
          landing = &contact;
          continue;
        }
        if (from >= first) continue;
      }
      const ImpactTime impact =
          contact_impact_time(contact, state_.shapes[contact.shape_a].shape, later(a, from),
                              state_.shapes[contact.shape_b].shape, later(b, from), first - from);
      if (!impact.hit) continue;
      first = from + impact.t;
      landing = &contact;
    }
    for (const ModeRow& row : mode_.rows) {
      const JointRecord& joint = state_.joints[island_.joints[row.joint]];
      if (row.kind != JointRowKind::Limit) continue;
      const Motion a = flight_of(joint.def.a.index), b = flight_of(joint.def.b.index);
      JointRows rows;
      const auto slack = [&](double t) {
        joint_rows(joint, end_at(a, t), end_at(b, t), rows);
        return rows[static_cast<std::size_t>(row.row)].error;
      };
      slack(0);
      const std::optional<double> reached =
          closing_time(slack, limit_speed(rows[static_cast<std::size_t>(row.row)], a, b, first), first,
                       touch_tolerance(state_, state_.bodies.position[joint.def.b.index]));
      if (!reached) continue;
      first = *reached;
      limit = &joint;
    }

    std::vector<PathEnd> start;
    if (state_.observe.paths) start = path_ends(state_, island_.bodies);
    for (const std::uint32_t body : island_.bodies) skerry::fly(state_, body, first);
    if (state_.observe.paths) record_hermite(state_, island_.bodies, elapsed_, first, start, result_);
    clear_forces();
    elapsed_ = first < left ? elapsed_ + first : h_;
    result_.manifolds_reused += update_manifolds(state_, island_, elapsed_, result_.narrow);
    if (limit != nullptr)
      note(MotionEventKind::Limit, elapsed_, limit->def.a, limit->def.b);
    else if (landing != nullptr)
      note(MotionEventKind::Landing, elapsed_, *landing);
    // A landing that changes nothing is an event all the same: too many of them must not go on for ever.
    if ((limit != nullptr || landing != nullptr) && first < 1e-12 * h_) ++events_;
    return true;
  }

  // --- Constrained motion
  // ---------------------------------------------------------------------------------------------------------

  std::vector<Watch> watches() const {
    std::vector<Watch> out;
    for (std::size_t p = 0; p < mode_.points.size(); ++p) {
      if (!mode_.points[p].closed) continue;
      out.push_back({MotionEventKind::Release, p});
      out.push_back({MotionEventKind::Feature, p});
    }
    for (std::size_t k = 0; k < mode_.grips.size(); ++k) {
      if (!is_loaded(mode_.grips[k])) continue;
      out.push_back({mode_.grips[k].sign == 0 ? MotionEventKind::Slip : MotionEventKind::Stick, k});
    }
    for (std::size_t i = 0; i < mode_.rows.size(); ++i) {
      if (mode_.rows[i].kind == JointRowKind::Limit) out.push_back({MotionEventKind::Limit, i});
      if (mode_.rows[i].kind == JointRowKind::Motor && forces_.rows[i].most < kInfinity)
        out.push_back({MotionEventKind::Motor, i});
    }
    return out;
  }

  bool is_loaded(const Grip& grip) const {
    for (int i = 0; i < grip.count; ++i) {
      if (mode_.points[static_cast<std::size_t>(grip.points[static_cast<std::size_t>(i)])].closed)
        return true;
    }
    return false;
  }

  double value(const Watch& watch, const ModeForces& forces) const {
    const std::size_t i = watch.index;
    switch (watch.kind) {
      case MotionEventKind::Release:
        return forces.point_force[i] + 1e-14 * forces.scale;
      case MotionEventKind::Feature:
        return forces.points[i].range + kBeyond;
      case MotionEventKind::Slip:
        return forces.grip_limit[i] - std::abs(forces.grip_force[i]) + 1e-14 * forces.scale;
      case MotionEventKind::Stick:
        return mode_.grips[i].sign * forces.grip_speed[i];
      case MotionEventKind::Motor: {
        const JointRow& row = forces.rows[i];
        if (mode_.rows[i].state == RowState::Forward) return row.speed - row.rate;
        if (mode_.rows[i].state == RowState::Backward) return row.rate - row.speed;
        return row.most - std::abs(forces.row_force[i]) + 1e-14 * forces.scale;
      }
      default:
        return mode_.rows[i].state == RowState::Holds ? forces.row_force[i] + 1e-14 * forces.scale
                                                      : forces.rows[i].error;
    }
  }

  bool integrate() {
    State y = problem_.gather(mode_), dy, at_event;
    if (!forces_known_ && !problem_.evaluate(mode_, elapsed_, y, forces_)) return false;
    forces_known_ = false;
    problem_.derivative(y, forces_, dy);
    ModeForces latest;
    RungeKutta method(
        [&](double t, const State& state, State& out) {
          if (!problem_.evaluate(mode_, t, state, latest)) return false;
          problem_.derivative(state, latest, out);
          return true;
        },
        static_cast<int>(6 * island_.bodies.size()));
    const std::vector<Watch> watched = watches();
    if (!(inner_step_ > 0)) inner_step_ = 0.2 / rate();
    const double accuracy = state_.config.accuracy.value_or(kFinest);

    for (;;) {
      const double left = h_ - elapsed_;
      const double length = std::min(inner_step_, left);
      if (++inner_steps_ > kMaxInnerSteps || !(length > 1e-14 * h_)) return false;
      if (problem_.work() > kMaxWork + h_ * kMaxWorkPerSecond) return false;
      const double error = method.attempt(elapsed_, y, dy, length, accuracy, kUnit);
      if (!(error <= 1)) {
        ++result_.rejected_steps;
        inner_step_ = length * std::min(step_factor(error), 0.9);
        continue;
      }
      const ModeForces end = latest;
      Event event;
      if (!find_event(method, watched, end, latest, event)) return false;
      if (state_.observe.paths && !record_path(method)) return false;
      ++result_.inner_steps;
      if (state_.config.accuracy) result_.report.error_estimate += error * accuracy;
      if (event.found) {
        method.at(event.theta, at_event);
        travel(event.theta * length, method.end());
        elapsed_ += event.theta * length;
        problem_.scatter(at_event, state_);
        if (!problem_.evaluate(mode_, elapsed_, at_event, forces_)) return false;
        change_mode(event, watched);
        store_forces(at_event);
        arrive();
        ++events_;
        return true;
      }
      travel(length, method.end());
      y = method.end();
      dy = method.end_derivative();
      forces_ = end;
      problem_.scatter(y, state_);
      elapsed_ = length < left ? elapsed_ + length : h_;
      const double factor = step_factor(error);
      if (length == inner_step_ || factor < 1) inner_step_ = length * factor;
      if (elapsed_ < h_) {
        // Landings are looked for from the manifolds of where the inner step begins.
        result_.manifolds_reused += update_manifolds(state_, island_, elapsed_, result_.narrow);
        continue;
      }
      store_forces(y);
      arrive();
      return true;
    }
  }

  /// The continuous output of the inner step that was tried last; an event may end it early.
  bool record_path(RungeKutta& method) {
    if (!method.prepare_dense()) return false;
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

  struct Event {
    bool found = false;
    double theta = 1;
    Watch watch{};
    const Contact* landing = nullptr;
  };

  /// The first event of the inner step that was tried last. @return false if there is one that cannot be
  /// located
  bool find_event(RungeKutta& method, const std::vector<Watch>& watched, const ModeForces& end,
                  ModeForces& scratch, Event& event) {
    bool dense = false;
    State y;
    const auto prepare = [&] {
      if (!dense) dense = method.prepare_dense();
      return dense;
    };
    for (const Watch& watch : watched) {
      double high = value(watch, end), low = value(watch, forces_);
      if (!(high < 0)) continue;
      if (!prepare()) return false;
      const auto at = [&](double theta) {
        method.at(theta, y);
        if (!problem_.evaluate(mode_, method.begin() + theta * method.length(), y, scratch)) return 0.0;
        return value(watch, scratch);
      };
      if (event.found && (high = at(event.theta)) >= 0) continue;
      double from = 0;
      if (!(low > 0)) {
        // It begins at zero: look for the moment from which on it was positive.
        from = 1e-4;
        while (from < event.theta && !((low = at(from)) > 0)) from *= 4;
        if (!(low > 0)) return false;
      }
      event.theta = falling_root(at, from, low, event.theta, high);
      event.watch = watch;
      event.found = true;
    }
    for (std::size_t k = 0; k < island_.contacts.size(); ++k) {
      const Contact& contact = contact_at(k);
      const double span = event.theta * method.length();
      const double speed = gap_speed(contact.body_a, contact.body_b, span);
      const auto pose = [&](std::uint32_t body, double elapsed, const State& at) {
        const BodyMotion m = problem_.motion(body, elapsed, at);
        return Transform{m.p, m.q};
      };
      const double now =
          open_gap(k, pose_at(state_, contact.body_a, elapsed_), pose_at(state_, contact.body_b, elapsed_));
      if (now > 1.5 * span * speed) continue;
      if (!prepare()) return false;
      const auto gap = [&](double t) {
        method.at(t / method.length(), y);
        return open_gap(k, pose(contact.body_a, method.begin() + t, y),
                        pose(contact.body_b, method.begin() + t, y));
      };
      const double tolerance = touch_tolerance(state_, state_.bodies.position[contact.body_b]);
      const std::optional<double> closes =
          closing_time(gap, speed, span, lingers(contact) ? tolerance : 1e-14);
      if (!closes) continue;
      event.found = true;
      event.theta = *closes / method.length();
      event.watch = {MotionEventKind::Landing, k};
      event.landing = &contact;
    }
    return true;
  }

  /// Applies what the event says where the forces go on smoothly; otherwise the mode is chosen anew.
  void change_mode(const Event& event, const std::vector<Watch>& watched) {
    note_event(event.watch, event.landing);
    if (event.watch.kind != MotionEventKind::Release && event.watch.kind != MotionEventKind::Slip) return;
    keep_mode_ = true;
    const double zero = 1e-11 * forces_.scale;
    for (const Watch& watch : watched) {
      const bool same = watch.kind == event.watch.kind && watch.index == event.watch.index;
      const bool smooth = watch.kind == MotionEventKind::Release || watch.kind == MotionEventKind::Slip;
      if (!same && !(smooth && value(watch, forces_) <= zero)) continue;
      if (!same) note_event(watch, nullptr);
      if (watch.kind == MotionEventKind::Release) mode_.points[watch.index].closed = false;
      if (watch.kind != MotionEventKind::Slip) continue;
      Grip& grip = mode_.grips[watch.index];
      grip.sign = forces_.grip_force[watch.index] > 0 ? -1 : 1;
      // Static friction lets go: the force jumps, and everything else is to be decided anew.
      if (!(grip.hold > grip.mu)) continue;
      onsets_.push_back({grip.contact, grip.rolling, grip.sign});
      keep_mode_ = false;
    }
  }

  void note_event(const Watch& watch, const Contact* landing) {
    switch (watch.kind) {
      case MotionEventKind::Release:
      case MotionEventKind::Feature:
        return note(watch.kind, elapsed_, contact_at(mode_.points[watch.index].contact));
      case MotionEventKind::Slip:
      case MotionEventKind::Stick:
        return note(watch.kind, elapsed_, contact_at(mode_.grips[watch.index].contact));
      case MotionEventKind::Landing:
        return note(watch.kind, elapsed_, *landing);
      default: {
        const ModeRow& row = mode_.rows[watch.index];
        const JointRecord& joint = state_.joints[island_.joints[row.joint]];
        const bool released = watch.kind == MotionEventKind::Limit && row.state == RowState::Holds;
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
      const double speed = std::max(length(state_.bodies.velocity[i]), std::hypot(q[3], q[4])) +
                           0.25 * t * std::hypot(a[0], a[1]);
      const double turn =
          std::max(std::abs(state_.bodies.omega[i]), std::abs(q[5])) + 0.25 * t * std::abs(a[2]);
      state_.travelled[i] += t * (speed + turn * state_.radius[i]);
    }
  }

  /// Brings manifolds to the new poses and takes out what the integration left of drift.
  void arrive() {
    result_.manifolds_reused += update_manifolds(state_, island_, elapsed_, result_.narrow);
    Spare<Assembly> rows;
    project_positions(state_, island_, elapsed_, result_, &*rows);
    project_velocities(state_, island_, elapsed_, false, result_, &*rows);
  }

  void clear_forces() {
    for (const std::uint32_t index : island_.contacts) {
      for (PointMemory& memory : state_.contacts[index].points) {
        memory.normal_impulse = memory.friction_impulse = memory.rolling_impulse = 0;
        memory.h = h_;
        memory.sticking = false;
      }
    }
    for (const std::uint32_t slot : island_.joints)
      std::fill(std::begin(state_.joints[slot].row_force), std::end(state_.joints[slot].row_force), 0);
  }

  /// Writes the present forces (as impulses of a whole step) and the impulses in `y` to contacts and joints.
  void store_forces(const State& y) {
    clear_forces();
    const std::size_t points = 6 * island_.bodies.size();
    const std::size_t grips = points + mode_.points.size();
    const std::size_t joints = grips + mode_.grips.size();
    for (std::size_t p = 0; p < mode_.points.size(); ++p) {
      if (PointMemory* memory = memory_of(mode_.points[p])) {
        // Closed points carry load, be it ever so small: that is how the projection knows them.
        if (mode_.points[p].closed)
          memory->normal_impulse = h_ * std::max(forces_.point_force[p], 1e-300 + 1e-15 * forces_.scale);
        memory->total_normal += y[points + p];
      }
    }
    for (std::size_t k = 0; k < mode_.grips.size(); ++k) {
      const Grip& grip = mode_.grips[k];
      double load = 0;
      for (int i = 0; i < grip.count; ++i) load += forces_.point_force[point_of(grip, i)];
      for (int i = 0; i < grip.count; ++i) {
        const ModePoint& point = mode_.points[point_of(grip, i)];
        PointMemory* memory = memory_of(point);
        if (memory == nullptr || !point.closed || !(load > 0)) continue;
        const double share = forces_.point_force[point_of(grip, i)] / load;
        (grip.rolling ? memory->rolling_impulse : memory->friction_impulse) =
            h_ * share * forces_.grip_force[k];
        if (grip.rolling) continue;
        memory->total_friction += share * y[grips + k];
        memory->sticking = grip.sign == 0;
      }
    }
    for (std::size_t i = 0; i < mode_.rows.size(); ++i) {
      JointRecord& joint = state_.joints[island_.joints[mode_.rows[i].joint]];
      joint.row_force[mode_.rows[i].row] = forces_.row_force[i];
      joint.row_impulse[mode_.rows[i].row] += y[joints + i];
    }
  }

  static std::size_t point_of(const Grip& grip, int i) {
    return static_cast<std::size_t>(grip.points[static_cast<std::size_t>(i)]);
  }

  PointMemory* memory_of(const ModePoint& point) {
    Contact& contact = state_.contacts[island_.contacts[point.contact]];
    for (PointMemory& memory : contact.points) {
      if (memory.feature == point.feature) return &memory;
    }
    return nullptr;
  }

  WorldState& state_;
  const Island& island_;
  const double h_;
  IslandResult& result_;
  AccelerationProblem problem_;
  ContactMode mode_;
  ModeForces forces_;  ///< at the beginning of the inner step
  /// A grip that let go a moment ago and has no speed yet.
  struct Onset {
    std::size_t contact;
    bool rolling;
    int sign;
  };
  std::vector<Onset> onsets_;  ///< since the mode was chosen last
  bool keep_mode_ = false;
  bool parabolic_ = true;      ///< free flight has constant acceleration
  bool forces_known_ = false;  ///< `forces_` are those of the mode and the present state
  double elapsed_ = 0;         ///< since the beginning of the step [s]
  double inner_step_ = 0;
  int inner_steps_ = 0;
  int events_ = 0;
  int flights_ = 0;         ///< of the whole island by a queue of impacts
  int queued_impacts_ = 0;  ///< that those carried out
};

}  // namespace

void step_island_by_events(WorldState& state, const Island& island, double h, IslandResult& result) {
  if (try_island_by_events(state, island, h, std::numeric_limits<int>::max(), result)) return;
  step_island_by_time_stepping(state, island, h, result);
}

bool try_island_by_events(WorldState& state, const Island& island, double h, int most_events,
                          IslandResult& result) {
  if (fly_freely(state, island, h, result)) return true;
  const IslandBackup backup(state, island);
  result.report.stepper = "event_driven";
  if (EventStep(state, island, h, result).run(most_events)) return true;

  // Only the work is kept of what was tried.
  backup.restore(state, island);
  IslandResult again;
  again.force_solves = result.force_solves;
  again.rejected_steps = result.rejected_steps;
  again.work = result.work;
  again.narrow = result.narrow;
  again.manifolds_reused = result.manifolds_reused;
  again.stage_seconds = result.stage_seconds;
  again.fallbacks = 1;
  result = std::move(again);
  return false;
}

}  // namespace skerry
