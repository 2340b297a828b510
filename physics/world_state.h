// SPDX-License-Identifier: MIT
//
// The inside of a World: what the stages of a step share. Not for users.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "physics/contact.h"
#include "physics/ledger.h"
#include "physics/resting.h"
#include "physics/sleep.h"
#include "physics/stepping/kinematic.h"
#include "physics/stepping/stepper.h"
#include "physics/thread_pool.h"
#include "physics/world.h"

namespace skerry {

/// Position and velocity of one body, kept so that a step of its island can be done again.
struct BodyBackup {
  Vec2 position;
  double angle;
  Rot rotation;
  Vec2 velocity;
  double omega;
};

struct WorldState {
  WorldConfig config;
  Observe observe;

  // Bodies, by slot. `force` and `torque` are the user's for the next step.
  BodyArrays bodies;
  std::vector<std::string> names;
  std::vector<std::optional<double>> given_mass, given_inertia;
  std::vector<std::vector<std::uint32_t>> shapes_of;  ///< slots of each body's shapes, ascending
  std::vector<std::vector<std::uint32_t>> joints_of;
  std::vector<Vec2> centre;    ///< centre of mass in the frame of the body's definition [m]
  std::vector<double> radius;  ///< farthest point of any shape from the centre of mass [m]
  std::vector<std::uint32_t> free_bodies;

  std::vector<Drag> drag;                    ///< by body
  std::vector<PrescribedMotion> prescribed;  ///< by body; empty: none
  ForceField field;

  std::vector<ShapeRecord> shapes;
  std::vector<std::uint32_t> free_shapes;
  std::vector<JointRecord> joints;
  std::vector<std::uint32_t> free_joints;

  std::unique_ptr<BroadPhase> broad_phase;
  std::unique_ptr<ThreadPool> pool;
  IslandBuilder island_builder;
  std::vector<Contact> contacts;        ///< sorted by key; those of sleeping islands are in `sleepers`
  std::vector<IslandMemory> memories;   ///< sorted by key
  std::vector<RestingIsland> resting;   ///< sorted by key
  std::vector<StepMemory> step_memory;  ///< by body
  std::vector<PathPiece> step_paths;    ///< of the last step, by body, then in the order of time
  bool paths_known = false;             ///< they were recorded in the last step
  Sleepers sleepers;
  Ledger ledger;

  // The working set, as slots in ascending order.
  std::vector<std::uint32_t> awake;      ///< dynamic bodies that do not sleep
  std::vector<std::uint32_t> kinematic;  ///< all kinematic bodies
  std::vector<std::uint32_t> touched;    ///< bodies that the user changed since the last step; in any order

  // Of the current step; by body, but valid for those that were active in it only, unless said.
  std::vector<std::uint32_t> active;  ///< awake, moving or touched bodies, ascending
  std::vector<std::uint32_t> active_joints;
  std::vector<Vec2> acceleration;  ///< by body, where forces vary: at the beginning [m/s^2]
  std::vector<double> angular_acceleration;
  std::vector<MotionPath> paths;  ///< by body, of those with a prescribed motion
  std::vector<double> reach;  ///< bound on how far any point of the body moves in a step [m], for all bodies
  std::vector<double> travelled;          ///< how far it did at most [m]
  std::vector<std::int32_t> local_index;  ///< by body: number in its island, -1 for bodies that do not react
  std::vector<BodyBackup> backup;         ///< at the start of the step, for all bodies
  std::vector<Pair> pairs;
  std::vector<BoxUpdate> box_updates;
  std::vector<std::uint8_t> shape_moved;    ///< by shape: its box is new in this round
  std::vector<std::uint32_t> loose_shapes;  ///< shapes whose box in the broad phase is missing or out of date

  // Looked up by name once, when the world is made.
  const SolverEntry* solver = nullptr;
  const struct ImpactLawEntry* impact_law = nullptr;
  const StepperEntry* stepper = nullptr;

  StepReport report;
  double time = 0;
  std::uint64_t steps = 0;
};

/// Gives an empty broad phase the boxes of the last step. Their pairs are in the contact table already.
void fill_broad_phase(WorldState& state);

}  // namespace skerry
