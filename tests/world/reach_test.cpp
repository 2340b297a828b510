// SPDX-License-Identifier: MIT
//
// Which pairs a step looks at: those that fly side by side are none, and none that meet is missed.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "physics/narrowphase/collide.h"
#include "physics/snapshot.h"
#include "tests/support/draw.h"
#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace reach_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;

TEST(Reach, LeavesOutThePairsOfABlockThatFalls) {
  World world;
  for (int i = 0; i < 10; ++i) {
    for (int k = 0; k < 10; ++k)
      add(world, {0.21 * i, 100 + 0.21 * k}, rough(make_box({0.2, 0.2}), 0.5), 1, {3, -20});
  }
  for (int step = 0; step < 20; ++step) {
    const StepReport& report = world.step(1.0 / 60);
    EXPECT_GT(report.pairs, 100);
    EXPECT_EQ(report.pairs_out_of_reach, report.pairs) << step;
    EXPECT_EQ(report.islands, 100);
    EXPECT_EQ(report.islands_in_flight, 100);
    EXPECT_EQ(report.island_retries, 0);
  }
}

TEST(Reach, OfFastBodiesThatAreStruckGrows) {
  // Two rows fly side by side, a hair apart; a wall stops one of them in the middle of a step and a slope
  // throws it against the other.
  for (const double gap : {0.02, 0.05, 0.1}) {
    World world(test::weightless());
    const BodyId wall = world.create_body({.type = BodyType::Static});
    ShapeDef slope = smooth(make_polygon(std::vector<Vec2>{{0, 0}, {2, 0}, {2, 2}}), 1);
    world.add_shape(wall, slope);
    const double r = 0.25, reach = r * std::sqrt(2.0);
    const BodyId low = add(world, {-0.1 - 2 * r, 0.4}, smooth(make_disc(r), 1), 1, {30, 0});
    const BodyId high = add(world, {-0.1 - 2 * r, 0.4 + 2 * r + gap}, smooth(make_disc(r), 1), 1, {30, 0});
    const double energy = world.step(1e-9).kinetic_energy;
    for (int step = 0; step < 6; ++step) {
      const StepReport& report = world.step(1.0 / 60);
      EXPECT_NEAR(report.kinetic_energy, energy, 1e-9 * energy) << gap << " " << step;
      EXPECT_GE(length(world.position(low) - world.position(high)), 2 * r - 1e-9) << gap << " " << step;
      for (const BodyId body : {low, high}) {
        const Vec2 p = world.position(body);
        // Above the slope y = x, unless it went round its tip.
        if (p.x > 0 && p.x < 2 && p.y > 0) {
          EXPECT_GE(p.y - p.x, reach - 1e-9) << gap << " " << step;
        }
      }
    }
  }
}

/// Two worlds of the same bodies, of which one looks at all pairs. They make each step from the same states;
/// what overlaps in the end was missed.
class Twins {
 public:
  Twins(Vec2 gravity, double restitution) : restitution_(restitution) {
    WorldConfig config;
    config.gravity = gravity;
    config.flow_work = 0;
    world_.emplace(config);
    config.skips.alike = false;
    looks_at_all_.emplace(config);
  }

  /// Those that the steps move come last.
  void place(const BodyDef& def, const Shape& shape) {
    for (World* each : {&*world_, &*looks_at_all_}) {
      const BodyId body = each->create_body(def);
      each->add_shape(body, smooth(shape, restitution_));
      if (each == &*world_) bodies_.push_back(body);
    }
    shapes_.push_back(shape);
    if (def.type != BodyType::Dynamic) obstacles_ = bodies_.size();
  }
  bool strikes_an_obstacle(const Shape& shape, Vec2 at) const {
    for (std::size_t j = 0; j < obstacles_; ++j)
      if (collide(shapes_[j], pose(j), shape, {at, {}}, 0).count > 0) return true;
    return false;
  }

  void step() {
    for (std::size_t i = obstacles_; i < bodies_.size(); ++i) {
      const BodyId body = bodies_[i];
      looks_at_all_->set_pose(body, world_->position(body), world_->angle(body));
      looks_at_all_->set_velocity(body, world_->velocity(body), world_->omega(body));
    }
    const StepReport &report = world_->step(1.0 / 60), &full = looks_at_all_->step(1.0 / 60);
    hits += report.impacts;
    retries += report.island_retries;
    pairs += report.pairs - report.pairs_out_of_reach;
    all_pairs += full.pairs - full.pairs_out_of_reach;
    sharp += full.worst_penetration < 1e-9;
    // The end of a step that is cut too often is of first order, and what turns then may sink in,
    // whichever pairs are looked at.
    const double most = report.substeps > 4 ? 0.1 : 1e-6 + 1.01 * full.worst_penetration;
    for (std::size_t i = obstacles_; i < bodies_.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const Manifold m = collide(shapes_[i], pose(i), shapes_[j], pose(j), 0);
        for (int p = 0; p < m.count; ++p)
          ASSERT_GT(m.points[static_cast<std::size_t>(p)].separation, -most) << i << "-" << j;
      }
    }
  }

  int hits = 0, retries = 0, pairs = 0, all_pairs = 0;
  int sharp = 0;  ///< steps that left no overlap

 private:
  Transform pose(std::size_t i) const {
    return {world_->position(bodies_[i]), Rot::from_angle(world_->angle(bodies_[i]))};
  }

  double restitution_;
  std::optional<World> world_, looks_at_all_;
  std::vector<BodyId> bodies_;
  std::vector<Shape> shapes_;
  std::size_t obstacles_ = 0;
};

TEST(Reach, MissesNothingInSwarmsThatStrikeObstacles) {
  // Swarms of discs and boxes that fly alike, against a floor, posts and each other.
  const unsigned seed = 2718;
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int hits = 0, retries = 0, pairs = 0, all_pairs = 0, sharp = 0;
  for (int k = 0; k < test_scale(6); ++k) {
    Twins twins({0, -9.81}, k % 2 == 0 ? 0 : 0.6);
    twins.place({.type = BodyType::Static}, make_half_plane({0, 0}, {0, 1}));
    for (int post = 0; post < 3; ++post) {
      twins.place({.type = BodyType::Static, .position = {uniform(-3, 3), 0.5}, .angle = uniform(-1, 1)},
                  make_box({0.1, 1}));
    }
    for (int swarm = 0; swarm < 2; ++swarm) {
      const Vec2 v{uniform(-20, 20), uniform(-30, -5)};
      const Vec2 at{uniform(-2, 2) - 0.05 * v.x, 2.5 - 0.05 * v.y + 3 * swarm};
      const double pitch = 0.3 + uniform(0, 0.1);
      for (int i = 0; i < 9; ++i) {
        const int row = i / 3;
        twins.place({.position = at + Vec2{pitch * (i % 3), pitch * row},
                     .velocity = v + Vec2{uniform(-0.1, 0.1), 0},
                     .mass = 1.0},
                    i % 2 == 0 ? make_disc(0.14) : make_box({0.2, 0.2}));
      }
    }
    for (int step = 0; step < 40; ++step) {
      SCOPED_TRACE("step " + std::to_string(step) + " of " + std::to_string(k) + ", seed " +
                   std::to_string(seed));
      ASSERT_NO_FATAL_FAILURE(twins.step());
    }
    hits += twins.hits;
    retries += twins.retries;
    pairs += twins.pairs;
    all_pairs += twins.all_pairs;
    sharp += twins.sharp;
  }
  EXPECT_GT(hits, 30);
  EXPECT_GT(retries, 0);
  EXPECT_LT(pairs, all_pairs);
  EXPECT_GT(sharp, 30);
  std::printf("%d impacts, %d islands stepped again, %d pairs of %d\n", hits, retries, pairs, all_pairs);
}

TEST(Reach, MissesNothingBesideLongBodiesAtASlant) {
  // Small bodies about a bar that turns and planks at a slant, which are much larger: pairs are looked at in
  // the frame of those.
  const unsigned seed = 1618;
  std::mt19937 random(seed);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int hits = 0, pairs = 0, all_pairs = 0, sharp = 0;
  for (int k = 0; k < test_scale(8); ++k) {
    Twins twins(k % 2 == 0 ? Vec2{} : Vec2{0, -10}, k % 4 < 2 ? 0 : 0.6);
    twins.place({.type = BodyType::Kinematic, .angle = uniform(-3, 3), .omega = uniform(-4, 4)},
                make_box({8, 0.3}));
    for (const double side : {-1.0, 1.0}) {
      twins.place({.type = BodyType::Static, .position = {6 * side, uniform(-2, 2)}, .angle = uniform(-1, 1)},
                  make_box({0.2, 7}));
    }
    for (int i = 0; i < 40; ++i) {
      const int row = i / 8;
      const Vec2 at{(i % 8 - 3.5) * 1.3, (row - 2) * 1.3};
      const Shape shape = i % 2 == 0 ? make_disc(0.12) : make_box({0.2, 0.2});
      if (twins.strikes_an_obstacle(make_disc(0.3), at)) continue;
      twins.place({.position = at,
                   .velocity = {uniform(-12, 12), uniform(-12, 12)},
                   .omega = uniform(-5, 5),
                   .mass = 1.0},
                  shape);
    }
    for (int step = 0; step < 25; ++step) {
      SCOPED_TRACE("step " + std::to_string(step) + " of " + std::to_string(k) + ", seed " +
                   std::to_string(seed));
      ASSERT_NO_FATAL_FAILURE(twins.step());
    }
    hits += twins.hits;
    pairs += twins.pairs;
    all_pairs += twins.all_pairs;
    sharp += twins.sharp;
  }
  EXPECT_GT(hits, 30);
  EXPECT_LT(pairs, all_pairs);
  EXPECT_GT(sharp, 40);
  std::printf("%d impacts, %d pairs of %d, %d sharp steps\n", hits, pairs, all_pairs, sharp);
}

/// Boxes of 0.4 m in a block, loose and in disorder, without weight. They flow within a few steps.
std::vector<BodyId> add_block(World& world, int side, Vec2 at, Vec2 velocity) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> noise(-1, 1);
  std::vector<BodyId> bodies;
  for (int i = 0; i < side * side; ++i) {
    const int row = i / side, column = i % side;
    const Vec2 place = at + 0.43 * Vec2{static_cast<double>(column), static_cast<double>(row)};
    const Vec2 v = velocity + 3.0 * Vec2{noise(random), noise(random)};
    bodies.push_back(add(world, place, rough(make_box({0.4, 0.4}), 0.5), 1, v, noise(random)));
  }
  return bodies;
}

TEST(Reach, FindsNoMorePairsInAPileThatFliesFast) {
  // At 40 m/s everything can go 0.67 m in a step; against its neighbours it strays by millimetres.
  int pairs[2] = {}, linked[2] = {}, contacts = 0, flowing = 0;
  for (const int fast : {0, 1}) {
    World world(test::weightless());
    add_block(world, 15, {}, fast * Vec2{40, 20});
    for (int step = 0; step < 60; ++step) {
      const StepReport& report = world.step(1.0 / 60);
      pairs[fast] += report.pairs;
      linked[fast] += report.pairs - report.pairs_out_of_reach;
      contacts += fast * report.contacts;
      flowing += fast * (report.islands_in_flow > 0);
    }
  }
  std::printf("pairs %d and %d, in reach %d and %d, %d touch\n", pairs[0], pairs[1], linked[0], linked[1],
              contacts);
  EXPECT_GT(flowing, 20);
  EXPECT_LT(linked[1], 1.2 * linked[0]);
  EXPECT_LT(pairs[1], 4 * pairs[0]);
}

TEST(Reach, AWallStopsAPileThatABarThrowsAtIt) {
  // What the bar strikes goes much farther in this step than the last one let anybody guess. The wall is 2 cm
  // thick, the boxes 40 cm.
  for (const double speed : {20.0, 40.0}) {
    World world(test::weightless());
    const BodyId bar =
        world.create_body({.type = BodyType::Kinematic, .position = {-3, 2}, .velocity = {speed, 0}});
    world.add_shape(bar, rough(make_box({0.2, 8}), 0.5));
    const BodyId wall = world.create_body({.type = BodyType::Static, .position = {7, 2}});
    world.add_shape(wall, rough(make_box({0.02, 400}), 0.5));
    const std::vector<BodyId> bodies = add_block(world, 10, {}, {});
    int flowing = 0;
    for (int step = 0; step < 40; ++step) {
      if (step * speed / 60 > 5) world.set_velocity(bar, {}, 0);
      flowing += world.step(1.0 / 60).islands_in_flow > 0;
      for (const BodyId body : bodies) {
        ASSERT_LT(world.position(body).x, 7.01) << speed << " m/s, step " << step;
        ASSERT_GT(world.position(body).x, world.position(bar).x - 0.1) << speed << " m/s, step " << step;
      }
    }
    EXPECT_GT(flowing, 20);
  }
}

TEST(Reach, AWrongGuessInFlowIsMended) {
  // A body in the midst of a calm flow is suddenly made a bullet. A world that lets everything go anywhere
  // within its reach makes the same step of it, but for what flow may leave to the next one.
  World world(test::weightless());
  const std::vector<BodyId> bodies = add_block(world, 12, {}, {});
  const BodyId wall = world.create_body({.type = BodyType::Static, .position = {9, 2}});
  world.add_shape(wall, rough(make_box({0.02, 40}), 0.5));
  for (int step = 0; step < 40; ++step) world.step(1.0 / 60);
  ASSERT_GT(world.report().islands_in_flow, 0);
  for (const std::size_t bullet : {0, 18, 65, 78, 90}) {
    World guessed = load_snapshot(save_snapshot(world)), all = load_snapshot(save_snapshot(world));
    WorldConfig config = all.config();
    config.skips.alike = false;
    all.reconfigure(config);
    for (World* each : {&guessed, &all}) {
      each->set_velocity(bodies[bullet], {90, 10}, 0);
      each->step(1.0 / 60);
    }
    double worst = 0;
    for (const BodyId body : bodies)
      worst = std::max(worst, length(guessed.position(body) - all.position(body)));
    std::printf("bullet %zu: %d and %d islands again, %.3f m apart, kinetic energy %.4g and %.4g J\n", bullet,
                guessed.report().island_retries, all.report().island_retries, worst, guessed.kinetic_energy(),
                all.kinetic_energy());
    EXPECT_LT(worst, 0.2);
    EXPECT_NEAR(guessed.kinetic_energy(), all.kinetic_energy(), 0.2 * all.kinetic_energy());
  }
}

TEST(Reach, ACrushThatGoesElsewhereInEachRoundComesToAnEnd) {
  // 300 capsules come down between two slopes at 150 m/s: what each of them strikes is another one in each
  // round. Bodies that had a new way each time took 40 to 77 rounds of the slowest step.
  int rounds = 0;
  for (const unsigned seed : {1u, 2u, 7u, 8u}) {
    test::Draw draw(seed);
    World world({.gravity = {0, -1000}, .stepper = "time_stepping"});
    const Material material{.friction = 0.5, .restitution = 0.6};
    const BodyId valley = world.create_body({.type = BodyType::Static});
    for (const double side : {-1.0, 1.0}) {
      const Shape slope = make_half_plane({0, 0}, {side * std::sin(0.8), std::cos(0.8)});
      world.add_shape(valley, {.shape = slope, .material = material});
    }
    for (int k = 0; k < 300; ++k) {
      const Vec2 place{(k % 18 - 9) * 0.6, std::floor(k / 18.0) * 0.6 + 16};
      const BodyId body = world.create_body({.position = place, .angle = draw.uniform(0, 6)});
      const double density = 1000 * std::pow(50, draw.uniform(0, 1));
      world.add_shape(
          body,
          {.shape = make_capsule({-0.35, 0}, {0.35, 0}, 0.15), .density = density, .material = material});
    }
    int most = 0;
    for (int i = 0; i < 25; ++i) most = std::max(most, world.step(1.0 / 60).island_retries);
    std::printf("seed %u: %d rounds\n", seed, most);
    rounds += most;
  }
  EXPECT_LE(rounds, 90);
}

TEST(ContactTable, ThatGrowsAtItsFrontIsTheSameForAnyThreads) {
  // Pairs of discs that collide, enough for all threads; then the first of all discs come between the pairs
  // and each contact moves back in the table.
  std::vector<std::uint64_t> hashes[3];
  for (const int threads : {1, 2, 3}) {
    WorldConfig config = test::weightless();
    config.threads = threads;
    World world(config);
    std::vector<BodyId> first;
    first.reserve(8);
    for (int k = 0; k < 8; ++k) first.push_back(add(world, {3.0 * k, -50}, smooth(make_disc(0.5), 1)));
    for (int k = 0; k < 2100; ++k) {
      for (const double side : {-1.0, 1.0})
        add(world, {3.0 * k + 0.502 * side, 0}, smooth(make_disc(0.5), 1), 1, {-0.05 * side, 0.0});
    }
    for (int i = 0; i < 6; ++i) {
      if (i == 2) {
        for (std::size_t k = 0; k < first.size(); ++k)
          world.set_pose(first[k], {3.0 * static_cast<double>(k), -0.95}, 0);
      }
      if (i == 4) {
        for (std::size_t k = 0; k < first.size(); k += 2)
          world.set_pose(first[k], {3.0 * static_cast<double>(k), -50}, 0);
        for (std::uint32_t k = 20; k < 80; k += 4) world.set_pose(world.body_id(k), {3.0 * k, 50}, 0);
      }
      world.step(1.0 / 60);
      hashes[threads - 1].push_back(world.state_hash());
    }
    ASSERT_GT(world.report().pairs, 2050);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(hashes[0], hashes[2]);
}

TEST(Reach, ChainsThatComeFastCarryWhatIsInTheirWay) {
  // In one step the chain goes several times as far as the bodies are high.
  for (const bool turns : {false, true}) {
    World world(test::weightless());
    const BodyId lift = world.create_body({.type = BodyType::Kinematic, .position = {0, 0}});
    world.add_shape(lift, smooth(make_chain(std::vector<Vec2>{{-5, 0}, {1, 0}, {3, 0}, {5, 0}})));
    std::vector<BodyId> bodies;
    for (const double x : {-3.0, 0.0, 2.5})
      bodies.push_back(add(world, {x, 0.35}, smooth(x == 0 ? make_box({0.1, 0.1}) : make_disc(0.05))));
    if (turns)
      world.set_velocity(lift, {0, 12}, 3);
    else
      world.set_velocity(lift, {0, 30}, 0);
    for (int step = 0; step < 4; ++step) {
      world.step(1.0 / 60);
      const Transform at = world.pose(lift);
      for (const BodyId body : bodies)
        EXPECT_GT(dot(rotate(at.q, {0, 1}), world.position(body) - at.p), 0.05 - 1e-3)
            << turns << " " << step;
    }
  }
}

TEST(Reach, WhatTurnsBackWithinTheStepMeetsWhatIsAtTheTopOfItsWay) {
  // Up and down again in one step; a ceiling stops it before its top, and it falls from there.
  const double h = 1.0 / 60, g = 4000, v = g * h / 2, gap = 0.1;
  World world({.gravity = {0, -g}});
  const BodyId ceiling = world.create_body({.type = BodyType::Static});
  world.add_shape(ceiling, smooth(make_half_plane({0, 0.1 + gap}, {0, -1})));
  const BodyId disc = add(world, {0, 0}, smooth(make_disc(0.1)), 1, {0, v});
  world.step(h);
  const double met = (v - std::sqrt(v * v - 2 * g * gap)) / g;
  EXPECT_NEAR(world.position(disc).y, gap - g * (h - met) * (h - met) / 2, 1e-6);
}

TEST(Reach, WhatIsSetTurningMeetsWhatIsBesideIt) {
  // The torque turns the bar by more than a radian, against a disc far from where it was.
  World world(test::weightless());
  const BodyId bar = add(world, {0, 0}, smooth(make_box({2, 0.1})), 1, {}, 2);
  const BodyId disc = add(world, 0.8 * Vec2{std::cos(0.7), std::sin(0.7)}, smooth(make_disc(0.05)));
  world.apply_torque(bar, 1e4 / world.bodies().inverse_inertia[bar.index]);
  world.step(1.0 / 60);
  EXPECT_GT(length(world.velocity(disc)), 1);
  EXPECT_LT(world.angle(bar), 1);
}

TEST(Reach, ABarThatTurnsAsToldMeetsWhatIsBesideIt) {
  for (const double way : {1.0, -1.0}) {
    World world(test::weightless());
    const BodyId bar = world.create_body({.type = BodyType::Kinematic});
    world.add_shape(bar, smooth(make_box({2, 0.1})));
    world.set_motion(bar, [way](double t) { return Placement{{0, 0}, 60 * way * t}; });
    const BodyId disc = add(world, 0.8 * Vec2{std::cos(0.7), way * std::sin(0.7)}, smooth(make_disc(0.05)));
    world.step(1.0 / 60);
    EXPECT_GT(length(world.velocity(disc)), 30);
  }
}

TEST(Reach, ImpulsesOfIslandsThatAreSteppedAgainAreThoseOfTheirMotion) {
  int retries = 0;
  double worst = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    test::Draw draw(seed);
    WorldConfig config = test::weightless();
    config.flow_work = 0;
    World world(config);
    world.observe({.contacts = true});
    const BodyId floor = world.create_body({.type = BodyType::Static});
    world.add_shape(floor, smooth(make_half_plane({0, 0}, {0.1, 1}), 0.5));
    std::vector<BodyId> bodies;
    bodies.reserve(12);
    for (int i = 0; i < 12; ++i)
      bodies.push_back(add(world, {0.33 * (i % 3), 1 + 0.33 * std::floor(i / 3)},
                           smooth(i % 2 == 0 ? make_disc(0.14) : make_box({0.2, 0.2}), 0.5),
                           draw.uniform(1, 2), {12 + draw.uniform(-0.1, 0.1), -20}));
    for (int step = 0; step < 12; ++step) {
      std::vector<Vec2> change(world.bodies().size());
      for (const BodyId body : bodies) change[body.index] = -world.mass(body) * world.velocity(body);
      const StepReport& report = world.step(1.0 / 60);
      for (const BodyId body : bodies) change[body.index] += world.mass(body) * world.velocity(body);
      for (const ContactReport& contact : report.contacts_list) {
        change[contact.body_a.index] += contact.impulse;
        change[contact.body_b.index] -= contact.impulse;
      }
      for (const BodyId body : bodies) worst = std::max(worst, length(change[body.index]));
      retries += report.island_retries;
    }
  }
  EXPECT_LT(worst, 1e-3);
  EXPECT_GT(retries, 5);
}

TEST(Reach, SmallBodiesOlderThanThePlanksMeetThemAsWell) {
  // One fast body against one long, rounded plank at a slant that stands, turns, or goes as told; the
  // same where all pairs are looked at.
  int struck = 0;
  for (unsigned seed = 1; seed <= 400; ++seed) {
    Vec2 places[2], velocities[2];
    for (const bool alike : {false, true}) {
      test::Draw draw(seed);
      WorldConfig config = test::weightless();
      config.skips.alike = alike;
      World world(config);
      const Vec2 at{draw.uniform(-2, 2), draw.uniform(-2, 2)};
      const Vec2 v{draw.uniform(-40, 40), draw.uniform(-40, 40)};
      const BodyId small = add(world, at, smooth(seed % 2 == 0 ? make_disc(0.1) : make_box({0.15, 0.1}), 0.5),
                               1, v, draw.uniform(-5, 5), draw.uniform(-3, 3));
      const bool turns = draw.one_in(2), told = draw.one_in(3);
      const BodyId plank = world.create_body({.type = BodyType::Kinematic,
                                              .position = at + Vec2{draw.uniform(-2, 2), draw.uniform(-2, 2)},
                                              .angle = draw.uniform(-3, 3),
                                              .omega = turns ? draw.uniform(-12, 12) : 0.0});
      world.add_shape(
          plank,
          smooth(draw.one_in(2) ? make_capsule({-4, 0}, {4, 0}, 0.3) : make_box({8, 0.4}, {}, 0, 0.15), 0.5));
      if (told) {
        const Vec2 pull{draw.uniform(-2000, 2000), draw.uniform(-2000, 2000)};
        world.set_motion(plank, [pull, from = world.position(plank), angle = world.angle(plank)](double t) {
          return Placement{from + t * t * pull, angle + 200 * t * t};
        });
      }
      const auto shapes = world.shapes();
      if (collide(shapes[0].shape, world.pose(small), shapes[1].shape, world.pose(plank), 0).count > 0) break;
      for (int i = 0; i < 2; ++i) {
        world.step(1.0 / 60);
        struck += alike && world.report().impacts > 0;
      }
      places[alike] = world.position(small);
      velocities[alike] = world.velocity(small);
    }
    ASSERT_LT(length(places[1] - places[0]), 1e-6) << "seed " << seed;
    ASSERT_LT(length(velocities[1] - velocities[0]), 1e-4) << "seed " << seed;
  }
  EXPECT_GT(struck, 40);
}

TEST(Reach, PairsAreThoseOfBoxesThatOverlap) {
  // Whatever is left out, found again, or found in a later round.
  int retries = 0, all = 0;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    test::Draw draw(seed);
    World world({.threads = seed % 3 == 0 ? 2 : 1});
    add_ground(world, rough(make_disc(1), 0.5, seed % 2 == 0 ? 0.6 : 0));
    const BodyId post = world.create_body({.type = BodyType::Static, .position = {0, 1}, .angle = 0.3});
    world.add_shape(post, smooth(make_box({0.1, 1.5})));
    const BodyId paddle =
        world.create_body({.type = BodyType::Kinematic, .position = {2, 1}, .omega = draw.uniform(-5, 5)});
    world.add_shape(paddle, smooth(make_box({2, 0.1})));
    for (int swarm = 0; swarm < 2; ++swarm) {
      const Vec2 v{draw.uniform(-20, 20), draw.uniform(-30, -5)};
      const Vec2 at{draw.uniform(-2, 2) - 0.05 * v.x, 2.5 - 0.05 * v.y + 3 * swarm};
      for (int i = 0; i < 12; ++i)
        add(world, at + Vec2{0.33 * (i % 3), 0.33 * std::floor(i / 3)},
            smooth(i % 2 == 0 ? make_disc(0.14) : make_box({0.2, 0.2}), 0.3), 1,
            v + Vec2{draw.uniform(-0.1, 0.1), 0});
    }
    for (int step = 0; step < 40; ++step) {
      const StepReport& report = world.step(1.0 / 60);
      int overlapping = 0;
      const auto shapes = world.shapes();
      for (std::size_t i = 0; i < shapes.size(); ++i) {
        for (std::size_t j = 0; j < i; ++j) overlapping += i > 2 && overlap(shapes[i].box, shapes[j].box);
      }
      ASSERT_EQ(report.pairs, overlapping) << "seed " << seed << ", step " << step;
      retries += report.island_retries;
      all += overlapping;
    }
  }
  EXPECT_GT(std::min(retries, all), 20);
}

TEST(Reach, SensorsAreNoPairsOutOfReachWhicheverOfTheTwoTheyAre) {
  // A block that falls: the sensor in its corner was made first, or last, or is not there.
  const auto fall = [](int sensor) {
    World world;
    for (int i = 0; i < 100; ++i) {
      const int column = i / 10, row = i % 10;
      ShapeDef def = rough(make_box({0.2, 0.2}), 0.5);
      if (i == 0 || i == 99) def.sensor = i == sensor;
      if (sensor < 0 && i == -sensor - 1) continue;
      add(world, {0.21 * column, 100 + 0.21 * row}, def, 1, {3, -20});
    }
    world.step(1.0 / 60);
    return std::pair(world.report().pairs, world.report().pairs_out_of_reach);
  };
  for (const int corner : {0, 99}) {
    const auto [pairs, out_of_reach] = fall(corner);
    const auto [solid, solid_out] = fall(-corner - 1);
    EXPECT_GT(pairs, solid);
    EXPECT_EQ(solid_out, solid);
    EXPECT_EQ(out_of_reach, solid) << corner;
  }
}

}  // namespace reach_test
}  // namespace skerry
