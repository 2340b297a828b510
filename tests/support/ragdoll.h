// SPDX-License-Identifier: MIT
//
// A body of limbs and hinges, for tests and benchmarks.
#pragma once

#include <vector>

#include "tests/support/worlds.h"

namespace skerry::test {

/// A hinge and where it is on its two bodies, at angle 0.
struct Hinge {
  JointId joint;
  BodyId a, b;
  Vec2 on_a, on_b;
};

struct Ragdoll {
  std::vector<BodyId> limbs;
  std::vector<Hinge> hinges;
};

/// Eleven limbs of density 1, ten hinges, 2.6 m tall. @param limit  of each angle, both ways [rad]; 0: none
inline Ragdoll add_ragdoll(World& world, Vec2 at, Vec2 velocity, double friction, double limit = 0) {
  Ragdoll all;
  std::vector<Vec2> places;
  const auto limb = [&](Vec2 where, Vec2 half) {
    all.limbs.push_back(world.create_body({.position = at + where, .velocity = velocity}));
    ShapeDef def = rough(half.y > 0 ? make_box({2 * half.x, 2 * half.y}) : make_disc(half.x), friction);
    def.density = 1;
    world.add_shape(all.limbs.back(), def);
    places.push_back(where);
  };
  const auto hinge = [&](std::size_t a, std::size_t b, Vec2 where) {
    JointDef def{.a = all.limbs[a], .b = all.limbs[b], .anchor_a = at + where};
    if (limit > 0) {
      def.lower = -limit;
      def.upper = limit;
    }
    all.hinges.push_back(
        {world.create_joint(def), all.limbs[a], all.limbs[b], where - places[a], where - places[b]});
  };
  limb({0, 0}, {0.15, 0.2});
  limb({0, 0.55}, {0.17, 0.3});
  limb({0, 1.1}, {0.17, 0});
  hinge(0, 1, {0, 0.22});
  hinge(1, 2, {0, 0.88});
  for (const double side : {-1.0, 1.0}) {
    const std::size_t k = all.limbs.size();
    limb({0.1 * side, -0.5}, {0.07, 0.25});
    limb({0.1 * side, -1.05}, {0.06, 0.25});
    limb({0.4 * side, 0.75}, {0.18, 0.05});
    limb({0.8 * side, 0.75}, {0.18, 0.045});
    hinge(0, k, {0.1 * side, -0.22});
    hinge(k, k + 1, {0.1 * side, -0.77});
    hinge(1, k + 2, {0.2 * side, 0.75});
    hinge(k + 2, k + 3, {0.6 * side, 0.75});
  }
  return all;
}

}  // namespace skerry::test
