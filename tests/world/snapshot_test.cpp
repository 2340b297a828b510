// SPDX-License-Identifier: MIT
//
// A world that was saved and loaded goes on as the one that was not, bit by bit.
#include "physics/snapshot.h"

#include <cmath>
#include <cstring>
#include <functional>
#include <gtest/gtest.h>
#include <random>
#include <stdexcept>
#include <tuple>

#include "physics/solver/impact_law.h"
#include "physics/stepping/stepper.h"
#include "tests/support/draw.h"
#include "tests/support/scale.h"
#include "tests/support/worlds.h"

namespace skerry {
namespace snapshot_test {

using test::add;
using test::add_ground;
using test::rough;
using test::smooth;

constexpr double kStep = 1.0 / 60;

void build_stack(World& world) {
  add_ground(world, rough(make_disc(1), 0.5));
  for (int i = 0; i < 8; ++i) add(world, {0.02 * (i % 3), 0.5 + i}, rough(make_box({1, 1}), 0.5), 1 + i);
}

void build_heap(World& world) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> jitter(-0.3, 0.3);
  add_ground(world, rough(make_disc(1), 0.6));
  for (int i = 0; i < 20; ++i) {
    const int column = i % 5, row = i / 5;
    const Vec2 at{jitter(random) + column, 1 + 1.1 * row};
    const Shape shape = i % 3 == 0   ? make_disc(0.4)
                        : i % 3 == 1 ? make_box({0.7, 0.5})
                                     : make_capsule({-0.3, 0}, {0.3, 0}, 0.2);
    ShapeDef def = rough(shape, 0.4, i % 4 == 0 ? 0.3 : 0);
    if (i % 6 == 0) def.material.rolling_resistance = 0.01;
    add(world, at, def, 1, {jitter(random), 0}, jitter(random), jitter(random));
  }
}

void build_cradle(World& world) {
  for (int i = 0; i < 5; ++i) {
    const double lift = i == 0 ? 0.7 : 0;
    const BodyId ball = add(world, {i - 2 * std::sin(lift), -2 * std::cos(lift)}, smooth(make_disc(0.5), 1));
    world.create_joint({.kind = JointKind::Distance,
                        .b = ball,
                        .anchor_a = {static_cast<double>(i), 0},
                        .anchor_b = world.position(ball)});
  }
}

void build_joints(World& world) {
  add_ground(world, rough(make_disc(1), 0.5));
  BodyId last{};
  for (int i = 0; i < 6; ++i) {
    const BodyId link = add(world, {0.5 + i, 4}, rough(make_box({0.9, 0.2}), 0.3));
    world.create_joint({.a = last, .b = link, .anchor_a = {static_cast<double>(i), 4}});
    last = link;
  }
  // One of each of the other kinds, with limits, a motor and a spring.
  const BodyId cart = add(world, {9, 1}, rough(make_box({0.8, 0.4}), 0.3), 2);
  world.create_joint({.kind = JointKind::Prismatic,
                      .b = cart,
                      .anchor_a = {9, 1},
                      .lower = -1.0,
                      .upper = 1.0,
                      .motor_speed = 2.0,
                      .motor_limit = 30});
  const BodyId wheel = add(world, {9, 2}, rough(make_disc(0.3), 0.3), 1);
  world.create_joint({.a = cart, .b = wheel, .anchor_a = {9, 2}, .motor_speed = 3.0, .motor_limit = 5});
  const BodyId gear = add(world, {12, 2}, rough(make_disc(0.3), 0.3), 1);
  world.create_joint({.b = gear, .anchor_a = {12, 2}});
  world.create_joint({.kind = JointKind::Gear, .a = wheel, .b = gear, .ratio = 2});
  const BodyId bob = add(world, {12, 1}, rough(make_disc(0.2), 0.3), 1);
  world.create_joint({.kind = JointKind::Spring,
                      .a = gear,
                      .b = bob,
                      .anchor_a = {12, 2},
                      .anchor_b = {12, 1},
                      .stiffness = 50,
                      .damping = 1,
                      .break_force = 40});
  const BodyId weight = add(world, {0, 1.5}, rough(make_disc(0.3), 0.2, 0.5), 3, {2, 0});
  world.create_joint(
      {.kind = JointKind::Rope, .b = weight, .anchor_a = {0, 5}, .anchor_b = {0, 1.5}, .length = 4.0});
}

/// A slope of terrain, a conveyor and a sensor.
void build_terrain(World& world) {
  const BodyId ground = world.create_body({.type = BodyType::Static});
  const Vec2 corners[] = {{-4, 3}, {0, 1}, {2, 0.5}, {6, 0.5}, {9, 2}};
  ShapeDef chain = rough(make_chain(corners), 0.4);
  chain.material.surface_velocity = 0.3;
  world.add_shape(ground, chain);
  ShapeDef sensor = rough(make_box({2, 2}), 0);
  sensor.sensor = true;
  const BodyId gate = world.create_body({.type = BodyType::Static, .position = {3, 1}, .name = "gate"});
  world.add_shape(gate, sensor);
  const BodyId lift =
      world.create_body({.type = BodyType::Kinematic, .position = {5, 0}, .velocity = {0, 0.2}});
  world.add_shape(lift, rough(make_box({1, 0.5}), 0.5));
  for (int i = 0; i < 6; ++i) add(world, {-3 + 0.9 * i, 4.0 + 0.2 * i}, rough(make_disc(0.3), 0.5, 0.2));
}

struct Scene {
  const char* name;
  void (*build)(World&);
};
constexpr Scene kScenes[] = {{"stack", build_stack},
                             {"heap", build_heap},
                             {"cradle", build_cradle},
                             {"joints", build_joints},
                             {"terrain", build_terrain}};

/// Everything in a report but measured times.
void expect_same(const StepReport& x, const StepReport& y, const std::string& where) {
  ASSERT_EQ(x.state_hash, y.state_hash) << where;
  const auto counts = [](const StepReport& r) {
    const NarrowPhaseStats& n = r.narrow;
    const SolveWork& w = r.work;
    return std::vector<std::uint64_t>{r.step,
                                      static_cast<std::uint64_t>(r.bodies),
                                      static_cast<std::uint64_t>(r.dynamic_bodies),
                                      static_cast<std::uint64_t>(r.shapes),
                                      static_cast<std::uint64_t>(r.joints),
                                      static_cast<std::uint64_t>(r.pairs),
                                      static_cast<std::uint64_t>(r.contacts),
                                      static_cast<std::uint64_t>(r.contact_points),
                                      static_cast<std::uint64_t>(r.islands),
                                      static_cast<std::uint64_t>(r.rows),
                                      static_cast<std::uint64_t>(r.substeps),
                                      static_cast<std::uint64_t>(r.impacts),
                                      static_cast<std::uint64_t>(r.reflections),
                                      static_cast<std::uint64_t>(r.friction_rows),
                                      n.pairs,
                                      n.axes_tested,
                                      n.axes_skipped,
                                      n.manifolds,
                                      static_cast<std::uint64_t>(w.factorisations),
                                      static_cast<std::uint64_t>(w.partial_factorisations),
                                      static_cast<std::uint64_t>(w.resolves),
                                      static_cast<std::uint64_t>(w.pivots),
                                      static_cast<std::uint64_t>(w.symbolic_analyses),
                                      static_cast<std::uint64_t>(w.symbolic_skipped),
                                      static_cast<std::uint64_t>(r.force_solves),
                                      static_cast<std::uint64_t>(r.events_found),
                                      static_cast<std::uint64_t>(r.rejected_steps),
                                      static_cast<std::uint64_t>(r.fallbacks),
                                      static_cast<std::uint64_t>(r.island_retries),
                                      static_cast<std::uint64_t>(r.islands_in_flight),
                                      static_cast<std::uint64_t>(r.islands_at_rest),
                                      static_cast<std::uint64_t>(r.manifolds_reused),
                                      static_cast<std::uint64_t>(r.pairs_out_of_reach),
                                      static_cast<std::uint64_t>(r.inexact_islands),
                                      static_cast<std::uint64_t>(r.contained),
                                      r.events.size(),
                                      r.motion_events.size()};
  };
  ASSERT_EQ(counts(x), counts(y)) << where;
  const auto numbers = [](const StepReport& r) {
    std::vector<double> all{r.time,
                            r.h,
                            r.worst_residual,
                            r.worst_penetration,
                            r.kinetic_energy,
                            r.potential_energy,
                            r.momentum.x,
                            r.momentum.y,
                            r.angular_momentum,
                            r.total_normal_impulse,
                            r.total_friction_impulse};
    for (const ContactReport& c : r.contacts_list) {
      for (const ContactPointReport& p : c.points) {
        all.insert(all.end(), {p.position.x, p.position.y, p.separation, p.normal_impulse, p.friction_impulse,
                               p.impact_impulse});
      }
    }
    for (const ContactEvent& e : r.events) all.insert(all.end(), {e.point.x, e.point.y, e.impulse});
    for (const IslandReport& i : r.islands_list) {
      all.insert(all.end(), {i.residual, static_cast<double>(i.iterations), static_cast<double>(i.rows)});
    }
    return all;
  };
  ASSERT_EQ(numbers(x), numbers(y)) << where;
}

World make_world(const Scene& scene, WorldConfig config) {
  World world(std::move(config));
  scene.build(world);
  world.observe({.contacts = true});
  return world;
}

/// Runs straight, and again through a snapshot after every `every` steps; all reports must be equal.
void check_scene(const Scene& scene, const WorldConfig& config, int steps, int every) {
  World straight = make_world(scene, config), saved = make_world(scene, config);
  const std::string name = std::string(scene.name) + ' ' + config.stepper + ' ' + config.solver + ' ' +
                           config.broad_phase + ' ' + config.impact_law;
  for (int i = 0; i < steps; ++i) {
    if (i % every == 0) {
      const std::vector<std::byte> bytes = save_snapshot(saved);
      saved = load_snapshot(bytes);
      ASSERT_TRUE(save_snapshot(saved) == bytes) << name << ": saved again, step " << i;
    }
    const StepReport& x = straight.step(kStep);
    const StepReport& y = saved.step(kStep);
    expect_same(x, y, name + ", step " + std::to_string(i));
    if (testing::Test::HasFatalFailure()) return;
  }
}

TEST(Snapshot, ContinuesBitByBitInEverySceneWithBothSteppers) {
  for (const Scene& scene : kScenes) {
    for (const StepperEntry& stepper : steppers()) {
      WorldConfig config;
      config.stepper = stepper.name;
      // A heap has so many events that each step takes long.
      const bool busy = stepper.name != "time_stepping" && scene.build == build_heap;
      check_scene(scene, config, test_scale(busy ? 10 : 45), 4);
      if (HasFatalFailure()) return;
    }
  }
}

TEST(Snapshot, ContinuesBitByBitWithEveryBroadPhase) {
  for (const BroadPhaseEntry& broad_phase : broad_phases()) {
    WorldConfig config;
    config.broad_phase = broad_phase.name;
    check_scene(kScenes[1], config, test_scale(24), 5);
    if (HasFatalFailure()) return;
  }
}

TEST(Snapshot, ContinuesBitByBitWithEverySolverAndImpactLaw) {
  for (const SolverEntry& solver : solvers()) {
    for (const Scene& scene : {kScenes[0], kScenes[3]}) {
      WorldConfig config;
      config.solver = solver.name;
      check_scene(scene, config, test_scale(20), 3);
      if (HasFatalFailure()) return;
    }
  }
  for (const ImpactLawEntry& law : impact_laws()) {
    WorldConfig config;
    config.impact_law = law.name;
    check_scene(kScenes[2], config, test_scale(40), 6);
    if (HasFatalFailure()) return;
  }
}

TEST(Snapshot, KeepsWhatWasDoneBetweenSteps) {
  World world = make_world(kScenes[0], {});
  for (int i = 0; i < 30; ++i) world.step(kStep);
  world.destroy(world.body_id(4));
  world.apply_force(world.body_id(3), {3, 50}, {0, 2});
  world.set_pose(world.body_id(8), {0.2, 9}, 0.3);
  const BodyId late = add(world, {2, 3}, rough(make_disc(0.4), 0.5));
  ASSERT_EQ(late.index, 4u) << "the free slot";
  World loaded = load_snapshot(save_snapshot(world));
  EXPECT_EQ(loaded.shapes_at({2, 3}), world.shapes_at({2, 3}));
  EXPECT_EQ(loaded.state_hash(), world.state_hash());
  expect_same(loaded.report(), world.report(), "the last report");
  EXPECT_EQ(loaded.time(), world.time());
  EXPECT_TRUE(loaded.alive(late));
  for (int i = 0; i < 30; ++i) {
    expect_same(world.step(kStep), loaded.step(kStep), "step " + std::to_string(i));
    ASSERT_FALSE(HasFatalFailure());
  }
}

/// What falls fast onto a body that stands looks at how that one flies.
TEST(Snapshot, BodiesThatStandAreWhatTheyWere) {
  for (unsigned seed = 0; seed < 60; ++seed) {
    std::mt19937 random(seed);
    const auto uniform = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    World world;
    const BodyId plate = world.create_body({.type = BodyType::Kinematic, .angle = 0.2});
    world.add_shape(plate, rough(make_box({4, 0.2}), 0.5));
    for (unsigned k = 0; k <= seed % 3; ++k) {
      const Shape shape = k % 2 ? make_box({0.8, 0.3}) : make_capsule({-0.4, 0}, {0.4, 0}, 0.1);
      add(world, {uniform(-1, 1), 1.0 + k}, rough(shape, 0.5, 0.3), 1, {uniform(-4, 4), uniform(-9, 0)},
          uniform(-9, 9), uniform(-2, 2));
    }
    // It stood, or moved as told until now.
    if (seed % 2) world.set_motion(plate, [](double) { return Placement{{0, 0}, 0.2}; });
    world.step(kStep);
    if (seed % 2) world.set_motion(plate, {});
    World loaded = load_snapshot(save_snapshot(world));
    for (int i = 0; i < 40; ++i) {
      expect_same(world.step(kStep), loaded.step(kStep),
                  "seed " + std::to_string(seed) + ", step " + std::to_string(i));
      ASSERT_FALSE(HasFatalFailure());
    }
  }
}

TEST(Snapshot, SolversLeaveNothingBehindWhenTheyAreExchanged) {
  World world = make_world(kScenes[1], {});
  for (int i = 0; i < 40; ++i) world.step(kStep);
  WorldConfig other = world.config();
  other.solver = "pgs";
  other.broad_phase = "sweep_and_prune";
  other.stepper = "event_driven";
  other.impact_law = "poisson";
  World loaded = load_snapshot(save_snapshot(world));
  world.reconfigure(other);
  loaded.reconfigure(other);
  EXPECT_EQ(world.broad_phase().name(), "sweep_and_prune");
  for (int i = 0; i < 4; ++i) {
    expect_same(world.step(kStep), loaded.step(kStep), "step " + std::to_string(i));
    ASSERT_FALSE(HasFatalFailure());
  }
  other.solver = "none such";
  EXPECT_THROW(world.reconfigure(other), std::invalid_argument);
  EXPECT_EQ(world.config().solver, "pgs");
}

/// A small world of everything, and what a user does to it between steps.
class Anything {
 public:
  explicit Anything(unsigned seed) : random_(seed), world(config(seed)) {
    const BodyId ground = world.create_body({.type = BodyType::Static});
    if (one_of(2))
      world.add_shape(ground, rough(make_half_plane({0, 0}, {0, 1}), 0.5));
    else
      world.add_shape(ground, rough(make_chain(std::vector<Vec2>{{-8, 2}, {-2, 0}, {2, 0}, {8, 2}}), 0.5));
    for (int i = 0; i < 9; ++i) create();
    for (int i = 0; i < 3; ++i) join();
  }

  void act() {
    const BodyId body = any();
    switch (one_of(10)) {
      case 0:
        return world.set_type(body, static_cast<BodyType>(one_of(3)));
      case 1:
        return world.set_pose(body, place(), uniform(-3, 3));
      case 2:
        world.destroy(body);
        std::erase(bodies_, body);
        return create();
      case 3:
        if (joints_.empty() || !world.alive(joints_.back())) return;
        world.destroy(joints_.back());
        return joints_.pop_back();
      case 4:
        return join();
      case 5:
        return world.apply_force(body, {uniform(-50, 50), 50}, world.position(body));
      case 6:
        return throw_up();
      case 7:
        if (world.bodies().type[body.index] == BodyType::Dynamic) world.set_drag(body, {.linear = 1});
        return;
      case 8:
        if (world.bodies().type[body.index] != BodyType::Static) world.set_velocity(body, {}, 0);
        return;
      default:
        return;
    }
  }
  unsigned one_of(unsigned count) { return random_() % count; }

 private:
  std::mt19937 random_;
  std::vector<BodyId> bodies_;
  std::vector<JointId> joints_;

  static WorldConfig config(unsigned seed) {
    WorldConfig config;
    config.stepper = steppers()[seed % steppers().size()].name;
    return config;
  }
  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Vec2 place() { return {uniform(-4, 4), uniform(0.6, 5)}; }
  BodyId any() { return bodies_[one_of(static_cast<unsigned>(bodies_.size()))]; }

  void create() {
    const unsigned kind = one_of(8);
    const BodyType type = kind == 0 ? BodyType::Static : kind <= 2 ? BodyType::Kinematic : BodyType::Dynamic;
    const Vec2 velocity = kind == 1 ? Vec2{} : Vec2{uniform(-4, 4), uniform(-4, 0)};
    bodies_.push_back(world.create_body({.type = type, .position = place(), .velocity = velocity}));
    const unsigned form = one_of(3);
    ShapeDef shape = rough(form == 0   ? make_disc(uniform(0.1, 0.4))
                           : form == 1 ? make_box({uniform(0.3, 1), uniform(0.2, 0.6)})
                                       : make_capsule({-0.3, 0}, {0.3, 0}, 0.1),
                           0.5, one_of(2) ? 0 : 0.4);
    world.add_shape(bodies_.back(), shape);
    shape.sensor = true;
    if (one_of(3) == 0) world.add_shape(bodies_.back(), shape);
  }
  void join() {
    const BodyId a = any(), b = any();
    if (a == b) return;
    const Vec2 at = 0.5 * (world.position(a) + world.position(b));
    JointDef def{.a = a, .b = b, .anchor_a = at, .anchor_b = at};
    if (one_of(2)) {
      def.kind = JointKind::Spring;
      def.stiffness = 40;
      def.damping = 1;
      def.break_force = 60;
    }
    joints_.push_back(world.create_joint(def));
  }
  void throw_up() {
    world.set_force_field([now = world.time()](const FieldSample& sample) -> Wrench {
      if (sample.time > now) throw std::runtime_error("no");
      return {};
    });
    try {
      world.step(kStep);
    } catch (const std::runtime_error&) {
    }
    world.set_force_field({});
  }

 public:
  World world;
};

/// Where and between what, as well.
void expect_same_events(const StepReport& x, const StepReport& y, const std::string& where) {
  const auto events = [](const StepReport& r) {
    std::vector<std::tuple<int, ShapeId, ShapeId, double, bool>> all;
    for (const ContactEvent& e : r.events)
      all.emplace_back(static_cast<int>(e.kind), e.shape_a, e.shape_b, e.time, e.sensor);
    return all;
  };
  ASSERT_TRUE(events(x) == events(y)) << where;
  ASSERT_EQ(x.joint_events.size(), y.joint_events.size()) << where;
}

/// After any step, while some sleep, and right after anything that the user did.
TEST(Snapshot, RandomWorldsGoOnAsWithoutTheDetour) {
  for (int trial = 0; trial < test_scale(40); ++trial) {
    const unsigned seed = 7000 + static_cast<unsigned>(trial);
    Anything any(seed);
    World& world = any.world;
    for (unsigned left = 1 + any.one_of(trial % 4 == 0 ? 240 : 60); left > 0; --left) {
      if (any.one_of(12) == 0) any.act();
      world.step(kStep);
    }
    any.act();
    World loaded = load_snapshot(save_snapshot(world));
    for (int i = 0; i < 30; ++i) {
      const std::string where = "seed " + std::to_string(seed) + ", step " + std::to_string(i);
      const StepReport &x = world.step(kStep), &y = loaded.step(kStep);
      expect_same_events(x, y, where);
      if (!HasFatalFailure()) expect_same(x, y, where);
      ASSERT_FALSE(HasFatalFailure());
    }
  }
}

std::string refusal(std::span<const std::byte> bytes) {
  try {
    load_snapshot(bytes);
  } catch (const ArchiveError& error) {
    return error.what();
  }
  return "";
}

TEST(Snapshot, ForeignFilesAreRefusedWithTheReasonAndTheOffset) {
  World world = make_world(kScenes[1], {});
  for (int i = 0; i < 20; ++i) world.step(kStep);
  const std::vector<std::byte> good = save_snapshot(world);
  EXPECT_EQ(refusal(good), "");
  EXPECT_EQ(refusal({}), "offset 0: not a Skerry file (its first bytes are others)");
  std::vector<std::byte> bytes = good;
  bytes[12] = std::byte{'x'};
  EXPECT_NE(refusal(bytes).find("of kind"), std::string::npos) << refusal(bytes);
  bytes = good;
  bytes[19] = std::byte{16};
  EXPECT_EQ(refusal(bytes), "offset 19: version 16, this program reads version 28");
  bytes = good;
  bytes.back() ^= std::byte{1};
  EXPECT_NE(refusal(bytes).find("section repo is damaged"), std::string::npos) << refusal(bytes);
  bytes = good;
  bytes.push_back({});
  EXPECT_NE(refusal(bytes).find("1 bytes after the last section"), std::string::npos) << refusal(bytes);
  bytes = good;
  bytes.resize(bytes.size() - 1);
  EXPECT_NE(refusal(bytes).find("is cut off"), std::string::npos) << refusal(bytes);
}

TEST(Snapshot, DamageAnywhereIsRefused) {
  World world = make_world(kScenes[1], {});
  for (int i = 0; i < 20; ++i) world.step(kStep);
  const std::vector<std::byte> good = save_snapshot(world);
  const unsigned seed = 20261121;
  std::mt19937 random(seed);
  for (int trial = 0; trial < test_scale(600); ++trial) {
    std::vector<std::byte> bytes = good;
    const std::size_t at = random() % bytes.size();
    switch (trial % 4) {
      case 0:
        bytes[at] ^= static_cast<std::byte>(1 << random() % 8);
        break;
      case 1:
        bytes.resize(at);
        break;
      case 2:
        bytes.erase(bytes.begin() + static_cast<std::ptrdiff_t>(at));
        break;
      default:
        bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), std::byte{0x5a});
    }
    const std::string why = refusal(bytes);
    ASSERT_NE(why, "") << "seed " << seed << ", trial " << trial << ", byte " << at;
    ASSERT_EQ(why.rfind("offset ", 0), 0u) << why;
  }
}

// The sections themselves, without the checksum that would catch it first: no read beyond the end, no memory
// for lists that cannot be there.
TEST(Archive, DamagedBytesNeverReadBeyondTheirEnd) {
  std::mt19937 random(5);
  for (int trial = 0; trial < test_scale(3000); ++trial) {
    std::vector<std::byte> bytes;
    Archive write(bytes);
    std::vector<std::string> words{"one", "two", "three"};
    std::vector<std::vector<double>> lists{{1, 2, 3}, {}, {4}};
    std::optional<double> maybe = 5.0;
    bool flag = true;
    write(words, lists, maybe, flag);
    if (trial % 2) bytes.resize(random() % bytes.size());
    if (!bytes.empty()) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
    Archive read(bytes, 0);
    try {
      read(words, lists, maybe, flag);
      read.finish();
    } catch (const ArchiveError&) {
    }
  }
}

/// What falls asleep keeps the way of its last step: what comes near, or just not, looks at it.
TEST(Snapshot, SleepersAreAsFarFromWhatComesFastAsTheyWere) {
  for (unsigned seed = 0; seed < 120; ++seed) {
    test::Draw draw(seed);
    World world;
    add_ground(world, rough(make_disc(1), 0.5));
    for (int i = 0; i < 20; ++i) {
      for (const Vec2 at : {Vec2{6.0 * i, 0.3}, Vec2{6.0 * i + 1, 0.3}, Vec2{6.0 * i, 0.9}}) {
        add(world, at, rough(make_box({0.8, 0.6}), 0.5, 0.3));
      }
    }
    for (int i = 0; i < 5; ++i) world.step(kStep);
    ASSERT_TRUE(world.asleep(world.body_id(1)));
    for (int i = 0; i < 20; ++i) {
      // It ends a step right above one, or flies across several.
      const bool across = seed >= 20;
      const double speed = draw.uniform(across ? 10 : 20, 60), x = 6 * i + draw.uniform(0.5, 1.5);
      const double y = across ? draw.uniform(0.7, 1.6) : 0.7 + speed * kStep + draw.uniform(-0.01, 0.01);
      const Vec2 velocity = across ? Vec2{-speed, draw.uniform(-speed, 0)} : Vec2{0, -speed};
      add(world, {x, y}, rough(make_disc(0.1), 0.5, 0.3), 1, velocity);
    }
    World loaded = load_snapshot(save_snapshot(world));
    for (int i = 0; i < 2; ++i) {
      const StepReport &x = world.step(kStep), &y = loaded.step(kStep);
      expect_same(x, y, "seed " + std::to_string(seed));
      ASSERT_FALSE(HasFatalFailure() || HasNonfatalFailure());
    }
  }
}

}  // namespace snapshot_test
}  // namespace skerry
