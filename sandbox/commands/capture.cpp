// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <ostream>

#include "render/frame_sink.h"
#include "sandbox/commands/commands.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "sandbox/loop.h"
#include "sandbox/names.h"
#include "sandbox/painter.h"
#include "sandbox/progress.h"
#include "sandbox/report.h"

namespace skerry::sandbox {
namespace {

namespace fs = std::filesystem;

constexpr double kFlashSeconds = 0.5;  // of the video: an impact lasts one step, eyes need longer

struct Options {
  SharedOptions shared;
  std::string out;
  std::string size = "1280x720";
  std::string theme = "light";
  int fps = 60;
  double speed = 1;
  int ssaa = 1;
  std::vector<std::string> overlays;
  bool matrix = false;
  std::optional<double> at;
  render::SinkOptions sink;

  PaintOptions paint() const;
};

PaintOptions Options::paint() const {
  PaintOptions paint;
  int used = 0;
  const bool read = std::sscanf(size.c_str(), "%dx%d%n", &paint.width, &paint.height, &used) == 2;
  if (!read || used != static_cast<int>(size.size()) || paint.width < 16 || paint.height < 16 ||
      paint.width > 16384 || paint.height > 16384)
    throw UsageError("--size expected WIDTHxHEIGHT from 16x16 to 16384x16384 pixels, got \"" + size + '"');
  const std::optional<render::Theme> chosen = render::parse_theme(theme);
  if (!chosen) throw UsageError("--theme expected light or dark, got \"" + theme + '"');
  paint.theme = *chosen;
  paint.ssaa = ssaa;
  paint.fps = fps;
  paint.speed = speed;
  return paint;
}

// Overlays of the demo and of the command line, each once; "none" drops those of the demo.
std::vector<std::string> chosen_overlays(const Options& options, const Demo& demo) {
  std::vector<std::string> names;
  const bool none =
      std::find(options.overlays.begin(), options.overlays.end(), "none") != options.overlays.end();
  if (!none) names = demo.picture().overlays;
  for (const std::string& name : options.overlays)
    if (name != "none") names.push_back(name);
  if (options.matrix) names.emplace_back("matrix");
  return names;
}

void check_overlays(const Options& options) {
  std::vector<std::string> known = overlay_names();
  known.emplace_back("none");
  for (const std::string& name : options.overlays)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw UsageError("--overlay: no \"" + name + '"' + suggestion(name, known));
}

bool is_folder(const std::string& path) {
  return path.empty() || path.back() == '/' || fs::is_directory(path);
}

// A picture of one moment: a PNG without a counter in its name.
bool is_still(const fs::path& path) {
  return path.extension() == ".png" && path.string().find('%') == std::string::npos;
}

std::string output_path(const Options& options, const DemoFile& file) {
  if (!is_folder(options.out)) return options.out;
  const std::string name = file.name + (options.at ? ".png" : ".mp4");
  return (fs::path(options.out) / name).string();
}

/// A demo on its way to a file.
class Recording {
 public:
  Recording(const Options& options, const DemoFile& file, const Io& io, Painter& painter)
      : options_(options),
        io_(io),
        painter_(painter),
        clock_{static_cast<double>(options.fps), options.speed},
        demo_(file.path, demo_options(options, file.path, io)),
        names_(chosen_overlays(options, demo_)),
        history_(demo_, needs_of(names_).systems, kFlashSeconds * options.speed) {
    demo_.observe(needs_of(names_));
    painter_.start(demo_, names_);
  }

  /// @return whether all checks hold
  bool still(const std::string& path) {
    LoopCallbacks callbacks;
    callbacks.step = [&](Demo&) { history_.update(demo_); };
    run_loop(demo_, {}, callbacks);
    painter_.paint(demo_, history_, image_);
    render::write_png(path, image_);
    io_.out << path << ": " << format_number_of(demo_.time()) << " s, " << format_bytes(fs::file_size(path))
            << '\n';
    return true;
  }

  bool video(const std::string& path) {
    const std::unique_ptr<render::FrameSink> sink = render::make_sink(path, options_.sink);
    const PaintOptions paint = options_.paint();
    sink->begin({.width = paint.width,
                 .height = paint.height,
                 .fps = options_.fps,
                 .title = demo_.title(),
                 .comment = io_.command_line,
                 .chapters = {}});
    const std::uint64_t total = frame_count(demo_, clock_);
    Progress progress(io_, demo_.name(), total);
    std::uint64_t frames = 0;
    std::size_t notes = 0;
    LoopCallbacks callbacks;
    callbacks.step = [&](Demo&) { history_.update(demo_); };
    callbacks.frame = [&](const Demo&, bool moved) {
      for (; notes < demo_.notes().size(); ++notes) sink->chapter(demo_.notes()[notes].text);
      if (moved) {
        painter_.paint(demo_, history_, image_);
        sink->frame(image_);
      } else {
        sink->repeat();
      }
      progress.at(++frames);
    };
    const bool whole = run_loop(demo_, clock_, callbacks);
    const render::SinkReport report = sink->end();
    const double rate = static_cast<double>(frames) / std::max(progress.elapsed(), 1e-9);
    io_.out << report.path << ": " << format_number_of(static_cast<double>(frames) / options_.fps) << " s, "
            << frames << " frames, " << std::lround(rate) << " frames/s, " << format_bytes(report.bytes)
            << '\n';
    if (!whole) return true;
    if (demo_.failed()) print_checks(io_.err, demo_);
    return !demo_.failed();
  }

 private:
  // A still ends at its moment.
  static DemoOptions demo_options(const Options& options, const std::string& path, const Io& io) {
    DemoOptions demo = options.shared.checked(io);
    if (options.at) {
      demo.seconds = std::max(*options.at, 0.0);
      demo.steps.reset();
    }
    // Slow motion in smaller steps, so that every frame shows another moment.
    if (!demo.dt && options.speed < 1) {
      const double standard = Demo(path, demo).dt();
      demo.dt = std::min(standard, options.speed / options.fps);
    }
    return demo;
  }

  static std::string format_number_of(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.2f", value);
    return text;
  }

  const Options& options_;
  const Io& io_;
  Painter& painter_;
  LoopClock clock_;
  Demo demo_;
  std::vector<std::string> names_;
  History history_;
  render::Image image_;
};

int capture(const Options& options, const Io& io) {
  check_overlays(options);
  std::vector<DemoFile> files;
  for (const std::string& name : options.shared.demos)
    files.push_back(find_demo(name, options.shared.folder));
  if (files.empty()) files = find_demos(demo_folder(options.shared.folder));
  if (files.size() > 1 && !is_folder(options.out))
    throw UsageError("-o: " + std::to_string(files.size()) + " demos need a folder (ending in /), got \"" +
                     options.out + '"');
  if (options.at && !options.out.empty() && !is_folder(options.out) && !is_still(options.out))
    throw UsageError("--at makes one picture: -o expected a .png file or a folder, got \"" + options.out +
                     '"');
  if (!options.out.empty() && options.out.back() == '/') {
    std::error_code error;
    fs::create_directories(options.out, error);
    if (error) throw ScriptError(options.out + ": cannot be made: " + error.message());
  }
  Painter painter(options.paint());
  catch_interrupts();
  bool good = true;
  for (const DemoFile& file : files) {
    const std::string path = output_path(options, file);
    Recording recording(options, file, io, painter);
    const bool passed = is_still(path) ? recording.still(path) : recording.video(path);
    good = good && passed;
    if (interrupted()) break;
  }
  return good ? kGood : kCheckFailed;
}

}  // namespace

Action setup_capture(CLI::App& app) {
  auto options = std::make_shared<Options>();
  add_shared_options(app, options->shared, DemoCount::Any);
  const std::string group = "Picture";
  app.add_option("-o,--out", options->out,
                 "File (.mp4 .mkv .webm .gif, .png for one picture, %06d.png for all) or folder/")
      ->type_name("PATH")
      ->group(group);
  app.add_option("--at", options->at, "One picture of this moment [s]")
      ->check(CLI::NonNegativeNumber)
      ->group(group);
  app.add_option("--fps", options->fps, "Frames a second (default 60)")
      ->check(CLI::Range(1, 240))
      ->group(group);
  app.add_option("--size", options->size, "WIDTHxHEIGHT in pixels (default 1280x720)")
      ->type_name("SIZE")
      ->group(group);
  app.add_option("--speed", options->speed, "World seconds in a second of video (default 1)")
      ->check(CLI::PositiveNumber)
      ->group(group);
  std::string names = join(overlay_names());
  app.add_option("--overlay", options->overlays, "Adds overlays: " + names + "; none drops the demo's own")
      ->type_name("NAME,...")
      ->delimiter(',')
      ->take_all()
      ->expected(1)
      ->group(group);
  app.add_flag("--matrix", options->matrix, "Same as --overlay matrix")->group(group);
  app.add_flag("--sharp", options->sink.sharp, "Full colour resolution (4:4:4)")->group(group);
  app.add_flag("--lossless", options->sink.lossless, "Every bit of the picture")->group(group);
  app.add_option("--ssaa", options->ssaa, "Draws the scene so many times finer, 1 to 4")
      ->check(CLI::Range(1, 4))
      ->group(group);
  app.add_option("--theme", options->theme, "light or dark")->type_name("THEME")->group(group);
  return [options](const Io& io) { return capture(*options, io); };
}

}  // namespace skerry::sandbox
