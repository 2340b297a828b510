// SPDX-License-Identifier: MIT
//
// Structures: factorising, solving one more load with the kept factor, moving an axle, influence lines.
// Counters: members, residual of equilibrium.
#include <benchmark/benchmark.h>

#include "tests/statics/trusses.h"

namespace {

using namespace skerry::statics;
using namespace skerry::statics::test;

/// A Pratt truss with about `members` members; with `redundant` a second diagonal in every panel.
Structure truss(int members, bool redundant) {
  const int panels = (members + 3) / 4;
  Structure s = pratt(panels);
  if (redundant) {
    for (int i = 1; i + 1 < panels; ++i) {
      const bool left = 2 * i < panels;
      s.members.push_back(left ? Member{i, panels + i + 1} : Member{panels + i, i + 1});
      s.members.back().area = 0.01;
      s.members.back().modulus = 2e11;
    }
  }
  return s;
}

void report(benchmark::State& state, const StructureSolver& solver, const Response& response) {
  state.counters["members"] = static_cast<double>(solver.structure().members.size());
  state.counters["residual"] = response.residual;
}

/// A load on every node of the deck, another one each time.
void LoadCase(benchmark::State& state) {
  StructureSolver solver(truss(static_cast<int>(state.range(0)), state.range(1) != 0));
  const int panels = (static_cast<int>(state.range(0)) + 3) / 4;
  Load load;
  for (int i = 1; i < panels; ++i) load.nodes.push_back({i, {0, -1000}});
  Response response;
  int turn = 0;
  for (auto _ : state) {
    load.nodes[static_cast<std::size_t>(turn++ % (panels - 1))].force.y -= 1;
    solver.solve(load, response);
    benchmark::DoNotOptimize(response.members.data());
  }
  report(state, solver, response);
}
BENCHMARK(LoadCase)->ArgsProduct({{200, 1000}, {0, 1}})->Unit(benchmark::kMicrosecond);

/// One axle, at another place each time.
void MovingAxle(benchmark::State& state) {
  StructureSolver solver(truss(static_cast<int>(state.range(0)), state.range(1) != 0));
  const int panels = (static_cast<int>(state.range(0)) + 3) / 4;
  Load load;
  load.spans.push_back({0, 0, {0, -1e5}});
  Response response;
  int turn = 0;
  for (auto _ : state) {
    ++turn;
    load.spans[0].member = turn / 10 % panels;
    load.spans[0].share = turn % 10 / 10.0;
    solver.solve(load, response);
    benchmark::DoNotOptimize(response.members.data());
  }
  report(state, solver, response);
}
BENCHMARK(MovingAxle)->ArgsProduct({{200, 1000}, {0, 1}})->Unit(benchmark::kMicrosecond);

/// The influence line of one member, for all positions at once.
void InfluenceLine(benchmark::State& state) {
  StructureSolver solver(truss(static_cast<int>(state.range(0)), false));
  for (auto _ : state) benchmark::DoNotOptimize(solver.influence({Quantity::Kind::Axial, 7}).force.data());
}
BENCHMARK(InfluenceLine)->Arg(200)->Arg(1000)->Unit(benchmark::kMicrosecond);

/// Analysis and factor from nothing: what a broken member costs.
void Factorise(benchmark::State& state) {
  const Structure s = truss(static_cast<int>(state.range(0)), state.range(1) != 0);
  for (auto _ : state) {
    StructureSolver solver(s);
    benchmark::DoNotOptimize(solver.determinacy().rank);
  }
}
BENCHMARK(Factorise)->ArgsProduct({{200, 1000}, {0, 1}})->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();
