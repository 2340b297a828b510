// SPDX-License-Identifier: MIT
//
// Ground that is told to move: half-planes move like boxes and chains, and carry, tilt and leave behind what
// lies on them.
#include <algorithm>
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <random>
#include <string>
#include <vector>

#include "tests/support/worlds.h"

namespace skerry {
namespace moving_ground_test {

constexpr double kStep = 1.0 / 60;

WorldConfig by(const std::string& stepper) {
  WorldConfig config;
  config.stepper = stepper;
  return config;
}

class MovingGroundBy : public testing::TestWithParam<const char*> {};

/// The ways of two boxes, one of which may bounce, and of a disc, on ground whose surface is 1 m above its
/// centre.
std::vector<Vec2> ways_on(const Shape& ground, const char* stepper, double bounce,
                          const std::function<void(World&, BodyId)>& move) {
  World world(by(stepper));
  const BodyId floor = world.create_body({.type = BodyType::Kinematic, .position = {0, -2}});
  world.add_shape(floor, test::rough(ground, 0.6));
  move(world, floor);
  const std::vector<BodyId> bodies{test::add(world, {-1.5, 0.2}, test::rough(make_box({0.6, 0.5}), 0.6)),
                                   test::add(world, {0, 0.5}, test::rough(make_box({0.6, 0.5}), 0.6, bounce)),
                                   test::add(world, {1.5, 0.8}, test::rough(make_disc(0.3), 0.6))};
  std::vector<Vec2> places;
  for (int k = 0; k < 80; ++k) {
    const StepReport& report = world.step(kStep);
    EXPECT_EQ(report.contained, 0) << "step " << k;
    EXPECT_LE(report.worst_penetration, 1e-9);
    for (const BodyId body : bodies) places.push_back(world.position(body));
  }
  return places;
}

TEST_P(MovingGroundBy, HalfPlaneMovesLikeABoxAndAChain) {
  const std::vector<Vec2> line{{-50, 1}, {50, 1}};
  const std::function<void(World&, BodyId)> ways[] = {
      [](World& world, BodyId floor) {
        world.set_velocity(floor, {3, -1}, 0);
      },
      [](World& world, BodyId floor) { world.set_velocity(floor, {}, 0.5); },
      [](World& world, BodyId floor) {
        world.set_velocity(floor, {1, 0.5}, -0.7);
      },
      [](World& world, BodyId floor) {
        world.set_motion(floor, [](double t) {
          return Placement{{0, -2 + 0.1 * std::sin(3 * t)}, 0.3 * std::sin(2 * t)};
        });
      }};
  for (const auto& move : ways) {
    // Where steps are cut, and so where bounces that die away end, may depend on the shape, but not by
    // events.
    const bool events = GetParam() == std::string("event_driven");
    const double bounce = events ? 0.4 : 0, near = events ? 1e-9 : 1e-5;
    const std::vector<Vec2> plane = ways_on(make_half_plane({0, 1}, {0, 1}), GetParam(), bounce, move);
    const std::vector<Vec2> box = ways_on(make_box({100, 2}), GetParam(), bounce, move);
    const std::vector<Vec2> chain = ways_on(make_chain(line), GetParam(), bounce, move);
    for (std::size_t i = 0; i < plane.size(); ++i) {
      ASSERT_LE(length(plane[i] - box[i]), near) << "step " << i / 3 << ", body " << i % 3;
      ASSERT_LE(length(plane[i] - chain[i]), near) << "step " << i / 3 << ", body " << i % 3;
    }
    EXPECT_LT(plane[plane.size() - 3].y, 1.2);
  }
}

/// What lies on a plane that is lifted, or goes down no faster than it would fall, stays on it.
TEST_P(MovingGroundBy, CarriesWhatLiesOnIt) {
  World world(by(GetParam()));
  const BodyId floor = world.create_body({.type = BodyType::Kinematic});
  world.add_shape(floor, test::rough(make_half_plane({0, 0}, {0, 1}), 0.5));
  const auto height = [](double t) { return 0.3 * (1 - std::cos(4 * t)); };
  world.set_motion(floor, [&](double t) { return Placement{{std::sin(t), height(t)}, 0}; });
  const BodyId box = test::add(world, {0, 0.25}, test::rough(make_box({0.5, 0.5}), 0.5), 1, {1, 0});
  for (int k = 0; k < 120; ++k) {
    world.step(kStep);
    const double t = world.time();
    ASSERT_NEAR(world.position(box).y, height(t) + 0.25, 1e-9) << t;
    ASSERT_NEAR(world.position(box).x, std::sin(t), 2e-4) << t;
  }
}

/// A block on ground that accelerates by a until it has the speed V slides V^2/(2 mu g) (1 - mu g/a) behind
/// it in all [Newmark 1965].
TEST_P(MovingGroundBy, LeavesASlidingBlockBehindByNewmarksFormula) {
  const double g = 9.81, mu = 0.2, a = 3.5, starts = 0.5, speed = a * starts;
  World world(by(GetParam()));
  const BodyId floor = world.create_body({.type = BodyType::Kinematic});
  world.add_shape(floor, test::rough(make_half_plane({0, 0}, {0, 1}), mu));
  world.set_motion(floor, [=](double t) {
    return Placement{{t < starts ? 0.5 * a * t * t : speed * (t - 0.5 * starts), 0}, 0};
  });
  const BodyId block = test::add(world, {0, 0.25}, test::rough(make_box({1, 0.5}), mu));
  while (world.time() < 2) world.step(kStep);
  const double behind = speed * speed / (2 * mu * g) * (1 - mu * g / a);
  EXPECT_NEAR(world.position(floor).x - world.position(block).x, behind, 1e-9);
  EXPECT_NEAR(world.velocity(block).x, speed, 1e-9);
}

/// The angle of nip: jaws grip a stone if their angle is less than twice that of friction, and squeeze it out
/// with V / tan(angle) else. Rigid bodies cannot be crushed, so the first one has no answer, and the report
/// must not call it one (that of its normals alone, which squeezes it out as well, was).
TEST_P(MovingGroundBy, JawsGripWhatTheyDoNotSqueezeOut) {
  constexpr double kFriction = 0.3, kSpeed = 0.4, kRadius = 0.3;
  const double grip = 2 * std::atan(kFriction);
  for (const double angle : {grip - 0.17, grip + 0.17, grip + 0.4}) {
    SCOPED_TRACE(angle);
    WorldConfig config = by(GetParam());
    config.gravity = {};
    World world(config);
    const BodyId left = world.create_body({.type = BodyType::Static});
    world.add_shape(left, test::rough(make_half_plane({0, 0}, {1, 0}), kFriction));
    const BodyId stone = test::add(world, {kRadius, 0}, test::rough(make_disc(kRadius), kFriction));
    // A face with the normal (-cos, sin) that the stone touches.
    const Vec2 normal{-std::cos(angle), std::sin(angle)};
    const BodyId right = world.create_body({.type = BodyType::Kinematic,
                                            .position = Vec2{kRadius, 0} - kRadius * normal,
                                            .velocity = {-kSpeed, 0}});
    world.add_shape(right, test::rough(make_half_plane({0, 0}, normal), kFriction));
    const StepReport& report = world.step(kStep);
    if (angle < grip) {
      EXPECT_GT(report.worst_residual, 0.1);
    } else {
      EXPECT_LT(report.worst_residual, 1e-9);
      EXPECT_NEAR(world.velocity(stone).y, kSpeed / std::tan(angle), 1e-9);
    }
  }
}

/// A press comes down on three boxes that do not stand quite on each other. Rigid bodies have no answer to
/// that, which the report says; without friction one of them would be shot out at 340 times the speed of the
/// press, as soon as its edges are tilted by a thousandth.
TEST_P(MovingGroundBy, APressShootsNothingOut) {
  World world(by(GetParam()));
  test::add_ground(world, test::rough(make_disc(1), 0.5));
  std::vector<BodyId> boxes;
  boxes.reserve(3);
  for (int i = 0; i < 3; ++i)
    boxes.push_back(test::add(world, {0.05 * i, 0.25 + 0.5 * i}, test::rough(make_box({0.5, 0.5}), 0.5)));
  const BodyId press =
      world.create_body({.type = BodyType::Kinematic, .position = {0, 1.8}, .velocity = {0, -0.5}});
  world.add_shape(press, test::rough(make_box({3, 0.2}), 0.5));
  double fastest = 0, residual = 0;
  for (int k = 0; k < 120; ++k) {
    const StepReport& report = world.step(kStep);
    residual = std::max(residual, report.worst_residual);
    for (const BodyId box : boxes) fastest = std::max(fastest, length(world.velocity(box)));
  }
  EXPECT_LT(fastest, 10);
  EXPECT_GT(residual, 0.1);
}

/// Twelve bodies in a pit under a press. @return the fastest that any of them gets [m/s]
double fastest_under_a_press(const WorldConfig& config, unsigned seed, double friction, double restitution) {
  World world(config);
  const BodyId pit = world.create_body({.type = BodyType::Static});
  for (const Shape& side : {make_half_plane({0, 0}, {0, 1}), make_half_plane({-1.5, 0}, {1, 0}),
                            make_half_plane({1.5, 0}, {-1, 0})})
    world.add_shape(pit, test::rough(side, friction, restitution));
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (random() / 4294967296.0);
  };
  std::vector<BodyId> bodies;
  for (int i = 0; i < 12; ++i) {
    const double x = uniform(-1, 1), angle = uniform(0, 3), size = uniform(0.3, 0.6);
    const Shape shape = random() % 2 == 1 ? make_disc(0.5 * size) : make_box({size, 0.4});
    bodies.push_back(test::add(world, {x, 0.4 + 0.5 * i}, test::rough(shape, friction, restitution),
                               uniform(0.5, 2), {}, 0, angle));
  }
  for (int k = 0; k < 120; ++k) world.step(kStep);
  double top = 0;
  for (const BodyId body : bodies) top = std::max(top, world.position(body).y);
  const BodyId press =
      world.create_body({.type = BodyType::Kinematic, .position = {0, top + 0.7}, .velocity = {0, -0.5}});
  world.add_shape(press, test::rough(make_box({2.98, 0.2}), friction, restitution));
  double fastest = 0;
  for (int k = 0; k < static_cast<int>(120 * (0.35 + 0.3 * top)); ++k) {
    world.step(kStep);
    for (const BodyId body : bodies) fastest = std::max(fastest, length(world.velocity(body)));
  }
  return fastest;
}

/// The same for what lies in a pit, smooth or rough, whether it bounces or not: each step, and each impact,
/// made it faster than the one before, up to 1e11 m/s.
TEST_P(MovingGroundBy, APressOnAHeapLeavesItSlow) {
  for (const char* law : {"reflections", "poisson", "simultaneous"}) {
    WorldConfig config = by(GetParam());
    config.impact_law = law;
    for (const unsigned seed : {33u, 40u, 68u}) {
      SCOPED_TRACE(testing::Message() << law << ", seed " << seed);
      EXPECT_LT(fastest_under_a_press(config, seed, 0, 0.5), 200);
    }
  }
}

/// Loads of rounding bring friction that is no number, and such a correction was taken for a good one.
TEST_P(MovingGroundBy, APressOnARoughHeapStaysWithinTheNumbers) {
  WorldConfig config = by(GetParam());
  config.impact_law = "poisson";
  EXPECT_LT(fastest_under_a_press(config, 47, 0.5, 0), 200);
}

INSTANTIATE_TEST_SUITE_P(By, MovingGroundBy, testing::Values("time_stepping", "event_driven"),
                         [](const auto& one) { return std::string(one.param); });

}  // namespace moving_ground_test
}  // namespace skerry
