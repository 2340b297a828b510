// SPDX-License-Identifier: MIT
//
// What a step did: times, counts, skips, conserved quantities, events. Filled at every step; island systems
// and solver traces only for an observer.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "physics/broadphase/broadphase.h"
#include "physics/handle.h"
#include "physics/islands/island_system.h"
#include "physics/narrowphase/manifold.h"
#include "physics/solver/solver.h"

namespace skerry {

/// A stage of the step, in order; names for `Stage` come from `stage_name`.
enum class Stage : std::uint8_t { Forces, Broad, Narrow, Islands, Assemble, Solve, Impact, Apply, Report };
inline constexpr int kStageCount = 9;
std::string_view stage_name(Stage stage);

/// A shape that is destroyed while it touches another one has its End in the report of the next step, with
/// the ids that it had, which are no longer alive.
enum class ContactEventKind : std::uint8_t { Begin, Persist, End, Hit };

/// Something that happened to a pair of shapes in the step.
struct ContactEvent {
  ContactEventKind kind = ContactEventKind::Begin;
  ShapeId shape_a, shape_b;
  BodyId body_a, body_b;
  Vec2 point;                 ///< world frame [m] (Begin, Hit)
  Vec2 normal;                ///< from a to b (Begin, Hit)
  double approach_speed = 0;  ///< before the impact [m/s] (Hit)
  double impulse = 0;         ///< sum of normal impulses [N s] (Hit)
  double time = 0;            ///< of the fastest impact (Hit), of being destroyed, else of the step's end [s]
  int segment = -1;           ///< of the chain, from 0, which has events for each of them; -1: no chain
  bool sensor = false;
};

enum class MotionEventKind : std::uint8_t {
  Landing,  ///< a gap closed
  Release,  ///< the normal force of a contact, or the pull of a rope, fell to zero
  Slip,     ///< friction, or rolling resistance, reached its bound
  Stick,    ///< sliding, or rolling, came to an end
  Limit,    ///< a rope became taut, or a joint reached its limit
  Settle,   ///< infinitely many bounces came to an end
  Feature,  ///< a contact moved on to the next corner or edge
  Motor,    ///< a joint's motor reached its largest force, or its speed
  Paradox,  ///< Painleve's: sliding ended by an impulse without a collision, since no forces allow it
};

/// A change of the way in which an island moves, located in time. Only event-driven steppers know them, but
/// for Paradox, which comes from any.
struct MotionEvent {
  MotionEventKind kind = MotionEventKind::Landing;
  double time = 0;  ///< [s]; of Settle: the limit of the bounces, which may lie after the step
  BodyId body_a, body_b;
};

/// A joint that broke: its load was too large, and it is no more.
struct JointEvent {
  JointId joint;
  BodyId body_a, body_b;
  double force = 0;   ///< mean magnitude over the step [N]
  double torque = 0;  ///< [N m]
};

/// One contact point with the impulses of the step.
struct ContactPointReport {
  Vec2 position;          ///< world frame [m]
  double separation = 0;  ///< [m]
  std::uint32_t feature = 0;
  double normal_impulse = 0;    ///< of all sub-steps, without impacts [N s]; it acts on b along the normal
  double friction_impulse = 0;  ///< acts on b along perp(normal) [N s]
  double impact_impulse = 0;    ///< normal impulse of impacts in the step [N s]
  Vec2 impact_position;         ///< where that acted: the bodies have moved on since [m]
};

/// A touching (or speculative) pair in the last step, or one that pushed in it and has parted since: that has
/// one point, where they are nearest or where the impact was, with all that its points gave.
///
/// Numbers of the points are sums along normals, and what turns has turned on by the end of the step.
/// `impulse` is the sum of what acted in the direction in which it did: for each body, the sum over its
/// contacts, with what joints and forces give it, is the change of its momentum.
struct ContactReport {
  ShapeId shape_a, shape_b;
  BodyId body_a, body_b;
  Vec2 normal;         ///< from a to b at the end of the step, world frame
  Vec2 impulse;        ///< on b in the step, friction and impacts included, world frame [N s]
  Vec2 impact_normal;  ///< mean of the normals of impacts in the step, by what they gave; without: `normal`
  std::array<ContactPointReport, 2> points;
  int count = 0;
  int island = -1;
};

/// An island of the last step.
struct IslandReport {
  int bodies = 0;
  int contacts = 0;  ///< contact points
  int rows = 0;
  std::string_view stepper;  ///< that brought it through the step; "" for closed-form flight
  SolveStatus status = SolveStatus::Solved;
  std::string_view method;  ///< solver that gave the answer; "" when nothing had to be solved
  double residual = 0;
  int iterations = 0;
  bool flowing = false;  ///< in flow: solved within `WorldConfig::flow_work`
  /// Sum of the estimated local errors of its inner steps, relative above 1 m, m/s, rad, rad/s. Only where an
  /// accuracy was asked for; above it where that could not be had.
  double error_estimate = 0;
};

/// For an observer: the problem of an island, its answer and how it was found.
struct IslandTrace {
  int island = -1;
  bool impact = false;         ///< the impact problem (velocity before the kick) rather than the resting one
  double time = 0;             ///< [s] of the world when it was solved
  std::vector<BodyId> bodies;  ///< bodies of the system, in its order
  IslandSystem system;
  std::vector<double> lambda;
  SolveStatus status = SolveStatus::Solved;
  std::string_view method;
  double residual = 0;
  std::shared_ptr<const SolveTrace> trace;  ///< may be null; copies of a report share it
};

enum class ContainmentCause : std::uint8_t {
  TooFar,     ///< it would have moved more than 1e100 m in the step
  NotFinite,  ///< its new position, angle or velocity was not a finite number
};
std::string_view to_string(ContainmentCause cause);

/// A body that was put back to where the step found it, and stopped; the others are not concerned.
struct Containment {
  BodyId body;
  ContainmentCause cause = ContainmentCause::NotFinite;
};

struct StepReport {
  std::uint64_t step = 0;  ///< number of steps made
  double time = 0;         ///< at the end of the step [s]
  double h = 0;            ///< length of the step; 0: it was not made [s]
  /// Why the step was not made: what a callback threw. Nothing has moved, and the report counts nothing but
  /// what there is: `step` and `time` are those of the last step that was made.
  std::string interrupted;
  std::array<double, kStageCount> stage_seconds{};

  // Counts.
  int bodies = 0, dynamic_bodies = 0, shapes = 0, joints = 0;
  int pairs = 0, contacts = 0, contact_points = 0, islands = 0, rows = 0;
  int substeps = 0;     ///< pieces into which impacts cut the step
  int impacts = 0;      ///< impact solves
  int reflections = 0;  ///< inner reflections of those
  int friction_rows = 0;
  BroadPhaseChoice broad_phase;  ///< which implementation found the pairs, and why
  NarrowPhaseStats narrow;
  SolveWork work;  ///< of all islands, and of rounds of the step that were made again

  int force_solves = 0;    ///< evaluations of contact forces at acceleration level, over all islands
  int events_found = 0;    ///< events that were located in time (releases, landings, slip, stick, limits)
  int inner_steps = 0;     ///< steps that error control accepted, over all islands
  int rejected_steps = 0;  ///< inner steps taken again because their error was too large
  int paradoxes = 0;       ///< contact points that slid in Painleve's paradox; `motion_events` say which
  int fallbacks = 0;       ///< islands for which the event-driven stepper gave up; time_stepping made them

  // Who made the step of the islands that were neither in flight nor at rest.
  int islands_by_events = 0, islands_by_time_stepping = 0;
  int islands_in_flow = 0;       ///< of the latter, with a bounded amount of work (`WorldConfig::flow_work`)
  int islands_in_one_piece = 0;  ///< of them, lightly disturbed: one exact solve for impacts and forces

  int island_retries = 0;  ///< islands stepped again because a body went farther than foreseen

  // Skips: work that this step did not have to do.
  int islands_asleep = 0;  ///< out of the working set; counted in `islands`, `contacts`, `rows` all the same
  int bodies_asleep = 0;
  int islands_in_flight = 0;   ///< closed-form flight: no narrow phase, no rows, no solve
  int islands_at_rest = 0;     ///< nothing changed by a bit: last step's forces serve; sleepers among them
  int manifolds_reused = 0;    ///< manifolds whose bodies had not moved by a bit
  int pairs_out_of_reach = 0;  ///< pairs that cannot meet within the step, left out of the islands
  /// What the world's force field switches off: it may be another one at any time, so nothing is at rest and
  /// nothing sleeps; and unless it may be called by many threads, one makes the step of all islands.
  bool field_keeps_awake = false, field_wants_one_thread = false;

  // Accuracy.
  double worst_residual = 0;  ///< over the islands, relative
  double error_estimate = 0;  ///< largest of the islands' (see `IslandReport`)
  /// That have no exact answer, or whose joints or contacts an exact step left off by more than 1e-5 of a
  /// body; asleep or not.
  int inexact_islands = 0;
  /// Deepest overlap at the end of the step [m], >= 0; of islands in flow at its beginning, too: what met
  /// unforeseen in the step before is known only then.
  double worst_penetration = 0;
  int contained = 0;  ///< bodies put back and stopped, see `containments`

  // Conserved quantities at the end of the step, dynamic bodies only.
  double kinetic_energy = 0;    ///< [J]
  double potential_energy = 0;  ///< in the uniform gravity field, zero at the origin, and in springs [J]
  Vec2 momentum;                ///< [kg m/s]
  double angular_momentum = 0;  ///< about the world's origin [kg m^2/s]

  double total_normal_impulse = 0;    ///< sum over contacts [N s]
  double total_friction_impulse = 0;  ///< sum of magnitudes [N s]
  std::uint64_t state_hash = 0;       ///< of all positions, angles and velocities, bit by bit

  std::vector<ContactReport> contacts_list;  ///< only with `Observe::contacts`
  std::vector<IslandReport> islands_list;  ///< awake ones; with `Observe::contacts` followed by the sleeping
  std::vector<ContactEvent> events;
  std::vector<MotionEvent> motion_events;  ///< by island, then in the order of time
  std::vector<JointEvent> joint_events;    ///< joints that broke at the end of the step, by slot
  std::vector<Containment> containments;   ///< in the order in which they were found
  std::vector<IslandTrace> traces;         ///< only with `Observe::systems`
};

/// What the next reports carry besides the counters; all off costs nothing.
struct Observe {
  bool contacts = false;
  bool systems = false;
  bool solve_traces = false;  ///< with `systems`: the trace of every solve
  bool stage_times = false;
  bool paths = false;  ///< the motion within the step, for `World::interpolated`
};

}  // namespace skerry
