// SPDX-License-Identifier: MIT
#include "physics/stepping/coming_to_rest.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "physics/hash.h"
#include "physics/solver/associated_path.h"
#include "physics/spare.h"
#include "physics/stepping/applied_forces.h"
#include "physics/stepping/flow_work.h"
#include "physics/stepping/island_backup.h"
#include "physics/stepping/island_energy.h"
#include "physics/stepping/island_notes.h"
#include "physics/stepping/island_rows.h"
#include "physics/stepping/local_support.h"
#include "physics/stepping/one_piece_joints.h"
#include "physics/stepping/one_piece_sweeps.h"
#include "physics/stepping/path.h"
#include "physics/stepping/point_memory.h"
#include "physics/stepping/projection.h"
#include "physics/stepping/touching.h"
#include "physics/stepping/travel.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

// Steps from one look to the next, of so many bodies: a look costs as much as three steps in flow. It grows
// with the power 3/2 of the bodies, and so there are fewer looks at more.
constexpr double kEvery = 16, kUsualBodies = 1000;
// Fastest motion, of what gravity does in a step.
constexpr double kQuiet = 0.01;
// Gaps that are closed, and those that may be held as they are, of the smaller body's size.
constexpr double kClosed = 1e-4, kNearlyClosed = 5e-4;
// Steps for which forces that are not exact could have held it before they do: exact ones may still be found.
constexpr int kPatience = 96;
// By so much joints may be off where they are held, of that size.
constexpr double kJointed = 1e-2;
// Overlaps that are no rest, of that size: they go away by shifts alone.
constexpr double kPressed = 0.05;
// Of what gaps are closed with, in steps of flow; and by so much joints are off then, of that size.
constexpr double kClosingWork = 3, kJoined = 1e-8;
// For so long an island has to be slow before it is stopped for that [s].
constexpr double kSlowFor = 0.5;
// What may be left of the speed that gravity gives in a step: of exact rest, and of what is held.
constexpr double kStill = 1e-9, kHeld = 1e-2;
// The same by which it is told whether a body can be stopped exactly: more than rounding leaves.
constexpr double kStopped = 1e-6;

/// Fastest motion of a body with the velocities of some, its ends included [m/s].
template <class VelocityOf>
double fastest_of(const WorldState& state, const Island& island, const VelocityOf& velocity) {
  double most = 0;
  for (std::size_t k = 0; k < island.bodies.size(); ++k) {
    const Velocity v = velocity(k);
    const double speed = std::hypot(v[0], v[1]) + state.radius[island.bodies[k]] * std::abs(v[2]);
    if (!(speed <= most)) most = speed;
  }
  return most;
}

double fastest_now(const WorldState& state, const Island& island) {
  const BodyArrays& all = state.bodies;
  return fastest_of(state, island, [&](std::size_t k) {
    const std::uint32_t i = island.bodies[k];
    return Velocity{all.velocity[i].x, all.velocity[i].y, all.omega[i]};
  });
}

class ComingToRest {
 public:
  ComingToRest(WorldState& state, const Island& island, double h, IslandResult& result)
      : state_(state), island_(island), h_(h), result_(result), varying_(has_varying_forces(state, island)) {}

  /// @param every  steps from one look to the next; 0: it was held in the last step
  RestLook run(int every) {
    gravity_ = h_ * largest_acceleration(state_, island_);
    int& near = result_.step_memory.near_rest;
    if (!(gravity_ > 0) || !(fastest() <= kQuiet * gravity_)) {
      if (!(fastest() <= gravity_)) near = 0;
      return RestLook::None;
    }
    if (meets_motion(state_, island_) || is_free(state_, island_)) return RestLook::None;
    if (joints_are_off(state_, island_, 0, kJointed) || is_pressed()) return RestLook::None;
    if (varying_) gravity_ = h_ * forces_of_rest();
    if (!(gravity_ > 0)) return RestLook::None;
    if (every == 0 && still_held()) return RestLook::Rests;
    const bool waits = every > 0 && near + every <= kPatience;
    find_forces(kClosed, kStopped);
    const bool exact = is_exact() && !joints_are_off(state_, island_, 0, kClosed);
    // It would have gone on a little.
    double speed = std::max({fastest(), left_, widest_gap() / h_});
    if (!exact || !stop(true)) {
      // After gaps that were closed in vain the forces are those of other places; they will do to wait.
      searched_ &= !closed_;
      if ((closed_ && !waits) || !are_near()) find_forces(kNearlyClosed, kHeld);
      if (!are_near()) return RestLook::Vain;
      if (waits) {
        near += every;
        return RestLook::Vain;
      }
      speed = std::max({fastest(), left_, widest_gap() / h_});
      stop(false);
    }
    if (varying_) begin_at_rest();
    report(speed / gravity_);
    return RestLook::Rests;
  }

  /// Stops the island, with what sweeps from the last forces find in the work of a step in flow.
  /// @param again  that was done in the last step: nothing changes
  void stop_slow(bool again) {
    const double largest = varying_ ? forces_of_rest() : largest_acceleration(state_, island_);
    gravity_ = std::max(h_ * largest, state_.config.sleep_speed);
    Spare<std::vector<Velocity>> after;
    aim(kNearlyClosed, *after);
    Spare<std::vector<double>> last;
    last_impulses(*last);
    if (again) {
      solution_.lambda = *last;
    } else {
      SolveOptions options = state_.config.solve;
      options.threads = state_.island_threads;
      options.work_limit = flow_work(state_, island_) * static_cast<double>(island_.bodies.size());
      StageTimer timer(state_, result_, Stage::Solve);
      solution_ = sweep_until_done(rows_->system, true, *last, options, {}, look_at_nothing);
      result_.work += solution_.work;
    }
    weigh(*after);
    const double speed = std::max({fastest(), left_, widest_gap() / h_, widest_joint() / h_});
    if (again)
      hold();
    else
      stop(false);
    result_.step_memory = {.stopped = 1, .slow = kSlowFor};
    if (varying_) begin_at_rest();
    report(speed / gravity_);
  }

 private:
  /// Sets the accelerations of bodies that do not move. @param of  gives that of one, from where it is
  template <class Of>
  void set_accelerations(const Of& of) {
    const BodyArrays& all = state_.bodies;
    for (const std::uint32_t i : island_.bodies) {
      const std::array<double, 3> a = of(i, JointEnd{all.position[i], all.rotation[i], all.angle[i], {}, 0});
      state_.acceleration[i] = {a[0], a[1]};
      state_.angular_acceleration[i] = a[2];
    }
  }

  /// They become those of rest, where no drag acts. @return the largest one
  double forces_of_rest() {
    set_accelerations(
        [this](std::uint32_t i, const JointEnd& end) { return applied_acceleration(state_, i, end, 0); });
    return largest_acceleration(state_, island_);
  }

  /// They become those with which the next step begins, by which it is known that nothing changed.
  void begin_at_rest() {
    set_accelerations([this](std::uint32_t i, const JointEnd& end) {
      return damped_motion(state_, i, end, 0, {}, h_).acceleration;
    });
  }

  void report(double residual) {
    result_.report.method = solution_.method;
    result_.report.iterations = solution_.iterations;
    result_.report.rows = rows_->system.size();
    for (const RowOrigin& origin : rows_->origin) result_.friction_rows += origin.kind == RowKind::Friction;
    note_status(result_, residual <= kStill ? SolveStatus::Solved : SolveStatus::Inexact, residual);
    if (state_.observe.systems)
      keep_trace(state_, island_, 0, rows_->system, solution_.lambda, solution_.status, solution_.method,
                 solution_.residual, false, nullptr, result_);
  }

  double fastest() const { return fastest_now(state_, island_); }

  /// Of the points that carry load, overlaps left out [m].
  double widest_gap() const {
    double widest = 0;
    for (std::size_t i = 0; i < solution_.lambda.size(); ++i) {
      const RowOrigin& origin = rows_->origin[i];
      if (!origin.joint && origin.kind == RowKind::Normal && solution_.lambda[i] > 0)
        widest = std::max(widest, origin.error);
    }
    return widest;
  }

  /// Error of a joint [m or rad].
  double widest_joint() const {
    double widest = 0;
    for (const RowOrigin& origin : rows_->origin)
      if (origin.kind == RowKind::Joint) widest = std::max(widest, std::abs(origin.error));
    return widest;
  }

  /// Forces that hold what touches, as well as can be, and what is left of the motion.
  /// Not looked for where what touches a body cannot stop it.
  /// @param closed   gaps that count as none, of the smaller body's size
  /// @param stopped  speed that counts as stopped, of what gravity gives in a step
  void find_forces(double closed, double stopped) {
    const int before = rows_->system.size();
    Spare<std::vector<Velocity>> after;
    aim(closed, *after);
    // The same rows have the same forces, where nothing has moved.
    if (closed > 0 && searched_ && rows_->system.size() == before) return;
    Spare<std::vector<double>> radius;
    for (const std::uint32_t body : island_.bodies) radius->push_back(state_.radius[body]);
    searched_ =
        each_can_be_stopped(rows_->system, *after, *radius, stopped * gravity_, state_.island_threads);
    if (!searched_) {
      solution_ = {};
      solution_.residual = left_ = kInfinity;
      return;
    }
    SolveOptions options = state_.config.solve;
    options.threads = state_.island_threads;
    {
      StageTimer timer(state_, result_, Stage::Solve);
      Spare<std::vector<double>> last;
      last_impulses(*last);
      solution_ = find_rest(rows_->system, *last, options);
    }
    result_.work += solution_.work;
    weigh(*after);
  }

  /// Rows of what counts as closed, and what it takes to stop them. @param after  becomes what their bodies
  /// do from rest without them
  void aim(double closed, std::vector<Velocity>& after) {
    assemble_closed(closed);
    IslandSystem& system = rows_->system;
    after.assign(island_.bodies.size(), Velocity{});
    add_free_motion(state_, island_, h_, after);
    for (int i = 0; i < system.size(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const RowOrigin& origin = rows_->origin[k];
      const double target = origin.joint ? aim_actuator(origin, h_, k, system).value_or(0) : 0;
      system.b[k] = target - row_velocity(*rows_, i, after);
      Row& row = system.rows[k];
      if (origin.kind == RowKind::Friction)
        row.mu = std::max(row.mu, state_.contacts[origin.index].static_friction);
    }
  }

  /// What the forces of the solution leave. @param after  what bodies do without them
  void weigh(std::vector<Velocity>& after) {
    apply_impulses(rows_->system, solution_.lambda, after);
    left_ = fastest_of(state_, island_, [&](std::size_t k) { return after[k]; });
  }

  /// Of each row, over a step.
  void last_impulses(std::vector<double>& impulses) const {
    impulses.resize(rows_->origin.size());
    for (std::size_t i = 0; i < impulses.size(); ++i) {
      const RowOrigin& origin = rows_->origin[i];
      impulses[i] = origin.joint ? state_.joints[origin.index].row_force[origin.point] * h_
                                 : last_impulse(state_.contacts[origin.index], origin, h_);
    }
  }

  bool are_near() const { return solution_.residual <= kHeld && left_ <= kHeld * gravity_; }

  /// Rows of all points that count as closed. @param closed  0: that touch
  void assemble_closed(double closed) {
    StageTimer timer(state_, result_, Stage::Assemble);
    Spare<std::vector<std::uint8_t>> points;
    points->assign(island_.contacts.size(), 0);
    double smallest = kInfinity;
    for (const std::uint32_t body : island_.bodies)
      smallest = std::min(smallest, size_in_island(state_, body));
    for (std::size_t k = 0; k < points->size(); ++k) {
      const Contact& contact = state_.contacts[island_.contacts[k]];
      const double size =
          std::min(size_in_island(state_, contact.body_a), size_in_island(state_, contact.body_b));
      for (int i = 0; i < contact.manifold.count; ++i)
        if (contact.manifold.points[i].separation <= std::max(closed * size, state_.config.touch_tolerance))
          (*points)[k] |= 1u << i;
    }
    AssemblyRequest request;
    request.points = &*points;
    request.friction = true;
    request.actuators = AssemblyRequest::Actuators::All;
    request.rope_slack = std::max(closed * std::min(1.0, smallest), state_.config.touch_tolerance);
    assemble(state_, island_, request, *rows_);
  }

  void store() {
    const Assembly& rows = *rows_;
    const std::vector<double>& lambda = solution_.lambda;
    for (const std::uint32_t index : island_.contacts) forget_impulses(state_.contacts[index], h_);
    store_joint_impulses(state_, island_, rows, lambda, h_);
    for (std::size_t i = 0; i < lambda.size(); ++i) {
      const RowOrigin& origin = rows.origin[i];
      if (origin.joint) continue;
      Contact& contact = state_.contacts[origin.index];
      remember_impulse(origin, rows.system.rows[i], lambda[i], contact);
      if (origin.kind == RowKind::Normal)
        contact.points[static_cast<std::size_t>(origin.point)].total_normal += lambda[i];
    }
  }

  /// The bodies stop. @param exact  and the gaps of what carries load are closed
  /// @return false, and nothing has happened, where that takes too much work
  bool stop(bool exact) {
    StageTimer timer(state_, result_, Stage::Apply);
    std::optional<IslandBackup> before;
    if (exact) before.emplace(state_, island_);
    std::vector<PathEnd> start;
    store();
    for (const std::uint32_t i : island_.bodies) {
      state_.bodies.velocity[i] = {};
      state_.bodies.omega[i] = 0;
      // It strays from the way that it would have gone on.
      note_travel(state_, i, 0, h_, {}, {});
    }
    if (state_.observe.paths) start = path_ends(state_, island_.bodies);
    closed_ = exact && close_gaps();
    if (exact && !(closed_ && still_holds())) {
      before->restore(state_, island_);
      return false;
    }
    if (state_.observe.paths) record_hermite(state_, island_.bodies, 0, h_, start, result_);
    ++result_.substeps;
    result_.report.flowing = true;
    result_.step_memory = {.held = !exact};
    return true;
  }

  /// Whether the forces that held it in the last step do so now: then they act on, and nothing else happens.
  bool still_held() {
    Spare<std::vector<Velocity>> after;
    aim(kNearlyClosed, *after);
    last_impulses(solution_.lambda);
    solution_.residual = natural_map_residual(rows_->system, solution_.lambda);
    weigh(*after);
    if (!are_near()) return false;
    const double speed = std::max(left_, widest_gap() / h_);
    hold();
    result_.step_memory = {.held = 1};
    if (varying_) begin_at_rest();
    report(speed / gravity_);
    return true;
  }

  /// Bodies are so far in each other that they are still being pushed out, without any velocity.
  bool is_pressed() const {
    return std::any_of(island_.contacts.begin(), island_.contacts.end(), [&](std::uint32_t index) {
      const Contact& contact = state_.contacts[index];
      const double size =
          std::min(size_in_island(state_, contact.body_a), size_in_island(state_, contact.body_b));
      for (int i = 0; i < contact.manifold.count; ++i)
        if (contact.manifold.points[static_cast<std::size_t>(i)].separation < -kPressed * size) return true;
      return false;
    });
  }

  /// They stand still already, and their forces act on.
  void hold() {
    repeat_forces(state_, island_, h_);
    if (state_.observe.paths)
      record_hermite(state_, island_.bodies, 0, h_, path_ends(state_, island_.bodies), result_);
    ++result_.substeps;
    result_.report.flowing = true;
  }

  /// Gaps of what carries load, overlaps, and errors of joints. @return whether none are left
  bool close_gaps() {
    const double limit = result_.work_limit;
    result_.work_limit = result_.work.visits +
                         kClosingWork * usual_flow_work(state_) * static_cast<double>(island_.bodies.size());
    Spare<Assembly> rows;
    project_positions(state_, island_, h_, result_, *rows);
    result_.work_limit = limit;
    const auto is_open = [this](std::uint32_t index) {
      const Contact& contact = state_.contacts[index];
      for (int i = 0; i < contact.manifold.count; ++i)
        if (contact.points[static_cast<std::size_t>(i)].normal_impulse > 0 &&
            !(std::abs(contact.manifold.points[i].separation) <= state_.config.touch_tolerance))
          return true;
      return overlaps(state_, contact);
    };
    return std::none_of(island_.contacts.begin(), island_.contacts.end(), is_open) &&
           !joints_are_off(state_, island_, h_, kJoined);
  }

  /// Closing gaps moves corners past each other, and what carried load may do so no more: the next steps
  /// begin with forces that hold what is there now. @return whether there are any
  bool still_holds() {
    find_forces(0, kStopped);
    if (!is_exact()) return false;
    for (const std::uint32_t index : island_.contacts) {
      Contact& contact = state_.contacts[index];
      for (PointMemory& memory : contact.points) memory.total_normal = memory.total_friction = 0;
      contact.impulse = {};
    }
    for (const std::uint32_t slot : island_.joints)
      std::fill(std::begin(state_.joints[slot].row_impulse), std::end(state_.joints[slot].row_impulse), 0);
    store();
    return true;
  }

  bool is_exact() const { return solution_.status == SolveStatus::Solved && left_ <= kStill * gravity_; }

  WorldState& state_;
  const Island& island_;
  double h_;
  IslandResult& result_;
  bool varying_;
  double gravity_ = 0;  ///< what it does in a step [m/s]
  Spare<Assembly> rows_;
  bool searched_ = false;
  bool closed_ = false;  ///< gaps were closed
  Solution solution_;
  double left_ = 0;  ///< speed of the fastest body under the forces of `solution_` [m/s]
};

}  // namespace

bool is_held(const WorldState& state, const Island& island) {
  return std::all_of(island.bodies.begin(), island.bodies.end(), [&](std::uint32_t i) {
    return state.step_memory[i].held != 0 && state.bodies.velocity[i] == Vec2{} && state.bodies.omega[i] == 0;
  });
}

namespace {

/// Whether a contact touches, or carries load.
bool bears(const WorldState& state, const Contact& contact) {
  for (int i = 0; i < contact.manifold.count; ++i)
    if (is_touching(state, contact.manifold.points[i]) ||
        contact.points[static_cast<std::size_t>(i)].normal_impulse > 0)
      return true;
  return false;
}

/// Hashes of what each body of an island lies on while it does not move: where it is, what acts on it, what
/// touches it and what it is joined to, in any order and whichever island that is in.
void hash_support(const WorldState& state, const Island& island, std::vector<std::uint64_t>& of_body) {
  const BodyArrays& all = state.bodies;
  of_body.resize(island.bodies.size());
  for (std::size_t k = 0; k < of_body.size(); ++k) {
    const std::uint32_t i = island.bodies[k];
    Fnv1a hash;
    for (const double value :
         {all.position[i].x, all.position[i].y, all.angle[i], all.inverse_mass[i], state.acceleration[i].x,
          state.acceleration[i].y, state.angular_acceleration[i]})
      hash.add(value);
    of_body[k] = hash.value();
  }
  const auto add = [&](std::uint32_t body, std::uint32_t other, Fnv1a hash) {
    if (body == BodyId::kNone || state.local_index[body] < 0) return;
    if (other != BodyId::kNone)
      for (const double value : {all.position[other].x, all.position[other].y, all.angle[other]})
        hash.add(value);
    of_body[static_cast<std::size_t>(state.local_index[body])] += hash.value();
  };
  for (const std::uint32_t index : island.contacts) {
    const Contact& contact = state.contacts[index];
    if (!bears(state, contact)) continue;
    Fnv1a hash;
    hash.add(std::uint64_t{contact.shape_a} << 32 | contact.shape_b);
    hash.add(std::uint64_t{state.shapes[contact.shape_a].generation} << 32 |
             state.shapes[contact.shape_b].generation);
    add(contact.body_a, contact.body_b, hash);
    add(contact.body_b, contact.body_a, hash);
  }
  for (const std::uint32_t slot : island.joints) {
    const JointRecord& joint = state.joints[slot];
    Fnv1a hash;
    hash.add(std::uint64_t{slot} << 32 | joint.generation);
    for (const double value : {joint.def.motor_speed.value_or(0), joint.def.motor_limit}) hash.add(value);
    add(joint.def.a.index, joint.def.b.index, hash);
    add(joint.def.b.index, joint.def.a.index, hash);
  }
}

/// Whether it is one that may be stopped for being slow: not what is told to move, or is pushed by the user,
/// or has nothing to stop on.
bool may_be_slow(const WorldState& state, const Island& island) {
  const auto is_pushed = [&](std::uint32_t i) {
    return state.bodies.force[i] != Vec2{} || state.bodies.torque[i] != 0;
  };
  return !state.field && std::none_of(island.bodies.begin(), island.bodies.end(), is_pushed) &&
         !meets_motion(state, island) && !is_free(state, island);
}

}  // namespace

bool stop_if_slow(WorldState& state, const Island& island, double h, IslandResult& result) {
  const double most = state.config.sleep_speed;
  if (!(most > 0)) return false;
  for (const std::uint32_t i : island.bodies)
    if (state.step_memory[i].slow < kSlowFor) return false;
  if (!may_be_slow(state, island)) return false;
  Spare<std::vector<std::uint64_t>> support;
  hash_support(state, island, *support);
  const double speed = fastest_now(state, island);
  bool again = speed == 0, stopped = false;
  for (std::size_t k = 0; k < island.bodies.size(); ++k) {
    const std::uint32_t i = island.bodies[k];
    stopped |= state.step_memory[i].stopped != 0;
    again &= state.step_memory[i].stopped != 0 && state.support[i] == (*support)[k];
  }
  if (!again && (stopped || !(speed <= most))) return false;
  result.report.stepper = "time_stepping";
  ComingToRest(state, island, h, result).stop_slow(again);
  // New forces are other support.
  if (!again) hash_support(state, island, *support);
  for (std::size_t k = 0; k < island.bodies.size(); ++k) state.support[island.bodies[k]] = (*support)[k];
  return true;
}

void note_slowness(const WorldState& state, const Island& island, double h, IslandResult& result) {
  const double most = state.config.sleep_speed;
  if (!(most > 0) || result.step_memory.stopped != 0) return;
  result.step_memory.slow = 0;
  const double speed = fastest_now(state, island);
  // Where flow takes all energy out nothing moves, and yet it goes on.
  const bool moves = speed > 0 || result.report.flowing;
  if (!moves || !(speed <= most) || result.in_flight || !may_be_slow(state, island)) return;
  double before = kSlowFor;
  for (const std::uint32_t i : island.bodies) {
    const StepMemory& memory = state.step_memory[i];
    before = std::min(before, memory.stopped != 0 ? 0 : memory.slow);
  }
  result.step_memory.slow = std::min(before + h, kSlowFor);
}

RestLook come_to_rest(WorldState& state, const Island& island, double h, IslandResult& result) {
  if (!state.solver->exact) return RestLook::None;
  if (is_held(state, island)) return ComingToRest(state, island, h, result).run(0);
  const double more = std::sqrt(std::max(1.0, static_cast<double>(island.bodies.size()) / kUsualBodies));
  const int every = static_cast<int>(kEvery * more);
  if ((state.steps + island.bodies.front()) % static_cast<std::uint64_t>(every) != 0) return RestLook::None;
  return ComingToRest(state, island, h, result).run(every);
}

}  // namespace skerry
