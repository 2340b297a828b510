// SPDX-License-Identifier: MIT
//
// Solvers on frozen scenes, cold: time of a solve, residual, rows, iterations. As CSV:
//   solver_bench --benchmark_format=csv
// Time of a chain a contact: divide by the counter `contacts`.
#include <benchmark/benchmark.h>
#include <string>

#include "physics/solver/solver.h"
#include "tests/support/island_scenes.h"

namespace skerry {
namespace {

struct NamedScene {
  const char* name;
  IslandSystem system;
};

std::vector<NamedScene> make_scenes() {
  const scenes::SceneOptions frictionless{.friction = 0};
  std::vector<NamedScene> list;
  list.push_back({"disc_on_floor", scenes::disc_heap(1).system});
  list.push_back({"box_on_floor", scenes::box_on_floor().system});
  list.push_back({"chain_100", scenes::chain(100, {.noise = 1}).system});
  list.push_back({"chain_10000", scenes::chain(10000, {.noise = 1}).system});
  list.push_back({"chain_100000", scenes::chain(100000, {.noise = 1}).system});
  list.push_back({"pushed_chain_100000", scenes::chain(100000).system});
  list.push_back({"stack_10", scenes::stack(10).system});
  list.push_back({"stack_100", scenes::stack(100).system});
  list.push_back({"stack_100_frictionless", scenes::stack(100, frictionless).system});
  list.push_back({"stack_100_noise", scenes::stack(100, {.noise = 0.1}).system});
  list.push_back({"pyramid_10", scenes::pyramid(10).system});
  list.push_back({"pyramid_20", scenes::pyramid(20).system});
  list.push_back({"pyramid_20_frictionless", scenes::pyramid(20, frictionless).system});
  return list;
}

/// Dense methods take seconds beyond this, long chains of sweeps say nothing new.
bool worth_running(const SolverEntry& solver, const IslandSystem& system) {
  const bool dense = solver.name == "dense_lu" || solver.name == "incremental_ldlt" || solver.name == "lemke";
  if (dense && system.rows.size() > 200) return false;
  return system.rows.size() < 5000 || solver.name == "tridiagonal";
}

void solve_scene(benchmark::State& state, const SolverEntry& solver, const IslandSystem& system) {
  Solution solution;
  for (auto _ : state) {
    solution = solver.solve(system, {}, {}, nullptr);
    benchmark::DoNotOptimize(solution.lambda.data());
  }
  int contacts = 0;
  for (const Row& row : system.rows) contacts += row.kind == RowKind::Normal;
  state.counters["residual"] = solution.residual;
  state.counters["rows"] = static_cast<double>(system.rows.size());
  state.counters["contacts"] = contacts;
  state.counters["iterations_used"] = solution.iterations;
  state.counters["factorisations"] = solution.work.factorisations;
  state.SetLabel(std::string(to_string(solution.status)));
}

void measure_residual(benchmark::State& state, const IslandSystem& system) {
  const Solution solution = find_solver("nncg").solve(system, {}, {.max_iterations = 10}, nullptr);
  for (auto _ : state) benchmark::DoNotOptimize(natural_map_residual(system, solution.lambda));
}

}  // namespace
}  // namespace skerry

int main(int argc, char** argv) {
  const std::vector<skerry::NamedScene> list = skerry::make_scenes();
  for (const skerry::NamedScene& scene : list) {
    for (const skerry::SolverEntry& solver : skerry::solvers()) {
      if (!skerry::worth_running(solver, scene.system)) continue;
      const skerry::Solution trial = solver.solve(scene.system, {}, {}, nullptr);
      if (trial.status == skerry::SolveStatus::Unsupported) continue;
      const std::string name = std::string(solver.name) + "/" + scene.name;
      benchmark::RegisterBenchmark(name.c_str(), [&](benchmark::State& state) {
        skerry::solve_scene(state, solver, scene.system);
      })->Unit(benchmark::kMicrosecond);
    }
    benchmark::RegisterBenchmark(
        (std::string("residual/") + scene.name).c_str(),
        [&](benchmark::State& state) { skerry::measure_residual(state, scene.system); })
        ->Unit(benchmark::kMicrosecond);
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
}
