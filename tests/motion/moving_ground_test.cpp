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

#include "tests/support/draw.h"
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

/// Landings are looked for along parabolas: what swings through a radian in a step is nowhere near its own.
/// Nearly all discs in a box that is shaken at 29 Hz were outside of it after two seconds.
TEST_P(MovingGroundBy, ABoxThatIsShakenHoldsWhatIsInIt) {
  constexpr double kInner = 1, kWall = 0.1;
  const Shape shapes[] = {make_disc(0.1), make_box({0.2, 0.14}), make_capsule({-0.1, 0}, {0.1, 0}, 0.05)};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(0, 1);
  for (const double angle : {1.0, 2.0, 3.0}) {  // [rad a step]
    int lost = 0;
    for (int run = 0; run < 12; ++run) {
      World world(by(GetParam()));
      const BodyId box = world.create_body({.type = BodyType::Kinematic});
      const double friction = any(random), phase = 6 * any(random), swing = 0.1 + 0.4 * any(random);
      for (int side = 0; side < 4; ++side) {
        const Rot turn = Rot::from_angle(0.5 * kPi * side);
        const Shape wall = make_box({2 * kInner + 2 * kWall, kWall}, rotate(turn, {0, kInner + 0.5 * kWall}),
                                    0.5 * kPi * side);
        world.add_shape(box, test::rough(wall, friction));
      }
      world.set_motion(box, [=](double t) {
        const double x = std::sin(60 * angle * t + phase) - std::sin(phase);
        return Placement{{0.3 * x, 0}, swing * (std::sin(54 * angle * t + phase) - std::sin(phase))};
      });
      const BodyId body =
          test::add(world, {any(random) - 0.5, any(random) - 0.5}, test::rough(shapes[run % 3], friction));
      for (int step = 0; step < 120; ++step) world.step(kStep);
      const Vec2 place =
          inverse_rotate(Rot::from_angle(world.angle(box)), world.position(body) - world.position(box));
      lost += std::max(std::abs(place.x), std::abs(place.y)) > kInner;
    }
    EXPECT_EQ(lost, 0) << angle << " rad a step";
  }
}

/// A box that turns is made 3 cm in a floor, and a disc flies 4 mm beside it: to be lifted out costs the disc
/// nothing. It lost a tenth of its speed.
TEST_P(MovingGroundBy, WhatIsLiftedOutOfTheGroundBrakesNothingElse) {
  for (const BodyType type : {BodyType::Static, BodyType::Kinematic}) {
    World world(by(GetParam()));
    const BodyId floor = world.create_body({.type = type});
    world.add_shape(floor, {.shape = make_box({10, 1}, {0, -0.5})});
    const BodyId box = world.create_body({.position = {0, 0.22}, .velocity = {1, 0}, .omega = 2});
    world.add_shape(box, {.shape = make_box({0.5, 0.5})});
    const BodyId disc = world.create_body({.position = {0.504, 0.6}, .velocity = {1, -1}});
    world.add_shape(disc, {.shape = make_disc(0.25)});
    world.step(kStep);
    EXPECT_NEAR(world.velocity(disc).x, 1, 1e-12);
    EXPECT_NEAR(world.velocity(disc).y, -1 - 9.81 * kStep, 1e-12);
  }
}

/// Of the velocity of a ball at rest after what moves as told struck it in a first step, without loss.
void expect_elastic_blow(const char* stepper, double gap, double mass, const PrescribedMotion& motion,
                         double speed) {
  WorldConfig config = test::weightless();
  config.stepper = stepper;
  World world(config);
  const BodyId table = world.create_body({.type = BodyType::Kinematic});
  world.add_shape(table, test::smooth(make_box({2, 1}), 1));
  world.set_motion(table, motion);
  const BodyId ball = test::add(world, {0, 0.6 + gap}, test::smooth(make_disc(0.1), 1), mass);
  world.step(kStep);
  EXPECT_NEAR(world.velocity(ball).y, 2 * speed, 1e-9 * speed) << "gap " << gap << ", mass " << mass;
}

/// What it may bring is neither what it brings when the step begins, nor less than that by rounding, by which
/// every other ball did not bounce.
TEST_P(MovingGroundBy, ABlowWithoutLossMakesABallTwiceAsFast) {
  for (const double mass : {0.3, 1.0, 7.0}) {
    for (const double gap : {0.003, 0.005, 0.01}) {
      // From rest, with 100 m/s^2; at constant speed.
      expect_elastic_blow(
          GetParam(), gap, mass,
          [](double t) {
            return Placement{{0, 50 * t * t}, 0};
          },
          std::sqrt(200 * gap));
      for (const double speed : {1.1, 3.0, 7.7})
        expect_elastic_blow(
            GetParam(), gap, mass,
            [=](double t) {
              return Placement{{0, speed * t}, 0};
            },
            speed);
    }
  }
}

/// Speed of a part on a table that swings along 30 degrees, with a peak of 1.5 g upwards: it slides on, and
/// flies, a little in each swing [m/s].
double speed_on_a_feeder(const char* stepper, double frequency, double h) {
  constexpr double kTime = 4, kStart = -10;
  World world(by(stepper));
  const BodyId table = world.create_body({.type = BodyType::Kinematic});
  world.add_shape(table, test::rough(make_box({40, 1}), 0.4));
  const double omega = 2 * kPi * frequency, amplitude = 1.5 * 9.81 / (0.5 * omega * omega);
  world.set_motion(table, [=](double t) {
    const double s = amplitude * std::sin(omega * t);
    return Placement{{s * std::cos(kPi / 6), 0.5 * s}, 0};
  });
  const BodyId part = test::add(world, {kStart, 0.525}, test::rough(make_box({0.1, 0.05}), 0.4));
  for (int k = 0; k < std::lround(kTime / h); ++k) world.step(h);
  return (world.position(part).x - kStart) / kTime;
}

TEST(Feeder, CarriesPartsAsFastInWholeStepsAsByEvents) {
  for (const double frequency : {5.0, 16.0, 25.0, 50.0}) {
    const double known = speed_on_a_feeder("event_driven", frequency, kStep);
    EXPECT_NEAR(speed_on_a_feeder("time_stepping", frequency, kStep), known, 0.03 * known)
        << frequency << " Hz";
  }
}

/// Where bodies that slide into each other on a floor of this type are after two thirds of a second.
std::vector<Vec2> places_on(BodyType type, const char* stepper, unsigned seed) {
  test::Draw draw(seed);
  World world(by(stepper));
  const BodyId floor = world.create_body({.type = type});
  world.add_shape(floor, test::rough(make_half_plane({0, 0}, {0, 1}), draw.uniform(0.2, 0.8)));
  std::vector<BodyId> bodies;
  bodies.reserve(4);
  for (int k = 0; k < 4; ++k) {
    const double size = draw.uniform(0.2, 0.4);
    const Shape shape = draw.one_in(2) ? make_disc(0.5 * size) : make_box({size, size});
    bodies.push_back(test::add(world, {0.45 * k, 0.5 * size},
                               test::rough(shape, draw.one_in(3) ? 0 : draw.uniform(0.1, 1)),
                               draw.uniform(0.5, 2), {draw.uniform(-2, 2), 0}));
  }
  for (int step = 0; step < 40; ++step) world.step(kStep);
  std::vector<Vec2> places;
  places.reserve(bodies.size());
  for (const BodyId body : bodies) places.push_back(world.position(body));
  return places;
}

/// What moving ground may bring, and what it takes, is nothing where it stands.
TEST_P(MovingGroundBy, GroundThatStandsIsAsIfItWereFixed) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const std::vector<Vec2> fixed = places_on(BodyType::Static, GetParam(), seed),
                            told = places_on(BodyType::Kinematic, GetParam(), seed);
    for (std::size_t k = 0; k < fixed.size(); ++k)
      EXPECT_EQ(told[k], fixed[k]) << "seed " << seed << ", body " << k;
  }
}

/// Five bodies between a wall that comes at 5 m/s and one that stands.
struct Squeeze {
  World world;
  BodyId wall;
  std::vector<BodyId> bodies;
  double room = 0;  ///< [m^2]

  Squeeze(const char* stepper, unsigned seed) : world(by(stepper)) {
    test::Draw draw(seed);
    const BodyId ground = world.create_body({.type = BodyType::Static});
    world.add_shape(ground, test::rough(make_half_plane({0, 0}, {0, 1}), 0.5));
    world.add_shape(ground, test::rough(make_box({0.2, 6}, {2.1, 3}), 0.5));
    wall = world.create_body({.type = BodyType::Kinematic, .position = {-2.1, 3}, .velocity = {5, 0}});
    world.add_shape(wall, test::rough(make_box({0.2, 5.98}), 0.5));
    for (int k = 0; k < 5; ++k) {
      const double size = draw.uniform(0.2, 0.4), density = std::pow(10, draw.uniform(1, 5));
      const Shape shape =
          draw.one_in(2) ? make_disc(0.5 * size) : make_box({size, size * draw.uniform(0.4, 1)});
      const BodyId body = world.create_body({.position = {-1.6 + 0.6 * k, 0.5 * size + 0.01}});
      const double friction = draw.uniform(0, 1);
      world.add_shape(body, {.shape = shape, .density = density, .material = {.friction = friction}});
      bodies.push_back(body);
      room += size * size;
    }
  }

  const StepReport& step() {
    if (world.position(wall).x > 1.5 - room) world.set_velocity(wall, {}, 0);
    return world.step(kStep);
  }
};

/// Where they jam, each of dozens of pieces of a step had impacts and forces without an answer, to the end of
/// the work that a step may cost: a second. Light ones took what heavy ones might have been given, and flew
/// off at 300 m/s.
TEST_P(MovingGroundBy, WhatIsSqueezedCostsLittleAndStays) {
  double fastest = 0, most = 0;
  for (const unsigned seed : {5u, 31u, 55u, 72u, 139u, 171u}) {
    Squeeze squeeze(GetParam(), seed);
    for (int step = 0; step < 60; ++step) {
      most = std::max(most, squeeze.step().work.visits);
      for (const BodyId body : squeeze.bodies)
        fastest = std::max(fastest, length(squeeze.world.velocity(body)));
    }
    for (const BodyId body : squeeze.bodies) {
      const Vec2 place = squeeze.world.position(body);
      EXPECT_GT(place.y, 0) << seed;
      EXPECT_TRUE(place.y > 5.9 || (place.x < 2 && place.x > squeeze.world.position(squeeze.wall).x)) << seed;
    }
  }
  EXPECT_LT(most, 3e7);
  if (std::string(GetParam()) == "time_stepping") {
    EXPECT_LT(fastest, 33 * 5);
  }
}

INSTANTIATE_TEST_SUITE_P(By, MovingGroundBy, testing::Values("time_stepping", "event_driven"),
                         [](const auto& one) { return std::string(one.param); });

/// What a rope holds to a ground that moves on swings as if the ground stood.
TEST(MovingGround, ARopeOnItSwingsAsOnGroundThatStands) {
  for (const Vec2 start : {Vec2{-2, 0}, Vec2{-1.5, -1.2}}) {
    Vec2 ends[2];
    for (const bool moves : {false, true}) {
      World world;
      const BodyId ground =
          world.create_body({.type = BodyType::Kinematic, .velocity = {moves ? 3.0 : 0.0, 0}});
      world.add_shape(ground, test::smooth(make_disc(0.1)));
      const BodyId bob =
          test::add(world, start, test::smooth(make_disc(0.2)), 1, world.bodies().velocity[ground.index]);
      world.create_joint({.kind = JointKind::Rope,
                          .a = ground,
                          .b = bob,
                          .anchor_a = {0, 0},
                          .anchor_b = start,
                          .length = 2});
      for (int k = 0; k < 120; ++k) world.step(1.0 / 60);
      ends[moves ? 1 : 0] = world.position(bob) - world.position(ground);
    }
    EXPECT_LE(length(ends[1] - ends[0]), 2e-3);
  }
}

}  // namespace moving_ground_test
}  // namespace skerry
