// SPDX-License-Identifier: MIT
#include <memory>
#include <ostream>
#include <tuple>

#include "sandbox/commands/commands.h"
#include "sandbox/errors.h"
#include "sandbox/names.h"
#include "sandbox/picture_options.h"
#include "sandbox/window/actions.h"
#include "sandbox/window/window_app.h"

namespace skerry::sandbox {
namespace {

struct Options {
  SharedOptions shared;
  WindowOptions window;
  std::string size = "1280x720", theme = "light";
  bool keys = false;
};

int run(const Options& options, const Io& io) {
  if (options.keys) {
    io.out << keys_table();
    return kGood;
  }
  WindowOptions window = options.window;
  std::tie(window.width, window.height) = parse_size(options.size, 320, 240);
  const std::optional<render::Theme> theme = render::parse_theme(options.theme);
  if (!theme) throw UsageError("--theme expected light or dark, got \"" + options.theme + '"');
  window.theme = *theme;
  if (options.shared.demos.size() > 1)
    throw UsageError("open shows one demo at a time, got " + join(options.shared.demos));
  window.folder = options.shared.folder;
  window.options = options.shared.checked(io);
  if (!options.shared.demos.empty()) window.demo = options.shared.demos.front();
  run_window(window, io);
  return kGood;
}

}  // namespace

Action setup_open(OptionTable& table) {
  auto options = std::make_shared<Options>();
  add_shared_options(table, options->shared, DemoCount::Any);
  table.add("--size", options->size, "Size of the window in pixels").type("WxH").shows_default();
  table.add("--theme", options->theme, "light or dark").type("NAME").shows_default();
  table.add("--close-after", options->window.seconds, "Closes the window after so many seconds").positive();
  table.add("--screenshot", options->window.screenshot, "Writes the last frame to a PNG file").type("FILE");
  table.add_flag("--keys", options->keys, "Prints the keys of the window as a table");
  return [options](const Io& io) { return run(*options, io); };
}

}  // namespace skerry::sandbox
