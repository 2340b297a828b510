// SPDX-License-Identifier: MIT
//
// on_touch and on_hit: what they tell, in which order, and what their functions may do.
#include <gmock/gmock.h>

#include "tests/sandbox/script_fixture.h"

namespace skerry::sandbox {
namespace touch_script_test {

using testing::ElementsAre;
using testing::IsEmpty;

class TouchScript : public ScriptFixture {};

constexpr const char* kSay =
    "local function began(o, t) print('began', o.name, string.format('%.4f', t)) end\n"
    "local function ended(o, t) print('ended', o.alive and o.name or 'gone', string.format('%.4f', t)) end\n";

// A ball that does not bounce comes to a wall, and is pulled off again.
TEST_F(TouchScript, TellsBeginAndEnd) {
  EXPECT_THAT(lines_of(std::string(kSay) +
                       "local wall = box{ at = {2, 0}, size = {1, 1}, type = 'static', name = 'wall' }\n"
                       "box{ at = {-2, 0}, size = {1, 1}, type = 'static', name = 'other' }\n"
                       "local ball = disc{ at = {0, 0}, radius = 0.5, velocity = {4, 0}, name = 'ball' }\n"
                       "on_touch(ball, began, ended)\n"
                       "on_touch(ball, wall, function() print('wall', time()) end)\n"
                       "on_touch(wall, ball, began, nil)\n"
                       "at(0.5, function() ball.vx = -8 end)"),
              ElementsAre("began\twall\t0.2500", "wall\t0.25", "began\tball\t0.2500", "ended\twall\t0.5167",
                          "began\tother\t0.7500"));
}

TEST_F(TouchScript, WhatTouchesFromTheBeginningBeginsWithTheFirstStepAndRestsSilently) {
  EXPECT_THAT(
      lines_of(std::string(kSay) +
               "gravity(0, -10) ground{ name = 'floor' }\n"
               "local b = box{ at = {0, 0.5}, size = {1, 1}, name = 'box' }\n"
               "on_touch(b, began, ended)\n"
               // A watch that comes later has nothing to tell of what touches already, but for its end.
               "at(0.5, function() on_touch(b, began, function() print('end') end) end)\n"
               "at(0.8, function() b.y = 2 end)"),
      ElementsAre("began\tfloor\t0.0167", "ended\tfloor\t0.8167", "end"));
}

// What opens by micrometres, as contacts in piles do all the time, touches on.
TEST_F(TouchScript, ContactsThatOpenByMicrometresHaveNotEnded) {
  EXPECT_THAT(lines_of(std::string(kSay) +
                       "local a = box{ at = {0, 0}, size = {1, 1}, type = 'static' }\n"
                       "local b = box{ at = {1, 0}, size = {1, 1}, name = 'b' }\non_touch(a, began, ended)\n"
                       "at(0.2, function() b.x = 1 + 5e-6 end) at(0.4, function() b.x = 1 end)\n"
                       "at(0.6, function() b.x = 1 + 2e-5 end) at(0.8, function() b.x = 1 end)"),
              ElementsAre("began\tb\t0.0167", "ended\tb\t0.6167", "began\tb\t0.8167"));
}

// Zones see a ball that is removed in them, and one that goes on; corners and seams of a body are one.
TEST_F(TouchScript, SensorsCountWhatIsInThem) {
  EXPECT_THAT(
      lines_of(
          "local zone = compound{ at = {2, 0}, type = 'static', sensor = true,\n"
          "  { shape = 'box', at = {-0.5, 0}, size = {1, 1} }, { shape = 'box', at = {0.5, 0}, size = "
          "{1, 1} } }\n"
          "local a = disc{ at = {0, 0}, radius = 0.25, velocity = {4, 0}, name = 'a' }\n"
          "disc{ at = {-1, 0}, radius = 0.25, velocity = {5, 0}, name = 'b', ignores = {'x'}, category = "
          "'x' }\n"
          "a.category = 'x' a.ignores = {'x'}\n"
          "local inside = 0\n"
          "on_touch(zone, function(o) inside = inside + 1 print('in', o.name, inside) end,\n"
          "  function(o) inside = inside - 1 print('out', o.alive, inside) end)\n"
          "at(0.5, function() a:remove() end)"),
      ElementsAre("in\ta\t1", "in\tb\t2", "out\tfalse\t1", "out\ttrue\t0"));
}

// A box comes to rest in a zone and sleeps; it is in there until it is taken out.
TEST_F(TouchScript, SleepersStayInTheirZone) {
  Demo demo = load(
      "gravity(0, -10) ground{}\nlocal b = box{ at = {0, 0.5}, size = {1, 1}, name = 'box' }\n"
      "local zone = box{ at = {0, 1}, size = {3, 2}, type = 'static', sensor = true }\n"
      "on_touch(zone, function(o, t) print('in', t < 0.02) end, function(o, t) print('out', t > 0.9) "
      "end)\n"
      "local feel = contact(zone, b)\n"
      "at(0.8, function() print(feel.touching, feel.points, contact(zone).touching) end)\n"
      "at(0.9, function() b.y = 4 end)");
  while (demo.time() < 0.85) demo.step();
  EXPECT_TRUE(demo.world().asleep(demo.world().body_id(1)));
  run_to_end(demo);
  EXPECT_THAT(printed_, ElementsAre("in\ttrue", "true\t1\ttrue", "out\ttrue"));
}

// A chain has events of each segment; what rolls over its corners touches one body all the time.
TEST_F(TouchScript, SegmentsOfAChainAreOneBody) {
  EXPECT_THAT(lines_of(std::string(kSay) +
                       "gravity(0, -10)\nlocal way = {} for k = 0, 20 do way[k + 1] = {k / 4, 0} end\n"
                       "chain{ points = way, name = 'way' }\n"
                       "local b = disc{ at = {1, 0.2}, radius = 0.2, velocity = {3, 0} }\n"
                       "on_touch(b, began, ended)"),
              ElementsAre("began\tway\t0.0167"));
}

TEST_F(TouchScript, BodiesMayBeRemovedByTheFunctions) {
  // Two coins at once, and a ball that takes itself away: its own end comes, too.
  EXPECT_THAT(
      lines_of("local ball = disc{ at = {0, 0}, radius = 0.5, velocity = {4, 0}, name = 'ball' }\n"
               "for _, y in ipairs{ -0.6, 0.6 } do\n"
               "  local coin = disc{ at = {2, y}, radius = 0.5, sensor = true, name = 'coin' .. y }\n"
               "  on_touch(coin, ball, function() print('take', coin.name) coin:remove() end,\n"
               "    function(o) print('lost', o.name, coin.alive) end)\n"
               "end\n"
               "local wall = box{ at = {4, 0}, size = {1, 9}, type = 'static', name = 'wall' }\n"
               "on_touch(ball, wall, function(o) ball:remove() end, function(o) print('gone', o.name) end)\n"
               // What it removed does not begin to touch for who comes later.
               "on_touch(ball, function(o) print('late', o.name) end, function() print('never') end)"),
      ElementsAre("take\tcoin-0.6", "take\tcoin0.6", "lost\tball\tfalse", "lost\tball\tfalse", "gone\twall"));
}

// A ball falls on the floor: when, how fast, where and with what impulse is known.
TEST_F(TouchScript, HitsTellTheBlow) {
  for (const char* stepper : {"event_driven", "time_stepping"}) {
    EXPECT_THAT(
        failures_of(
            "gravity(0, -10) ground{ name = 'floor' }\n"
            "local ball = disc{ at = {1, 1.5}, radius = 0.5, mass = 2, restitution = 0.5 }\n"
            "local blows = {}\n"
            "on_hit(ball, function(other, speed, x, y, impulse, t)\n"
            "  blows[#blows + 1] = { other = other.name, speed = speed, x = x, y = y, impulse = "
            "impulse, t = t,\n"
            "    time = time(), vy = ball.vy, height = ball.y }\n"
            "end)\n"
            "local function is(what, f, value) expect(what, f, { equals = value, within = 1e-4 }) end\n"
            "local v = math.sqrt(20)\n"
            "local hard = 0 on_hit(ball, function() hard = hard + 1 end, 3)\n"
            "is('blows', function() return #blows end, 2) is('hard', function() return hard end, 1)\n"
            "for k, t in ipairs{ v / 10, 2 * v / 10 } do\n"
            "  local e = 0.5 ^ (k - 1)\n"
            "  local function of(what, value) is(what .. k, function() return blows[k][what] end, value) "
            "end\n"
            "  of('speed', e * v) of('x', 1) of('y', 0) of('impulse', 2 * 1.5 * e * v) of('t', t)\n"
            "  of('time', t) of('vy', 0.5 * e * v) of('height', 0.5)\n"
            "  is('floor' .. k, function() return blows[k].other == 'floor' end, 1)\n"
            "end",
            {.stepper = stepper}),
        IsEmpty())
        << stepper;
  }
}

TEST_F(TouchScript, HitsAndEventsComeInTheOrderOfTime) {
  const std::string scene =
      "local b = disc{ at = {0, 0}, radius = 0.5, velocity = {1, 0}, name = 'ball' }\n"
      "local early = box{ at = {0, 1.02}, size = {1, 1}, velocity = {0, -1}, type = 'kinematic', name = "
      "'early' "
      "}\n"
      "local late = box{ at = {0, -1.03}, size = {1, 1}, velocity = {0, 0.5}, type = 'kinematic', name = "
      "'late' "
      "}\n"
      "local slow = box{ at = {-1.05, 0}, size = {1, 1}, velocity = {1.1, 0}, type = 'kinematic', name = "
      "'slow' "
      "}\n"
      "local function say(o, v) print(o.name, string.format('%.3f', v)) end\n"
      "on_hit(late, say)\non_hit(b, late, say)\non_hit(b, early, say, 0.5)\non_hit(b, slow, say, 0.2)\n"
      "on_event(function() return time() - 0.03 end, function() print('event') end)\n"
      "on_touch(b, early, function() print('touch') end)";
  Lines lines = lines_of(scene, {.dt = 0.1, .stepper = "event_driven"});
  ASSERT_GE(lines.size(), 5u);
  lines.resize(5);
  // At 0.02, at 0.03, and at 0.0333 by who was told first; then what touches at the end of the step.
  EXPECT_THAT(lines, ElementsAre("early\t1.000", "event", "ball\t1.500", "late\t1.500", "touch"));
}

TEST_F(TouchScript, ShapesOfABodyStrikeTogether) {
  // A flat landing on two tiles of one body: each gives half of it.
  EXPECT_THAT(
      failures_of("gravity(0, -10)\n"
                  "compound{ at = {0, -0.5}, type = 'static', { shape = 'box', at = {-1, 0}, size = {2, "
                  "1} },\n"
                  "  { shape = 'box', at = {1, 0}, size = {2, 1} } }\n"
                  "local b = box{ at = {0, 1}, size = {2, 1}, mass = 3 }\n"
                  "local calls, sum = 0, 0\n"
                  "on_hit(b, function(o, v, x, y, j) calls = calls + 1 sum = sum + j end)\n"
                  "expect('calls', function() return calls end, { equals = 1, within = 0 })\n"
                  "expect('sum', function() return sum end, { equals = 3 * math.sqrt(10), within = 1e-3 "
                  "})"),
      IsEmpty());
}

TEST_F(TouchScript, WhatWasRemovedByAnEarlierActionStrikesNoMore) {
  EXPECT_THAT(
      lines_of("local target = box{ at = {2, 0}, size = {1, 3}, type = 'static' }\n"
               "for _, y in ipairs{ -1, 1 } do\n"
               "  local shot = disc{ at = {0, y}, radius = 0.25, velocity = {8, 0} }\n"
               "  on_hit(shot, target, function() print('hit') target:remove() shot:impulse(0, 1) end)\n"
               "end"),
      ElementsAre("hit"));
}

// Waiting for bodies that are no more costs nothing: their functions are dropped.
TEST_F(TouchScript, ManyShotsLeaveNothingBehind) {
  const auto bytes_after = [&](int seconds) {
    Demo demo = load(
        "local wall = box{ at = {2, 0}, size = {1, 1}, type = 'static' }\n"
        "on_step(function(t)\n"
        "  local shot = disc{ at = {1, 0}, radius = 0.1, velocity = {30, 0} }\n"
        "  local text = string.rep('x', 1000) .. t\n"
        "  on_hit(shot, wall, function() local l = #text shot:remove() end)\n"
        "  on_touch(shot, function() local l = #text end)\n"
        "end)");
    for (int i = 0; i < 60 * seconds; ++i) demo.step();
    EXPECT_LE(demo.world().report().bodies, 4);
    return demo.save().bytes();
  };
  EXPECT_LT(static_cast<double>(bytes_after(20)), 1.5 * static_cast<double>(bytes_after(4)));
}

TEST_F(TouchScript, GoesBackWithTheState) {
  Demo demo = load(
      "gravity(0, -10) ground{ name = 'floor' }\nlocal n = 0\n"
      "for k = 1, 5 do\n"
      "  local b = disc{ at = {k, 1 + k / 5}, radius = 0.3, restitution = 0.6, name = 'b' .. k }\n"
      "  on_touch(b, function(o) n = n + 1 print('on', k, n) end, function() print('off', k) end)\n"
      "  on_hit(b, function(o, v) print('hit', b.name, v) if v < 2.5 then b:remove() end end)\n"
      "end\n"
      "local zone = box{ at = {3, 0.5}, size = {4, 0.5}, type = 'static', sensor = true }\n"
      "on_touch(zone, function(o) print('in', o.name) end, function(o) print('out', o.alive) end)");
  std::vector<DemoState> states;
  std::vector<std::size_t> lines;
  for (int i = 0; i < 90; ++i) {
    if (i % 13 == 0) {
      states.push_back(demo.save());
      lines.push_back(printed_.size());
    }
    demo.step();
  }
  const Lines all = printed_;
  const std::uint64_t hash = demo.world().state_hash();
  EXPECT_GT(all.size(), 20u);
  for (std::size_t k = states.size(); k-- > 0;) {
    printed_.clear();
    demo.restore(states[k]);
    while (demo.steps_done() < 90) demo.step();
    EXPECT_EQ(printed_, Lines(all.begin() + static_cast<std::ptrdiff_t>(lines[k]), all.end())) << k;
    EXPECT_EQ(demo.world().state_hash(), hash);
  }
}

// A run from a snapshot makes the steps again, as for all who act while it runs.
TEST_F(TouchScript, CountsAsActingWhileItRuns) {
  const std::string b = "local b = disc{ radius = 1 }\n";
  EXPECT_FALSE(load(b).has_callbacks());
  EXPECT_TRUE(load(b + "on_touch(b, print)").has_callbacks());
  EXPECT_TRUE(load(b + "on_hit(b, print)").has_callbacks());
}

TEST_F(TouchScript, SaysWhatIsWrong) {
  const std::string b = "local b = disc{ radius = 1 }\n";
  EXPECT_EQ(error_of("on_touch(3, print)"), "arch.lua:2: on_touch: first expected a body, got the number 3");
  EXPECT_EQ(error_of(b + "on_touch(b, 3)"),
            "arch.lua:3: on_touch: second expected a body or a function, got the number 3");
  EXPECT_EQ(error_of(b + "on_touch(b, nil, print)"),
            "arch.lua:3: on_touch: second expected a body or a function, got nothing");
  EXPECT_EQ(error_of(b + "on_touch(b, b)"), "arch.lua:3: on_touch: began expected a function, got nothing");
  EXPECT_EQ(error_of(b + "on_touch(b, print, 3)"),
            "arch.lua:3: on_touch: ended expected a function, got the number 3");
  EXPECT_EQ(error_of(b + "b:remove()\non_touch(b, print)"), "arch.lua:4: on_touch: first was removed");
  EXPECT_EQ(error_of(b + "on_hit(b)"),
            "arch.lua:3: on_hit: second expected a body or a function, got nothing");
  EXPECT_EQ(error_of("on_hit('b', print)"),
            "arch.lua:2: on_hit: first expected a body, got the string \"b\"");
  EXPECT_EQ(error_of(b + "on_hit(b, print, -1)"), "arch.lua:3: on_hit: least must be at least 0, got -1");
  EXPECT_EQ(error_of(b + "on_hit(b, print, 'fast')"),
            "arch.lua:3: on_hit: least expected a finite number, got the string \"fast\"");
  EXPECT_EQ(
      error_of(b + "local late at(0.1, function() late = true end)\n"
                   "watch('x', function() if late then on_touch(b, print) end return 0 end)"),
      "arch.lua:4: on_touch: the function of watch is asked for an answer, it must not change the world");
  EXPECT_EQ(error_of(b + "watch('x', function() on_hit(b, print) return 0 end)"),
            "arch.lua:3: on_hit: the function of watch is asked for an answer, it must not change the world");
  EXPECT_EQ(error_of(b + "local c = disc{ at = {3, 0}, radius = 1, velocity = {-5, 0} }\n"
                         "on_hit(c, function(o)\n  o.colour = 3\nend)"),
            "arch.lua:5: body: \"colour\" cannot be set; these can: " +
                error_of(b + "b.colour = 3")
                    .substr(std::string("arch.lua:3: body: \"colour\" cannot be set; these "
                                        "can: ")
                                .size()));
}

}  // namespace touch_script_test
}  // namespace skerry::sandbox
