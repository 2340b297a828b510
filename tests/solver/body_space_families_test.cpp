// SPDX-License-Identifier: MIT
//
// Families of cold problems, not favourites: every combination of scene, friction, mass ratio, load and
// doubled contacts that the generator can draw. The share of problems solved is printed for each family, with
// the failures by number; problem k is `draw(k)`. None of these was looked at while the solver was tuned.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <gtest/gtest.h>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "physics/solver/body_space.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace body_space_families_test {

using scenes::MassPattern;
using scenes::Scene;
using scenes::SceneOptions;

struct Problem {
  std::string shape;
  SceneOptions options;
  Scene scene;
};

Problem draw(std::uint64_t number) {
  std::mt19937_64 random(770000 + number);
  const auto pick = [&](auto... values) {
    const double list[] = {static_cast<double>(values)...};
    return list[random() % sizeof...(values)];
  };
  Problem problem;
  SceneOptions& o = problem.options;
  o.friction = pick(0, 0.1, 0.3, 0.5, 1, 10);
  o.mass_ratio = pick(1, 1, 1, 1e3, 1e6);
  o.pattern = static_cast<MassPattern>(1 + random() % 3);
  o.noise = pick(0, 0, 0.01, 0.1, 1);
  o.points_per_edge = static_cast<int>(pick(2, 2, 3));
  o.duplicated = random() % 6 == 0;
  o.seed = number;
  switch (number % 6) {
    case 0:
      problem.shape = "stack";
      problem.scene = scenes::stack(static_cast<int>(pick(2, 5, 10, 30, 100)), o);
      break;
    case 1:
      problem.shape = "pyramid";
      problem.scene = scenes::pyramid(static_cast<int>(pick(3, 6, 10, 15)), o);
      break;
    case 2:
      problem.shape = "wall";
      problem.scene =
          scenes::wall(3 + static_cast<int>(random() % 7), 3 + static_cast<int>(random() % 7), false, o);
      break;
    case 3:
      problem.shape = "wall with sides";
      problem.scene =
          scenes::wall(3 + static_cast<int>(random() % 7), 3 + static_cast<int>(random() % 7), true, o);
      break;
    case 4:
      problem.shape = "heap of discs";
      problem.scene = scenes::disc_heap(static_cast<int>(pick(3, 5, 8, 12)), o);
      break;
    default:
      problem.shape = "random contacts";
      const int bodies = static_cast<int>(pick(3, 6, 12, 25));
      problem.scene = scenes::random_island({.bodies = bodies, .contacts = 2 * bodies}, o);
  }
  return problem;
}

struct Count {
  int solved = 0, total = 0;
  double share() const { return total ? static_cast<double>(solved) / total : 1; }
};

TEST(BodySpaceFamilies, SolveNearlyEverythingCold) {
  const char* scale = std::getenv("SKERRY_TEST_SCALE");
  const std::uint64_t problems = static_cast<std::uint64_t>(240 * (scale ? std::atof(scale) : 1.0));
  std::map<std::string, Count> counts;
  std::string failures;
  std::vector<double> milliseconds;
  for (std::uint64_t k = 1; k <= problems; ++k) {
    const Problem problem = draw(k);
    const SceneOptions& o = problem.options;
    const std::clock_t begin = std::clock();
    const Solution solution = solve_body_space(problem.scene.system, {}, {}, nullptr);
    milliseconds.push_back(1e3 * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC);
    const double residual = natural_map_residual(problem.scene.system, solution.lambda);
    for (const double z : solution.lambda) ASSERT_TRUE(std::isfinite(z)) << "problem " << k;
    const bool solved = residual <= 1e-8;
    // Nothing may be called solved that is not.
    if (solution.status == SolveStatus::Solved) {
      EXPECT_LE(residual, std::max(1e-10, 16 * residual_floor(problem.scene.system, solution.lambda)))
          << "problem " << k;
    }
    if (!solved) failures += " " + std::to_string(k);
    char name[64];
    const auto count = [&](const char* format, auto value) {
      std::snprintf(name, sizeof name, format, value);
      ++counts[name].total;
      counts[name].solved += solved;
    };
    count("%s", "all");
    count("shape %s", problem.shape.c_str());
    count("friction %g", o.friction);
    count("mass ratio %g", o.mass_ratio);
    count("noise %g m/s", o.noise);
    if (o.duplicated) count("%s", "doubled contacts");
    if (o.mass_ratio <= 1e3 && o.friction <= 0.5) count("%s", "mass ratio to 1e3, friction to 0.5");
    if (o.mass_ratio <= 1e3 && o.friction <= 0.5 && o.noise <= 0.1)
      count("%s", "mass ratio to 1e3, friction to 0.5, noise to 0.1 m/s");
  }
  for (const auto& [family, count] : counts)
    std::printf("%-55s %4d of %4d = %5.1f %%\n", family.c_str(), count.solved, count.total,
                100 * count.share());
  std::sort(milliseconds.begin(), milliseconds.end());
  const auto share = [&](double part) {
    return milliseconds[static_cast<std::size_t>(part * static_cast<double>(milliseconds.size() - 1))];
  };
  std::printf("processor time: median %.2f ms, p90 %.1f ms, p99 %.0f ms, largest %.0f ms\n", share(0.5),
              share(0.9), share(0.99), share(1));
  std::printf("not solved to 1e-8:%s\n", failures.empty() ? " none" : failures.c_str());
  EXPECT_GE(counts["friction 0"].share(), 0.97);
  EXPECT_GE(counts["mass ratio to 1e3, friction to 0.5"].share(), 0.99);
  EXPECT_GE(counts["all"].share(), 0.93);
}

}  // namespace body_space_families_test
}  // namespace skerry
