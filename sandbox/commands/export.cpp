// SPDX-License-Identifier: MIT
//
// Figures of one moment of a demo: the picture as SVG or PNG, curves over time as SVG; the contact problem of
// an island as MatrixMarket or JSON.
#include "physics/export.h"

#include <algorithm>
#include <filesystem>
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
#include "sandbox/picture_options.h"
#include "sandbox/progress.h"

namespace skerry::sandbox {
namespace {

struct Options {
  SharedOptions shared;
  PictureOptions picture;
  std::optional<double> at;
  std::string svg, png, plot;
  std::string what = "energy";
  int island = -1;
  std::string matrix_market, json;

  bool problem() const { return !matrix_market.empty() || !json.empty(); }
};

void write(const Io& io, const std::string& path, const std::string& text) {
  render::write_file(path, text.data(), text.size());
  io.out << path << ": " << format_bytes(text.size()) << '\n';
}

/// The equations of the last step that had any, with their impulses: those of forces, not of impacts.
void write_problem(const Options& options, const Io& io, const Demo& demo, const History& history) {
  const SystemRecord* record = history.resting();
  if (record == nullptr || (options.island >= 0 && record->island != options.island)) {
    throw UsageError("export: no island" + (options.island < 0 ? "" : " " + std::to_string(options.island)) +
                     " with contacts or joints up to " + std::to_string(demo.time()) + " s");
  }
  if (!options.json.empty()) {
    std::ostringstream text;
    write_json(text, record->system, record->lambda);
    write(io, options.json, text.str());
  }
  if (options.matrix_market.empty()) return;
  try {
    std::filesystem::create_directories(options.matrix_market);
    const std::string stem = (std::filesystem::path(options.matrix_market) / demo.name()).string();
    for (const std::string& path : write_matrix_market_files(stem, record->system, record->lambda))
      io.out << path << ": " << format_bytes(std::filesystem::file_size(path)) << '\n';
  } catch (const std::runtime_error& error) {
    throw ScriptError(error.what());
  }
}

int export_demo(const Options& options, const Io& io) {
  options.picture.check();
  check_plot(options.what);
  const bool picture = !options.svg.empty() || !options.png.empty();
  if (!picture && options.plot.empty() && !options.problem())
    throw UsageError(
        "export: nothing to write; give --svg FILE, --png FILE, --plot FILE, --matrix-market FOLDER or "
        "--json FILE");
  const DemoFile file = find_demo(options.shared.demos.front(), options.shared.folder);
  Demo demo(file.path, options.shared.checked(io));
  const std::vector<std::string> names = options.picture.overlays_for(demo);
  Observe needs = needs_of(names);
  needs.systems = needs.systems || options.problem();
  demo.observe(needs);
  History history(demo, needs.systems, kFlashSeconds);
  const auto selected = [&] {
    const Selection selection = options.picture.selection_for(demo);
    history.follow_island(options.island >= 0 ? options.island : selection.island);
    return selection;
  };
  WatchSeries watches(demo);
  LoopCallbacks callbacks;
  callbacks.step = [&](Demo& running) {
    selected();
    history.update(running);
    if (!options.plot.empty()) watches.add(running);
  };
  catch_interrupts();
  if (!run_loop(demo, {.until = options.at}, callbacks)) return kGood;

  const PaintOptions paint = options.picture.paint();
  if (picture) {
    Painter painter(paint);
    painter.start(demo, names);
    painter.select(selected());
    render::Image image;
    painter.paint(demo, history, image);
    if (!options.svg.empty()) write(io, options.svg, painter.svg(demo.title()));
    if (!options.png.empty()) {
      render::write_png(options.png, image);
      io.out << options.png << ": " << format_bytes(std::filesystem::file_size(options.png)) << '\n';
    }
  }
  if (options.problem()) write_problem(options, io, demo, history);
  if (!options.plot.empty())
    write(io, options.plot, plot_svg(options.what, demo, history, watches, render::style(paint.theme)));
  return kGood;
}

}  // namespace

Action setup_export(OptionTable& table) {
  auto options = std::make_shared<Options>();
  add_shared_options(table, options->shared, DemoCount::One);
  const std::string group = "Figure";
  table.add("--at", options->at, "The moment [s] (default: the end of the demo)").non_negative().group(group);
  table.add("--svg", options->svg, "Writes the picture as SVG").type("FILE").group(group);
  table.add("--png", options->png, "Writes the picture as PNG").type("FILE").group(group);
  table.add("--plot", options->plot, "Writes curves up to the moment as SVG").type("FILE").group(group);
  table.add("--curves", options->what, "What --plot shows: " + plot_names() + " (default energy)")
      .type("NAME")
      .group(group);
  const std::string problem = "Contact problem";
  table.add("--island", options->island, "Number of the island (default: the largest)")
      .non_negative()
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
