// SPDX-License-Identifier: MIT
//
// Bridges under trains: loads by place, slack cables, breaking members, bodies that take over.
#include "physics/statics/bridge.h"

#include <cmath>
#include <gtest/gtest.h>
#include <stdexcept>

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

}  // namespace bridge_test
}  // namespace skerry::statics::test
