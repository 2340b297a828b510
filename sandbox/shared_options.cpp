// SPDX-License-Identifier: MIT
//
// The flags that `run`, `capture` and `test` have in common.
#include <limits>
#include <ostream>

#include "physics/broadphase/broadphase.h"
#include "physics/solver/impact_law.h"
#include "physics/solver/solver.h"
#include "physics/stepping/stepper.h"
#include "sandbox/cli.h"
#include "sandbox/errors.h"
#include "sandbox/names.h"

namespace skerry::sandbox {
namespace {

// The names of a registry's rows.
template <class Rows>
std::vector<std::string> names_of(const Rows& rows) {
  std::vector<std::string> names;
  for (const auto& row : rows) names.emplace_back(row.name);
  return names;
}

void check_name(const char* option, const std::optional<std::string>& value,
                const std::vector<std::string>& names) {
  if (value && std::find(names.begin(), names.end(), *value) == names.end())
    throw UsageError(std::string(option) + ": no \"" + *value + '"' + suggestion(*value, names));
}

}  // namespace

void add_folder_option(OptionTable& table, SharedOptions& options) {
  table.add("--demos", options.folder, "Folder with the demos").type("FOLDER");
}

void add_shared_options(OptionTable& table, SharedOptions& options, DemoCount count) {
  OptionRow demos = table.add("DEMO", options.demos, "Demo by name or .lua file").type("");
  if (count == DemoCount::One)
    demos.required().one();
  else if (count == DemoCount::AtLeastOne)
    demos.required().many();
  DemoOptions& demo = options.demo;
  add_folder_option(table, options);
  const std::string group = "Simulation";
  table.add("--seed", demo.seed, "Seed of math.random in the script (default 1)")
      .whole(0, std::numeric_limits<std::uint64_t>::max())
      .group(group);
  table.add("--dt", demo.dt, "Length of a step [s]").range(kShortestStep, kLongestStep).group(group);
  const OptionRow seconds = table.add("--seconds", demo.seconds, "Length of the run [s]")
                                .range(kShortestStep, kLongestRun)
                                .group(group);
  table.add("--steps", demo.steps, "Length of the run in steps")
      .whole(1, kMostSteps)
      .excludes(seconds)
      .group(group);
  // Each registry gives an option its values; with a single row there is nothing to choose.
  const auto add_choice = [&](const char* flag, std::optional<std::string>& value, const char* what,
                              const std::vector<std::string>& names) {
    if (names.size() < 2) return;
    table.add(flag, value, std::string(what) + ": " + join(names)).type("NAME").group(group);
  };
  add_choice("--solver", demo.solver, "Solver of the islands", names_of(solvers()));
  add_choice("--broadphase", demo.broad_phase, "Broad phase", names_of(broad_phases()));
  add_choice("--impact", demo.impact_law, "Impact law", names_of(impact_laws()));
  add_choice("--stepper", demo.stepper, "How time advances", names_of(steppers()));
  table
      .add("--accuracy", demo.accuracy,
           "Wanted error after a second of motion, 1e-14 to 1e-2: each island picks its own inner steps")
      .range(1e-14, 1e-2)
      .group(group);
  table
      .add("--budget", demo.budget,
           "Work of the solver an island and a step, in millions of row visits of some 10 ns (default 100; "
           "0: no limit); beyond it the best answer so far is taken, with its residual in the report")
      .non_negative()
      .group(group);
  table
      .add(
          "--flow-work", demo.flow_work,
          "Work a body and step of piles that flow, in row visits of some 10 ns (default 400; without joints "
          "1000 in worlds of fewer than 1000 bodies; in a small world more, whose bodies share 4e5; 0: as "
          "exact as the rest)")
      .non_negative()
      .group(group);
  table
      .add("--sleep-speed", demo.sleep_speed,
           "What has been slower than this for half a second is stopped and sleeps, as in game engines [m/s] "
           "(default 0: only what rests)")
      .non_negative()
      .group(group);
  table.add("--threads", demo.threads, "Threads, 1 to 256 (default 1); results do not depend on it")
      .whole(1, 256)
      .group(group);
  table
      .add(
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
      .type("NAME=VALUE")
      .repeatable()
      .group(group);
}

DemoOptions SharedOptions::checked(const Io& io) const {
  DemoOptions options = demo;
  check_name("--solver", options.solver, names_of(solvers()));
  check_name("--broadphase", options.broad_phase, names_of(broad_phases()));
  check_name("--impact", options.impact_law, names_of(impact_laws()));
  check_name("--stepper", options.stepper, names_of(steppers()));
  options.print = [&io](std::string_view line) { io.err << line << '\n'; };
  return options;
}

}  // namespace skerry::sandbox
