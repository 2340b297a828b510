// SPDX-License-Identifier: MIT
//
// Nothing passes through anything, however thin: small bodies that land on thin boards and turn about a
// corner that rests, and what bounces to and fro more often than a step has impacts.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "tests/support/draw.h"
#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace thin_test {

class Thin : public testing::TestWithParam<const char*> {
 protected:
  static World make_world() {
    WorldConfig config = test::weightless();
    config.stepper = GetParam();
    return World(config);
  }
};

struct Case {
  const char* name;
  Shape shape;
  double size, board, speed, friction, h;  ///< [m, m, m/s, 1, s]
};

/// With the corner that was struck at rest, the others were looked at only where the piece ended: a stick
/// that turned by a radian was past the board by then, 150 of 1000.
TEST_P(Thin, BoardsHoldWhatIsThrownOntoThem) {
  const Case cases[] = {
      {"stick", make_box({0.05, 0.005}), 0.05, 0.01, 8, 0.3, 1.0 / 60},
      {"smooth stick", make_box({0.05, 0.005}), 0.05, 0.01, 8, 0, 1.0 / 60},
      {"capsule", make_capsule({-0.025, 0}, {0.025, 0}, 0.00625), 0.05, 0.01, 8, 0.3, 1.0 / 60},
      {"die", make_box({0.01, 0.01}), 0.01, 0.003, 3, 0.3, 1.0 / 30},
      {"bullet", make_box({0.05, 0.005}), 0.05, 0.01, 32, 0.3, 1.0 / 240}};
  for (const Case& one : cases) {
    int through = 0;
    for (int seed = 0; seed < test_scale(60); ++seed) {
      test::Draw draw(static_cast<unsigned>(seed));
      World world = make_world();
      world.add_shape(world.create_body({.type = BodyType::Static}),
                      test::rough(make_box({100, one.board}, {0, -one.board / 2}), one.friction));
      const double way = draw.uniform(-3, -0.1);
      const auto body = world.create_body({.position = {0, 3 * one.size},
                                           .angle = draw.uniform(0, 6),
                                           .velocity = one.speed * Vec2{std::cos(way), std::sin(way)},
                                           .omega = draw.uniform(-10, 10)});
      world.add_shape(body, test::rough(one.shape, one.friction));
      for (int i = 0; i * one.h < 0.3; ++i) world.step(one.h);
      through += world.position(body).y < 0;
    }
    EXPECT_EQ(through, 0) << one.name;
  }
}

/// What landed in the last piece of a step, after 64 impacts, bounced for all of that: through the other
/// board.
TEST_P(Thin, BoardsHoldWhatBouncesBetweenThem) {
  for (const double speed : {45.0, 100.0, 1000.0}) {
    for (const double restitution : {1.0, 0.95}) {
      World world = make_world();
      const auto boards = world.create_body({.type = BodyType::Static});
      for (const double y : {-0.05, 1.06})
        world.add_shape(boards, test::smooth(make_box({10, 0.1}, {0, y}), restitution));
      const auto disc =
          test::add(world, {0, 0.505}, test::smooth(make_disc(0.5), restitution), 1, {0, speed});
      double energy = 0.5 * speed * speed;
      for (int i = 0; i < 20; ++i) {
        const StepReport& report = world.step(1.0 / 60);
        EXPECT_NEAR(world.position(disc).y, 0.505, 0.0051) << speed << " m/s, step " << i;
        EXPECT_LE(report.kinetic_energy, energy * (1 + 1e-12)) << speed << " m/s, step " << i;
        energy = report.kinetic_energy;
      }
    }
  }
}

/// The same in a cup, with others in the way. What is as far from the wall as foreseen points do not reach
/// passes it still: 8 of 420, where 347 did.
TEST_P(Thin, CupsHoldWhatBouncesInThem) {
  int lost = 0;
  for (int seed = 0; seed < test_scale(8); ++seed) {
    test::Draw draw(static_cast<unsigned>(seed));
    World world = make_world();
    const auto cup = world.create_body({.type = BodyType::Static});
    for (const auto& [size, at] : {std::pair{Vec2{1.1, 0.05}, Vec2{0, -0.525}},
                                   {Vec2{1.1, 0.05}, Vec2{0, 0.525}},
                                   {Vec2{0.05, 1.1}, Vec2{-0.525, 0}},
                                   {Vec2{0.05, 1.1}, Vec2{0.525, 0}}})
      world.add_shape(cup, test::smooth(make_box(size, at), 0.95));
    std::vector<BodyId> discs;
    for (int k = 0; k < 7; ++k) {
      const int column = k % 3, row = k / 3;
      const double way = draw.uniform(0, 6.3);
      discs.push_back(test::add(world, {0.28 * column - 0.28, 0.28 * row - 0.28},
                                test::smooth(make_disc(0.1), 0.95), 1,
                                300 * Vec2{std::cos(way), std::sin(way)}));
    }
    for (int i = 0; i < 30; ++i) world.step(1.0 / 60);
    for (const BodyId disc : discs)
      lost += std::max(std::abs(world.position(disc).x), std::abs(world.position(disc).y)) > 0.5;
  }
  EXPECT_LE(lost, test_scale(8) / 4);
}

/// Sweeps that leave a part of a blow let what others press on go on into the wall, and past its middle it
/// was pushed out behind: of 800 volleys 147 and 722 lost some in a large world, 90 at 300 m/s in a small
/// one.
TEST(ThinWalls, HoldVolleys) {
  struct Volley {
    double speed;
    int others;  ///< bodies elsewhere, that make the world large
  };
  for (const Volley& each : {Volley{100, 1000}, Volley{300, 1000}, Volley{300, 0}}) {
    int lost = 0;
    for (int seed = 0; seed < test_scale(40); ++seed) {
      test::Draw draw(static_cast<unsigned>(seed));
      WorldConfig config = test::weightless();
      config.stepper = "time_stepping";
      World world(config);
      for (int i = 0; i < each.others; ++i) test::add(world, {1000.0 + i, 0}, test::smooth(make_disc(0.4)));
      const BodyId wall = world.create_body({.type = BodyType::Static});
      world.add_shape(wall, test::rough(make_box({0.05, 200}), 0.5));
      std::vector<BodyId> thrown;
      const int count = 5 + draw.pick(36);
      for (int i = 0; i < count; ++i) {
        const double size = draw.uniform(0.2, 0.6);
        const Shape shape =
            i % 2 == 1 ? make_box({size, size * draw.uniform(0.4, 1)}) : make_disc(0.5 * size);
        thrown.push_back(world.create_body({.position = {-1.2 - 0.7 * (i % 6), 0.7 * std::floor(i / 6.0)},
                                            .angle = draw.uniform(0, 3),
                                            .velocity = {each.speed, 0},
                                            .omega = draw.uniform(-5, 5)}));
        world.add_shape(thrown.back(), test::rough(shape, 0.4));
      }
      for (int i = 0; i < 6; ++i) world.step(1.0 / 60);
      lost +=
          std::any_of(thrown.begin(), thrown.end(), [&](BodyId body) { return world.position(body).x > 0; });
    }
    EXPECT_EQ(lost, 0) << each.speed << " m/s, " << each.others << " others";
  }
}

INSTANTIATE_TEST_SUITE_P(Steppers, Thin, testing::Values("time_stepping", "event_driven", "auto"),
                         [](const testing::TestParamInfo<const char*>& test) {
                           return std::string(test.param);
                         });

}  // namespace thin_test
}  // namespace skerry
