// SPDX-License-Identifier: MIT
//
// Figures of one moment of a demo: the picture as SVG or PNG, curves over time as SVG.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <ostream>

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
};

void write(const Io& io, const std::string& path, const std::string& text) {
  render::write_file(path, text.data(), text.size());
  io.out << path << ": " << format_bytes(text.size()) << '\n';
}

int export_demo(const Options& options, const Io& io) {
  options.picture.check();
  check_plot(options.what);
  const bool picture = !options.svg.empty() || !options.png.empty();
  if (!picture && options.plot.empty())
    throw UsageError("export: nothing to write; give --svg FILE, --png FILE or --plot FILE");
  const DemoFile file = find_demo(options.shared.demos.front(), options.shared.folder);
  DemoOptions demo_options = options.shared.checked(io);
  if (options.at) {
    demo_options.seconds = *options.at;
    demo_options.steps.reset();
  }
  Demo demo(file.path, demo_options);
  const std::vector<std::string> names = options.picture.overlays_for(demo);
  const Observe needs = needs_of(names);
  demo.observe(needs);
  History history(demo, needs.systems, kFlashSeconds);
  const Selection selection = options.picture.selection_for(demo);
  history.follow_island(selection.island);
  WatchSeries watches(demo);
  LoopCallbacks callbacks;
  callbacks.step = [&](Demo& running) {
    history.update(running);
    if (!options.plot.empty()) watches.add(running);
  };
  catch_interrupts();
  if (!run_loop(demo, {}, callbacks)) return kGood;

  const PaintOptions paint = options.picture.paint();
  if (picture) {
    Painter painter(paint);
    painter.start(demo, names);
    painter.select(selection);
    render::Image image;
    painter.paint(demo, history, image);
    if (!options.svg.empty()) write(io, options.svg, painter.svg(demo.title()));
    if (!options.png.empty()) {
      render::write_png(options.png, image);
      io.out << options.png << ": " << format_bytes(std::filesystem::file_size(options.png)) << '\n';
    }
  }
  if (!options.plot.empty())
    write(io, options.plot, plot_svg(options.what, demo, history, watches, render::style(paint.theme)));
  return kGood;
}

}  // namespace

Action setup_export(CLI::App& app) {
  auto options = std::make_shared<Options>();
  add_shared_options(app, options->shared, DemoCount::One);
  const std::string group = "Figure";
  app.add_option("--at", options->at, "The moment [s] (default: the end of the demo)")
      ->check(CLI::NonNegativeNumber)
      ->group(group);
  app.add_option("--svg", options->svg, "Writes the picture as SVG")->type_name("FILE")->group(group);
  app.add_option("--png", options->png, "Writes the picture as PNG")->type_name("FILE")->group(group);
  app.add_option("--plot", options->plot, "Writes curves up to the moment as SVG")
      ->type_name("FILE")
      ->group(group);
  app.add_option("--curves", options->what, "What --plot shows: " + plot_names() + " (default energy)")
      ->type_name("NAME")
      ->group(group);
  add_picture_options(app, options->picture);
  return [options](const Io& io) { return export_demo(*options, io); };
}

}  // namespace skerry::sandbox
