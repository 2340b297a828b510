// SPDX-License-Identifier: MIT
//
// The script functions: what they build, and what they say when they are used wrongly.
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sandbox/demo.h"
#include "sandbox/errors.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace script_test {

using testing::EndsWith;
using testing::HasSubstr;

constexpr const char* kHead = "demo{ title = 'T', seconds = 1, gravity = {0, 0}, friction = 0 }\n";

class Script : public testing::Test {
 protected:
  Demo load(const std::string& body, const DemoOptions& options = {}) {
    return Demo(folder_.write("arch.lua", kHead + body), options);
  }
  // The message without the folder: it begins with "arch.lua:".
  std::string error_of(const std::string& body) {
    try {
      load(body);
    } catch (const ScriptError& error) {
      const std::string text = error.what();
      const std::size_t at = text.find("arch.lua");
      return at == std::string::npos ? text : text.substr(at);
    }
    return "no error";
  }
  TemporaryFolder folder_;
};

TEST_F(Script, NamesFileLineFunctionArgumentAndWhatItGot) {
  EXPECT_EQ(error_of("\nbox{ at = {0, 1}, size = 3 }"),
            "arch.lua:3: box: size expected {w, h}, got the number 3");
  EXPECT_EQ(error_of("disc{ at = {0, 1} }"), "arch.lua:2: disc: radius expected a number, got nothing");
  EXPECT_EQ(error_of("disc{ radius = -1 }"), "arch.lua:2: disc: radius must be positive, got -1");
  EXPECT_EQ(error_of("box{ size = {1, 0} }"), "arch.lua:2: box: size must be positive, got {1, 0}");
  EXPECT_EQ(error_of("box{ siez = {1, 1} }"),
            "arch.lua:2: box: no argument \"siez\"; did you mean \"size\"?");
  EXPECT_EQ(error_of("box(3)"),
            "arch.lua:2: box: expected a table, as in box{ size = ... }, got the number 3");
  EXPECT_EQ(error_of("disc{ radius = 1, mass = 0 / 0 }"),
            "arch.lua:2: disc: mass expected a finite number, got the number -nan");
  EXPECT_EQ(error_of("disc{ radius = 1, mass = 0 }"), "arch.lua:2: disc: mass must be positive, got 0");
  EXPECT_EQ(error_of("disc{ radius = 1, inertia = 0 }"), "arch.lua:2: disc: inertia must be positive, got 0");
  EXPECT_EQ(error_of("disc{ radius = 1, type = 'statik' }"),
            "arch.lua:2: disc: no type \"statik\"; did you mean \"static\"?");
  EXPECT_EQ(error_of("ground{ type = 'dynamic' }"),
            "arch.lua:2: ground: no type \"dynamic\"; there are static, kinematic");
  EXPECT_EQ(error_of("ground{ velocity = {1, 0} }"),
            "arch.lua:2: ground: what is static has no velocity and no omega; try type = \"kinematic\"");
  EXPECT_EQ(error_of("disc{ radius = 1, type = 'static', omega = 2 }"),
            "arch.lua:2: disc: what is static has no velocity and no omega; try type = \"kinematic\"");
  EXPECT_EQ(error_of("disc{ radius = 1, color = 'blu' }"),
            "arch.lua:2: disc: no color \"blu\"; did you mean \"blue\"?");
  EXPECT_EQ(error_of("disc{ 1, 2 }"),
            "arch.lua:2: disc: the arguments have names, as in radius = ...; got one without: the number 1");
  EXPECT_THAT(error_of("polygon{ corners = {{0, 0}, {1, 0}, 5} }"),
              HasSubstr("polygon: corners[3] expected {x, y}, got the number 5"));
  EXPECT_EQ(error_of("show{ 'contcats' }"),
            "arch.lua:2: show: no overlay \"contcats\"; did you mean \"contacts\"?");
  EXPECT_THAT(error_of("expect('x', function() return 1 end, {})"), HasSubstr("one of below, above, equals"));
  EXPECT_THAT(error_of("rod{ from = 3, to = {0, 1} }"), HasSubstr("rod: from expected {x, y}, a body, or"));
  EXPECT_THAT(error_of("local b = disc{ radius = 1 }\nb.colour = 3"),
              HasSubstr("arch.lua:3: body: \"colour\""));
  EXPECT_THAT(error_of("local b = disc{ radius = 1 }\nprint(b.vz)"),
              HasSubstr("no field \"vz\"; did you mean"));
}

TEST_F(Script, StopsScriptsThatMakeBodiesForEver) {
  Demo demo = load("on_step(function()\n  while true do disc{ radius = 1 } end\nend)");
  try {
    demo.step();
    FAIL();
  } catch (const ScriptError& error) {
    EXPECT_THAT(error.what(), EndsWith("arch.lua:3: the script runs for too long (limits: 200 million "
                                       "instructions to load, 20 million a callback; a body or a joint "
                                       "counts 400)"));
  }
}

TEST_F(Script, WhatIsAskedForAnAnswerMustNotChangeTheWorld) {
  const auto error_of_run = [&](const std::string& body) -> std::string {
    try {
      Demo demo = load(body);
      for (int i = 0; i < 30; ++i) {
        demo.step();
        demo.watch_values();
      }
    } catch (const ScriptError& error) {
      const std::string text = error.what();
      const std::size_t at = text.find("arch.lua");
      return at == std::string::npos ? text : text.substr(at);
    }
    return "no error";
  };
  const std::string scene =
      "local k = box{ at = {0, 5}, size = {2, 0.2}, type = 'kinematic', mass = 1 } "
      "local a = disc{ at = {0, 9}, radius = 0.1 } local b = disc{ at = {0, 7}, radius = 0.1 } "
      "local j = hinge{ a = a, at = {0, 10} } local late = false at(0.2, function() late = true end)\n";
  for (const auto& [change, function] : std::vector<std::pair<std::string, std::string>>{
           {"k.type = 'dynamic'", "body"},
           {"a.x = 3", "body"},
           {"a.vx = 3", "body"},
           {"a.mass = 3", "body"},
           {"a.friction = 0.3", "body"},
           {"k:remove()", "remove"},
           {"a:force(1, 0)", "force"},
           {"a:torque(1)", "torque"},
           {"a:impulse(1, 0)", "impulse"},
           {"disc{ radius = 0.1 }", "disc"},
           {"ground{ y = -9 }", "ground"},
           {"chain{ points = {{0, -9}, {1, -9}} }", "chain"},
           {"field()", "field"},
           {"field(function() return 0, 0 end)", "field"},
           {"move(k, function(t) return t, 0 end)", "move"},
           {"drag(a, { linear = 1 })", "drag"},
           {"gravity(0, 1)", "gravity"},
           {"rod{ from = a, to = b }", "rod"},
           {"hinge{ a = b, at = {0, 7} }", "hinge"},
           {"j:remove()", "remove"},
           {"j:set_speed(1)", "set_speed"},
           {"j.upper = 1", "joint"},
           {"on_event(function() return 1 end, function() end)", "on_event"}}) {
    const std::string when = "if late then " + change + " end ";
    const std::string end = " is asked for an answer, it must not change the world";
    EXPECT_EQ(error_of_run(scene + "move(k, function(t) " + when + "return 0, 5 + t end)"),
              "arch.lua:3: " + function + ": the function of move" + end);
    EXPECT_EQ(error_of_run(scene + "field(function() " + when + "return 0, 0 end)"),
              "arch.lua:3: " + function + ": the function of field" + end);
    EXPECT_EQ(error_of_run(scene + "watch('x', function() " + when + "return 0 end)"),
              "arch.lua:3: " + function + ": the function of watch" + end);
    EXPECT_EQ(error_of_run(scene + "on_event(function() " + when + "return 1 end, function() end)"),
              "arch.lua:3: " + function + ": the function of on_event" + end);
    // Otherwise they may.
    EXPECT_EQ(error_of_run(scene + "on_step(function(t) if t > 0.1 and late then late = false " + change +
                           " end end)"),
              "no error")
        << change;
  }
}

TEST_F(Script, MovesTurnBodiesOnlyWhereTheySaySo) {
  Demo demo = load(
      "box{ size = {1, 1}, type = 'kinematic', angle = 0.5 }\nlocal g = ground{ type = 'kinematic', tilt = "
      "0.2 }\n"
      "local b = box{ size = {1, 1}, type = 'kinematic', angle = 0.5 }\n"
      "move(g, function(t) return 0, t end)\nmove(b, function(t) return t, 0, 2 * t end)");
  demo.step();
  EXPECT_NEAR(demo.world().angle(demo.world().body_id(1)), 0.2, 1e-15);
  EXPECT_NEAR(demo.world().angle(demo.world().body_id(2)), 2 * demo.time(), 1e-15);
  EXPECT_EQ(error_of("local b = box{ size = {1, 1}, type = 'kinematic' }\n"
                     "move(b, function(t) return t, 'x' end)"),
            "arch.lua:3: move: y returned expected a finite number, got the string \"x\"");
  for (const char* field : {"x", "y", "angle", "vx", "vy", "omega"})
    EXPECT_EQ(error_of(std::string("local b = box{ size = {1, 1}, type = 'kinematic' }\n"
                                   "move(b, function(t) return t, 0 end)\nb.") +
                       field + " = 1"),
              std::string("arch.lua:4: body: \"") + field + "\" of a body that goes as `move` told it");
}

TEST_F(Script, ValuesThatWouldDoNothingAreRefused) {
  EXPECT_EQ(error_of("disc{ radius = 1, group = -0.5 }"),
            "arch.lua:2: disc: group expected a whole number, got -0.5");
  EXPECT_EQ(error_of("disc{ radius = 1, group = 1e20 }"),
            "arch.lua:2: disc: group expected a whole number, got 1e+20");
  EXPECT_EQ(error_of("local b = disc{ radius = 1 }\nb.mass = -1"),
            "arch.lua:3: body: mass: mass must be positive, got -1");
  EXPECT_EQ(error_of("local b = disc{ radius = 1 }\nb.inertia = 0"),
            "arch.lua:3: body: inertia: inertia must be positive, got 0");
  EXPECT_EQ(error_of("local b = disc{ radius = 1, type = 'static' }\nb.inertia = 1"),
            "arch.lua:3: body: inertia: only what is dynamic has one");
  EXPECT_EQ(error_of("local b = disc{ radius = 1 }\nb:remove()\nprint(b.type)"),
            "arch.lua:4: body: \"type\" of a body that was removed");
  const std::string two = "local a, b = disc{ radius = 1 }, disc{ at = {3, 0}, radius = 1 }\n";
  EXPECT_EQ(error_of(two + "local j = weld{ a = a, b = b, at = {1, 0} }\nj.length = 3"),
            "arch.lua:4: joint: a weld joint has no length");
  EXPECT_EQ(error_of(two + "local j = weld{ a = a, b = b, at = {1, 0} }\nj.motor_limit = 3"),
            "arch.lua:4: joint: a weld joint has no motor");
  EXPECT_EQ(error_of(two + "local j = rod{ from = a, to = b, break_force = 5 }\n"
                           "local k = rod{ from = a, to = b }\nj.break_force = k.break_force\n"
                           "print(j.break_force) assert(j.break_force == math.huge)"),
            "no error");
}

TEST_F(Script, ParametersThatCountStayWholeAndOthersDoNot) {
  const std::string body =
      "local n, e = param('n', 3, 1, 10), param('modulus', 2.1e11, 1, 1e12)\n"
      "assert(math.type(n) == WHOLE and math.type(e) == 'float' and e * e > 0)\n";
  const auto with = [&](const char* whole) {
    std::string text = body;
    return text.replace(text.find("WHOLE"), 5, whole);
  };
  load(with("'integer'"));
  load(with("'integer'"), {.parameters = {{"n", "4"}, {"modulus", "3"}}});
  load(with("'float'"), {.parameters = {{"n", "4.5"}}});
}

TEST_F(Script, AGroundIsNotPaintedLikeTheBodyWhosePlaceItTakes) {
  const Demo demo = load("local b = disc{ radius = 1, color = 'blue' }\nb:remove()\nground{ y = 0 }");
  EXPECT_EQ(demo.picture().colors.of(demo.world().body_id(0)), -1);
}

TEST_F(Script, HighlightsThatBodyWhateverItsNameAndItsNeighbours) {
  Demo demo = load(
      "local gone = disc{ radius = 1 }\nlocal k = box{ at = {9, 0}, size = {1, 1}, type = 'kinematic' }\n"
      "local one = disc{ at = {3, 0}, radius = 1, name = 'twin' }\n"
      "local two = disc{ at = {6, 0}, radius = 1, name = 'twin' }\nground{ y = -5 }\ngone:remove()\n"
      "highlight{ body = two, other = k }\nat(0.1, function() two:remove() end)\n"
      "at(0.2, function() highlight{ body = 'twin' } end)");
  const auto selected = [&demo] { return resolve(demo.picture().selection, demo.world()); };
  EXPECT_EQ(selected().body.index, 3u);
  EXPECT_EQ(selected().other.index, 1u);
  for (int i = 0; i < 8; ++i) demo.step();
  EXPECT_FALSE(selected().body);
  for (int i = 0; i < 8; ++i) demo.step();
  EXPECT_EQ(selected().body.index, 2u);
}

TEST_F(Script, GeometryErrorsOfTheLibraryGetAFileAndALineToo) {
  EXPECT_THAT(error_of("\npolygon{ corners = {{0, 0}, {1, 0}} }"), testing::StartsWith("arch.lua:3: "));
  EXPECT_THAT(error_of("capsule{ from = {0, 0}, to = {0, 0}, radius = 1 }"),
              testing::StartsWith("arch.lua:2: "));
}

TEST_F(Script, NeedsDemoFirstAndOnce) {
  const std::string path = folder_.write("a.lua", "disc{ radius = 1 }");
  EXPECT_THROW(Demo(path, {}), ScriptError);
  EXPECT_THAT(error_of("demo{ title = 'again' }"), HasSubstr("called a second time"));
  EXPECT_THROW(Demo(folder_.write("b.lua", "local x = 1"), {}), ScriptError);
  EXPECT_THROW(Demo(folder_ / "absent.lua", {}), ScriptError);
}

TEST_F(Script, BodiesHaveTheGivenState) {
  Demo demo = load(
      "b = box{ at = {1, 2}, size = {2, 1}, angle = 0.5, velocity = {3, 4}, omega = 5, mass = 6 }\n"
      "print(b.x, b.y, b.angle, b.vx, b.vy, b.omega, b.mass)");
  const World& world = demo.world();
  const BodyId body = world.body_id(0);
  EXPECT_EQ(world.position(body), (Vec2{1, 2}));
  EXPECT_EQ(world.angle(body), 0.5);
  EXPECT_EQ(world.velocity(body), (Vec2{3, 4}));
  EXPECT_EQ(world.omega(body), 5);
  EXPECT_EQ(world.mass(body), 6);
  EXPECT_NEAR(world.inertia(body), 6 * (4 + 1) / 12.0, 1e-12);
}

TEST_F(Script, InertiaIsThatOfTheShapeUnlessItIsGiven) {
  load(
      "local b = disc{ radius = 2, mass = 3, inertia = 12 }\nassert(b.inertia == 12 and b.mass == 3)\n"
      "b.inertia = 5 assert(b.inertia == 5 and b.mass == 3)\n"
      "b.gravity_scale = -0.5 assert(b.gravity_scale == -0.5) b.gravity_scale = 1\n"
      "b.mass = 4 assert(math.abs(b.inertia - 8) < 1e-14)\n"
      "local d = disc{ at = {9, 0}, radius = 2, density = 2 } local m = d.mass d.inertia = 7\n"
      "assert(d.inertia == 7 and d.mass == m)\n"
      "local s = disc{ at = {0, 9}, radius = 1, mass = 1, inertia = 3, type = 'static' }\n"
      "s.type = 'dynamic' assert(s.inertia == 3)");
}

// What rolls down a slope without slipping: a = g sin t / (1 + I / (m r^2)).
TEST_F(Script, TheDiscWinsTheRaceAgainstTheRing) {
  for (const char* stepper : {"time_stepping", "event_driven"}) {
    const std::string path = folder_.write(
        "race.lua",
        "demo{ title = 'T', seconds = 1, friction = 1 }\nlocal t, r = 0.3, 0.2\nground{ tilt = -t }\n"
        "for k, inertia in ipairs{ 0.5, 1, 0.4 } do\n"
        "  local m = 2 * k\n"
        "  local b = disc{ at = { 9 * k * math.cos(t) + r * math.sin(t), r * math.cos(t) - 9 * k * "
        "math.sin(t) },\n"
        "    radius = r, mass = m, inertia = inertia * m * r ^ 2 }\n"
        "  expect('v', function() return b.speed end,\n"
        "    { equals = 9.81 * math.sin(t) / (1 + inertia), within = 1e-9 })\n"
        "end");
    Demo demo(path, {.stepper = stepper});
    while (demo.steps_done() < demo.total_steps()) demo.step();
    demo.finish();
    for (const Check& check : demo.checks())
      EXPECT_EQ(check.state, CheckState::Holds) << stepper << ' ' << check.value << ' ' << check.condition();
  }
}

TEST_F(Script, GroundMayMove) {
  Demo demo =
      load("ground{ y = 1, tilt = 0.1, type = 'kinematic', velocity = {0, 2}, omega = 0.3 }", {.dt = 0.1});
  demo.step();
  const World& world = demo.world();
  const BodyId ground = world.body_id(0);
  EXPECT_NEAR(world.position(ground).y, 1.2, 1e-12);
  EXPECT_NEAR(world.angle(ground), 0.13, 1e-12);
}

TEST_F(Script, ChainsSayWhatIsWrongWithTheirPoints) {
  EXPECT_EQ(error_of("chain{}"),
            "arch.lua:2: chain: points expected a list of points {{x, y}, ...}, got nothing");
  EXPECT_EQ(error_of("chain{ points = {{0, 0}, {1, 'x'}} }"),
            "arch.lua:2: chain: points[2] expected {x, y}, got a table of 2");
  EXPECT_EQ(error_of("chain{ points = {{0, 0}} }"), "arch.lua:2: chain: points expected at least 2, got 1");
  EXPECT_EQ(error_of("chain{ points = {{0, 0}, {1, 0}}, loop = true }"),
            "arch.lua:2: chain: points expected at least 3 for a loop, got 2");
  EXPECT_EQ(error_of("chain{ points = {{0, 0}, {1, 0.5}, {1, 0.5}} }"),
            "arch.lua:2: chain: points[3] repeats points[2], {1, 0.5}");
  EXPECT_EQ(
      error_of("chain{ points = {{0, 0}, {1, 0}, {1, 1}, {0, 0}}, loop = true }"),
      "arch.lua:2: chain: points[4] repeats points[1]; a loop goes on from the last to the first without "
      "that");
  EXPECT_EQ(error_of("chain{ points = {{0, 0}, {1, 0}}, loop = 1 }"),
            "arch.lua:2: chain: loop expected true or false, got the number 1");
  EXPECT_EQ(error_of("chain{ points = {{0, 0}, {1, 0}}, type = 'dynamic' }"),
            "arch.lua:2: chain: no type \"dynamic\"; there are static, kinematic");
  EXPECT_EQ(error_of("chain{ points = {{0, 0}, {1, 0}}, velocity = {1, 0} }"),
            "arch.lua:2: chain: what is static has no velocity and no omega; try type = \"kinematic\"");
  EXPECT_EQ(error_of("chain{ ponits = {{0, 0}, {1, 0}} }"),
            "arch.lua:2: chain: no argument \"ponits\"; did you mean \"points\"?");
  EXPECT_THAT(error_of("chain{ points = {{0, 0}, {1e13, 0}} }"), HasSubstr("within 1e12 m, got (1"));
}

// Three discs fall on a track from left to right, from right to left and between the two of a closed one.
TEST_F(Script, ChainsAreSolidOnTheRightOfTheWay) {
  const std::string path = folder_.write(
      "chain.lua",
      "demo{ title = 'T', seconds = 2 }\n"
      "chain{ points = {{-1, 0}, {1, 0}} }\nchain{ points = {{1, 0}, {-1, 0}}, at = {4, 0} }\n"
      "chain{ points = {{-1, 0}, {1, 0}, {1, 2}, {-1, 2}}, loop = true, at = {8, 0} }\n"
      "chain{ points = {{-1, 0}, {-1, 2}, {1, 2}, {1, 0}}, loop = true, at = {12, 0} }\n"
      "local b = {} for k, y in ipairs{ 1, 1, 1, 3 } do b[k] = disc{ at = {4 * k - 4, y}, radius = 0.5 } "
      "end\n"
      "expect('carries', function() return b[1].y end, { equals = 0.5, within = 1e-6, at = 1 })\n"
      "expect('lets pass', function() return b[2].y end, { below = -10 })\n"
      "expect('holds', function() return b[3].y end, { equals = 0.5, within = 1e-6 })\n"
      "expect('keeps out', function() return b[4].y end, { equals = 2.5, within = 1e-6 })");
  Demo demo(path, {});
  while (demo.steps_done() < demo.total_steps()) demo.step();
  demo.finish();
  for (const Check& check : demo.checks())
    EXPECT_EQ(check.state, CheckState::Holds) << check.what << ' ' << check.value;
}

TEST_F(Script, ChainsMoveAsTheyAreTold) {
  Demo demo = load(
      "local a = chain{ points = {{0, 0}, {1, 0}}, at = {1, 2}, angle = 0.1, type = 'kinematic', omega = "
      "0.3, "
      "velocity = {0, 2}, friction = 0.7, surface_speed = 1 }\n"
      "local b = chain{ points = {{0, 0}, {1, 0}}, type = 'kinematic' }\n"
      "move(b, function(t) return 3 * t, 1 end)\n"
      "assert(a.friction == 0.7 and a.surface_speed == 1 and a.x == 1 and a.y == 2 and a.name == 'chain')",
      {.dt = 0.1});
  demo.step();
  const World& world = demo.world();
  EXPECT_NEAR(world.position(world.body_id(0)).y, 2.2, 1e-12);
  EXPECT_NEAR(world.angle(world.body_id(0)), 0.13, 1e-12);
  EXPECT_NEAR(world.position(world.body_id(1)).x, 0.3, 1e-12);
}

TEST_F(Script, ForceOffCentreGivesBothAccelerations) {
  // F = 3 N upwards at arm 0.5 m: a = F/m, alpha = r F / I with I = m r^2 / 2.
  Demo demo = load("local b = disc{ radius = 1, mass = 2 }\nb:force(0, 3, {0.5, 0})", {.dt = 0.01});
  demo.step();
  const BodyId body = demo.world().body_id(0);
  EXPECT_NEAR(demo.world().velocity(body).y, 3.0 / 2 * 0.01, 1e-15);
  EXPECT_NEAR(demo.world().omega(body), 0.5 * 3 / 1.0 * 0.01, 1e-15);
}

TEST_F(Script, AccelerationsAreMeansOfTheLastStep) {
  // F = 3 N at 0.5 m from the centre; what is set or struck between steps is no acceleration.
  Demo demo = load(
      "local b = disc{ radius = 1, mass = 2 }\nlocal still = disc{ at = {9, 0}, radius = 1, type = 'static' "
      "}\n"
      "local seen local function look() return math.abs(b.ax) < 1e-12 and math.abs(b.ay - 1.5) < 1e-12 "
      "and math.abs(b.alpha - 1.5) < 1e-12 end\n"
      "assert(b.ax == 0 and b.ay == 0 and b.alpha == 0)\n"
      "on_step(function() b:force(0, 3, {b.x + 0.5, b.y}) end)\n"
      "field(function() seen = b.ay return 0, 0 end)\n"
      "at(0.2, function() assert(look()) b.vx = 7 b:impulse(0, 5) b.omega = 3 assert(look()) end)\n"
      "expect('as the force', function() return look() and math.abs(seen - 1.5) < 1e-12 and 1 or 0 end, "
      "{ equals = 1, within = 0 })\n"
      "expect('none', function() return still.ay end, { equals = 0, within = 0 })\n"
      "local c expect('new', function() c = c or disc{ at = {0, 50}, radius = 1, velocity = {3, 0} } return "
      "c.ax "
      "end, { equals = 0, within = 0, at = 0.6 })",
      {.dt = 0.1});
  while (demo.steps_done() < demo.total_steps()) demo.step();
  demo.finish();
  for (const Check& check : demo.checks())
    EXPECT_EQ(check.state, CheckState::Holds) << check.what << ' ' << check.value;
  EXPECT_EQ(error_of("local b = disc{ radius = 1 }\nb.ax = 1"),
            "arch.lua:3: body: \"ax\" cannot be set; these can: type, color, group, category, ignores, x, y, "
            "angle, "
            "vx, vy, omega, friction, "
            "static_friction, restitution, rolling_resistance, surface_speed, mass, inertia, gravity_scale");
}

TEST_F(Script, ColoursChangeWithTheStateAndEndWithTheBody) {
  Demo demo = load(
      "b = disc{ radius = 1, color = 'orange' }\nassert(b.color == 'orange')\n"
      "at(0.1, function() b.color = 'sky' assert(b.color == 'sky') end)\n"
      "at(0.2, function() b.color = nil assert(b.color == nil) end)\n"
      "at(0.3, function() b.color = 'green' b:remove() c = disc{ radius = 1 } assert(c.color == nil) end)",
      {.dt = 0.1});
  const auto color = [&] { return demo.picture().colors.of(demo.world().body_id(0)); };
  demo.step();
  EXPECT_EQ(color(), 1);
  demo.step();
  EXPECT_EQ(color(), 0);
  const DemoState state = demo.save();
  demo.step();
  EXPECT_EQ(color(), -1);
  demo.step();
  EXPECT_EQ(color(), -1) << "of what took the place of the removed body";
  demo.restore(state);
  EXPECT_EQ(color(), 0);
  EXPECT_EQ(error_of("local b = disc{ radius = 1 }\nb.color = 'red'"),
            "arch.lua:3: body: no color \"red\"; did you mean \"grey\"?");
  EXPECT_EQ(error_of("local b = disc{ radius = 1 }\nb:remove() b.color = 'sky'"),
            "arch.lua:3: body: \"color\" of a body that was removed");
}

TEST_F(Script, AccelerationsCountImpactsAndAreKeptWithTheState) {
  // Falls on the ground within a step: the velocity goes from -2 to 0 m/s.
  Demo demo = load(
      "ground{ y = 0 }\nlocal b = disc{ at = {0, 1.1}, radius = 1, velocity = {0, -2} }\n"
      "watch('a', function() return b.ay end)",
      {.dt = 0.1});
  demo.step();
  EXPECT_NEAR(demo.watch_values().front(), 20, 1e-9);
  const DemoState state = demo.save();
  demo.step();
  EXPECT_NEAR(demo.watch_values().front(), 0, 1e-9);
  demo.restore(state);
  EXPECT_NEAR(demo.watch_values().front(), 20, 1e-9);
}

TEST_F(Script, CallbacksComeAtTheirTimes) {
  std::string text;
  DemoOptions options{.dt = 0.25};
  options.print = [&](std::string_view line) { text += std::string(line) + ';'; };
  Demo demo =
      load("at(0.5, function() print('at', time()) end)\non_step(function(t, h) print(t, h) end)", options);
  for (int i = 0; i < 4; ++i) demo.step();
  EXPECT_EQ(text, "0.0\t0.25;0.25\t0.25;at\t0.5;0.5\t0.25;0.75\t0.25;");
}

TEST_F(Script, ChecksAreJudgedAtTheirTimes) {
  Demo demo = load(
      "local b = disc{ radius = 1, velocity = {1, 0} }\n"
      "expect('early', function() return b.x end, { at = 0.5, equals = 0.5, within = 1e-12 })\n"
      "expect('end', function() return b.x end, { above = 0.9, below = 1.1 })\n"
      "expect('wrong', function() return b.x end, { at = 1, below = 0.5, unit = 'm' })\n"
      "expect('always', function() return b.x end, { always = true, below = 0.7 })\n"
      "expect('nan', function() return 0 / 0 end, { above = 0 })",
      {.dt = 0.1, .seconds = 1.0});
  while (demo.steps_done() < demo.total_steps()) demo.step();
  demo.finish();
  const std::vector<Check>& checks = demo.checks();
  EXPECT_EQ(checks[0].state, CheckState::Holds);
  EXPECT_EQ(checks[1].state, CheckState::Holds);
  EXPECT_EQ(checks[2].state, CheckState::Fails);
  EXPECT_EQ(checks[2].condition(), "below 0.5 m");
  EXPECT_THAT(checks[2].place, EndsWith("arch.lua:5"));
  EXPECT_EQ(checks[3].state, CheckState::Fails);
  EXPECT_NEAR(checks[3].time, 0.7, 0.11);
  EXPECT_EQ(checks[4].state, CheckState::Fails);
  EXPECT_TRUE(demo.failed());
}

TEST_F(Script, ARunThatIsCutShortReachesNeitherTheEndNorLaterTimes) {
  Demo demo = load(
      "expect('late', function() return 1 end, { at = 0.9, below = 0 })\n"
      "expect('end', function() return 1 end, { below = 0 })",
      {.dt = 0.1, .seconds = 0.5});
  while (demo.steps_done() < demo.total_steps()) demo.step();
  demo.finish();
  EXPECT_EQ(demo.checks()[0].state, CheckState::Waiting);
  EXPECT_EQ(demo.checks()[1].state, CheckState::Waiting);
  EXPECT_FALSE(demo.failed());
  EXPECT_THAT(error_of("expect('x', function() return 1 end, { at = 1.5, below = 0 })"),
              HasSubstr("at = 1.5 s is after the end, 1 s"));
}

TEST_F(Script, ParametersTakeValuesFromOutside) {
  DemoOptions options;
  options.parameters = {{"mass ratio", "10"}, {"law", "poisson"}};
  Demo demo = load(
      "local m = param('mass ratio', 1000, 1, 1e6)\nlocal law = choice('law', {'reflections', 'poisson'})\n"
      "disc{ radius = 1, mass = m }\nassert(law == 'poisson')",
      options);
  EXPECT_EQ(demo.world().mass(demo.world().body_id(0)), 10);
  EXPECT_EQ(demo.parameters()[1].text(), "poisson");
  for (const char* wrong : {"0.5", "1e7", "abc", "", "nan", "10x"}) {
    options.parameters = {{"mass ratio", wrong}};
    EXPECT_THROW(load("param('mass ratio', 1000, 1, 1e6)", options), UsageError) << wrong;
  }
  options.parameters = {{"mas ratio", "10"}};
  EXPECT_THROW(load("param('mass ratio', 1000, 1, 1e6)", options), UsageError);
}

TEST_F(Script, SameSeedGivesTheSameBits) {
  const std::string source =
      "for i = 1, 20 do disc{ at = {3 * i, 0}, radius = 0.1 + math.random(), "
      "velocity = {math.random(), math.sin(i)} } end";
  const auto hash = [&](std::uint64_t seed) {
    Demo demo = load(source, {.seed = seed});
    for (int i = 0; i < 10; ++i) demo.step();
    return demo.world().state_hash();
  };
  EXPECT_EQ(hash(1), hash(1));
  EXPECT_NE(hash(1), hash(2));
}

TEST_F(Script, ContactSensorReadsTheWeightOfABox) {
  const std::string path =
      folder_.write("w.lua",
                    "demo{ title = 'T', seconds = 0.2 }\nlocal g = ground{ y = 0 }\n"
                    "local b = box{ at = {0, 0.5}, size = {1, 1}, mass = 2 }\n"
                    "local c = contact(b, g)\n"
                    "expect('weight', function() return c.force end, { equals = 2 * 9.81, within = 1e-9 })\n"
                    "expect('points', function() return c.points end, { equals = 2, within = 0 })");
  Demo demo(path, {.seconds = 0.2});
  while (demo.steps_done() < demo.total_steps()) demo.step();
  demo.finish();
  EXPECT_FALSE(demo.failed()) << demo.checks()[0].value;
}

// What hands that press a book from both sides carry is friction of opposite signs, and a force upwards.
TEST_F(Script, ContactSensorAddsUpTheForceOnItsFirstBody) {
  const std::string path = folder_.write(
      "book.lua",
      "demo{ title = 'T', seconds = 0.2, friction = 0.5 }\n"
      "local book = box{ at = {0, 1}, size = {0.2, 0.3}, mass = 2 }\n"
      "local left = box{ at = {-0.15, 1}, size = {0.1, 0.1}, mass = 1, gravity_scale = 0 }\n"
      "local right = box{ at = {0.15, 1}, size = {0.1, 0.1}, mass = 1, gravity_scale = 0 }\n"
      "slider{ a = left, axis = {1, 0} }\nslider{ a = right, axis = {1, 0} }\n"
      "on_step(function() left:force(50, 0) right:force(-50, 0) end)\n"
      "local both, one, back = contact(book), contact(book, left), contact(left, book)\n"
      "expect('pressed', function() return both.force end, { equals = 100, within = 1e-6 })\n"
      "expect('up', function() return both.fy end, { equals = 2 * 9.81, within = 1e-6 })\n"
      "expect('across', function() return both.fx end, { equals = 0, within = 1e-6 })\n"
      "expect('right', function() return one.fx end, { equals = 50, within = 1e-6 })\n"
      "expect('half', function() return one.fy end, { equals = 9.81, within = 1e-6 })\n"
      "expect('down', function() return back.fy end, { equals = -9.81, within = 1e-6 })\n"
      "expect('friction', function() return one.friction end, { equals = 9.81, within = 1e-6 })\n"
      "expect('and back', function() return back.friction end, { equals = 9.81, within = 1e-6 })");
  Demo demo(path, {});
  while (demo.steps_done() < demo.total_steps()) demo.step();
  demo.finish();
  for (const Check& check : demo.checks())
    EXPECT_EQ(check.state, CheckState::Holds) << check.what << ' ' << check.value;
}

TEST_F(Script, WhatIsOfAllBodiesTakesNone) {
  for (const std::string name : {"energy", "kinetic_energy", "momentum", "angular_momentum", "penetration"}) {
    EXPECT_EQ(error_of("local b = disc{ radius = 1 }\nprint(" + name + "(b))"),
              "arch.lua:3: " + name + ": is of all bodies and takes nothing, got a body");
  }
}

TEST_F(Script, JointsPullWithTheWeightTheyCarry) {
  const std::string path = folder_.write(
      "j.lua",
      "demo{ title = 'T', seconds = 0.6 }\nlocal b = disc{ at = {0, -2}, radius = 0.5, mass = 3 }\n"
      "local r = rod{ from = {0, 0}, to = b }\n"
      "expect('length', function() return r.length end, { at = 0.2, equals = 2, within = 0 })\n"
      "expect('pull', function() return r.fy end, { at = 0.2, equals = 3 * 9.81, within = 1e-9 })\n"
      "at(0.3, function() r:remove() end)\n"
      "expect('gone', function() return r.alive and 1 or 0 end, { at = 0.5, equals = 0, within = 0 })");
  Demo demo(path, {});
  while (demo.steps_done() < demo.total_steps()) demo.step();
  demo.finish();
  EXPECT_EQ(demo.checks()[0].state, CheckState::Holds);
  EXPECT_EQ(demo.checks()[1].state, CheckState::Holds) << demo.checks()[1].value;
  EXPECT_EQ(demo.checks()[2].state, CheckState::Holds);
}

// A ball falls through a gate 1 m below it, within a step.
TEST_F(Script, ActionsOfEventsSeeTheirMoment) {
  for (const char* stepper : {"event_driven", "time_stepping"}) {
    const std::string path = folder_.write(
        "gate.lua",
        "demo{ title = 'T', seconds = 0.5, stepper = '" + std::string(stepper) +
            "' }\nlocal b = disc{ at = {0, 0}, radius = 0.1, mass = 2 }\n"
            "local seen, late, passed = {}, {}\n"
            "on_event(function() return b.y + 1 end, function(t)\n"
            "  passed = t\n"
            "  seen = { y = b.y, vy = b.vy, speed = b.speed, work = b.kinetic_energy, t = time(),\n"
            "           point = select(2, b:point(0, 0)) }\n"
            "  b:force(0, 0)\n"
            "  late = { y = b.y, vy = b.vy, t = time() }\n"
            "end)\n"
            "local other\n"
            "on_event(function() return b.y + 1 end, function(t) other = b.y end)\n"
            "local fall, v = math.sqrt(2 / 9.81), math.sqrt(2 * 9.81)\n"
            "local function is(what, f, value)\n"
            "  expect(what, f, { equals = value, within = 1e-9 })\n"
            "end\n"
            "is('t', function() return passed end, fall)\n"
            "is('time()', function() return seen.t - passed end, 0)\n"
            "is('y', function() return seen.y end, -1)\n"
            "is('vy', function() return seen.vy end, -v)\n"
            "is('speed', function() return seen.speed end, v)\n"
            "is('energy', function() return seen.work end, 2 * 9.81)\n"
            "is('point', function() return seen.point end, -1)\n"
            // After a change: as they are, at the end of the step.
            "is('late time()', function() return late.t end, 28 / 60)\n"
            "is('late y', function() return late.y end, -9.81 * (28 / 60) ^ 2 / 2)\n"
            "is('late vy', function() return late.vy end, -9.81 * 28 / 60)\n"
            // Each action begins at its moment.
            "is('another one', function() return other end, -1)\n");
    Demo demo(path, {});
    while (demo.steps_done() < demo.total_steps()) demo.step();
    demo.finish();
    for (const Check& check : demo.checks())
      EXPECT_EQ(check.state, CheckState::Holds) << stepper << ' ' << check.what << ' ' << check.value;
  }
}

TEST_F(Script, ReadsAfterAWriteInAnActionAreOfTheWorldAsItIs) {
  const std::string path = folder_.write(
      "write.lua",
      "demo{ title = 'T', seconds = 0.5, gravity = {0, 0} }\n"
      "local b = disc{ at = {0, 0}, radius = 0.1, mass = 2, velocity = {3, 0} }\n"
      "local x, vx, events\n"
      "on_event(function() return b.x - 1 end, function(t) b.x = 5 x = b.x b.vx = 7 vx = b.vx end)\n"
      "on_event(function() return b.x - 1 end, function(t)\n"
      "  on_event(function() return 1 end, function() end) events = b.x end)\n"
      "expect('x', function() return x end, { equals = 5, within = 0 })\n"
      "expect('vx', function() return vx end, { equals = 7, within = 0 })\n"
      "expect('another event changes nothing', function() return events end, { equals = 1, within = 1e-9 "
      "})\n");
  Demo demo(path, {});
  while (demo.steps_done() < demo.total_steps()) demo.step();
  demo.finish();
  for (const Check& check : demo.checks())
    EXPECT_EQ(check.state, CheckState::Holds) << check.what << ' ' << check.value;
}

TEST_F(Script, ChecksMeasureBodiesAtTheirMoment) {
  for (const double dt : {1.0 / 60, 0.03, 0.007}) {
    const std::string path = folder_.write("moment.lua",
                                           "demo{ title = 'T', seconds = 1.5 }\n"
                                           "local b = disc{ at = {0, 0}, radius = 0.1, mass = 1 }\n"
                                           "local made\nlocal touch = contact(b)\n"
                                           "local function is(what, at, f, value)\n"
                                           "  expect(what, f, { at = at, equals = value, within = 1e-9 })\n"
                                           "end\n"
                                           "local function y() return b.y end\n"
                                           "for _, t in ipairs{0, 0.001, 0.3, 0.5, 1.234, 1.5} do\n"
                                           "  is('y', t, y, -9.81 * t ^ 2 / 2)\n"
                                           "  is('vy', t, function() return b.vy end, -9.81 * t)\n"
                                           "  is('time', t, time, t)\n"
                                           "end\n"
                                           "is('no contact', 0.3, function() return touch.points end, 0)\n"
                                           "at(1.3, function() made = time() is('late', 0.2, time, made + " +
                                               std::to_string(dt) + ") end)\n");
    DemoOptions options;
    options.dt = dt;
    Demo demo(path, options);
    while (demo.steps_done() < demo.total_steps()) demo.step();
    demo.finish();
    for (const Check& check : demo.checks()) {
      const bool late = check.what == "late";
      EXPECT_TRUE(late ? std::abs(check.value - check.time) < 1e-9 : check.state == CheckState::Holds)
          << dt << ' ' << check.what << ' ' << check.value;
      if (!late) {
        EXPECT_NEAR(check.time, *check.at, 1e-12);
      }
    }
    EXPECT_EQ(demo.checks().size(), 20u);
  }
}

}  // namespace script_test
}  // namespace skerry::sandbox
