// SPDX-License-Identifier: MIT
//
// Figures of one moment of a demo: the picture as SVG or PNG, curves over time as SVG; the contact problem of
// an island as MatrixMarket or JSON.
#include "physics/export.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <memory>
#include <ostream>
#include <sstream>

#include "render/image.h"
#include "render/svg.h"
#include "sandbox/commands/commands.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "sandbox/figures.h"
#include "sandbox/loop.h"
#include "sandbox/lua_args.h"
#include "sandbox/output.h"
#include "sandbox/picture_options.h"
#include "sandbox/progress.h"
#include "sandbox/report.h"

namespace skerry::sandbox {
namespace {

struct Options {
  SharedOptions shared;
  PictureOptions picture;
  std::optional<double> at;
  std::string svg, png, plot;
  std::string what = "energy";
  int island = 0;  // from 1, as everywhere; 0: the largest
  std::string matrix_market, json;

  bool problem() const { return !matrix_market.empty() || !json.empty(); }
  bool has_picture() const { return !svg.empty() || !png.empty(); }
};

void check(const Options& options) {
  options.picture.check();
  check_plot(options.what);
  if (!options.has_picture() && options.plot.empty() && !options.problem())
    throw UsageError(
        "export: nothing to write; give --svg FILE, --png FILE, --plot FILE, --matrix-market FOLDER or "
        "--json FILE");
  check_outputs(
      {{"--svg", options.svg}, {"--png", options.png}, {"--plot", options.plot}, {"--json", options.json}});
  if (options.has_picture()) return;
  const std::string unused = options.picture.needs_picture();
  // An island may be chosen by --select, too.
  if (!unused.empty() && !(unused == "--select" && options.problem()))
    throw UsageError("export: " + unused + " needs --svg or --png");
  if (options.island > 0 && !options.problem())
    throw UsageError("export: --island needs --matrix-market, --json, --svg or --png");
}

/// The equations of the last step that had any: those of its forces before those of its impacts.
const SystemRecord* last_problem(const History& history) {
  const SystemRecord *forces = history.resting(), *impact = history.impact();
  return impact && (!forces || forces->time < impact->time) ? impact : forces;
}

void add_problem(const Options& options, const Demo& demo, const History& history,
                 std::vector<Output>& outputs, std::string& words) {
  const SystemRecord* record = last_problem(history);
  if (record == nullptr || (options.island > 0 && record->island != options.island - 1)) {
    throw UsageError("export: no island" + (options.island > 0 ? " " + std::to_string(options.island) : "") +
                     " with contacts or joints up to " + format_number(demo.time()) + " s");
  }
  char line[120];
  std::snprintf(line, sizeof line, "%s of island %d at %.4g s, %d rows: b in m/s, lambda in N s\n",
                record->impact ? "impact" : "forces", record->island + 1, record->time,
                record->system.size());
  words = line;
  if (!options.json.empty()) {
    std::ostringstream text;
    write_json(text, record->system, record->lambda);
    outputs.push_back({options.json, std::move(text).str()});
  }
  if (options.matrix_market.empty()) return;
  const std::string stem = (std::filesystem::path(options.matrix_market) / demo.name()).string();
  for (MatrixMarketFile& file : matrix_market_files(stem, record->system, record->lambda))
    outputs.push_back({std::move(file.path), std::move(file.text)});
}

int export_demo(const Options& options, const Io& io) {
  check(options);
  const DemoFile file = find_demo(options.shared.demos.front(), options.shared.folder);
  Demo demo(file.path, options.shared.checked(io));
  const std::vector<std::string> names = options.picture.overlays_for(demo);
  Observe needs = needs_of(names);
  needs.systems = needs.systems || options.problem();
  demo.observe(needs);
  History history(demo, needs.systems, kFlashSeconds);
  Selection selection;
  std::optional<SelectionText> selected;
  const auto select = [&] {
    // Scripts may move their highlight while they run.
    if (selected && *selected == demo.picture().selection) return;
    selected = demo.picture().selection;
    selection = options.picture.selection_for(demo);
    history.follow_island(options.island > 0 ? options.island - 1 : selection.island);
  };
  WatchSeries watches(demo);
  LoopCallbacks callbacks;
  callbacks.step = [&](Demo& running) {
    select();
    history.update(running);
    if (!options.plot.empty()) watches.add(running);
  };
  catch_interrupts();
  run_loop(demo, {.until = options.at}, callbacks);
  stop_if_interrupted("nothing is written");

  // Complete in memory, so that an error leaves no part of the files.
  std::vector<Output> outputs;
  const PaintOptions paint = options.picture.paint();
  if (options.has_picture()) {
    select();
    Painter painter(paint);
    painter.start(demo, names);
    painter.select(selection);
    render::Image image;
    painter.paint(demo, history, image);
    if (!options.svg.empty()) outputs.push_back({options.svg, painter.svg(demo.title())});
    if (!options.png.empty()) {
      const std::vector<std::uint8_t> bytes = render::encode_png(image);
      outputs.push_back({options.png, {bytes.begin(), bytes.end()}});
    }
  }
  std::string words;
  if (options.problem()) add_problem(options, demo, history, outputs, words);
  if (!options.plot.empty())
    outputs.push_back(
        {options.plot, plot_svg(options.what, demo, history, watches, render::style(paint.theme))});
  stop_if_interrupted("nothing is written");
  if (!options.matrix_market.empty()) make_folder(options.matrix_market);
  const auto absent = std::stable_partition(outputs.begin(), outputs.end(),
                                            [](const Output& output) { return !output.bytes.empty(); });
  const std::span<const Output> written(outputs.begin(), absent);
  write_outputs(io, written);
  for (auto output = absent; output != outputs.end(); ++output) std::filesystem::remove(output->path);
  const bool to_stdout = std::any_of(written.begin(), written.end(),
                                     [](const Output& output) { return is_standard_output(output.path); });
  std::ostream& out = to_stdout ? io.err : io.out;
  for (const Output& output : written)
    if (!is_standard_output(output.path))
      out << output.path << ": " << format_bytes(output.bytes.size()) << '\n';
  out << words;
  if (demo.failed()) print_checks(io.err, demo);
  return demo.failed() ? kCheckFailed : kGood;
}

}  // namespace

Action setup_export(OptionTable& table) {
  auto options = std::make_shared<Options>();
  add_shared_options(table, options->shared, DemoCount::One);
  const std::string group = "Figure";
  table.add("--at", options->at, "The moment [s] (default: the end of the demo)")
      .range(0, kLongestRun)
      .group(group);
  table.add("--svg", options->svg, "Writes the picture as SVG").type("FILE").group(group);
  table.add("--png", options->png, "Writes the picture as PNG").type("FILE").group(group);
  const OptionRow plot =
      table.add("--plot", options->plot, "Writes curves up to the moment as SVG").type("FILE").group(group);
  table.add("--curves", options->what, "What --plot shows: " + plot_names() + " (default energy)")
      .type("NAME")
      .needs(plot)
      .group(group);
  const std::string problem = "Contact problem";
  table
      .add("--island", options->island,
           "Number of the island from 1, as pictures show it (default: the largest)")
      .whole(1, std::numeric_limits<int>::max())
      .group(problem);
  table
      .add("--matrix-market", options->matrix_market,
           "Writes DEMO_W, _J, _M, _b, _rows and _lambda.mtx for `skerry solve`")
      .type("FOLDER")
      .group(problem);
  table.add("--json", options->json, "Writes the island as JSON").type("FILE").group(problem);
  add_picture_options(table, options->picture);
  return [options](const Io& io) { return export_demo(*options, io); };
}

}  // namespace skerry::sandbox
