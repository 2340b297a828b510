// SPDX-License-Identifier: MIT
//
// Trains over bridges that are bodies: what statics says for slow ones, momentum for fast ones, breaks.
#include <cmath>
#include <gtest/gtest.h>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "tests/statics/bridges.h"

namespace skerry::statics::test {
namespace bridge_motion_test {

/// Largest difference of member forces between a dynamic crossing and a static solve with the axles where
/// they are, over the heaviest axle, while the train is well on the bridge.
double largest_difference(double speed, double h) {
  BridgeDef def = truss_bridge(6);
  def.breaks = false;
  def.ground = -4;
  def.dynamic = true;
  def.train.speed = speed;
  def.train.start = 3;
  World world;
  Bridge bridge(def, world);
  // The same with its axles as loads at places that are set.
  StructureSolver still(def.structure);
  double worst = 0;
  const double duration = 1.2;
  for (int step = 1; step * h <= duration; ++step) {
    const std::vector<Vec2> before = wheels(world, bridge);
    world.step(h);
    bridge.advance(world, world.time());
    if (step * h < 0.5 * duration) continue;  // wheels and bearings settle
    const std::vector<Vec2> after = wheels(world, bridge);
    Load load = self_weight(def.structure);
    for (std::size_t k = 0; k < 2; ++k) {
      // Forces are means over the step. Half of the light body above the wheels goes to each.
      const double x = 0.5 * (before[k].x + after[k].x), axle = def.train.axles[k] + 0.5 * 9.81;
      const int panel = static_cast<int>(x / 2);
      load.spans.push_back({panel, x / 2 - panel, {0, -axle}});
    }
    const Response response = still.solve(load);
    for (std::size_t m = 0; m < response.members.size(); ++m)
      worst = std::max(worst, std::abs(bridge.members()[m].axial - response.members[m].axial) / 1e5);
  }
  return worst;
}

TEST(BridgeMotion, ForcesUnderASlowTrainAreTheStaticOnes) {
  EXPECT_LT(largest_difference(0.25, 1.0 / 60), 2e-6);
  EXPECT_LT(largest_difference(1, 1.0 / 240), 2e-6);
  // A fast one passes nodes within a step, whose mean then lies on both sides of the influence line's corner.
  EXPECT_LT(largest_difference(4, 1.0 / 60), 0.03);
  EXPECT_LT(largest_difference(4, 1.0 / 240), 0.0075);
}

TEST(BridgeMotion, ReactionsCarryTrainAndBridgeAtAnySpeedOnALevelDeck) {
  // Nothing moves up or down, so inertia adds nothing.
  for (const double speed : {1.0, 20.0}) {
    BridgeDef def = truss_bridge(20);
    def.ground = -4;
    def.dynamic = true;
    def.breaks = false;
    def.train.start = 4;
    def.train.speed = speed;
    World world;
    Bridge bridge(def, world);
    double weight = 1e5 + 8e4 + 9.81;  // with the light body above the wheels
    for (const LineLoad& line : self_weight(def.structure).lines)
      weight -= line.force_per_length.y * member_length(def.structure, line.member);
    for (int step = 1; step <= 120; ++step) {
      world.step(1.0 / 120);
      bridge.advance(world, world.time());
      if (step < 60) continue;
      double sum = 0;
      for (const Reaction& reaction : bridge.response().reactions) sum += reaction.force.y;
      EXPECT_NEAR(sum, weight, 2e-5 * weight) << speed << " m/s, step " << step;
    }
  }
}

/// Radius of the deck below [m].
constexpr double kCrest = 60;

TEST(BridgeMotion, CrestTakesVSquaredOverGROffTheLoad) {
  // A train at speed v over the top of a hill of radius R presses with m (g - v^2/R) in the mean.
  const double speed = 12, spread = 0.25;  // the deck reaches over +-0.25 rad in 80 straight pieces
  const int pieces = 80;
  BridgeDef def;
  for (int i = 0; i <= pieces; ++i) {
    const double angle = spread * (2.0 * i / pieces - 1);
    def.structure.nodes.push_back({{kCrest * std::sin(angle), kCrest * std::cos(angle)}});
    def.structure.supports.push_back({i});
    def.deck.push_back(i);
    if (i > 0) def.structure.members.push_back({i - 1, i, MemberKind::Bar, 2e11, 0.01});
  }
  const double axle = 1e5;
  def.train = {{axle}, {}, speed, 2};
  def.dynamic = true;
  def.breaks = false;
  World world;
  Bridge bridge(def, world);
  const BodyId wagon = bridge.wagons()[0];
  double own = 0;
  for (std::size_t i = 0; i < world.bodies().size(); ++i)
    if (world.bodies().type[i] == BodyType::Dynamic && i != wagon.index) own += world.bodies().mass[i] * 9.81;
  const double mass = world.mass(wagon), h = 1.0 / 600;
  double impulse = 0, time = 0, rise = 0, fall = 0;
  for (int step = 1; step <= 1200; ++step) {
    const double before = world.velocity(wagon).y;
    world.step(h);
    bridge.advance(world, world.time());
    const double x = world.position(wagon).x;
    if (x < -6 || x > 6) continue;
    for (const Reaction& reaction : bridge.response().reactions) impulse += (reaction.force.y) * h;
    impulse -= own * h;
    rise += world.velocity(wagon).y - before;
    time += h;
    // v^2/R towards the centre, and the slope's share along the deck.
    const double sine = x / kCrest, v = length(world.velocity(wagon));
    fall += h * (v * v / kCrest * std::sqrt(1 - sine * sine) + 9.81 * sine * sine);
  }
  ASSERT_GT(time, 0.5);
  const double mean = impulse / time;
  EXPECT_NEAR(mean, mass * (9.81 + rise / time), 1e-4 * axle);
  // About 30 kinks of the deck lie between the ends of the count, one more or less.
  EXPECT_NEAR(mean, mass * (9.81 - fall / time), 0.02 * axle);
  EXPECT_LT(mean, 0.85 * axle);
}

TEST(BridgeMotion, MemberBreaksWhereStaticsSaysAndTheRestGoesOn) {
  double broke[2] = {0, 0};
  int member[2] = {-1, -1};
  for (const bool dynamic : {false, true}) {
    BridgeDef def = truss_bridge(6);
    def.structure.members.back().area = 5e-4;
    def.train.start = 1.6;
    def.train.speed = 1;
    def.ground = -4;
    def.dynamic = dynamic;
    World world;
    Bridge bridge(def, world);
    for (int step = 1; step <= 1200 && bridge.breaks().empty(); ++step) {
      world.step(1.0 / 120);
      bridge.advance(world, world.time());
    }
    ASSERT_FALSE(bridge.breaks().empty());
    broke[dynamic] = bridge.breaks().front().time;
    member[dynamic] = bridge.breaks().front().member;
    EXPECT_TRUE(bridge.moving());
    EXPECT_GT(std::abs(bridge.breaks().front().use), 1);
    for (int step = 0; step < 90; ++step) {
      world.step(1.0 / 120);
      bridge.advance(world, world.time());
    }
    double lowest = 0;
    for (const BridgePiece& piece : bridge.pieces()) {
      ASSERT_TRUE(is_finite(world.position(piece.body)));
      lowest = std::min(lowest, world.position(piece.body).y);
    }
    EXPECT_LT(lowest, -0.2);
    EXPECT_EQ(world.report().contained, 0);
  }
  EXPECT_EQ(member[0], member[1]);
  // To a step: forces are means over it.
  EXPECT_NEAR(broke[0], broke[1], 1.5 / 120);
}

Member steel(int a, int b, MemberKind kind) {
  Member m{a, b, kind, 2.1e11, 0.01};
  m.second_moment = 1e-4;
  m.density = 7850;
  m.strength = 2.35e8;
  return m;
}

/// From a support at the left.
BridgeDef one_member(MemberKind kind, double length, SupportKind support) {
  BridgeDef def;
  def.structure.nodes = {{{0, 0}}, {{length, 0}}};
  def.structure.members = {steel(0, 1, kind)};
  def.structure.supports = {{0, support}};
  return def;
}

/// Two beams from a clamp, to the right and up.
BridgeDef corner() {
  BridgeDef def;
  def.structure.nodes = {{{0, 0}}, {{4, 0}}, {{4, 3}}};
  def.structure.members = {steel(0, 1, MemberKind::Beam), steel(1, 2, MemberKind::Beam)};
  def.structure.supports = {{0, SupportKind::Fixed}};
  return def;
}

/// A level bar whose end a cable of `strength` [Pa] joins to an anchor above or below it.
BridgeDef bar_on_a_cable(double above, double strength) {
  BridgeDef def;
  def.structure.nodes = {{{0, 0}}, {{3, 0}}, {{3, above}}};
  def.structure.members = {steel(0, 1, MemberKind::Bar), steel(1, 2, MemberKind::Bar)};
  def.structure.members[1].cable = true;
  def.structure.members[1].strength = strength;
  def.structure.supports = {{0}, {2}};
  return def;
}

void run(Bridge& bridge, World& world, int steps) {
  for (int i = 0; i < steps; ++i) {
    world.step(1.0 / 60);
    bridge.advance(world, world.time());
  }
}

int ropes(const World& world) {
  int count = 0;
  for (const JointRecord& joint : world.joints()) count += joint.alive && joint.def.kind == JointKind::Rope;
  return count;
}

/// Static forces and those of the same bridge as bodies, after a while.
void expect_alike(BridgeDef def, const std::string& what) {
  def.breaks = false;
  World world_a, world_b;
  Bridge still(def, world_a);
  still.advance(world_a, 0.01);
  ASSERT_FALSE(still.moving()) << what;
  def.dynamic = true;
  Bridge moving(def, world_b);
  for (int step = 1; step <= 60; ++step) {
    world_b.step(1.0 / 60);
    moving.advance(world_b, world_b.time());
  }
  double scale = 0;
  for (const Reaction& reaction : still.response().reactions)
    scale = std::max({scale, length(reaction.force), std::abs(reaction.moment)});
  for (std::size_t k = 0; k < def.structure.supports.size(); ++k) {
    const Reaction &one = still.response().reactions[k], &other = moving.response().reactions[k];
    EXPECT_NEAR(one.force.x, other.force.x, 1e-6 * scale) << what << ", support " << k;
    EXPECT_NEAR(one.force.y, other.force.y, 1e-6 * scale) << what << ", support " << k;
    EXPECT_NEAR(one.moment, other.moment, 1e-6 * scale) << what << ", support " << k;
  }
  for (std::size_t m = 0; m < def.structure.members.size(); ++m) {
    if (def.structure.members[m].kind != MemberKind::Bar) continue;
    EXPECT_NEAR(still.members()[m].axial, moving.members()[m].axial, 1e-6 * scale)
        << what << ", member " << m;
    EXPECT_NEAR(std::abs(moving.members()[m].axial) / def.structure.members[m].area,
                std::max(moving.members()[m].stress.tension, moving.members()[m].stress.compression), 1e-6);
  }
}

TEST(BridgeMotion, FixedSupportsHoldBeamsWhereverTheyAreAndInAnyOrder) {
  // Two beams over one support: the centre of mass lies on it.
  BridgeDef tee;
  tee.structure.nodes = {{{-4, 0}}, {{0, 0}}, {{4, 0}}};
  tee.structure.members = {steel(0, 1, MemberKind::Beam), steel(1, 2, MemberKind::Beam)};
  tee.structure.supports = {{1, SupportKind::Fixed}};
  expect_alike(tee, "tee");
  tee.fixed.nodes = {{2, {0, -1e4}, 0}, {0, {}, 500}};
  expect_alike(tee, "tee with a load");
  // A cantilever beside a bar that hangs on the same node.
  for (const bool bar_first : {true, false}) {
    BridgeDef def;
    def.structure.nodes = {{{0, 0}}, {{1, 3}}, {{4, 0}}, {{-3, 3}}};
    def.structure.members = {steel(0, 1, MemberKind::Bar), steel(0, 2, MemberKind::Beam),
                             steel(1, 3, MemberKind::Bar)};
    if (!bar_first) std::swap(def.structure.members[0], def.structure.members[1]);
    def.structure.supports = {{0, SupportKind::Fixed}, {3}};
    expect_alike(def, bar_first ? "bar first" : "beam first");
  }
}

TEST(BridgeMotion, FixedSupportsDoNotClampBars) {
  World world;
  Bridge bridge(one_member(MemberKind::Bar, 4, SupportKind::Fixed), world);
  run(bridge, world, 30);
  EXPECT_TRUE(bridge.moving());
  EXPECT_LT(world.position(bridge.pieces()[0].body).y, -0.3);
}

TEST(BridgeMotion, FixedLoadsGoOnWhenTheBridgeIsBodies) {
  BridgeDef def = truss_bridge(4);
  def.train = {};
  def.fixed.nodes = {{2, {3e4, -1e5}}};
  expect_alike(def, "node load");
  // Between the ends they act on rods by lever.
  def.fixed = {};
  def.fixed.spans = {{1, 0.25, {0, -1e5}}};
  expect_alike(def, "span load");
  def.fixed = {};
  def.fixed.lines = {{1, {0, -2e4}}};
  expect_alike(def, "line load");
}

/// Two bars with a joint in the middle that cables hold up.
BridgeDef hung_bars() {
  BridgeDef def;
  def.structure.nodes = {{{-4, 0}}, {{0, 0}}, {{4, 0}}, {{-4, 6}}, {{4, 6}}};
  for (const auto& [a, b, cable] :
       {std::tuple(0, 1, false), std::tuple(1, 2, false), std::tuple(3, 1, true), std::tuple(4, 1, true)}) {
    Member member{a, b, MemberKind::Bar, 2.1e11, 0.01};
    member.density = 7850;
    member.cable = cable;
    member.strength = 1e12;
    def.structure.members.push_back(member);
  }
  def.structure.supports = {{0}, {2, SupportKind::Roller}, {3}, {4}};
  def.fixed.nodes = {{1, {0, -1e4}}};
  return def;
}

TEST(BridgeMotion, CablesWeighOnTheBarsThatTheyHold) {
  BridgeDef def = hung_bars();
  World world, moving_world;
  Bridge still(def, world);
  still.advance(world, 0.01);
  def.dynamic = true;
  Bridge moving(def, moving_world);
  for (int i = 0; i < 120; ++i) {
    moving_world.step(1.0 / 60);
    moving.advance(moving_world, moving_world.time());
  }
  double up = 0, up_of_moving = 0;
  for (const Reaction& reaction : still.response().reactions) up += reaction.force.y;
  for (const Reaction& reaction : moving.response().reactions) up_of_moving += reaction.force.y;
  EXPECT_NEAR(up_of_moving, up, 1e-6 * up);
  for (std::size_t m = 0; m < 4; ++m)
    EXPECT_NEAR(moving.members()[m].axial, still.members()[m].axial, 1e-6 * up) << "member " << m;
}

TEST(BridgeMotion, ForcesAreNothingBeforeTheFirstStep) {
  BridgeDef def = hung_bars();
  def.dynamic = true;
  World world;
  Bridge bridge(def, world);
  bridge.advance(world, 0);
  for (const MemberState& member : bridge.members()) {
    EXPECT_EQ(member.axial, 0);
    EXPECT_EQ(member.signed_use, 0);
  }
}

TEST(BridgeMotion, AMomentOnABeamThatBreaksIsNoErrorAndOneOnAHingeIs) {
  BridgeDef def;
  def.structure.nodes = {{{0, 0}}, {{4, 0}}, {{4, 3}}, {{0, 3}}};
  def.structure.members = {steel(0, 1, MemberKind::Beam), steel(1, 2, MemberKind::Bar),
                           steel(1, 3, MemberKind::Bar)};
  def.structure.members[0].depth = 0.3;
  def.structure.supports = {{0, SupportKind::Fixed}, {2}, {3}};
  def.fixed.nodes = {{1, {}, 3e5}};
  World world;
  Bridge bridge(def, world);
  EXPECT_NO_THROW(bridge.advance(world, 0.01));
  EXPECT_EQ(bridge.breaks().size(), 1u);
  EXPECT_FALSE(bridge.moving());
  def.fixed.nodes = {{2, {}, 3e5}};
  EXPECT_THROW(Bridge(def, world), std::invalid_argument);
}

TEST(BridgeMotion, TheTrainOnABridgeThatFallsIsThereOnce) {
  BridgeDef def = truss_bridge(6);
  def.structure.members.back().area = 1e-4;
  World world;
  Bridge bridge(def, world);
  run(bridge, world, 120);
  ASSERT_TRUE(bridge.moving());
  EXPECT_EQ(bodies_named(world, "wagon").size(), bridge.wagons().size());
}

TEST(BridgeMotion, WagonsAreCoupled) {
  BridgeDef def = truss_bridge(8);
  def.train = {{1e5, 8e4, 6e4, 7e4}, {2, 3, 1.5}, 4, 10};
  def.dynamic = true;
  def.breaks = false;
  World world;
  Bridge bridge(def, world);
  ASSERT_EQ(bridge.wagons().size(), 2u);
  const auto apart = [&] {
    return length(world.position(bridge.wagons()[0]) - world.position(bridge.wagons()[1]));
  };
  const double before = apart();
  world.set_velocity(bridge.wagons()[0], {5, 0}, 0);
  run(bridge, world, 30);
  EXPECT_NEAR(apart(), before, 0.02);
}

TEST(BridgeMotion, ABeamBreaksWhereItIsBentMost) {
  // At the wall: a short stump stays there, the rest falls.
  BridgeDef def = one_member(MemberKind::Beam, 8, SupportKind::Fixed);
  def.structure.members[0].depth = 0.3;
  def.structure.members[0].strength = 1e7;
  def.fixed.lines = {{0, {0, -1e4}}};
  World world;
  Bridge bridge(def, world);
  bridge.advance(world, 0);
  ASSERT_TRUE(bridge.moving());
  ASSERT_EQ(bridge.pieces().size(), 2u);
  EXPECT_EQ(bridge.pieces()[0].to, 0.05);
  EXPECT_EQ(bridge.pieces()[1].from, 0.05);
  EXPECT_NE(bridge.pieces()[0].body, bridge.pieces()[1].body);
  // The stump carries its share of the load and of the weight.
  run(bridge, world, 2);
  const double own = world.mass(bridge.pieces()[0].body) * 9.81, share = 0.05 * 8 * 1e4;
  EXPECT_NEAR(bridge.response().reactions[0].force.y, own + share, 1e-6 * share);
}

TEST(BridgeMotion, AFrameThatIsClampedByOneOfItsBeamsIsHeld) {
  BridgeDef def = corner();
  def.structure.members.push_back(steel(2, 0, MemberKind::Beam));
  def.structure.members[2].hinge_b = true;
  def.dynamic = true;
  def.breaks = false;
  World world;
  Bridge bridge(def, world);
  run(bridge, world, 20);
  EXPECT_NEAR(length(world.velocity(bridge.pieces()[0].body)), 0, 1e-6);
  EXPECT_GT(bridge.response().reactions[0].moment, 1e4);
}

TEST(BridgeMotion, APinHoldsNoMomentOfABeam) {
  BridgeDef def = one_member(MemberKind::Beam, 6, SupportKind::Pinned);
  def.structure.supports.push_back({1, SupportKind::Roller});
  def.dynamic = true;
  World world;
  Bridge bridge(def, world);
  run(bridge, world, 20);
  const std::vector<Reaction>& reactions = bridge.response().reactions;
  EXPECT_NEAR(reactions[0].moment, 0, 1e-6);
  EXPECT_NEAR(reactions[0].force.y, reactions[1].force.y, 1e-2 * reactions[0].force.y);
  EXPECT_GT(reactions[0].force.y, 1000);
}

TEST(BridgeMotion, NothingIsSaidOfABeamInMotion) {
  BridgeDef def = one_member(MemberKind::Beam, 6, SupportKind::Fixed);
  def.fixed.nodes = {{1, {1e5, 0}}};
  def.dynamic = true;
  World world;
  Bridge bridge(def, world);
  run(bridge, world, 5);
  EXPECT_EQ(bridge.members()[0].axial, 0);
  EXPECT_EQ(bridge.members()[0].stress.utilisation, 0);
  EXPECT_TRUE(bridge.breaks().empty());
}

TEST(BridgeMotion, HalvesOfABarThatBreaksGoOnTurningAsItDid) {
  // A pendulum whose pull grows until it breaks.
  BridgeDef def = one_member(MemberKind::Bar, 3, SupportKind::Pinned);
  def.structure.members[0].strength = 1e5;
  def.fixed.nodes = {{1, {0, -1000}}};
  def.dynamic = true;
  World world;
  Bridge bridge(def, world);
  double omega = 0;
  for (int i = 0; i < 300 && bridge.breaks().empty(); ++i) {
    world.step(1.0 / 240);
    omega = world.omega(bridge.pieces()[0].body);
    bridge.advance(world, world.time());
  }
  ASSERT_EQ(bridge.pieces().size(), 2u);
  EXPECT_LT(omega, -0.5);
  for (const BridgePiece& piece : bridge.pieces()) EXPECT_EQ(world.omega(piece.body), omega);
}

TEST(BridgeMotion, ABearingThatIsTakenAwayIsNotMadeAgain) {
  BridgeDef def = truss_bridge(4);
  def.train = {};
  def.structure.members[3].area = 1e-6;  // ends at the roller, and breaks
  def.dynamic = true;
  World world;
  Bridge bridge(def, world);
  for (const BodyId bearing : bodies_named(world, "bearing")) world.destroy(bearing);
  EXPECT_NO_THROW(run(bridge, world, 5));
  EXPECT_FALSE(bridge.breaks().empty());
  EXPECT_TRUE(bodies_named(world, "bearing").empty());
}

TEST(BridgeMotion, LoadsOnAPartThatIsTakenAwayGoWithIt) {
  BridgeDef def = truss_bridge(4);
  def.fixed.nodes = {{2, {0, -1000}}};
  def.dynamic = true;
  World world;
  Bridge bridge(def, world);
  run(bridge, world, 2);
  const std::vector<BridgePiece> pieces = bridge.pieces();
  for (const BridgePiece& piece : pieces) {
    world.destroy(piece.body);
    EXPECT_NO_THROW(run(bridge, world, 1));
  }
}

TEST(BridgeMotion, ACableThatBrokeIsNotHungWhenTheBridgeFalls) {
  World world;
  Bridge bridge(bar_on_a_cable(4, 1e4), world);
  bridge.advance(world, 0);
  ASSERT_TRUE(bridge.moving());
  ASSERT_TRUE(bridge.members()[1].broken);
  EXPECT_EQ(ropes(world), 0);
}

TEST(BridgeMotion, ACableWhoseEndsComeNearerIsSlack) {
  BridgeDef def = bar_on_a_cable(-4, 2.35e8);
  def.dynamic = true;
  World world;
  Bridge bridge(def, world);
  run(bridge, world, 10);
  EXPECT_TRUE(bridge.members()[1].slack);
  EXPECT_EQ(bridge.members()[1].axial, 0);
}

/// A bar that hangs on a weak cable at its left and on a rod at its right.
BridgeDef bar_on_a_cable_and_a_rod() {
  BridgeDef def;
  def.structure.nodes = {{{0, 0}}, {{4, 0}}, {{0, 4}}, {{4, 4}}};
  def.structure.members = {steel(0, 1, MemberKind::Bar), steel(2, 0, MemberKind::Bar),
                           steel(3, 1, MemberKind::Bar)};
  def.structure.members[1].cable = true;
  def.structure.members[1].strength = 1e4;
  def.structure.supports = {{2}, {3}};
  def.dynamic = true;
  return def;
}

TEST(BridgeMotion, ACableThatBreaksInMotionCarriesNothingAndIsNotHungAgain) {
  BridgeDef def = bar_on_a_cable_and_a_rod();
  World world;
  Bridge bridge(def, world);
  run(bridge, world, 2);
  ASSERT_TRUE(bridge.members()[1].broken);
  EXPECT_EQ(bridge.members()[1].axial, 0);
  EXPECT_EQ(bridge.members()[1].signed_use, 0);
  EXPECT_EQ(ropes(world), 0);
  // Nor when the bar at its node breaks as well.
  def.structure.members[0].strength = 1e3;
  World other;
  Bridge both(def, other);
  for (int i = 0; i < 200 && both.breaks().size() < 2; ++i) run(both, other, 1);
  ASSERT_EQ(both.breaks().size(), 2u);
  ASSERT_TRUE(both.members()[0].broken);
  EXPECT_EQ(ropes(other), 0);
}

TEST(BridgeMotion, ACableBetweenNodesOfOneFrameIsNoRope) {
  BridgeDef def = corner();
  def.structure.members.push_back(steel(0, 2, MemberKind::Bar));
  def.structure.members[2].cable = true;
  def.dynamic = true;
  World world;
  EXPECT_NO_THROW({
    Bridge bridge(def, world);
    run(bridge, world, 3);
  });
  EXPECT_EQ(ropes(world), 0);
}

}  // namespace bridge_motion_test
}  // namespace skerry::statics::test
