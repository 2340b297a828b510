// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>
#include <memory>
#include <ostream>

#include "render/image.h"
#include "sandbox/commands/commands.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "sandbox/loop.h"
#include "sandbox/report.h"

namespace skerry::sandbox {
namespace {

struct Options {
  SharedOptions shared;
  std::string report, csv;
};

// A result file that cannot be written is a file error, whatever the reason.
void write(const std::string& path, const std::string& text) {
  try {
    render::write_file(path, text.data(), text.size());
  } catch (const std::runtime_error& error) {
    throw ScriptError(error.what());
  }
}

int run(const Options& options, const Io& io) {
  const DemoFile file = find_demo(options.shared.demos.front(), options.shared.folder);
  Demo demo(file.path, options.shared.checked(io));
  Series series(demo);
  LoopCallbacks callbacks;
  if (!options.csv.empty()) callbacks.step = [&](Demo& running) { series.add(running); };
  catch_interrupts();
  run_loop(demo, {}, callbacks);
  const bool to_stdout = options.report == "-" || options.csv == "-";
  if (!options.csv.empty() && options.csv != "-") write(options.csv, series.text());
  if (options.csv == "-") io.out << series.text();
  const std::string json = options.report.empty() ? "" : json_report(demo, io.command_line);
  if (!options.report.empty() && options.report != "-") write(options.report, json);
  if (options.report == "-") io.out << json;
  print_checks(to_stdout ? io.err : io.out, demo);
  return demo.failed() ? kCheckFailed : kGood;
}

}  // namespace

Action setup_run(CLI::App& app) {
  auto options = std::make_shared<Options>();
  add_shared_options(app, options->shared, DemoCount::One);
  app.add_option("--report", options->report, "Writes the results as JSON (- for standard output)")
      ->type_name("FILE");
  app.add_option("--csv", options->csv, "Writes a row a step: energy, momentum, residual, watches")
      ->type_name("FILE");
  return [options](const Io& io) { return run(*options, io); };
}

}  // namespace skerry::sandbox
