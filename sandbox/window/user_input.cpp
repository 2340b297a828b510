// SPDX-License-Identifier: MIT
#include "sandbox/window/user_input.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace skerry::sandbox {
namespace {

constexpr double kHandRate = 2 * kPi * 4;  // of the spring [1/s]
constexpr double kSwingRate = 4;           // of the damping of its turning [1/s]
// Strongest pull in units of the body's weight (or of 10 m/s^2, where there is no gravity).
constexpr double kHandStrength = 60;

Shape spawned_shape(SpawnKind kind, double size) {
  switch (kind) {
    case SpawnKind::Disc:
      return make_disc(size);
    case SpawnKind::Box:
      return make_box({2 * size, 2 * size});
    case SpawnKind::Capsule:
      return make_capsule({-size, 0}, {size, 0}, 0.5 * size);
    case SpawnKind::Hexagon:
      break;
  }
  std::vector<Vec2> corners;
  corners.reserve(6);
  for (int i = 0; i < 6; ++i) corners.push_back(size * rotate(Rot::from_angle(i * kPi / 3), {1, 0}));
  return make_polygon(corners);
}

void change_methods(const std::vector<std::string>& names, World& world) {
  WorldConfig config = world.config();
  std::string* const fields[] = {&config.solver, &config.stepper, &config.broad_phase, &config.impact_law};
  for (std::size_t i = 0; i < std::min(names.size(), std::size(fields)); ++i) *fields[i] = names[i];
  world.reconfigure(config);
}

void turn_over(World& world, BodyId body) {
  const bool moves = world.bodies().type[body.index] == BodyType::Dynamic;
  world.set_type(body, moves ? BodyType::Static : BodyType::Dynamic);
}

}  // namespace

std::string_view to_string(SpawnKind kind) {
  static constexpr std::string_view kNames[kSpawnKinds] = {"disc", "box", "capsule", "hexagon"};
  return kNames[static_cast<int>(kind)];
}

void fields(Archive& archive, UserInput& input) {
  auto& [step, kind, body, at, spawn, size, methods] = input;
  archive(step, kind, body.index, body.generation, at.x, at.y, spawn, size, methods);
}

Vec2 Hand::grip(const World& world) const {
  return to_world(world.pose(body_), local_);
}

void Hand::grab(const World& world, BodyId body, Vec2 at) {
  body_ = body;
  local_ = to_local(world.pose(body), at);
  target_ = at;
}

void Hand::pull(World& world, double h) {
  if (!holds()) return;
  if (!world.alive(body_)) {
    release();
    return;
  }
  const Vec2 at = grip(world);
  const Vec2 r = at - world.position(body_);
  const Vec2 v = world.velocity_at(body_, at);
  // Backward Euler of x'' = -2 w x' - w^2 x: stable for any step, and rational, so the same bits everywhere.
  const Vec2 wanted =
      (1 / ((1 + h * kHandRate) * (1 + h * kHandRate))) * (v - h * kHandRate * kHandRate * (at - target_));
  const std::size_t i = body_.index;
  const BodyArrays& bodies = world.bodies();
  const Vec2 gravity = bodies.gravity_scale[i] * world.config().gravity;
  const Vec2 acceleration = (1 / h) * (wanted - v) - gravity;
  // Inverse mass at the point: K = 1/m + [-r]' 1/I [-r]; F = K^-1 a.
  const double m = bodies.inverse_mass[i], turn = bodies.inverse_inertia[i];
  const double k11 = m + turn * r.y * r.y, k22 = m + turn * r.x * r.x, k12 = -turn * r.x * r.y;
  const double determinant = k11 * k22 - k12 * k12;
  if (!(determinant > 0)) return;
  Vec2 force{(k22 * acceleration.x - k12 * acceleration.y) / determinant,
             (k11 * acceleration.y - k12 * acceleration.x) / determinant};
  const double strongest = kHandStrength * bodies.mass[i] * std::max(length(gravity), 10.0);
  const double size = length(force);
  if (size > strongest) force = (strongest / size) * force;
  if (!is_finite(force)) return;
  world.apply_force(body_, force, at);
  // A body that hangs at the hand comes to rest: its turning about the grip is damped.
  const double swing = bodies.inertia[i] + bodies.mass[i] * length_squared(r);
  world.apply_torque(body_, -swing * bodies.omega[i] * std::min(kSwingRate, 0.5 / h));
}

void apply_input(const UserInput& input, const Material& material, World& world, Hand& hand) {
  switch (input.kind) {
    case InputKind::Grab:
      if (world.alive(input.body)) hand.grab(world, input.body, input.at);
      break;
    case InputKind::Drag:
      hand.move(input.at);
      break;
    case InputKind::Release:
      hand.release();
      break;
    case InputKind::Spawn: {
      // The shape first: a size that it refuses must not leave a body without one.
      const Shape shape = spawned_shape(input.spawn, input.size);
      const BodyId body = world.create_body({.position = input.at});
      world.add_shape(body, {.shape = shape, .material = material});
      break;
    }
    case InputKind::Remove:
      if (world.alive(input.body)) world.destroy(input.body);
      break;
    case InputKind::Methods:
      change_methods(input.methods, world);
      break;
    case InputKind::Hold:
      if (world.alive(input.body)) turn_over(world, input.body);
      break;
  }
}

bool is_loose(const World& world, BodyId body, std::span<const UserInput> inputs) {
  if (!world.alive(body)) return false;
  const BodyType type = world.bodies().type[body.index];
  return type == BodyType::Dynamic ||
         (type == BodyType::Static && std::any_of(inputs.begin(), inputs.end(), [&](const UserInput& input) {
            return input.kind == InputKind::Hold && input.body == body;
          }));
}

BodyId pick_body(const World& world, Vec2 point, double slack, std::span<const UserInput> inputs) {
  BodyId best{};
  bool solid = false;
  const auto offer = [&](ShapeId id) {
    const ShapeRecord& shape = world.shapes()[id.index];
    // Drawn later lies above; sensors are seen through.
    const bool above = !best || std::pair(!shape.sensor, shape.body.index) > std::pair(solid, best.index);
    if (!above || !is_loose(world, shape.body, inputs)) return;
    best = shape.body;
    solid = !shape.sensor;
  };
  for (const ShapeId shape : world.shapes_at(point)) offer(shape);
  if (best || !(slack > 0)) return best;
  for (const ShapeId shape : world.shapes_overlapping(make_disc(slack), {point, Rot{}})) offer(shape);
  return best;
}

}  // namespace skerry::sandbox
