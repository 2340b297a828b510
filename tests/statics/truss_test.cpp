// SPDX-License-Identifier: MIT
//
// Trusses against the method of joints, moments, virtual work and reciprocity.
#include <cmath>
#include <gtest/gtest.h>

#include "tests/statics/trusses.h"
#include "tests/support/scale.h"

namespace skerry::statics::test {
namespace truss_test {

/// Largest axial force.
double largest(const Response& response) {
  double result = 0;
  for (const MemberForce& force : response.members) result = std::max(result, std::abs(force.axial));
  return result;
}

/// The method of joints in long double: nodes in the reverse order of their construction, two unknown bars
/// each.
std::vector<long double> method_of_joints(const Structure& s, const Load& load) {
  const std::size_t n = s.nodes.size();
  std::vector<long double> px(n), py(n), force(s.members.size());
  for (const NodeLoad& l : load.nodes) {
    px[static_cast<std::size_t>(l.node)] += l.force.x;
    py[static_cast<std::size_t>(l.node)] += l.force.y;
  }
  for (std::size_t c = n; c-- > 2;) {
    const std::size_t bars[] = {2 * (c - 2) + 1, 2 * (c - 2) + 2};
    long double ux[2], uy[2];
    std::size_t ends[2];
    for (int k = 0; k < 2; ++k) {
      ends[k] = static_cast<std::size_t>(s.members[bars[k]].a);
      ux[k] = static_cast<long double>(s.nodes[ends[k]].at.x) - s.nodes[c].at.x;
      uy[k] = static_cast<long double>(s.nodes[ends[k]].at.y) - s.nodes[c].at.y;
      const long double l = std::sqrt(ux[k] * ux[k] + uy[k] * uy[k]);
      ux[k] /= l;
      uy[k] /= l;
    }
    // N1 u1 + N2 u2 + p = 0
    const long double det = ux[0] * uy[1] - ux[1] * uy[0];
    force[bars[0]] = (-px[c] * uy[1] + ux[1] * py[c]) / det;
    force[bars[1]] = (-ux[0] * py[c] + px[c] * uy[0]) / det;
    for (int k = 0; k < 2; ++k) {
      px[ends[k]] -= force[bars[k]] * ux[k];
      py[ends[k]] -= force[bars[k]] * uy[k];
    }
  }
  // Node 1 rolls along its line: the bar to node 0 carries what the roller cannot.
  const long double tx = std::cos(static_cast<long double>(s.supports[1].angle));
  const long double ty = std::sin(static_cast<long double>(s.supports[1].angle));
  long double ux = static_cast<long double>(s.nodes[0].at.x) - s.nodes[1].at.x;
  long double uy = static_cast<long double>(s.nodes[0].at.y) - s.nodes[1].at.y;
  const long double l = std::sqrt(ux * ux + uy * uy);
  ux /= l;
  uy /= l;
  force[0] = -(px[1] * tx + py[1] * ty) / (ux * tx + uy * ty);
  return force;
}

TEST(Truss, RandomTrussesAgreeWithTheMethodOfJointsTo1e12) {
  for (int seed = 1; seed <= test_scale(200); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(static_cast<unsigned>(seed));
    const Structure s = random_truss(random, 3 + seed % 40);
    StructureSolver solver(s);
    ASSERT_EQ(solver.method(), ForceMethod::Equilibrium);
    const Load load = random_load(random, s);
    const Response response = solver.solve(load);
    const std::vector<long double> exact = method_of_joints(s, load);
    const double scale = largest(response);
    for (std::size_t m = 0; m < s.members.size(); ++m)
      ASSERT_NEAR(response.members[m].axial, static_cast<double>(exact[m]), 1e-12 * scale) << "member " << m;
  }
}

TEST(Truss, ReactionsFollowFromForcesAndMoments) {
  for (int seed = 1; seed <= test_scale(50); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(static_cast<unsigned>(seed));
    const Structure s = random_truss(random, 20);
    StructureSolver solver(s);
    const Load load = random_load(random, s);
    const Response response = solver.solve(load);
    Vec2 force{};
    double moment = 0;
    for (const NodeLoad& l : load.nodes) {
      force += l.force;
      moment += cross(s.nodes[static_cast<std::size_t>(l.node)].at, l.force);
    }
    // The roller's force stands across its line; moments about the pin give its size.
    const Vec2 across = perp(Vec2{std::cos(s.supports[1].angle), std::sin(s.supports[1].angle)});
    const double roller = -moment / cross(s.nodes[1].at, across);
    const double scale = largest(response);
    EXPECT_NEAR(dot(response.reactions[1].force, across), roller, 1e-12 * scale);
    EXPECT_NEAR(dot(response.reactions[1].force, perp(across)), 0, 1e-12 * scale);
    EXPECT_NEAR(response.reactions[0].force.x, -force.x - roller * across.x, 1e-12 * scale);
    EXPECT_NEAR(response.reactions[0].force.y, -force.y - roller * across.y, 1e-12 * scale);
  }
}

TEST(Truss, PrattTrussAgreesWithTheMethodOfSections) {
  // Chord forces by moments about the opposite node, with one load on each lower node.
  const int panels = 8;
  const double side = 2, P = 1000;
  StructureSolver solver(pratt(panels));
  Load load;
  for (int i = 1; i < panels; ++i) load.nodes.push_back({i, {0, -P}});
  const Response response = solver.solve(load);
  const auto moment = [&](int i) { return 0.5 * P * side * i * (panels - i); };  // of the simple beam
  EXPECT_NEAR(response.members[0].axial, moment(1) / side, 1e-9);
  for (int i = 1; i < panels / 2; ++i)
    EXPECT_NEAR(response.members[static_cast<std::size_t>(i)].axial, moment(i) / side, 1e-9) << i;
  for (int i = 1; i < panels / 2; ++i)
    EXPECT_NEAR(response.members[static_cast<std::size_t>(panels + i - 1)].axial, -moment(i + 1) / side, 1e-9)
        << i;
  EXPECT_NEAR(response.reactions[0].force.y, 0.5 * P * (panels - 1), 1e-9);
  EXPECT_NEAR(response.reactions[1].force.y, 0.5 * P * (panels - 1), 1e-9);
}

TEST(Truss, InfluenceLineIsTheSumOfUnitLoadsAndPiecewiseLinear) {
  const int panels = 10;
  const double side = 2, height = 2;
  StructureSolver solver(pratt(panels));
  // Lower chord of panel 4 by moments about the upper node above node 3: M(x) / height.
  const auto line = solver.influence({Quantity::Kind::Axial, 3});
  const double x0 = 3 * side, length = panels * side;
  for (int i = 0; i <= panels; ++i) {
    const double x = side * i;
    const double moment = x <= x0 ? x * (length - x0) / length : x0 * (length - x) / length;
    EXPECT_NEAR(-line.force[static_cast<std::size_t>(i)].y, moment / height, 1e-12) << i;
    Load unit;
    unit.nodes.push_back({i, {0, -1}});
    EXPECT_NEAR(solver.solve(unit).members[3].axial, -line.force[static_cast<std::size_t>(i)].y, 1e-12);
  }
  // Between the nodes a load on a bar is shared by lever.
  Load between;
  between.spans.push_back({4, 0.25, {0, -1}});
  EXPECT_NEAR(solver.value(line, between), -0.75 * line.force[4].y - 0.25 * line.force[5].y, 1e-12);
}

TEST(Truss, SimplySupportedBeamShareIsOneMinusXOverL) {
  StructureSolver solver(pratt(6));
  const auto line = solver.influence({Quantity::Kind::ReactionY, 0});
  for (int i = 0; i <= 6; ++i)
    EXPECT_NEAR(-line.force[static_cast<std::size_t>(i)].y, 1 - i / 6.0, 1e-13) << i;
}

TEST(Truss, InfluenceLinesAndForcesAreTwoSidesOfVirtualWork) {
  for (int seed = 1; seed <= test_scale(40); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(static_cast<unsigned>(seed));
    Structure s = random_truss(random, 15);
    // Some with redundant bars: the displacement method takes over.
    if (seed % 2 == 0) {
      s.members.push_back({0, 8, MemberKind::Bar, 2e11, 0.01});
      s.members.push_back({5, 12, MemberKind::Bar, 2e11, 0.02});
    }
    StructureSolver solver(s);
    ASSERT_TRUE(solver.determinacy().stable());
    const Load load = random_load(random, s);
    const Response response = solver.solve(load);
    const double scale = largest(response);
    for (int m = 0; m < static_cast<int>(s.members.size()); ++m) {
      const auto line = solver.influence({Quantity::Kind::Axial, m});
      ASSERT_NEAR(solver.value(line, load), response.members[static_cast<std::size_t>(m)].axial,
                  1e-10 * scale);
    }
  }
}

TEST(Truss, DisplacementsAreReciprocalAsMaxwellAndBettiSay) {
  for (int seed = 1; seed <= test_scale(40); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(static_cast<unsigned>(seed));
    Structure s = random_truss(random, 12);
    if (seed % 2 == 0) s.members.push_back({0, 9, MemberKind::Bar, 2e11, 0.01});
    StructureSolver solver(s);
    const Load one = random_load(random, s), two = random_load(random, s);
    const Response first = solver.solve(one, true), second = solver.solve(two, true);
    double work12 = 0, work21 = 0, size = 0;
    for (std::size_t i = 0; i < s.nodes.size(); ++i) {
      work12 += dot(one.nodes[i].force, second.displacements[i].shift);
      work21 += dot(two.nodes[i].force, first.displacements[i].shift);
      size += length(one.nodes[i].force) * length(second.displacements[i].shift);
    }
    EXPECT_NEAR(work12, work21, 1e-10 * size);
    // Work of the loads is the strain energy, sum N^2 L / (E A).
    double external = 0, internal = 0;
    for (std::size_t i = 0; i < s.nodes.size(); ++i)
      external += dot(one.nodes[i].force, first.displacements[i].shift);
    for (int m = 0; m < static_cast<int>(s.members.size()); ++m) {
      const Member& member = s.members[static_cast<std::size_t>(m)];
      const double n = first.members[static_cast<std::size_t>(m)].axial;
      internal += n * n * member_length(s, m) / (member.modulus * member.area);
    }
    EXPECT_NEAR(external, internal, 1e-10 * internal);
  }
}

TEST(Truss, RedundantTrussSharesByStiffness) {
  // Two bars in line between two walls: a force in the middle is shared by E A / L.
  Structure s;
  s.nodes = {{{0, 0}}, {{1, 0}}, {{3, 0}}, {{1, -1}}};
  s.members = {{0, 1, MemberKind::Bar, 2e11, 0.01},
               {1, 2, MemberKind::Bar, 1e11, 0.03},
               {1, 3, MemberKind::Bar, 2e11, 0.01}};
  s.supports = {{0}, {2}, {3}};
  StructureSolver solver(s);
  EXPECT_EQ(solver.method(), ForceMethod::Stiffness);
  EXPECT_EQ(solver.determinacy().indeterminacy(), 1);
  EXPECT_EQ(solver.determinacy().sentence(), "1 time statically indeterminate");
  Load load;
  load.nodes.push_back({1, {700, 0}});
  const Response response = solver.solve(load);
  const double k1 = 2e11 * 0.01 / 1, k2 = 1e11 * 0.03 / 2;
  EXPECT_NEAR(response.members[0].axial, 700 * k1 / (k1 + k2), 1e-10);
  EXPECT_NEAR(response.members[1].axial, -700 * k2 / (k1 + k2), 1e-10);
  EXPECT_NEAR(response.members[2].axial, 0, 1e-10);

  // Without stiffness: the smallest sum of squares, so equal shares.
  for (Member& m : s.members) m.modulus = 0;
  StructureSolver plain(s);
  EXPECT_EQ(plain.method(), ForceMethod::MinimumNorm);
  EXPECT_NEAR(plain.solve(load).members[0].axial, 350, 1e-10);
  // Its one self-stress state: equal tension in both bars.
  const auto states = plain.self_stresses();
  ASSERT_EQ(states.size(), 1u);
  EXPECT_NEAR(states[0][0].axial, states[0][1].axial, 1e-12);
  EXPECT_NEAR(std::abs(states[0][0].axial), 1, 1e-12);
  EXPECT_NEAR(states[0][2].axial, 0, 1e-12);
}

TEST(Truss, BucklingOfASlenderBarGoesBeforeItsStrength) {
  Structure s;
  s.nodes = {{{0, 0}}, {{0, 4}}};
  Member m{0, 1, MemberKind::Bar, 2e11, 1e-3};
  m.second_moment = 1e-7;
  m.strength = 2.5e8;
  s.members = {m};
  s.supports = {{0}, {1, SupportKind::Roller, kPi / 2}};
  StructureSolver solver(s);
  Load load;
  load.nodes.push_back({1, {0, -1e4}});
  const Response response = solver.solve(load);
  const double euler = kPi * kPi * 2e11 * 1e-7 / 16;
  const MemberStress stress = member_stress(s, load, response, 0);
  EXPECT_NEAR(stress.compression, 1e7, 1e-3);
  EXPECT_NEAR(stress.utilisation, 1e4 / euler, 1e-12);
  EXPECT_TRUE(stress.buckles);
  EXPECT_TRUE(stress.squeezed);
}

TEST(Truss, BendingOfABarUnderItsWeightDoesNotBuckleIt) {
  // A round rod of 30 mm, 6 m long: Euler's load is 2.3 kN, far below its strength.
  Structure s;
  s.nodes = {{{0, 0}}, {{6, 0}}};
  Member m{0, 1, MemberKind::Bar, 2.1e11, 7.07e-4};
  m.second_moment = 3.976e-8;
  m.depth = 0.03;
  m.strength = 2.35e8;
  m.density = 7850;
  s.members = {m};
  s.supports = {{0}, {1, SupportKind::Roller}};
  StructureSolver solver(s);
  const double bending = 7850 * 7.07e-4 * 9.81 * 36 / 8 * 0.015 / 3.976e-8;
  const double euler = kPi * kPi * 2.1e11 * 3.976e-8 / 36;
  const auto stress_under = [&](double pull) {
    Load load = self_weight(s);
    load.nodes.push_back({1, {pull, 0}});
    return member_stress(s, load, solver.solve(load), 0);
  };
  // Pulled, its upper side is squeezed a little: the lower one breaks first.
  const MemberStress tie = stress_under(2.8e4);
  EXPECT_NEAR(tie.utilisation, (2.8e4 / 7.07e-4 + bending) / 2.35e8, 1e-9);
  EXPECT_NEAR(tie.compression, bending - 2.8e4 / 7.07e-4, 1);
  EXPECT_FALSE(tie.buckles);
  EXPECT_FALSE(tie.squeezed);
  // Pushed a little, bending decides; pushed more, Euler.
  const MemberStress little = stress_under(-500), more = stress_under(-2000);
  EXPECT_NEAR(little.utilisation, (500 / 7.07e-4 + bending) / 2.35e8, 1e-9);
  EXPECT_FALSE(little.buckles);
  EXPECT_TRUE(little.squeezed);
  EXPECT_NEAR(more.utilisation, 2000 / euler, 1e-9);
  EXPECT_TRUE(more.buckles);
}

}  // namespace truss_test
}  // namespace skerry::statics::test
