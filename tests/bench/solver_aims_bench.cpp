// SPDX-License-Identifier: MIT
//
// The solvers' speed aims, one row each, beside ten sweeps of projected Gauss-Seidel on the same island in
// the same run; see kUsage.
#include <cstdio>
#include <cstring>
#include <functional>

#include "physics/solver/auto.h"
#include "physics/solver/body_space.h"
#include "physics/solver/body_space_model.h"
#include "physics/solver/impact_law.h"
#include "physics/solver/run_pooling.h"
#include "physics/solver/small_exact.h"
#include "physics/spare.h"
#include "tests/bench/arguments.h"
#include "tests/bench/solver_timing.h"
#include "tests/support/island_scenes.h"

namespace {

using namespace skerry;
using bench::Timing;
using scenes::Scene;

struct Reading {
  Timing time;            // [s]
  double residual = 0;    // of the last answer
  double ten_sweeps = 0;  // [s]; 0: none to compare with
  double sweeps_residual = 0;
  int factorisations = 0;  // of the last answer
};

struct Job {
  const char* name;
  double aim;  // in `unit`; 0: none
  double unit;
  const char* unit_name;
  std::function<Reading()> run;
};

// Adds the sweeps of the same run.
Reading beside_sweeps(Reading reading, const IslandSystem& system) {
  reading.ten_sweeps = bench::pgs_sweeps(system, 10);
  reading.sweeps_residual = find_solver("pgs").solve(system, {}, {.max_iterations = 10}, nullptr).residual;
  return reading;
}

Reading small(int height, bool batched) {
  std::vector<Scene> islands;
  SmallBatch batch;
  for (int lane = 0; lane < SmallBatch::kLanes; ++lane) {
    islands.push_back(scenes::stack(height, {.noise = 1e-3, .seed = static_cast<std::uint64_t>(lane + 1)}));
    batch.set(lane, islands.back().system);
  }
  const IslandSystem& system = islands[0].system;
  Reading r;
  if (batched) {
    r.time = bench::time_calls([&] { batch.solve(); }, 200);
    r.time = {r.time.least / SmallBatch::kLanes, r.time.median / SmallBatch::kLanes};
    r.residual = batch.residual(0);
  } else {
    r.time = bench::time_calls(
        [&] {
          Solution solution = solve_small_exact(system, {}, {}, nullptr);
          r.residual = solution.residual;
          give_spare(std::move(solution.lambda));  // as the step does
        },
        200);
  }
  return beside_sweeps(r, system);
}

// A contact, of a chain of random velocities, in which some discs part, or of one at rest that a disc hits.
Scene row_of_discs(int count, bool hit) {
  return scenes::chain(count, {.noise = hit ? 0.0 : 1.0});
}

Reading chain(int count, bool hit) {
  const Scene scene = row_of_discs(count, hit);
  const SolverEntry& solver = find_solver("tridiagonal");
  Reading r;
  r.time = bench::time_calls(
      [&] {
        Solution solution = solver.solve(scene.system, {}, {}, nullptr);
        r.residual = solution.residual;
        give_spare(std::move(solution.lambda));  // as the step does
      },
      count < 1000 ? 20 : 1);
  r = beside_sweeps(r, scene.system);
  for (double* t : {&r.time.least, &r.time.median, &r.ten_sweeps}) *t /= count;
  return r;
}

// The same without the island: W along the path is there as packed numbers, and the answer is not judged but
// after the clock has stopped.
Reading packed_chain(int count, bool hit) {
  const Scene scene = row_of_discs(count, hit);
  std::vector<PathRow> rows(scene.system.rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& row = scene.system.rows[i];
    const double left = scene.system.bodies[static_cast<std::size_t>(row.a)].linear,
                 right = scene.system.bodies[static_cast<std::size_t>(row.b)].linear;
    rows[i] = {left + right, i > 0 ? left : 0, scene.system.b[i]};
  }
  RunPooling pass;
  std::vector<double> impulse(rows.size() + 1);
  Reading r;
  r.time = bench::time_calls(
      [&] {
        if (pass.join_rows(
                static_cast<int>(rows.size()), 0, [&](int k, PathRow& to) __attribute__((always_inline)) {
                  to = rows[static_cast<std::size_t>(k)];
                  return true;
                }))
          pass.solve(impulse.data());
      },
      count < 1000 ? 20 : 1);
  impulse.pop_back();
  r.residual = natural_map_residual(scene.system, impulse);
  r = beside_sweeps(r, scene.system);
  for (double* t : {&r.time.least, &r.time.median, &r.ten_sweeps}) *t /= count;
  return r;
}

Reading cradle(int count) {
  ImpactProblem problem;
  problem.solver = &find_solver("auto");
  problem.system = scenes::chain(count).system;
  problem.velocity.assign(static_cast<std::size_t>(count), {0, 0, 0});
  problem.velocity[0] = {1, 0, 0};
  problem.drive.assign(problem.system.rows.size(), 0);
  problem.restitution.assign(problem.system.rows.size(), 1);
  Reading r;
  r.time = bench::time_calls([&] {
    const ImpactResult result = find_impact_law("reflections").apply(problem);
    r.residual = std::abs(result.velocity.back()[0] - 1);
  });
  return r;
}

Reading cold(const Scene& scene, double tolerance) {
  Reading r;
  r.time = bench::time_calls([&] {
    const Solution s = solve_body_space(scene.system, {}, {.tolerance = tolerance}, nullptr);
    r.residual = s.residual;
    r.factorisations = s.work.factorisations;
  });
  return beside_sweeps(r, scene.system);
}

Reading skip(const Scene& scene) {
  std::unique_ptr<SolverMemory> memory;
  const Solution first = solve_body_space(scene.system, {}, {}, &memory);
  Reading r;
  r.time = bench::time_calls(
      [&] { r.residual = solve_body_space(scene.system, first.lambda, {}, &memory).residual; });
  return beside_sweeps(r, scene.system);
}

// One body of a resting scene is pushed sideways, and the push is taken away again.
Reading local_change(const Scene& scene, int body, double speed) {
  IslandSystem pushed = scene.system;
  for (std::size_t i = 0; i < pushed.rows.size(); ++i) {
    if (pushed.rows[i].a == body) pushed.b[i] -= pushed.rows[i].Ja[0] * speed;
    if (pushed.rows[i].b == body) pushed.b[i] -= pushed.rows[i].Jb[0] * speed;
  }
  std::unique_ptr<SolverMemory> memory;
  Solution s = solve_body_space(scene.system, {}, {}, &memory);
  bool push = false;
  Reading r;
  r.time = bench::time_calls([&] {
    push = !push;
    s = solve_body_space(push ? pushed : scene.system, s.lambda, {}, &memory);
    r.residual = std::max(r.residual, s.residual);
    r.factorisations = s.work.factorisations;
  });
  return beside_sweeps(r, pushed);
}

// Velocities of a stack whose middle is pushed, step by step without moving it: warm, most contacts of the
// middle slip and open, the rest of the stack feels it.
Reading pushed_stack(int height, int steps) {
  const Scene scene = scenes::stack(height);
  const double fall = scene.free_velocity[0][1];
  std::vector<std::array<double, 3>> velocity(scene.system.bodies.size(), {0, 0, 0});
  for (int k = 45 * height / 100; k < 55 * height / 100; ++k) velocity[static_cast<std::size_t>(k)][0] = 1.5;
  IslandSystem system = scene.system;
  std::unique_ptr<SolverMemory> memory;
  std::vector<double> lambda = solve_auto(system, {}, {}, &memory).lambda, times;
  Reading r;
  for (int step = 0; step < steps; ++step) {
    for (auto& v : velocity) v[1] += fall;
    for (std::size_t i = 0; i < system.rows.size(); ++i) {
      const Row& row = system.rows[i];
      double u = 0;
      if (row.a >= 0) u += along(row.Ja, velocity[static_cast<std::size_t>(row.a)]);
      if (row.b >= 0) u += along(row.Jb, velocity[static_cast<std::size_t>(row.b)]);
      system.b[i] = -u;
    }
    const double begin = bench::thread_seconds();
    const Solution s = solve_auto(system, lambda, {}, &memory);
    times.push_back(bench::thread_seconds() - begin);
    lambda = s.lambda;
    apply_impulses(system, lambda, velocity);
    r.residual = std::max(r.residual, s.residual);
    r.factorisations += s.work.factorisations;
  }
  // The aim is a mean: a few steps take nearly all of the time.
  double sum = 0;
  for (const double t : times) sum += t;
  std::sort(times.begin(), times.end());
  r.time = {sum / steps, times[times.size() / 2]};
  r.factorisations /= steps;
  return beside_sweeps(r, scene.system);
}

// One factorisation, or one solve with the factor, in units of a Gauss-Seidel sweep.
Reading in_sweeps(const Scene& scene, bool factor) {
  BodySpaceModel model;
  SolveWork work;
  std::vector<double> g(scene.system.rows.size()), h(g.size()), k(g.size(), 1.0), d(g.size());
  model.assign(scene.system, work);
  for (int i = 0; i < model.rows(); ++i) g[static_cast<std::size_t>(i)] = 1e7 / model.row(i).D;
  Reading r;
  if (!model.factor(g.data(), h.data(), work)) return r;
  const double sweep = bench::pgs_sweeps(scene.system, 1);
  r.time = bench::time_calls([&] {
    if (factor)
      (void)model.factor(g.data(), h.data(), work);
    else
      model.solve(k.data(), g.data(), h.data(), d.data(), work);
  });
  r.time = {r.time.least / sweep, r.time.median / sweep};
  return r;
}

std::vector<Job> jobs() {
  const scenes::SceneOptions smooth{.friction = 0};
  constexpr double ns = 1e-9, us = 1e-6, ms = 1e-3;
  return {
      {"box on the floor", 80, ns, "ns", [] { return small(1, false); }},
      {"box on the floor, batch of 8", 12, ns, "ns", [] { return small(1, true); }},
      {"8 bodies, 16 contacts", 1.1, us, "us", [] { return small(8, false); }},
      {"8 bodies, 16 contacts, batch of 8", 0.17, us, "us", [] { return small(8, true); }},
      {"chain of 100, a contact", 7, ns, "ns", [] { return chain(100, false); }},
      {"chain of 10000, a contact", 7, ns, "ns", [] { return chain(10000, false); }},
      {"chain of 100000, a contact", 7, ns, "ns", [] { return chain(100000, false); }},
      {"chain of 100 hit, a contact", 7, ns, "ns", [] { return chain(100, true); }},
      {"chain of 10000 hit, a contact", 7, ns, "ns", [] { return chain(10000, true); }},
      {"chain of 100000 hit, a contact", 7, ns, "ns", [] { return chain(100000, true); }},
      {"chain of 100, elimination alone", 7, ns, "ns", [] { return packed_chain(100, false); }},
      {"chain of 10000, elimination alone", 7, ns, "ns", [] { return packed_chain(10000, false); }},
      {"chain of 100000, elimination alone", 7, ns, "ns", [] { return packed_chain(100000, false); }},
      {"chain of 100 hit, elimination alone", 7, ns, "ns", [] { return packed_chain(100, true); }},
      {"chain of 10000 hit, elimination alone", 7, ns, "ns", [] { return packed_chain(10000, true); }},
      {"chain of 100000 hit, elimination alone", 7, ns, "ns", [] { return packed_chain(100000, true); }},
      {"cradle of 10000, impact", 14, ms, "ms", [] { return cradle(10000); }},
      {"pyramid 20 at rest, verified skip", 0.02, ms, "ms", [] { return skip(scenes::pyramid(20)); }},
      {"pyramid 50 at rest, verified skip", 0.11, ms, "ms", [] { return skip(scenes::pyramid(50)); }},
      {"pyramid 100 at rest, verified skip", 0.46, ms, "ms", [] { return skip(scenes::pyramid(100)); }},
      {"pyramid 100, top box pushed", 4, ms, "ms",
       [] { return local_change(scenes::pyramid(100), 5049, 0.5); }},
      {"pyramid 100, box in the middle pushed", 4, ms, "ms",
       [] { return local_change(scenes::pyramid(100), 3000, 0.5); }},
      {"stack 100 pushed, mean of 60 steps", 0.45, ms, "ms", [] { return pushed_stack(100, 60); }},
      {"stack 1000 cold to 1e-12", 1.2, ms, "ms", [] { return cold(scenes::stack(1000), 1e-12); }},
      {"pyramid 100 cold, no friction", 26, ms, "ms",
       [smooth] { return cold(scenes::pyramid(100, smooth), 1e-10); }},
      {"pyramid 100 cold, friction", 120, ms, "ms", [] { return cold(scenes::pyramid(100), 1e-10); }},
      {"stack 1000: factorisation in sweeps", 8, 1, "", [] { return in_sweeps(scenes::stack(1000), true); }},
      {"stack 1000: re-solve in sweeps", 1.5, 1, "", [] { return in_sweeps(scenes::stack(1000), false); }},
      {"pyramid 100: factorisation in sweeps", 8, 1, "",
       [] { return in_sweeps(scenes::pyramid(100), true); }},
      {"pyramid 100: re-solve in sweeps", 1.5, 1, "", [] { return in_sweeps(scenes::pyramid(100), false); }},
  };
}

constexpr const char* kUsage =
    R"(usage: solver_aims_bench [--csv] [FILTER]

One row an aim whose name has the filter in it. Aim and times in the same unit; least and median of repeated
calls, processor time of one thread. A row that is not reached says so; the residual shows what the time
bought, and what the ten sweeps leave.
)";

int run(int argc, char** argv) {
  bool csv = false;
  const char* filter = "";
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "--csv") == 0)
      csv = true;
    else if (argv[i][0] == '-' || *filter != '\0')
      throw bench::BadArgument(std::string(argv[i]) + ": expected --csv or one filter");
    else
      filter = argv[i];
  }
  const std::vector<Job> all = jobs();
  bench::expect_part("row", filter, bench::names_of(all));
  if (csv)
    std::printf("row,unit,aim,least,median,aims,of_ten_sweeps,residual,ten_sweeps_residual,factorisations\n");
  else
    std::printf("%-40s %8s %9s %9s %6s  %9s %9s %9s %5s\n", "row", "aim", "least", "median", "x aim",
                "x 10 PGS", "residual", "10 PGS's", "fact");
  for (const Job& job : all) {
    if (std::strstr(job.name, filter) == nullptr) continue;
    const Reading r = job.run();
    const double least = r.time.least / job.unit, median = r.time.median / job.unit;
    const double share = r.ten_sweeps > 0 ? r.time.least / r.ten_sweeps : 0;
    if (csv) {
      std::printf("\"%s\",%s,%g,%g,%g,%g,%g,%g,%g,%d\n", job.name, job.unit_name, job.aim, least, median,
                  least / job.aim, share, r.residual, r.sweeps_residual, r.factorisations);
    } else {
      std::printf("%-40s %5g %-2s %9.4g %9.4g %6.2f  %9.3g %9.1e %9.1e %5d\n", job.name, job.aim,
                  job.unit_name, least, median, least / job.aim, share, r.residual, r.sweeps_residual,
                  r.factorisations);
    }
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return bench::run_with_arguments("solver_aims_bench", kUsage, argc, argv, run);
}
