// SPDX-License-Identifier: MIT
//
// The flags that `run`, `capture` and `test` have in common.
#include <CLI/CLI.hpp>
#include <ostream>

#include "physics/broadphase/broadphase.h"
#include "physics/solver/solver.h"
#include "sandbox/cli.h"
#include "sandbox/errors.h"
#include "sandbox/names.h"

namespace skerry::sandbox {
namespace {

std::vector<std::string> solver_names() {
  std::vector<std::string> names;
  for (const SolverEntry& entry : solvers()) names.emplace_back(entry.name);
  return names;
}

std::vector<std::string> broad_phase_names() {
  std::vector<std::string> names;
  for (const BroadPhaseEntry& entry : broad_phases()) names.emplace_back(entry.name);
  return names;
}

void check_name(const char* option, const std::optional<std::string>& value,
                const std::vector<std::string>& names) {
  if (value && std::find(names.begin(), names.end(), *value) == names.end())
    throw UsageError(std::string(option) + ": no \"" + *value + '"' + suggestion(*value, names));
}

}  // namespace

void add_folder_option(CLI::App& app, SharedOptions& options) {
  app.add_option("--demos", options.folder, "Folder with the demos")->type_name("FOLDER");
}

void add_shared_options(CLI::App& app, SharedOptions& options, DemoCount count) {
  CLI::Option* demos = app.add_option("DEMO", options.demos, "Demo by name or .lua file")->type_name("");
  if (count == DemoCount::One)
    demos->required()->expected(1);
  else if (count == DemoCount::AtLeastOne)
    demos->required()->expected(1, 1 << 20);
  DemoOptions& demo = options.demo;
  add_folder_option(app, options);
  const std::string group = "Simulation";
  app.add_option("--seed", demo.seed, "Seed of math.random in the script (default 1)")->group(group);
  app.add_option("--dt", demo.dt, "Length of a step [s]")->check(CLI::PositiveNumber)->group(group);
  CLI::Option* seconds = app.add_option("--seconds", demo.seconds, "Length of the run [s]")
                             ->check(CLI::PositiveNumber)
                             ->group(group);
  app.add_option("--steps", demo.steps, "Length of the run in steps")
      ->check(CLI::PositiveNumber)
      ->excludes(seconds)
      ->group(group);
  app.add_option("--solver", demo.solver, "One of: " + join(solver_names()))->type_name("NAME")->group(group);
  app.add_option("--broadphase", demo.broad_phase, "One of: " + join(broad_phase_names()))
      ->type_name("NAME")
      ->group(group);
  app.add_option("--impact", demo.impact_law, "Impact law: reflections, simultaneous or poisson")
      ->type_name("NAME")
      ->group(group);
  app.add_option("--stepper", demo.stepper, "How time advances: time_stepping")
      ->type_name("NAME")
      ->group(group);
  app.add_option("--threads", demo.threads, "Number of threads (the result does not depend on it)")
      ->check(CLI::Range(1, 256))
      ->group(group);
  app.add_option_function<std::vector<std::string>>(
         "--set",
         [&demo](const std::vector<std::string>& words) {
           for (const std::string& word : words) {
             const std::size_t equals = word.find('=');
             if (equals == std::string::npos || equals == 0)
               throw UsageError("--set expected name=value, got \"" + word + '"');
             demo.parameters.emplace_back(word.substr(0, equals), word.substr(equals + 1));
           }
         },
         "Parameter of the demo: --set \"mass ratio=10\"")
      ->type_name("NAME=VALUE")
      ->take_all()
      ->expected(1)
      ->group(group);
}

DemoOptions SharedOptions::checked(const Io& io) const {
  DemoOptions options = demo;
  check_name("--solver", options.solver, solver_names());
  check_name("--broadphase", options.broad_phase, broad_phase_names());
  // The world knows its impact laws and steppers; a world with the given ones says what is wrong.
  WorldConfig config;
  if (options.impact_law) config.impact_law = *options.impact_law;
  if (options.stepper) config.stepper = *options.stepper;
  try {
    World probe(config);
  } catch (const std::invalid_argument& error) {
    throw UsageError(error.what());
  }
  options.print = [&io](std::string_view line) { io.err << line << '\n'; };
  return options;
}

}  // namespace skerry::sandbox
