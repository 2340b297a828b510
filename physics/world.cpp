// SPDX-License-Identifier: MIT
//
// Building and reading a world; the step itself is in world_step.cpp.
#include "physics/world.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "physics/joint_rows.h"
#include "physics/solver/impact_law.h"
#include "physics/stepping/touching.h"
#include "physics/text.h"
#include "physics/world_state.h"

namespace skerry {
namespace {

void require(bool condition, const std::string& message) {
  if (!condition) throw std::invalid_argument(message);
}

void require_finite(double value, const char* what) {
  require(std::isfinite(value), std::string(what) + " must be finite, got " + to_text(value));
}

void require_finite(Vec2 value, const char* what) {
  require(is_finite(value), std::string(what) + " must be finite, got " + to_text(value));
}

void require_at_least_zero(double value, const char* what) {
  require(value >= 0 && std::isfinite(value),
          std::string(what) + " must be finite and >= 0, got " + to_text(value));
}

void require_accuracy(const std::optional<double>& accuracy) {
  require(!accuracy || (*accuracy >= 1e-14 && *accuracy <= 1e-2),
          "accuracy must be from 1e-14 to 1e-2, got " + to_text(accuracy.value_or(0)));
}

template <class Tag, class Slots>
std::uint32_t checked(Handle<Tag> id, const Slots& generation_of, std::size_t count, const char* what) {
  require(id.index < count && generation_of(id.index) == id.generation,
          std::string(what) + " " + (id ? std::to_string(id.index) : "none") + " does not exist (any more)");
  return id.index;
}

std::uint32_t slot(const WorldState& s, BodyId id) {
  return checked(
      id, [&](std::uint32_t i) { return s.bodies.alive[i] ? s.bodies.generation[i] : ~0u; }, s.bodies.size(),
      "body");
}

std::uint32_t slot(const WorldState& s, ShapeId id) {
  return checked(
      id, [&](std::uint32_t i) { return s.shapes[i].alive ? s.shapes[i].generation : ~0u; }, s.shapes.size(),
      "shape");
}

std::uint32_t slot(const WorldState& s, JointId id) {
  return checked(
      id, [&](std::uint32_t i) { return s.joints[i].alive ? s.joints[i].generation : ~0u; }, s.joints.size(),
      "joint");
}

/// Grows every per-body array by one default slot.
std::uint32_t new_body_slot(WorldState& s) {
  if (!s.free_bodies.empty()) {
    // The lowest free slot, so that slots do not depend on the order of removals.
    const auto lowest = std::min_element(s.free_bodies.begin(), s.free_bodies.end());
    const std::uint32_t i = *lowest;
    s.free_bodies.erase(lowest);
    return i;
  }
  BodyArrays& b = s.bodies;
  b.position.emplace_back();
  b.angle.push_back(0);
  b.rotation.emplace_back();
  b.velocity.emplace_back();
  b.omega.push_back(0);
  b.force.emplace_back();
  b.torque.push_back(0);
  b.mass.push_back(0);
  b.inertia.push_back(0);
  b.inverse_mass.push_back(0);
  b.inverse_inertia.push_back(0);
  b.gravity_scale.push_back(1);
  b.type.push_back(BodyType::Static);
  b.alive.push_back(0);
  b.asleep.push_back(0);
  b.island.push_back(-1);
  b.generation.push_back(0);
  s.names.emplace_back();
  s.given_mass.emplace_back();
  s.given_inertia.emplace_back();
  s.shapes_of.emplace_back();
  s.joints_of.emplace_back();
  s.centre.emplace_back();
  s.radius.push_back(0);
  s.acceleration.emplace_back();
  s.angular_acceleration.push_back(0);
  s.reach.push_back(0);
  s.travelled.push_back(0);
  s.local_index.push_back(-1);
  s.rests.push_back(0);
  s.kept.push_back(0);
  s.drag.emplace_back();
  s.prescribed.emplace_back();
  s.paths.emplace_back();
  s.step_memory.emplace_back();
  return static_cast<std::uint32_t>(b.position.size() - 1);
}

/// Whatever the user changes at a body wakes its island, and those that lean on it.
void touch(WorldState& s, std::uint32_t body) {
  s.touched.push_back(body);
  s.rests[body] = 0;
  s.ledger.mark(body);
  if (s.sleepers.none()) return;
  s.sleepers.wake(s, {&body, 1});
  s.sleepers.wake_at(s, body);
}

/// Queries look at these shapes themselves until the next step gives them boxes.
void make_loose(WorldState& s, std::uint32_t body) {
  touch(s, body);
  s.loose_shapes.insert(s.loose_shapes.end(), s.shapes_of[body].begin(), s.shapes_of[body].end());
}

/// Mass, centre and inertia of a body from its shapes, and the shapes moved so that the centre of mass is the
/// origin.
void update_mass(WorldState& s, std::uint32_t body) {
  double mass = 0;
  Vec2 moment;
  double second = 0;  // polar, about the present origin
  double area = 0;
  Vec2 area_moment;
  for (const std::uint32_t i : s.shapes_of[body]) {
    const AreaProperties p = area_properties(s.shapes[i].shape);
    const double m = s.shapes[i].density * p.area;
    mass += m;
    moment += m * p.centroid;
    second += s.shapes[i].density * (p.second_moment + p.area * length_squared(p.centroid));
    area += p.area;
    area_moment += p.area * p.centroid;
  }
  // With all densities zero the centre is that of the area; a body with a given mass spreads it evenly then.
  const bool weightless = !(mass > 0);
  if (weightless && area > 0) {
    mass = area;
    moment = area_moment;
    second = 0;
    for (const std::uint32_t i : s.shapes_of[body]) {
      const AreaProperties p = area_properties(s.shapes[i].shape);
      second += p.second_moment + p.area * length_squared(p.centroid);
    }
  }
  const Vec2 centre = mass > 0 ? moment / mass : Vec2{};
  double inertia = mass > 0 ? std::max(0.0, second - mass * length_squared(centre)) : 0;
  if (weightless && !s.given_mass[body]) mass = inertia = 0;

  make_loose(s, body);
  if (centre != Vec2{}) {
    for (const std::uint32_t i : s.shapes_of[body])
      s.shapes[i].shape = translated(s.shapes[i].shape, -centre);
    for (const std::uint32_t i : s.joints_of[body]) {
      JointRecord& joint = s.joints[i];
      if (joint.def.a.index == body) joint.local_a -= centre;
      if (joint.def.b.index == body) joint.local_b -= centre;
    }
    s.centre[body] += centre;
    const Vec2 shift = rotate(s.bodies.rotation[body], centre);
    s.bodies.position[body] += shift;
    s.bodies.velocity[body] += s.bodies.omega[body] * perp(shift);
  }
  s.radius[body] = 0;
  for (const std::uint32_t i : s.shapes_of[body]) {
    s.radius[body] = std::max(s.radius[body], bounding_radius(s.shapes[i].shape));
  }

  if (s.bodies.type[body] != BodyType::Dynamic) return;
  if (s.given_mass[body]) {
    inertia = mass > 0 ? inertia * (*s.given_mass[body] / mass) : 0;
    mass = *s.given_mass[body];
  }
  if (s.given_inertia[body]) inertia = *s.given_inertia[body];
  s.bodies.mass[body] = mass;
  s.bodies.inertia[body] = inertia;
  s.bodies.inverse_mass[body] = mass > 0 ? 1 / mass : 0;
  s.bodies.inverse_inertia[body] = inertia > 0 ? 1 / inertia : 0;
}

void drop_contacts_of_shape(WorldState& s, std::uint32_t shape) {
  s.table_changed |= std::erase_if(s.contacts, [&](const Contact& c) {
                       return c.shape_a == shape || c.shape_b == shape;
                     }) > 0;
}

void remove_shape(WorldState& s, std::uint32_t i) {
  drop_contacts_of_shape(s, i);
  if (s.shapes[i].in_broad_phase) s.broad_phase->remove(i);
  const std::uint32_t generation = s.shapes[i].generation;
  s.shapes[i] = ShapeRecord{};
  s.shapes[i].generation = generation + 1;
  s.free_shapes.push_back(i);
}

/// Refuses definitions that mean nothing, and makes the anchors one where the joint has only one.
void check_joint(JointDef& def) {
  const auto is = [&def](std::initializer_list<JointKind> kinds) {
    return std::find(kinds.begin(), kinds.end(), def.kind) != kinds.end();
  };
  require_finite(def.anchor_a, "joint: anchor_a");
  require_finite(def.anchor_b, "joint: anchor_b");
  if (is({JointKind::Revolute, JointKind::Weld, JointKind::Prismatic, JointKind::Wheel}))
    def.anchor_b = def.anchor_a;
  if (def.length) require_at_least_zero(*def.length, "joint: length");
  require(def.kind != JointKind::Distance || def.length.value_or(length(def.anchor_b - def.anchor_a)) > 0,
          "distance joint: length must be positive, got 0; use a revolute joint, or a spring");
  require_finite(def.axis, "joint: axis");
  require(def.axis != Vec2{}, "joint: axis must not be zero");
  require(std::isfinite(def.ratio) && def.ratio != 0,
          "joint: ratio must not be 0, got " + to_text(def.ratio));
  require(def.kind != JointKind::Pulley || def.ratio > 0,
          "pulley: ratio must be positive, got " + to_text(def.ratio));
  require_finite(def.pulley_a, "joint: pulley_a");
  require_finite(def.pulley_b, "joint: pulley_b");
  require_at_least_zero(def.stiffness, "joint: stiffness");
  require_at_least_zero(def.damping, "joint: damping");
  if (def.lower) require_finite(*def.lower, "joint: lower limit");
  if (def.upper) require_finite(*def.upper, "joint: upper limit");
  require(!def.lower || !def.upper || *def.lower <= *def.upper,
          "joint: lower limit must not exceed the upper one, got " + to_text(def.lower.value_or(0)) +
              " and " + to_text(def.upper.value_or(0)));
  if (def.motor_speed) require_finite(*def.motor_speed, "joint: motor_speed");
  require(def.kind != JointKind::Motor || def.motor_speed, "motor joint: motor_speed must be given");
  require(def.kind != JointKind::Spring || def.stiffness > 0 || def.damping > 0,
          "spring: stiffness or damping must be positive, got 0 and 0");
  for (const double most : {def.motor_limit, def.break_force, def.break_torque})
    require(most >= 0, "joint: the largest force must be >= 0, got " + to_text(most));
  // What a kind does not have is refused rather than ignored.
  const bool limits = def.lower || def.upper;
  const bool spring = def.stiffness > 0 || def.damping > 0;
  require(!limits || is({JointKind::Revolute, JointKind::Distance, JointKind::Prismatic, JointKind::Wheel,
                         JointKind::Spring}),
          "joint: this kind has no limits");
  require(!spring || is({JointKind::Revolute, JointKind::Distance, JointKind::Prismatic, JointKind::Wheel,
                         JointKind::Spring}),
          "joint: this kind has no spring");
  require(!def.motor_speed || is({JointKind::Revolute, JointKind::Distance, JointKind::Prismatic,
                                  JointKind::Wheel, JointKind::Motor}),
          "joint: this kind has no motor");
}

void remove_joint(WorldState& s, std::uint32_t i) {
  for (const BodyId id : {s.joints[i].def.a, s.joints[i].def.b}) {
    if (!id) continue;
    touch(s, id.index);
    std::erase(s.joints_of[id.index], i);
  }
  s.joints_changed = true;
  const std::uint32_t generation = s.joints[i].generation;
  s.joints[i] = JointRecord{};
  s.joints[i].generation = generation + 1;
  s.free_joints.push_back(i);
}

/// Refuses settings out of range.
void check(const WorldConfig& config) {
  require_finite(config.gravity, "gravity");
  require_at_least_zero(config.contact_margin, "contact_margin");
  require_at_least_zero(config.touch_tolerance, "touch_tolerance");
  require_at_least_zero(config.rest_speed, "rest_speed");
  require_accuracy(config.accuracy);
  require(config.max_impacts_per_step >= 0,
          "max_impacts_per_step must be >= 0, got " + std::to_string(config.max_impacts_per_step));
  require(config.touch_tolerance <= config.contact_margin,
          "touch_tolerance must not exceed contact_margin, got " + to_text(config.touch_tolerance) + " and " +
              to_text(config.contact_margin));
}

/// All names are looked up before any is taken.
void look_up_methods(WorldState& s, const WorldConfig& config) {
  const SolverEntry& solver = find_solver(config.solver);
  const ImpactLawEntry& impact_law = find_impact_law(config.impact_law);
  const StepperEntry& stepper = find_stepper(config.stepper);
  s.solver = &solver;
  s.impact_law = &impact_law;
  s.stepper = &stepper;
}

}  // namespace

void fill_broad_phase(WorldState& s) {
  for (std::uint32_t i = 0; i < s.shapes.size(); ++i) {
    const ShapeRecord& shape = s.shapes[i];
    if (!shape.alive || !shape.in_broad_phase) continue;
    const bool fixed = s.bodies.type[shape.body.index] == BodyType::Static;
    s.broad_phase->insert(i, shape.box, fixed ? ProxyKind::Fixed : ProxyKind::Moving);
  }
  s.broad_phase->moved_pairs(s.pairs);
}

World::World(WorldConfig config) : state_(std::make_unique<WorldState>()) {
  check(config);
  state_->pool = std::make_unique<ThreadPool>(config.threads);
  config.broad_phase_options.threads = config.threads;
  state_->broad_phase = make_broad_phase(config.broad_phase, config.broad_phase_options);
  look_up_methods(*state_, config);
  state_->config = std::move(config);
}

void World::reconfigure(const WorldConfig& given) {
  WorldState& s = *state_;
  WorldConfig config = given;
  check(config);
  config.threads = config.broad_phase_options.threads = s.config.threads;
  std::unique_ptr<BroadPhase> broad_phase = make_broad_phase(config.broad_phase, config.broad_phase_options);
  look_up_methods(s, config);
  s.config = std::move(config);
  s.sleepers.wake_all(s);
  s.ledger.mark_all();
  s.memories.clear();
  s.resting.clear();
  s.graph_known = false;
  std::fill(s.rests.begin(), s.rests.end(), 0);
  std::fill(s.step_memory.begin(), s.step_memory.end(), StepMemory{});
  s.broad_phase = std::move(broad_phase);
  fill_broad_phase(s);
}

World::~World() = default;
World::World(World&&) noexcept = default;
World& World::operator=(World&&) noexcept = default;

BodyId World::create_body(const BodyDef& def) {
  require_finite(def.position, "position");
  require_finite(def.angle, "angle");
  require_finite(def.velocity, "velocity");
  require_finite(def.omega, "omega");
  require_finite(def.gravity_scale, "gravity_scale");
  if (def.mass)
    require(*def.mass > 0 && std::isfinite(*def.mass), "mass must be positive, got " + to_text(*def.mass));
  if (def.inertia) require_at_least_zero(*def.inertia, "inertia");

  WorldState& s = *state_;
  const std::uint32_t i = new_body_slot(s);
  s.step_memory[i] = {};
  BodyArrays& b = s.bodies;
  b.position[i] = def.position;
  b.angle[i] = def.angle;
  b.rotation[i] = Rot::from_angle(def.angle);
  const bool moves = def.type != BodyType::Static;
  b.velocity[i] = moves ? def.velocity : Vec2{};
  b.omega[i] = moves ? def.omega : 0;
  b.force[i] = {};
  b.torque[i] = 0;
  b.gravity_scale[i] = def.gravity_scale;
  b.type[i] = def.type;
  b.alive[i] = 1;
  b.island[i] = -1;
  b.mass[i] = b.inertia[i] = b.inverse_mass[i] = b.inverse_inertia[i] = 0;
  s.names[i] = def.name;
  s.given_mass[i] = def.mass;
  s.given_inertia[i] = def.inertia;
  s.centre[i] = {};
  s.radius[i] = 0;
  s.local_index[i] = -1;
  s.rests[i] = 0;
  s.kept[i] = def.type != BodyType::Dynamic;
  b.asleep[i] = 0;
  if (def.type == BodyType::Dynamic) s.awake.insert(std::lower_bound(s.awake.begin(), s.awake.end(), i), i);
  if (def.type == BodyType::Kinematic) {
    s.kinematic.insert(std::lower_bound(s.kinematic.begin(), s.kinematic.end(), i), i);
  }
  update_mass(s, i);
  return {i, b.generation[i]};
}

ShapeId World::add_shape(BodyId id, const ShapeDef& def) {
  WorldState& s = *state_;
  const std::uint32_t body = slot(s, id);
  require_at_least_zero(def.density, "density");
  require_at_least_zero(def.material.friction, "friction");
  const double held = def.material.static_friction.value_or(def.material.friction);
  require(held >= def.material.friction && std::isfinite(held),
          "static_friction must be finite and at least friction, got " + to_text(held) + " and " +
              to_text(def.material.friction));
  require_at_least_zero(def.material.rolling_resistance, "rolling_resistance");
  require_finite(def.material.surface_velocity, "surface_velocity");
  require(def.material.restitution >= 0 && def.material.restitution <= 1,
          "restitution must be between 0 and 1, got " + to_text(def.material.restitution));
  require(!def.shape.vertices.empty(), "shape is empty; use make_disc, make_polygon, ...");
  const bool endless = def.shape.kind == ShapeKind::HalfPlane || def.shape.kind == ShapeKind::Chain;
  require(!endless || s.bodies.type[body] != BodyType::Dynamic,
          "a half-plane or chain has no mass and cannot belong to a dynamic body");

  std::uint32_t i;
  if (s.free_shapes.empty()) {
    i = static_cast<std::uint32_t>(s.shapes.size());
    s.shapes.emplace_back();
  } else {
    const auto lowest = std::min_element(s.free_shapes.begin(), s.free_shapes.end());
    i = *lowest;
    s.free_shapes.erase(lowest);
  }
  ShapeRecord& record = s.shapes[i];
  // Shapes are given in the frame of the definition, whose origin the centre of mass may have left by now.
  const Vec2 centre = s.centre[body];
  record.shape = centre == Vec2{} ? def.shape : translated(def.shape, -centre);
  record.density = s.bodies.type[body] == BodyType::Dynamic ? def.density : 0;
  record.material = def.material;
  record.friction_rule = def.friction_rule;
  record.restitution_rule = def.restitution_rule;
  record.filter = def.filter;
  record.sensor = def.sensor;
  record.alive = true;
  record.body = id;
  record.in_broad_phase = false;
  auto& list = s.shapes_of[body];
  list.insert(std::lower_bound(list.begin(), list.end(), i), i);
  update_mass(s, body);
  return {i, record.generation};
}

JointId World::create_joint(const JointDef& given) {
  WorldState& s = *state_;
  JointDef def = given;
  require(static_cast<bool>(def.b), "joint: body b must be given; body a may be none for the ground");
  const std::uint32_t b = slot(s, def.b);
  if (def.a) slot(s, def.a);
  require(def.a != def.b, "joint: both ends are body " + std::to_string(def.b.index));
  check_joint(def);

  std::uint32_t i;
  if (s.free_joints.empty()) {
    i = static_cast<std::uint32_t>(s.joints.size());
    s.joints.emplace_back();
  } else {
    const auto lowest = std::min_element(s.free_joints.begin(), s.free_joints.end());
    i = *lowest;
    s.free_joints.erase(lowest);
  }
  JointRecord& joint = s.joints[i];
  joint.def = def;
  joint.local_a = def.a ? to_local(s.bodies.pose(def.a.index), def.anchor_a) : def.anchor_a;
  joint.local_b = to_local(s.bodies.pose(b), def.anchor_b);
  const double angle_a = def.a ? s.bodies.angle[def.a.index] : 0;
  joint.reference_angle = s.bodies.angle[b] - angle_a;
  joint.local_axis = def.axis / length(def.axis);
  if (def.a && def.kind != JointKind::Rack)
    joint.local_axis = inverse_rotate(s.bodies.rotation[def.a.index], joint.local_axis);
  joint.alive = true;
  // What pulleys, gears and racks keep is the value of now.
  const bool keeps =
      def.kind == JointKind::Pulley || def.kind == JointKind::Gear || def.kind == JointKind::Rack;
  joint.length = keeps ? joint_coordinate(joint, joint_end(s, def.a.index), joint_end(s, b)).value
                       : def.length.value_or(length(def.anchor_b - def.anchor_a));
  for (const BodyId end : {def.a, def.b}) {
    if (end) touch(s, end.index);
  }
  s.joints_changed = true;
  if (def.a) s.joints_of[def.a.index].push_back(i);
  s.joints_of[b].push_back(i);
  return {i, joint.generation};
}

Vec2 World::joint_force(JointId id) const {
  const JointRecord& joint = state_->joints[slot(*state_, id)];
  return state_->report.h > 0 ? joint.impulse / state_->report.h : Vec2{};
}

double World::joint_torque(JointId id) const {
  const JointRecord& joint = state_->joints[slot(*state_, id)];
  return state_->report.h > 0 ? joint.angular_impulse / state_->report.h : 0;
}

double World::joint_position(JointId id) const {
  const JointRecord& joint = state_->joints[slot(*state_, id)];
  return joint_coordinate(joint, joint_end(*state_, joint.def.a.index), joint_end(*state_, joint.def.b.index))
      .value;
}

double World::joint_speed(JointId id) const {
  const JointRecord& joint = state_->joints[slot(*state_, id)];
  return joint_coordinate(joint, joint_end(*state_, joint.def.a.index), joint_end(*state_, joint.def.b.index))
      .rate;
}

void World::set_motor(JointId id, double speed, std::optional<double> limit) {
  JointRecord& joint = state_->joints[slot(*state_, id)];
  JointDef def = joint.def;
  def.motor_speed = speed;
  if (limit) def.motor_limit = *limit;
  check_joint(def);
  // Rows are counted by what the joint has; a new one renumbers those behind it.
  if (!joint.def.motor_speed) std::fill(std::begin(joint.row_force), std::end(joint.row_force), 0);
  for (const BodyId end : {def.a, def.b}) {
    if (end) touch(*state_, end.index);
  }
  joint.def = def;
}

void World::destroy(BodyId id) {
  WorldState& s = *state_;
  const std::uint32_t i = slot(s, id);
  touch(s, i);
  for (const std::uint32_t shape : s.shapes_of[i]) remove_shape(s, shape);
  s.shapes_of[i].clear();
  const std::vector<std::uint32_t> joints = s.joints_of[i];
  for (const std::uint32_t joint : joints) remove_joint(s, joint);
  s.joints_of[i].clear();
  std::erase(s.awake, i);
  std::erase(s.kinematic, i);
  s.local_index[i] = -1;
  BodyArrays& b = s.bodies;
  s.kept[i] = 1;
  b.alive[i] = 0;
  b.type[i] = BodyType::Static;
  b.velocity[i] = {};
  b.omega[i] = 0;
  b.mass[i] = b.inertia[i] = b.inverse_mass[i] = b.inverse_inertia[i] = 0;
  ++b.generation[i];
  s.names[i].clear();
  s.drag[i] = {};
  s.prescribed[i] = nullptr;
  s.free_bodies.push_back(i);
}

void World::destroy(ShapeId id) {
  WorldState& s = *state_;
  const std::uint32_t i = slot(s, id);
  const std::uint32_t body = s.shapes[i].body.index;
  touch(s, body);
  remove_shape(s, i);
  std::erase(s.shapes_of[body], i);
  update_mass(s, body);
}

void World::destroy(JointId id) {
  remove_joint(*state_, slot(*state_, id));
}

bool World::alive(BodyId id) const {
  const BodyArrays& b = state_->bodies;
  return id.index < b.size() && b.alive[id.index] && b.generation[id.index] == id.generation;
}

bool World::alive(ShapeId id) const {
  const auto& all = state_->shapes;
  return id.index < all.size() && all[id.index].alive && all[id.index].generation == id.generation;
}

bool World::alive(JointId id) const {
  const auto& all = state_->joints;
  return id.index < all.size() && all[id.index].alive && all[id.index].generation == id.generation;
}

Vec2 World::position(BodyId id) const {
  return state_->bodies.position[slot(*state_, id)];
}
double World::angle(BodyId id) const {
  return state_->bodies.angle[slot(*state_, id)];
}
Vec2 World::velocity(BodyId id) const {
  return state_->bodies.velocity[slot(*state_, id)];
}
double World::omega(BodyId id) const {
  return state_->bodies.omega[slot(*state_, id)];
}
double World::mass(BodyId id) const {
  return state_->bodies.mass[slot(*state_, id)];
}
double World::inertia(BodyId id) const {
  return state_->bodies.inertia[slot(*state_, id)];
}
Transform World::pose(BodyId id) const {
  return state_->bodies.pose(slot(*state_, id));
}
std::string_view World::name(BodyId id) const {
  return state_->names[slot(*state_, id)];
}

Vec2 World::velocity_at(BodyId id, Vec2 point_world) const {
  const std::uint32_t i = slot(*state_, id);
  const BodyArrays& b = state_->bodies;
  return b.velocity[i] + b.omega[i] * perp(point_world - b.position[i]);
}

void World::set_pose(BodyId id, Vec2 position, double angle) {
  const std::uint32_t i = slot(*state_, id);
  require_finite(position, "position");
  require_finite(angle, "angle");
  state_->bodies.position[i] = position;
  state_->bodies.angle[i] = angle;
  state_->bodies.rotation[i] = Rot::from_angle(angle);
  make_loose(*state_, i);
}

void World::set_velocity(BodyId id, Vec2 velocity, double omega) {
  const std::uint32_t i = slot(*state_, id);
  require_finite(velocity, "velocity");
  require_finite(omega, "omega");
  require(state_->bodies.type[i] != BodyType::Static, "a static body cannot have a velocity");
  if (state_->bodies.velocity[i] == velocity && state_->bodies.omega[i] == omega) return;
  touch(*state_, i);
  state_->bodies.velocity[i] = velocity;
  state_->bodies.omega[i] = omega;
}

void World::apply_force(BodyId id, Vec2 force, Vec2 point_world) {
  const std::uint32_t i = slot(*state_, id);
  require_finite(force, "force");
  require_finite(point_world, "point");
  touch(*state_, i);
  state_->bodies.force[i] += force;
  state_->bodies.torque[i] += cross(point_world - state_->bodies.position[i], force);
}

void World::apply_torque(BodyId id, double torque) {
  const std::uint32_t i = slot(*state_, id);
  require_finite(torque, "torque");
  touch(*state_, i);
  state_->bodies.torque[i] += torque;
}

void World::apply_impulse(BodyId id, Vec2 impulse, Vec2 point_world) {
  const std::uint32_t i = slot(*state_, id);
  require_finite(impulse, "impulse");
  require_finite(point_world, "point");
  touch(*state_, i);
  BodyArrays& b = state_->bodies;
  b.velocity[i] += b.inverse_mass[i] * impulse;
  b.omega[i] += b.inverse_inertia[i] * cross(point_world - b.position[i], impulse);
}

void World::set_force_field(ForceField field) {
  state_->field = std::move(field);
  state_->sleepers.wake_all(*state_);
}

void World::set_drag(BodyId id, const Drag& drag) {
  const std::uint32_t i = slot(*state_, id);
  require_at_least_zero(drag.linear, "linear drag");
  require_at_least_zero(drag.quadratic, "quadratic drag");
  require_at_least_zero(drag.angular, "angular drag");
  require_at_least_zero(drag.angular_quadratic, "angular_quadratic drag");
  require(state_->bodies.type[i] == BodyType::Dynamic, "drag: only dynamic bodies feel it");
  state_->drag[i] = drag;
}

void World::set_motion(BodyId id, PrescribedMotion motion) {
  const std::uint32_t i = slot(*state_, id);
  require(state_->bodies.type[i] == BodyType::Kinematic, "set_motion: the body must be kinematic");
  if (motion) {
    const Placement now = motion(state_->time);
    require_finite(now.position, "prescribed position");
    require_finite(now.angle, "prescribed angle");
    set_pose(id, now.position, now.angle);
  }
  state_->prescribed[i] = std::move(motion);
  state_->sleepers.wake_at(*state_, i);
}

void World::adopt_callbacks(const World& other) {
  WorldState& s = *state_;
  const WorldState& from = *other.state_;
  s.field = from.field;
  s.sleepers.wake_all(s);
  for (std::size_t i = 0; i < std::min(s.bodies.size(), from.bodies.size()); ++i) {
    const bool same = s.bodies.alive[i] && from.bodies.alive[i] &&
                      s.bodies.generation[i] == from.bodies.generation[i] &&
                      s.bodies.type[i] == BodyType::Kinematic;
    s.prescribed[i] = same ? from.prescribed[i] : PrescribedMotion{};
  }
}

const StepReport& World::report() const {
  return state_->report;
}
double World::time() const {
  return state_->time;
}
void World::observe(const Observe& what) {
  state_->observe = what;
}
const WorldConfig& World::config() const {
  return state_->config;
}

void World::set_accuracy(std::optional<double> accuracy) {
  require_accuracy(accuracy);
  state_->config.accuracy = accuracy;
  // Lengths that served another accuracy are no good first guess.
  for (StepMemory& memory : state_->step_memory) memory.inner_step = 0;
}

void World::set_gravity(Vec2 gravity) {
  require_finite(gravity, "gravity");
  if (gravity == state_->config.gravity) return;
  state_->config.gravity = gravity;
  state_->ledger.mark_all();
  state_->sleepers.wake_all(*state_);
}

bool World::asleep(BodyId id) const {
  return state_->bodies.asleep[slot(*state_, id)] != 0;
}

void World::wake(BodyId id) {
  touch(*state_, slot(*state_, id));
}

const BodyArrays& World::bodies() const {
  return state_->bodies;
}
std::span<const ShapeRecord> World::shapes() const {
  return state_->shapes;
}
std::span<const JointRecord> World::joints() const {
  return state_->joints;
}
const BroadPhase& World::broad_phase() const {
  return *state_->broad_phase;
}

BodyId World::body_id(std::size_t i) const {
  require(i < state_->bodies.size() && state_->bodies.alive[i], "no body in slot " + std::to_string(i));
  return {static_cast<std::uint32_t>(i), state_->bodies.generation[i]};
}

double World::kinetic_energy() const {
  return sum_bodies(state_->bodies, state_->config.gravity).kinetic;
}

double World::potential_energy() const {
  return sum_bodies(state_->bodies, state_->config.gravity).potential + spring_energy();
}

double World::spring_energy() const {
  double sum = 0;
  for (const JointRecord& joint : state_->joints) {
    if (!joint.alive || !(joint.def.stiffness > 0)) continue;
    JointRows rows;
    const int count =
        joint_rows(joint, joint_end(*state_, joint.def.a.index), joint_end(*state_, joint.def.b.index), rows);
    for (int k = 0; k < count; ++k) {
      const JointRow& row = rows[static_cast<std::size_t>(k)];
      if (row.kind == JointRowKind::Spring) sum += 0.5 * row.stiffness * row.error * row.error;
    }
  }
  return sum;
}

Vec2 World::momentum() const {
  return sum_bodies(state_->bodies, state_->config.gravity).momentum;
}

double World::angular_momentum() const {
  return sum_bodies(state_->bodies, state_->config.gravity).angular;
}

std::uint64_t World::state_hash() const {
  return sum_bodies(state_->bodies, state_->config.gravity).hash;
}

}  // namespace skerry
