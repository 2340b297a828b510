// SPDX-License-Identifier: MIT
#include <memory>
#include <ostream>

#include "physics/snapshot.h"
#include "render/image.h"
#include "sandbox/commands/commands.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "sandbox/loop.h"
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

std::span<const std::byte> bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

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
  while (demo.steps_done() < world.report().step && !interrupted()) demo.step();
  if (demo.world().state_hash() != world.state_hash())
    throw ScriptError(path + ": " + demo.name() + " comes to another state at step " +
                      std::to_string(demo.steps_done()) + "; other script, options or version?");
}

int run(const Options& options, const Io& io) {
  const DemoFile file = find_demo(options.shared.demos.front(), options.shared.folder);
  Demo demo(file.path, options.shared.checked(io));
  Series series(demo);
  catch_interrupts();
  if (!options.load.empty()) go_to_snapshot(options.load, demo);
  bool saved = options.save.empty();
  const auto save = [&](const Demo& running) {
    write_bytes(options.save, save_snapshot(running.world()));
    saved = true;
  };
  LoopCallbacks callbacks;
  callbacks.step = [&](Demo& running) {
    if (!options.csv.empty()) series.add(running);
    if (!saved && options.at && running.time() + 1e-9 >= *options.at) save(running);
  };
  run_loop(demo, {}, callbacks);
  if (!saved) save(demo);
  const bool to_stdout = options.report == "-" || options.csv == "-";
  if (!options.csv.empty() && options.csv != "-") write_bytes(options.csv, bytes_of(series.text()));
  if (options.csv == "-") io.out << series.text();
  const std::string json = options.report.empty() ? "" : json_report(demo, io.command_line);
  if (!options.report.empty() && options.report != "-") write_bytes(options.report, bytes_of(json));
  if (options.report == "-") io.out << json;
  print_checks(to_stdout ? io.err : io.out, demo);
  return demo.failed() ? kCheckFailed : kGood;
}

}  // namespace

Action setup_run(OptionTable& table) {
  auto options = std::make_shared<Options>();
  add_shared_options(table, options->shared, DemoCount::One);
  table.add("--report", options->report, "Writes the results as JSON (- for standard output)").type("FILE");
  table.add("--csv", options->csv, "Writes a row a step: energy, momentum, residual, watches").type("FILE");
  table.add("--save", options->save, "Writes the state of the world to a file").type("FILE");
  table.add("--at", options->at, "Time of --save [s] (default: the end)").non_negative();
  table.add("--load", options->load, "Goes on from a state that --save wrote").type("FILE");
  return [options](const Io& io) { return run(*options, io); };
}

}  // namespace skerry::sandbox
