// SPDX-License-Identifier: MIT
//
// Exact solves in body space beside projected Gauss-Seidel sweeps, on frozen scenes: cold start, one
// factorisation, one re-solve with a kept factor, verified skip. Counters: contacts, factorisations,
// residual, and the time as a multiple of one and of ten PGS sweeps measured in the same run.
#include <algorithm>
#include <benchmark/benchmark.h>
#include <chrono>
#include <string>
#include <utility>

#include "physics/solver/body_space.h"
#include "physics/solver/body_space_model.h"
#include "physics/solver/small_exact.h"
#include "tests/support/island_scenes.h"

namespace {

using namespace skerry;
using scenes::Scene;
using scenes::SceneOptions;

struct NamedScene {
  const char* name;
  Scene (*make)(const SceneOptions&);
};
const NamedScene kScenes[] = {
    {"box", [](const SceneOptions& o) { return scenes::stack(1, o); }},
    {"stack_8", [](const SceneOptions& o) { return scenes::stack(8, o); }},
    {"stack_10", [](const SceneOptions& o) { return scenes::stack(10, o); }},
    {"stack_100", [](const SceneOptions& o) { return scenes::stack(100, o); }},
    {"stack_1000", [](const SceneOptions& o) { return scenes::stack(1000, o); }},
    {"pyramid_10", [](const SceneOptions& o) { return scenes::pyramid(10, o); }},
    {"pyramid_30", [](const SceneOptions& o) { return scenes::pyramid(30, o); }},
    {"pyramid_100", [](const SceneOptions& o) { return scenes::pyramid(100, o); }},
    {"wall_30x30", [](const SceneOptions& o) { return scenes::wall(30, 30, false, o); }},
    {"wall_sides_30x30", [](const SceneOptions& o) { return scenes::wall(30, 30, true, o); }},
    {"triangle_300", [](const SceneOptions& o) { return scenes::disc_heap(24, o); }},
    {"triangle_3003", [](const SceneOptions& o) { return scenes::disc_heap(77, o); }},
};

using Clock = std::chrono::steady_clock;

double seconds(Clock::time_point from) {
  return std::chrono::duration<double>(Clock::now() - from).count();
}

// Least time of a few calls.
template <class F>
double least_time(F&& f, int calls) {
  double least = kInfinity;
  for (int k = 0; k < calls; ++k) {
    const auto begin = Clock::now();
    f();
    least = std::min(least, seconds(begin));
  }
  return least;
}

// One sweep is the difference between many and few, so that the set-up does not count.
double pgs_sweep_time(const IslandSystem& system) {
  const SolverEntry& pgs = find_solver("pgs");
  const auto run = [&](int sweeps) {
    return least_time(
        [&] {
          benchmark::DoNotOptimize(
              pgs.solve(system, {}, {.tolerance = 0, .max_iterations = sweeps}, nullptr));
        },
        5);
  };
  return std::max(1e-9, (run(41) - run(1)) / 40);
}

enum class What { Cold, Factor, Resolve, Skip };

void run(benchmark::State& state, const NamedScene& named, const SceneOptions& options, What what) {
  const Scene scene = named.make(options);
  const IslandSystem& system = scene.system;
  double least = kInfinity;
  Solution solution = solve_body_space(system, {}, {}, nullptr);
  std::unique_ptr<SolverMemory> memory;
  if (what == What::Skip || what == What::Resolve) solution = solve_body_space(system, {}, {}, &memory);
  IslandSystem heavier = system;
  for (double& b : heavier.b) b *= 1.01;

  BodySpaceModel model;
  SolveWork work;
  std::vector<double> g(system.rows.size()), h(g.size()), k(g.size(), 1.0), d(g.size());
  if (what == What::Factor) {
    model.assign(system, work);
    for (int i = 0; i < model.rows(); ++i) g[static_cast<std::size_t>(i)] = 1e7 / model.row(i).D;
  }
  bool up = false;
  for (auto _ : state) {
    up = !up;
    const auto begin = Clock::now();
    switch (what) {
      case What::Cold:
        solution = solve_body_space(system, {}, {}, nullptr);
        break;
      case What::Factor:
        benchmark::DoNotOptimize(model.factor(g.data(), h.data(), work));
        break;
      case What::Resolve:
        // The load goes up and down; states and factor stay.
        solution = solve_body_space(up ? heavier : system, solution.lambda, {}, &memory);
        break;
      case What::Skip:
        solution = solve_body_space(system, solution.lambda, {}, &memory);
        break;
    }
    least = std::min(least, seconds(begin));
  }
  const double sweep = pgs_sweep_time(system);
  state.counters["contacts"] = static_cast<double>(std::count_if(
      system.rows.begin(), system.rows.end(), [](const Row& row) { return row.kind == RowKind::Normal; }));
  state.counters["least_us"] = least * 1e6;
  state.counters["sweeps"] = least / sweep;
  state.counters["per_10_sweeps"] = least / (10 * sweep);
  if (what != What::Factor) {
    state.counters["residual"] = solution.residual;
    state.counters["factorisations"] = solution.work.factorisations;
  }
}

// Small islands: one through the solver's interface, eight side by side without it.
void run_small(benchmark::State& state, int height, bool batched) {
  std::vector<Scene> islands;
  SmallBatch batch;
  for (int lane = 0; lane < SmallBatch::kLanes; ++lane) {
    islands.push_back(scenes::stack(height, {.noise = 1e-3, .seed = static_cast<std::uint64_t>(lane + 1)}));
    batch.set(lane, islands.back().system);
  }
  const IslandSystem& system = islands[0].system;
  double least = kInfinity, residual = 0;
  const int repeats = 64;
  for (auto _ : state) {
    const auto begin = Clock::now();
    for (int k = 0; k < repeats; ++k) {
      if (batched) {
        batch.solve();
        benchmark::DoNotOptimize(batch);
      } else {
        residual = solve_small_exact(system, {}, {}, nullptr).residual;
      }
    }
    least = std::min(least, seconds(begin) / (batched ? repeats * SmallBatch::kLanes : repeats));
  }
  if (batched) residual = batch.residual(0);
  const double sweep = pgs_sweep_time(system);
  state.counters["least_ns"] = least * 1e9;
  state.counters["per_10_sweeps"] = least / (10 * sweep);
  state.counters["residual"] = residual;
}

}  // namespace

int main(int argc, char** argv) {
  const std::pair<const char*, What> jobs[] = {
      {"cold", What::Cold}, {"factor", What::Factor}, {"resolve", What::Resolve}, {"skip", What::Skip}};
  for (const NamedScene& scene : kScenes)
    for (const double friction : {0.0, 0.5})
      for (const double noise : {0.0, 0.3})
        for (const auto& [job, what] : jobs) {
          if (noise > 0 && what != What::Cold) continue;
          const std::string name = std::string(scene.name) + (friction > 0 ? "/friction" : "/smooth") +
                                   (noise > 0 ? "/shock/" : "/rest/") + job;
          const SceneOptions options{.friction = friction, .noise = noise};
          benchmark::RegisterBenchmark(
              name.c_str(),
              [&scene, options, what = what](benchmark::State& state) { run(state, scene, options, what); })
              ->Unit(benchmark::kMicrosecond)
              ->MinTime(0.05);
        }
  for (const int height : {1, 2, 4, 8})
    for (const bool batched : {false, true}) {
      const std::string name = "small/stack_" + std::to_string(height) + (batched ? "/batch" : "/single");
      benchmark::RegisterBenchmark(name.c_str(), [height, batched](benchmark::State& state) {
        run_small(state, height, batched);
      })->MinTime(0.05);
    }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
}
