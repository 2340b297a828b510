// SPDX-License-Identifier: MIT
//
// Bodies of several shapes.
#include <cmath>
#include <gmock/gmock.h>

#include "tests/sandbox/script_fixture.h"

namespace skerry::sandbox {
namespace compound_script_test {

using testing::ElementsAre;
using testing::IsEmpty;

class CompoundScript : public ScriptFixture {};

// A hammer: the handle has 2 kg and its middle at 0, the head 6 kg at 1 m.
constexpr const char* kHammer =
    "local h = compound{ at = {3, 4}, angle = math.pi / 2, velocity = {1, 2}, omega = 5, MORE\n"
    "  { shape = 'box', size = {2, 0.1}, density = 10 },\n"
    "  { shape = 'box', size = {0.3, 0.4}, at = {1, 0}, angle = 0.7, density = 50 } }\n";

std::string hammer(const std::string& more = "") {
  std::string text = kHammer;
  return text.replace(text.find("MORE"), 4, more);
}

// The origin of the parts' frame is at `at`; x, y and the velocity are those of the centre of mass.
TEST_F(CompoundScript, MassCentreAndInertiaAreThoseOfTheParts) {
  const double handle = 2, head = 6, centre = head / (handle + head);
  const double inertia = handle * (4 + 0.01) / 12 + head * (0.09 + 0.16) / 12 + handle * centre * centre +
                         head * (1 - centre) * (1 - centre);
  for (const double mass : {0.0, 4.0}) {
    const Demo demo = load(hammer(mass > 0 ? "mass = 4," : ""));
    const World& world = demo.world();
    const BodyId body = world.body_id(0);
    const double share = mass > 0 ? mass / 8 : 1;
    EXPECT_NEAR(world.mass(body), 8 * share, 1e-12);
    EXPECT_NEAR(world.inertia(body), inertia * share, 1e-12);
    EXPECT_NEAR(world.position(body).x, 3, 1e-12);
    EXPECT_NEAR(world.position(body).y, 4 + centre, 1e-12);
    EXPECT_EQ(world.velocity(body), (Vec2{1, 2}));
    EXPECT_EQ(world.omega(body), 5);
  }
}

TEST_F(CompoundScript, PartsLieWhereTheySay) {
  EXPECT_THAT(
      lines_of(
          "local b = compound{ at = {10, 0}, angle = math.pi / 2, type = 'static', name = 'b',\n"
          "  { shape = 'disc', radius = 0.5, at = {2, 0} },\n"
          "  { shape = 'box', size = {4, 0.2}, at = {0, 3}, angle = math.pi / 2 },\n"
          "  { shape = 'capsule', from = {0, -1}, to = {0, 1}, radius = 0.1, at = {-3, 0}, angle = math.pi / "
          "2 "
          "},\n"
          "  { shape = 'polygon', corners = {{0, 0}, {1, 0}, {0, 1}}, at = {0, -5}, rounding = 0.1 } }\n"
          // In the world the frame's x axis goes up, its y axis to the left.
          "for _, p in ipairs{ {10, 2.4}, {10, 2.6}, {5.1, 0}, {8.9, 0}, {7, 1.9}, {10, -3.95}, {10.9, -3}, "
          "{8.8, -3},\n"
          "                    {15, 0.95}, {14.1, 0.05}, {15.2, 0} } do\n"
          "  print(#bodies_at(p[1], p[2]))\n"
          "end"),
      ElementsAre("1", "0", "1", "1", "0", "1", "0", "0", "1", "1", "0"));
}

// Two shapes at a point are one body.
TEST_F(CompoundScript, IsFoundOnce) {
  EXPECT_THAT(lines_of("local b = compound{ at = {0, 5}, { shape = 'disc', radius = 1 }, { shape = 'box', "
                       "size = {1, 1} } }\n"
                       "print(#bodies_at(0, 5), #bodies_at(0, 5.9), bodies_at(0, 5)[1] == b)"),
              ElementsAre("1\t1\ttrue"));
}

TEST_F(CompoundScript, PartsHaveTheirOwnMaterialOrThatOfTheWhole) {
  const Demo demo = load(
      "compound{ friction = 0.3, static_friction = 0.4, restitution = 0.2, surface_speed = 2, group = -4,\n"
      "  category = 'cart', ignores = {'cart'}, color = 'green',\n"
      "  { shape = 'disc', radius = 1 },\n"
      "  { shape = 'disc', radius = 1, friction = 0.7, restitution = 1, rolling_resistance = 0.01, sensor = "
      "true } "
      "}\n");
  const std::span<const ShapeRecord> shapes = demo.world().shapes();
  ASSERT_EQ(shapes.size(), 2u);
  EXPECT_EQ(shapes[0].material.friction, 0.3);
  EXPECT_EQ(shapes[0].material.static_friction, 0.4);
  EXPECT_EQ(shapes[0].material.restitution, 0.2);
  EXPECT_EQ(shapes[0].material.surface_velocity, 2);
  EXPECT_EQ(shapes[1].material.friction, 0.7);
  EXPECT_FALSE(shapes[1].material.static_friction);
  EXPECT_EQ(shapes[1].material.restitution, 1);
  EXPECT_EQ(shapes[1].material.rolling_resistance, 0.01);
  EXPECT_EQ(shapes[1].material.surface_velocity, 2);
  EXPECT_FALSE(shapes[0].sensor);
  EXPECT_TRUE(shapes[1].sensor);
  for (const ShapeRecord& shape : shapes) {
    EXPECT_EQ(shape.filter.group, -4);
    EXPECT_EQ(shape.filter.category, 2u);
    EXPECT_EQ(shape.filter.mask, ~2u);
  }
  EXPECT_EQ(demo.picture().colors.of(demo.world().body_id(0)), 2);
}

// A feeler weighs nothing, feels the floor, and is no more than a part of what pushes.
TEST_F(CompoundScript, AFeelerIsAPartThatIsASensor) {
  EXPECT_THAT(
      lines_of("gravity(0, -10)\nlocal floor = ground{ name = 'floor' }\n"
               "local b = compound{ at = {0, 1}, density = 5,\n"
               "  { shape = 'box', size = {1, 1} },\n"
               "  { shape = 'box', size = {0.8, 0.2}, at = {0, -0.6}, sensor = true } }\n"
               "print(b.mass, b.x, b.y, b.sensor)\n"
               "on_touch(b, floor, function() print(string.format('%.2f', b.y)) end)\n"
               "at(0.9, function() print(string.format('%.3f', b.y), contact(b, floor).touching) end)"),
      ElementsAre("5.0\t0.0\t1.0\tfalse", "0.69", "0.500\ttrue"));
}

// Its parts stand on two supports, and roll and slide as one.
TEST_F(CompoundScript, MovesAsOneBody) {
  EXPECT_THAT(
      failures_of("gravity(0, -10) ground{}\n"
                  "local t = compound{ at = {0, 1}, mass = 10, { shape = 'box', size = {3, 0.2} },\n"
                  "  { shape = 'box', size = {0.2, 0.9}, at = {-1, -0.55} },\n"
                  "  { shape = 'box', size = {0.2, 0.9}, at = {1, -0.55} } }\n"
                  "local y = t.y\n"
                  "local c = contact(t)\n"
                  "local function is(what, f, value) expect(what, f, { equals = value, within = 1e-9 }) "
                  "end\n"
                  "is('y', function() return t.y - y end, 0) is('angle', function() return t.angle end, "
                  "0)\n"
                  "is('force', function() return c.force end, 100) is('points', function() return c.points "
                  "end, 4)"),
      IsEmpty());
}

TEST_F(CompoundScript, SaysWhatIsWrong) {
  EXPECT_EQ(
      error_of("compound(3)"),
      "arch.lua:2: compound: expected a table, as in compound{ { shape = \"disc\", radius = 1 }, ... }, got "
      "the number 3");
  EXPECT_EQ(error_of("compound{ at = {0, 1} }"),
            "arch.lua:2: compound: expected at least one part, got none");
  EXPECT_EQ(
      error_of("compound{ { shape = 'disc', radius = 1 }, 5 }"),
      "arch.lua:2: compound: part 2 expected a table, as in { shape = \"disc\", radius = 1 }, got the number "
      "5");
  EXPECT_EQ(error_of("compound{ { radius = 1 } }"),
            "arch.lua:2: compound: part 1: shape expected a string, got nothing");
  EXPECT_EQ(error_of("compound{ { shape = 'bxo', size = {1, 1} } }"),
            "arch.lua:2: compound: part 1: no shape \"bxo\"; did you mean \"box\"?");
  EXPECT_EQ(error_of("compound{ { shape = 'box', size = 3 } }"),
            "arch.lua:2: compound: part 1: size expected {w, h}, got the number 3");
  EXPECT_EQ(error_of("compound{\n  { shape = 'disc', radius = 1 },\n  { shape = 'disc', radius = 0 } }"),
            "arch.lua:2: compound: part 2: radius must be positive, got 0");
  EXPECT_EQ(error_of("compound{ { shape = 'disc', radius = 1, radios = 2 } }"),
            "arch.lua:2: compound: part 1: no argument \"radios\"; did you mean \"radius\"?");
  EXPECT_EQ(error_of("compound{ { shape = 'disc', radius = 1, mass = 2 } }").substr(0, 48),
            "arch.lua:2: compound: part 1: no argument \"mass\"");
  EXPECT_EQ(error_of("compound{ { shape = 'disc', radius = 1, density = -1 } }"),
            "arch.lua:2: compound: part 1: density must be positive, got -1");
  EXPECT_EQ(error_of("compound{ { shape = 'disc', radius = 1, friction = 0.5, static_friction = 0.2 } }"),
            "arch.lua:2: compound: part 1: static_friction must be at least friction, got 0.2 and 0.5");
  EXPECT_EQ(error_of("compound{ { shape = 'disc', radius = 1 }, radius = 2 }").substr(0, 42),
            "arch.lua:2: compound: no argument \"radius\"");
  EXPECT_EQ(error_of("compound{ { shape = 'disc', radius = 1 }, mass = -2 }"),
            "arch.lua:2: compound: mass must be positive, got -2");
  EXPECT_EQ(error_of("compound{ { shape = 'disc', radius = 1, sensor = true } }"),
            "arch.lua:2: compound: all parts are sensors, which weigh nothing; set sensor = true for the "
            "whole body");
  EXPECT_EQ(
      error_of("watch('x', function() compound{ { shape = 'disc', radius = 1 } } return 0 end)"),
      "arch.lua:2: compound: the function of watch is asked for an answer, it must not change the world");
}

}  // namespace compound_script_test
}  // namespace skerry::sandbox
