// SPDX-License-Identifier: MIT
//
// Islands of successive steps, from files, solved one after the other: each begins with the impulses that
// its rows had in the one before. A line a solver: the share of steps that reached 1e-8 and 1e-4, residuals,
// times, factorisations a step; see kUsage.
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <unordered_map>

#include "physics/import.h"
#include "tests/bench/arguments.h"
#include "tests/bench/solver_timing.h"

namespace {

using namespace skerry;

struct Choice {
  double work = 0;  // visits a body
  bool cold = false, each_step = false;
};

// What a row is called from step to step.
std::uint64_t name_of(const Row& row) {
  return row.source * 8 + static_cast<std::uint64_t>(row.kind);
}

IslandSystem read(const char* path) {
  std::ifstream in(path);
  if (!in) throw std::runtime_error(std::string(path) + ": cannot be read");
  return read_json(in, path).system;
}

void replay(const SolverEntry& solver, const std::vector<const char*>& files, const Choice& choice) {
  std::unordered_map<std::uint64_t, double> impulses;
  std::unique_ptr<SolverMemory> memory;
  std::vector<double> residuals, seconds;
  double factorisations = 0, rows = 0;
  for (const char* path : files) {
    const IslandSystem system = read(path);
    if (system.rows.empty()) continue;
    std::vector<double> warm(system.rows.size(), 0);
    if (!choice.cold)
      for (std::size_t i = 0; i < warm.size(); ++i)
        if (const auto known = impulses.find(name_of(system.rows[i])); known != impulses.end())
          warm[i] = known->second;
    SolveOptions options;
    options.work_limit = choice.work * static_cast<double>(system.bodies.size());
    if (choice.cold) memory = nullptr;
    const double begin = bench::thread_seconds();
    const Solution solution = solver.solve(system, warm, options, &memory);
    seconds.push_back(bench::thread_seconds() - begin);
    residuals.push_back(solution.residual);
    factorisations += solution.work.factorisations;
    rows += static_cast<double>(warm.size());
    impulses.clear();
    for (std::size_t i = 0; i < warm.size(); ++i) impulses[name_of(system.rows[i])] = solution.lambda[i];
    if (choice.each_step)
      std::printf("  %s %s: %zu rows, residual %.1e, %.2f ms, %d factors, %s\n", solver.name.data(), path,
                  warm.size(), solution.residual, 1e3 * seconds.back(), solution.work.factorisations,
                  std::string(solution.method).c_str());
  }
  if (residuals.empty()) throw std::runtime_error("no rows in any of the files");
  const double steps = static_cast<double>(residuals.size());
  const auto share = [&](double limit) {
    return 100 / steps * static_cast<double>(std::count_if(residuals.begin(), residuals.end(), [=](double r) {
             return r <= limit;
           }));
  };
  double sum = 0;
  for (const double t : seconds) sum += t;
  std::sort(residuals.begin(), residuals.end());
  std::sort(seconds.begin(), seconds.end());
  std::printf("%-20s %5.0f %8.0f  %6.1f %6.1f  %9.1e %9.1e  %8.2f %8.2f %8.2f  %6.1f\n", solver.name.data(),
              steps, rows / steps, share(1e-8), share(1e-4), residuals[residuals.size() / 2],
              residuals.back(), 1e3 * sum / steps, 1e3 * seconds[seconds.size() / 2], 1e3 * seconds.back(),
              factorisations / steps);
  std::fflush(stdout);
}

constexpr const char* kUsage =
    R"(usage: solver_replay_bench [--solver NAME]... [--work N] [--cold] [--steps] FILE.json...

  --solver NAME   default: auto
  --work N        row visits a body and step (0: no limit)
  --cold          from nothing each time
  --steps         a line a step
)";

int run(int argc, char** argv) {
  Choice choice;
  std::vector<const char*> files, names;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--solver") {
      names.push_back(bench::value_of(argc, argv, i));
      bench::expect_name("solver", names.back(), bench::names_of(solvers()));
    } else if (word == "--work") {
      choice.work = bench::number_of(word, bench::value_of(argc, argv, i), 0, 1e12);
    } else if (word == "--cold") {
      choice.cold = true;
    } else if (word == "--steps") {
      choice.each_step = true;
    } else if (word.starts_with('-')) {
      throw bench::BadArgument("no option " + word);
    } else {
      files.push_back(argv[i]);
    }
  }
  if (files.empty()) throw bench::BadArgument("which FILE.json?");
  if (names.empty()) names.push_back("auto");
  std::printf("%-20s %5s %8s  %6s %6s  %9s %9s  %8s %8s %8s  %6s\n", "solver", "steps", "rows", "1e-8 %",
              "1e-4 %", "median", "worst", "mean ms", "median", "slowest", "fact");
  for (const char* name : names) replay(find_solver(name), files, choice);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return bench::run_with_arguments("solver_replay_bench", kUsage, argc, argv, run);
}
