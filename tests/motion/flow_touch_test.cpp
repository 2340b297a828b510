// SPDX-License-Identifier: MIT
//
// What events say of what is pressed far out of each other in flow.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <set>
#include <utility>

#include "physics/narrowphase/queries.h"
#include "tests/support/draw.h"
#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace flow_touch_test {

/// Piles that come down at 40 m/s: manifolds that followed shifts of half a body in a straight line had 747
/// of 7300 touch that were more than a millimetre apart, up to 0.26 m.
TEST(FlowTouch, BeginsWhereBodiesTouch) {
  int looked = 0, apart = 0;
  double farthest = 0;
  for (int seed = 0; seed < test_scale(2); ++seed) {
    test::Draw draw(static_cast<unsigned>(seed));
    WorldConfig config;
    config.flow_work = 400;
    World world(config);
    test::add_ground(world, test::rough(make_disc(1), 0.5));
    const BodyId shaft = world.create_body({.type = BodyType::Static});
    for (const double side : {-4.0, 4.0})
      world.add_shape(shaft, test::rough(make_box({0.5, 60}, {side, 30}), 0.5));
    for (int i = 0; i < 200; ++i) {
      const double size = draw.uniform(0.3, 0.8), row = std::floor(i / 8.0);
      const BodyId body =
          world.create_body({.position = {-3.3 + 0.9 * (i % 8) + draw.uniform(-0.05, 0.05), 0.6 + 0.9 * row},
                             .angle = draw.uniform(-1, 1),
                             .velocity = {0, -40}});
      const Shape shape = i % 2 == 1 ? make_box({size, size * draw.uniform(0.4, 1)}) : make_disc(0.5 * size);
      world.add_shape(body, test::rough(shape, 0.4));
    }
    std::set<std::pair<std::uint32_t, std::uint32_t>> touching;
    for (int k = 0; k < 20; ++k) {
      for (const ContactEvent& event : world.step(1.0 / 60).events) {
        const std::pair<std::uint32_t, std::uint32_t> pair =
            std::minmax(event.shape_a.index, event.shape_b.index);
        if (event.kind == ContactEventKind::Begin) touching.insert(pair);
        if (event.kind == ContactEventKind::End) touching.erase(pair);
      }
      for (const auto& [one, other] : touching) {
        const ShapeRecord &a = world.shapes()[one], &b = world.shapes()[other];
        const double gap = distance(a.shape, world.pose(a.body), b.shape, world.pose(b.body)).distance;
        ++looked;
        apart += gap > 1e-3;
        farthest = std::max(farthest, gap);
      }
    }
  }
  std::printf("%d of %d that touch are apart, by up to %.2g m\n", apart, looked, farthest);
  EXPECT_GT(looked, 1000);
  EXPECT_LE(apart, looked / 1000);
  EXPECT_LT(farthest, 0.01);
}

}  // namespace flow_touch_test
}  // namespace skerry
