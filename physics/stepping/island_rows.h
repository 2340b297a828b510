// SPDX-License-Identifier: MIT
//
// From the contacts and joints of an island to the rows of its IslandSystem.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "physics/islands/island_builder.h"
#include "physics/islands/island_system.h"
#include "physics/narrowphase/manifold.h"

namespace skerry {

struct WorldState;

using Velocity = std::array<double, 3>;  ///< (vx, vy, omega)

/// Where a row came from.
struct RowOrigin {
  RowKind kind;
  bool joint;
  std::uint32_t index;                ///< contact or joint slot
  int point;                          ///< of the contact's manifold, or row of the joint
  double error;                       ///< separation of the point, or position error of the joint [m or rad]
  double stiffness = 0, damping = 0;  ///< of a joint's spring: the row is compliant then

  bool spring() const { return stiffness > 0 || damping > 0; }
  /// The same row of the same point or joint.
  bool is_same(const RowOrigin& other) const {
    return joint == other.joint && index == other.index && point == other.point && kind == other.kind;
  }
};

/// Rows with what they were made of. A spare one has those of the last time: `assemble` writes over them.
struct Assembly {
  IslandSystem system;
  std::vector<RowOrigin> origin;
  std::vector<double>
      drive;  ///< per row: velocity that comes from kinematic bodies, conveyor surfaces and motors [m/s]

  void drop_rows() {
    for (auto* numbers : {&system.b, &system.compliance, &drive}) numbers->clear();
    system.bodies.clear();
    system.positions.clear();
    system.rows.clear();
    origin.clear();
  }
};

/// What `assemble` is to take.
struct AssemblyRequest {
  /// Per contact of the island (same order): bit i set takes point i.
  const std::vector<std::uint8_t>* points = nullptr;
  /// Per contact: geometry to use instead of the contact's own manifold; same length as the island's
  /// contacts.
  const std::vector<Manifold>* manifolds = nullptr;
  /// Poses of the island's bodies, and their angles, for joint geometry, or null: the current ones.
  const std::vector<Transform>* poses = nullptr;
  const std::vector<double>* angles = nullptr;
  /// Which motors and springs are taken.
  enum class Actuators : std::uint8_t {
    None,
    Rigid,  ///< motors whose force has no limit
    All,    ///< bounds of motors are forces [N]: times the length of the piece they become impulses
  };
  Actuators actuators = Actuators::None;
  bool friction = false;
  double rope_slack = 0;  ///< ropes and limits with at most this slack are taken [m or rad]
  /// Slacks of angles count where the smaller of the two bodies ends [m].
  bool slack_at_ends = false;
  /// If given, per joint of the island: the limits that are taken (bit k: row k), whatever their slack.
  const std::vector<std::uint8_t>* limits = nullptr;
  /// If given: with the slack that they have after a time `ahead` [s] at these velocities of the island's
  /// bodies.
  const std::vector<Velocity>* velocities = nullptr;
  double ahead = 0;
  double elapsed = 0;  ///< since the beginning of the step [s], for kinematic bodies
};

/// Builds the rows: joints in slot order, then contacts in table order (Normal, Friction, Rolling for each
/// point). `b` is left zero.
void assemble(const WorldState& state, const Island& island, const AssemblyRequest& request, Assembly& out);
/// Impulses of `before` for `after`, which has the same rows and others among them: 0 for those.
void keep_known(const Assembly& before, const std::vector<double>& lambda, const Assembly& after,
                std::vector<double>& out);

/// Velocities of the island's bodies.
std::vector<Velocity> island_velocities(const WorldState& state, const Island& island);
void island_velocities(const WorldState& state, const Island& island, std::vector<Velocity>& v);
void store_velocities(WorldState& state, const Island& island, const std::vector<Velocity>& v);
/// Adds what the applied forces alone change in a time `h` [s].
void add_free_motion(const WorldState& state, const Island& island, double h, std::vector<Velocity>& v);

/// Relative velocity of row `i`, J v + drive.
inline double row_velocity(const Assembly& assembly, int i, const std::vector<Velocity>& v) {
  const Row& row = assembly.system.rows[i];
  double u = assembly.drive[i];
  if (row.a >= 0) u += along(row.Ja, v[row.a]);
  if (row.b >= 0) u += along(row.Jb, v[row.b]);
  return u;
}

/// The direction in which a row pushes b with an impulse > 0.
inline Vec2 push_on_b(const Row& row) {
  return row.b >= 0 ? Vec2{row.Jb[0], row.Jb[1]} : Vec2{-row.Ja[0], -row.Ja[1]};
}

/// What kinematic bodies, conveyors and motors do with these impulses [J].
double work_of_drive(const Assembly& assembly, const std::vector<double>& lambda);
/// The most that it may be over a time `h` [s] [J]: rows have the velocities of ground from when they were
/// made, `elapsed` [s] in the step, and it may turn, or change its speed.
double most_of_drive(const WorldState& state, const Assembly& assembly, const std::vector<double>& lambda,
                     double elapsed, double h);

/// Brings the manifolds of the island's contacts to the current poses, each within its own margin.
/// @param elapsed  since the beginning of the step [s], for kinematic bodies
/// @return how many were right already
int update_manifolds(WorldState& state, const Island& island, double elapsed, NarrowPhaseStats& stats);

}  // namespace skerry
