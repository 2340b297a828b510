// SPDX-License-Identifier: MIT
#include "sandbox/window/window_app.h"

#include <ostream>

#include "render/image.h"
#include "render/window_context.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "sandbox/window/window_view.h"
#include "sandbox/window/workbench.h"

namespace skerry::sandbox {
namespace {

constexpr double kIdleWait = 0.2;  // [s]; saved scripts are noticed after at most this long

constexpr double kFrameSeconds = 1.0 / 60;

}  // namespace

void run_window(const WindowOptions& options, const Io& io) {
  // Looked up first: a wrong name is told without a window.
  const std::string path = options.demo.empty() ? "" : find_demo(options.demo, options.folder).path;
  Workbench bench(find_demos(demo_folder(options.folder)), options.options);
  bench.set_theme(options.theme);
  if (!path.empty()) {
    bench.open(path);
    if (!bench.has_demo()) throw ScriptError(bench.message()->text);
  }
  render::WindowContext window("Skerry", options.width, options.height);
  catch_interrupts();
  WindowView view(bench);
  std::string title;
  bool drawn = false;
  double open_for = 0;
  for (bool idle = false; !interrupted(); idle = view.idle()) {
    render::WindowInput input = window.poll(idle && options.screenshot.empty() ? kIdleWait : 0);
    if (!options.screenshot.empty()) input.seconds = kFrameSeconds;
    open_for += input.seconds;
    if (input.close || bench.quit || (options.seconds > 0 && open_for >= options.seconds)) break;
    view.frame(input, window.width(), window.height());
    window.present(view.target());
    drawn = true;
    const std::string wanted = bench.has_demo() ? bench.player().demo().title() + " - Skerry" : "Skerry";
    if (wanted != title) window.set_title(title = wanted);
  }
  view.finish();
  if (drawn && !options.screenshot.empty()) {
    render::Image image;
    view.target().read(image);
    render::write_png(options.screenshot, image);
  }
  if (bench.has_demo() && bench.player().divergence())
    io.err << "skerry: step " << *bench.player().divergence()
           << " came out differently when it was made again; please report this\n";
}

}  // namespace skerry::sandbox
