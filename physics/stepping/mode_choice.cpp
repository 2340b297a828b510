// SPDX-License-Identifier: MIT
#include "physics/stepping/mode_choice.h"

#include <algorithm>
#include <cmath>

#include "physics/joint_rows.h"
#include "physics/stepping/touching.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

using State = AccelerationProblem::State;

std::optional<ContactKinematics> point_kinematics(const WorldState& state, const AccelerationProblem& problem,
                                                  const Contact& contact, int i, double elapsed,
                                                  const State& y, std::optional<ContactFeatures>& features) {
  features =
      features_of(contact, state.shapes[contact.shape_a].shape, pose_at(state, contact.body_a, elapsed),
                  state.shapes[contact.shape_b].shape, pose_at(state, contact.body_b, elapsed), i);
  if (!features) return std::nullopt;
  return kinematics_of(*features, problem.motion(contact.body_a, elapsed, y),
                       problem.motion(contact.body_b, elapsed, y));
}

class ModeChoice {
 public:
  ModeChoice(const WorldState& state, const Island& island, const AccelerationProblem& problem,
             double elapsed, const std::vector<Onset>& onsets, double ahead, ContactMode& mode,
             ModeForces& forces)
      : state_(state),
        island_(island),
        problem_(problem),
        elapsed_(elapsed),
        onsets_(onsets),
        ahead_(ahead),
        mode_(mode),
        forces_(forces),
        still_(1e-11 * (1 + speed_bound(state, island))) {}

  bool choose() {
    // The accelerations of the mode before.
    if (ahead_ > 0) accelerations_ = forces_.acceleration;
    mode_ = {};
    const State y = problem_.gather(mode_);
    for (std::size_t k = 0; k < island_.contacts.size(); ++k) {
      if (!add_contact(k, y)) return false;
    }
    for (std::size_t j = 0; j < island_.joints.size(); ++j) add_rows(j, y);
    if (mode_.points.empty() && mode_.free()) return true;
    return problem_.choose(mode_, elapsed_ + ahead_, state_ahead()) && is_consistent();
  }

 private:
  State state_ahead() const {
    State y = problem_.gather(mode_);
    for (std::size_t k = 0; k < accelerations_.size(); ++k) {
      for (std::size_t c = 0; c < 3; ++c) {
        double &place = y[6 * k + c], &speed = y[6 * k + 3 + c];
        place += ahead_ * (speed + 0.5 * ahead_ * accelerations_[k][c]);
        speed += ahead_ * accelerations_[k][c];
      }
    }
    return y;
  }

  /// Points of a contact that touch and do not part, with their friction. @return false if its geometry is
  /// not what the manifold says
  bool add_contact(std::size_t k, const State& y) {
    const Contact& contact = state_.contacts[island_.contacts[k]];
    const std::size_t first = mode_.points.size();
    double sliding = 0;
    bool held = false;
    for (int i = 0; i < contact.manifold.count; ++i) {
      const ManifoldPoint& point = contact.manifold.points[static_cast<std::size_t>(i)];
      if (!is_touching(state_, point)) continue;
      std::optional<ContactFeatures> features;
      const std::optional<ContactKinematics> kinematics =
          point_kinematics(state_, problem_, contact, i, elapsed_, y, features);
      if (features && features->past) continue;
      // Of two corners that have passed each other by a hair nothing is left.
      if (!kinematics && normal_velocity(state_, contact, point.position, elapsed_) > still_) continue;
      if (!kinematics || std::abs(kinematics->gap - point.separation) > 1e-6) return false;
      if (kinematics->gap_rate > still_) continue;
      mode_.points.push_back({k, i, point.feature, *features, false});
      sliding = kinematics->sliding - contact.surface_velocity;
      held |= contact.points[static_cast<std::size_t>(i)].sticking;
    }
    const int count = static_cast<int>(mode_.points.size() - first);
    if (count == 0) return true;
    const auto add_grip = [&](bool rolling, double mu, double hold, double surface, double speed) {
      if (!(mu > 0)) return;
      Grip grip;
      grip.contact = k;
      grip.rolling = rolling;
      grip.mu = mu;
      grip.hold = hold;
      grip.surface = surface;
      // What stuck before moves by rounding only; what static friction may hold is still below the speed that
      // counts as rest.
      const double limit = hold > mu ? state_.config.rest_speed : held ? 1e-9 : 0.1 * still_;
      grip.sign = std::abs(speed) <= limit ? 0 : speed > 0 ? 1 : -1;
      for (const Onset& onset : onsets_) {
        if (onset.contact == k && onset.rolling == rolling && grip.sign == 0) grip.sign = onset.sign;
      }
      grip.count = count;
      for (int i = 0; i < count; ++i) grip.points[static_cast<std::size_t>(i)] = static_cast<int>(first) + i;
      mode_.grips.push_back(grip);
    };
    add_grip(false, contact.friction, contact.static_friction, contact.surface_velocity, sliding);
    add_grip(true, contact.rolling_resistance, contact.rolling_resistance, 0,
             problem_.motion(contact.body_b, elapsed_, y).omega -
                 problem_.motion(contact.body_a, elapsed_, y).omega);
    return true;
  }

  /// Rows of a joint: what holds always, limits when reached and not about to slacken, motors by how they
  /// compare with their speed. A motor that is stalled holds for its limit.
  void add_rows(std::size_t j, const State& y) {
    const JointRecord& joint = state_.joints[island_.joints[j]];
    const JointEnd b = problem_.joint_end(joint.def.b.index, elapsed_, y);
    JointRows rows;
    const int count = joint_rows(joint, problem_.joint_end(joint.def.a.index, elapsed_, y), b, rows);
    for (int i = 0; i < count; ++i) {
      const JointRow& row = rows[static_cast<std::size_t>(i)];
      JointRowState state = JointRowState::Holds;
      if (row.kind == JointRowKind::Spring) state = JointRowState::Off;
      if (row.kind == JointRowKind::Limit) {
        const bool reached =
            !joint.stalled && row.error <= touch_tolerance(state_, b.p) && row.rate <= still_;
        state = reached ? JointRowState::Holds : JointRowState::Off;
      }
      // Drift while it held is taken out by the projection of velocities, which knows motors by this.
      if (row.kind == JointRowKind::Motor && row.most < kInfinity) {
        const double missing = row.speed - row.rate;
        const bool held = std::abs(joint.row_force[i]) < row.most * (1 - 1e-9);
        if (std::abs(missing) > (held ? 1e-9 * (1 + std::abs(row.speed)) : still_))
          state = missing > 0 ? JointRowState::Forward : JointRowState::Backward;
      }
      mode_.rows.push_back({j, i, row.kind, state});
    }
  }

  /// Of two points that pull without the resistance to rolling which they share, the other one carries all,
  /// and that resistance the rest. @return whether there are any
  bool lean_on_others(double slack) {
    bool any = false;
    for (const Grip& grip : mode_.grips) {
      if (!grip.rolling || grip.sign != 0 || grip.count < 2) continue;
      const auto at = [&](std::size_t i) { return static_cast<std::size_t>(grip.points[i]); };
      for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
        if (!mode_.points[at(i)].closed || !mode_.points[at(1 - i)].closed) continue;
        if (!(forces_.point_force[at(i)] < -slack)) continue;
        mode_.points[at(i)].closed = false;
        any = true;
      }
    }
    return any;
  }

  /// The forces of the mode must be of the kind the mode assumes.
  bool is_consistent() {
    if (mode_.free()) return true;
    if (!problem_.evaluate(mode_, elapsed_, problem_.gather(mode_), forces_)) return false;
    const double slack = 1e-8 * forces_.scale;
    // Each time at least one point fewer is closed.
    if (lean_on_others(slack)) return is_consistent();
    for (std::size_t p = 0; p < mode_.points.size(); ++p) {
      if (forces_.point_force[p] < -slack) return false;
    }
    for (std::size_t k = 0; k < mode_.grips.size(); ++k) {
      if (mode_.grips[k].sign == 0 && std::abs(forces_.grip_force[k]) > forces_.grip_limit[k] + slack)
        return false;
    }
    for (std::size_t i = 0; i < mode_.rows.size(); ++i) {
      if (mode_.rows[i].state != JointRowState::Holds) continue;
      if (mode_.rows[i].kind == JointRowKind::Limit && forces_.row_force[i] < -slack) return false;
      if (mode_.rows[i].kind == JointRowKind::Motor &&
          std::abs(forces_.row_force[i]) > forces_.rows[i].most + slack) {
        return false;
      }
    }
    return true;
  }

  const WorldState& state_;
  const Island& island_;
  const AccelerationProblem& problem_;
  const double elapsed_;
  const std::vector<Onset>& onsets_;
  const double ahead_;
  std::vector<std::array<double, 3>> accelerations_;
  ContactMode& mode_;
  ModeForces& forces_;
  const double still_;  ///< slower than this is not moving [m/s]
};

}  // namespace

double speed_bound(const WorldState& state, const Island& island) {
  double fastest = 0;
  for (const std::uint32_t i : island.bodies) {
    fastest = std::max(fastest,
                       length(state.bodies.velocity[i]) + std::abs(state.bodies.omega[i]) * state.radius[i]);
  }
  return fastest;
}

double free_gap_acceleration(const WorldState& state, const AccelerationProblem& problem,
                             const Contact& contact, int point, double elapsed, const State& y) {
  std::optional<ContactFeatures> features;
  const std::optional<ContactKinematics> k =
      point_kinematics(state, problem, contact, point, elapsed, y, features);
  if (!k) return 0;
  const auto external = [&](std::uint32_t body) {
    if (state.local_index[body] < 0) return Vec2{};
    return state.acceleration[body] +
           state.angular_acceleration[body] * perp(k->position - state.bodies.position[body]);
  };
  return dot(k->normal, external(contact.body_b) - external(contact.body_a)) + k->normal_bias;
}

bool choose_mode(const WorldState& state, const Island& island, const AccelerationProblem& problem,
                 double elapsed, const std::vector<Onset>& onsets, double ahead, ContactMode& mode,
                 ModeForces& forces) {
  return ModeChoice(state, island, problem, elapsed, onsets, ahead, mode, forces).choose();
}

}  // namespace skerry
