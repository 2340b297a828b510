// SPDX-License-Identifier: MIT
//
// Bridges for tests.
#pragma once

#include <string_view>
#include <vector>

#include "physics/statics/bridge.h"
#include "tests/statics/trusses.h"

namespace skerry::statics::test {

/// A Pratt truss with two axles that come from the left at 4 m/s.
inline BridgeDef truss_bridge(int panels) {
  BridgeDef def;
  def.structure = pratt(panels);
  for (Member& m : def.structure.members) {
    m.strength = 2.35e8;
    m.density = 7850;
  }
  for (int i = 0; i <= panels; ++i) def.deck.push_back(i);
  def.train = {{1e5, 8e4}, {1.5}, 4, -1};
  return def;
}

/// The bodies of this name that there are.
inline std::vector<BodyId> bodies_named(const World& world, std::string_view name) {
  std::vector<BodyId> found;
  for (std::size_t i = 0; i < world.bodies().size(); ++i)
    if (world.bodies().alive[i] && world.name(world.body_id(i)) == name) found.push_back(world.body_id(i));
  return found;
}

/// Where the wheels of all wagons are, in the order of the axles.
inline std::vector<Vec2> wheels(const World& world, const Bridge& bridge) {
  std::vector<Vec2> found;
  for (const BodyId wagon : bridge.wagons())
    for (const ShapeRecord& shape : world.shapes())
      if (shape.alive && shape.body == wagon && shape.shape->kind == ShapeKind::Disc)
        found.push_back(to_world(world.pose(wagon), shape.shape->vertices[0]));
  return found;
}

}  // namespace skerry::statics::test
