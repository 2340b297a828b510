// SPDX-License-Identifier: MIT
#include <memory>
#include <ostream>

#include "physics/snapshot.h"
#include "sandbox/commands/commands.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "sandbox/loop.h"
#include "sandbox/lua_args.h"
#include "sandbox/output.h"
#include "sandbox/report.h"
#include "sandbox/window/recording.h"

namespace skerry::sandbox {
namespace {

struct Options {
  SharedOptions shared;
  std::string report, csv;
  std::string save, load;
  std::optional<double> at;
};

/// Brings a demo that was just loaded to the state of a snapshot. The variables of a script are not in the
/// file: one that acts while it runs makes the steps again, and must arrive at the same state.
void go_to_snapshot(const std::string& path, Demo& demo) {
  World world;
  try {
    world = load_snapshot(read_bytes(path));
  } catch (const ArchiveError& error) {
    throw ScriptError(path + ": " + error.what());
  }
  if (!demo.has_callbacks()) {
    try {
      demo.adopt(std::move(world));
    } catch (const std::invalid_argument& error) {
      throw ScriptError(path + ": " + error.what());
    }
    return;
  }
  while (demo.steps_done() < world.report().step) {
    demo.step();
    stop_if_interrupted("nothing is written");
  }
  if (demo.world().state_hash() != world.state_hash())
    throw ScriptError(path + ": " + demo.name() + " comes to another state at step " +
                      std::to_string(demo.steps_done()) + "; other script, options or version?");
}

/// @throws UsageError for a moment of --save that the run does not come by
void check_moment(double at, const Demo& demo) {
  const double end = static_cast<double>(demo.total_steps()) * demo.dt();
  if (at >= demo.time() - 1e-9 && at <= end + 1e-9) return;
  throw UsageError("--at expected a time from " + format_number(demo.time()) + " to " + format_number(end) +
                   " s, which is what the run covers, got " + format_number(at));
}

int run(const Options& options, const Io& io) {
  check_outputs({{"--report", options.report}, {"--csv", options.csv}, {"--save", options.save}});
  const DemoFile file = find_demo(options.shared.demos.front(), options.shared.folder);
  Demo demo(file.path, options.shared.checked(io));
  Series series(demo);
  catch_interrupts();
  if (!options.load.empty()) go_to_snapshot(options.load, demo);
  bool saved = options.save.empty();
  const auto save = [&](const Demo& running) {
    write_results(io, {{options.save, text_of(save_snapshot(running.world()))}});
    saved = true;
  };
  LoopCallbacks callbacks;
  callbacks.step = [&](Demo& running) {
    if (!options.csv.empty()) series.add(running);
    if (!saved && options.at && running.time() + 1e-9 >= *options.at) save(running);
  };
  if (options.at) {
    check_moment(*options.at, demo);
    if (*options.at <= demo.time() + 1e-9) save(demo);
  }
  run_loop(demo, {}, callbacks);
  stop_if_interrupted("no results are written");
  if (!saved) save(demo);
  std::vector<Output> outputs;
  if (!options.csv.empty()) outputs.push_back({options.csv, series.text()});
  if (!options.report.empty()) outputs.push_back({options.report, json_report(demo, io.command_line)});
  write_results(io, outputs);
  const bool to_stdout = is_standard_output(options.report) || is_standard_output(options.csv) ||
                         is_standard_output(options.save);
  print_checks(to_stdout ? io.err : io.out, demo);
  return demo.failed() ? kCheckFailed : kGood;
}

}  // namespace

Action setup_run(OptionTable& table) {
  auto options = std::make_shared<Options>();
  add_shared_options(table, options->shared, DemoCount::One);
  table.add("--report", options->report, "Writes the results as JSON (- for standard output)").type("FILE");
  table.add("--csv", options->csv, "Writes a row a step: energy, momentum, residual, watches").type("FILE");
  const OptionRow save =
      table.add("--save", options->save, "Writes the state of the world to a file").type("FILE");
  table.add("--at", options->at, "Time of --save [s] (default: the end)").range(0, kLongestRun).needs(save);
  table.add("--load", options->load, "Goes on from a state that --save wrote").type("FILE");
  return [options](const Io& io) { return run(*options, io); };
}

}  // namespace skerry::sandbox
