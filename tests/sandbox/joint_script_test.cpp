// SPDX-License-Identifier: MIT
//
// Script functions of joints and forces: what they build, and what they say when they are used wrongly.
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sandbox/demo.h"
#include "sandbox/errors.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace joint_script_test {

using testing::HasSubstr;

constexpr const char* kHead = "demo{ title = 'T', seconds = 1, gravity = {0, -10}, friction = 0 }\n";
constexpr const char* kBodies =
    "local a = box{ at = {1, 0}, size = {1, 1}, mass = 2 } local b = disc{ at = {3, 0}, radius = 0.5 }\n";

class JointScript : public testing::Test {
 protected:
  Demo load(const std::string& body) {
    return Demo(folder_.write("arch.lua", std::string(kHead) + kBodies + body), {});
  }
  // The message of loading or of the first steps, from "arch.lua:" on.
  std::string error_of(const std::string& body) {
    try {
      Demo demo = load(body);
      for (int i = 0; i < 3; ++i) demo.step();
    } catch (const ScriptError& error) {
      const std::string text = error.what();
      const std::size_t at = text.find("arch.lua");
      return at == std::string::npos ? text : text.substr(at);
    }
    return "no error";
  }
  // Runs to the end: every `expect` must hold.
  void expect_good(const std::string& body) {
    Demo demo = load(body);
    while (demo.steps_done() < demo.total_steps()) demo.step();
    demo.finish();
    EXPECT_FALSE(demo.failed()) << body;
  }
  TemporaryFolder folder_;
};

TEST_F(JointScript, SaysWhatIsWrongWithAJointAndWhere) {
  EXPECT_EQ(error_of("slider{ a = a }"), "arch.lua:3: slider: axis expected {x, y}, got nothing");
  EXPECT_EQ(error_of("slider{ a = a, axis = {0, 0} }"), "arch.lua:3: slider: axis must not be {0, 0}");
  EXPECT_EQ(error_of("weld{ at = {0, 0} }"), "arch.lua:3: weld: a expected a body, got nothing");
  EXPECT_EQ(error_of("hinge{ a = a, at = {0, 0}, limits = {1, -1} }"),
            "arch.lua:3: hinge: limits expected {lower, upper}, got {1, -1}");
  EXPECT_EQ(error_of("hinge{ a = a, at = {0, 0}, motor_limit = 3 }"),
            "arch.lua:3: hinge: motor_limit needs a speed");
  EXPECT_EQ(error_of("gear{ a = a, b = b }"), "arch.lua:3: gear: ratio expected a number, got nothing");
  EXPECT_EQ(error_of("gear{ a = a, ratio = 2 }"), "arch.lua:3: gear: b expected a body, got nothing");
  EXPECT_THAT(error_of("gear{ a = a, b = b, ratio = 0 }"),
              HasSubstr("arch.lua:3: joint: ratio must not be 0"));
  EXPECT_EQ(error_of("pulley{ from = a, to = b, over = {{0, 1}} }"),
            "arch.lua:3: pulley: over expected {{x, y}, {x, y}}, got 1 points");
  EXPECT_EQ(error_of("pulley{ from = {0, 0}, to = b, over = {{0, 1}, {1, 1}} }"),
            "arch.lua:3: pulley: from and to expected ends on bodies");
  EXPECT_THAT(error_of("spring{ from = {0, 0}, to = a }"),
              HasSubstr("stiffness or damping must be positive"));
  EXPECT_THAT(error_of("spring{ from = {0, 0}, to = a, stiffness = -1 }"),
              HasSubstr("spring: stiffness must be at least 0, got -1"));
  EXPECT_THAT(error_of("weld{ a = a, at = {0, 0}, limits = {0, 1} }"),
              HasSubstr("a weld joint has no limits"));
  EXPECT_THAT(error_of("motor{ a = a }"), HasSubstr("motor: speed expected a number, got nothing"));
  EXPECT_THAT(error_of("wheel{ a = a, b = b, stifness = 3 }"), HasSubstr("did you mean \"stiffness\"?"));
  EXPECT_THAT(error_of("local w = weld{ a = a, at = {1, 0} } w:remove() print(w.force)"),
              HasSubstr("\"force\" of a joint that was removed or broke"));
}

TEST_F(JointScript, SaysWhatIsWrongWithAForceAndWhere) {
  EXPECT_EQ(error_of("field(3)"), "arch.lua:3: field: force expected a function, got the number 3");
  EXPECT_EQ(error_of("\nfield(function() return 1 end)"),
            "arch.lua:4: field: fy returned expected a finite number, got nothing");
  EXPECT_THAT(error_of("field(function() return 0 / 0, 0 end)"),
              HasSubstr("fx returned expected a finite number"));
  EXPECT_THAT(error_of("field(function() return nonsense.x, 0 end)"), HasSubstr("arch.lua:3: "));
  EXPECT_EQ(error_of("drag(3, {})"), "arch.lua:3: drag: first expected a body, got the number 3");
  EXPECT_THAT(error_of("drag(a, { linear = -1 })"), HasSubstr("linear must be at least 0, got -1"));
  EXPECT_THAT(error_of("move(a, function(t) return t, 0 end)"), HasSubstr("must be kinematic"));
  EXPECT_THAT(error_of("box{ size = {1, 1}, friction = 0.5, static_friction = 0.4 }"),
              HasSubstr("static_friction must be at least friction, got 0.4 and 0.5"));
}

TEST_F(JointScript, JointsDoWhatTheySay) {
  expect_good(
      "local s = slider{ a = a, axis = {1, 0}, speed = 2 }\n"
      "expect('way', function() return a.x - 1 end, { equals = 2, within = 0.05 })\n"
      "expect('speed', function() return s.speed end, { equals = 2, within = 1e-9 })\n"
      "expect('load', function() return s.fy end, { equals = 20, within = 1e-6 })");
  expect_good(
      "local w = weld{ a = a, at = {0, 0} }\n"
      "expect('moment', function() return w.torque end, { equals = 20, within = 1e-6 })");
  expect_good(
      "local w = weld{ a = a, at = {0, 0}, break_force = 19 }\n"
      "expect('broken', function() return w.alive and 1 or 0 end, { equals = 0, within = 0 })");
  expect_good(
      "hinge{ a = a, at = {1, 0} } hinge{ a = b, at = {3, 0} } gear{ a = a, b = b, ratio = 2 }\n"
      "on_step(function() a:torque(1) end)\n"
      "expect('ratio', function() return b.angle + 2 * a.angle end, { equals = 0, within = 1e-12 })");
}

TEST_F(JointScript, SurfacesAndJointsChangeWhileItRuns) {
  expect_good(
      "local floor = ground{ y = -0.5, friction = 0.4 } a.vx = -5\n"
      "at(0.5, function() a.friction = 0.4 end)\n"
      "expect('speed', function() return a.vx end, { equals = -3, within = 1e-9 })\n"
      "expect('read', function() return a.friction + a.static_friction end, { equals = 0.8, within = 1e-15 "
      "})");
  expect_good(
      "local floor = ground{ y = -0.5, friction = 0.4 } a.friction = 0.4\n"
      "at(0.5, function() floor.surface_speed = -1 a.rolling_resistance = 0.01 end)\n"
      "expect('carried', function() return a.vx end, { equals = 1, within = 1e-9 })\n"
      "expect('read', function() return floor.surface_speed + a.rolling_resistance end, { equals = -0.99, "
      "within = 1e-15 })");
  expect_good(
      "local r = rope{ from = {1, 2}, to = a } at(0.5, function() r.length = 2.5 end)\n"
      "expect('hangs', function() return a.y end, { equals = -0.5, within = 1e-6 })\n"
      "expect('read', function() return r.length end, { equals = 2.5, within = 0 })");
  expect_good(
      "local h = hinge{ a = a, at = {0, 0}, limits = {0, 1} }\n"
      "at(0.5, function() h.lower = nil h.upper = 0.5 end)\n"
      "expect('turned', function() return h.position end, { below = -0.1 })\n"
      "expect('read', function() return h.lower == nil and h.upper or 0 end, { equals = 0.5, within = 0 })");
  expect_good(
      "local w = weld{ a = a, at = {0, 0} } at(0.5, function() w.break_force = 19 end)\n"
      "expect('broken', function() return w.alive and 1 or 0 end, { equals = 0, within = 0 })");
  expect_good(
      "local s = slider{ a = a, axis = {1, 0}, speed = 2, motor_limit = 0 }\n"
      "at(0.5, function() s.motor_limit = 4 s.break_torque = 1000 end)\n"
      "expect('speed', function() return s.speed end, { equals = 1, within = 1e-9 })\n"
      "expect('read', function() return s.motor_limit + s.break_torque end, { equals = 1004, within = 0 })");
  expect_good(
      "gravity(0, 0) local s = spring{ from = {0, 0}, to = a, stiffness = 1 } at(0.5, function()\n"
      "s.stiffness = 8 s.damping = 8 s.length = 0.5 end)\n"
      "expect('pulled', function() return a.vx end, { below = -0.1 })\n"
      "expect('read', function() return s.stiffness + s.damping end, { equals = 16, within = 0 })");
  expect_good(
      "gravity(0, 0) a.vx = 1 at(0.5, function() a.type = 'static' end)\n"
      "expect('stopped', function() return a.vx end, { equals = 0, within = 0 })\n"
      "expect('read', function() return a.type == 'static' and a.mass or 1 end, { equals = 0, within = 0 })");
  expect_good(
      "a.type = 'kinematic' a.vy = 1 a.mass = 3 at(0.5, function() a.type = 'dynamic' end)\n"
      "expect('falls', function() return a.vy end, { below = -1 })\n"
      "expect('read', function() return a.mass end, { equals = 3, within = 0 })");
  EXPECT_THAT(error_of("a.type = 'statik'"), HasSubstr("body: no type \"statik\"; did you mean \"static\"?"));
  EXPECT_THAT(error_of("a.type = 3"), HasSubstr("type expected"));
  EXPECT_THAT(error_of("a.mass = 0"), HasSubstr("mass must be positive, got 0"));
  EXPECT_THAT(error_of("local g = ground{} g.type = 'dynamic'"), HasSubstr("cannot be dynamic"));
  EXPECT_EQ(
      error_of("local h = hinge{ a = a, at = {0, 0} }\nh.speed = 3"),
      "arch.lua:4: joint: \"speed\" cannot be set; these can: length, lower, upper, stiffness, damping, "
      "motor_limit, break_force, break_torque");
  EXPECT_EQ(error_of("local h = hinge{ a = a, at = {0, 0} } h.lower = 'low'"),
            "arch.lua:3: joint: lower expected a finite number, got the string \"low\"");
  EXPECT_THAT(error_of("local h = hinge{ a = a, at = {0, 0} } h.stiffness = nil"),
              HasSubstr("joint: stiffness expected a finite number"));
  EXPECT_THAT(error_of("local h = hinge{ a = a, at = {0, 0} } h:remove() h.lower = 1"),
              HasSubstr("\"lower\" of a joint that was removed or broke"));
  EXPECT_THAT(error_of("a.restitution = 2"), HasSubstr("restitution must be between 0 and 1, got 2"));
  EXPECT_THAT(error_of("a.friction = -1"), HasSubstr("friction must be finite and >= 0, got -1"));
}

TEST_F(JointScript, ForcesActAndEventsAreTold) {
  expect_good(
      "gravity(0, 0) field(function(x, y, vx, vy, m, t) return m * 3, 0 end)\n"
      "expect('way', function() return a.x - 1 end, { equals = 1.5, within = 1e-9 })");
  expect_good(
      "gravity(0, 0) a.vx = 2 drag(a, { linear = 4 })\n"
      "expect('speed', function() return a.vx end, { equals = 2 * math.exp(-2), within = 1e-3 })");
  expect_good(
      "local lift = box{ at = {9, 9}, size = {1, 1}, type = 'kinematic' }\n"
      "move(lift, function(t) return 5, 2 * t, t end)\n"
      "expect('place', function() return lift.y + lift.angle end, { equals = 3, within = 1e-12 })");
  expect_good(
      "local when = 0\n"
      "on_event(function() return a.y + 1 end, function(t) when = t end)\n"
      "expect('crossing', function() return when end, { equals = math.sqrt(0.2), within = 1e-12 })");
  // time() follows, too; actions come in the order of time.
  expect_good(
      "local order, off = '', 0\n"
      "on_event(function() return time() - 0.342 end, function(t) order = order .. 'b' off = off + t - 0.342 "
      "end)\n"
      "on_event(function() return time() - 0.341 end, function(t) order = order .. 'a' off = off + t - 0.341 "
      "end)\n"
      "expect('order', function() return order == 'ab' and 1 or 0 end, { equals = 1, within = 0 })\n"
      "expect('times', function() return off end, { equals = 0, within = 1e-12 })");
  // Energies are known at the ends of steps only: a straight line between them.
  expect_good(
      "gravity(0, 0) local when = 0 a.vx = -1 on_step(function() a:force(-2, 0) end)\n"
      "on_event(function() return kinetic_energy() - 1.5 end, function(t) when = t end)\n"
      "expect('crossing', function() return when end, { equals = math.sqrt(1.5) - 1, within = 1e-4 })");
}

}  // namespace joint_script_test
}  // namespace skerry::sandbox
