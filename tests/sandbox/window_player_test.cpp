// SPDX-License-Identifier: MIT
//
// Time travel without a window: demo states, inputs, seeking, recordings.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "sandbox/bridge_view.h"
#include "sandbox/demo.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "sandbox/lua_arena.h"
#include "sandbox/window/player.h"
#include "sandbox/window/recording.h"
#include "tests/sandbox/temporary.h"
#include "tests/support/paths.h"
#include "tests/support/scale.h"

namespace skerry::sandbox {
namespace window_player_test {

/// Lua variables, random numbers, appointments and a sensor all steer the bodies.
constexpr const char* kRestless = R"lua(
demo{ title = "Restless", seconds = 2 }
ground{ y = 0 }
local bodies, count, hits = {}, 0, 0
for i = 1, 6 do bodies[i] = box{ at = {i, 0.5}, size = {0.8, 0.8}, mass = 1, restitution = 0.2,
    name = "b" .. i } end
local sensor = contact(bodies[1])
on_step(function(t)
  count = count + 1
  if sensor.touching then hits = hits + 1 end
  if count % 7 == 0 then
    local b = bodies[math.random(#bodies)]
    if b.alive then b:impulse(math.random() * 2 - 1, 2 + hits / 100) end
    bodies[#bodies + 1] = disc{ at = {math.random() * 6, 4}, radius = 0.2 }
  end
end)
at(0.5, function() gravity(0, -3) note("lighter") end)
expect("many hits", function() return hits end, { above = 0 })
)lua";

std::string restless(const TemporaryFolder& folder) {
  return folder.write("restless.lua", kRestless);
}

TEST(LuaArena, BlocksKeepTheirContentsAndReturnToAnImage) {
  LuaArena arena(1 << 20);
  std::mt19937 random(3);
  struct Block {
    unsigned char* at;
    std::size_t size;
    unsigned char fill;
  };
  std::vector<Block> blocks, kept;
  LuaArenaImage image;
  const auto check = [](const std::vector<Block>& all) {
    for (const Block& b : all) {
      if (!std::all_of(b.at, b.at + b.size, [&](unsigned char c) { return c == b.fill; })) return false;
    }
    return true;
  };
  for (int i = 0; i < 4000; ++i) {
    if (i == 2000) {
      image = arena.save();
      kept = blocks;
    }
    const bool grow = blocks.size() < 20 || random() % 2;
    if (grow) {
      const std::size_t size = 1 + random() % (i % 10 ? 300 : 3000);
      auto* at = static_cast<unsigned char*>(arena.resize(nullptr, 0, size));
      ASSERT_NE(at, nullptr);
      ASSERT_EQ(reinterpret_cast<std::uintptr_t>(at) % 16, 0u);
      blocks.push_back({at, size, static_cast<unsigned char>(random())});
      std::fill_n(at, size, blocks.back().fill);
      continue;
    }
    Block& block = blocks[random() % blocks.size()];
    const std::size_t size = random() % 3 ? 1 + random() % 1500 : 0;
    const std::size_t same = std::min(size, block.size);
    block.at = static_cast<unsigned char*>(arena.resize(block.at, block.size, size));
    if (size == 0) {
      block = blocks.back();
      blocks.pop_back();
      continue;
    }
    ASSERT_TRUE(std::all_of(block.at, block.at + same, [&](unsigned char c) { return c == block.fill; }));
    block.size = size;
    std::fill_n(block.at, size, block.fill);
  }
  EXPECT_TRUE(check(blocks));
  arena.restore(image);
  EXPECT_TRUE(check(kept));
}

TEST(LuaArena, AFullArenaGivesNull) {
  LuaArena arena(1 << 20);
  EXPECT_EQ(arena.resize(nullptr, 0, std::size_t{1} << 30), nullptr);
  EXPECT_NE(arena.resize(nullptr, 0, 100), nullptr);
}

TEST(DemoState, RestoresTheWorldAndTheVariablesOfTheScript) {
  const TemporaryFolder folder;
  Demo demo(restless(folder), {});
  for (int i = 0; i < 25; ++i) demo.step();
  const DemoState state = demo.save();
  EXPECT_EQ(state.step(), 25u);
  std::vector<std::uint64_t> hashes;
  for (int i = 0; i < 60; ++i) {
    demo.step();
    hashes.push_back(demo.world().state_hash());
  }
  EXPECT_EQ(demo.notes().size(), 1u);
  demo.restore(state);
  EXPECT_EQ(demo.steps_done(), 25u);
  EXPECT_TRUE(demo.notes().empty());
  for (const std::uint64_t hash : hashes) {
    demo.step();
    ASSERT_EQ(demo.world().state_hash(), hash) << demo.steps_done();
  }
  Demo other(restless(folder), {});
  EXPECT_THROW(other.restore(state), std::invalid_argument);
}

// Each of them changes what the world asks the script, or how many bridges there are, on its way.
constexpr const char* kChangeable[] = {
    "local b = disc{ at = {0, 0}, radius = 0.1, mass = 1 }\n"
    "field(function(x, y, vx, vy, m) return 1, 0 end)\n"
    "at(0.3, function() field(function() return 0, 1 end) end)\nat(0.6, function() field() end)",
    "local b = box{ size = {1, 1}, type = 'kinematic' }\nmove(b, function(t) return t, 0 end)\n"
    "at(0.4, function() move(b, function(t) return 0.4, t end) end)",
    "at(0.4, function() bridge{ nodes = {{0, 0}, {4, 0}}, members = {{1, 2}},\n"
    "  section = { area = 0.01, modulus = 2e11, strength = 2e8 }, supports = {{1, 'pinned'}, {2, "
    "'roller'}},\n"
    "  deck = {1, 2}, train = { axles = {1e3}, speed = 4 } } end)"};

TEST(DemoState, RestoresFieldsMotionsAndBridges) {
  const TemporaryFolder folder;
  for (const char* body : kChangeable) {
    Demo demo(
        folder.write("c.lua", std::string("demo{ title = 'C', seconds = 1, gravity = {0, 0} }\n") + body),
        {});
    std::vector<DemoState> states;
    std::vector<std::uint64_t> hashes;
    std::vector<std::size_t> bridges;
    for (int i = 0; i < 60; ++i) {
      states.push_back(demo.save());
      demo.step();
      hashes.push_back(demo.world().state_hash());
      bridges.push_back(demo.bridges().size());
    }
    // Back, on, and from each of them to the end.
    for (const std::size_t from : {0u, 50u, 10u, 30u, 20u}) {
      demo.restore(states[from]);
      for (std::size_t i = from; i < 60; ++i) {
        demo.step();
        ASSERT_EQ(demo.world().state_hash(), hashes[i]) << body << " from " << from << " at " << i;
        ASSERT_EQ(demo.bridges().size(), bridges[i]) << body << " from " << from << " at " << i;
      }
    }
  }
}

UserInput grab(const World& world, std::uint32_t slot) {
  const BodyId body = world.body_id(slot);
  return {.kind = InputKind::Grab, .body = body, .at = world.position(body)};
}

/// Plays with pushes of a user in between; the states' hashes.
void play(Player& player) {
  for (int i = 0; i < 10; ++i) player.advance();
  player.input(grab(player.demo().world(), 3));
  for (int i = 0; i < 12; ++i) {
    player.input({.kind = InputKind::Drag, .at = {3 + 0.05 * i, 1 + 0.1 * i}});
    player.advance();
  }
  player.input({.kind = InputKind::Spawn, .at = {2, 5}, .spawn = SpawnKind::Hexagon, .size = 0.3});
  for (int i = 0; i < 12; ++i) player.advance();
  player.input({.kind = InputKind::Release});
  player.input({.kind = InputKind::Remove, .body = player.demo().world().body_id(2)});
  player.input({.kind = InputKind::Hold, .body = player.demo().world().body_id(4)});
  for (int i = 0; i < 6; ++i) player.advance();
  player.input({.kind = InputKind::Hold, .body = player.demo().world().body_id(4)});
  player.input(
      {.kind = InputKind::Methods, .methods = {"pgs", "time_stepping", "sweep_and_prune", "poisson"}});
  for (int i = 0; i < 20; ++i) player.advance();
}

TEST(Player, EveryStateIsReachedAgainByTheBitFromEverywhere) {
  const TemporaryFolder folder;
  Player player(restless(folder), {}, {.spacing = 8});
  play(player);
  const std::uint64_t end = player.end();
  ASSERT_EQ(end, 60u);
  std::mt19937 random(11);
  for (int i = 0; i < test_scale(60); ++i) {
    const std::uint64_t target = random() % (end + 1);
    player.seek(target);
    ASSERT_EQ(player.step(), target);
    ASSERT_EQ(player.end(), end);
    ASSERT_EQ(player.divergence(), std::nullopt) << "seek " << i << " to " << target;
    ASSERT_EQ(player.history().ledger().size(), target + 1);
  }
  // A state before its inputs has the recorded hash, so a fresh run with the same inputs shows the same.
  Player again(restless(folder), {});
  again.play_inputs(player.inputs());
  for (std::uint64_t step = 0; step < end; ++step) {
    ASSERT_EQ(again.hash(step), player.hash(step)) << step;
    again.advance();
  }
}

TEST(Player, ThousandsOfStatesStayInReachWithLittleMemory) {
  const TemporaryFolder folder;
  const std::string path =
      folder.write("pendulum.lua",
                   "demo{ title = 'P', seconds = 60 }\nlocal n = 0\n"
                   "local b = disc{ at = {1, 0}, radius = 0.2, mass = 1 }\n"
                   "rod{ from = {0, 0}, to = b }\n"
                   "on_step(function() n = n + 1 b:force(n % 5 * math.random(), 0) end)\n");
  Player player(path, {}, {.spacing = 16, .memory = std::size_t{3} << 20});
  constexpr std::uint64_t kSteps = 2200;
  while (player.step() < kSteps) player.advance();
  EXPECT_LE(player.keyframe_bytes(), std::size_t{3} << 20);
  EXPECT_LT(player.keyframes(), kSteps / 16) << "some were given up";
  EXPECT_GE(player.keyframes(), 10u);
  std::mt19937 random(4);
  for (int i = 0; i < 20; ++i) {
    player.seek(random() % (kSteps + 1));
    ASSERT_EQ(player.divergence(), std::nullopt) << player.step();
  }
  player.seek(0);
  EXPECT_EQ(player.step(), 0u);
  EXPECT_EQ(player.end(), kSteps);
}

TEST(Player, ForceFieldsMotionsAndEventsOfAScriptAreThereAgain) {
  const TemporaryFolder folder;
  const std::string path =
      folder.write("fields.lua",
                   "demo{ title = 'F', seconds = 2 }\nground{ y = 0 }\nlocal n = 0\n"
                   "local b = disc{ at = {0, 1}, radius = 0.2, mass = 1, velocity = {2, 0} }\n"
                   "local lift = box{ at = {3, 0.2}, size = {1, 0.2}, type = 'kinematic' }\n"
                   "field(function(x, y, vx, vy, m, t) return -3 * x + n, 0 end)\n"
                   "move(lift, function(t) return 3, 0.2 + 0.1 * math.sin(3 * t), 0 end)\n"
                   "on_event(function() return b.vx end, function(t) n = n + 1 end)\n");
  Player player(path, {}, {.spacing = 8});
  for (int i = 0; i < 90; ++i) player.advance();
  for (const std::uint64_t target : {20, 85, 3, 60, 41, 90, 0}) {
    player.seek(target);
    ASSERT_EQ(player.divergence(), std::nullopt) << target;
  }
}

TEST(Player, TheStateOfABridgeIsThereAgain) {
  Player player(find_demo("failing_bridge", demo_tree()).path, {}, {.spacing = 8});
  for (int i = 0; i < 150; ++i) player.advance();
  for (const std::uint64_t target : {12, 150, 0, 120, 77, 149}) {
    player.seek(target);
    ASSERT_EQ(player.step(), target);
    ASSERT_EQ(player.divergence(), std::nullopt) << target;
  }
}

TEST(Player, WhatAScriptPrintsIsPrintedOnce) {
  const TemporaryFolder folder;
  const std::string path = folder.write("p.lua", "demo{ title = 'P' }\non_step(function(t) print(t) end)");
  int lines = 0;
  DemoOptions options;
  options.print = [&](std::string_view) { ++lines; };
  Player player(path, options);
  player.seek(20);
  player.seek(3);
  player.seek(10);
  EXPECT_EQ(lines, 20);
  player.seek(21);
  EXPECT_EQ(lines, 21);
}

TEST(Player, AnInputInThePastForgetsTheFuture) {
  const TemporaryFolder folder;
  Player player(restless(folder), {}, {.spacing = 8});
  play(player);
  player.seek(30);
  player.input({.kind = InputKind::Spawn, .at = {1, 3}, .spawn = SpawnKind::Box, .size = 0.2});
  EXPECT_EQ(player.end(), 30u);
  EXPECT_LE(player.inputs().back().step, 30u);
  for (int i = 0; i < 10; ++i) player.advance();
  player.seek(33);
  player.seek(40);
  EXPECT_EQ(player.divergence(), std::nullopt);
}

// An error before, after and at the end of a step of the world.
constexpr const char* kErrors[] = {
    "on_step(function(t) n = n + 1 if t > 0.29 then error('no') end end)",
    "at(0.3, function() n = n + 1 error('no') end)",
    "expect('x', function() n = n + 1 if n > 20 then error('no') end return n end,"
    " { always = true, above = 0 })",
    "on_event(function() n = n + 1 if n > 20 then error('no') end return n end,"
    " function() end)",
    "expect('x', function() error('no') end, { above = 0 })"};

TEST(Player, AnErrorOfTheScriptLeavesTheStateBeforeTheStep) {
  const TemporaryFolder folder;
  for (const char* error : kErrors) {
    const std::string path = folder.write(
        "e.lua", std::string("demo{ title = 'E', seconds = 1 }\nlocal n = 0\nlocal b = disc{ at = {0, 0}, "
                             "radius = 0.1, mass = 1 }\non_step(function() b:force(n, 0) end)\n") +
                     error);
    Player player(path, {}, {.spacing = 8});
    const auto play_on = [&] {
      for (;;) player.advance();
    };
    ASSERT_THROW(play_on(), ScriptError) << error;
    const std::uint64_t here = player.step();
    EXPECT_GE(here, 16u) << error;
    EXPECT_EQ(player.end(), here) << error;
    EXPECT_EQ(player.history().ledger().size(), here + 1) << error;
    // Again and again it comes to the same.
    for (const std::uint64_t from : {here, std::uint64_t{0}, here - 3}) {
      player.seek(from);
      EXPECT_THROW(play_on(), ScriptError) << error;
      EXPECT_EQ(player.step(), here) << error;
      EXPECT_EQ(player.demo().world().state_hash(), player.hash(here)) << error;
      EXPECT_EQ(player.divergence(), std::nullopt) << error;
    }
    const Recording recording = record(player);
    EXPECT_EQ(recording.steps(), here) << error;
    EXPECT_EQ(player.step(), here) << error;
    EXPECT_EQ(replay(recording), std::nullopt) << error;
  }
}

TEST(Player, ABodyThatTheScriptNamesMayBeRemoved) {
  Player player(find_demo("newtons_cradle", demo_tree()).path, {});
  player.seek(5);
  player.input({.kind = InputKind::Remove, .body = player.demo().world().body_id(2)});
  for (int i = 0; i < 200; ++i) ASSERT_NO_THROW(player.advance()) << i;
  const std::vector<Check>& checks = player.demo().checks();
  const auto unmeasured = [](const Check& check) { return check.state == CheckState::Unmeasured; };
  EXPECT_EQ(std::count_if(checks.begin(), checks.end(), unmeasured), 1);
  ASSERT_EQ(player.demo().notes().size(), 1u);
  EXPECT_NE(player.demo().notes()[0].text.find("body 2 does not exist"), std::string::npos)
      << player.demo().notes()[0].text;
  player.seek(4);
  EXPECT_EQ(std::count_if(checks.begin(), checks.end(), unmeasured), 0);
  const Recording recording = record(player);
  EXPECT_EQ(recording.steps(), 205u);
  EXPECT_EQ(replay(load_recording(save_recording(recording))), std::nullopt);
  EXPECT_EQ(player.divergence(), std::nullopt);
}

TEST(Player, ASizeThatNoShapeHasMakesNoBody) {
  const TemporaryFolder folder;
  Player player(restless(folder), {});
  const std::size_t bodies = player.demo().world().bodies().size();
  for (const double size : {0.0, 1e13})
    EXPECT_THROW(player.input({.kind = InputKind::Spawn, .at = {0, 3}, .size = size}), std::invalid_argument);
  EXPECT_EQ(player.demo().world().bodies().size(), bodies);
  EXPECT_TRUE(player.inputs().empty());
}

TEST(Hand, HoldsABodyUnderItsGripAndIsNotInfinitelyStrong) {
  World world({.gravity = {0, -9.81}});
  const BodyId box = world.create_body({.mass = 3.0});
  world.add_shape(box, {.shape = make_box({1, 0.4})});
  Hand hand;
  hand.grab(world, box, {0.5, 0.2});
  hand.move({2, 3});
  for (int i = 0; i < 480; ++i) {
    hand.pull(world, 1.0 / 60);
    world.step(1.0 / 60);
  }
  const Vec2 grip = hand.grip(world);
  EXPECT_NEAR(grip.x, 2, 1e-3);
  EXPECT_NEAR(grip.y, 3, 1e-3);
  // Its centre hangs below the grip, and it has come to rest.
  EXPECT_NEAR(world.position(box).x, 2, 2e-3);
  EXPECT_NEAR(length(world.velocity(box)), 0, 1e-3);
  // Far away: the force is limited to 60 weights.
  world.set_velocity(box, {}, 0);
  hand.move({2, 1e6});
  hand.pull(world, 1.0 / 60);
  EXPECT_NEAR(length(world.bodies().force[box.index]), 60 * 3 * 10, 1e-6);
  world.destroy(box);
  hand.pull(world, 1.0 / 60);
  EXPECT_FALSE(hand.holds());
}

TEST(Pick, SeesThroughSensors) {
  World world;
  const BodyId box = world.create_body({.position = {0, 1}});
  world.add_shape(box, {.shape = make_disc(0.5)});
  const BodyId zone = world.create_body({.position = {0, 1}});
  world.add_shape(zone, {.shape = make_disc(2), .sensor = true});
  EXPECT_EQ(pick_body(world, {0, 1}, 0), box);
  EXPECT_EQ(pick_body(world, {1, 1}, 0), zone);
}

TEST(Pick, FindsTheTopmostDynamicBodyAndSmallOnesNearby) {
  World world;
  const BodyId ground = world.create_body({.type = BodyType::Static});
  world.add_shape(ground, {.shape = make_half_plane({0, 0}, {0, 1})});
  const BodyId low = world.create_body({.position = {0, 1}});
  world.add_shape(low, {.shape = make_disc(1)});
  const BodyId high = world.create_body({.position = {0.5, 1}});
  world.add_shape(high, {.shape = make_disc(1)});
  const BodyId small = world.create_body({.position = {5, 1}});
  world.add_shape(small, {.shape = make_disc(0.01)});
  EXPECT_EQ(pick_body(world, {0.2, 1}, 0), high);
  EXPECT_EQ(pick_body(world, {-0.9, 1}, 0), low);
  EXPECT_FALSE(pick_body(world, {0, -1}, 0.1));
  EXPECT_FALSE(pick_body(world, {5.05, 1}, 0));
  EXPECT_EQ(pick_body(world, {5.05, 1}, 0.1), small);
  // What the user holds fast he can let go again; what the scene is made of stays.
  const UserInput hold{.kind = InputKind::Hold, .body = high};
  Hand hand;
  apply_input(hold, {}, world, hand);
  EXPECT_EQ(world.bodies().type[high.index], BodyType::Static);
  EXPECT_EQ(pick_body(world, {0.2, 1}, 0), low);
  EXPECT_EQ(pick_body(world, {0.2, 1}, 0, {&hold, 1}), high);
  apply_input(hold, {}, world, hand);
  EXPECT_EQ(world.bodies().type[high.index], BodyType::Dynamic);
  world.destroy(high);
  apply_input(hold, {}, world, hand);
  EXPECT_EQ(pick_body(world, {0.2, 1}, 0, {&hold, 1}), low);
}

Recording recording_of(const TemporaryFolder& folder) {
  Player player(restless(folder), {.seed = 5});
  play(player);
  player.seek(20);
  Recording recording = record(player);
  EXPECT_EQ(player.step(), 20u);
  return recording;
}

TEST(Recording, RunsAgainFromItsBytes) {
  const TemporaryFolder folder;
  const Recording recording = recording_of(folder);
  EXPECT_EQ(recording.steps(), 60u);
  const Recording loaded = load_recording(save_recording(recording));
  EXPECT_EQ(loaded.inputs, recording.inputs);
  EXPECT_EQ(loaded.options.seed, 5u);
  EXPECT_EQ(loaded.script_hash, file_hash(loaded.path));
  EXPECT_EQ(replay(loaded), std::nullopt);
}

TEST(Recording, KnowsTheTextThatRan) {
  const TemporaryFolder folder;
  Player player(restless(folder), {});
  const std::uint64_t loaded = file_hash(player.demo().path());
  for (int i = 0; i < 5; ++i) player.advance();
  folder.write("restless.lua", "demo{ title = ");
  EXPECT_EQ(record(player).script_hash, loaded);
  EXPECT_NE(file_hash(player.demo().path()), loaded);
}

TEST(Recording, NamesTheFirstStateBodyAndValueThatDiffer) {
  const TemporaryFolder folder;
  Recording recording = recording_of(folder);
  // A last bit in the past of one body.
  bool found = false;
  for (std::uint64_t step = 17; step < recording.states.size() && !found; ++step) {
    for (RecordedBody& body : recording.states[step].changed) {
      if (body.slot != 4) continue;
      body.values[4] = std::nextafter(body.values[4], 1e9);
      recording.states[step].hash ^= 1;
      const auto difference = replay(recording);
      ASSERT_TRUE(difference);
      EXPECT_EQ(difference->step, step);
      EXPECT_EQ(difference->value, "velocity y");
      EXPECT_EQ(difference->expected, body.values[4]);
      EXPECT_NE(difference->text().find("velocity y of body 4 \"b4\" is "), std::string::npos)
          << difference->text();
      found = true;
      break;
    }
  }
  EXPECT_TRUE(found);
  // Another script.
  std::string text = kRestless;
  text.replace(text.find("{i, 0.5}"), 8, "{i, 0.6}");
  const std::string other = folder.write("other.lua", text);
  const auto difference = replay(recording_of(folder), other);
  ASSERT_TRUE(difference);
  EXPECT_EQ(difference->step, 0u);
  EXPECT_EQ(difference->value, "y");
}

TEST(Recording, DamagedFilesAreRefused) {
  const TemporaryFolder folder;
  const std::vector<std::byte> good = save_recording(recording_of(folder));
  std::mt19937 random(9);
  for (int trial = 0; trial < test_scale(200); ++trial) {
    std::vector<std::byte> bytes = good;
    if (trial % 2)
      bytes[random() % bytes.size()] ^= static_cast<std::byte>(1 + random() % 255);
    else
      bytes.resize(random() % bytes.size());
    EXPECT_THROW(load_recording(bytes), ArchiveError) << trial;
  }
}

}  // namespace window_player_test
}  // namespace skerry::sandbox
