// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdio>

#include "physics/islands/delassus.h"
#include "physics/statics/limit_load.h"
#include "physics/world.h"

// Links what solves linear programs, too.
auto* volatile load = &skerry::statics::limit_load;

int main() {
  skerry::World world({.gravity = {0, -10}});
  const skerry::BodyId ball = world.create_body({.position = {0, 5}, .mass = 1});
  world.add_shape(ball, {.shape = skerry::make_disc(0.5)});
  for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
  std::printf("fell %.12f m\n", 5 - world.position(ball).y);
  return std::abs(5 - world.position(ball).y - 5) < 1e-12 && load ? 0 : 1;
}
