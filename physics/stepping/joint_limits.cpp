// SPDX-License-Identifier: MIT
#include "physics/stepping/joint_limits.h"

#include <algorithm>
#include <cmath>

#include "physics/root.h"
#include "physics/stepping/free_flight.h"
#include "physics/stepping/touching.h"

namespace skerry {
namespace {

// Share of its largest force with which a motor is at that, and deviations up to which it is at its speed
// [m/s or rad/s, and of the speed].
constexpr double kAtLargest = 1 - 1e-9;
constexpr double kAtSpeed = 1e-3;
// A motor that has come to its limit stays there until it is farther away than what impacts that are found to
// some accuracy leave, in units of the slack of limits.
constexpr double kStalls = 1000;

/// Slack up to which a limit counts as reached [m or rad].
double reach_of(const WorldState& state, Vec2 a, Vec2 b) {
  return std::max(touch_tolerance(state, a), touch_tolerance(state, b));
}

/// Where a body that moves like `motion` is after a time `t` [s].
JointEnd end_at(const Motion& motion, double t) {
  const Motion then = later(motion, t);
  return {.p = then.p0, .q = Rot::from_angle(then.angle0), .angle = then.angle0, .v = {}};
}

/// Fastest in a time `h`: of the centre [m/s], and turning [rad/s].
double fastest(const Motion& m, double h) {
  return std::max(length(m.v), length(m.v + h * m.a));
}
double fastest_turn(const Motion& m, double h) {
  return std::max(std::abs(m.omega), std::abs(m.omega + h * m.alpha));
}

/// Bound of how fast the coordinate of a joint changes in a time `h` [m/s or rad/s].
double fastest_change(const JointRecord& joint, const Motion& a, const Motion& b, double h) {
  const double turn_a = fastest_turn(a, h), turn_b = fastest_turn(b, h);
  if (joint.def.kind == JointKind::Revolute) return turn_a + turn_b;
  const double centres = fastest(a, h) + fastest(b, h);
  const double arm_a = length(joint.local_a), arm_b = length(joint.local_b);
  const double apart = length(b.p0 - a.p0) + arm_a + arm_b + h * centres;
  const bool sliding = joint.def.kind == JointKind::Prismatic || joint.def.kind == JointKind::Wheel;
  return centres + turn_a * (arm_a + (sliding ? apart : 0)) + turn_b * arm_b;
}

}  // namespace

bool has_limits(const JointDef& def) {
  return def.kind == JointKind::Rope || def.lower || def.upper;
}

void note_stall(const WorldState& state, JointRecord& joint, double elapsed) {
  const JointDef& def = joint.def;
  joint.stalled = false;
  // The motor of a wheel acts on another coordinate than its limits.
  if (!def.motor_speed || def.motor_limit < kInfinity || !has_limits(def) || def.kind == JointKind::Wheel)
    return;
  const JointEnd a = joint_end(state, def.a.index, elapsed), b = joint_end(state, def.b.index, elapsed);
  const double value = joint_coordinate(joint, a, b).value, reach = kStalls * reach_of(state, a.p, b.p);
  joint.stalled = (def.lower && *def.motor_speed < 0 && value <= *def.lower + reach) ||
                  (def.upper && *def.motor_speed > 0 && value >= *def.upper - reach);
}

std::uint8_t reached_limits(const WorldState& state, const JointRecord& joint, double elapsed) {
  if (!has_limits(joint.def)) return 0;
  const JointEnd a = joint_end(state, joint.def.a.index, elapsed);
  const JointEnd b = joint_end(state, joint.def.b.index, elapsed);
  const double reach = reach_of(state, a.p, b.p);
  JointRows rows;
  const int count = joint_rows(joint, a, b, rows);
  std::uint8_t bits = 0;
  for (int k = 0; k < count; ++k) {
    const JointRow& row = rows[static_cast<std::size_t>(k)];
    if (row.kind != JointRowKind::Limit || row.error > reach) continue;
    if (row.rate <= state.config.rest_speed || row.error < -reach) bits |= 1u << k;
  }
  return bits;
}

std::optional<double> next_limit_time(const WorldState& state, const JointRecord& joint, const Motion& a,
                                      const Motion& b, std::uint8_t reached, double h) {
  if (!has_limits(joint.def)) return std::nullopt;
  JointRows rows;
  const auto rows_at = [&](double t) { return joint_geometry(joint, end_at(a, t), end_at(b, t), rows); };
  const int count = rows_at(0);
  const JointRows start = rows;
  const double change = fastest_change(joint, a, b, h), reach = reach_of(state, a.p0, b.p0);
  std::optional<double> first;
  for (int k = 0; k < count; ++k) {
    const auto row = static_cast<std::size_t>(k);
    if (start[row].kind != JointRowKind::Limit || (reached >> k & 1) != 0) continue;
    if (!(start[row].error <= h * change)) continue;
    const double until = first.value_or(h);
    // An angle is a parabola in time.
    const bool angle = joint.def.kind == JointKind::Revolute;
    const double value = start[row].error, sign = start[row].Jb[2];
    const double rate = sign * (b.omega - a.omega), bend = sign * (b.alpha - a.alpha);
    if (angle && value > reach) {
      const double t = first_root(value, rate, bend);
      if (t <= until) first = t;
      continue;
    }
    const auto slack = [&](double t) {
      if (angle) return value + t * (rate + 0.5 * t * bend);
      rows_at(t);
      return rows[row].error;
    };
    const std::optional<double> t = closing_time(slack, change, until, reach);
    if (t) first = t;
  }
  return first;
}

std::uint8_t held_rows_of(const WorldState& state, const JointRecord& joint, double elapsed,
                          std::uint8_t reached, bool whole) {
  const bool drives = joint.def.motor_speed && joint.def.motor_limit < kInfinity;
  if (reached == 0 && !drives) return 0;
  JointRows rows;
  const int count = joint_rows(joint, joint_end(state, joint.def.a.index, elapsed),
                               joint_end(state, joint.def.b.index, elapsed), rows);
  std::uint8_t bits = 0;
  for (int k = 0; k < count; ++k) {
    const JointRow& row = rows[static_cast<std::size_t>(k)];
    const double force = joint.row_force[k];
    bool held = false;
    if (row.kind == JointRowKind::Limit) held = (reached >> k & 1) != 0 && force > 0;
    if (row.kind == JointRowKind::Motor && row.most < kInfinity)
      held = std::abs(force) < kAtLargest * row.most &&
             (whole || std::abs(row.rate - row.speed) <= kAtSpeed * (1 + std::abs(row.speed)));
    if (held) bits |= 1u << k;
  }
  return bits;
}

bool has_motors(const WorldState& state, const Island& island) {
  return std::any_of(island.joints.begin(), island.joints.end(),
                     [&](std::uint32_t slot) { return state.joints[slot].def.motor_speed.has_value(); });
}

bool hold_passed_motors(WorldState& state, const Island& island, double elapsed) {
  bool any = false;
  for (const std::uint32_t slot : island.joints) {
    const JointRecord& joint = state.joints[slot];
    const JointDef& def = joint.def;
    if (!def.motor_speed) continue;
    if (def.motor_limit < kInfinity) {
      JointRows rows;
      const int count = joint_rows(joint, joint_end(state, def.a.index, elapsed),
                                   joint_end(state, def.b.index, elapsed), rows);
      for (int k = 0; k < count; ++k) {
        const JointRow& row = rows[static_cast<std::size_t>(k)];
        if (row.kind == JointRowKind::Motor && joint.row_force[k] * (row.rate - row.speed) > 0)
          state.held_rows[slot] |= 1u << k;
      }
    }
    any |= def.motor_limit == kInfinity || state.held_rows[slot] != 0;
  }
  return any;
}

}  // namespace skerry
