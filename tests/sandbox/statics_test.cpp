// SPDX-License-Identifier: MIT
//
// Statics in the sandbox: agreement with the step in every resting demo, `skerry analyze`, the bridge of
// scripts.
#include <cmath>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <map>
#include <tuple>

#include "physics/statics/limit_load.h"
#include "physics/statics/rest.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "tests/sandbox/temporary.h"

namespace skerry::sandbox {
namespace {

using statics::RestAnalysis;
using statics::RestContact;
using testing::HasSubstr;

using PointKey = std::tuple<std::uint32_t, std::uint32_t, std::uint32_t>;

/// Normal and friction force of each contact point of the last step.
std::map<PointKey, Vec2> step_forces(const World& world) {
  std::map<PointKey, Vec2> forces;
  const double h = world.report().h;
  for (const ContactReport& contact : world.report().contacts_list) {
    for (int k = 0; k < contact.count; ++k) {
      const ContactPointReport& point = contact.points[static_cast<std::size_t>(k)];
      forces[{contact.shape_a.index, contact.shape_b.index, point.feature}] = {point.normal_impulse / h,
                                                                               point.friction_impulse / h};
    }
  }
  return forces;
}

/// Compares statics with the last step. @return number of contact points compared
int compare(const World& world, const std::string& name) {
  for (std::size_t i = 0; i < world.bodies().size(); ++i) {
    if (!world.bodies().alive[i] || world.bodies().type[i] != BodyType::Dynamic) continue;
    if (length(world.bodies().velocity[i]) > 1e-10 || std::abs(world.bodies().omega[i]) > 1e-10) return 0;
  }
  const RestAnalysis rest = statics::analyse_rest(world);
  if (!rest.stands) return 0;
  const std::map<PointKey, Vec2> forces = step_forces(world);
  double largest = 0;
  for (const RestContact& contact : rest.contacts) largest = std::max(largest, contact.normal_force);
  // Scripts may have pushed during the step; then its forces carry more than statics knows of.
  std::vector<Vec2> sum(rest.bodies.size());
  const auto add = [&](BodyId body, Vec2 force) {
    for (std::size_t k = 0; k < rest.bodies.size(); ++k)
      if (rest.bodies[k] == body) sum[k] += force;
  };
  for (const ContactReport& contact : world.report().contacts_list) {
    for (int k = 0; k < contact.count; ++k) {
      const ContactPointReport& point = contact.points[static_cast<std::size_t>(k)];
      const Vec2 force = point.normal_impulse / world.report().h * contact.normal +
                         point.friction_impulse / world.report().h * perp(contact.normal);
      add(contact.body_b, force);
      add(contact.body_a, -force);
    }
  }
  for (const JointRecord& joint : world.joints()) {
    if (!joint.alive) continue;
    add(joint.def.b, joint.impulse / world.report().h);
    add(joint.def.a, -(joint.impulse / world.report().h));
  }
  for (std::size_t k = 0; k < rest.bodies.size(); ++k)
    if (length(sum[k] + Vec2{rest.load[k][0], rest.load[k][1]}) > 1e-9 * (1 + largest)) return 0;

  int compared = 0;
  for (const RestContact& contact : rest.contacts) {
    if (!contact.normal_unique || !(contact.normal_force > 1e-9 * largest)) continue;
    const auto found = forces.find({contact.shape_a.index, contact.shape_b.index, contact.feature});
    if (found == forces.end()) continue;  // a gap that the step left out of its solve
    EXPECT_NEAR(found->second.x, contact.normal_force, 1e-9 * (1 + largest)) << name;
    ++compared;
  }
  return compared;
}

TEST(Statics, AgreesWithTheStepOnContactForcesOfEveryRestingDemo) {
  int points = 0, demos = 0;
  for (const DemoFile& file : find_demos(demo_tree())) {
    Demo demo(file.path, {});
    // Large ones are too slow for this test, and their forces are not unique.
    if (demo.world().bodies().size() > 150 || demo.total_steps() > 2000) continue;
    demo.observe({.contacts = true});
    while (demo.steps_done() < demo.total_steps()) demo.step();
    const int compared = compare(demo.world(), file.name);
    points += compared;
    demos += compared > 0;
  }
  EXPECT_GE(demos, 2);
  EXPECT_GE(points, 10);
  RecordProperty("demos", demos);
  RecordProperty("points", points);
}

TEST(Analyze, StackStandsWithItsMarginAndForces) {
  const Outcome outcome = run({"analyze", "stack", "--demos", demo_tree()});
  EXPECT_EQ(outcome.code, kGood) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("stack: stands (5 bodies, 10 contact points"));
  if (statics::limit_load_available()) {
    // Five boxes 1.4 m wide and 5 m high tip together at 1.4 / 5.
    EXPECT_THAT(outcome.out, HasSubstr("margin: 0.28 g sideways"));
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

}  // namespace
}  // namespace skerry::sandbox
