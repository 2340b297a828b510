// SPDX-License-Identifier: MIT
//
// What a world is made of, so that the same one can be made again: as it is, or as someone sees it who stands
// on his head, moves along, or measures in other units.
#pragma once

#include <algorithm>
#include <functional>
#include <vector>

#include "physics/world.h"

namespace skerry::test {

struct Recipe {
  struct Part {
    BodyDef body;
    std::vector<ShapeDef> shapes;
    Drag drag{};
    std::function<Placement(double)> motion{};  ///< of a kinematic body, if it is prescribed
  };
  /// A joint between parts; -1: the ground.
  struct Link {
    JointDef joint;
    int a = -1, b = -1;
  };

  Vec2 gravity{0, -9.81};
  std::vector<Part> parts;
  std::vector<Link> links;
};

/// A world by its recipe. @return the bodies, by part
inline std::vector<BodyId> build(const Recipe& recipe, World& world) {
  world.set_gravity(recipe.gravity);
  std::vector<BodyId> bodies;
  for (const Recipe::Part& part : recipe.parts) {
    const BodyId body = world.create_body(part.body);
    for (const ShapeDef& shape : part.shapes) world.add_shape(body, shape);
    if (part.drag.any()) world.set_drag(body, part.drag);
    if (part.motion) world.set_motion(body, part.motion);
    bodies.push_back(body);
  }
  const auto body_of = [&](int part) { return part < 0 ? BodyId{} : bodies[static_cast<std::size_t>(part)]; };
  for (const Recipe::Link& link : recipe.links) {
    JointDef joint = link.joint;
    joint.a = body_of(link.a);
    joint.b = body_of(link.b);
    world.create_joint(joint);
  }
  return bodies;
}

/// Largest distance of the places of two ways [m].
inline double apart(const std::vector<Vec2>& a, const std::vector<Vec2>& b) {
  double worst = 0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, length(a[i] - b[i]));
  return worst;
}

}  // namespace skerry::test
