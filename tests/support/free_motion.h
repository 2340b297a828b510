// SPDX-License-Identifier: MIT
//
// What steps must keep in a world without ground and forces.
#pragma once

#include <cmath>
#include <gtest/gtest.h>

#include "physics/world.h"

namespace skerry::test {

/// Makes steps and expects both momenta to stay and the kinetic energy not to grow.
/// @param turn  of the angular momentum, relative to the linear one [m]  @return steps with islands in flow
inline int expect_free_motion(World& world, double h, int steps, double turn) {
  const Vec2 momentum = world.momentum();
  const double spin = world.angular_momentum();
  double energy = world.kinetic_energy();
  int flowing = 0;
  for (int k = 0; k < steps; ++k) {
    flowing += world.step(h).islands_in_flow > 0;
    EXPECT_LE(length(world.momentum() - momentum), 1e-12 * length(momentum)) << k;
    EXPECT_LE(std::abs(world.angular_momentum() - spin), turn * length(momentum)) << k;
    EXPECT_LE(world.kinetic_energy(), energy * (1 + 1e-12)) << k;
    energy = world.kinetic_energy();
  }
  return flowing;
}

}  // namespace skerry::test
