// SPDX-License-Identifier: MIT
//
// Bridges under trains: loads by place, slack cables, breaking members, bodies that take over.
#include "physics/statics/bridge.h"

#include <cmath>
#include <gtest/gtest.h>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "tests/statics/bridges.h"

namespace skerry::statics::test {
namespace bridge_test {

TEST(Bridge, EachMomentIsTheSumOfItsInfluenceLine) {
  World world;
  Bridge bridge(truss_bridge(6), world);
  for (int step = 1; step <= 60; ++step) {
    world.step(1.0 / 15);
    bridge.advance(world, world.time());
    if (step % 10 != 0) continue;
    for (int m = 0; m < static_cast<int>(bridge.members().size()); ++m) {
      double sum = 0;
      double x = -1 + 4 * world.time();
      sum += 1e5 * bridge.influence_at({Quantity::Kind::Axial, m}, x);
      sum += 8e4 * bridge.influence_at({Quantity::Kind::Axial, m}, x - 1.5);
      StructureSolver own(bridge.def().structure);
      sum += own.solve(self_weight(bridge.def().structure)).members[static_cast<std::size_t>(m)].axial;
      EXPECT_NEAR(bridge.members()[static_cast<std::size_t>(m)].axial, sum, 1e-9 * 1e5) << m;
    }
  }
  EXPECT_FALSE(bridge.moving());
  EXPECT_TRUE(bridge.breaks().empty());
}

TEST(Bridge, OverloadedMemberBreaksAndTheMechanismFalls) {
  BridgeDef def = truss_bridge(6);
  def.structure.members.back().area = 1e-4;
  def.ground = -4;
  World world;
  Bridge bridge(def, world);
  for (int step = 1; step <= 200 && !bridge.moving(); ++step) {
    world.step(1.0 / 60);
    bridge.advance(world, world.time());
  }
  ASSERT_TRUE(bridge.moving());
  EXPECT_EQ(bridge.breaks().front().member, static_cast<int>(def.structure.members.size()) - 1);
  EXPECT_NE(bridge.determinacy().sentence().find("mechanism: node"), std::string::npos);
  // Both halves hang on their nodes, and the bridge goes down.
  EXPECT_EQ(bridge.pieces().size(), def.structure.members.size() + 1);
  double lowest = 0;
  for (int step = 0; step < 60; ++step) {
    world.step(1.0 / 60);
    bridge.advance(world, world.time());
  }
  for (const BridgePiece& piece : bridge.pieces()) {
    lowest = std::min(lowest, world.position(piece.body).y);
    EXPECT_TRUE(is_finite(world.position(piece.body)));
  }
  EXPECT_LT(lowest, -0.2);
  EXPECT_EQ(world.report().contained, 0);
}

// Pieces, wagons and bearings, in any order, until nothing is left.
TEST(Bridge, PartsOfABridgeInMotionMayBeRemoved) {
  BridgeDef def = truss_bridge(4);
  def.structure.members.back().area = 1e-4;
  def.ground = -4;
  for (const std::size_t stride : {1u, 3u, 7u}) {
    World world;
    Bridge bridge(def, world);
    for (int step = 1; step <= 200 && !bridge.moving(); ++step) {
      world.step(1.0 / 60);
      bridge.advance(world, world.time());
    }
    ASSERT_TRUE(bridge.moving());
    std::size_t next = 0;
    for (int removed = 0; removed < 60; ++removed) {
      std::vector<BodyId> loose;
      for (std::size_t i = 0; i < world.bodies().size(); ++i)
        if (world.bodies().alive[i] && world.bodies().type[i] == BodyType::Dynamic)
          loose.push_back(world.body_id(i));
      if (loose.empty()) break;
      world.destroy(loose[(next += stride) % loose.size()]);
      world.step(1.0 / 60);
      ASSERT_NO_THROW(bridge.advance(world, world.time())) << stride << ", " << removed;
    }
    EXPECT_EQ(bridge.pieces().size(), 0u) << stride;
    EXPECT_TRUE(bridge.wagons().empty()) << stride;
  }
}

TEST(Bridge, DynamicBridgeAtRestCarriesItsWeightLikeTheStaticOne) {
  // Without a train the rods stand still; hinge forces of heavy rods are those of half weights at the nodes.
  BridgeDef def = truss_bridge(4);
  def.train = {};
  World world_a, world_b;
  Bridge still(def, world_a);
  def.dynamic = true;
  Bridge moving(def, world_b);
  EXPECT_TRUE(moving.moving());
  still.advance(world_a, 0);
  for (int step = 0; step < 5; ++step) {
    world_b.step(1.0 / 240);
    moving.advance(world_b, world_b.time());
  }
  for (std::size_t m = 0; m < still.members().size(); ++m)
    EXPECT_NEAR(moving.members()[m].axial, still.members()[m].axial, 1e-6 * 1e4) << m;
}

TEST(Bridge, CableThatWouldPushIsSlack) {
  // A beam on two supports with cables to a mast below and above: only the upper one carries.
  BridgeDef def;
  def.structure = continuous_beam({0, 5, 10});
  def.structure.supports = {{0}, {2, SupportKind::Roller}};
  def.structure.nodes.push_back({{5, 4}});
  def.structure.nodes.push_back({{5, -4}});
  def.structure.supports.push_back({3});
  def.structure.supports.push_back({4});
  for (const int end : {3, 4}) {
    Member cable{1, end, MemberKind::Bar, 2e11, 1e-3};
    cable.cable = true;
    def.structure.members.push_back(cable);
  }
  def.deck = {0, 1, 2};
  def.train = {{1e5}, {}, 1, 5};
  def.thickness = 0.2;
  World world;
  Bridge bridge(def, world);
  bridge.advance(world, 0);
  EXPECT_GT(bridge.members()[2].axial, 0);
  EXPECT_EQ(bridge.members()[3].axial, 0);
  EXPECT_TRUE(bridge.members()[3].slack);
  // Spring of the beam 48 E I / L^3 beside that of one cable.
  const double beam = 48 * 2e11 * 3e-4 / 1000, cable = 2e11 * 1e-3 / 4;
  EXPECT_NEAR(bridge.members()[2].axial, 1e5 * cable / (beam + cable), 1e-6);
}

TEST(Bridge, AxlesAreAtTheirDistanceAlongAnInclinedDeck) {
  // Up 10 m and down 10 m, each over 6 m of ground.
  BridgeDef def;
  def.structure.nodes = {{{0, 0}}, {{6, 8}}, {{12, 0}}};
  def.structure.members = {{0, 1}, {1, 2}, {0, 2}};
  def.structure.supports = {{0}, {2, SupportKind::Roller}};
  def.deck = {0, 1, 2};
  def.train = {{1e5, 1e5}, {11}, 0, 16};
  World world;
  const Bridge bridge(def, world);
  const std::vector<Bridge::Axle> axles = bridge.axles();
  ASSERT_EQ(axles.size(), 2u);
  EXPECT_NEAR(axles[0].station, 16, 1e-12);
  EXPECT_NEAR(axles[1].station, 5, 1e-12);
  EXPECT_NEAR(length(axles[0].at - Vec2{9.6, 3.2}), 0, 1e-12);
  EXPECT_NEAR(length(axles[1].at - Vec2{3, 4}), 0, 1e-12);
  // The line is read where they are.
  double sum = 0;
  for (const Bridge::Axle& axle : axles)
    sum += axle.load * bridge.influence_at({Quantity::Kind::Axial, 2}, axle.station);
  EXPECT_NEAR(sum, bridge.members()[2].axial, 1e-6);
}

TEST(Bridge, WrongDecksAndTrainsAreRefused) {
  World world;
  BridgeDef def = truss_bridge(4);
  def.deck = {0, 2};
  EXPECT_THROW(Bridge(def, world), std::invalid_argument);
  def = truss_bridge(4);
  def.train.gaps.clear();
  EXPECT_THROW(Bridge(def, world), std::invalid_argument);
  def = truss_bridge(4);
  def.train.axles[0] = -1;
  EXPECT_THROW(Bridge(def, world), std::invalid_argument);
  def = truss_bridge(4);
  def.thickness = 0;
  EXPECT_THROW(Bridge(def, world), std::invalid_argument);
}

TEST(Bridge, WhatIsRefusedLeavesNothingInTheWorld) {
  World world;
  const BodyId own = world.create_body({.type = BodyType::Static});
  const auto refused = [&](const auto& spoil, const std::string& why) {
    for (const bool dynamic : {false, true}) {
      BridgeDef def = truss_bridge(4);
      def.ground = -5;
      def.dynamic = dynamic;
      spoil(def);
      try {
        Bridge bridge(def, world);
        ADD_FAILURE() << "accepted: " << why;
      } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
      }
      for (std::size_t i = 0; i < world.bodies().size(); ++i)
        EXPECT_EQ(world.bodies().alive[i] != 0, i == own.index) << "body " << i << ": " << why;
    }
  };
  refused([](BridgeDef& def) { def.train.speed = kInfinity; }, "train: speed must be finite, got inf");
  refused([](BridgeDef& def) { def.train.start = -kInfinity; }, "train: start must be finite, got -inf");
  refused([](BridgeDef& def) { def.train.axles[0] = kInfinity; }, "train: axles must be finite, got inf");
  refused([](BridgeDef& def) { def.train.wheel_radius = kInfinity; },
          "train: wheel_radius must be finite, got inf");
  refused([](BridgeDef& def) { def.thickness = kInfinity; }, "bridge: thickness must be finite, got inf");
  refused([](BridgeDef& def) { def.ground = -kInfinity; }, "bridge: ground must be finite, got -inf");
  // Finite, but no size of a shape.
  refused([](BridgeDef& def) { def.train.wheel_radius = 1e13; }, "1e");
  refused([](BridgeDef& def) { def.thickness = 1e13; }, "1e");
}

TEST(Bridge, MembersOfTheDeckMayRunEitherWay) {
  BridgeDef def = truss_bridge(4);
  World world_a, world_b;
  Bridge there(def, world_a);
  for (std::size_t m = 0; m < 4; ++m) std::swap(def.structure.members[m].a, def.structure.members[m].b);
  Bridge back(def, world_b);
  for (const double time : {0.5, 0.7, 1.1, 1.6}) {
    there.advance(world_a, time);
    back.advance(world_b, time);
    for (std::size_t m = 0; m < there.members().size(); ++m)
      EXPECT_NEAR(there.members()[m].axial, back.members()[m].axial, 1e-6) << time << " s, member " << m;
  }
}

TEST(Bridge, LoadsOnASlackCableHangOnItsNodes) {
  BridgeDef def;
  def.structure.nodes = {{{0, 0}}, {{4, 0}}, {{2, 3}}, {{2, -4}}};
  def.structure.members = {{0, 2}, {1, 2}, {2, 3}};
  for (Member& m : def.structure.members) {
    m.area = 1e-3;
    m.modulus = 2e11;
  }
  def.structure.members[2].cable = true;
  def.structure.supports = {{0}, {1}, {3}};
  def.fixed.spans = {{2, 0.25, {1000, -2000}}};
  def.fixed.lines = {{2, {0, -100}}};
  World world;
  const Bridge bridge(def, world);
  ASSERT_TRUE(bridge.members()[2].slack);
  const std::vector<Reaction>& reactions = bridge.response().reactions;
  Vec2 sum;
  for (const Reaction& reaction : reactions) sum += reaction.force;
  EXPECT_NEAR(sum.x, -1000, 1e-9);
  EXPECT_NEAR(sum.y, 2000 + 7 * 100, 1e-9);
  EXPECT_NEAR(reactions[2].force.x, -0.25 * 1000, 1e-9);
  EXPECT_NEAR(reactions[2].force.y, 0.25 * 2000 + 350, 1e-9);
}

TEST(Bridge, ACableThatIsGivenAsABeamDoesNotBend) {
  BridgeDef def;
  def.structure.nodes = {{{0, 0}}, {{4, 0}}};
  def.structure.members = {{0, 1, MemberKind::Beam, 2e11, 1e-3}};
  def.structure.members[0].second_moment = 1e-4;
  def.structure.members[0].cable = true;
  def.structure.supports = {{0, SupportKind::Fixed}, {1, SupportKind::Fixed}};
  def.fixed.lines = {{0, {0, -1000}}};
  World world;
  const Bridge bridge(def, world);
  for (const Reaction& reaction : bridge.response().reactions) {
    EXPECT_EQ(reaction.moment, 0);
    EXPECT_NEAR(reaction.force.y, 2000, 1e-9);
  }
}

/// A square with both diagonals whose lower side is the deck, pulled at its lower right corner.
BridgeDef braced_square(double pull) {
  BridgeDef def;
  def.structure.nodes = {{{0, 0}}, {{4, 0}}, {{0, 3}}, {{4, 3}}};
  def.structure.members = {{0, 1}, {0, 2}, {1, 3}, {2, 3}, {0, 3}, {1, 2}};
  for (Member& m : def.structure.members) {
    m.area = 1e-3;
    m.modulus = 2e11;
    m.strength = 2e8;
  }
  def.structure.supports = {{0}, {1, SupportKind::Roller}};
  def.deck = {0, 1};
  def.fixed.nodes = {{1, {pull, 0}}};
  return def;
}

TEST(Bridge, WithoutATrainADeckMayBreakAndTheRestStands) {
  BridgeDef def = braced_square(1e4);
  def.structure.members[0].strength = 1e6;
  World world;
  Bridge bridge(def, world);
  bridge.advance(world, 0.1);
  ASSERT_EQ(bridge.breaks().size(), 1u);
  EXPECT_EQ(bridge.breaks()[0].member, 0);
  EXPECT_FALSE(bridge.moving());
  EXPECT_TRUE(bridge.determinacy().stable());
}

TEST(Bridge, UseHasTheSignOfTheForce) {
  for (const double side : {1.0, -1.0}) {
    World world;
    Bridge bridge(braced_square(side * 1e4), world);
    bridge.advance(world, 0.1);
    EXPECT_GT(side * bridge.members()[0].axial, 0) << side;
    EXPECT_GT(side * bridge.members()[0].signed_use, 0) << side;
    EXPECT_GT(side * bridge.members()[0].peak_use, 0) << side;
  }
}

TEST(Bridge, WeightsFollowTheGravityOfTheWorld) {
  World world;
  BridgeDef def = truss_bridge(4);
  def.train.start = 3;
  def.train.speed = 0;
  Bridge bridge(def, world);
  bridge.advance(world, 0.1);
  const std::vector<MemberState> before = bridge.members();
  EXPECT_NEAR(bridge.axles()[0].load, 1e5, 1e-9);
  world.set_gravity({0, -9.81 / 6});
  bridge.advance(world, 0.2);
  EXPECT_NEAR(bridge.axles()[0].load, 1e5 / 6, 1e-9);
  for (std::size_t m = 0; m < before.size(); ++m)
    EXPECT_NEAR(bridge.members()[m].axial, before[m].axial / 6, 1e-6) << m;
  world.set_gravity({9.81, 0});
  bridge.advance(world, 0.3);
  Vec2 sum;
  for (const Reaction& reaction : bridge.response().reactions) sum += reaction.force;
  EXPECT_LT(sum.x, -1.8e5 * 0.999);
  EXPECT_NEAR(sum.y, 0, 1e-6);
}

Aabb box_of(const World& world, BodyId body) {
  Aabb box{{kInfinity, kInfinity}, {-kInfinity, -kInfinity}};
  for (const ShapeRecord& shape : world.shapes())
    if (shape.alive && shape.body == body) box = united(box, bounding_box(shape.shape, world.pose(body)));
  return box;
}

TEST(Bridge, PiersReachUpToTheirPlatesAndNoneIsInABankOrBelowTheGround) {
  BridgeDef def = truss_bridge(4);
  def.ground = -4;
  // An anchor far in the left bank.
  def.structure.nodes.push_back({{-10, 0}});
  def.structure.supports.push_back({static_cast<int>(def.structure.nodes.size()) - 1});
  World world;
  const Bridge bridge(def, world);
  const std::vector<BodyId> piers = bodies_named(world, "pier"),
                            plates = bodies_named(world, "bearing plate");
  ASSERT_EQ(piers.size(), 2u);
  ASSERT_EQ(plates.size(), 1u);
  const Aabb plate = box_of(world, plates[0]);
  for (const BodyId pier : piers) {
    const Aabb box = box_of(world, pier);
    EXPECT_NEAR(box.lower.y, -4, 1e-12);
    if (box.lower.x < plate.upper.x && box.upper.x > plate.lower.x) {
      EXPECT_NEAR(box.upper.y, plate.lower.y, 1e-12);
    }
  }
  def = truss_bridge(4);
  def.ground = 0.5;
  World flat;
  const Bridge low(def, flat);
  EXPECT_TRUE(bodies_named(flat, "pier").empty());
}

TEST(Bridge, WheelsStandOnTheirAxles) {
  // On a slope, with three wagons, the last of one axle.
  BridgeDef def;
  def.structure.nodes = {{{0, 0}}, {{20, 8}}, {{40, 8}}};
  def.structure.members = {{0, 1}, {1, 2}, {0, 2}};
  for (Member& m : def.structure.members) {
    m.area = 0.1;
    m.modulus = 2e11;
  }
  def.structure.supports = {{0}, {2, SupportKind::Roller}};
  def.deck = {0, 1, 2};
  def.train = {{1e5, 8e4, 6e4, 7e4, 5e4}, {2, 3, 1.5, 2.5}, 4, 15};
  World world;
  Bridge bridge(def, world);
  const Vec2 lift{0, 0.5 * def.thickness + def.train.wheel_radius};
  for (const double time : {0.0, 0.2, 0.4}) {
    if (time > 0) bridge.advance(world, time);
    const std::vector<Vec2> at = wheels(world, bridge);
    const std::vector<Bridge::Axle> axles = bridge.axles();
    ASSERT_EQ(at.size(), 5u);
    for (std::size_t i = 0; i < 5; ++i)
      EXPECT_NEAR(length(at[i] - lift - axles[i].at), 0, 1e-9) << time << " s, axle " << i;
  }
}

}  // namespace bridge_test
}  // namespace skerry::statics::test
