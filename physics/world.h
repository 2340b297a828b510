// SPDX-License-Identifier: MIT
//
// The world: bodies, shapes and joints, and the step that moves them.
//
//   skerry::World world({.gravity = {0, -9.81}});
//   auto ground = world.create_body({.type = skerry::BodyType::Static});
//   world.add_shape(ground, {.shape = skerry::make_half_plane({0, 0}, {0, 1})});
//   auto ball = world.create_body({.position = {0, 5}});
//   world.add_shape(ball, {.shape = skerry::make_disc(0.5), .density = 1000});
//   for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
//
// All quantities are SI, angles in rad, y points up. Every public call checks its arguments, in Release too,
// and throws std::invalid_argument with the offending value; the world is unchanged then.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "physics/body.h"
#include "physics/broadphase/broadphase.h"
#include "physics/forces.h"
#include "physics/joint.h"
#include "physics/narrowphase/queries.h"
#include "physics/shared_shape.h"
#include "physics/skips.h"
#include "physics/step_report.h"

namespace skerry {

struct ShapeDef {
  Shape shape{};          ///< in the frame of the body's definition
  double density = 1000;  ///< [kg/m^2]; ignored for static bodies and when the body has a mass of its own
  Material material{};
  MixingRule friction_rule = MixingRule::GeometricMean;
  MixingRule restitution_rule = MixingRule::Maximum;
  Filter filter{};
  /// Reports overlaps, never pushes. It sees what overlaps it when a step ends: what passes it within a step
  /// is not seen. Two static bodies never see each other: a zone for what may become static is kinematic.
  bool sensor = false;
};

struct WorldConfig {
  Vec2 gravity{0, -9.81};  ///< [m/s^2]
  std::string broad_phase = "auto";
  BroadPhaseOptions broad_phase_options{};
  std::string solver = "auto";
  std::string impact_law = "reflections";
  std::string stepper = "time_stepping";
  /// Of every solve; `work_limit` is the budget of an island and a step, and stands at about a second of one
  /// core, which only a pathological island needs. What is left when it is spent is made in one piece, and
  /// reported inexact. 0: unlimited.
  SolveOptions solve{.work_limit = 1e8};
  /// Counted work (`SolveWork::visits`, some 10 ns each) for each body of an island in flow and a step: its
  /// contacts are many and most of them move, so that exact forces of an instant are worth less than they
  /// cost (physics/stepping/one_piece.h). Not set: 400, or 60 sweeps over velocities where that is less and
  /// there are no joints; in a world of fewer than 1000 dynamic bodies, 1000 without joints, and in a small
  /// one more, whose bodies share 4e5 (a joint of the island counts as half a one). From 1000 visits on
  /// overlaps stay below some micrometres. 0: no island counts as in flow, for reference runs.
  std::optional<double> flow_work{};
  double contact_margin = 0.005;  ///< pairs closer than this are kept as near contacts [m]
  double touch_tolerance = 1e-9;  ///< gaps up to this count as touching [m]
  double rest_speed = 1e-6;       ///< approach speeds below this do not bounce [m/s]
  /// Wanted error of positions and velocities after about a second of motion, relative for values above 1 (SI
  /// units), else absolute; 1e-14 to 1e-2. With it every island picks its own inner steps: `event_driven` by
  /// its embedded estimate, `time_stepping` by step doubling. Without it `event_driven` integrates to 1e-13
  /// and `time_stepping` takes the steps as they are given.
  std::optional<double> accuracy{};
  /// Of one island, fewer for large ones (512 over its contact points, at least 4); then the rest of the step
  /// treats landings as plastic. Where bodies in flow have less work than 1000, islands with joints that
  /// do not bounce well flow after 2 if they move fast, else after 16.
  int max_impacts_per_step = 64;
  /// Islands that a step did not change by a bit are not stepped again until something does.
  bool reuse_resting = true;
  /// Islands that are at rest to the bit leave the working set until something touches, moves or loads them;
  /// no bit of the motion depends on it. Needs `reuse_resting`.
  bool sleep = true;
  /// An island in which for half a second nothing has been faster than this [m/s] (ends of its bodies
  /// included) is stopped as it is, and sleeps, as in game engines, until something touches, moves or loads
  /// it: for heaps in which something goes on swinging or creeping, which never rest exactly. It is reported
  /// inexact, with what the best forces leave. 0: only what rests, or nearly does, is stopped.
  double sleep_speed = 0;
  Skips skips{};    ///< other work left out
  int threads = 1;  ///< for pairs, manifolds and islands, 1 to 256; results are the same bits for any number
};

/// A shape of the world, for drawing and queries.
struct ShapeRecord {
  // First, side by side, what is looked at of every pair.
  SharedShape shape;  ///< relative to the body's centre of mass
  BodyId body;
  Filter filter;
  std::uint32_t generation = 0;
  bool sensor = false;
  bool alive = false;
  bool in_broad_phase = false;
  bool pairs_changed = false;  ///< what it meets is to be found anew, though it lies where it lay
  MixingRule friction_rule{}, restitution_rule{};
  Aabb box;            ///< last box given to the broad phase
  double density = 0;  ///< [kg/m^2], as it was given
  Material material;
};

/// A joint of the world with the reaction of the last step.
struct JointRecord {
  JointDef def;
  Vec2 local_a,
      local_b;  ///< anchors relative to the centres of mass, in the bodies' frames (ground: world) [m]
  Vec2 local_axis{1, 0};       ///< unit, in the frame of a (Rack: world)
  double length = 0;           ///< [m]; Pulley, Gear, Rack: the constant that the joint keeps
  double reference_angle = 0;  ///< of b against a at creation [rad]
  bool alive = false;
  bool stalled = false;  ///< a motor without a largest force has come to a limit, and ends there
  std::uint32_t generation = 0;
  /// On b, world frame, of the last step, impacts included [N s]. What turns with a body counts in the
  /// direction that it had half-way.
  Vec2 impulse;
  double angular_impulse = 0;           ///< on b about its anchor [N m s]
  double row_force[kMaxJointRows]{};    ///< of each row in the last force solve [N or N m]; for warm starts
  double row_impulse[kMaxJointRows]{};  ///< of each row, summed over the step [N s or N m s]
};

/// What a query found.
struct QueryHit {
  ShapeId shape;
  BodyId body;
  double t = 0;         ///< ray: parameter; shape cast: share of the translation
  double distance = 0;  ///< closest point: from the given point [m], negative inside
  Vec2 point;           ///< on the surface, world frame [m]
  Vec2 normal;          ///< of the surface, unit
};

/// Motion of a body at one instant.
struct BodyState {
  Vec2 position;     ///< centre of mass, world frame [m]
  double angle = 0;  ///< [rad]
  Vec2 velocity;     ///< [m/s]
  double omega = 0;  ///< [rad/s]
  Transform pose() const { return {position, Rot::from_angle(angle)}; }
};

struct WorldState;
struct BodyForce;

class World {
 public:
  explicit World(WorldConfig config = {});
  ~World();
  World(World&&) noexcept;
  World& operator=(World&&) noexcept;

  // --- Building
  // -----------------------------------------------------------------------------------------------------
  /// Adds a body without shapes. A dynamic body needs a mass: from `def`, or from its shapes before the first
  /// step.
  BodyId create_body(const BodyDef& def);
  /// Adds a shape. The centre of mass moves to that of all shapes, and the position with it.
  ShapeId add_shape(BodyId body, const ShapeDef& def);
  /// Joins two bodies, or one and the world (`def.a` not given). Anchors that are apart come together in the
  /// next step, which changes no velocity.
  /// @throws std::invalid_argument for what the kind does not have, and numbers beyond their ranges
  JointId create_joint(const JointDef& def);
  /// Makes a body static, kinematic or dynamic from now on: it stays where it is, with its shapes and joints.
  /// What moves keeps its velocity, what is static has none; drag is that of dynamic bodies, a prescribed
  /// motion that of kinematic ones, and each is forgotten with the type. What touches it wakes.
  /// @throws std::invalid_argument if a body with a half-plane or a chain is to be dynamic
  void set_type(BodyId body, BodyType type);
  /// As `BodyDef::mass` [kg] and `BodyDef::inertia` [kg m^2] from now on; none: by the shapes. Velocities
  /// stay.
  /// @throws std::invalid_argument as `create_body`; nothing is changed then
  void set_mass(BodyId body, std::optional<double> mass, std::optional<double> inertia = {});
  /// What the surface does from now on; the rules of mixing stay. What lies on it wakes.
  /// @throws std::invalid_argument as `add_shape`; nothing is changed then
  void set_material(ShapeId shape, const Material& material);
  /// What the shape meets from now on: contacts begin and end with the next step.
  void set_filter(ShapeId shape, const Filter& filter);
  /// Another definition of a joint: limits, motor, spring, length, largest and breaking loads, whether
  /// its bodies touch. Take `joints()[joint.index].def` and change that. A length that is given is the new
  /// one [m] (Distance, Rope, Spring), without one the old one stays. It holds at once: what it is off by
  /// goes in the next step, through what stands in between where that is more than the size of a body; a
  /// motor hauls.
  /// @throws std::invalid_argument as `create_joint`, and if the kind, the bodies, the anchors, the axis, the
  /// pulleys or the ratio are others; nothing is changed then
  void set_joint(JointId joint, const JointDef& def);
  void destroy(BodyId body);  ///< with its shapes, contacts and joints; what rested on it wakes
  void destroy(ShapeId shape);
  void destroy(JointId joint);
  bool alive(BodyId body) const;
  bool alive(ShapeId shape) const;
  bool alive(JointId joint) const;

  // --- State of a body
  // ------------------------------------------------------------------------------------------------
  Vec2 position(BodyId body) const;   ///< centre of mass, world frame [m]
  double angle(BodyId body) const;    ///< [rad]
  Vec2 velocity(BodyId body) const;   ///< of the centre of mass [m/s]
  double omega(BodyId body) const;    ///< [rad/s]
  double mass(BodyId body) const;     ///< [kg]
  double inertia(BodyId body) const;  ///< about the centre of mass [kg m^2]
  Transform pose(BodyId body) const;
  Vec2 velocity_at(BodyId body, Vec2 point_world) const;
  std::string_view name(BodyId body) const;
  /// Puts the centre of mass at `position` [m, world frame] and turns the body to `angle` [rad]; its velocity
  /// stays. What is joined to it comes along in the next step, and keeps its velocity, too.
  /// @throws std::invalid_argument unless all are finite, as the next four do, too
  void set_pose(BodyId body, Vec2 position, double angle);
  /// Of the centre of mass [m/s, world frame], and of turning [rad/s].
  /// @throws std::invalid_argument for a static body
  void set_velocity(BodyId body, Vec2 velocity, double omega);
  /// Adds a force for the next step. Off the centre of mass it turns the body: torque = (point - position) x
  /// force [N, m, world frame].
  void apply_force(BodyId body, Vec2 force, Vec2 point_world);
  void apply_torque(BodyId body, double torque);  ///< for the next step [N m]
  /// Changes the velocity at once [N s, m, world frame].
  void apply_impulse(BodyId body, Vec2 impulse, Vec2 point_world);
  /// Sets the force field of the world; none: an empty function. Called at states that are only tried, so it
  /// must depend on its argument alone. What it throws leaves `step`, and the bodies are where they were
  /// then.
  void set_force_field(ForceField field, FieldThreads threads = FieldThreads::One);
  /// Sets the resistance of the medium for a body.
  void set_drag(BodyId body, const Drag& drag);
  /// Sets what share of the world's gravity a body feels; less than 0: upwards.
  void set_gravity_scale(BodyId body, double scale);
  /// Lets a kinematic body move as told from now on; an empty function: on with the velocity that it has.
  /// Its velocity, within steps too, is that of the motion, whatever `set_pose` and `set_velocity` say.
  void set_motion(BodyId body, PrescribedMotion motion);
  bool has_motion(BodyId body) const;  ///< it moves as `set_motion` told it to
  WorldCallbacks callbacks() const;
  /// Takes these in place of its own, and the motions of those bodies that it has, too. They have to be what
  /// they were when the world was saved: bodies are left where they are.
  void adopt(const WorldCallbacks& callbacks);
  bool asleep(BodyId body) const;  ///< its island is at rest and out of the working set
  void wake(BodyId body);          ///< never needed: whatever changes a body wakes it

  // --- Stepping
  // -------------------------------------------------------------------------------------------------------
  /// Advances by `h` > 0 [s]. The report is valid until the next step. What a callback throws comes through:
  /// then nothing has moved, and `report` says so (`StepReport::interrupted`).
  const StepReport& step(double h);
  const StepReport& report() const;
  double time() const;
  void observe(const Observe& what);
  const WorldConfig& config() const;
  /// Sets `WorldConfig::accuracy` from now on; none: no error control. Another one wakes all that sleeps.
  void set_accuracy(std::optional<double> accuracy);
  void set_gravity(Vec2 gravity);
  /// Changes settings while running; `threads` stays as it is. What the old solver or stepper kept of the
  /// islands is dropped. @throws std::invalid_argument as the constructor; nothing is changed then
  void reconfigure(const WorldConfig& config);

  // --- Looking
  // --------------------------------------------------------------------------------------------------------
  const BodyArrays& bodies() const;
  std::span<const ShapeRecord> shapes() const;  ///< by slot; look at `alive`
  std::span<const JointRecord> joints() const;
  /// Mean reaction of a joint over the last step: force on body b [N] and torque on b about its anchor [N m];
  /// impacts are included. Body a feels the opposite.
  Vec2 joint_force(JointId joint) const;
  double joint_torque(JointId joint) const;
  /// The coordinate on which limits, motor and spring of a joint act (see JointDef), and its rate.
  double joint_position(JointId joint) const;  ///< [m or rad]
  double joint_speed(JointId joint) const;     ///< [m/s or rad/s]
  /// Changes the speed that a joint's motor aims at, or gives it a motor. @param limit  [N or N m], none:
  /// kept
  void set_motor(JointId joint, double speed, std::optional<double> limit = {});
  BodyId body_id(std::size_t slot) const;
  /// The motion of a body at `time` [s] within the last step, from the continuous output of the stepper: the
  /// Runge-Kutta interpolant between events, the parabola or Hermite cubic of a time-stepping piece, cut at
  /// impacts; at the instant of an impact the velocity after it.
  /// @throws std::invalid_argument if `time` is not within the last step, or `Observe::paths` was off in it
  BodyState interpolated(BodyId body, double time) const;
  /// Kinetic energy of the dynamic bodies [J], momentum [kg m/s], angular momentum about the origin [kg
  /// m^2/s].
  double kinetic_energy() const;
  double potential_energy() const;  ///< in the uniform gravity field, and in the springs of joints [J]
  double spring_energy() const;     ///< of which in springs [J]
  Vec2 momentum() const;
  double angular_momentum() const;
  /// Hash of the slot, position, angle and velocities of all live bodies, bit by bit and in slot order: that
  /// of hash.h (FNV-1a over words, not bytes, with the high half folded back) over each 64 slots, then over
  /// these hashes, without those of blocks where nothing lives.
  std::uint64_t state_hash() const;
  const BroadPhase& broad_phase() const;

  // --- Queries --------------------------------------------------------------------------------------------
  // Shapes whose filter lets them meet `filter` are considered; sensors are found like the rest. Results that
  // list shapes ascend by slot, so they do not depend on the broad phase.
  std::vector<ShapeId> shapes_at(Vec2 point, const Filter& filter = {}) const;
  /// Shapes that overlap `shape` at `pose`.
  std::vector<ShapeId> shapes_overlapping(const Shape& shape, const Transform& pose,
                                          const Filter& filter = {}) const;
  /// Shapes whose bounding boxes overlap `box`.
  std::vector<ShapeId> shapes_in_box(const Aabb& box, const Filter& filter = {}) const;
  /// First shape that the ray meets; of several at the same t the one with the lowest slot.
  std::optional<QueryHit> ray_cast(const Ray& ray, const Filter& filter = {}) const;
  /// All shapes that the ray meets, by t.
  std::vector<QueryHit> ray_cast_all(const Ray& ray, const Filter& filter = {}) const;
  /// First shape that `shape` touches when it is moved along `translation` without turning.
  std::optional<QueryHit> shape_cast(const Shape& shape, const Transform& pose, Vec2 translation,
                                     const Filter& filter = {}) const;
  /// The shape nearest to `point` within `max_distance` [m].
  std::optional<QueryHit> closest(Vec2 point, double max_distance, const Filter& filter = {}) const;
  /// Closest points of two shapes of the world.
  ClosestPoints distance(ShapeId a, ShapeId b) const;

 private:
  friend std::vector<std::byte> save_snapshot(const World& world);
  friend World load_snapshot(std::span<const std::byte> bytes);
  friend std::vector<BodyForce> forces_on(const World& world, BodyId body);

  std::unique_ptr<WorldState> state_;
};

}  // namespace skerry
