// SPDX-License-Identifier: MIT
#include "physics/stepping/mode_events.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "physics/joint_rows.h"
#include "physics/root.h"
#include "physics/stepping/chain_side.h"
#include "physics/stepping/flush_faces.h"
#include "physics/stepping/free_flight.h"
#include "physics/stepping/joint_limits.h"
#include "physics/stepping/touching.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

using State = AccelerationProblem::State;

// Forces that are beyond their bound by less, in large forces of the system, are at it.
constexpr double kAtBound = 1e-8;
// What comes back is missed where it is below zero by less: forces in large ones of the system, other things
// [m, m/s, rad, rad/s].
constexpr double kNoDip = 1e-10;
// Corners this near to each other are one, and their points have other names [m].
constexpr double kPassing = 1e-7;
// What one gap of two shapes costs (see ModeEvents::work).
constexpr double kWorkOfGap = 1;
// Sine of the turn from a segment to the next below which they have no ridge between them.
constexpr double kFlat = 1e-9;

/// How far it is at least to a segment of a chain that reports nothing, up to the margin: a corner comes down
/// on its face, or from beyond one of its ends over it [m].
double way_to_segment(const WorldState& state, const Contact& contact, const Transform& a,
                      const Transform& b) {
  const ChainSide side = chain_side(state, contact);
  const Transform &chain = side.of_a ? a : b, &other = side.of_a ? b : a;
  const auto index = static_cast<std::size_t>(contact.child);
  const std::vector<Vec2>& corners = side.chain.vertices;
  const Vec2 from = corners[index], normal = side.chain.normals[index], along = -perp(normal);
  const double extent = length(corners[(index + 1) % corners.size()] - from);
  double way = contact.margin;
  for (const Vec2 corner : side.other.vertices) {
    const Vec2 p = inverse_rotate(chain.q, to_world(other, corner) - chain.p) - from;
    const double height = dot(normal, p) - side.other.radius, x = dot(along, p);
    const double beyond = std::max(-x, x - extent);
    if (height >= 0 || beyond > 0) way = std::min(way, std::max(height, beyond));
  }
  // Deeper by less it is still seen.
  return std::max(way, 0.25 * half_width(side.other));
}

}  // namespace

const Contact& ModeEvents::contact_at(std::size_t k) const {
  return state_.contacts[island_.contacts[k]];
}

bool ModeEvents::is_loaded(const Grip& grip) const {
  for (int i = 0; i < grip.count; ++i) {
    if (mode_.points[static_cast<std::size_t>(grip.points[static_cast<std::size_t>(i)])].closed) return true;
  }
  return false;
}

std::vector<ModeWatch> ModeEvents::watches(const ModeForces& forces) const {
  std::vector<ModeWatch> out;
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
    const bool stalled = state_.joints[island_.joints[mode_.rows[i].joint]].stalled;
    if (mode_.rows[i].kind == JointRowKind::Limit && !stalled) out.push_back({MotionEventKind::Limit, i});
    if (mode_.rows[i].kind == JointRowKind::Motor && forces.rows[i].most < kInfinity)
      out.push_back({MotionEventKind::Motor, i});
  }
  return out;
}

double ModeEvents::value(const ModeWatch& watch, const ModeForces& forces) const {
  const std::size_t i = watch.index;
  switch (watch.kind) {
    case MotionEventKind::Release:
      return forces.point_force[i] + 1e-14 * forces.scale;
    case MotionEventKind::Feature:
      return forces.points[i].range + kBeyondCorner;
    case MotionEventKind::Slip:
      return forces.grip_limit[i] - std::abs(forces.grip_force[i]) + 1e-14 * forces.scale;
    case MotionEventKind::Stick:
      return mode_.grips[i].sign * forces.grip_speed[i];
    case MotionEventKind::Motor: {
      const JointRow& row = forces.rows[i];
      if (mode_.rows[i].state == JointRowState::Forward) return row.speed - row.rate;
      if (mode_.rows[i].state == JointRowState::Backward) return row.rate - row.speed;
      return row.most - std::abs(forces.row_force[i]) + 1e-14 * forces.scale;
    }
    default:
      return mode_.rows[i].state == JointRowState::Holds ? forces.row_force[i] + 1e-14 * forces.scale
                                                         : forces.rows[i].error;
  }
}

/// True if what falls to zero is a force.
bool ModeEvents::is_force(const ModeWatch& watch) const {
  switch (watch.kind) {
    case MotionEventKind::Release:
    case MotionEventKind::Slip:
      return true;
    case MotionEventKind::Motor:
    case MotionEventKind::Limit:
      return mode_.rows[watch.index].state == JointRowState::Holds;
    default:
      return false;
  }
}

/// True if a point touches without parting: it was released a moment ago, or rests beside.
bool ModeEvents::lingers(const Contact& contact, double elapsed) const {
  for (int i = 0; i < contact.manifold.count; ++i) {
    const ManifoldPoint& point = contact.manifold.points[static_cast<std::size_t>(i)];
    if (is_touching(state_, point) &&
        std::abs(normal_velocity(state_, contact, point.position, elapsed)) < 1e-8) {
      return true;
    }
  }
  return false;
}

/// Smallest separation of two shapes at these poses, of a chain that of one segment, closed points left out;
/// the contact's margin if there is none.
double ModeEvents::open_gap(const Contact& contact, int child, const Transform& a, const Transform& b) const {
  const Manifold manifold =
      contact_manifold(child, state_.shapes[contact.shape_a].shape, a, state_.shapes[contact.shape_b].shape,
                       b, contact.margin, nullptr, nullptr);
  work_ += kWorkOfGap;
  const auto is_between = [&](const Contact& other) {
    return other.shape_a == contact.shape_a && other.shape_b == contact.shape_b && other.child == child;
  };
  double smallest = contact.margin;
  for (int i = 0; i < manifold.count; ++i) {
    const ManifoldPoint& point = manifold.points[static_cast<std::size_t>(i)];
    const bool closed = std::any_of(mode_.points.begin(), mode_.points.end(), [&](const ModePoint& p) {
      return p.closed && p.feature == point.feature && is_between(contact_at(p.contact));
    });
    if (!closed) smallest = std::min(smallest, point.separation);
  }
  return smallest;
}

/// The smallest one that the segments beyond the ridges of a chain's segment have: its corner goes over from
/// one to the other as it closes, and is seen by neither when it has sunk in.
double ModeEvents::open_gap_beside(const Contact& contact, const Transform& a, const Transform& b) const {
  const Shape& chain = chain_side(state_, contact).chain;
  const int segments = static_cast<int>(chain.normals.size());
  const auto normal = [&](int child) { return chain.normals[static_cast<std::size_t>(child)]; };
  double smallest = contact.margin;
  for (const int way : {-1, 1}) {
    int child = contact.child + way;
    if (chain.closed) child = (child + segments) % segments;
    if (child < 0 || child >= segments || child == contact.child) continue;
    const bool ridge = way * cross(normal(contact.child), normal(child)) < -kFlat;
    if (ridge) smallest = std::min(smallest, open_gap(contact, child, a, b));
  }
  return smallest;
}

/// Largest speed at which any gap of a contact can change within `h` of constrained motion [m/s]: that of the
/// bodies against each other, as what goes and turns together keeps its gaps.
double ModeEvents::gap_speed(const Contact& contact, double elapsed, double h,
                             const ModeForces& forces) const {
  const Motion a = free_flight(state_, contact.body_a, elapsed),
               b = free_flight(state_, contact.body_b, elapsed);
  const Vec2 apart = b.p0 - a.p0, v = b.v - a.v;
  const double spin = b.omega - a.omega;
  // They meet no farther out than where the other one is.
  const auto radius = [&](std::uint32_t body) {
    return body == BodyId::kNone ? kInfinity : state_.radius[body];
  };
  const double of_a = radius(contact.body_a), of_b = radius(contact.body_b);
  // Of what one of them has at its own centre against the other.
  const auto fastest = [&](Vec2 at_centre, double omega, double own, double other) {
    const double r = std::min(own, length(apart) + other);
    return length(at_centre) + (spin == 0 ? 0 : std::abs(spin) * r) + h * std::abs(omega) * length(v);
  };
  double speed = 1e-9 + std::min(fastest(v - a.omega * perp(apart), a.omega, of_b, of_a),
                                 fastest(v - b.omega * perp(apart), b.omega, of_a, of_b));
  for (const auto& [body, m] : {std::pair{contact.body_a, &a}, std::pair{contact.body_b, &b}}) {
    double acceleration = length(m->a), angular = std::abs(m->alpha);
    const int k = body == BodyId::kNone ? -1 : state_.local_index[body];
    if (k >= 0) {
      const std::array<double, 3>& f = forces.acceleration[static_cast<std::size_t>(k)];
      acceleration = std::max(acceleration, std::hypot(f[0], f[1]));
      angular = std::max(angular, std::abs(f[2]));
    }
    const double arm = length(apart) + std::min(of_a, of_b);
    speed += h * (acceleration + (angular == 0 ? 0 : angular * arm));
  }
  return speed;
}

FlightEnd ModeEvents::end_of_flight(double elapsed, double length) const {
  FlightEnd end{length};
  for (std::size_t k = 0; k < island_.contacts.size(); ++k) {
    const Contact& contact = contact_at(k);
    const Motion a = free_flight(state_, contact.body_a, elapsed),
                 b = free_flight(state_, contact.body_b, elapsed);
    double from = 0;
    if (lingers(contact, elapsed)) {
      const double tolerance = touch_tolerance(state_, state_.bodies.position[contact.body_b]);
      from = 1e-6 * end.length;
      double gap = open_gap(contact, contact.child, a.at(from), b.at(from));
      while (std::abs(gap) <= tolerance && from < end.length) {
        from = std::min(2 * from, end.length);
        gap = open_gap(contact, contact.child, a.at(from), b.at(from));
      }
      if (gap < -tolerance) {
        end.length = from;
        end.landing = &contact;
        continue;
      }
      if (from >= end.length) continue;
    }
    const ImpactTime impact =
        landing_time(state_, contact, later(a, from), later(b, from), end.length - from);
    if (!impact.hit) continue;
    end.length = from + impact.t;
    end.landing = &contact;
  }
  for (const std::uint32_t slot : island_.joints) {
    const JointRecord& joint = state_.joints[slot];
    const std::optional<double> reached =
        next_limit_time(state_, joint, free_flight(state_, joint.def.a.index, elapsed),
                        free_flight(state_, joint.def.b.index, elapsed), 0, end.length);
    if (!reached) continue;
    end.length = *reached;
    end.landing = nullptr;
    end.limit = &joint;
  }
  return end;
}

void ModeEvents::note_stage(double t, const std::vector<ModeWatch>& watched, const ModeForces& forces,
                            StageValues& stages) const {
  if (!stages.wants(t)) return;
  const std::span<double> values = stages.add(t, watched.size());
  for (std::size_t i = 0; i < watched.size(); ++i) values[i] = value(watched[i], forces);
}

bool ModeEvents::find(RungeKutta& method, const std::vector<ModeWatch>& watched, double elapsed,
                      const ModeForces& begin, const ModeForces& end, const StageValues& stages,
                      ModeEvent& event) const {
  return find_roots(method, watched, begin, end, stages, event) &&
         find_landings(method, elapsed, begin, event);
}

bool ModeEvents::find_roots(RungeKutta& method, const std::vector<ModeWatch>& watched,
                            const ModeForces& begin, const ModeForces& end, const StageValues& stages,
                            ModeEvent& event) const {
  State y;
  ModeForces forces;
  for (std::size_t i = 0; i < watched.size(); ++i) {
    const ModeWatch& watch = watched[i];
    double high = value(watch, end), low = value(watch, begin), to = event.theta;
    const auto at = [&](double theta) {
      if (!method.prepare_dense()) return 0.0;
      method.at(theta, y);
      if (!problem_.evaluate(mode_, method.begin() + theta * method.length(), y, forces)) return 0.0;
      return value(watch, forces);
    };
    if (low > 0) {
      const double depth = kNoDip * (is_force(watch) ? begin.scale : 1);
      if (const std::optional<double> below = stages.dip(i, low, high, to, depth, std::ref(at))) {
        to = *below;
        high = at(to);
      }
    }
    if (!(high < 0)) continue;
    if (!method.prepare_dense()) return false;
    if (event.found && to == event.theta && (high = at(event.theta)) >= 0) continue;
    double from = 0;
    if (!(low > 0)) {
      // It begins at zero: look for the moment from which on it was positive.
      from = 1e-4;
      while (from < event.theta && !((low = at(from)) > 0)) from *= 4;
      if (!(low > 0)) {
        // A force that stays at its bound, as all those of a body that is wedged may.
        if (is_force(watch) && high > -kAtBound * begin.scale) continue;
        const bool of_contact = watch.kind == MotionEventKind::Release ||
                                watch.kind == MotionEventKind::Slip || watch.kind == MotionEventKind::Stick;
        if (!of_contact) return false;
        // One that falls from it at once got there together with another one, whose event it was.
        if (event.found && event.theta <= from) continue;
        event.theta = 0;
        event.watch = watch;
        event.found = true;
        continue;
      }
    }
    event.theta = falling_root(at, from, low, to, high);
    event.watch = watch;
    event.found = true;
  }
  return true;
}

bool ModeEvents::find_landings(RungeKutta& method, double elapsed, const ModeForces& begin,
                               ModeEvent& event) const {
  State y(6 * island_.bodies.size());  // of which only places are filled in
  for (std::size_t k = 0; k < island_.contacts.size(); ++k) {
    const Contact& contact = contact_at(k);
    const double span = event.theta * method.length();
    const double speed = gap_speed(contact, elapsed, span, begin);
    const auto pose = [&](std::uint32_t body, double time, const State& at) {
      const BodyMotion m = problem_.motion(body, time, at);
      return Transform{m.p, m.q};
    };
    const Transform a_now = pose_at(state_, contact.body_a, elapsed),
                    b_now = pose_at(state_, contact.body_b, elapsed);
    const double now = open_gap(contact, contact.child, a_now, b_now);
    // What comes to a side of a valley from beyond its end is not seen before, however near it is; nor what
    // turns over a ridge, while the other side sees it.
    const bool chain = is_on_chain(state_, contact);
    const double within = 1.5 * span * speed;
    const bool unseen =
        chain && (!(now < contact.margin) || open_gap_beside(contact, a_now, b_now) <= within);
    if (now > within && !unseen) continue;
    if (!method.prepare_dense()) return false;
    const auto gap = [&](double t) {
      for (const std::uint32_t body : {contact.body_a, contact.body_b}) {
        const int place = body == BodyId::kNone ? -1 : state_.local_index[body];
        if (place >= 0) method.at(t / method.length(), 6 * static_cast<std::size_t>(place), 3, y);
      }
      return open_gap(contact, contact.child, pose(contact.body_a, method.begin() + t, y),
                      pose(contact.body_b, method.begin() + t, y));
    };
    const auto way = [&](double t, double value) {
      if (!chain) return value;
      const Transform a = pose(contact.body_a, method.begin() + t, y),
                      b = pose(contact.body_b, method.begin() + t, y);
      const double beside = std::max(open_gap_beside(contact, a, b), 0.0);
      return std::min(value < contact.margin ? value : way_to_segment(state_, contact, a, b), beside);
    };
    const double tolerance = touch_tolerance(state_, state_.bodies.position[contact.body_b]);
    const std::optional<double> closes =
        closing_time(gap, way, speed, span, lingers(contact, elapsed) ? tolerance : 1e-14);
    if (!closes) continue;
    // Two corners that pass each other meet on the way: that is no landing.
    const bool passes = event.found && event.watch.kind == MotionEventKind::Feature &&
                        mode_.points[event.watch.index].contact == k;
    if (passes && (span - *closes) * speed <= kPassing) continue;
    event.found = true;
    event.theta = *closes / method.length();
    event.watch = {MotionEventKind::Landing, k};
  }
  return true;
}

}  // namespace skerry
