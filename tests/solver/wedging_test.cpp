// SPDX-License-Identifier: MIT
#include "physics/solver/wedging.h"

#include <gtest/gtest.h>
#include <random>

#include "physics/solver/auto.h"
#include "physics/solver/small_states.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace wedging_test {

/// A box of a metre between pegs of the ground at these points of its outline, with its own friction each.
IslandSystem box_between_pegs(double mass, const std::vector<std::array<double, 3>>& pegs, double noise = 0,
                              std::uint64_t seed = 1) {
  scenes::SceneBuilder builder({.friction = 1, .noise = noise, .seed = seed});
  const int box = builder.body({0, 0}, mass, mass / 6);
  for (const auto& [x, y, friction] : pegs) {
    const Vec2 inwards =
        std::abs(x) < std::abs(y) ? Vec2{0, y < 0 ? 1.0 : -1.0} : Vec2{x < 0 ? 1.0 : -1.0, 0};
    builder.contact(-1, box, {x, y}, inwards);
  }
  IslandSystem system = builder.finish().system;
  for (std::size_t k = 0; k < pegs.size(); ++k) system.rows[2 * k + 1].mu = pegs[k][2];
  return system;
}

/// Pegs above, to the left of and below it, between which friction can hold it as tightly as one likes.
IslandSystem tight_box() {
  return box_between_pegs(1000, {{0.029668, 0.5, 0.454207},
                                 {-0.5, -0.362148, 0.395057},
                                 {0.345097, -0.5, 0.45614},
                                 {0.414722, -0.5, 0.630414}});
}

TEST(Wedging, AnAnswerThatPressesForNothingIsTold) {
  const IslandSystem system = tight_box();
  Solution tight;
  ASSERT_TRUE(try_small_states(system, {}, {}, tight));
  EXPECT_LE(natural_map_residual(system, tight.lambda), 1e-10);
  EXPECT_GT(largest_magnitude(tight.lambda), 1e4);
  EXPECT_TRUE(is_wedged(system, tight.lambda));
  EXPECT_GT(self_made_share(system, tight.lambda), 100);

  // Whatever stands on each other does not, be it heavy.
  for (const double ratio : {1.0, 1e6}) {
    const IslandSystem stack =
        scenes::stack(10, {.mass_ratio = ratio, .pattern = scenes::MassPattern::HeavyOnTop}).system;
    const Solution solution = solve_auto(stack, {}, {}, nullptr);
    EXPECT_FALSE(is_wedged(stack, solution.lambda)) << ratio;
    EXPECT_LT(self_made_share(stack, solution.lambda), 2) << ratio;
  }
}

// It was 19 862 N s; the weight of a step is 163.
TEST(Wedging, ABoxBetweenPegsPressesNoHarderThanItMust) {
  const IslandSystem system = tight_box();
  const Solution solution = solve_auto(system, {}, {.trace = true}, nullptr);
  EXPECT_EQ(solution.status, SolveStatus::Solved);
  EXPECT_LE(solution.residual, 1e-10);
  EXPECT_LT(largest_magnitude(solution.lambda), 200);
  EXPECT_GT(solution.trace->notes.size(), 1u);

  // So it does after a step that left the other ones.
  Solution tight;
  ASSERT_TRUE(try_small_states(system, {}, {}, tight));
  const Solution next = solve_auto(system, tight.lambda, {}, nullptr);
  EXPECT_EQ(next.status, SolveStatus::Solved);
  EXPECT_LT(largest_magnitude(next.lambda), 200);
}

// A clamped box is asked for velocities that contradict each other by a thousandth: from the impulses of the
// step before they were "solved" by impulses of 1e10 N s, whose rounding was as large as what was left.
TEST(Wedging, RunawayImpulsesAreNoAnswer) {
  int solved = 0, wedged = 0;
  for (std::uint64_t seed = 2001; seed <= 2400; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> place(-0.45, 0.45), friction(0.1, 1.5), error(-1e-3, 1e-3);
    std::vector<std::array<double, 3>> pegs;
    for (std::size_t k = 0; k < 3 + seed % 3; ++k) {
      const double along = place(random), side = random() % 2 == 0 ? 0.5 : -0.5;
      const bool upright = random() % 2 == 0;
      pegs.push_back({upright ? side : along, upright ? along : side, friction(random)});
    }
    IslandSystem system = box_between_pegs(1, pegs, seed % 2 == 0 ? 1 : 0, seed);
    const Solution before = solve_auto(system, {}, {}, nullptr);
    for (double& b : system.b) b *= 1 + error(random);
    const Solution solution = solve_auto(system, before.lambda, {}, nullptr);
    if (solution.status != SolveStatus::Solved) continue;
    ++solved;
    wedged += is_wedged(system, solution.lambda);
    EXPECT_LE(solution.residual, 1e-9);
  }
  EXPECT_GT(solved, 200);
  EXPECT_LE(wedged, 3);
}

}  // namespace wedging_test
}  // namespace skerry
