// SPDX-License-Identifier: MIT
//
// Without gravity an edge that turns is thrown against the corner that it touches by its centripetal
// acceleration alone, and its bounces, which no weight ends, are shorter than what landings are found by.
#include <cmath>
#include <gtest/gtest.h>

#include "physics/snapshot.h"
#include "tests/support/draw.h"
#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace turning_bounces_test {

constexpr double kPi = 3.14159265358979323846;

/// A room with six square posts.
void add_room(World& world, const Material& surface) {
  const BodyId room = world.create_body({.type = BodyType::Static});
  for (int i = 0; i < 4; ++i) {
    const double side = i < 2 ? 2 : -2;
    const bool upright = i % 2 == 1;
    world.add_shape(
        room, {.shape = make_box(upright ? Vec2{1, 6} : Vec2{6, 1}, upright ? Vec2{side, 0} : Vec2{0, side}),
               .material = surface});
  }
  for (int i = 0; i < 6; ++i) {
    const double way = i * kPi / 3;
    world.add_shape(room,
                    {.shape = make_box({0.3, 0.3}, {1.3 * std::cos(way), 1.1 * std::sin(way)}, 0.78 + i),
                     .material = surface});
  }
}

/// Each step of a box is made from the state that events came to: of 400 boxes 39 had a step of 64 impacts,
/// and half of these left the velocity off by more than a tenth of it.
TEST(TurningBounces, ComeToAnEnd) {
  int many = 0, off = 0;
  for (int seed = 0; seed < test_scale(60); ++seed) {
    test::Draw draw(static_cast<unsigned>(seed));
    WorldConfig config = test::weightless();
    config.stepper = "event_driven";
    World exact(config);
    const Material surface{.friction = draw.one_in(2) ? 0 : draw.uniform(0, 0.5),
                           .restitution = draw.uniform(0.02, 0.6)};
    add_room(exact, surface);
    const BodyId box = exact.create_body({.position = {0.3, 0.1},
                                          .angle = draw.uniform(-3, 3),
                                          .velocity = {draw.uniform(-8, 8), draw.uniform(-8, 8)},
                                          .omega = draw.uniform(-60, 60)});
    const Vec2 half{draw.uniform(0.1, 0.4), draw.uniform(0.05, 0.2)};
    exact.add_shape(box, {.shape = make_box(2 * half), .material = surface});
    for (int i = 0; i < 60; ++i) {
      World stepped = load_snapshot(save_snapshot(exact));
      WorldConfig own = stepped.config();
      own.stepper = "time_stepping";
      stepped.reconfigure(own);
      exact.step(1.0 / 60);
      if (stepped.step(1.0 / 60).impacts < 32) continue;
      ++many;
      const Vec2 v = exact.velocity(box);
      off += length(stepped.velocity(box) - v) > 0.1 * length(v);
    }
  }
  EXPECT_LE(many, test_scale(60) / 60);
  EXPECT_EQ(off, 0);
}

}  // namespace turning_bounces_test
}  // namespace skerry
