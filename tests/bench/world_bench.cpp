// SPDX-License-Identifier: MIT
//
// Whole steps of a world, and impacts. Counters: residual of the contact problem, bodies, contact points.
#include <algorithm>
#include <benchmark/benchmark.h>
#include <chrono>
#include <cmath>
#include <random>

#include "physics/solver/impact_law.h"
#include "tests/support/pile.h"
#include "tests/support/worlds.h"

namespace {

using namespace skerry;
using namespace skerry::test;

void set_counters(benchmark::State& state, const World& world) {
  state.counters["bodies"] = world.report().dynamic_bodies;
  state.counters["points"] = world.report().contact_points;
  state.counters["residual"] = world.report().worst_residual;
}

WorldConfig on_grid(bool reuse) {
  WorldConfig config;
  config.sleep = false;
  config.broad_phase = "uniform_grid";
  config.reuse_resting = reuse;
  return config;
}

void add_pyramid(World& world, int base) {
  add_ground(world, rough(make_disc(1), 0.5));
  for (int row = 0; row < base; ++row) {
    for (int i = 0; i < base - row; ++i) add(world, {i + 0.5 * row, row + 0.5}, rough(make_box({1, 1}), 0.5));
  }
}

/// A step of a pyramid at rest and awake; the second argument is whether islands at rest are kept.
void PyramidAtRest(benchmark::State& state) {
  World world(on_grid(state.range(1) != 0));
  add_pyramid(world, static_cast<int>(state.range(0)));
  for (int i = 0; i < 3; ++i) world.step(1.0 / 60);
  for (auto _ : state) world.step(1.0 / 60);
  set_counters(state, world);
}
BENCHMARK(PyramidAtRest)
    ->Args({20, 0})
    ->Args({20, 1})
    ->Args({50, 0})
    ->Args({50, 1})
    ->Args({100, 0})
    ->Args({100, 1})
    ->Unit(benchmark::kMicrosecond);

/// A world in which everything sleeps: pairs of boxes on a floor; the second argument is 1 if a small disc is
/// rolling about besides.
void Sleeping(benchmark::State& state) {
  World world;
  add_ground(world, rough(make_disc(1), 0.5));
  const int count = static_cast<int>(state.range(0));
  for (int i = 0; i < count / 2; ++i) {
    add(world, {2.0 * i, 0.5}, rough(make_box({1, 1}), 0.5));
    add(world, {2.0 * i, 1.5}, rough(make_box({1, 1}), 0.5));
  }
  for (int i = 0; i < 4; ++i) world.step(1.0 / 60);
  if (state.range(1) != 0) add(world, {-5, 0.5}, rough(make_disc(0.5), 0.5), 1, {-1, 0}, 2);
  for (auto _ : state) world.step(1.0 / 60);
  set_counters(state, world);
  state.counters["asleep"] = world.report().bodies_asleep;
}
BENCHMARK(Sleeping)
    ->Args({1000, 0})
    ->Args({10000, 0})
    ->Args({100000, 0})
    ->Args({100000, 1})
    ->Unit(benchmark::kMicrosecond);

/// A stack that is pushed sideways at every step, so that every step has a new load.
void StackPushed(benchmark::State& state) {
  World world(on_grid(true));
  add_ground(world, rough(make_disc(1), 0.5));
  const int count = static_cast<int>(state.range(0));
  std::vector<BodyId> boxes;
  for (int i = 0; i < count; ++i) boxes.push_back(add(world, {0, i + 0.5}, rough(make_box({1, 1}), 0.5)));
  for (int i = 0; i < 3; ++i) world.step(1.0 / 60);
  int step = 0;
  for (auto _ : state) {
    world.apply_force(boxes[count / 2], {0.01 * (step++ % 7), 0}, world.position(boxes[count / 2]));
    world.step(1.0 / 60);
  }
  set_counters(state, world);
}
BENCHMARK(StackPushed)->Arg(10)->Arg(30)->Arg(100)->Unit(benchmark::kMicrosecond);

/// Small islands far from each other that are never at rest: stacks of boxes with a rough fall and a bounce
/// (0), or with forces that change at every step (1). Arguments: which, how many, boxes in each.
void SmallIslands(benchmark::State& state) {
  const bool pushed = state.range(0) != 0;
  const int count = static_cast<int>(state.range(1)), boxes = static_cast<int>(state.range(2));
  constexpr int kSteps = 60;
  for (auto _ : state) {
    state.PauseTiming();
    WorldConfig config;
    config.sleep = false;
    World world(config);
    add_ground(world, rough(make_disc(1), 0.5));
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> any(-1, 1);
    std::vector<BodyId> all;
    for (int i = 0; i < count; ++i) {
      for (int k = 0; k < boxes; ++k) {
        const double x = 8.0 * i + (pushed ? 0.05 : 0.1) * any(random);
        all.push_back(pushed ? add(world, {x, k + 0.5}, rough(make_box({1, 1}), 0.5))
                             : add(world, {x, 0.7 + 1.3 * k}, rough(make_box({1, 1}), 0.5, 0.6), 1,
                                   {any(random), 0}, any(random)));
      }
    }
    state.ResumeTiming();
    for (int step = 0; step < kSteps; ++step) {
      for (std::size_t i = 0; pushed && i < all.size(); ++i)
        world.apply_force(all[i], {6 * any(random), 0}, world.position(all[i]));
      world.step(1.0 / 60);
    }
    state.PauseTiming();
    set_counters(state, world);
    state.ResumeTiming();
  }
  state.counters["island_steps/s"] =
      benchmark::Counter(static_cast<double>(count) * kSteps, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(SmallIslands)
    ->Args({0, 200, 1})
    ->Args({0, 200, 3})
    ->Args({1, 200, 2})
    ->Args({1, 50, 5})
    ->Unit(benchmark::kMillisecond);

/// Bodies that fly and meet nothing.
void Flight(benchmark::State& state) {
  WorldConfig config = on_grid(true);
  config.gravity = {0, 0};  // else they get so fast that they might meet
  World world(config);
  for (int i = 0; i < state.range(0); ++i)
    add(world, {3.0 * (i % 100), 3.0 * (i / 100)}, smooth(make_disc(0.5)));
  for (auto _ : state) world.step(1.0 / 60);
  set_counters(state, world);
}
BENCHMARK(Flight)->Arg(1)->Arg(1000)->Arg(10000)->Unit(benchmark::kMicrosecond);

/// One ball on the ground that rolls: what a single-body scene costs.
void OneBodyRolling(benchmark::State& state) {
  World world;
  add_ground(world, rough(make_disc(1), 0.5), -0.01);
  add(world, {0, 0.5}, rough(make_disc(0.5), 0.5));
  for (auto _ : state) world.step(1.0 / 60);
  set_counters(state, world);
}
BENCHMARK(OneBodyRolling)->Unit(benchmark::kMicrosecond);

/// The impact law alone on a row of touching discs, the first of which arrives.
void CradleImpact(benchmark::State& state) {
  const int count = static_cast<int>(state.range(0));
  ImpactProblem problem;
  problem.solver = &find_solver("auto");
  for (int i = 0; i < count; ++i) {
    problem.system.bodies.push_back({1, 8});
    problem.system.positions.push_back({static_cast<double>(i), 0});
    problem.velocity.push_back({i == 0 ? 1.0 : 0.0, 0, 0});
  }
  for (int i = 0; i + 1 < count; ++i) {
    Row row;
    row.a = i;
    row.b = i + 1;
    row.Ja = {-1, 0, 0};
    row.Jb = {1, 0, 0};
    problem.system.rows.push_back(row);
  }
  problem.drive.assign(problem.system.rows.size(), 0);
  problem.restitution.assign(problem.system.rows.size(), 1);
  double error = 0;
  for (auto _ : state) {
    const ImpactResult result = find_impact_law("reflections").apply(problem);
    error = std::abs(result.velocity.back()[0] - 1);
    for (int i = 0; i + 1 < count; ++i) error = std::max(error, std::abs(result.velocity[i][0]));
  }
  state.counters["error"] = error;
}
BENCHMARK(CradleImpact)->Arg(5)->Arg(50)->Arg(1000)->Arg(10000)->Unit(benchmark::kMicrosecond);

enum class Pile { Plain, Drag, OneDrag, Wind, Planet, BouncesALittle, BouncesWell, OneBall };

/// Steps of 400 boxes and discs that fall into a pit: 4 s. What acts on them, or how they bounce, should make
/// no difference; exactly (flow_work 0) for comparison.
void FallingPile(benchmark::State& state, Pile pile, bool exactly) {
  WorldConfig config;
  if (exactly) config.flow_work = 0;
  if (pile == Pile::Planet) config.gravity = {};
  World world(config);
  const double bounce = pile == Pile::BouncesALittle ? 0.4 : pile == Pile::BouncesWell ? 0.6 : 0;
  if (pile != Pile::Planet) add_pit(world, bounce);
  const std::vector<BodyId> bodies =
      add_pile(world, 400, bounce, pile == Pile::Planet ? Vec2{-6, -12} : Vec2{-6, 1});
  for (const BodyId body : bodies) {
    if (pile == Pile::Drag || (pile == Pile::OneDrag && body == bodies.front()))
      world.set_drag(body, {.linear = 0.05});
  }
  if (pile == Pile::Wind)
    world.set_force_field([](const FieldSample& s) {
      return Wrench{{0.1 * s.mass * std::sin(s.time), 0}, 0};
    });
  if (pile == Pile::Planet)
    world.set_force_field([](const FieldSample& s) {
      return Wrench{-9.81 * s.mass / std::max(1.0, length(s.position)) * s.position, 0};
    });
  if (pile == Pile::OneBall) {
    ShapeDef ball = rough(make_disc(0.2), 0.5, 0.9);
    ball.restitution_rule = MixingRule::Maximum;
    add(world, {0.2, 0.5}, ball);
  }
  int flowing = 0;
  for (auto _ : state) flowing += world.step(1.0 / 60).islands_in_flow > 0;
  set_counters(state, world);
  state.counters["flowing"] = flowing;
}

void four_seconds(benchmark::internal::Benchmark* benchmark) {
  benchmark->Iterations(240)->Unit(benchmark::kMillisecond);
}
BENCHMARK_CAPTURE(FallingPile, plain, Pile::Plain, false)->Apply(four_seconds);
BENCHMARK_CAPTURE(FallingPile, drag, Pile::Drag, false)->Apply(four_seconds);
BENCHMARK_CAPTURE(FallingPile, one_feels_drag, Pile::OneDrag, false)->Apply(four_seconds);
BENCHMARK_CAPTURE(FallingPile, wind, Pile::Wind, false)->Apply(four_seconds);
BENCHMARK_CAPTURE(FallingPile, planet, Pile::Planet, false)->Apply(four_seconds);
BENCHMARK_CAPTURE(FallingPile, bounces_a_little, Pile::BouncesALittle, false)->Apply(four_seconds);
BENCHMARK_CAPTURE(FallingPile, bounces_well, Pile::BouncesWell, false)->Apply(four_seconds);
BENCHMARK_CAPTURE(FallingPile, one_ball_bounces, Pile::OneBall, false)->Apply(four_seconds);
BENCHMARK_CAPTURE(FallingPile, drag_exactly, Pile::Drag, true)->Apply(four_seconds);
BENCHMARK_CAPTURE(FallingPile, planet_exactly, Pile::Planet, true)->Apply(four_seconds);
BENCHMARK_CAPTURE(FallingPile, bounces_well_exactly, Pile::BouncesWell, true)->Apply(four_seconds);

/// The same of 300 that are welded to blocks, 6 s: as one body each, or with all rows for comparison.
void FallingBlocks(benchmark::State& state, bool as_one) {
  WorldConfig config;
  config.solve.welds_as_one = as_one;
  World world(config);
  add_pit(world);
  add_blocks(world, 300, static_cast<int>(state.range(0)), 1);
  int flowing = 0;
  double slowest = 0;
  for (auto _ : state) {
    const auto start = std::chrono::steady_clock::now();
    flowing += world.step(1.0 / 60).islands_in_flow > 0;
    slowest =
        std::max(slowest, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  set_counters(state, world);
  state.counters["flowing"] = flowing;
  state.counters["slowest_ms"] = 1e3 * slowest;
}
BENCHMARK_CAPTURE(FallingBlocks, as_one, true)
    ->DenseRange(2, 5)
    ->Arg(7)
    ->Iterations(360)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(FallingBlocks, all_rows, false)
    ->DenseRange(2, 5)
    ->Arg(7)
    ->Iterations(360)
    ->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();
