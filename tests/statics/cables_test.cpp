// SPDX-License-Identifier: MIT
//
// Cables that cannot push: the forces against all sets of slack cables that there are.
#include <bit>
#include <cmath>
#include <gtest/gtest.h>
#include <optional>
#include <random>

#include "tests/statics/bridges.h"

namespace skerry::statics::test {
namespace cables_test {

Member bar(int a, int b, double area, bool cable = false) {
  Member m{a, b};
  m.modulus = 2e11;
  m.area = area;
  m.cable = cable;
  return m;
}

std::vector<int> cables_of(const Structure& s) {
  std::vector<int> cables;
  for (int m = 0; m < static_cast<int>(s.members.size()); ++m)
    if (s.members[static_cast<std::size_t>(m)].cable) cables.push_back(m);
  return cables;
}

/// The axial forces of all members if the cables of `mask` are slack; none: a mechanism, or cables would
/// push, or slack ones be stretched.
std::optional<std::vector<double>> forces_without(const Structure& s, const Load& load,
                                                  const std::vector<int>& cables, unsigned mask) {
  Structure rest = s;
  rest.members.clear();
  std::vector<std::size_t> kept;
  std::vector<char> slack(s.members.size(), 0);
  for (std::size_t k = 0; k < cables.size(); ++k)
    slack[static_cast<std::size_t>(cables[k])] = (mask >> k) & 1;
  for (std::size_t m = 0; m < s.members.size(); ++m) {
    if (slack[m]) continue;
    kept.push_back(m);
    rest.members.push_back(s.members[m]);
  }
  StructureSolver solver(rest);
  if (!solver.determinacy().stable()) return {};
  const Response response = solver.solve(load, true);
  std::vector<double> forces(s.members.size(), 0);
  for (std::size_t k = 0; k < kept.size(); ++k) {
    forces[kept[k]] = response.members[k].axial;
    if (s.members[kept[k]].cable && response.members[k].axial < -1e-6) return {};
  }
  for (std::size_t m = 0; m < s.members.size(); ++m) {
    if (!slack[m]) continue;
    const auto a = static_cast<std::size_t>(s.members[m].a), b = static_cast<std::size_t>(s.members[m].b);
    const Vec2 way = s.nodes[b].at - s.nodes[a].at;
    if (dot(way, response.displacements[b].shift - response.displacements[a].shift) > 1e-11 * length(way))
      return {};
  }
  return forces;
}

/// Fewer slack ones first.
std::optional<std::vector<double>> forces_of_all_sets(const Structure& s, const Load& load) {
  const std::vector<int> cables = cables_of(s);
  for (int count = 0; count <= static_cast<int>(cables.size()); ++count) {
    for (unsigned mask = 0; mask < (1u << cables.size()); ++mask) {
      if (std::popcount(mask) != count) continue;
      if (auto forces = forces_without(s, load, cables, mask)) return forces;
    }
  }
  return {};
}

TEST(Cables, ForcesAreThoseOfTheOneSetOfSlackCablesThatFits) {
  const unsigned seed = 4;
  std::mt19937 random(seed);
  const auto among = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int slack = 0;
  for (int bridge_number = 0; bridge_number < 300; ++bridge_number) {
    // Crooked panels between two walls, each braced by two cables.
    const int columns = 3 + bridge_number % 2;
    BridgeDef def;
    Structure& s = def.structure;
    for (int i = 0; i < columns; ++i) {
      s.nodes.push_back({{4.0 * i, 0}});
      s.nodes.push_back({{4.0 * i + among(-1, 1), 4 + among(-1, 1)}});
    }
    for (int i = 0; i < columns; ++i) s.members.push_back(bar(2 * i, 2 * i + 1, 2e-3));
    for (int i = 0; i + 1 < columns; ++i) {
      s.members.push_back(bar(2 * i, 2 * i + 2, 2e-3));
      s.members.push_back(bar(2 * i + 1, 2 * i + 3, 2e-3));
      s.members.push_back(bar(2 * i, 2 * i + 3, among(2e-4, 2e-3), true));
      s.members.push_back(bar(2 * i + 1, 2 * i + 2, among(2e-4, 2e-3), true));
    }
    s.supports = {{0, SupportKind::Pinned}, {2 * columns - 2, SupportKind::Pinned}};
    def.breaks = false;
    for (int i = 0; i < 2 * columns; ++i)
      def.fixed.nodes.push_back({i, {1e4 * among(-1, 1), 1e4 * among(-1, 1)}});
    const Load load = def.fixed;
    const Structure structure = s;
    World world;
    Bridge bridge(std::move(def), world);
    const auto expected = forces_of_all_sets(structure, load);
    bridge.advance(world, 0.01);
    ASSERT_EQ(bridge.moving(), !expected) << "seed " << seed << ", bridge " << bridge_number;
    if (!expected) continue;
    double largest = 0;
    for (const double force : *expected) largest = std::max(largest, std::abs(force));
    for (std::size_t m = 0; m < structure.members.size(); ++m) {
      EXPECT_NEAR(bridge.members()[m].axial, (*expected)[m], 1e-9 * largest)
          << "seed " << seed << ", bridge " << bridge_number << ", member " << m;
      slack += bridge.members()[m].slack;
    }
  }
  EXPECT_GT(slack, 300);
}

/// A square of bars between a pin and a roller, with two crossing cables, pushed to the right at its top.
BridgeDef braced_square() {
  BridgeDef def;
  def.structure.nodes = {{{0, 0}}, {{4, 0}}, {{4, 4}}, {{0, 4}}};
  for (int i = 0; i < 4; ++i) def.structure.members.push_back(bar(i, (i + 1) % 4, 1e-3));
  def.structure.members.push_back(bar(0, 2, 1e-3, true));
  def.structure.members.push_back(bar(1, 3, 1e-3, true));
  for (Member& m : def.structure.members) m.strength = 2.35e8;
  def.structure.supports = {{0, SupportKind::Pinned}, {1, SupportKind::Roller}};
  def.fixed.nodes = {{3, {1e5, 0}}};
  return def;
}

TEST(Cables, NonePushesFromTheFirstMomentOn) {
  World world;
  const Bridge bridge(braced_square(), world);
  EXPECT_NEAR(bridge.members()[4].axial, std::sqrt(2.0) * 1e5, 1e-4);
  EXPECT_EQ(bridge.members()[5].axial, 0);
  EXPECT_TRUE(bridge.members()[5].slack);
  EXPECT_NEAR(bridge.members()[4].peak_use, std::sqrt(2.0) * 1e5 / 1e-3 / 2.35e8, 1e-9);
  EXPECT_EQ(bridge.members()[5].peak_use, 0);
}

TEST(Cables, OneThatIsNeededToPushLeavesAMechanism) {
  BridgeDef def = braced_square();
  def.structure.members.pop_back();
  def.fixed.nodes[0].force = {-1e5, 0};
  World world;
  Bridge bridge(def, world);
  bridge.advance(world, 0.01);
  EXPECT_TRUE(bridge.moving());
}

TEST(Cables, ASlackOneCarriesWhenABarBreaks) {
  // A node hangs on a soft bar, and sinks towards the anchor of a cable to the left below it. A weak bar
  // holds it against a pull to the right; when that breaks the cable does.
  BridgeDef def;
  def.structure.nodes = {{{0, 0}}, {{-4, 0}}, {{0, 4}}, {{-4, -4}}};
  def.structure.members = {bar(0, 1, 1e-3), bar(0, 2, 1e-4), bar(0, 3, 1e-3, true)};
  def.structure.members[0].strength = 5e6;
  def.structure.supports = {{1}, {2}, {3}};
  def.fixed.nodes = {{0, {1e4, -1e4}}};
  World world;
  Bridge bridge(def, world);
  EXPECT_TRUE(bridge.members()[2].slack);
  EXPECT_NEAR(bridge.members()[0].axial, 1e4, 1e-6);
  bridge.advance(world, 0.01);
  EXPECT_EQ(bridge.breaks().size(), 1u);
  EXPECT_FALSE(bridge.moving());
  EXPECT_NEAR(bridge.members()[2].axial, std::sqrt(2.0) * 1e4, 1e-6);
  EXPECT_NEAR(bridge.members()[1].axial, 2e4, 1e-6);
}

TEST(Cables, NetsOfManyCablesHaveASetOfSlackOnesThatFits) {
  const unsigned seed = 11;
  std::mt19937 random(seed);
  const auto among = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (int number = 0; number < 100; ++number) {
    // Nodes that soft bars hold, tied to each other and to anchors around them by cables.
    BridgeDef def;
    Structure& s = def.structure;
    const int nodes = 5;
    for (int i = 0; i < nodes; ++i) s.nodes.push_back({{among(-2, 2), among(-2, 2)}});
    const auto anchored = [&](int i, double area, bool cable) {
      const double angle = among(0, 6.28);
      const int anchor = static_cast<int>(s.nodes.size());
      s.supports.push_back({anchor});
      s.nodes.push_back({{6 * std::cos(angle), 6 * std::sin(angle)}});
      s.members.push_back(bar(i, anchor, area, cable));
    };
    for (int i = 0; i < nodes; ++i) {
      for (int k = 0; k < 2; ++k) anchored(i, among(1e-5, 1e-4), false);
      for (int k = 0; k < 2; ++k) anchored(i, among(2e-4, 2e-3), true);
      for (int j = 0; j < i; ++j) s.members.push_back(bar(i, j, among(2e-4, 2e-3), true));
    }
    def.breaks = false;
    for (int i = 0; i < nodes; ++i) def.fixed.nodes.push_back({i, {1e4 * among(-1, 1), 1e4 * among(-1, 1)}});
    const Load load = def.fixed;
    const Structure structure = s;
    World world;
    const Bridge bridge(std::move(def), world);
    const std::vector<int> cables = cables_of(structure);
    unsigned slack = 0;
    for (std::size_t k = 0; k < cables.size(); ++k)
      slack |= unsigned{bridge.members()[static_cast<std::size_t>(cables[k])].slack} << k;
    const auto expected = forces_without(structure, load, cables, slack);
    ASSERT_TRUE(expected) << "seed " << seed << ", net " << number;
    double largest = 0;
    for (const double force : *expected) largest = std::max(largest, std::abs(force));
    for (std::size_t m = 0; m < structure.members.size(); ++m)
      EXPECT_NEAR(bridge.members()[m].axial, (*expected)[m], 1e-6 * largest)
          << "seed " << seed << ", net " << number << ", member " << m;
  }
}

}  // namespace cables_test
}  // namespace skerry::statics::test
