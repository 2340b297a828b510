// SPDX-License-Identifier: MIT
//
// ray, bodies_at and nearest.
#include <gmock/gmock.h>

#include "tests/sandbox/script_fixture.h"

namespace skerry::sandbox {
namespace query_script_test {

using testing::ElementsAre;

class QueryScript : public ScriptFixture {};

constexpr const char* kScene =
    "local a = box{ at = {2, 0}, size = {1, 1}, type = 'static', name = 'a', category = 'wall' }\n"
    "local b = disc{ at = {4, 0}, radius = 0.5, name = 'b' }\n"
    "local z = box{ at = {1, 0}, size = {0.5, 0.5}, type = 'static', sensor = true, name = 'zone' }\n"
    "local function say(body, ...)\n"
    "  local text = { body and body.name or 'none' }\n"
    "  for k, v in ipairs{ ... } do text[#text + 1] = string.format('%.3g', v + 0.0) end\n"
    "  print(table.concat(text, ' '))\n"
    "end\n"
    "local function all(list) local text = {} for k, v in ipairs(list) do text[k] = v.name end\n"
    "  print(#list, table.concat(text, ' ')) end\n";

TEST_F(QueryScript, RaysMeetTheFirstBody) {
  EXPECT_THAT(lines_of(std::string(kScene) + "say(ray{ from = {0, 0}, to = {9, 0} })\n"
                                             "say(ray{ from = {0, 0}, to = {9, 0}, skip = a })\n"
                                             "say(ray{ from = {9, 0}, to = {0, 0}, skip = { b } })\n"
                                             "say(ray{ from = {0, 0}, to = {9, 0}, skip = { a, b } })\n"
                                             "say(ray{ from = {0, 0}, to = {9, 0}, ignores = {'wall'} })\n"
                                             "say(ray{ from = {0, 0}, to = {9, 0}, sensors = true })\n"
                                             "say(ray{ from = {0, 0}, to = {1.4, 0} })\n"
                                             // From within it is met where it begins.
                                             "say(ray{ from = {2, 0.25}, to = {9, 0.25} })"),
              ElementsAre("a 1.5 0 -1 0", "b 3.5 0 -1 0", "a 2.5 0 1 0", "none", "b 3.5 0 -1 0",
                          "zone 0.75 0 -1 0", "none", "a 2 0.25 -1 0"));
}

TEST_F(QueryScript, PointsLieInBodiesAndNearThem) {
  EXPECT_THAT(
      lines_of(std::string(kScene) +
               "disc{ at = {2, 0.6}, radius = 0.3, name = 'c', type = 'static' }\n"
               "all(bodies_at(2, 0.4)) all(bodies_at(2, 0.4, { skip = a }))\n"
               "all(bodies_at(2, 0.4, { ignores = {'wall'} })) all(bodies_at(1, 0)) all(bodies_at(9, 9))\n"
               "all(bodies_at(1, 0, { sensors = true }))\n"
               "say(nearest(3.1, 0)) say(nearest(3.1, 0, { skip = b })) say(nearest(4, 0.4))\n"
               "say(nearest(4, 3, { within = 2.4 })) say(nearest(4, 3, { within = 2.6 }))\n"
               "say(nearest(0, 0)) say(nearest(0, 0, { sensors = true }))\n"
               "say(nearest(0, 0, { skip = {a, b}, ignores = {'wall'}, within = 1 }))"),
      ElementsAre("2\ta c", "1\tc", "1\tc", "0\t", "0\t", "1\tzone", "b 0.4 3.5 0", "a 0.6 2.5 0",
                  "b -0.1 4 0.5", "none", "b 2.5 4 0.5", "a 1.5 1.5 0", "zone 0.75 0.75 0", "none"));
}

// They see the world as it is: what was made or moved a moment ago, and in an action the end of the step.
TEST_F(QueryScript, SeeTheWorldAsItIs) {
  EXPECT_THAT(lines_of(std::string(kScene) +
                       "at(0.1, function()\n"
                       "  disc{ at = {0, 5}, radius = 0.5, name = 'new' } b.x = 6\n"
                       "  all(bodies_at(0, 5)) all(bodies_at(6, 0)) all(bodies_at(4, 0)) say(nearest(7, 0))\n"
                       "  say(ray{ from = {9, 0}, to = {3, 0} })\n"
                       "  a:remove() say(ray{ from = {0, 0}, to = {9, 0} })\n"
                       "end)\n"
                       "local m = disc{ at = {0, -5}, radius = 0.5, velocity = {6, 0}, name = 'm' }\n"
                       "on_event(function() return m.x - 1.05 end, function()\n"
                       "  print(m.x < 1.051) say(nearest(1.7, -5))\n"
                       "end)"),
              ElementsAre("1\tnew", "1\tb", "0\t", "b 0.5 6.5 0", "b 6.5 0 1 0", "b 5.5 0 -1 0", "true",
                          "m 0.1 1.6 -5"));
}

// A chain is met from the side where it is free, the ground from above.
TEST_F(QueryScript, TracksAndGroundAreFound) {
  EXPECT_THAT(
      lines_of(std::string(kScene) +
               "chain{ points = {{-5, 2}, {5, 2}}, name = 'track' } ground{ y = -3, name = 'floor' }\n"
               "say(ray{ from = {-4, 4}, to = {-4, 0} }) say(ray{ from = {-4, 0}, to = {-4, 4} })\n"
               "say(ray{ from = {-4, 0}, to = {-4, -9} }) say(nearest(-4, 1.5)) say(nearest(-4, -2))\n"
               "all(bodies_at(99, -4))"),
      ElementsAre("track -4 2 0 1", "none", "floor -4 -3 0 1", "track 0.5 -4 2", "floor 1 -4 -3",
                  "1\tfloor"));
}

TEST_F(QueryScript, AnswersMayBeLookedAtWhereTheWorldMustNotChange) {
  EXPECT_EQ(error_of(std::string(kScene) +
                     "watch('x', function() return select(2, nearest(0, 0)) end)\n"
                     "on_event(function() return select(2, nearest(b.x, 3)) - 1 end, function() end)\n"
                     "expect('x', function() return #bodies_at(2, 0) end, { equals = 1, within = 0 })"),
            "no error");
  for (const auto& [call, name] :
       std::vector<std::pair<std::string, std::string>>{{"ray{ from = {0, 0}, to = {1, 0} }", "ray"},
                                                        {"bodies_at(0, 0)", "bodies_at"},
                                                        {"nearest(0, 0)", "nearest"}}) {
    EXPECT_EQ(error_of(std::string(kScene) + "field(function(x)\n  " + call + "\n  return 0, 0\nend)"),
              "arch.lua:13: " + name + ": the function of field must depend on its arguments alone");
    EXPECT_EQ(
        error_of(std::string(kScene) +
                 "local k = box{ at = {0, 9}, size = {1, 1}, type = 'kinematic' } move(k, function(t)\n  " +
                 call + "\n  return 0, 9 end)"),
        "arch.lua:13: " + name + ": the function of move must depend on its arguments alone");
  }
}

TEST_F(QueryScript, SaysWhatIsWrong) {
  EXPECT_EQ(error_of("ray(3)"),
            "arch.lua:2: ray: expected a table, as in ray{ from = ... }, got the number 3");
  EXPECT_EQ(error_of("ray{ from = {0, 0} }"), "arch.lua:2: ray: to expected {x, y}, got nothing");
  EXPECT_EQ(error_of("ray{ from = {0, 0}, to = 'x' }"),
            "arch.lua:2: ray: to expected {x, y}, got the string \"x\"");
  EXPECT_EQ(error_of("ray{ from = {1, 2}, to = {1, 2} }"),
            "arch.lua:2: ray: to must not be where from is, {1, 2}");
  EXPECT_EQ(error_of("ray{ from = {0, 0}, to = {1, 0}, skip = 3 }"),
            "arch.lua:2: ray: skip expected a body or a list of bodies, got the number 3");
  EXPECT_EQ(error_of("ray{ from = {0, 0}, to = {1, 0}, skip = {3} }"),
            "arch.lua:2: ray: skip[1] expected a body, got the number 3");
  EXPECT_EQ(
      error_of(
          "disc{ radius = 1, category = 'coin' }\nray{ from = {0, 0}, to = {1, 0}, ignores = {'cion'} }"),
      "arch.lua:3: ray: ignores: no category \"cion\"; did you mean \"coin\"?");
  EXPECT_EQ(error_of("ray{ from = {0, 0}, to = {1, 0}, sensor = true }"),
            "arch.lua:2: ray: no argument \"sensor\"; did you mean \"sensors\"?");
  EXPECT_EQ(error_of("bodies_at(1)"), "arch.lua:2: bodies_at: y expected a finite number, got nothing");
  EXPECT_EQ(error_of("bodies_at(0, 0, { within = 3 })"),
            "arch.lua:2: bodies_at: no argument \"within\"; there are skip, ignores, sensors");
  EXPECT_EQ(error_of("nearest({1, 2})"), "arch.lua:2: nearest: x expected a finite number, got a table of 2");
  EXPECT_EQ(error_of("nearest(0, 0, { within = -1 })"),
            "arch.lua:2: nearest: within must be at least 0, got -1");
  EXPECT_EQ(error_of("nearest(0, 0, 3)"),
            "arch.lua:2: nearest: expected a table, as in nearest{ within = ... }, got the number 3");
}

}  // namespace query_script_test
}  // namespace skerry::sandbox
