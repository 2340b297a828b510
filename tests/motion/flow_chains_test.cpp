// SPDX-License-Identifier: MIT
//
// Chains under load in flow: a ball on light links breaks a wall, in whole steps as in shorter ones. And what
// springs hold that swing faster than a step.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "tests/support/worlds.h"

namespace skerry {
namespace flow_chains_test {

constexpr double kStep = 1.0 / 60;

struct Found {
  double farthest = -10;  ///< the ball came [m]
  double apart = 0;       ///< ends that are one, or too far from each other [m]
  double gained = 0;      ///< energy, of what there was
  int fallen = 0;         ///< bricks
  int flowing = 0;        ///< steps
};

struct Link {
  BodyId a, b;
  Vec2 on_a, on_b;  ///< in their frames
};

/// A ball of `mass` [kg] on 18 links of 1 kg, plates or the rods, ropes and springs between discs, swings
/// into a wall; 3.5 s in steps of 1 / (60 cuts) s.
Found swing(JointKind kind, double mass, int cuts) {
  World world;
  test::add_ground(world, test::rough(make_box({1, 1}), 0.6));
  constexpr int count = 18;
  constexpr double length_of_link = 0.4, radius = 0.8, angle = -1.15;
  const Vec2 along{std::sin(angle), -std::cos(angle)}, top{0, 9.2};
  const bool hinged = kind == JointKind::Revolute;
  std::vector<Link> links;
  const auto join = [&](BodyId a, BodyId b, Vec2 at, Vec2 to) {
    JointDef joint{.kind = kind, .a = a, .b = b, .anchor_a = at, .anchor_b = to};
    if (kind == JointKind::Spring) {
      joint.stiffness = 1e6;
      joint.damping = 1000;
    }
    world.create_joint(joint);
    if (!a) return;
    const auto local = [&](BodyId body, Vec2 p) {
      return inverse_rotate(Rot::from_angle(world.angle(body)), p - world.position(body));
    };
    links.push_back({a, b, local(a, at), local(b, to)});
  };
  BodyId last;
  Vec2 at = top;
  for (int k = 0; k < count; ++k) {
    const Vec2 next = at + length_of_link * along;
    if (hinged) {
      const BodyId link = test::add(world, 0.5 * (at + next), test::rough(make_box({0.38, 0.1}), 0.6), 1, {},
                                    0, angle - kPi / 2);
      join(last, link, at, at);
      last = link;
    } else {
      const BodyId link = test::add(world, next, test::rough(make_disc(0.06), 0.6), 1);
      join(last, link, at, next);
      last = link;
    }
    at = next;
  }
  const BodyId ball = test::add(world, at + radius * along, test::rough(make_disc(radius), 0.6), mass);
  join(last, ball, at, hinged ? at : at + 0.06 * along);
  std::vector<BodyId> bricks;
  std::vector<double> height;
  for (int row = 0; row < 11; ++row) {
    double x = 1.1;
    for (int k = 0; k < 4 + row % 2; ++k) {
      const bool half = row % 2 == 1 && (k == 0 || k == 4);
      const double width = half ? 0.35 : 0.7;
      bricks.push_back(test::add(world, {x + width / 2, 0.2 + 0.4 * row},
                                 test::rough(make_box({width - 0.01, 0.4}), 0.6), half ? 10 : 20));
      height.push_back(world.position(bricks.back()).y);
      x += width;
    }
  }
  Found found;
  const double energy = world.kinetic_energy() + world.potential_energy();
  for (int step = 0; step < 210 * cuts; ++step) {
    found.flowing += world.step(kStep / cuts).islands_in_flow > 0;
    found.farthest = std::max(found.farthest, world.position(ball).x);
    found.gained = std::max(found.gained, (world.kinetic_energy() + world.potential_energy()) / energy - 1);
    for (const Link& link : links) {
      const auto end = [&](BodyId body, Vec2 local) {
        return world.position(body) + rotate(Rot::from_angle(world.angle(body)), local);
      };
      const double distance = length(end(link.b, link.on_b) - end(link.a, link.on_a));
      const double wanted = hinged ? 0 : &link == &links.back() ? 0.06 : length_of_link;
      found.apart =
          std::max(found.apart, kind == JointKind::Rope ? distance - wanted : std::abs(distance - wanted));
    }
  }
  for (std::size_t i = 0; i < bricks.size(); ++i)
    found.fallen += world.position(bricks[i]).y < height[i] - 0.2;
  return found;
}

TEST(FlowOfChains, ABallOnLightLinksBreaksAWallAsItDoesInShorterSteps) {
  struct Kind {
    JointKind kind;
    const char* name;
  };
  for (const auto& [kind, name] : {Kind{JointKind::Revolute, "plates"}, Kind{JointKind::Distance, "rods"},
                                   Kind{JointKind::Rope, "ropes"}, Kind{JointKind::Spring, "springs"}}) {
    for (const double mass : {500.0, 2000.0}) {
      SCOPED_TRACE(std::string(name) + ", " + std::to_string(mass) + " kg");
      const Found whole = swing(kind, mass, 1), shorter = swing(kind, mass, 6);
      std::printf(
          "%s, %.0f kg: the ball comes to %.2f m (in sixths %.2f), %d bricks fall (%d), ends apart by %.5f m "
          "(%.5f), %d steps in flow\n",
          name, mass, whole.farthest, shorter.farthest, whole.fallen, shorter.fallen, whole.apart,
          shorter.apart, whole.flowing);
      EXPECT_GT(whole.flowing, 30);
      // At nearly the same angles ten plates with 500 kg come to 1.5 to 2.1 m (in sixths to 1.9 to 2.4), ten
      // ropes with 2000 kg nine times to 4.9 to 5.6 m; a wall of bricks that does not give way stops them
      // before 1 m.
      EXPECT_GT(whole.farthest, 0.7 * shorter.farthest);
      EXPECT_LT(whole.farthest, 1.4 * shorter.farthest);
      // In nine runs of nearly the same ropes 13 to 44 of them.
      EXPECT_GT(whole.fallen, 10);
      EXPECT_LT(whole.gained, 1e-5);
      // Springs give under their load.
      EXPECT_LT(whole.apart, kind == JointKind::Spring ? 1.1 * shorter.apart : 0.005);
    }
  }
}

/// Balls of 20 kg fall onto discs of half a kilogram that springs hold between two walls.
TEST(FlowOfChains, ATrampolineGivesBackNoMoreThanItGot) {
  for (const char* stepper : {"time_stepping", "event_driven", "auto"}) {
    SCOPED_TRACE(stepper);
    WorldConfig config;
    config.stepper = stepper;
    World world(config);
    test::add_ground(world, test::rough(make_box({1, 1}), 0.6));
    const auto wall = [&](double x) {
      const BodyId body = world.create_body({.type = BodyType::Static, .position = {x, 3}});
      world.add_shape(body, test::rough(make_box({0.4, 0.4}), 0.6));
      return body;
    };
    const auto spring = [&](BodyId a, BodyId b, Vec2 at, Vec2 to) {
      world.create_joint({.kind = JointKind::Spring,
                          .a = a,
                          .b = b,
                          .anchor_a = at,
                          .anchor_b = to,
                          .stiffness = 2e4,
                          .damping = 20});
    };
    constexpr int count = 16;
    BodyId last = wall(-4.4);
    Vec2 at{-4.2, 3};
    for (int k = 0; k < count; ++k) {
      const Vec2 next{-4.2 + 8.4 * (k + 1) / (count + 1), 3};
      const BodyId disc = test::add(world, next, test::rough(make_disc(0.15), 0.6), 0.5);
      spring(last, disc, at, next);
      last = disc;
      at = next;
    }
    spring(last, wall(4.4), at, {4.2, 3});
    for (int k = 0; k < 6; ++k)
      test::add(world, {-1.5 + 0.6 * k, 5 + 0.7 * (k % 2)}, test::rough(make_disc(0.28), 0.6), 20);
    const double energy = world.kinetic_energy() + world.potential_energy();
    double most = 0;
    for (int step = 0; step < 300; ++step) {
      world.step(kStep);
      most = std::max(most, world.kinetic_energy() + world.potential_energy());
    }
    std::printf("%s: at most %.4f of the energy\n", stepper, most / energy);
    EXPECT_LE(most, energy * (1 + 1e-4));
  }
}

/// A ball of 100 kg falls onto a block of small discs that stiff springs hold: they swing forty times to and
/// fro in a step, of which contacts end many a piece.
TEST(StiffSprings, OfABlockUnderAHeavyBallGainNoEnergy) {
  World world;
  test::add_ground(world, test::rough(make_box({1, 1}), 0.6));
  constexpr int side = 6;
  std::vector<BodyId> discs;
  const auto place = [](int row, int column) { return Vec2{0.4 * column, 2 + 0.4 * row}; };
  const auto at = [](int row, int column) {
    return static_cast<std::size_t>(row) * side + static_cast<std::size_t>(column);
  };
  for (int row = 0; row < side; ++row)
    for (int column = 0; column < side; ++column)
      discs.push_back(test::add(world, place(row, column), test::rough(make_disc(0.15), 0.6), 0.2));
  const auto spring = [&](int row, int column, int to_row, int to_column) {
    if (to_row >= side || to_column < 0 || to_column >= side) return;
    world.create_joint({.kind = JointKind::Spring,
                        .a = discs[at(row, column)],
                        .b = discs[at(to_row, to_column)],
                        .anchor_a = place(row, column),
                        .anchor_b = place(to_row, to_column),
                        .stiffness = 3e5,
                        .damping = 10});
  };
  for (int row = 0; row < side; ++row) {
    for (int column = 0; column < side; ++column) {
      spring(row, column, row, column + 1);
      spring(row, column, row + 1, column);
      spring(row, column, row + 1, column + 1);
      spring(row, column, row + 1, column - 1);
    }
  }
  test::add(world, {1, 7}, test::rough(make_disc(0.5), 0.6), 100);
  const double energy = world.kinetic_energy() + world.potential_energy();
  double before = energy, jump = 0, most = 0;
  for (int step = 0; step < 300; ++step) {
    world.step(kStep);
    const double now = world.kinetic_energy() + world.potential_energy();
    jump = std::max(jump, now - before);
    most = std::max(most, now);
    before = now;
  }
  std::printf("at most %.5f of the energy, largest jump %.5f\n", most / energy, jump / energy);
  EXPECT_LE(most, energy * (1 + 1e-4));
  EXPECT_LE(jump, 0.005 * energy);
}

}  // namespace flow_chains_test
}  // namespace skerry
