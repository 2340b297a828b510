// SPDX-License-Identifier: MIT
//
// Beams and frames against the formulas of the textbooks.
#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>

#include "tests/statics/trusses.h"
#include "tests/support/scale.h"

namespace skerry::statics::test {
namespace beam_test {

double moment_at(const StructureSolver& solver, const Load& load, const Response& r, int member,
                 double share) {
  return section_force(solver.structure(), load, r, member, share).moment;
}

TEST(Beam, SimplySupportedBeamHasTheMomentsOfTheTextbook) {
  const double L = 6, P = 1200, w = 300;
  StructureSolver solver(continuous_beam({0, L}));
  EXPECT_EQ(solver.method(), ForceMethod::Equilibrium);
  Load point;
  point.spans.push_back({0, 0.3, {0, -P}});
  Response r = solver.solve(point, true);
  EXPECT_NEAR(r.reactions[0].force.y, P * 0.7, 1e-10);
  EXPECT_NEAR(r.reactions[1].force.y, P * 0.3, 1e-10);
  EXPECT_NEAR(moment_at(solver, point, r, 0, 0.3), P * 0.3 * 0.7 * L, 1e-10);
  EXPECT_NEAR(section_force(solver.structure(), point, r, 0, 0.2).shear, 0.7 * P, 1e-10);
  EXPECT_NEAR(section_force(solver.structure(), point, r, 0, 0.4).shear, -0.3 * P, 1e-10);
  // End slope P a b (L + b) / (6 L E I).
  const double a = 0.3 * L, b = 0.7 * L, EI = 2e11 * 3e-4;
  EXPECT_NEAR(r.displacements[0].rotation, -P * a * b * (L + b) / (6 * L * EI), 1e-15);
  EXPECT_NEAR(r.displacements[1].rotation, P * a * b * (L + a) / (6 * L * EI), 1e-15);

  Load line;
  line.lines.push_back({0, {0, -w}});
  r = solver.solve(line, true);
  EXPECT_NEAR(moment_at(solver, line, r, 0, 0.5), w * L * L / 8, 1e-10);
  EXPECT_NEAR(r.displacements[0].rotation, -w * L * L * L / (24 * EI), 1e-15);
  // Bending stress M c / I at mid span.
  const MemberStress stress = member_stress(solver.structure(), line, r, 0);
  EXPECT_NEAR(stress.tension, w * L * L / 8 * 0.2 / 3e-4, 1e-4);
  EXPECT_NEAR(stress.share, 0.5, 1e-9);
}

TEST(Beam, CantileverBendsByPL3Over3EI) {
  Structure s = continuous_beam({0, 2, 3});
  s.supports = {{0, SupportKind::Fixed}};
  StructureSolver solver(s);
  Load load;
  load.nodes.push_back({2, {0, -500}});
  const Response r = solver.solve(load, true);
  const double EI = 2e11 * 3e-4;
  EXPECT_NEAR(r.reactions[0].moment, 1500, 1e-9);
  EXPECT_NEAR(r.displacements[2].shift.y, -500 * 27 / (3 * EI), 1e-14);
  EXPECT_NEAR(r.displacements[2].rotation, -500 * 9 / (2 * EI), 1e-14);
  EXPECT_NEAR(r.members[1].moment_a, -500, 1e-9);
}

TEST(Beam, BeamClampedAtBothEndsHasTheMomentsOfTheTextbook) {
  const double L = 4, w = 100, P = 700;
  Structure s = continuous_beam({0, L});
  s.supports = {{0, SupportKind::Fixed}, {1, SupportKind::Fixed}};
  StructureSolver solver(s);
  EXPECT_EQ(solver.determinacy().indeterminacy(), 3);
  Load load;
  load.lines.push_back({0, {0, -w}});
  Response r = solver.solve(load);
  EXPECT_NEAR(r.members[0].moment_a, -w * L * L / 12, 1e-9);
  EXPECT_NEAR(r.members[0].moment_b, -w * L * L / 12, 1e-9);
  EXPECT_NEAR(moment_at(solver, load, r, 0, 0.5), w * L * L / 24, 1e-9);
  load.clear();
  load.spans.push_back({0, 0.25, {0, -P}});
  r = solver.solve(load);
  EXPECT_NEAR(r.members[0].moment_a, -P * 1 * 9 / (L * L), 1e-9);  // P a b^2 / L^2
  EXPECT_NEAR(r.members[0].moment_b, -P * 1 * 3 / (L * L), 1e-9);
}

TEST(Beam, ProppedCantileverHasMinusWL2Over8AtTheWall) {
  Structure s = continuous_beam({0, 5});
  s.supports = {{0, SupportKind::Fixed}, {1, SupportKind::Roller}};
  s.members[0].hinge_b = true;
  StructureSolver solver(s);
  Load load;
  load.lines.push_back({0, {0, -80}});
  const Response r = solver.solve(load);
  EXPECT_NEAR(r.members[0].moment_a, -80 * 25 / 8.0, 1e-9);
  EXPECT_NEAR(r.reactions[1].force.y, 3 * 80 * 5 / 8.0, 1e-9);
}

TEST(Beam, ContinuousBeamAgreesWithTheThreeMomentEquation) {
  // M(i-1) l(i) + 2 M(i) (l(i) + l(i+1)) + M(i+1) l(i+1) = -6 (A a / l + B b / l)  [Clapeyron 1857]
  for (int seed = 1; seed <= test_scale(40); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(static_cast<unsigned>(seed));
    std::uniform_real_distribution<double> span(2, 9), amount(-500, 500), share(0.1, 0.9);
    const int spans = 2 + seed % 6;
    std::vector<double> stations{0}, l, w, P, at;
    Load load;
    for (int i = 0; i < spans; ++i) {
      l.push_back(span(random));
      stations.push_back(stations.back() + l.back());
      w.push_back(amount(random));
      P.push_back(amount(random));
      at.push_back(share(random));
      load.lines.push_back({i, {0, -w.back()}});
      load.spans.push_back({i, at.back(), {0, -P.back()}});
    }
    StructureSolver solver(continuous_beam(stations));
    EXPECT_EQ(solver.determinacy().indeterminacy(), spans - 1);
    const Response r = solver.solve(load);
    const int n = spans - 1;
    Eigen::MatrixXd m = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd rhs(n);
    for (int i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      m(i, i) = 2 * (l[k] + l[k + 1]);
      if (i > 0) m(i, i - 1) = l[k];
      if (i + 1 < n) m(i, i + 1) = l[k + 1];
      const double a = at[k] * l[k], b = (1 - at[k + 1]) * l[k + 1];
      rhs(i) = -(w[k] * std::pow(l[k], 3) + w[k + 1] * std::pow(l[k + 1], 3)) / 4 -
               P[k] * a * (l[k] * l[k] - a * a) / l[k] -
               P[k + 1] * b * (l[k + 1] * l[k + 1] - b * b) / l[k + 1];
    }
    const Eigen::VectorXd exact = m.fullPivLu().solve(rhs);
    for (int i = 0; i < n; ++i) {
      EXPECT_NEAR(r.members[static_cast<std::size_t>(i)].moment_b, exact(i), 1e-8);
      EXPECT_NEAR(r.members[static_cast<std::size_t>(i) + 1].moment_a, exact(i), 1e-8);
    }
  }
}

TEST(Beam, MiddleReactionOfTwoEqualSpansIsFiveEighthsOfTheLoad) {
  StructureSolver solver(continuous_beam({0, 4, 8}));
  Load load;
  load.lines = {{0, {0, -50}}, {1, {0, -50}}};
  const Response r = solver.solve(load);
  EXPECT_NEAR(r.reactions[1].force.y, 1.25 * 50 * 4, 1e-9);
  EXPECT_NEAR(r.members[0].moment_b, -50 * 16 / 8.0, 1e-9);
}

TEST(Beam, GerberBeamIsDeterminateAndItsHingesCarryNoMoment) {
  // Supports at 0, 6, 12; a hinge at 4: the piece 0-4 hangs on the cantilever 4-6.
  Structure s = continuous_beam({0, 4, 6, 12});
  s.supports = {{0}, {2, SupportKind::Roller}, {3, SupportKind::Roller}};
  s.members[0].hinge_b = true;
  StructureSolver solver(s);
  EXPECT_EQ(solver.determinacy().sentence(), "statically determinate");
  Load load;
  load.spans.push_back({0, 0.5, {0, -1000}});
  const Response r = solver.solve(load);
  EXPECT_NEAR(r.reactions[0].force.y, 500, 1e-10);
  EXPECT_NEAR(r.members[0].moment_b, 0, 1e-10);
  EXPECT_NEAR(r.members[1].moment_b, -500 * 2, 1e-10);
  EXPECT_NEAR(r.reactions[1].force.y, 500 + 1000 / 6.0, 1e-10);
  EXPECT_NEAR(r.reactions[2].force.y, -1000 / 6.0, 1e-10);
  // Influence line of the support moment: zero over the first support, -2 at the hinge, zero again beyond 6.
  const auto line = solver.influence({Quantity::Kind::Moment, 1, 1});
  EXPECT_NEAR(-line.force[1].y, -2, 1e-12);
  EXPECT_NEAR(-line.force[3].y, 0, 1e-12);
  Load half;
  half.spans.push_back({0, 0.5, {0, -1}});
  EXPECT_NEAR(solver.value(line, half), -1, 1e-12);
}

TEST(Beam, ThreeHingedArchHasThrustWL2Over8F) {
  // Parabola y = 4 f x (L - x) / L^2 of beams with a hinge at the crown: under an even load no moments at
  // all.
  const int pieces = 16;
  const double L = 20, f = 5, w = 400;
  Structure s;
  Load load;
  for (int i = 0; i <= pieces; ++i) {
    const double x = L * i / pieces;
    s.nodes.push_back({{x, 4 * f * x * (L - x) / (L * L)}});
    load.nodes.push_back({i, {0, -w * L / pieces * (i == 0 || i == pieces ? 0.5 : 1)}});
  }
  for (int i = 0; i < pieces; ++i) {
    Member m{i, i + 1, MemberKind::Beam};
    m.hinge_b = i + 1 == pieces / 2;
    s.members.push_back(m);
  }
  s.supports = {{0}, {pieces}};
  StructureSolver solver(s);
  EXPECT_EQ(solver.method(), ForceMethod::Equilibrium);
  Response r = solver.solve(load);
  EXPECT_NEAR(r.reactions[0].force.x, w * L * L / (8 * f), 1e-9);
  EXPECT_NEAR(r.reactions[1].force.x, -w * L * L / (8 * f), 1e-9);
  EXPECT_NEAR(r.reactions[0].force.y, w * L / 2, 1e-9);
  for (const MemberForce& m : r.members) EXPECT_NEAR(m.moment_b, 0, 1e-9);
  // One load in the left quarter: H = P x / (2 f), M(x) = V x - H y.
  load.clear();
  load.nodes.push_back({pieces / 4, {0, -1000}});
  r = solver.solve(load);
  EXPECT_NEAR(r.reactions[0].force.x, 1000 * (L / 4) / (2 * f), 1e-10);
  EXPECT_NEAR(r.members[pieces / 4 - 1].moment_b, 750 * L / 4 - 500 * 0.75 * f, 1e-9);
}

TEST(Beam, PortalFrameHasTheMomentsOfKleinlogel) {
  // Two-hinged portal, span l, height h, k = (I_beam / I_column) h / l. Even load on the beam:
  // H = w l^2 / (4 h (2 k + 3)); load W at the top corner: H = W / 2. Stiff against stretching.
  const double l = 6, h = 4, w = 500;
  Structure s;
  s.nodes = {{{0, 0}}, {{0, h}}, {{l, h}}, {{l, 0}}};
  for (int i = 0; i < 3; ++i) {
    Member m{i, i + 1, MemberKind::Beam};
    m.modulus = 2e11;
    m.area = 1e3;
    m.second_moment = i == 1 ? 4e-4 : 2e-4;
    s.members.push_back(m);
  }
  s.supports = {{0}, {3}};
  StructureSolver solver(s);
  EXPECT_EQ(solver.determinacy().indeterminacy(), 1);
  Load load;
  load.lines.push_back({1, {0, -w}});
  Response r = solver.solve(load);
  const double k = 2 * h / l;
  EXPECT_NEAR(r.reactions[0].force.x, w * l * l / (4 * h * (2 * k + 3)), 1e-3);
  EXPECT_NEAR(r.members[1].moment_a, -w * l * l / (4 * (2 * k + 3)), 1e-3);
  load.clear();
  load.nodes.push_back({1, {800, 0}});
  r = solver.solve(load);
  EXPECT_NEAR(r.reactions[0].force.x, -400, 1e-3);
  EXPECT_NEAR(r.reactions[0].force.y, -800 * h / l, 1e-6);
}

TEST(Beam, AFrameSpreadsItsLegsIntoTheTie) {
  // Two legs 4 m high with feet 3 m apart on smooth rollers, hinged at the top, a tie 1 m above the feet.
  Structure s;
  s.nodes = {{{-1.5, 0}}, {{-1.125, 1}}, {{0, 4}}, {{1.125, 1}}, {{1.5, 0}}};
  Member leg{0, 1, MemberKind::Beam};
  s.members = {leg, leg, leg, leg, {1, 3}};
  s.members[1] = {1, 2, MemberKind::Beam};
  s.members[2] = {2, 3, MemberKind::Beam};
  s.members[2].hinge_a = true;
  s.members[3] = {3, 4, MemberKind::Beam};
  s.supports = {{0, SupportKind::Pinned}, {4, SupportKind::Roller}};
  StructureSolver solver(s);
  EXPECT_EQ(solver.determinacy().sentence(), "statically determinate");
  Load load;
  load.nodes.push_back({2, {0, -800}});
  const Response r = solver.solve(load);
  // Moments of one leg about the top: T * 3 = 400 * 1.5.
  EXPECT_NEAR(r.members[4].axial, 400 * 1.5 / 3, 1e-10);
  EXPECT_NEAR(r.reactions[0].force.x, 0, 1e-10);
  EXPECT_NEAR(r.reactions[0].force.y, 400, 1e-10);
}

TEST(Beam, LadderOnASmoothWallPushesByItsLever) {
  // Foot pinned, top on a roller along the wall: H = W cot(angle) / 2.
  const double angle = 1.1, L = 5, W = 200;
  Structure s;
  s.nodes = {{{0, 0}}, {{L * std::cos(angle), L * std::sin(angle)}}};
  s.members = {{0, 1, MemberKind::Beam}};
  s.supports = {{0}, {1, SupportKind::Roller, kPi / 2}};
  StructureSolver solver(s);
  Load load;
  load.spans.push_back({0, 0.5, {0, -W}});
  const Response r = solver.solve(load);
  EXPECT_NEAR(r.reactions[0].force.x, 0.5 * W / std::tan(angle), 1e-11);
  EXPECT_NEAR(r.reactions[0].force.y, W, 1e-11);
  EXPECT_NEAR(r.reactions[1].force.x, -0.5 * W / std::tan(angle), 1e-11);
}

TEST(Beam, InfluenceVectorsGiveTheSolvedForcesForRandomFramesAndLoads) {
  for (int seed = 1; seed <= test_scale(40); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(static_cast<unsigned>(seed));
    std::uniform_real_distribution<double> unit(-1, 1), share(0, 1);
    Structure s;
    s.nodes = {{{0, 0}}, {{0.2, 3}}, {{3, 3.5}}, {{6, 3}}, {{6.1, 0}}};
    for (int i = 0; i < 4; ++i) {
      Member m{i, i + 1, MemberKind::Beam};
      m.modulus = 2e11;
      m.area = 0.01 * (1.5 + unit(random));
      m.second_moment = 1e-4 * (1.5 + unit(random));
      s.members.push_back(m);
    }
    s.members[1].hinge_b = seed % 2 == 0;
    s.members[3].hinge_b = seed % 3 == 0;
    s.supports = {{0, SupportKind::Fixed}, {4, seed % 5 == 0 ? SupportKind::Pinned : SupportKind::Fixed}};
    StructureSolver solver(s);
    ASSERT_TRUE(solver.determinacy().stable()) << solver.determinacy().sentence();
    Load load;
    for (int k = 0; k < 5; ++k) {
      load.spans.push_back({k % 4, share(random), {1000 * unit(random), 1000 * unit(random)}});
      load.lines.push_back({k % 4, {300 * unit(random), 300 * unit(random)}});
      load.nodes.push_back({k % 5, {1000 * unit(random), 1000 * unit(random)}});
    }
    load.nodes.push_back({1, {}, 500});
    const Response r = solver.solve(load);
    for (int member = 0; member < 4; ++member) {
      const double at = share(random);
      const SectionForce f = section_force(s, load, r, member, at);
      using Kind = Quantity::Kind;
      EXPECT_NEAR(solver.value(solver.influence({Kind::Axial, member, at}), load), f.axial, 1e-6);
      EXPECT_NEAR(solver.value(solver.influence({Kind::Shear, member, at}), load), f.shear, 1e-6);
      EXPECT_NEAR(solver.value(solver.influence({Kind::Moment, member, at}), load), f.moment, 1e-6);
    }
    for (int k = 0; k < 2; ++k) {
      using Kind = Quantity::Kind;
      const Reaction& reaction = r.reactions[static_cast<std::size_t>(k)];
      EXPECT_NEAR(solver.value(solver.influence({Kind::ReactionX, k}), load), reaction.force.x, 1e-6);
      EXPECT_NEAR(solver.value(solver.influence({Kind::ReactionY, k}), load), reaction.force.y, 1e-6);
      EXPECT_NEAR(solver.value(solver.influence({Kind::ReactionMoment, k}), load), reaction.moment, 1e-6);
    }
  }
}

TEST(Beam, WithoutStiffnessForcesAreTheLeastThatBalance) {
  // A frame that is clamped at both feet; forces are orthogonal to all states of self-stress.
  Structure s;
  s.nodes = {{{0, 0}}, {{0, 3}}, {{4, 4}}, {{5, 0}}};
  for (int i = 0; i < 3; ++i) s.members.push_back({i, i + 1, MemberKind::Beam});
  s.supports = {{0, SupportKind::Fixed}, {3, SupportKind::Fixed}};
  StructureSolver solver(s);
  ASSERT_EQ(solver.method(), ForceMethod::MinimumNorm);
  Load load;
  load.nodes = {{1, {100, -50}, 30}, {2, {0, -70}}};
  const Response response = solver.solve(load);
  EXPECT_LT(response.residual, 1e-12);
  const auto states = solver.self_stresses();
  ASSERT_EQ(states.size(), 3u);
  for (const std::vector<MemberForce>& state : states) {
    double product = 0;
    for (std::size_t m = 0; m < state.size(); ++m) {
      const double span = member_length(s, static_cast<int>(m));
      const MemberForce &x = state[m], &y = response.members[m];
      product += x.axial * y.axial + (x.moment_a * y.moment_a + x.moment_b * y.moment_b) / (span * span);
    }
    EXPECT_NEAR(product, 0, 1e-9);
  }
}

/// 4 m long and slender.
Structure one_member(MemberKind kind) {
  Structure s;
  s.nodes = {{{0, 0}}, {{4, 0}}};
  Member m{0, 1, kind, 2e11, 0.01};
  m.second_moment = 1e-9;
  m.depth = 0.1;
  m.strength = 1e9;
  s.members = {m};
  return s;
}

TEST(MemberStress, IsLookedAtOnBothSidesOfALoadAlongTheMember) {
  // Pulled at its middle, pushed along its length: the largest pull is just before the middle.
  Structure s = one_member(MemberKind::Beam);
  s.supports = {{0, SupportKind::Fixed}};
  Load load;
  const double pull = 1000, push = 100;
  load.spans = {{0, 0.5, {pull, 0}}};
  load.lines = {{0, {-push, 0}}};
  StructureSolver solver(s);
  const MemberStress stress = member_stress(s, load, solver.solve(load), 0);
  EXPECT_NEAR(stress.tension, (pull - 2 * push) / 0.01, 1e-3);
  EXPECT_NEAR(stress.compression, 2 * push / 0.01, 1e-3);
  EXPECT_NEAR(stress.share, 0.5, 1e-9);
}

TEST(MemberStress, APartThatBucklesIsSqueezedHoweverHardTheRestIsPulled) {
  // Held at both ends and loaded along it: one half is pulled, the other pushed.
  const Structure s = one_member(MemberKind::Bar);
  const double least = buckling_load(s, 0);
  for (const double side : {1.0, -1.0}) {
    Load load;
    load.spans = {{0, 0.5, {side * 6 * least, 0}}};
    Response response;
    response.members = {{least, 0, 0}};  // 4 and -2 times the buckling load
    const MemberStress stress = member_stress(s, load, response, 0);
    EXPECT_TRUE(stress.buckles) << side;
    EXPECT_TRUE(stress.squeezed) << side;
    EXPECT_NEAR(stress.utilisation, 2, 1e-9) << side;
  }
}

}  // namespace beam_test
}  // namespace skerry::statics::test
