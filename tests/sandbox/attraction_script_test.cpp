// SPDX-License-Identifier: MIT
//
// Scripts: attract.
#include <gtest/gtest.h>

#include "tests/sandbox/script_fixture.h"

namespace skerry::sandbox {
namespace attraction_script_test {

class AttractionScript : public ScriptFixture {};

const std::string kBinary =
    "local sun = disc{ at = {0, 0}, radius = 0.1, mass = 3, velocity = {0, -0.25} }\n"
    "local moon = disc{ at = {1, 0}, radius = 0.1, mass = 1, velocity = {0, 0.75} }\n";

TEST_F(AttractionScript, KeepsWhatOrbitsHave) {
  const Lines lines =
      lines_of(kBinary +
               "local pull = attract{ strength = 0.25 }\n"
               "local first\n"
               "on_step(function(t)\n"
               "  local e = energy() + pull.energy\n"
               "  first = first or e\n"
               "  if math.abs(e - first) > 1e-4 * math.abs(first) then print('energy', e) end\n"
               "  local px, py = momentum()\n"
               "  if math.abs(px) + math.abs(py) > 1e-13 then print('momentum') end\n"
               "  local far = math.sqrt((moon.x - sun.x) ^ 2 + (moon.y - sun.y) ^ 2)\n"
               "  if math.abs(far - 1) > 1e-3 then print('far', far) end\n"
               "end)\n"
               "at(0.5, function() print(pull.power, pull.softening, pull.strength) end)\n");
  EXPECT_EQ(lines, Lines{"2.0\t0.0\t0.25"});
}

TEST_F(AttractionScript, TakesChargesOfAnything) {
  const Lines lines = lines_of(
      "local wall = box{ at = {-1, 0}, size = {0.1, 0.1}, type = 'static' }\n"
      "local a = disc{ at = {0, 0}, radius = 0.1, mass = 2 }\n"
      "local b = disc{ at = {0, 5}, radius = 0.1, mass = 1 }\n"
      "local push = attract{ strength = -1, power = 1, bodies = {wall, a}, weights = {3, 2} }\n"
      "on_step(function(t, h) if t == 0 then print(push.energy) end end)\n"
      "local n = 0\n"
      "on_step(function(t, h)\n"
      "  n = n + 1\n"
      "  if n == 2 then print(a.vx / h, b.vx, b.vy) push:remove() end\n"
      "  if n == 3 then print(a.vx / h) end\n"
      "end)\n");
  EXPECT_EQ(lines, (Lines{"0.0", "3.0\t0.0\t0.0", "3.0"}));
}

TEST_F(AttractionScript, CanBeChanged) {
  const Lines lines = lines_of(kBinary +
                               "local pull = attract{ strength = 0 }\n"
                               "pull.strength, pull.power, pull.softening = 2, -1, 0.5\n"
                               "print(pull.strength, pull.power, pull.softening)\n");
  EXPECT_EQ(lines, Lines{"2.0\t-1.0\t0.5"});
}

TEST_F(AttractionScript, GoesBackWithTheDemo) {
  Demo demo = load(kBinary +
                   "local pull = attract{ strength = 0.25 }\n"
                   "at(0.4, function() pull.strength = 1 end)\n"
                   "at(0.7, function() pull:remove() end)\n");
  std::vector<std::uint64_t> hashes;
  std::optional<DemoState> middle;
  while (demo.steps_done() < demo.total_steps()) {
    if (demo.steps_done() == 20) middle = demo.save();
    demo.step();
    hashes.push_back(demo.world().state_hash());
  }
  demo.restore(*middle);
  for (std::size_t i = 20; i < hashes.size(); ++i) {
    demo.step();
    EXPECT_EQ(demo.world().state_hash(), hashes[i]) << i;
  }
}

TEST_F(AttractionScript, SaysWhatIsWrong) {
  const std::string two =
      "local a, b = disc{ radius = 1, mass = 1 }, disc{ at = {3, 0}, radius = 1, mass = 1 } ";
  EXPECT_EQ(error_of("attract{}"), "arch.lua:2: attract: strength expected a number, got nothing");
  EXPECT_EQ(error_of(two + "attract{ strength = 1, bodies = a }"),
            "arch.lua:2: attract: bodies expected a list of bodies, got a body");
  EXPECT_EQ(error_of(two + "attract{ strength = 1, bodies = {a, 3} }"),
            "arch.lua:2: attract: bodies[2] expected a body, got the number 3");
  EXPECT_EQ(error_of(two + "attract{ strength = 1, bodies = {a} }"),
            "arch.lua:2: attract: bodies expected two or more, got 1");
  EXPECT_EQ(error_of(two + "attract{ strength = 1, bodies = {a, b}, weights = {1} }"),
            "arch.lua:2: attract: weights expected one for each of 2 bodies, got 1");
  EXPECT_EQ(error_of(two + "attract{ strength = 1, weights = {1, 2} }"),
            "arch.lua:2: attract: weights expected one for each of 0 bodies, got 2");
  EXPECT_EQ(error_of(two + "attract{ strength = 1, softening = -1 }"),
            "arch.lua:2: attract: softening must be at least 0, got -1");
  EXPECT_EQ(
      error_of(
          two +
          "local s = disc{ radius = 1, type = 'static', mass = 9 } attract{ strength = 1, bodies = {a, s} }"),
      "arch.lua:2: attract: bodies[2] is not dynamic and has no mass; give weights");
  EXPECT_EQ(error_of(two + "attract{ strength = 1 }.softening = -1"),
            "arch.lua:2: attraction: softening must be at least 0, got the number -1");
  EXPECT_EQ(error_of(two + "attract{ strength = 1, mass = 2 }").substr(0, 33),
            "arch.lua:2: attract: no argument ");
  EXPECT_EQ(error_of(two + "attract{ strength = 1 }.charge = 3"),
            "arch.lua:2: attraction: \"charge\" cannot be set; these can: strength, power, softening");
  EXPECT_EQ(error_of(two + "local p = attract{ strength = 1 } p:remove() print(p.energy)"),
            "arch.lua:2: attraction: it was removed");
  EXPECT_EQ(error_of("disc{ radius = 0.1, mass = 1, group = -1 }\n"
                     "disc{ at = {1e-110, 0}, radius = 0.1, mass = 1, group = -1 }\n"
                     "attract{ strength = 1, power = 3 }")
                .substr(0, 60),
            "arch.lua:4: attract: PairForces::apply: force between bodies");
}

}  // namespace attraction_script_test
}  // namespace skerry::sandbox
