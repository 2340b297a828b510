// SPDX-License-Identifier: MIT
//
// Worlds in one line, for tests.
#pragma once

#include <vector>

#include "physics/world.h"

namespace skerry::test {

/// Frictionless unless said otherwise, so that closed forms hold.
inline ShapeDef smooth(Shape shape, double restitution = 0) {
  ShapeDef def;
  def.shape = std::move(shape);
  def.material.friction = 0;
  def.material.restitution = restitution;
  return def;
}

inline ShapeDef rough(Shape shape, double friction, double restitution = 0) {
  ShapeDef def = smooth(std::move(shape), restitution);
  def.material.friction = friction;
  return def;
}

inline BodyId add(World& world, Vec2 position, const ShapeDef& shape, double mass = 1, Vec2 velocity = {},
                  double omega = 0, double angle = 0) {
  const BodyId body = world.create_body(
      {.position = position, .angle = angle, .velocity = velocity, .omega = omega, .mass = mass});
  world.add_shape(body, shape);
  return body;
}

/// Ground with its surface through the origin, tilted by `angle` [rad].
inline BodyId add_ground(World& world, const ShapeDef& like, double angle = 0) {
  const BodyId ground = world.create_body({.type = BodyType::Static});
  ShapeDef def = like;
  const Rot q = Rot::from_angle(angle);
  def.shape = make_half_plane({0, 0}, rotate(q, {0, 1}));
  world.add_shape(ground, def);
  return ground;
}

inline WorldConfig weightless() {
  WorldConfig config;
  config.gravity = {0, 0};
  return config;
}

/// `count` discs of radius 0.5 in a row along x, centres 1 m apart; disc i starts with velocities[i].
inline std::vector<BodyId> add_row(World& world, const std::vector<double>& velocities,
                                   double restitution = 1, double gap = 0) {
  std::vector<BodyId> discs;
  for (std::size_t i = 0; i < velocities.size(); ++i) {
    discs.push_back(add(world, {static_cast<double>(i) * (1 + gap), 0}, smooth(make_disc(0.5), restitution),
                        1, {velocities[i], 0}));
  }
  return discs;
}

}  // namespace skerry::test
