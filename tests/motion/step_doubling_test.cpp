// SPDX-License-Identifier: MIT
//
// Error control ends: where no inner step keeps the error that was asked for, a step still costs what an
// island may cost, and says what it could not keep.
#include <cmath>
#include <functional>
#include <gtest/gtest.h>
#include <random>

#include "tests/support/worlds.h"

namespace skerry {
namespace step_doubling_test {

using test::add;
using test::add_ground;
using test::rough;

constexpr double kStep = 1.0 / 60;
// Small, so that a step that would not end takes a moment only.
constexpr double kWork = 3e5;

std::mt19937 generator;
double uniform(double low, double high) {
  return low + (high - low) * (generator() / 4294967296.0);
}

void join(World& world, JointKind kind, BodyId a, BodyId b, Vec2 from, Vec2 to,
          const std::function<void(JointDef&)>& more = {}) {
  JointDef def{.kind = kind, .a = a, .b = b, .anchor_a = from, .anchor_b = to};
  if (more) more(def);
  world.create_joint(def);
}

/// Two boxes with rubbing ground below them.
std::pair<BodyId, BodyId> two_boxes(World& world) {
  add_ground(world, rough(make_disc(1), 0.5, 0.3));
  const BodyId a = add(world, {0, 1.2}, rough(make_box({0.6, 0.4}), 0.5), 1, {1, 0}, uniform(-3, 3));
  const BodyId b = add(world, {1, 1.4}, rough(make_box({0.5, 0.5}), 0.5), 5, {-1, 0}, uniform(-3, 3));
  return {a, b};
}

void stiff_springs(World& world) {
  const auto [a, b] = two_boxes(world);
  for (const double stiffness : {1e4, 1e7, 1e10}) {
    join(world, JointKind::Spring, a, b, {uniform(-0.2, 0.2), 1.2}, {uniform(0.8, 1.2), 1.4},
         [&](JointDef& def) { def.stiffness = stiffness; });
  }
}

void spinning_spring(World& world) {
  const auto [a, b] = two_boxes(world);
  world.set_velocity(a, {}, 1e7);
  join(world, JointKind::Spring, a, b, {0.1, 1.2}, {1, 1.4}, [](JointDef& def) { def.stiffness = 1e3; });
}

/// Rods that cannot all keep their lengths, and a hinge that contradicts them.
void contradicting_joints(World& world) {
  const auto [a, b] = two_boxes(world);
  for (const double length : {0.5, 0.8, 1.3}) {
    join(world, JointKind::Distance, a, b, {0.2, 1.2}, {0.9, 1.4},
         [&](JointDef& def) { def.length = length; });
  }
  join(world, JointKind::Revolute, {}, b, {1, 1.4}, {1, 1.4});
  join(world, JointKind::Revolute, {}, b, {1.2, 1.4}, {1.2, 1.4});
}

/// Gears between the same wheels that want different ratios, while a motor turns one of them.
void contradicting_gears(World& world) {
  const auto [a, b] = two_boxes(world);
  join(world, JointKind::Revolute, {}, a, {0, 1.2}, {}, [](JointDef& def) {
    def.motor_speed = 5;
    def.motor_limit = 100;
  });
  join(world, JointKind::Revolute, {}, b, {1, 1.4}, {});
  for (const double ratio : {0.5, 2.0, -1.0})
    join(world, JointKind::Gear, a, b, {0, 1.2}, {1, 1.4}, [&](JointDef& def) { def.ratio = ratio; });
}

/// A box between the ground and a paddle that comes down.
void press(World& world) {
  two_boxes(world);
  const BodyId paddle = world.create_body(
      {.type = BodyType::Kinematic, .position = {0.5, 2.2}, .velocity = {0, -3}, .omega = 0.1});
  world.add_shape(paddle, rough(make_box({3, 0.3}), 0.5));
}

/// A motor without limit hauls one end of a pulley's rope to its wheel, and on.
void hauled_pulley(World& world) {
  const BodyId hoist =
      world.create_body({.type = BodyType::Kinematic, .position = {0.2, 1.2}, .velocity = {0.3, 0}});
  const BodyId a = add(world, {0.2, 0.5}, rough(make_box({0.2, 0.2}), 0));
  const Vec2 load{2, 0.4 + 0.01 * uniform(0, 1)};
  const BodyId b = add(world, load, rough(make_box({0.2, 0.2}), 0));
  join(world, JointKind::Prismatic, hoist, a, {0.2, 0.5}, {0.2, 0.5}, [](JointDef& def) {
    def.axis = {0, 1};
    def.motor_speed = -2;
  });
  join(world, JointKind::Pulley, a, b, {0.2, 0.5}, load, [](JointDef& def) {
    def.ratio = 0.8;
    def.pulley_a = {0.2, 1};
    def.pulley_b = {2, 1.2};
  });
}

struct Case {
  const char* name;
  void (*build)(World& world);
  int steps = 40;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

class ErrorControl : public testing::TestWithParam<Case> {};

TEST_P(ErrorControl, Ends) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    for (const double accuracy : {1e-3, 1e-6, 1e-10}) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", accuracy " + std::to_string(std::log10(accuracy)));
      generator.seed(seed);
      WorldConfig config;
      config.accuracy = accuracy;
      config.solve.work_limit = kWork;
      World world(config);
      GetParam().build(world);
      for (int k = 0; k < GetParam().steps; ++k) {
        const StepReport& report = world.step(kStep);
        // Half of the limit for tries, and what the last ones cost beyond it.
        ASSERT_LE(report.work.visits, 4 * kWork) << "step " << k;
        ASSERT_LE(report.inner_steps + report.rejected_steps, kWork / 300) << "step " << k;
        // The last 16 steps may each be cut into 256 pieces, and their halves into as many.
        ASSERT_LE(report.substeps, kWork / 100 + 16 * 3 * 256) << "step " << k;
        for (const std::uint32_t i : {1u, 2u}) {
          ASSERT_TRUE(is_finite(world.bodies().position[i]) && is_finite(world.bodies().velocity[i]));
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Of, ErrorControl,
                         testing::Values(Case{"StiffSprings", stiff_springs},
                                         Case{"ASpringOnAFastSpin", spinning_spring, 3},
                                         Case{"ContradictingJoints", contradicting_joints},
                                         Case{"ContradictingGears", contradicting_gears},
                                         Case{"AHauledPulley", hauled_pulley, 21}, Case{"APress", press}),
                         [](const testing::TestParamInfo<Case>& test) { return test.param.name; });

}  // namespace step_doubling_test
}  // namespace skerry
