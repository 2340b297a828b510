// SPDX-License-Identifier: MIT
#include "physics/solver/small_exact.h"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "physics/solver/body_space.h"
#include "physics/solver/contact_states.h"
#include "physics/solver/simd.h"
#include "physics/solver/small_sticking.h"
#include "physics/solver/small_topology.h"
#include "physics/spare.h"

#if defined(__x86_64__)
#define SKERRY_AVX512 __attribute__((target("avx512f,avx512dq,avx512vl")))
#else
#define SKERRY_AVX512
#endif

namespace skerry {
namespace {

using namespace small;

void solve_one_group_portable(const Topology& t, OneGroup& n) {
  solve_one_group(t, n);
}
SKERRY_AVX2 void solve_one_group_avx2(const Topology& t, OneGroup& n) {
  solve_one_group(t, n);
}
void solve_one_portable(const Topology& t, OneIsland& n) {
  solve_groups(t, n);
}
SKERRY_AVX2 void solve_one_avx2(const Topology& t, OneIsland& n) {
  solve_groups(t, n);
}
template <class V>
SKERRY_ALWAYS_INLINE void solve_side_by_side(const Topology& t, Islands<V>& n) {
  if (t.tower && t.bodies == 1)
    stick_edge(n.slot, n.inverse_mass[0], n.residual);
  else
    solve_small(t, n);
}
void solve_eight_portable(const Topology& t, EightIslands& n) {
  for (Islands<Lanes2>& two : n.two) solve_side_by_side(t, two);
}
SKERRY_AVX2 void solve_eight_avx2(const Topology& t, EightIslands& n) {
  for (Islands<Vec4>& four : n.four) solve_side_by_side(t, four);
}
SKERRY_AVX512 void solve_eight_avx512(const Topology& t, EightIslands& n) {
  solve_side_by_side(t, n.eight);
}

void begin_answer(std::size_t rows, double residual, Solution& solution) {
  solution.status = SolveStatus::Solved;
  solution.method = "small_exact";
  solution.lambda = take_spare<std::vector<double>>();
  solution.lambda.resize(rows);
  solution.residual = residual;
  solution.iterations = 1;
}

void note_sticking(const SolveOptions& options, Solution& solution) {
  if (!options.trace) return;
  solution.trace = std::make_unique<SolveTrace>();
  solution.trace->notes.emplace_back("small island, everything sticks");
}

// Points that are close to each other say less of how the body turns: what is worse than this is for the
// steps that always reach rounding.
constexpr double kEdgeTolerance = 1e-13;

// Its numbers by way of `put(T&, double)`.
template <class N, class Put>
SKERRY_ALWAYS_INLINE void read_edge(const IslandSystem& system, N& n, Put&& put) {
  put(n.inverse_mass[0][0], system.bodies[0].linear);
  put(n.inverse_mass[0][1], system.bodies[0].linear);
  put(n.inverse_mass[0][2], system.bodies[0].angular);
  const bool swapped = system.rows[0].a == 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Row& row = system.rows[i];
    const std::array<double, 3>& J = swapped ? row.Ja : row.Jb;
    for (std::size_t c = 0; c < 3; ++c) put(n.slot[i].Jb[c], J[c]);
    put(n.slot[i].b, system.b[i]);
    put(n.slot[i].mu, row.mu);
  }
}

const Row kNoRow{};

void read_numbers(const IslandSystem& system, const Topology& t, OneIsland& n) {
  for (std::size_t j = 0; j < system.bodies.size(); ++j) {
    n.inverse_mass[j][0] = n.inverse_mass[j][1] = system.bodies[j].linear;
    n.inverse_mass[j][2] = system.bodies[j].angular;
  }
  for (int k = 0; k < t.groups; ++k) {
    const Group& group = t.group[at(k)];
    Slot<Vec4>& slot = n.slot[k];
    const Row* const row = &system.rows[at(group.first)];
    const double* const b = &system.b[at(group.first)];
    const Row &r0 = row[0], &r1 = group.count > 1 ? row[1] : kNoRow, &r2 = group.count > 2 ? row[2] : kNoRow,
              &r3 = group.count > 3 ? row[3] : kNoRow;
    const bool swapped = r0.a > r0.b;
    const auto gather = [](Vec4(&to)[3], const auto& j0, const auto& j1, const auto& j2, const auto& j3) {
      for (std::size_t c = 0; c < 3; ++c) to[c] = Vec4{j0[c], j1[c], j2[c], j3[c]};
    };
    if (swapped)
      gather(slot.Jb, r0.Ja, r1.Ja, r2.Ja, r3.Ja);
    else
      gather(slot.Jb, r0.Jb, r1.Jb, r2.Jb, r3.Jb);
    if (group.a >= 0) {
      if (swapped)
        gather(slot.Ja, r0.Jb, r1.Jb, r2.Jb, r3.Jb);
      else
        gather(slot.Ja, r0.Ja, r1.Ja, r2.Ja, r3.Ja);
    }
    slot.b = Vec4{b[0], group.count > 1 ? b[1] : 0, group.count > 2 ? b[2] : 0, group.count > 3 ? b[3] : 0};
    slot.mu = Vec4{r0.mu, r1.mu, r2.mu, r3.mu};
  }
}

// One row a slot, by way of `put(T&, double)`.
template <class N, class Put>
SKERRY_ALWAYS_INLINE void read_rows(const IslandSystem& system, const Topology& t, N& n, Put&& put) {
  for (std::size_t j = 0; j < system.bodies.size(); ++j) {
    put(n.inverse_mass[j][0], system.bodies[j].linear);
    put(n.inverse_mass[j][1], system.bodies[j].linear);
    put(n.inverse_mass[j][2], system.bodies[j].angular);
  }
  for (int k = 0; k < t.groups; ++k) {
    const Group& group = t.group[at(k)];
    for (int i = 0; i < group.slots(); ++i) {
      auto& slot = n.slot[group.slot + i];
      const bool there = i < group.count;
      const Row& row = there ? system.rows[at(group.first + i)] : kNoRow;
      const bool swapped = row.a > row.b;
      const auto &Ja = swapped ? row.Jb : row.Ja, &Jb = swapped ? row.Ja : row.Jb;
      for (std::size_t c = 0; c < 3; ++c) put(slot.Jb[c], Jb[c]);
      if (group.a >= 0)
        for (std::size_t c = 0; c < 3; ++c) put(slot.Ja[c], Ja[c]);
      put(slot.b, there ? system.b[at(group.first + i)] : 0);
      put(slot.mu, row.mu);
    }
  }
}

void read_numbers(const IslandSystem& system, const Topology& t, OneGroup& n) {
  read_rows(system, t, n, [](double& to, double from) { to = from; });
}
template <class V>
void read_numbers(const IslandSystem& system, const Topology& t, int lane, Islands<V>& n) {
  read_rows(system, t, n, [lane](V& to, double from) { to[lane] = from; });
}

// f(the vectors that this processor takes side by side, the lane in them)
template <class F>
void at_lane(EightIslands& n, int lane, F&& f) {
  if (cpu_has_avx512())
    f(n.eight, lane);
  else if (cpu_has_avx2())
    f(n.four[lane / 4], lane % 4);
  else
    f(n.two[lane / 2], lane % 2);
}

void read_lane(const IslandSystem& system, const Topology& t, int lane, EightIslands& n) {
  at_lane(n, lane, [&](auto& islands, int k) { read_numbers(system, t, k, islands); });
}

void solve_one(const Topology& t, OneGroup& n) {
  if (cpu_has_avx2())
    solve_one_group_avx2(t, n);
  else
    solve_one_group_portable(t, n);
}
void solve_one(const Topology& t, OneIsland& n) {
  if (cpu_has_avx2())
    solve_one_avx2(t, n);
  else
    solve_one_portable(t, n);
}

// The answer that everything sticks. @param impulse  of a group's row
template <class Impulse>
void tell(const Topology& t, double residual, Impulse&& impulse, Solution& solution) {
  begin_answer(at(t.rows), residual, solution);
  double* to = solution.lambda.data();
  for (int k = 0; k < t.groups; ++k)
    for (int i = 0; i < t.group[at(k)].count; ++i) *to++ = impulse(k, i);
}

// What `Sticking` does.
void count_work(Solution& solution) {
  solution.work.factorisations = 1;
  solution.work.resolves = kSteps;
}

// Edges and towers, by formula. @return false, and `solution` as it was, where the island is none, or does
// not stick, or not to the last digits
bool try_tower(const IslandSystem& system, const SolveOptions& options, Solution& solution) {
  const double tolerance = std::min(options.tolerance, kEdgeTolerance);
  if (is_edge(system)) {
    OneGroup n;
    read_edge(system, n, [](double& to, double from) { to = from; });
    stick_edge(n.slot, n.inverse_mass[0], n.residual);
    if (!(n.residual <= tolerance)) return false;
    begin_answer(4, n.residual, solution);
    for (std::size_t i = 0; i < 4; ++i) solution.lambda[i] = n.slot[i].lambda;
  } else {
    Topology t;
    if (!read_tower(system, t)) return false;
    OneIsland n;
    read_numbers(system, t, n);
    solve_one(t, n);
    if (!(n.residual <= tolerance)) return false;
    tell(
        t, n.residual, [&](int k, int i) { return n.slot[k].lambda[i]; }, solution);
  }
  note_sticking(options, solution);
  return true;
}

}  // namespace

bool fits_small_exact(const IslandSystem& system) {
  Topology topology;
  return read_topology(system, topology);
}

bool try_small_exact(const IslandSystem& system, const SolveOptions& options, Solution& solution) {
  if (try_tower(system, options, solution)) return true;
  Topology topology;
  if (!read_topology(system, topology)) return false;
  if (topology.bodies == 1 && topology.groups == 1) {
    OneGroup numbers;
    read_numbers(system, topology, numbers);
    solve_one(topology, numbers);
    if (!(numbers.residual <= options.tolerance)) return false;
    tell(
        topology, numbers.residual, [&](int, int i) { return numbers.slot[i].lambda; }, solution);
  } else {
    OneIsland numbers;
    read_numbers(system, topology, numbers);
    solve_one(topology, numbers);
    if (!(numbers.residual <= options.tolerance)) return false;
    tell(
        topology, numbers.residual, [&](int k, int i) { return numbers.slot[k].lambda[i]; }, solution);
  }
  count_work(solution);
  note_sticking(options, solution);
  return true;
}

Solution solve_small_exact(const IslandSystem& system, std::span<const double> warm_start,
                           const SolveOptions& options, std::unique_ptr<SolverMemory>* memory) {
  Solution solution;
  if (!try_small_exact(system, options, solution))
    solution = solve_body_space(system, warm_start, options, memory);
  return solution;
}

struct SmallBatch::Data {
  Topology topology;
  bool any = false;
  EightIslands numbers;
};

SmallBatch::SmallBatch() : data_(std::make_unique<Data>()) {}
SmallBatch::~SmallBatch() = default;
SmallBatch::SmallBatch(SmallBatch&&) noexcept = default;
SmallBatch& SmallBatch::operator=(SmallBatch&&) noexcept = default;

bool SmallBatch::set(int lane, const IslandSystem& system) {
  if (lane < 0 || lane >= kLanes)
    throw std::invalid_argument("SmallBatch: lane " + std::to_string(lane) + " of 8");
  Topology topology;
  if (!read_tower(system, topology) && !read_topology(system, topology)) return false;
  if (data_->any && !(topology == data_->topology)) return false;
  if (!data_->any) {
    // Lanes that stay empty must be harmless: they all start as this island.
    data_->topology = topology;
    data_->any = true;
    for (int k = 0; k < kLanes; ++k) read_lane(system, topology, k, data_->numbers);
  }
  read_lane(system, topology, lane, data_->numbers);
  return true;
}

void SmallBatch::solve() {
  if (!data_->any) return;
  if (cpu_has_avx512())
    solve_eight_avx512(data_->topology, data_->numbers);
  else if (cpu_has_avx2())
    solve_eight_avx2(data_->topology, data_->numbers);
  else
    solve_eight_portable(data_->topology, data_->numbers);
}

double SmallBatch::residual(int lane) const {
  double residual = kInfinity;
  if (data_->any)
    at_lane(data_->numbers, lane, [&](auto& islands, int k) { residual = islands.residual[k]; });
  return data_->topology.tower && !(residual <= kEdgeTolerance) ? kInfinity : residual;
}

Solution SmallBatch::solution(int lane) const {
  const Topology& t = data_->topology;
  Solution solution;
  at_lane(data_->numbers, lane, [&](auto& islands, int k) {
    const auto impulse = [&](int group, int i) {
      return islands.slot[t.group[at(group)].slot + i].lambda[k];
    };
    tell(t, islands.residual[k], impulse, solution);
  });
  if (!data_->topology.tower) count_work(solution);
  return solution;
}

std::vector<Solution> solve_batch(std::span<const IslandSystem* const> systems, const SolveOptions& options) {
  std::vector<Solution> solutions(systems.size());
  for (std::size_t first = 0; first < systems.size();) {
    SmallBatch batch;
    int lanes = 0;
    while (lanes < SmallBatch::kLanes && first + at(lanes) < systems.size() &&
           batch.set(lanes, *systems[first + at(lanes)]))
      ++lanes;
    if (lanes > 1) batch.solve();
    for (int lane = 0; lane < std::max(1, lanes); ++lane) {
      const IslandSystem& system = *systems[first + at(lane)];
      Solution& solution = solutions[first + at(lane)];
      if (lanes > 1 && batch.residual(lane) <= options.tolerance) {
        solution = batch.solution(lane);
      } else {
        solution = solve_small_exact(system, {}, options, nullptr);
      }
    }
    first += at(std::max(1, lanes));
  }
  return solutions;
}

extern const SolverEntry kSmallExactEntry;
const SolverEntry kSmallExactEntry = {
    .name = "small_exact",
    .summary = "fixed-size body space on the stack for small islands; else body_space",
    .reference = "physics/README.md",
    .exact = true,
    .friction = true,
    .bilateral = true,
    .solve = solve_small_exact,
};

}  // namespace skerry
