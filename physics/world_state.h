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

/// Forces of a joint at the start of a step.
struct JointStart {
  std::array<double, kMaxJointRows> row_force{};  ///< [N or N m]
  std::uint64_t begun = 0;                        ///< number of that step, 1 for the first; 0: none
};

/// Position and velocity of one body, kept so that a step of its island can be done again.
struct BodyBackup {
  Vec2 position;
  double angle;
  Rot rotation;
  Vec2 velocity;
  double omega;
};

/// How far a body went in the last try of a step, and where it was then.
struct Went {
  double travelled, strayed;  ///< [m]
  Vec2 position;
  double angle;
};

/// What a contact is between, in a table that is small enough to look through at every step.
struct ContactLink {
  std::uint32_t body_a = 0, body_b = 0, shape_a = 0, shape_b = 0;
  std::int32_t child = 0;
  bool sensor = false;
  bool linked = false;
  bool touched = false;

  Pair pair() const { return {shape_a, shape_b}; }
  ContactKey key() const { return {shape_a, shape_b, child}; }
};

inline ContactLink link_of(const Contact& contact) {
  return {contact.body_a, contact.body_b, contact.shape_a, contact.shape_b,
          contact.child,  contact.sensor, contact.linked,  contact.touched};
}

/// What the contacts of an island add to the report of a step.
struct IslandTotals {
  int points = 0;  ///< of linked contacts
  int touching = 0, touching_points = 0;
  double normal_impulse = 0, friction_impulse = 0;  ///< of the step, impacts included [N s]
  double worst_penetration = 0;                     ///< [m]
};

/// What a step of an island produced.
struct IslandOutcome {
  IslandResult result;
  IslandTotals totals;
  std::uint64_t rest_key = 0;  ///< of its entry in `WorldState::resting`
};

/// An island with its last step; it stays from step to step while the graph of contacts and joints does. Most
/// islands of a falling pile are bodies that fly alone, and loops over all of them should not fetch what such
/// a body has no use for.
struct SteppedIsland {
  Island island;
  std::unique_ptr<IslandOutcome> outcome;  ///< means nothing, and may be null, where it `flew_alone`
  /// One body, nothing to meet, and nothing to tell but that: flown in closed form.
  bool flew_alone = false;
  /// Nothing of it or around it changed since a step that was already known to change nothing.
  bool kept = false;
  bool again = false;  ///< stepped in this round, which is not the first

  IslandResult& result() const { return outcome->result; }
  /// For a step that is to be made: an outcome without anything in it.
  void begin() {
    if (outcome == nullptr)
      outcome = std::make_unique<IslandOutcome>();
    else
      outcome->result.clear();
    flew_alone = kept = false;
  }
};

/// How a body moves in a step while nothing strikes it that was not foreseen: first in free flight; struck in
/// flow and off that way, as the last round moved it.
struct Way {
  Vec2 v, a;  ///< [m/s], [m/s^2]
  double omega = 0, alpha = 0;
};

/// How two bodies stand to each other; the numbers are known if one of them is fast.
struct PairLook {
  double gap = 0;      ///< of their boxes where the step begins [m]
  double nearest = 0;  ///< bound on that gap while both go their ways [m]
  std::uint32_t body_a = 0, body_b = 0;
  bool alike = false;
  bool may_touch = false;   ///< filters and joints let them
  bool chain = false;       ///< one of the two shapes is one
  bool may_strike = false;  ///< a blow between the two may take one of them off its way
};

/// Counters of a chunk of contacts.
struct LinkCount {
  NarrowPhaseStats narrow;
  int reused = 0;
  bool relinked = false;                 ///< a contact became linked, or ceased to be
  std::vector<std::uint32_t> newly;      ///< bodies of contacts that became linked after the first round
  std::vector<std::uint32_t> disturbed;  ///< bodies at rest on something that moved
};

/// What a step needs for itself; here, so that the next step finds the memory.
struct StepScratch {
  std::vector<std::uint8_t> dirty;    ///< by body, after the first round: its island steps again
  std::vector<std::uint32_t> others;  ///< active bodies that are not awake ones
  std::vector<ContactKey> wanted;     ///< contacts of the pairs
  std::vector<Pair> distant;          ///< pairs of fast bodies that will not meet, as far as is known
  std::vector<Pair> more;             ///< pairs of boxes that grew
  std::vector<PairLook> looks;        ///< at `WorldState::pairs`, in the first round
  std::vector<std::uint32_t> left;    ///< bodies whose boxes have to grow
  std::vector<int> segments;          ///< of a chain
  std::vector<Contact> lost;          ///< touching contacts whose boxes parted
  /// Where bodies were that a prescribed motion put elsewhere.
  std::vector<std::pair<std::uint32_t, BodyBackup>> before_motion;
  bool motion_breaks = false;             ///< a prescribed motion has a break in this step
  bool motion_jumps = false;              ///< one jumps where it begins or ends
  std::vector<SteppedIsland> last_round;  ///< islands of the round before
  std::vector<std::size_t> to_step;       ///< islands of this round
  std::vector<std::size_t> pieces;        ///< of it, that a thread takes at a time
  std::vector<RestingIsland> resting;     ///< of the next step
  std::vector<IslandMemory> memories;     ///< of the next step
  std::vector<LinkCount> counts;          ///< by chunk of contacts
  std::vector<IslandEdge> edges;
  std::vector<Island> graph;  ///< islands in the making
};

/// How a body moves while nothing touches it: what two bodies do to their distance is little where both fly
/// alike, but that is worth a look only where one of them is fast.
enum class FlightKind : std::uint8_t {
  Bent,  ///< drag or a field acts on it, or somebody prescribes where it goes
  Slow,
  Fast,  ///< its reach is more than a few contact margins
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
  std::vector<Vec2> centre;       ///< centre of mass in the frame of the body's definition [m]
  std::vector<double> radius;     ///< farthest point of any shape from the centre of mass [m]
  std::vector<double> thickness;  ///< smallest half width of any shape [m]
  /// How far a body will stray from free flight, by the last step [m]: 0 where nothing struck it, infinite
  /// where something may have and its island did not flow.
  std::vector<double> stray_guess;
  std::vector<std::uint32_t> free_bodies;

  std::vector<Drag> drag;                    ///< by body
  std::vector<Wrench> applied;               ///< by body: the user's in the last step
  std::vector<PrescribedMotion> prescribed;  ///< by body; empty: none
  ForceField field;

  std::vector<ShapeRecord> shapes;
  ShapePool shape_pool;
  std::vector<std::uint32_t> free_shapes;
  std::vector<JointRecord> joints;
  std::vector<std::uint32_t> free_joints;

  std::unique_ptr<BroadPhase> broad_phase;
  std::unique_ptr<ThreadPool> pool;
  /// The same while one large island steps alone and its loops are shared; null while islands are.
  ThreadPool* island_threads = nullptr;
  IslandBuilder island_builder;
  std::vector<SteppedIsland> islands;  ///< of the last step, if `graph_known`
  std::vector<std::uint32_t> graph_bodies, graph_joints;
  std::vector<ContactLink> links;       ///< of `contacts`
  std::vector<Contact> contacts;        ///< sorted by key; those of sleeping islands are in `sleepers`
  std::vector<ContactEvent> parted;     ///< ends of what was destroyed since the last step
  std::vector<IslandMemory> memories;   ///< sorted by key
  std::vector<RestingIsland> resting;   ///< sorted by key
  std::vector<StepMemory> step_memory;  ///< by body
  std::vector<std::uint64_t> support;   ///< by body, of those that are `StepMemory::stopped`: what holds it
  std::vector<PathPiece> step_paths;    ///< of the last step, by body, then in the order of time
  Sleepers sleepers;
  Ledger ledger;

  // Small things side by side, which saves padding.
  FieldThreads field_threads = FieldThreads::One;
  bool graph_known = false;    ///< `islands` are those of `graph_bodies`, `graph_joints`, `contacts`
  bool table_changed = true;   ///< contacts came or went since `links` was made
  bool joints_changed = true;  ///< joints came or went since the last step
  bool paths_known = false;    ///< `step_paths` were recorded in the last step
  int springs = 0;             ///< joints that hold energy

  // The working set, as slots in ascending order.
  std::vector<std::uint32_t> awake;      ///< dynamic bodies that do not sleep
  std::vector<std::uint32_t> kinematic;  ///< all kinematic bodies
  std::vector<std::uint32_t> touched;    ///< bodies that the user changed since the last step; in any order
  std::vector<std::uint32_t> displaced;  ///< of those, the ones that may be off their joints

  double last_h = 0;                ///< length of the last step [s]
  std::vector<std::uint8_t> rests;  ///< by body: its island's last step was known to change nothing
  /// By body. While islands are looked for: it is where and as it was, and so are the forces on it. After
  /// that: its island is kept. Of bodies that are not dynamic: they are where they were.
  std::vector<std::uint8_t> kept;

  // Of the current step; by body, but valid for those that were active in it only, unless said.
  std::size_t dynamic_bodies = 0;     ///< how many there are, asleep or not
  std::vector<std::uint32_t> active;  ///< awake, moving or touched bodies, ascending
  std::vector<std::uint32_t> active_joints;
  std::vector<Vec2> acceleration;  ///< by body, where forces vary: at the beginning [m/s^2]
  std::vector<double> angular_acceleration;
  std::vector<MotionPath> paths;  ///< by body, of those with a prescribed motion
  std::vector<double> reach;  ///< bound on how far any point of the body moves in a step [m], for all bodies
  std::vector<double> travelled;  ///< how far it did at most [m]
  std::vector<Way> way;
  /// Bound on how far any point of the body moves away from where its way would have taken it [m], and how
  /// far it did at most. They matter for bodies that fly fast (see `FlightKind`).
  std::vector<double> allowance, strayed;
  std::vector<FlightKind> flight;
  std::vector<Went> went;                 ///< of bodies that are stepped again
  std::vector<std::uint8_t> rerouted;     ///< it was struck off its way, which is that of the last round
  std::vector<Aabb> start_box;            ///< by shape, for all: the smallest box where the step begins
  std::vector<std::int32_t> local_index;  ///< by body: number in its island, -1 for bodies that do not react
  std::vector<BodyBackup> backup;         ///< at the start of the step, for all bodies
  std::vector<JointStart> joint_start;    ///< by joint
  /// By joint, while `time_stepping` steps its island: limits that the last piece kept reached, and motors
  /// with a largest force that it kept at their speed (bit k: row k); else 0.
  std::vector<std::uint8_t> held_rows;
  std::vector<Pair> pairs;
  std::vector<BoxUpdate> box_updates;
  std::vector<std::uint8_t> shape_moved;    ///< by shape: its box is new in this round
  std::vector<std::uint32_t> loose_shapes;  ///< shapes whose box in the broad phase is missing or out of date

  StepScratch scratch;

  // Looked up by name once, when the world is made.
  const SolverEntry* solver = nullptr;
  const struct ImpactLawEntry* impact_law = nullptr;
  const StepperEntry* stepper = nullptr;

  StepReport report;
  double time = 0;
  std::uint64_t steps = 0;
};

/// Nothing acts on a dynamic body but its weight, forces of the user, its joints, and what touches it.
bool flies_freely(const WorldState& state, std::uint32_t body);

/// Gives an empty broad phase the boxes of the last step. Their pairs are in the contact table already.
void fill_broad_phase(WorldState& state);

}  // namespace skerry
