// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <type_traits>

#include "physics/joint_rows.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace world_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;
using test::weightless;

template <class Call>
std::string message_of(Call&& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no exception";
}

TEST(Force, OffTheCentreAcceleratesByFOverMAndTurnsByRCrossFOverI) {
  World world(weightless());
  const auto box = world.create_body({.position = {1, 2}, .mass = 3.0});
  world.add_shape(box, smooth(make_box({2, 1})));
  const Vec2 force{4, -5};
  const Vec2 point{1.7, 2.4};
  const double h = 0.01;
  world.apply_force(box, force, point);
  world.step(h);
  const double inertia = 3.0 * (4 + 1) / 12;
  EXPECT_NEAR(world.inertia(box), inertia, 1e-14);
  EXPECT_NEAR(world.velocity(box).x, h * force.x / 3, 1e-16);
  EXPECT_NEAR(world.velocity(box).y, h * force.y / 3, 1e-16);
  EXPECT_NEAR(world.omega(box), h * cross(Vec2{0.7, 0.4}, force) / inertia, 1e-15);
  // The force acted for one step only.
  world.step(h);
  EXPECT_NEAR(world.velocity(box).x, h * force.x / 3, 1e-16);
}

TEST(Force, TorqueAndImpulseFollowTheirDefinitions) {
  World world(weightless());
  const auto disc = add(world, {0, 0}, smooth(make_disc(0.5)), 2);
  world.apply_torque(disc, 0.3);
  world.step(0.1);
  EXPECT_NEAR(world.omega(disc), 0.03 / 0.25, 1e-15);
  world.apply_impulse(disc, {0, 4}, {0.5, world.position(disc).y});
  EXPECT_NEAR(world.velocity(disc).y, 2, 1e-15);
  EXPECT_NEAR(world.omega(disc), 0.03 / 0.25 + 2 / 0.25, 1e-13);
}

TEST(Rest, BoxOnTheGroundStaysWhereItIs) {
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  const auto box = add(world, {0, 0.5}, rough(make_box({1, 1}), 0.5), 2);
  world.observe({.contacts = true});
  for (int i = 0; i < 600; ++i) world.step(1.0 / 60);
  EXPECT_NEAR(world.position(box).y, 0.5, 1e-12);
  EXPECT_NEAR(world.position(box).x, 0, 1e-12);
  EXPECT_NEAR(world.angle(box), 0, 1e-12);
  ASSERT_EQ(world.report().contacts_list.size(), 1u);
  const ContactReport& contact = world.report().contacts_list[0];
  EXPECT_EQ(contact.count, 2);
  EXPECT_NEAR(contact.points[0].normal_impulse + contact.points[1].normal_impulse, 2 * 9.81 / 60, 1e-12);
  EXPECT_NEAR(contact.points[0].normal_impulse, contact.points[1].normal_impulse, 1e-12);
}

TEST(Rest, ContactOfAStackCarriesTheWeightAboveIt) {
  World world;
  add_ground(world, smooth(make_disc(1)));
  const int count = 10;
  for (int i = 0; i < count; ++i) add(world, {0, i + 0.5}, smooth(make_box({1, 1})), 1 + i);
  world.observe({.contacts = true});
  for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
  ASSERT_EQ(world.report().contacts_list.size(), static_cast<std::size_t>(count));
  for (int k = 0; k < count; ++k) {
    double above = 0;
    for (int i = k; i < count; ++i) above += 1 + i;
    const ContactReport& contact = world.report().contacts_list[k];
    EXPECT_NEAR(contact.points[0].normal_impulse + contact.points[1].normal_impulse, above * 9.81 / 60, 1e-10)
        << k;
  }
  EXPECT_LE(world.report().worst_penetration, 1e-10);
  EXPECT_EQ(world.report().inexact_islands, 0);
}

TEST(Rest, PlankOnTwoSupportsSharesItsWeightByMomentsAndTheFarContactOpens) {
  // Plank of length 4 on supports at x = -1 and x = 1; a heavy weight on its right overhang tips it about x
  // = 1.
  World world;
  const auto supports = world.create_body({.type = BodyType::Static});
  world.add_shape(supports, smooth(make_disc(0.1, {-1, -0.1})));
  world.add_shape(supports, smooth(make_disc(0.1, {1, -0.1})));
  const auto plank = add(world, {0.25, 0.05}, smooth(make_box({4, 0.1})), 8);
  world.observe({.contacts = true});
  world.step(1e-3);
  const auto forces = [&] {
    double left = 0, right = 0;
    for (const ContactReport& c : world.report().contacts_list) {
      for (int i = 0; i < c.count; ++i) {
        EXPECT_GE(c.points[i].normal_impulse, 0);
        (c.points[i].position.x < 0 ? left : right) += c.points[i].normal_impulse / 1e-3;
      }
    }
    return std::pair(left, right);
  };
  // Moments about the supports: R_left = m g (1 - 0.25) / 2.
  EXPECT_NEAR(forces().first, 8 * 9.81 * 0.75 / 2, 1e-9);
  EXPECT_NEAR(forces().second, 8 * 9.81 * 1.25 / 2, 1e-9);

  world.apply_force(plank, {0, -200}, {2.2, 0.1});
  world.step(1e-3);
  EXPECT_EQ(forces().first, 0);
  EXPECT_GT(forces().second, 200);
  EXPECT_LT(world.omega(plank), 0);
}

TEST(Building, RefusesBadArgumentsWithTheirValues) {
  World world;
  EXPECT_NE(message_of([&] {
              world.create_body({.position = {NAN, 0}});
            }).find("(nan, 0)"),
            std::string::npos);
  EXPECT_NE(message_of([&] { world.create_body({.mass = -2.0}); }).find("-2"), std::string::npos);
  EXPECT_NE(message_of([&] { world.step(0); }).find("got 0"), std::string::npos);
  EXPECT_NE(message_of([&] { world.step(NAN); }).find("nan"), std::string::npos);
  const auto body = world.create_body({});
  ShapeDef def = smooth(make_disc(1));
  def.material.restitution = 1.5;
  EXPECT_NE(message_of([&] { world.add_shape(body, def); }).find("1.5"), std::string::npos);
  EXPECT_NE(message_of([&] {
              world.add_shape(body, smooth(make_half_plane({0, 0}, {0, 1})));
            }).find("dynamic"),
            std::string::npos);
  EXPECT_NE(message_of([&] { world.step(0.1); }).find("no mass"), std::string::npos);
  EXPECT_NE(message_of([&] { World({.solver = "magic"}); }).find("magic"), std::string::npos);
  EXPECT_NE(message_of([&] { World({.broad_phase = "magic"}); }).find("magic"), std::string::npos);
  EXPECT_NE(message_of([&] { World({.stepper = "magic"}); }).find("time_stepping"), std::string::npos);
  EXPECT_NE(message_of([&] { world.shapes_overlapping({}, {}); }).find("shape is empty"), std::string::npos);
  EXPECT_NE(message_of([&] { world.shape_cast({}, {}, {1, 0}); }).find("shape is empty"), std::string::npos);
  for (const double wrong : {-1.0, static_cast<double>(NAN)}) {
    EXPECT_NE(message_of([&] { World({.solve = {.tolerance = wrong}}); }).find("tolerance"),
              std::string::npos);
    EXPECT_NE(message_of([&] { World({.solve = {.time_budget = wrong}}); }).find("time_budget"),
              std::string::npos);
  }
  EXPECT_NE(message_of([&] { World({.solve = {.max_iterations = -5}}); }).find("-5"), std::string::npos);
}

/// Each number is one, but not what comes of it.
TEST(Building, RefusesMassesAndImpulsesThatLeaveTheNumbers) {
  World world;
  EXPECT_NE(message_of([&] { world.create_body({.mass = 1e-320}); }).find("must have an inverse, got 1"),
            std::string::npos);
  EXPECT_NE(message_of([&] { world.create_body({.inertia = 1e-320}); }).find("inertia must have an inverse"),
            std::string::npos);
  const BodyId body = world.create_body({.position = {1, 2}, .velocity = {1, 0}, .omega = 1});
  const auto add = [&](double density, Vec2 centre) {
    ShapeDef def = smooth(make_disc(0.5, centre));
    def.density = density;
    return message_of([&] { world.add_shape(body, def); });
  };
  EXPECT_NE(add(1e-320, {}).find("mass of its body must have an inverse"), std::string::npos);
  EXPECT_NE(add(1e300, {1e10, 0}).find("moment of inertia of its body must be finite"), std::string::npos);
  EXPECT_EQ(add(1.5e308, {0.1, 0}), "no exception");
  const double mass = world.mass(body);
  const Vec2 at = world.position(body);
  // Two of them are too much.
  EXPECT_NE(add(1.5e308, {0.1, 0}).find("must have an inverse, got inf"), std::string::npos);
  EXPECT_NE(add(1.5e308, {1, 0}).find("must"), std::string::npos);
  EXPECT_EQ(world.mass(body), mass);
  EXPECT_EQ(world.position(body), at);

  const BodyId light = world.create_body({.mass = 1e-3, .inertia = 1e-3});
  EXPECT_EQ(message_of([&] {
              world.apply_impulse(light, {1e308, 0}, {});
            }),
            "velocity that the impulse gives must be finite, got (inf, 0)");
  EXPECT_EQ(message_of([&] {
              world.apply_impulse(light, {0, 1e300}, {1e300, 0});
            }),
            "omega that the impulse gives must be finite, got inf");
  EXPECT_EQ(world.velocity(light), Vec2{});
  const BodyId rock = world.create_body({.type = BodyType::Static});
  world.apply_impulse(rock, {0, 1e300}, {1e300, 0});
  EXPECT_EQ(world.omega(rock), 0);
}

TEST(Building, RefusalsNameTheBody) {
  World world;
  const auto rock = world.create_body({.type = BodyType::Static, .name = "rock"});
  world.add_shape(rock, smooth(make_half_plane({0, 0}, {0, 1})));
  EXPECT_EQ(message_of([&] {
              world.set_velocity(rock, {1, 0}, 0);
            }),
            "set_velocity: body 0 'rock' is static and cannot have a velocity");
  EXPECT_EQ(message_of([&] { world.set_drag(rock, {.linear = 1}); }),
            "set_drag: only dynamic bodies feel it, body 0 'rock' is not");
  EXPECT_EQ(message_of([&] { world.set_motion(rock, {}); }), "set_motion: body 0 'rock' must be kinematic");
  EXPECT_EQ(message_of([&] { world.set_type(rock, BodyType::Dynamic); }),
            "set_type: body 0 'rock' has a half-plane or chain, so no mass, and cannot be dynamic");
}

TEST(Building, CentreOfMassBecomesTheOriginOfTheBody) {
  World world(weightless());
  const auto body = world.create_body({.position = {10, 0}});
  ShapeDef disc = smooth(make_disc(0.5, {0, 0}));
  disc.density = 1;
  const auto first = world.add_shape(body, disc);
  EXPECT_EQ(world.position(body), (Vec2{10, 0}));
  disc.shape = make_disc(0.5, {2, 0});
  world.add_shape(body, disc);
  // The second shape was given in the frame of the definition, not in the moved one.
  EXPECT_NEAR(world.position(body).x, 11, 1e-15);
  const double area = kPi * 0.25;
  EXPECT_NEAR(world.mass(body), 2 * area, 1e-14);
  EXPECT_NEAR(world.inertia(body), 2 * area * (0.125 + 1), 1e-13);
  world.destroy(first);
  EXPECT_NEAR(world.position(body).x, 12, 1e-14);
  EXPECT_NEAR(world.mass(body), area, 1e-14);
}

TEST(Handles, OfRemovedThingsAreRefused) {
  World world;
  const auto body = add(world, {0, 0}, smooth(make_disc(1)));
  world.destroy(body);
  EXPECT_FALSE(world.alive(body));
  EXPECT_NE(message_of([&] { world.position(body); }).find("does not exist"), std::string::npos);
  const auto next = add(world, {0, 0}, smooth(make_disc(1)));
  EXPECT_EQ(next.index, body.index);
  EXPECT_FALSE(world.alive(body));
  EXPECT_TRUE(world.alive(next));
}

TEST(Handles, RemovingABodyInAStackLetsTheOthersFall) {
  World world;
  add_ground(world, smooth(make_disc(1)));
  const auto low = add(world, {0, 0.5}, smooth(make_box({1, 1})));
  const auto high = add(world, {0, 1.5}, smooth(make_box({1, 1})));
  for (int i = 0; i < 10; ++i) world.step(1.0 / 60);
  world.destroy(low);
  for (int i = 0; i < 120; ++i) world.step(1.0 / 60);
  EXPECT_NEAR(world.position(high).y, 0.5, 1e-9);
}

TEST(Terrain, BoxSlidesOverTheJointsOfAFlatChainAsOverAPlane) {
  World world;
  std::vector<Vec2> corners;
  for (int i = 0; i <= 200; ++i) corners.push_back({0.1 * i, 0});
  const auto ground = world.create_body({.type = BodyType::Static});
  world.add_shape(ground, smooth(make_chain(corners)));
  const auto box = add(world, {1, 0.25}, smooth(make_box({0.5, 0.5})), 1, {3, 0});
  for (int i = 0; i < 300; ++i) {
    const StepReport& report = world.step(1.0 / 60);
    ASSERT_EQ(report.impacts, 0) << "step " << i;
  }
  EXPECT_NEAR(world.velocity(box).x, 3, 1e-12);
  EXPECT_NEAR(world.position(box).y, 0.25, 1e-9);
  EXPECT_NEAR(world.angle(box), 0, 1e-9);
}

TEST(Terrain, BallStaysInAValleyAndNeverFallsThrough) {
  World world;
  const std::vector<Vec2> corners{{-3, 2}, {-1, 0}, {1, 0}, {3, 2}};
  const auto ground = world.create_body({.type = BodyType::Static});
  world.add_shape(ground, smooth(make_chain(corners), 0.2));
  const auto ball = add(world, {-1.5, 3}, smooth(make_disc(0.3), 0.2));
  for (int i = 0; i < 600; ++i) {
    world.step(1.0 / 60);
    const Vec2 p = world.position(ball);
    ASSERT_GT(p.y, std::max(0.0, std::abs(p.x) - 1) * 0.99) << "step " << i;
  }
}

TEST(Filters, DecideWhoMeets) {
  World world;
  ShapeDef ground = smooth(make_half_plane({0, 0}, {0, 1}));
  ground.filter.category = 2;
  world.add_shape(world.create_body({.type = BodyType::Static}), ground);
  ShapeDef ghost = smooth(make_disc(0.5));
  ghost.filter.mask = ~2u;
  const auto through = add(world, {0, 1}, ghost);
  const auto stopped = add(world, {5, 1}, smooth(make_disc(0.5)));
  for (int i = 0; i < 60; ++i) world.step(1.0 / 60);
  EXPECT_LT(world.position(through).y, -1);
  EXPECT_NEAR(world.position(stopped).y, 0.5, 1e-9);
}

TEST(Kinematic, PlatformCarriesAndLiftsWhatStandsOnIt) {
  World world;
  const auto platform =
      world.create_body({.type = BodyType::Kinematic, .position = {0, 0}, .velocity = {0, 0.5}});
  world.add_shape(platform, rough(make_box({4, 0.2}), 0.8));
  const auto box = add(world, {0, 0.6}, rough(make_box({1, 1}), 0.8), 1, {0, 0.5});
  for (int i = 0; i < 120; ++i) world.step(1.0 / 60);
  EXPECT_NEAR(world.position(platform).y, 1, 1e-12);
  EXPECT_NEAR(world.position(box).y, 1.6, 1e-9);
  EXPECT_NEAR(world.velocity(box).y, 0.5, 1e-10);
}

TEST(Robustness, ABodyThatWouldBecomeInfiniteIsContainedAndTheOthersGoOn) {
  World world;
  const auto wild = add(world, {0, 0}, smooth(make_disc(0.5)), 1, {1e308, 0});
  const auto tame = add(world, {100, 0}, smooth(make_disc(0.5)));
  world.apply_force(wild, {1e308, 0}, {0, 0});
  for (int i = 0; i < 5; ++i) world.step(10);
  EXPECT_TRUE(is_finite(world.position(wild)));
  EXPECT_TRUE(std::isfinite(world.velocity(wild).x));
  EXPECT_NEAR(world.position(tame).y, -0.5 * 9.81 * 2500, 1e-6);
}

TEST(Determinism, SameInputGivesTheSameBits) {
  const auto run = [] {
    World world;
    add_ground(world, rough(make_disc(1), 0.4, 0.3));
    for (int i = 0; i < 12; ++i) {
      add(world, {0.3 * (i % 4) - 0.4, 1 + 1.1 * i},
          rough(i % 2 ? make_disc(0.4) : make_box({0.8, 0.6}), 0.4, 0.3), 1, {0.1 * i, 0}, 0.5);
    }
    std::vector<std::uint64_t> hashes(60);
    for (std::uint64_t& hash : hashes) hash = world.step(1.0 / 60).state_hash;
    return hashes;
  };
  EXPECT_EQ(run(), run());
}

TEST(Determinism, AnyNumberOfThreadsGivesTheSameBits) {
  const auto run = [](int threads) {
    WorldConfig config;
    config.threads = threads;
    config.broad_phase = "uniform_grid";
    World world(config);
    add_ground(world, rough(make_disc(1), 0.4, 0.3));
    for (int i = 0; i < 60; ++i) {
      const int row = i / 12;
      add(world, {1.7 * (i % 12), 1 + 1.3 * row + 0.01 * i},
          rough(i % 2 ? make_disc(0.4) : make_box({0.8, 0.6}), 0.4, 0.3), 1, {0.1 * (i % 5), 0}, 0.5);
    }
    std::vector<std::uint64_t> hashes(60);
    for (std::uint64_t& hash : hashes) hash = world.step(1.0 / 60).state_hash;
    return hashes;
  };
  const auto expected = run(1);
  for (const int threads : {2, 4, 8}) EXPECT_EQ(run(threads), expected) << threads;
}

TEST(Determinism, ThreadsThatShareOneLargeIslandGiveTheSameBits) {
  struct Run {
    std::vector<std::uint64_t> hashes;
    std::vector<double> residuals;
    int flowing = 0, shared = 0;  // steps; those with an island that threads share
    bool operator==(const Run&) const = default;
  };
  // A block that falls apart, some of its bodies in pairs.
  const auto run = [](int threads, bool preview) {
    WorldConfig config;
    config.threads = threads;
    if (preview) config.solver = "pgs";
    World world(config);
    add_ground(world, rough(make_disc(1), 0.4));
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> speed(-1, 1);
    BodyId last;
    for (int x = 0; x < 50; ++x) {
      for (int y = 0; y < 36; ++y) {
        const Vec2 where{1.001 * x, 0.5 + 1.001 * y};
        const BodyId body = add(world, where, rough(y % 3 ? make_box({1, 1}) : make_disc(0.5), 0.4), 1,
                                {speed(random), speed(random)}, speed(random));
        if (y == 15 && x % 2 == 1) world.create_joint({.a = last, .b = body, .anchor_a = where});
        last = body;
      }
    }
    Run result;
    for (int i = 0; i < 8; ++i) {
      const StepReport& report = world.step(1.0 / 60);
      result.hashes.push_back(report.state_hash);
      result.residuals.push_back(report.worst_residual);
      result.flowing += report.islands_in_flow;
      // More than half of all contacts, and more than 1000, as each has two points at most.
      result.shared += std::any_of(
          report.islands_list.begin(), report.islands_list.end(), [&](const IslandReport& island) {
            return island.flowing && island.contacts > 2000 && island.contacts > 0.7 * report.contact_points;
          });
    }
    return result;
  };
  for (const bool preview : {false, true}) {
    const Run expected = run(1, preview);
    EXPECT_GT(expected.flowing, 5);
    EXPECT_GT(expected.shared, 3);
    for (const int threads : {2, preview ? 8 : 4}) EXPECT_EQ(run(threads, preview), expected) << threads;
  }
}

TEST(Determinism, ThreadsThatShareOneLargeExactIslandGiveTheSameBits) {
  struct Run {
    std::vector<std::uint64_t> hashes;
    std::vector<double> residuals;
    int inexact = 0;
    bool operator==(const Run&) const = default;
  };
  // A pyramid of which a brick is pushed, or a swinging net of hinged discs.
  const auto run = [](int threads, bool net) {
    WorldConfig config;
    config.threads = threads;
    World world(config);
    BodyId pushed;
    if (net) {
      const int side = 36;
      std::vector<BodyId> bodies;
      for (int k = 0; k < side * side; ++k) {
        const int row = k / side;
        const Vec2 where{1.0 * (k % side), -1.0 * row};
        bodies.push_back(add(world, where, rough(make_disc(0.3), 0.4)));
        const auto hinge = [&](int other, Vec2 at) {
          world.create_joint(
              {.a = bodies[static_cast<std::size_t>(other)], .b = bodies.back(), .anchor_a = at});
        };
        if (k % side > 0) hinge(k - 1, where - Vec2{0.5, 0});
        if (k >= side) hinge(k - side, where + Vec2{0, 0.5});
      }
      world.create_joint({.b = bodies.front(), .anchor_a = {0, 0}});
      world.create_joint({.b = bodies[side - 1], .anchor_a = {side - 1.0, 0}});
    } else {
      add_ground(world, rough(make_disc(1), 0.4));
      for (int row = 0; row < 34; ++row)
        for (int k = 0; k < 34 - row; ++k) {
          const BodyId body = add(world, {1.1 * k + 0.55 * row, 0.5 + row}, rough(make_box({1, 1}), 0.6));
          if (row == 16 && k == 8) pushed = body;
        }
    }
    Run result;
    for (int i = 0; i < 4; ++i) {
      if (i == 2 && !net) world.apply_impulse(pushed, {0.02, 0}, world.position(pushed));
      const StepReport& report = world.step(1.0 / 60);
      result.hashes.push_back(report.state_hash);
      result.residuals.push_back(report.worst_residual);
      result.inexact += report.inexact_islands + report.islands_in_flow;
    }
    return result;
  };
  for (const bool net : {false, true}) {
    const Run expected = run(1, net);
    EXPECT_EQ(expected.inexact, 0);
    for (const int threads : {2, 3, 8}) EXPECT_EQ(run(threads, net), expected) << threads;
  }
}

/// Joints of all kinds, with and without limits, motors and springs.
std::vector<JointDef> joints_of_all_kinds() {
  std::vector<JointDef> all;
  for (int k = 0; k <= static_cast<int>(JointKind::Spring); ++k) {
    const auto kind = static_cast<JointKind>(k);
    JointDef plain{.kind = kind, .pulley_a = {-5, 9}, .pulley_b = {5, 9}};
    if (kind == JointKind::Distance || kind == JointKind::Rope || kind == JointKind::Spring) plain.length = 1;
    if (kind == JointKind::Motor) plain.motor_speed = 1;
    if (kind == JointKind::Spring) plain.stiffness = 10;
    all.push_back(plain);
    const bool takes_all = kind == JointKind::Revolute || kind == JointKind::Distance ||
                           kind == JointKind::Prismatic || kind == JointKind::Wheel;
    if (!takes_all) continue;
    for (const bool both : {false, true}) {
      JointDef more = plain;
      more.lower = both ? 0.5 : -0.5;
      more.upper = 0.5;
      all.push_back(more);
    }
    JointDef driven = plain;
    driven.motor_speed = 0.5;
    driven.motor_limit = 2;
    all.push_back(driven);
    JointDef sprung = plain;
    sprung.stiffness = 5;
    sprung.damping = 0.1;
    all.push_back(sprung);
  }
  return all;
}

TEST(JointRows, CountOfJointsThatOnlyHoldIsThatOfTheirRows) {
  World world;
  const BodyId a = add(world, {-1, 0}, rough(make_disc(0.3), 0)),
               b = add(world, {1, 0.5}, rough(make_disc(0.3), 0));
  for (JointDef def : joints_of_all_kinds()) {
    def.a = a;
    def.b = b;
    def.anchor_b = {1, 0};
    const JointId id = world.create_joint(def);
    const JointRecord& joint = world.joints()[id.index];
    JointRows rows;
    JointEnd end_a, end_b;
    end_a.p = {-1, 0};
    end_b.p = {1, 0.5};
    const int count = joint_rows(joint, end_a, end_b, rows);
    bool holds = true;
    for (int k = 0; k < count; ++k) holds &= rows[static_cast<std::size_t>(k)].kind == JointRowKind::Hold;
    const int held = held_rows(joint.def);
    if (held >= 0) {
      EXPECT_EQ(held, count) << static_cast<int>(def.kind);
      EXPECT_TRUE(holds) << static_cast<int>(def.kind);
    } else {
      EXPECT_TRUE(!holds || (def.lower && def.lower == def.upper)) << static_cast<int>(def.kind);
    }
  }
}

TEST(Determinism, ThreadsThatShareJointsOfAllKindsGiveTheSameBits) {
  const std::vector<JointDef> kinds = joints_of_all_kinds();
  const auto run = [&kinds](int threads) {
    WorldConfig config;
    config.threads = threads;
    World world(config);
    add_ground(world, rough(make_disc(1), 0.4));
    std::vector<BodyId> bodies;
    for (int k = 0; k < 700; ++k) {
      const Vec2 where{0.9 * k, 0.3 + 0.3 * (k % 3)};
      bodies.push_back(add(world, where, rough(k % 2 ? make_disc(0.3) : make_box({0.6, 0.5}), 0.4), 1,
                           {0.01 * (k % 7), 0}));
      if (k == 0) continue;
      JointDef def = kinds[static_cast<std::size_t>(k) % kinds.size()];
      def.a = bodies[bodies.size() - 2];
      def.b = bodies.back();
      def.anchor_a = world.position(def.a);
      def.anchor_b = where;
      world.create_joint(def);
    }
    std::vector<std::uint64_t> hashes;
    std::size_t rows = 0;
    for (int i = 0; i < 4; ++i) {
      const StepReport& report = world.step(1.0 / 60);
      hashes.push_back(report.state_hash);
      for (const IslandReport& island : report.islands_list)
        rows = std::max(rows, static_cast<std::size_t>(island.rows));
    }
    EXPECT_GT(rows, 1000u);
    return hashes;
  };
  const auto expected = run(1);
  for (const int threads : {2, 3, 8}) EXPECT_EQ(run(threads), expected) << threads;
}

TEST(Resting, IslandsAreNotSteppedAgainAndStillReportTheirForces) {
  const auto run = [](bool reuse, int& reused) {
    WorldConfig config;
    config.reuse_resting = reuse;
    World world(config);
    add_ground(world, rough(make_disc(1), 0.5));
    for (int i = 0; i < 6; ++i) add(world, {0.1 * (i % 2), i + 0.5}, rough(make_box({1, 1}), 0.5));
    world.observe({.contacts = true});
    std::vector<double> trail;
    for (int i = 0; i < 120; ++i) {
      if (i == 60) world.apply_impulse(world.body_id(6), {0.5, 0}, world.position(world.body_id(6)));
      if (i == 90) world.set_gravity({0, -5});
      const StepReport& report = world.step(1.0 / 60);
      reused += report.islands_at_rest;
      trail.push_back(static_cast<double>(report.state_hash >> 12));
      for (const ContactReport& contact : report.contacts_list) {
        for (int k = 0; k < contact.count; ++k) trail.push_back(contact.points[k].normal_impulse);
      }
    }
    return trail;
  };
  int with = 0, without = 0;
  EXPECT_EQ(run(true, with), run(false, without));
  EXPECT_GT(with, 40);
  EXPECT_EQ(without, 0);
}

TEST(Resting, MovingTheGroundAwayEndsTheRest) {
  World world;
  const auto table = world.create_body({.type = BodyType::Static});
  world.add_shape(table, smooth(make_box({4, 1}, {0, -0.5})));
  const auto box = add(world, {0, 0.5}, smooth(make_box({1, 1})));
  for (int i = 0; i < 10; ++i) world.step(1.0 / 60);
  EXPECT_EQ(world.report().islands_at_rest, 1);
  world.set_pose(table, {0, -3}, 0);
  for (int i = 0; i < 10; ++i) world.step(1.0 / 60);
  EXPECT_LT(world.position(box).y, 0.4);
}

TEST(Determinism, EveryBroadPhaseGivesTheSameBits) {
  const auto run = [](std::string_view broad_phase) {
    WorldConfig config;
    config.broad_phase = broad_phase;
    World world(config);
    add_ground(world, smooth(make_disc(1), 0.3));
    for (int i = 0; i < 20; ++i) {
      add(world, {0.3 * (i % 4) - 0.4, 1 + 1.1 * i},
          smooth(i % 2 ? make_disc(0.4) : make_box({0.8, 0.6}), 0.3));
    }
    std::uint64_t all = 0;
    for (int i = 0; i < 60; ++i) all = all * 31 + world.step(1.0 / 60).state_hash;
    return all;
  };
  const std::uint64_t expected = run("brute_force");
  for (const BroadPhaseEntry& entry : broad_phases()) EXPECT_EQ(run(entry.name), expected) << entry.name;
}

TEST(World, ContainsABodyThatLeavesTheNumbersAndTellsWhenAndWhy) {
  World world(weightless()), alone(weightless());
  // A spin so fast that the angle overflows in the third step, of a body without a size, and a speed beyond
  // all lengths.
  const BodyId spinner =
      world.create_body({.position = {50, 0}, .omega = 0.8e308, .mass = 1.0, .inertia = 0.0});
  const BodyId racer = add(world, {0, 500}, smooth(make_disc(0.5)), 1, {1e200, 0});
  for (World* w : {&world, &alone}) test::add_row(*w, {1, 0, 0});
  std::vector<Containment> found;
  std::vector<std::uint64_t> steps;
  for (int i = 0; i < 90; ++i) {
    world.step(i < 3 ? 1.0 : 1.0 / 60);
    alone.step(i < 3 ? 1.0 : 1.0 / 60);
    for (const Containment& one : world.report().containments) {
      found.push_back(one);
      steps.push_back(world.report().step);
    }
    ASSERT_EQ(world.report().contained, static_cast<int>(world.report().containments.size()));
  }
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].body, racer);
  EXPECT_EQ(found[0].cause, ContainmentCause::TooFar);
  EXPECT_EQ(steps[0], 1u);
  EXPECT_EQ(found[1].body, spinner);
  EXPECT_EQ(found[1].cause, ContainmentCause::NotFinite);
  EXPECT_EQ(steps[1], 3u);
  EXPECT_EQ(world.omega(spinner), 0);
  EXPECT_EQ(world.velocity(racer), Vec2{});
  // The rest does not notice.
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(world.bodies().position[k + 2], alone.bodies().position[k]);
}

}  // namespace world_test
}  // namespace skerry
