// SPDX-License-Identifier: MIT
//
// What comes to rest, or to roll, while others push it: steps of 1/60 s against events, which find each
// moment to rounding.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <vector>

#include "tests/support/draw.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace stops_in_company_test {

using test::Draw;

ShapeDef surface(Shape shape, double density, double friction, double rolling = 0, double speed = 0) {
  ShapeDef def;
  def.shape = std::move(shape);
  def.density = density;
  def.material.friction = friction;
  def.material.rolling_resistance = rolling;
  def.material.surface_velocity = speed;
  return def;
}

BodyId put(World& world, Vec2 at, double angle, Vec2 velocity, double omega, const ShapeDef& shape) {
  BodyDef def;
  def.position = at;
  def.angle = angle;
  def.velocity = velocity;
  def.omega = omega;
  const BodyId body = world.create_body(def);
  world.add_shape(body, shape);
  return body;
}

using Build = void (*)(World&, Draw&);

/// Largest distance of what the two steppers make of a scene, over `seconds`: of places, and of angles by 1
/// m.
double apart(Build build, unsigned seed, double seconds) {
  WorldConfig config;
  config.stepper = "time_stepping";
  World steps(config);
  config.stepper = "event_driven";
  World events(config);
  Draw one(seed), same(seed);
  build(steps, one);
  build(events, same);
  double worst = 0;
  for (int k = 0; k < static_cast<int>(60 * seconds); ++k) {
    steps.step(1.0 / 60);
    events.step(1.0 / 60);
    const BodyArrays &a = steps.bodies(), &b = events.bodies();
    for (std::size_t i = 0; i < a.size(); ++i) {
      if (a.type[i] != BodyType::Dynamic) continue;
      const double gyration = std::sqrt(a.inertia[i] / a.mass[i]);
      worst = std::max({worst, length(a.position[i] - b.position[i]),
                        std::min(1.0, gyration) * std::abs(a.angle[i] - b.angle[i])});
    }
  }
  return worst;
}

/// In how many of so many scenes they differ by more than `most` [m].
int wrong(Build build, int seeds, double most) {
  int count = 0;
  for (unsigned seed = 0; seed < static_cast<unsigned>(seeds); ++seed) {
    const double d = apart(build, seed, 0.75);
    if (d <= most) continue;
    std::printf("seed %u: %.1e m\n", seed, d);
    ++count;
  }
  return count;
}

/// A disc between a belt that runs and another one that a spring, or its weight, presses on it: up to 9 rows.
void between_belts(World& world, Draw& draw) {
  const double radius = draw.uniform(0.1, 0.5);
  const BodyId ground = world.create_body({.type = BodyType::Static});
  world.add_shape(ground,
                  surface(make_half_plane({0, 0}, {0, 1}), 1, draw.uniform(0, 1), 0, draw.uniform(-3, 3)));
  const Vec2 above{0, 2 * radius + 0.1};
  const BodyId belt =
      put(world, above, 0, {}, 0,
          surface(make_box({6, 0.2}), draw.uniform(10, 1000), draw.uniform(0, 1), 0, draw.uniform(-3, 3)));
  JointDef guide;
  guide.kind = JointKind::Prismatic;
  guide.b = belt;
  guide.anchor_a = guide.anchor_b = above;
  guide.axis = {0, 1};
  world.create_joint(guide);
  put(world, {0, radius}, 0, {draw.uniform(-1, 1), 0}, draw.uniform(-5, 5),
      surface(make_disc(radius), 1000, 1, draw.one_in(2) ? draw.uniform(0, 0.1) * radius : 0));
}

/// A disc that rolls and slides on a slope, or a belt on it, with resistance to rolling.
void disc_on_slope(World& world, Draw& draw) {
  const double slope = draw.uniform(-0.6, 0.6), radius = draw.uniform(0.02, 0.5);
  const Vec2 up{-std::sin(slope), std::cos(slope)}, along{std::cos(slope), std::sin(slope)};
  const BodyId ground = world.create_body({.type = BodyType::Static});
  world.add_shape(
      ground, surface(make_half_plane({0, 0}, up), 1, 1, draw.one_in(2) ? radius * draw.uniform(0, 0.3) : 0,
                      draw.one_in(3) ? draw.uniform(-3, 3) : 0));
  const double friction = draw.uniform(0, 1);
  put(world, radius * up, 0, draw.uniform(-4, 4) * along, draw.uniform(-8, 8) / radius,
      surface(make_disc(radius), 1000, friction * friction));
}

/// A slab on a slope under a block or a disc that may weigh much more.
void two_on_slope(World& world, Draw& draw) {
  const double slope = draw.uniform(-0.5, 0.5), thick = draw.uniform(0.1, 0.5),
               small = draw.uniform(0.1, 0.4);
  const Vec2 up{-std::sin(slope), std::cos(slope)}, along{std::cos(slope), std::sin(slope)};
  const BodyId ground = world.create_body({.type = BodyType::Static});
  world.add_shape(ground, surface(make_half_plane({0, 0}, up), 1, draw.uniform(0, 1)));
  put(world, 0.5 * thick * up, slope, draw.uniform(-3, 3) * along, 0,
      surface(make_box({6, thick}), 1000, draw.uniform(0, 1)));
  const bool round = draw.one_in(2);
  put(world, (thick + 0.5 * small) * up, slope, draw.uniform(-1, 1) * along, round ? draw.uniform(-5, 5) : 0,
      surface(round ? make_disc(0.5 * small) : make_box({small, small}), std::pow(10, draw.uniform(1, 5)),
              draw.uniform(0, 1)));
}

/// A block on a plank that turns about its middle with it, and slides to rest on it.
void on_a_seesaw(World& world, Draw& draw) {
  const double half = draw.uniform(1, 3), slope = draw.uniform(-0.3, 0.3), size = draw.uniform(0.1, 0.3);
  const Vec2 up{-std::sin(slope), std::cos(slope)}, along{std::cos(slope), std::sin(slope)};
  const BodyId plank = put(world, {}, slope, {}, 0,
                           surface(make_box({2 * half, 0.1}), std::pow(10, draw.uniform(1.7, 3.3)), 1));
  JointDef pin;
  pin.kind = JointKind::Revolute;
  pin.b = plank;
  world.create_joint(pin);
  const double place = draw.uniform(-0.8, -0.2) * half;
  put(world, place * along + (0.05 + 0.5 * size) * up, slope, {}, 0,
      surface(make_box({size, size}), std::pow(10, draw.uniform(2, 4)), draw.uniform(0, 0.5)));
}

TEST(StopsInCompany, OfADiscBetweenBelts) {
  EXPECT_LE(wrong(between_belts, 60, 1e-12), 2);
}

TEST(StopsInCompany, OfADiscOnASlope) {
  EXPECT_EQ(wrong(disc_on_slope, 150, 1e-12), 0);
}

TEST(StopsInCompany, OfASlabUnderWhatIsHeavy) {
  EXPECT_EQ(wrong(two_on_slope, 80, 1e-12), 0);
}

TEST(StopsInCompany, OfABlockOnASeesaw) {
  EXPECT_EQ(wrong(on_a_seesaw, 100, 4e-3), 0);
}

/// A tall block on a belt tips over a corner: the other one leaves the ground within half a step.
TEST(StopsInCompany, OfABlockThatTipsOver) {
  struct Case {
    double slope, friction, belt, speed;
    Vec2 size;
  };
  for (const Case& c : {Case{-0.1218, 0.5823, -2.864, 0.2055, {0.0665, 0.2095}},
                        Case{-0.3561, 0.7207, -2.139, -0.7062, {0.0976, 0.4658}}}) {
    std::vector<Vec2> places;
    for (const char* stepper : {"time_stepping", "event_driven"}) {
      WorldConfig config;
      config.stepper = stepper;
      World world(config);
      const Vec2 up{-std::sin(c.slope), std::cos(c.slope)}, along{std::cos(c.slope), std::sin(c.slope)};
      const BodyId ground = world.create_body({.type = BodyType::Static});
      world.add_shape(ground, surface(make_half_plane({0, 0}, up), 1, c.friction, 0, c.belt));
      const BodyId block = put(world, 0.5 * c.size.y * up, c.slope, c.speed * along, 0,
                               surface(make_box(c.size), 1000, c.friction));
      for (int step = 0; step < 20; ++step) world.step(1.0 / 60);
      places.push_back(world.position(block));
    }
    EXPECT_LT(length(places[0] - places[1]), 1e-3) << c.slope;
  }
}

}  // namespace stops_in_company_test
}  // namespace skerry
