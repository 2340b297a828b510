// SPDX-License-Identifier: MIT
//
// What flows over a level of tiles, up ramps, and bounces: as it does alone.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <optional>
#include <vector>

#include "tests/support/draw.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace flow_ground_test {

using test::Draw;

constexpr double kStep = 1.0 / 60;

/// Bodies that slide side by side, and flow where there are more than a few points, or in a step that is as
/// poor as those of large worlds.
enum class Train { Boxes, Capsules, WideBox, Stack };

struct Sliders {
  World world;
  std::vector<BodyId> bodies;

  Sliders(Train kind, unsigned seed, double friction, std::optional<double> flow_work, double tile)
      : world(configured(flow_work)), friction_(friction) {
    Draw draw(seed);
    speed = draw.uniform(4, 15);
    level_ = draw.one_in(2) ? draw.uniform(-20, 20) : 0;
    const BodyId floor = world.create_body({.type = BodyType::Static, .position = {0, level_}});
    if (tile > 0) {
      for (int i = -14; i < 30; ++i)
        world.add_shape(floor,
                        {.shape = make_box({tile, 1}, {tile * i, -0.5}), .material = {.friction = friction}});
    } else {
      world.add_shape(floor, {.shape = make_half_plane({}, {0, 1}), .material = {.friction = friction}});
    }
    const double height = draw.uniform(0.3, 0.9), width = draw.uniform(1.1, 3);
    switch (kind) {
      case Train::Boxes:
        for (int i = 0; i < 12; ++i) put(make_box({0.6, 0.5}), {-0.6 * i, 0.25});
        break;
      case Train::Capsules:
        for (int i = 0; i < 12; ++i) put(make_capsule({-0.2, 0}, {0.2, 0}, 0.15), {-0.7 * i, 0.15});
        break;
      case Train::WideBox:
        put(make_box({width, height}), {0, 0.5 * height});
        break;
      case Train::Stack:
        for (int i = 0; i < 3; ++i) put(make_box({0.9, 0.3}), {0, 0.15 + 0.3 * i});
        break;
    }
  }

  void put(const Shape& shape, Vec2 at) {
    bodies.push_back(world.create_body({.position = {at.x, level_ + at.y}, .velocity = {speed, 0}}));
    world.add_shape(bodies.back(), {.shape = shape, .material = {.friction = friction_}});
  }

  double mean_speed() const {
    double momentum = 0, mass = 0;
    for (const BodyId body : bodies) {
      momentum += world.mass(body) * world.velocity(body).x;
      mass += world.mass(body);
    }
    return momentum / mass;
  }

  static WorldConfig configured(std::optional<double> flow_work) {
    WorldConfig config;
    config.stepper = "time_stepping";
    config.flow_work = flow_work;
    return config;
  }

  double speed = 0;

 private:
  double friction_, level_ = 0;
};

TEST(FlowOnTiles, IsNotHeldUpBySeams) {
  for (const Train kind : {Train::Boxes, Train::Capsules, Train::WideBox, Train::Stack}) {
    for (const std::optional<double> work : {std::optional<double>(), std::optional<double>(400)}) {
      for (const double friction : {0.0, 0.4}) {
        for (unsigned seed = 0; seed < 8; ++seed) {
          Sliders tiles(kind, seed, friction, work, 1), plane(kind, seed, friction, work, 0);
          int flowing = 0;
          for (int k = 0; k < 30; ++k) {
            flowing += tiles.world.step(kStep).islands_in_flow;
            plane.world.step(kStep);
          }
          const bool many = kind == Train::Boxes || kind == Train::Capsules;
          if (many) {
            EXPECT_GT(flowing, 0);
          }
          EXPECT_NEAR(tiles.mean_speed(), plane.mean_speed(), 0.02 * plane.speed)
              << "kind " << static_cast<int>(kind) << " friction " << friction << " work " << work.value_or(0)
              << " seed " << seed;
        }
      }
    }
  }
}

/// A box, wider than a tile, that meets a ramp loses what turns it, and friction.
TEST(FlowOnTiles, GoesUpRamps) {
  for (const double degrees : {10.0, 20.0, 30.0}) {
    std::vector<double> kept;
    for (const std::optional<double> work : {std::optional<double>(), std::optional<double>(400)}) {
      World world(Sliders::configured(work));
      const BodyId ground = world.create_body({.type = BodyType::Static});
      const double slope = degrees * kPi / 180;
      for (int i = 0; i < 8; ++i)
        world.add_shape(ground, {.shape = make_box({1, 1}, {-0.5 - i, -0.5}), .material = {.friction = 0}});
      world.add_shape(
          ground,
          {.shape = make_polygon(std::vector<Vec2>{{0, 0}, {20, 20 * std::tan(slope)}, {20, -1}, {0, -1}}),
           .material = {.friction = 0}});
      const BodyId box = world.create_body({.position = {-3, 0.25}, .velocity = {8, 0}});
      world.add_shape(box, {.shape = make_box({2.5, 0.5}), .material = {.friction = 0}});
      const double before = world.kinetic_energy() + world.potential_energy();
      double energy = before;
      for (int k = 0; k < 40; ++k) {
        const StepReport& report = world.step(kStep);
        energy = report.kinetic_energy + report.potential_energy;
      }
      kept.push_back(energy / before);
    }
    EXPECT_NEAR(kept[1], kept[0], 0.02) << degrees;
    EXPECT_GT(kept[0], 0.75) << degrees;
  }
}

/// Towers that are dropped tap to rest with some twenty impacts in a step.
TEST(FlowOnTiles, SmallTowersComeToRest) {
  int restless = 0;
  for (const int count : {3, 4, 5}) {
    for (unsigned seed = 0; seed < 8; ++seed) {
      Draw draw(seed);
      World world(Sliders::configured(400));
      test::add_ground(world, test::rough(make_box({1, 1}), draw.uniform(0.3, 0.8)));
      const double drop = draw.uniform(0.1, 1.5);
      for (int i = 0; i < count; ++i) {
        const BodyId box = world.create_body({.position = {draw.uniform(-0.1, 0.1), 0.5 + drop + i}});
        world.add_shape(box, {.shape = make_box({1, 1}), .material = {.friction = 0.6}});
      }
      for (int k = 0; k < 600 && world.report().bodies_asleep < count; ++k) world.step(kStep);
      restless += world.report().bodies_asleep < count;
    }
  }
  EXPECT_EQ(restless, 0);
}

/// Tiles, and bodies that are no more, cost nothing: what slides over a thousand of them does not flow.
TEST(FlowOnTiles, OfALevelMakesNoLargeWorld) {
  for (const bool gone : {false, true}) {
    World world;
    std::vector<BodyId> tiles;
    for (int i = 0; i < 1500; ++i) {
      const BodyId tile = world.create_body(
          {.type = gone ? BodyType::Dynamic : BodyType::Static, .position = {1.0 * i, -0.5}});
      world.add_shape(tile, {.shape = make_box({1, 1})});
      tiles.push_back(tile);
    }
    if (gone) {
      for (const BodyId tile : tiles) world.destroy(tile);
      test::add_ground(world, test::rough(make_box({1, 1}), 0.2));
    }
    for (int i = 0; i < 3; ++i) {
      const BodyId box = world.create_body({.position = {5, 0.15 + 0.3 * i}, .velocity = {8, 0}});
      world.add_shape(box, {.shape = make_box({0.9, 0.3}), .material = {.friction = 0.2}});
    }
    for (int k = 0; k < 60; ++k) ASSERT_EQ(world.step(kStep).islands_in_flow, 0) << "step " << k;
  }
}

/// A row of boxes side by side falls, and bounces as high as each alone.
TEST(FlowBounces, AreAsHighAsTheLawSays) {
  for (const double restitution : {0.3, 0.5}) {
    double sum = 0;
    const unsigned rows = 20;
    for (unsigned seed = 0; seed < rows; ++seed) {
      Draw draw(seed);
      World world(Sliders::configured({}));
      ShapeDef ground = test::rough(make_box({1, 1}), 0.5);
      ground.material.restitution = restitution;
      test::add_ground(world, ground);
      const double height = draw.uniform(1, 5);
      std::vector<BodyId> row;
      for (int i = 0; i < 20; ++i) {
        row.push_back(world.create_body({.position = {1.0 * i, 0.5 + height}}));
        world.add_shape(row.back(), {.shape = make_box({1, 1}),
                                     .material = {.friction = 0.5, .restitution = restitution}});
      }
      const double fall = std::sqrt(2 * height / 9.81);
      double top = 0;
      while (world.time() < fall * (1 + 2 * restitution)) {
        world.step(kStep);
        if (world.time() > fall * (1 + 0.5 * restitution))
          top = std::max(top, world.position(row[2]).y - 0.5);
      }
      sum += top / (restitution * restitution * height);
    }
    EXPECT_NEAR(sum / rows, 1, 0.03) << restitution;
  }
}

/// A pile that came to rest is struck by small discs. Where an attempt to step it exactly left the forces of
/// the points that touch alone, it fell for a step, by centimetres, and was lifted again in the next second.
TEST(FlowingPiles, DoNotSinkWhereTheyAreStruck) {
  Draw draw(2);
  World world(Sliders::configured(400));
  test::add_ground(world, test::rough(make_box({1, 1}), 0.5));
  const double half = 8.5;
  for (const double side : {-1.0, 1.0}) {
    const BodyId wall = world.create_body({.type = BodyType::Static});
    world.add_shape(wall, {.shape = make_half_plane({half * side, 0}, {-side, 0})});
  }
  const Material material{.friction = 0.5, .restitution = 0.3};
  std::vector<BodyId> pile;
  for (int i = 0; i < 300; ++i) {
    const double size = draw.uniform(0.4, 0.9);
    const int row = i / 14;
    const Vec2 at{-half + 0.9 + (i % 14) * 1.1, 1 + row * 1.1};
    pile.push_back(world.create_body({.position = at,
                                      .angle = draw.uniform(0, 1),
                                      .velocity = {draw.uniform(-3, 3), draw.uniform(-10, 0)},
                                      .omega = draw.uniform(-5, 5)}));
    world.add_shape(pile.back(), {.shape = i % 2 == 1 ? make_box({size, size}) : make_disc(0.5 * size),
                                  .density = 1000,
                                  .material = material});
  }
  for (int k = 0; k < 300; ++k) world.step(kStep);
  const auto mean_height = [&] {
    double moment = 0, mass = 0;
    for (const BodyId body : pile) {
      moment += world.mass(body) * world.position(body).y;
      mass += world.mass(body);
    }
    return moment / mass;
  };
  for (int drop = 0; drop < 4; ++drop) {
    double top = 0;
    for (const BodyId body : pile) top = std::max(top, world.position(body).y);
    const BodyId disc =
        world.create_body({.position = {draw.uniform(1 - half, half - 1), top + 3}, .velocity = {0, -8}});
    world.add_shape(disc, {.shape = make_disc(0.3), .density = 1000, .material = material});
    const double before = mean_height();
    double lowest = before;
    for (int k = 0; k < 90; ++k) {
      world.step(kStep);
      lowest = std::min(lowest, mean_height());
    }
    world.destroy(disc);
    EXPECT_GT(lowest, before - 0.01) << "drop " << drop;
  }
}

}  // namespace flow_ground_test
}  // namespace skerry
