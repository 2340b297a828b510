// SPDX-License-Identifier: MIT
//
// Sensors in scripts, and what meets what: group, category, ignores.
#include <gmock/gmock.h>

#include "tests/sandbox/script_fixture.h"

namespace skerry::sandbox {
namespace sensor_script_test {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class SensorScript : public ScriptFixture {};

// A disc flies through one of each kind, one after the other, and is told by all.
TEST_F(SensorScript, ShapesOfAllKindsNoticeAndDoNotPush) {
  EXPECT_THAT(
      failures_of(
          "local zones = {\n"
          "  box{ at = {2, 0}, size = {1, 1}, type = 'static', sensor = true },\n"
          "  disc{ at = {4, 0}, radius = 0.5, type = 'static', sensor = true },\n"
          "  polygon{ at = {6, 0}, corners = {{-0.5, -1}, {0.5, -1}, {0, 1}}, type = 'kinematic', sensor = "
          "true },\n"
          "  capsule{ at = {8, 0}, from = {-0.2, 0}, to = {0.2, 0}, radius = 0.3, type = 'static', sensor = "
          "true },\n"
          "  chain{ points = {{10, -1}, {10, 1}}, sensor = true },\n"
          "  chain{ points = {{12, 1}, {12, -1}}, sensor = true },\n"
          "  ground{ x = 13, tilt = math.pi / 2, sensor = true },\n"
          "  disc{ at = {0, 3}, radius = 0.5, velocity = {20, 0}, sensor = true },\n"
          "  disc{ at = {0, 3}, radius = 0.5, velocity = {20, 0} } }\n"
          "local b = disc{ at = {0, 0}, radius = 0.25, velocity = {20, 0} }\n"
          "local steps, feels = {}, {}\n"
          "for k, zone in ipairs(zones) do steps[k] = 0 feels[k] = contact(zone, b) end\n"
          "local seen, points = 0, 0\nlocal any = contact(b)\n"
          "watch('x', function()\n"
          "  for k, feel in ipairs(feels) do if feel.touching then steps[k] = steps[k] + 1 end end\n"
          "  if any.touching then seen = seen + 1 end\n"
          "  if feels[1].touching then points = points + feels[1].points end\n"
          "  return 0\n"
          "end)\n"
          "local function is(what, f, value) expect(what, f, { equals = value, within = 1e-12 }) end\n"
          "is('x', function() return b.x end, 20) is('vx', function() return b.vx end, 20)\n"
          // Their widths and that of the disc, in steps of a third of a metre.
          "for k, wide in ipairs{ 1.5, 1.5, 1, 1.5, 0.5, 0.5 } do\n"
          "  expect('zone ' .. k, function() return steps[k] end,\n"
          "    { above = 3 * wide - 1.01, below = 3 * wide + 1.01 })\n"
          "end\n"
          "is('points', function() return points - steps[1] end, 0)\n"
          "is('others', function() return steps[8] + steps[9] end, 0)\n"
          "is('what pushes the disc', function() return seen end, 0)\n"
          "is('box', function() return contact(zones[1]).force end, 0)\n"
          "for k, zone in ipairs(zones) do is('sensor ' .. k, function() return zone.sensor end,\n"
          "  k < 9 and 1 or 0) end\n"
          "is('a solid', function() return b.sensor end, 0)\n"),
      IsEmpty());
}

TEST_F(SensorScript, ASensorOfItsOwnSeesAnythingAndFalls) {
  EXPECT_THAT(lines_of("gravity(0, -10)\nground{ y = 0 }\n"
                       "local zone = box{ at = {0, 1}, size = {1, 1}, sensor = true, density = 2 }\n"
                       "local touch, was = contact(zone), nil\n"
                       "print(zone.mass, zone.sensor)\n"
                       "on_step(function(t)\n"
                       "  if touch.touching ~= was then was = touch.touching print(was, touch.force, "
                       "touch.gap) end\n"
                       "end)\n"
                       "at(0.95, function() print(zone.y < -3) end)"),
              ElementsAre("2.0\ttrue", "false\t0.0\tinf", "true\t0.0\tinf", "true"));
}

// Solid shapes are filled; sensors let shine through what is behind, and a track of them is dashed, without a
// side.
TEST_F(SensorScript, PicturesShowWhatIsASensor) {
  const auto count = [&](const std::string& scene, const std::string& what) {
    const std::string path =
        folder_.write("picture.lua", "demo{ title = 'T', view = { x = 0, y = 0, height = 6 } }\n" + scene);
    const std::string svg = run({"export", path, "--at", "0", "--svg", "-"}).out;
    int found = 0;
    for (std::size_t at = svg.find(what); at != std::string::npos; at = svg.find(what, at + 1)) ++found;
    return found;
  };
  const std::string box = "box{ size = {1, 1}, type = 'static', color = 'orange'";
  const std::string track = "chain{ points = {{-1, 0}, {1, 0}}, color = 'orange'";
  const std::string faint = "fill=\"#f1b955\" fill-opacity=\"0.251\"", full = "fill=\"#f1b955\"";
  EXPECT_EQ(count(box + " }", faint), 0);
  EXPECT_EQ(count(box + " }", full), 1);
  EXPECT_EQ(count(box + ", sensor = true }", faint), 1);
  EXPECT_GT(count(track + " }", full), 0);
  EXPECT_EQ(count(track + ", sensor = true }", full), 0);
  EXPECT_EQ(count(track + " }", "fill=\"#986000\""), 1);
  EXPECT_GT(count(track + ", sensor = true }", "fill=\"#986000\""), 10);
}

TEST_F(SensorScript, SaysWhatIsWrong) {
  EXPECT_EQ(error_of("disc{ radius = 1, sensor = 1 }"),
            "arch.lua:2: disc: sensor expected true or false, got the number 1");
  EXPECT_EQ(error_of("ground{ sensor = 'yes' }"),
            "arch.lua:2: ground: sensor expected true or false, got the string \"yes\"");
  EXPECT_EQ(error_of("chain{ points = {{0, 0}, {1, 0}}, sensor = {} }"),
            "arch.lua:2: chain: sensor expected true or false, got a table");
  EXPECT_THAT(
      error_of("local b = disc{ radius = 1 }\nb.sensor = true"),
      HasSubstr(
          "arch.lua:3: body: \"sensor\" cannot be set; these can: type, color, group, category, ignores"));
  EXPECT_EQ(error_of("local b = disc{ radius = 1 }\nb:remove()\nprint(b.sensor)"),
            "arch.lua:4: body: \"sensor\" of a body that was removed");
}

constexpr const char* kTwo =
    "local wall = box{ at = {2, 0}, size = {1, 1}, type = 'static', WALL }\n"
    "local ball = disc{ at = {0, 0}, radius = 0.5, velocity = {4, 0}, BALL }\n"
    "at(0.9, function() print(ball.x > 3) end)\n";

std::string two(const std::string& wall, const std::string& ball, const std::string& more = "") {
  std::string text = kTwo;
  text.replace(text.find("WALL"), 4, wall);
  text.replace(text.find("BALL"), 4, ball);
  return text + more;
}

TEST_F(SensorScript, WhatIgnoresACategoryPassesIt) {
  const Lines through{"true"}, stopped{"false"};
  EXPECT_EQ(lines_of(two("", "")), stopped);
  EXPECT_EQ(lines_of(two("category = 'gate'", "")), stopped);
  EXPECT_EQ(lines_of(two("category = 'gate'", "ignores = {'door', 'gate'}")), through);
  EXPECT_EQ(lines_of(two("category = 'gate'", "ignores = {'door'}")), stopped);
  EXPECT_EQ(lines_of(two("category = 'gate', ignores = {'ball'}", "category = 'ball'")), through);
  EXPECT_EQ(lines_of(two("category = 'gate', ignores = {'gate'}", "category = 'ball', ignores = {'ball'}")),
            stopped);
  // The group goes first.
  EXPECT_EQ(lines_of(two("category = 'gate', group = 3", "ignores = {'gate'}, group = 3")), stopped);
  EXPECT_EQ(lines_of(two("group = -3", "group = -3")), through);
  EXPECT_EQ(lines_of("ground{ y = -1, category = 'floor' }\ngravity(0, -10)\n"
                     "local ball = disc{ radius = 0.5, ignores = {'floor'} }\n"
                     "at(0.9, function() print(ball.y > -2) end)"),
            stopped);
}

TEST_F(SensorScript, WhatMeetsWhatCanBeChangedAndRead) {
  const Lines through{"true"}, stopped{"false"};
  EXPECT_EQ(lines_of(two("", "", "wall.group = -1 ball.group = -1")), through);
  EXPECT_EQ(lines_of(two("", "", "at(0.1, function() wall.category = 'gate' ball.ignores = {'gate'} end)")),
            through);
  EXPECT_EQ(
      lines_of(two("category = 'gate'", "ignores = {'gate'}", "at(0.1, function() ball.ignores = nil end)")),
      stopped);
  EXPECT_EQ(lines_of(two("category = 'gate'", "ignores = {'gate'}", "wall.category = nil")), stopped);
  EXPECT_EQ(lines_of("local b = disc{ radius = 1, ignores = {'c', 'a'}, group = -2 }\n"
                     "print(b.group, b.category, #b.ignores, table.concat(b.ignores, ' '))\n"
                     "b.category = 'a' b.group = 7 b.ignores = {'b', 'a'}\n"
                     "print(b.group, b.category, table.concat(b.ignores, ' '))\n"
                     "b.category = nil b.ignores = {} b.group = nil print(b.group, b.category, #b.ignores)"),
            (Lines{"-2\tnil\t2\tc a", "7\ta\ta b", "0\tnil\t0"}));
}

// Names that a run adds are as they were when it goes back.
TEST_F(SensorScript, CategoriesGoBackWithTheState) {
  Demo demo = load(
      "local b = disc{ radius = 1, category = 'first' }\n"
      "at(0.5, function() b.ignores = {'second'} print(#b.ignores) end)");
  for (int i = 0; i < 20; ++i) demo.step();
  const DemoState before = demo.save();
  for (int i = 0; i < 20; ++i) demo.step();
  const Lines once = printed_;
  demo.restore(before);
  for (int i = 0; i < 20; ++i) demo.step();
  EXPECT_EQ(once, Lines{"1"});
  EXPECT_EQ(printed_, (Lines{"1", "1"}));
}

TEST_F(SensorScript, CategoriesSayWhatIsWrong) {
  EXPECT_EQ(error_of("disc{ radius = 1, category = 3 }"),
            "arch.lua:2: disc: category expected a string, got the number 3");
  EXPECT_EQ(error_of("disc{ radius = 1, category = '' }"),
            "arch.lua:2: disc: category expected a name, got the string \"\"");
  EXPECT_EQ(
      error_of("disc{ radius = 1, ignores = 'coin' }"),
      "arch.lua:2: disc: ignores expected a list of categories as in {\"coin\"}, got the string \"coin\"");
  EXPECT_EQ(error_of("disc{ radius = 1, ignores = {'coin', 3} }"),
            "arch.lua:2: disc: ignores[2] expected a string, got the number 3");
  EXPECT_EQ(error_of("for k = 1, 32 do disc{ at = {3 * k, 0}, radius = 1, category = 'c' .. k } end"),
            "arch.lua:2: disc: category: \"c32\" is one more than the 31 categories that there may be");
  const std::string ball = "local b = disc{ radius = 1 }\n";
  EXPECT_EQ(error_of(ball + "b.group = 0.5"), "arch.lua:3: body: group expected a whole number, got 0.5");
  EXPECT_EQ(error_of(ball + "b.group = 'x'"),
            "arch.lua:3: body: group expected a finite number, got the string \"x\"");
  EXPECT_EQ(error_of(ball + "b.category = 3"),
            "arch.lua:3: body: category expected a string, got the number 3");
  EXPECT_EQ(error_of(ball + "b.ignores = {3}"),
            "arch.lua:3: body: ignores[1] expected a string, got the number 3");
  EXPECT_EQ(error_of(ball + "b:remove()\nb.group = 3"),
            "arch.lua:4: body: \"group\" of a body that was removed");
  EXPECT_EQ(error_of(ball + "watch('x', function() b.category = 'x' return 0 end)"),
            "arch.lua:3: body: the function of watch is asked for an answer, it must not change the world");
}

}  // namespace sensor_script_test
}  // namespace skerry::sandbox
