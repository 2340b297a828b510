// SPDX-License-Identifier: MIT
//
// Work and precision: every solver on the frozen scenes, cold, the time that it takes to a residual of 1e-2,
// 1e-4, 1e-8 and 1e-12 (or the rounding floor), and the share of scenes on which it gets there; see kUsage.
// tests/bench/solver_plot.py draws the file.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "tests/bench/arguments.h"
#include "tests/bench/solver_timing.h"
#include "tests/support/island_scenes.h"
#include "tests/support/settled_heap.h"

namespace {

using namespace skerry;
using scenes::Scene;
using scenes::SceneOptions;

struct Frozen {
  const char* name;
  bool large;
  Scene (*make)(const SceneOptions&);
};
const Frozen kFrozen[] = {
    {"stack_10", false, [](const SceneOptions& o) { return scenes::stack(10, o); }},
    {"stack_100", false, [](const SceneOptions& o) { return scenes::stack(100, o); }},
    {"stack_1000", true, [](const SceneOptions& o) { return scenes::stack(1000, o); }},
    {"pyramid_10", false, [](const SceneOptions& o) { return scenes::pyramid(10, o); }},
    {"pyramid_30", false, [](const SceneOptions& o) { return scenes::pyramid(30, o); }},
    {"pyramid_100", true, [](const SceneOptions& o) { return scenes::pyramid(100, o); }},
    {"wall_30x30", true, [](const SceneOptions& o) { return scenes::wall(30, 30, false, o); }},
    {"wall_sides_30x30", true, [](const SceneOptions& o) { return scenes::wall(30, 30, true, o); }},
    {"settled_300", false, [](const SceneOptions& o) { return scenes::settled_discs(300, 20, o); }},
    {"settled_3000", true, [](const SceneOptions& o) { return scenes::settled_discs(3000, 60, o); }},
    {"triangle_300", false, [](const SceneOptions& o) { return scenes::disc_heap(24, o); }},
    {"triangle_3003", true, [](const SceneOptions& o) { return scenes::disc_heap(77, o); }},
};

constexpr double kTargets[] = {1e-2, 1e-4, 1e-8, 1e-12};
// Seconds for one target; a solver that needs longer has not reached it. Only the sweeping ones are cut off.
constexpr double kPatience = 2;

bool sweeps(const SolverEntry& solver) {
  return solver.name == "pgs" || solver.name == "nncg" || solver.name == "tgs_soft";
}
// Dense matrices and single pivots take minutes beyond this.
bool worth_running(const SolverEntry& solver, const IslandSystem& system) {
  if (solver.name == "dense_lu" || solver.name == "incremental_ldlt" || solver.name == "lemke")
    return system.rows.size() <= 200;
  if (solver.name == "sparse_contact") return system.rows.size() <= 2000;
  return true;
}

struct Reached {
  double seconds = kInfinity, residual = kInfinity;
};

// The least time of up to three calls, if the residual is reached.
Reached reach(const SolverEntry& solver, const IslandSystem& system, double target) {
  Reached reached;
  SolveOptions options{.tolerance = target};
  const double begin = bench::thread_seconds();
  if (sweeps(solver)) {
    // As many sweeps as the patience allows, some 20 ns a row each.
    options.max_iterations =
        std::max(1, static_cast<int>(kPatience / (20e-9 * static_cast<double>(system.rows.size()))));
    if (solver.name == "tgs_soft") options.max_iterations = std::min(options.max_iterations, 4096);
  }
  for (int call = 0; call < 3 && bench::thread_seconds() - begin < 0.5 * kPatience; ++call) {
    const double start = bench::thread_seconds();
    const Solution s = solver.solve(system, {}, options, nullptr);
    const double seconds = bench::thread_seconds() - start;
    reached.residual = s.residual;
    const double floor = 16 * residual_floor(system, s.lambda);
    if (s.status == SolveStatus::Unsupported || !(s.residual <= std::max(target, floor))) break;
    reached.seconds = std::min(reached.seconds, seconds);
  }
  return reached;
}

constexpr const char* kUsage =
    R"(usage: solver_precision_bench [--quick] [--scene TEXT] [--solver NAME] [FILE.csv]

Stack of 10, 100, 1000, pyramid of 10, 30, 100, brick wall, wall with sides, heaps of 300 and 3000 discs
that settled in a box: at rest and after a violent shock, with friction and without, 40 problems. Besides 8
of triangles of discs in hexagonal packing, which no friction of 0.5 holds. Writes solver_precision.csv where
no file is named.

options
  --quick         without the six largest scenes
  --scene TEXT    without all whose name does not contain the text
  --solver NAME   without all other solvers
)";

int run(int argc, char** argv) {
  bool quick = false;
  const char *path = nullptr, *part = "", *only = nullptr;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--quick") == 0)
      quick = true;
    else if (std::strcmp(argv[i], "--scene") == 0)
      part = bench::value_of(argc, argv, i);
    else if (std::strcmp(argv[i], "--solver") == 0)
      only = bench::value_of(argc, argv, i);
    else if (argv[i][0] != '-' && path == nullptr)
      path = argv[i];
    else
      throw bench::BadArgument(std::string(argv[i]) +
                               ": expected --quick, --scene TEXT, --solver NAME or one file");
  }
  if (path == nullptr) path = "solver_precision.csv";
  if (only != nullptr) bench::expect_name("solver", only, bench::names_of(solvers()));
  std::vector<std::string> names;
  for (const Frozen& frozen : kFrozen)
    if (!quick || !frozen.large) names.emplace_back(frozen.name);
  bench::expect_part(quick ? "quick scene" : "scene", part, names);
  std::FILE* file = std::fopen(path, "w");
  if (file == nullptr) {
    std::fprintf(stderr, "cannot write %s\n", path);
    return 4;
  }
  std::fprintf(file, "solver,scene,load,friction,contacts,target,seconds,residual\n");
  struct Count {
    int problems = 0, reached[4] = {};
  };
  std::map<std::string, Count> counts;
  for (const Frozen& frozen : kFrozen) {
    if ((quick && frozen.large) || std::strstr(frozen.name, part) == nullptr) continue;
    for (const double friction : {0.0, 0.5})
      for (const double noise : {0.0, 0.3}) {
        const Scene scene = frozen.make({.friction = friction, .noise = noise, .seed = 7});
        const auto contacts = std::count_if(scene.system.rows.begin(), scene.system.rows.end(),
                                            [](const Row& row) { return row.kind == RowKind::Normal; });
        for (const SolverEntry& solver : solvers()) {
          if (only != nullptr && solver.name != only) continue;
          if (!worth_running(solver, scene.system)) continue;
          if (friction > 0 && !solver.friction) continue;
          if (solver.name == "closed_form" || solver.name == "tridiagonal") continue;
          Count& count = counts[std::string(solver.name)];
          ++count.problems;
          bool further = true;
          for (int k = 0; k < 4; ++k) {
            const Reached r = further ? reach(solver, scene.system, kTargets[k]) : Reached{};
            further = std::isfinite(r.seconds);
            count.reached[k] += further;
            if (std::isfinite(r.residual))
              std::fprintf(file, "%s,%s,%s,%g,%d,%g,%g,%g\n", std::string(solver.name).c_str(), frozen.name,
                           noise > 0 ? "shock" : "rest", friction, static_cast<int>(contacts), kTargets[k],
                           further ? r.seconds : 0, r.residual);
          }
        }
        std::fprintf(stderr, "%s friction %g noise %g done\n", frozen.name, friction, noise);
      }
  }
  std::fclose(file);
  std::printf("%-18s %9s %9s %9s %9s %9s\n", "solver", "problems", "1e-2", "1e-4", "1e-8", "1e-12");
  for (const auto& [name, count] : counts)
    std::printf("%-18s %9d %9d %9d %9d %9d\n", name.c_str(), count.problems, count.reached[0],
                count.reached[1], count.reached[2], count.reached[3]);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return bench::run_with_arguments("solver_precision_bench", kUsage, argc, argv, run);
}
