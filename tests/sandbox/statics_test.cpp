// SPDX-License-Identifier: MIT
//
// Statics in the sandbox: agreement with the step in every resting demo, `skerry analyze`, the bridge of
// scripts.
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <iostream>
#include <map>

#include "physics/statics/limit_load.h"
#include "physics/statics/rest.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace statics_test {

using statics::RestAnalysis;
using statics::RestContact;
using testing::Eq;
using testing::HasSubstr;
using testing::Not;

using statics::PairForce;

/// True if every dynamic body of the world stands still.
bool is_still(const World& world) {
  bool any = false;
  for (std::size_t i = 0; i < world.bodies().size(); ++i) {
    if (!world.bodies().alive[i] || world.bodies().type[i] != BodyType::Dynamic) continue;
    if (length(world.bodies().velocity[i]) > 1e-10 || std::abs(world.bodies().omega[i]) > 1e-10) return false;
    any = true;
  }
  return any;
}

/// Loads that the step knew: a script's pushes are gone when statics looks, those of a field it does not
/// know.
/// @return the largest force on a body that the step's contacts and joints do not balance, over `scale`
double missing_balance(const World& world, const RestAnalysis& rest, double scale) {
  const double h = world.report().h;
  std::map<std::uint32_t, Vec2> sum;
  for (std::size_t k = 0; k < rest.bodies.size(); ++k)
    sum[rest.bodies[k].index] = {rest.load[k][0], rest.load[k][1]};
  const auto add = [&](BodyId body, Vec2 force) {
    const auto found = sum.find(body.index);
    if (body && found != sum.end()) found->second += force;
  };
  for (const ContactReport& contact : world.report().contacts_list) {
    for (int k = 0; k < contact.count; ++k) {
      const ContactPointReport& point = contact.points[static_cast<std::size_t>(k)];
      const Vec2 force =
          point.normal_impulse / h * contact.normal + point.friction_impulse / h * perp(contact.normal);
      add(contact.body_b, force);
      add(contact.body_a, -force);
    }
  }
  for (const JointRecord& joint : world.joints()) {
    if (!joint.alive) continue;
    add(joint.def.b, joint.impulse / h);
    add(joint.def.a, -(joint.impulse / h));
  }
  double worst = 0;
  for (const auto& [body, force] : sum) worst = std::max(worst, length(force));
  return worst / scale;
}

/// What the last step says of one pair of shapes: normal and friction force of each point, by place.
struct StepPoint {
  Vec2 position;
  double normal = 0, friction = 0;
};
using PairKey = std::pair<std::uint32_t, std::uint32_t>;
std::map<PairKey, std::vector<StepPoint>> step_points(const World& world) {
  std::map<PairKey, std::vector<StepPoint>> points;
  const double h = world.report().h;
  for (const ContactReport& contact : world.report().contacts_list) {
    for (int k = 0; k < contact.count; ++k) {
      const ContactPointReport& point = contact.points[static_cast<std::size_t>(k)];
      points[{contact.shape_a.index, contact.shape_b.index}].push_back(
          {point.position, point.normal_impulse / h, point.friction_impulse / h});
    }
  }
  return points;
}

/// How much of a demo was compared.
struct Compared {
  int points = 0, pairs = 0, joints = 0, bodies = 0;
};

/// Compares statics with the last step, all in shares of the largest contact force.
Compared compare(const World& world, const std::string& name) {
  constexpr double kAgrees = 1e-9;
  Compared compared;
  const auto points = step_points(world);
  double scale = 1;
  for (const auto& [key, list] : points)
    for (const StepPoint& point : list) scale = std::max(scale, point.normal);

  // 1. All forces, with the choice that statics documents: the forces of the last step are a solution of its
  // own equations, and stay what they are.
  const RestAnalysis kept = statics::analyse_rest(world);
  if (!kept.stands || missing_balance(world, kept, scale) > kAgrees) return compared;
  if (kept.lambda.empty()) return compared;
  EXPECT_TRUE(kept.from_last_step) << name;
  compared.bodies = static_cast<int>(kept.bodies.size());
  for (const RestContact& contact : kept.contacts) {
    const auto found = points.find({contact.shape_a.index, contact.shape_b.index});
    if (found == points.end()) {
      ADD_FAILURE() << name << ": a touching pair that the step does not know";
      continue;
    }
    const StepPoint* nearest = nullptr;
    for (const StepPoint& point : found->second) {
      if (!nearest ||
          length(point.position - contact.position) < length(nearest->position - contact.position))
        nearest = &point;
    }
    EXPECT_NEAR(nearest->normal, contact.normal_force, kAgrees * scale) << name;
    EXPECT_NEAR(nearest->friction, contact.friction_force, kAgrees * scale) << name;
    ++compared.points;
  }
  for (const statics::RestJoint& joint : kept.joints) {
    const Vec2 force = world.joints()[joint.slot].impulse / world.report().h;
    EXPECT_LE(length(joint.force - force), kAgrees * scale) << name << ", joint " << joint.slot;
    ++compared.joints;
  }

  // 2. From nothing: what equilibrium alone decides must come out alike.
  statics::RestOptions cold;
  cold.last_step = false;
  const RestAnalysis rest = statics::analyse_rest(world, cold);
  EXPECT_TRUE(rest.stands) << name;
  const std::vector<PairForce> resultants = statics::pair_forces(rest), same = statics::pair_forces(kept);
  EXPECT_EQ(resultants.size(), same.size());
  for (std::size_t k = 0; k < resultants.size(); ++k) {
    if (!resultants[k].unique) continue;
    EXPECT_LE(length(resultants[k].force - same[k].force), kAgrees * scale) << name << ", pair " << k;
    if (resultants[k].normal > 1e-6 * scale) {
      EXPECT_LE(length(resultants[k].at - same[k].at) * resultants[k].normal, kAgrees * scale)
          << name << ", pair " << k;
    }
    ++compared.pairs;
  }
  for (std::size_t k = 0; k < rest.contacts.size(); ++k) {
    const RestContact& one = rest.contacts[k];
    const RestContact& two = kept.contacts[k];
    if (one.normal_unique) {
      EXPECT_NEAR(one.normal_force, two.normal_force, kAgrees * scale) << name;
    }
    if (one.friction_unique) {
      EXPECT_NEAR(one.friction_force, two.friction_force, kAgrees * scale) << name;
    }
  }
  for (std::size_t k = 0; k < rest.joints.size(); ++k) {
    if (rest.joints[k].unique) {
      EXPECT_LE(length(rest.joints[k].force - kept.joints[k].force), kAgrees * scale) << name;
    }
  }
  return compared;
}

/// A quarter of the demos each: new ones are found when the test runs.
class StaticsOfDemos : public testing::TestWithParam<std::size_t> {
 public:
  static constexpr std::size_t kParts = 4;
};

TEST_P(StaticsOfDemos, AgreeWithTheStepOnEveryForceWhereTheDemoRests) {
  const std::vector<DemoFile> files = find_demos(demo_tree());
  int resting = 0;
  for (std::size_t i = GetParam(); i < files.size(); i += kParts) {
    Demo demo(files[i].path, {});
    demo.observe({.contacts = true});
    Compared most;
    // At the end, and on the way: many demos rest for a while.
    while (demo.steps_done() < demo.total_steps()) {
      demo.step();
      const bool end = demo.steps_done() == demo.total_steps();
      if ((!end && demo.steps_done() % 60 != 30) || !is_still(demo.world())) continue;
      const Compared now = compare(demo.world(), files[i].name);
      if (now.bodies >= most.bodies) most = now;
    }
    resting += most.bodies > 0;
    if (most.bodies > 0)
      std::cout << files[i].name << ": " << most.bodies << " bodies, " << most.points << " points, "
                << most.pairs << " resultants, " << most.joints << " joints\n";
  }
}
INSTANTIATE_TEST_SUITE_P(Part, StaticsOfDemos, testing::Range(std::size_t{0}, StaticsOfDemos::kParts));

TEST(Analyze, StackStandsWithItsMarginAndForces) {
  const Outcome outcome = run({"analyze", "stack", "--demos", demo_tree()});
  EXPECT_EQ(outcome.code, kGood) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("stack: stands (5 bodies, 10 contact points"));
  if (statics::limit_load_available()) {
    // Five boxes 1.4 m wide and 5 m high tip together at 1.4 / 5.
    EXPECT_THAT(outcome.out, HasSubstr("margin: 28 % of gravity sideways"));
  }
}

TEST(Analyze, TellsWhatSlidesTipsAndFalls) {
  const TemporaryFolder folder;
  const auto fate = [&](const std::string& body) {
    const std::string path = folder.write("scene.lua", "demo{ title = \"x\" }\n" + body);
    return run({"analyze", path}).out;
  };
  EXPECT_THAT(fate("ground{ tilt = 0.6, friction = 0.2 }\nbox{ at = {-0.282321, 0.412668}, angle = 0.6, size "
                   "= {1, 1}, friction = 0.2 }"),
              HasSubstr("slides"));
  EXPECT_THAT(
      fate("box{ at = {0, 0}, size = {1, 1}, type = \"static\" }\nbox{ at = {0.7, 0.6}, size = {1, 0.2} }"),
      HasSubstr("tips"));
  EXPECT_THAT(fate("disc{ at = {0, 3}, radius = 1 }"), HasSubstr("falls"));
  EXPECT_THAT(fate(""), HasSubstr("nothing that could move"));
}

TEST(Analyze, TheFieldAndWhatTheScriptPushesAreAmongTheLoads) {
  const TemporaryFolder folder;
  const auto analysis = [&](const std::string& script) {
    return run({"analyze", folder.write("scene.lua", "demo{ title = \"x\", friction = 0.5, " + script)}).out;
  };
  const std::string block = "ground{}\nlocal b = box{ at = {0, 0.5}, size = {4, 1}, mass = 1 }\n";
  const std::string plain = analysis("}\n" + block);
  EXPECT_THAT(plain, HasSubstr("stands"));
  EXPECT_THAT(plain, Not(HasSubstr("among the loads")));
  // 4.5 N of 4.905 N of friction.
  const std::string pushed = analysis("}\n" + block + "on_step(function() b:force(4.5, 0) end)");
  EXPECT_THAT(pushed, HasSubstr("stands"));
  EXPECT_THAT(pushed, HasSubstr("among the loads: the forces of on_step and attract at this moment"));
  EXPECT_THAT(pushed, HasSubstr("91.7 % of its friction"));
  const std::string blown = analysis("}\n" + block + "field(function() return 4.5, 0 end)");
  EXPECT_THAT(blown, HasSubstr("among the loads: the force field, as it acts on what rests\n"));
  EXPECT_THAT(blown, HasSubstr("91.7 % of its friction"));
  EXPECT_THAT(analysis("}\n" + block + "field(function() return 4.5, 0 end)\nfield()"), Eq(plain));
  // Without gravity the field presses, and nothing has a weight.
  const std::string light =
      analysis("gravity = {0, 0} }\n" + block + "field(function(x, y, vx, vy, m) return 0, -9.81 * m end)");
  EXPECT_THAT(light, HasSubstr("stands"));
  if (statics::limit_load_available()) {
    EXPECT_THAT(light, HasSubstr("margin: none, nothing has a weight"));
  }
}

TEST(Analyze, WhatHangsOnASpringStands) {
  const TemporaryFolder folder;
  const std::string text =
      run({"analyze",
           folder.write("scene.lua",
                        "demo{ title = \"x\" }\nlocal b = box{ at = {0, -0.0981}, size = {1, 0.2}, "
                        "mass = 1 }\nspring{ from = {0, 2}, to = b, length = 2, stiffness = 100 }")})
          .out;
  EXPECT_THAT(text, HasSubstr("stands"));
  if (statics::limit_load_available()) {
    EXPECT_THAT(text, HasSubstr("weakest to the right\n"));
  }
}

TEST(Analyze, WritesJsonPictureAndInfluenceLine) {
  const TemporaryFolder folder;
  const Outcome outcome = run({"analyze", "warren_truss", "--demos", demo_tree(), "--at", "2", "--json",
                               "--influence", folder / "line.csv", "--member", "12"});
  EXPECT_EQ(outcome.code, kGood) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("\"determinacy\": \"statically determinate\""));
  EXPECT_THAT(read_file(folder / "line.csv"), HasSubstr("x [m],force per unit of load\n0,0\n"));
  EXPECT_EQ(run({"analyze", "warren_truss", "--demos", demo_tree(), "--influence", folder / "l.csv",
                 "--member", "99"})
                .code,
            kUsage);
  EXPECT_EQ(run({"analyze", "stack", "--demos", demo_tree(), "-o", "picture.bmp"}).code, kUsage);
}

TEST(BridgeScript, WrongArgumentsAreRefusedWithTheirPlace) {
  const TemporaryFolder folder;
  const auto complaint = [&](const std::string& arguments) {
    const std::string path =
        folder.write("bridge.lua", "demo{ title = \"x\" }\nbridge{ " + arguments + " }\n");
    return run({"run", path}).err;
  };
  const std::string nodes = "nodes = {{0, 0}, {1, 0, name = \"B\"}}, ";
  EXPECT_THAT(complaint(nodes + "members = {{1, 3}}"),
              HasSubstr("bridge.lua:2: bridge: members[1]: no node 3, there are 2"));
  EXPECT_THAT(complaint(nodes + "members = {{1, \"C\"}}"), HasSubstr("no node \"C\""));
  EXPECT_THAT(complaint(nodes + "members = {{1, \"B\", aera = 1}}"), HasSubstr("no argument \"aera\""));
  EXPECT_THAT(complaint(nodes + "members = {{1, 2}}, supports = {{1, \"pined\"}}"),
              HasSubstr("no kind \"pined\""));
  EXPECT_THAT(complaint(nodes + "members = {{1, 2}}, method = \"magic\""), HasSubstr("no method \"magic\""));
}

/// Two legs at 45 degrees and a tie, loaded with P at the top: P / sqrt 2 in the legs, P / 2 in the tie.
TEST(BridgeScript, SaysWhatItsMembersAndSupportsCarry) {
  const TemporaryFolder folder;
  const std::string path = folder.write("bridge.lua", R"(demo{ title = "Triangle", seconds = 0.1 }
local P, area, strength = 1000, 0.01, 2e5
local b = bridge{
  nodes = { {0, 0}, {4, 0}, {2, 2, name = "top"} }, members = { {1, 2}, {1, 3}, {2, "top"} },
  section = { area = area, modulus = 2e11, strength = strength }, supports = { {1, "pinned"}, {2, "roller"} },
  deck = {1, 2}, loads = { {"top", {0, -P}} }, train = { axles = {1e-9}, speed = 1 },
}
local function near(what, value, wanted)
  expect(what, function() return math.abs(value() / wanted - 1) end, { below = 1e-9 })
end
near("tie", function() return b:force(1) end, P / 2)
near("leg", function() return b:force(2) end, -P / math.sqrt(2))
near("stress of the tie", function() return b:stress(1) end, P / 2 / area)
near("stress of a leg", function() return b:stress(3) end, -P / math.sqrt(2) / area)
near("use of the tie", function() return b:use(1) end, P / 2 / area / strength)
near("use of a leg", function() return b:use(2) end, -P / math.sqrt(2) / area / strength)
near("peak", function() return (b:peak(2)) end, -P / math.sqrt(2) / area / strength)
near("support", function() local x, y, m = b:reaction(1) return y + x + m end, P / 2)
-- A unit load half way along the tie, on both nodes of the deck: the legs know nothing of it.
expect("influence", function() return b:influence(2, 2) end, { equals = 0, within = 1e-12 })
expect("sound", function() return b.residual end, { below = 1e-9 })
expect("whole", function() return b.members - b.breaks + (b.moving and 1 or 0) end, { equals = 3, within = 0 })
)");
  const Outcome result = run({"run", path});
  EXPECT_EQ(result.code, 0) << result.out << result.err;
  EXPECT_THAT(result.out, HasSubstr("11 of 11 checks hold"));
  const auto complaint = [&](const std::string& call) {
    const std::string broken = folder.write("broken.lua",
                                            "demo{ title = \"x\" }\nlocal b = bridge{ nodes = {{0, 0}, {1, "
                                            "0}}, members = {{1, 2}}, deck = {1, 2},\n"
                                            " section = { area = 1, modulus = 1e9, strength = 1e9 }, "
                                            "supports = {{1, \"pinned\"}, {2, \"roller\"}} }\n" +
                                                call);
    return run({"run", broken}).err;
  };
  EXPECT_THAT(complaint("b:force(2)"), HasSubstr("broken.lua:4: force: "));
  EXPECT_THAT(complaint("b:influence(1, 3)"), HasSubstr("influence: x must be from 0 to 1, got 3"));
  EXPECT_THAT(complaint("print(b.mambers)"), HasSubstr("bridge: no field \"mambers\""));
}

TEST(TrussScript, MakesDeterminateTrussesOfEveryKindAndRefusesOthers) {
  const TemporaryFolder folder;
  const auto outcome = [&](const std::string& arguments) {
    const std::string path =
        folder.write("truss.lua", "demo{ title = \"x\", seconds = 0.1 }\nlocal t = truss{ " + arguments +
                                      " }\nlocal b = bridge{ nodes = t.nodes, members = t.members, deck = "
                                      "t.deck, supports = t.supports }\nexpect(b.determinacy .. \", \" .. "
                                      "#t.lower + #t.upper + #t.diagonals + #t.posts + #t.ends, function() "
                                      "return b.members end, { above = 0 })\n");
    const Outcome result = run({"run", path});
    return result.out + result.err;
  };
  // 2 nodes - 3 members.
  EXPECT_THAT(outcome("kind = \"warren\", panels = 5"), HasSubstr("statically determinate, 19: 19"));
  EXPECT_THAT(outcome("kind = \"pratt\", panels = 6, side = 2"), HasSubstr("statically determinate, 21: 21"));
  EXPECT_THAT(outcome("kind = \"howe\", panels = 7, height = 3"),
              HasSubstr("statically determinate, 25: 25"));
  EXPECT_THAT(outcome("kind = \"hove\""), HasSubstr("no kind \"hove\""));
  EXPECT_THAT(outcome("panels = 2.5"), HasSubstr("panels must be a whole number from 3 to 1000, got 2.5"));
  EXPECT_THAT(outcome("side = 0"), HasSubstr("side and height must be positive"));
}

}  // namespace statics_test
}  // namespace skerry::sandbox
