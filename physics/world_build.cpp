// SPDX-License-Identifier: MIT
//
// Bodies and shapes of a world: making them, removing them, and the masses that follow.
#include <algorithm>
#include <cmath>

#include "physics/spare.h"
#include "physics/text.h"
#include "physics/world_access.h"
#include "physics/world_report.h"

namespace skerry {
namespace {

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
  b.number.push_back(-1);
  s.names.emplace_back();
  s.given_mass.emplace_back();
  s.given_inertia.emplace_back();
  s.shapes_of.emplace_back();
  s.joints_of.emplace_back();
  s.centre.emplace_back();
  s.radius.push_back(0);
  s.thickness.push_back(kInfinity);
  s.stray_guess.push_back(0);
  s.way.emplace_back();
  s.rerouted.push_back(0);
  s.acceleration.emplace_back();
  s.angular_acceleration.push_back(0);
  s.reach.push_back(0);
  s.travelled.push_back(0);
  s.allowance.push_back(0);
  s.strayed.push_back(0);
  s.flight.push_back(FlightKind::Bent);
  s.local_index.push_back(-1);
  s.rests.push_back(0);
  s.kept.push_back(0);
  s.drag.emplace_back();
  s.applied.emplace_back();
  s.prescribed.emplace_back();
  s.paths.emplace_back();
  s.step_memory.emplace_back();
  s.support.push_back(0);
  return static_cast<std::uint32_t>(b.position.size() - 1);
}

/// Neither it nor its inverse leaves the numbers.
bool has_inverse(double x) {
  return std::isfinite(x) && std::isfinite(1 / x);
}

double density_of(const WorldState& s, std::uint32_t shape) {
  const ShapeRecord& record = s.shapes[shape];
  return s.bodies.type[record.body.index] == BodyType::Dynamic ? record.density : 0;
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
    const double m = density_of(s, i) * p.area;
    mass += m;
    moment += m * p.centroid;
    second += density_of(s, i) * (p.second_moment + p.area * length_squared(p.centroid));
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
    for (const std::uint32_t i : s.shapes_of[body]) {
      SharedShape& shape = s.shapes[i].shape;
      shape = SharedShape(translated(shape, -centre));
      s.shape_pool.share(shape);
    }
    for (const std::uint32_t i : s.joints_of[body]) {
      JointRecord& joint = s.joints[i];
      if (joint.def.a.index == body) joint.local_a -= centre;
      if (joint.def.b.index == body) joint.local_b -= centre;
    }
    s.centre[body] += centre;
    const Vec2 shift = rotate(s.bodies.rotation[body], centre);
    const Vec2 before = s.bodies.position[body];
    s.bodies.position[body] += shift;
    // What moved by less than its place can tell has other manifolds all the same.
    if (s.bodies.position[body] == before) {
      for (Contact& contact : s.contacts)
        if (contact.body_a == body || contact.body_b == body) forget_poses(contact);
    }
    s.bodies.velocity[body] += s.bodies.omega[body] * perp(shift);
    s.bodies.torque[body] -= cross(shift, s.bodies.force[body]);
  }
  s.radius[body] = 0;
  s.thickness[body] = kInfinity;
  for (const std::uint32_t i : s.shapes_of[body]) {
    s.radius[body] = std::max(s.radius[body], std::min(bounding_radius(s.shapes[i].shape), kEndless));
    s.thickness[body] = std::min(s.thickness[body], half_width(s.shapes[i].shape));
  }

  if (s.bodies.type[body] != BodyType::Dynamic) return;
  if (s.given_mass[body]) {
    inertia = mass > 0 ? inertia * (*s.given_mass[body] / mass) : 0;
    mass = *s.given_mass[body];
  }
  if (s.given_inertia[body]) inertia = *s.given_inertia[body];
  // Without shapes it is as large as a ring of its mass: by its size turning counts as motion.
  if (s.shapes_of[body].empty() && mass > 0) s.radius[body] = std::sqrt(inertia / mass);
  s.bodies.mass[body] = mass;
  s.bodies.inertia[body] = inertia;
  s.bodies.inverse_mass[body] = mass > 0 ? 1 / mass : 0;
  s.bodies.inverse_inertia[body] = inertia > 0 && has_inverse(inertia) ? 1 / inertia : 0;
}

void drop_contacts_of_shape(WorldState& s, std::uint32_t shape) {
  s.table_changed |= std::erase_if(s.contacts, [&](const Contact& c) {
                       if (c.shape_a != shape && c.shape_b != shape) return false;
                       if (c.touched) s.parted.push_back(event_of(s, c, ContactEventKind::End));
                       return true;
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

void check_material(const Material& material) {
  require_at_least_zero(material.friction, "friction");
  const double held = material.static_friction.value_or(material.friction);
  require(held >= material.friction && std::isfinite(held),
          "static_friction must be finite and at least friction, got ", held, " and ", material.friction);
  require_at_least_zero(material.rolling_resistance, "rolling_resistance");
  require_finite(material.surface_velocity, "surface_velocity");
  require(material.restitution >= 0 && material.restitution <= 1, "restitution must be between 0 and 1, got ",
          material.restitution);
}

void check_mass(std::optional<double> mass, std::optional<double> inertia) {
  if (mass) {
    require(*mass > 0 && std::isfinite(*mass), "mass must be positive, got ", *mass);
    require(has_inverse(*mass), "mass must have an inverse, got ", *mass);
  }
  if (inertia) {
    require_at_least_zero(*inertia, "inertia");
    require(*inertia == 0 || has_inverse(*inertia), "inertia must have an inverse, got ", *inertia);
  }
}

/// What a body sums up over its shapes, with a further one, are numbers.
void check_area(const WorldState& s, std::uint32_t body, const Shape& shape, double density) {
  double mass = 0, second = 0;
  const auto add = [&](const Shape& of, double its_density) {
    const AreaProperties p = area_properties(of);
    mass += its_density * p.area;
    // A body without density has that of its area.
    second += std::max(its_density, 1.0) * (p.second_moment + p.area * length_squared(p.centroid));
  };
  add(shape, density);
  for (const std::uint32_t i : s.shapes_of[body]) add(s.shapes[i].shape, s.shapes[i].density);
  require(mass == 0 || has_inverse(mass), "shape: the mass of its body must have an inverse, got ", mass);
  require(std::isfinite(second), "shape: the moment of inertia of its body must be finite, got ", second);
}

bool is_endless(const Shape& shape) {
  return shape.kind == ShapeKind::HalfPlane || shape.kind == ShapeKind::Chain;
}

/// Nothing is known of its last step, and it is in the list of its type.
void begin_as(WorldState& s, std::uint32_t i, BodyType type) {
  BodyArrays& b = s.bodies;
  b.type[i] = type;
  b.mass[i] = b.inertia[i] = b.inverse_mass[i] = b.inverse_inertia[i] = 0;
  b.island[i] = -1;
  b.asleep[i] = 0;
  s.step_memory[i] = {};
  s.stray_guess[i] = 0;
  s.local_index[i] = -1;
  s.applied[i] = {};
  s.rests[i] = 0;
  s.kept[i] = type != BodyType::Dynamic;
  s.graph_known = false;
  const auto enter = [i](std::vector<std::uint32_t>& list) {
    list.insert(std::lower_bound(list.begin(), list.end(), i), i);
  };
  if (type == BodyType::Dynamic) {
    enter(s.awake);
    if (b.number[i] < 0) b.number[i] = b.numbered++;
  }
  if (type == BodyType::Kinematic) enter(s.kinematic);
}

/// No step of a joint between bodies that are held says what it bears any more.
void forget_unfelt_reaction(const WorldState& s, JointRecord& joint) {
  const auto held = [&s](BodyId end) { return !end || s.bodies.type[end.index] != BodyType::Dynamic; };
  if (!held(joint.def.a) || !held(joint.def.b)) return;
  joint.impulse = {};
  joint.angular_impulse = 0;
  std::fill(std::begin(joint.row_force), std::end(joint.row_force), 0);
  std::fill(std::begin(joint.row_impulse), std::end(joint.row_impulse), 0);
}

}  // namespace

BodyId World::create_body(const BodyDef& def) {
  require_finite(def.position, "position");
  require_finite(def.angle, "angle");
  require_finite(def.velocity, "velocity");
  require_finite(def.omega, "omega");
  require_finite(def.gravity_scale, "gravity_scale");
  check_mass(def.mass, def.inertia);

  WorldState& s = *state_;
  const std::uint32_t i = new_body_slot(s);
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
  b.alive[i] = 1;
  s.names[i] = def.name;
  s.given_mass[i] = def.mass;
  s.given_inertia[i] = def.inertia;
  s.centre[i] = {};
  s.radius[i] = 0;
  s.thickness[i] = kInfinity;
  begin_as(s, i, def.type);
  update_mass(s, i);
  return {i, b.generation[i]};
}

ShapeId World::add_shape(BodyId id, const ShapeDef& def) {
  WorldState& s = *state_;
  const std::uint32_t body = slot(s, id);
  require_at_least_zero(def.density, "density");
  check_material(def.material);
  require(!def.shape.vertices.empty(), "shape is empty; use make_disc, make_polygon, ...");
  require(!is_endless(def.shape) || s.bodies.type[body] != BodyType::Dynamic,
          "a half-plane or chain has no mass and cannot belong to a dynamic body");
  check_area(s, body, def.shape, def.density);

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
  record.shape = SharedShape(centre == Vec2{} ? def.shape : translated(def.shape, -centre));
  record.density = def.density;
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
  s.shape_pool.share(record.shape);
  return {i, record.generation};
}

void World::set_material(ShapeId id, const Material& material) {
  WorldState& s = *state_;
  const std::uint32_t i = slot(s, id);
  check_material(material);
  ShapeRecord& shape = s.shapes[i];
  shape.material = material;
  touch_definition(s, shape.body.index);
  for (Contact& contact : s.contacts) {
    if (contact.shape_a == i || contact.shape_b == i)
      mix_materials(contact, s.shapes[contact.shape_a], s.shapes[contact.shape_b]);
  }
}

void World::set_filter(ShapeId id, const Filter& filter) {
  WorldState& s = *state_;
  const std::uint32_t i = slot(s, id);
  s.shapes[i].filter = filter;
  touch_pairs(s, s.shapes[i].body.index);
}

namespace {

/// Contacts of what a body lies on, or carries, begin without impulses. Between bodies that are held fast any
/// squeeze is an answer, and the next one is looked for beside the last: what lay on others weighs on them no
/// more once it is held itself.
void forget_loads(WorldState& s, std::uint32_t body) {
  Spare<std::vector<std::uint8_t>> near;
  near->assign(s.bodies.size(), 0);
  (*near)[body] = 1;
  const auto spreads = [&](std::uint32_t i) {
    return (*near)[i] != 0 && (i == body || s.bodies.type[i] == BodyType::Dynamic);
  };
  for (bool more = true; more;) {
    more = false;
    for (const Contact& contact : s.contacts) {
      if (!contact.linked || (!spreads(contact.body_a) && !spreads(contact.body_b))) continue;
      for (const std::uint32_t i : {contact.body_a, contact.body_b}) {
        more |= (*near)[i] == 0;
        (*near)[i] = 1;
      }
    }
  }
  for (Contact& contact : s.contacts) {
    if (!contact.linked || (!spreads(contact.body_a) && !spreads(contact.body_b))) continue;
    for (PointMemory& memory : contact.points) memory.let_go();
  }
}

}  // namespace

void World::set_type(BodyId id, BodyType type) {
  WorldState& s = *state_;
  const std::uint32_t i = slot(s, id);
  BodyArrays& b = s.bodies;
  const BodyType before = b.type[i];
  if (type == before) return;
  for (const std::uint32_t shape : s.shapes_of[i]) {
    if (type == BodyType::Dynamic && is_endless(s.shapes[shape].shape)) {
      refuse("set_type: " + body_label(s, i) +
             " has a half-plane or chain, so no mass, and cannot be dynamic");
    }
  }
  touch_pairs(s, i);
  displace(s, i);
  std::erase(s.awake, i);
  std::erase(s.kinematic, i);
  begin_as(s, i, type);
  if (type == BodyType::Static) {
    b.velocity[i] = {};
    b.omega[i] = 0;
  }
  if (type != BodyType::Dynamic) {
    b.force[i] = {};
    b.torque[i] = 0;
    s.drag[i] = {};
  }
  s.prescribed[i] = nullptr;
  // The broad phase never looks for pairs of fixed boxes, and has to be told anew which box is one.
  for (const std::uint32_t shape : s.shapes_of[i]) {
    if ((type == BodyType::Static) == (before == BodyType::Static) || !s.shapes[shape].in_broad_phase)
      continue;
    s.broad_phase->remove(shape);
    s.shapes[shape].in_broad_phase = false;
  }
  for (const std::uint32_t joint : s.joints_of[i]) forget_unfelt_reaction(s, s.joints[joint]);
  forget_loads(s, i);
  update_mass(s, i);
}

void World::set_mass(BodyId id, std::optional<double> mass, std::optional<double> inertia) {
  WorldState& s = *state_;
  const std::uint32_t i = slot(s, id);
  check_mass(mass, inertia);
  s.given_mass[i] = mass;
  s.given_inertia[i] = inertia;
  update_mass(s, i);
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

bool World::alive(BodyId id) const {
  const BodyArrays& b = state_->bodies;
  return id.index < b.size() && b.alive[id.index] && b.generation[id.index] == id.generation;
}

bool World::alive(ShapeId id) const {
  const auto& all = state_->shapes;
  return id.index < all.size() && all[id.index].alive && all[id.index].generation == id.generation;
}

}  // namespace skerry
