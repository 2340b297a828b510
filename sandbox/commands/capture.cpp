// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <ostream>

#include "render/frame_sink.h"
#include "render/output_file.h"
#include "sandbox/commands/commands.h"
#include "sandbox/demo_files.h"
#include "sandbox/errors.h"
#include "sandbox/loop.h"
#include "sandbox/names.h"
#include "sandbox/output.h"
#include "sandbox/painter.h"
#include "sandbox/picture_options.h"
#include "sandbox/progress.h"
#include "sandbox/report.h"

namespace skerry::sandbox {
namespace {

namespace fs = std::filesystem;

struct Options {
  SharedOptions shared;
  PictureOptions picture;
  std::string out;
  std::optional<int> fps_given;
  double speed = 1;
  bool small = false;
  std::optional<double> at;
  render::SinkOptions sink;

  int fps() const { return fps_given.value_or(60); }
  PaintOptions paint() const {
    PaintOptions paint = picture.paint();
    paint.fps = fps();
    paint.speed = speed;
    return paint;
  }
};

bool is_folder(const std::string& path) {
  return path.empty() || path.back() == '/' || fs::is_directory(path);
}

std::string extension_of(const fs::path& path) {
  std::string text = path.extension().string();
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c); });
  return text;
}

// A picture of one moment: a PNG without a counter in its name, or what has no ending to tell.
bool is_still(const Options& options, const std::string& path) {
  if (options.at && (is_standard_output(path) || render::is_special(path))) return true;
  return extension_of(path) == ".png" && !render::counts_frames(path);
}

std::string output_path(const Options& options, const DemoFile& file) {
  if (!is_folder(options.out)) return options.out;
  const std::string name = file.name + (options.at ? ".png" : ".mp4");
  return (fs::path(options.out) / name).string();
}

// Options that would do nothing to this output. What a sink does not know it refuses itself.
void check_options(const Options& options, const std::string& path) {
  const auto refuse = [&](const char* option, const char* what) {
    throw UsageError(std::string(option) + " is for " + what + ", got \"" + path + '"');
  };
  const std::string ending = extension_of(path);
  const bool still = is_still(options, path),
             video = ending == ".mp4" || ending == ".mkv" || ending == ".webm";
  if (options.small && !still) refuse("--small", "one picture (.png)");
  if (options.fps_given && still) refuse("--fps", "videos and pictures of all frames");
  if (options.sink.sharp && !video) refuse("--sharp", "videos (.mp4 .mkv .webm)");
  if (options.sink.lossless && !video) refuse("--lossless", "videos (.mp4 .mkv .webm)");
  if (!options.sink.encoder.empty() && !video) refuse("--encoder", "videos (.mp4 .mkv .webm)");
}

/// A demo on its way to a file.
class Recording {
 public:
  Recording(const Options& options, const DemoFile& file, const Io& io, Painter& painter)
      : options_(options),
        io_(io),
        painter_(painter),
        clock_{static_cast<double>(options.fps()), options.speed},
        demo_(file.path, options.shared.checked(io)),
        names_(options.picture.overlays_for(demo_)),
        history_(demo_, needs_of(names_).systems, kFlashSeconds * options.speed) {
    demo_.observe(needs_of(names_));
    painter_.start(demo_, names_);
    select();
    const std::vector<std::string>& left_out = painter_.composer().left_out();
    if (!left_out.empty())
      io.err << "skerry: no room for " << join(left_out) << "; make the picture larger with --size\n";
  }

  /// @return whether all checks hold
  bool still(const std::string& path) {
    LoopCallbacks callbacks;
    callbacks.step = [&](Demo&) { history_.update(demo_); };
    run_loop(demo_, {.until = options_.at}, callbacks);
    stop_if_interrupted(path + " not written");
    paint_frame();
    const std::vector<std::uint8_t> bytes =
        options_.small ? render::encode_small_png(image_, true) : render::encode_png(image_);
    stop_if_interrupted(path + " not written");
    const Output output{path, {bytes.begin(), bytes.end()}};
    write_outputs(io_, {&output, 1});
    words_beside(io_, path) << path << ": " << format_number_of(demo_.time()) << " s, "
                            << format_bytes(bytes.size()) << '\n';
    return passed();
  }

  bool video(const std::string& path) {
    const std::unique_ptr<render::FrameSink> sink = render::make_sink(path, options_.sink);
    const PaintOptions paint = options_.paint();
    sink->begin({.width = paint.width,
                 .height = paint.height,
                 .fps = options_.fps(),
                 .title = demo_.title(),
                 .comment = io_.command_line,
                 .chapters = {}});
    const std::uint64_t total = frame_count(demo_, clock_);
    Progress progress(io_, demo_.name(), total);
    std::uint64_t frames = 0;
    std::size_t notes = 0;
    LoopCallbacks callbacks;
    callbacks.step = [&](Demo&) { history_.update(demo_); };
    callbacks.frame = [&](const Demo&) {
      for (; notes < demo_.notes().size(); ++notes) sink->chapter(demo_.notes()[notes].text);
      history_.show_at(demo_.shown_time());
      paint_frame() ? sink->frame(image_) : sink->repeat();
      progress.at(++frames);
    };
    const bool whole = run_loop(demo_, clock_, callbacks);
    const render::SinkReport report = sink->end();
    const double rate = static_cast<double>(frames) / std::max(progress.elapsed(), 1e-9);
    const std::string seconds = format_number_of(static_cast<double>(frames) / options_.fps());
    std::ostream& out = words_beside(io_, path);
    out << report.path << ": " << seconds << " s, " << frames << " frames, ";
    if (report.repeats > 0) out << report.repeats << " of them unchanged, ";
    out << std::lround(rate) << " frames/s, " << format_bytes(report.bytes) << '\n';
    if (!whole) stop_if_interrupted(report.path + " ends after " + seconds + " s");
    return passed();
  }

 private:
  bool passed() const {
    if (demo_.failed()) print_checks(io_.err, demo_);
    return !demo_.failed();
  }

  // Scripts may move their highlight while they run.
  bool paint_frame() {
    if (!(demo_.picture().selection == selected_)) select();
    return painter_.paint(demo_, history_, image_);
  }

  void select() {
    selected_ = demo_.picture().selection;
    const Selection selection = options_.picture.selection_for(demo_);
    painter_.select(selection);
    history_.follow_island(selection.island);
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
  SelectionText selected_;
  render::Image image_;
};

int capture(const Options& options, const Io& io) {
  options.picture.check();
  std::vector<DemoFile> files;
  for (const std::string& name : options.shared.demos)
    files.push_back(find_demo(name, options.shared.folder));
  if (files.empty()) files = find_demos(demo_folder(options.shared.folder));
  if (files.size() > 1 && !is_folder(options.out))
    throw UsageError("-o: " + std::to_string(files.size()) + " demos need a folder (ending in /), got \"" +
                     options.out + '"');
  if (options.at && !is_folder(options.out) && !is_still(options, options.out))
    throw UsageError("--at makes one picture: -o expected a .png file or a folder, got \"" + options.out +
                     '"');
  std::map<std::string, std::string> sources;
  for (const DemoFile& file : files) {
    const std::string path = output_path(options, file);
    check_options(options, path);
    const auto [first, added] = sources.emplace(path, file.path);
    if (!added)
      throw UsageError(first->second + " and " + file.path + " would both become " + path +
                       "; capture them into folders of their own");
  }
  if (!options.out.empty() && options.out.back() == '/') make_folder(options.out);
  Painter painter(options.paint());
  catch_interrupts();
  bool good = true;
  for (const DemoFile& file : files) {
    const std::string path = output_path(options, file);
    stop_if_interrupted(path + " not written");
    Recording recording(options, file, io, painter);
    const bool passed = is_still(options, path) ? recording.still(path) : recording.video(path);
    good = good && passed;
  }
  return good ? kGood : kCheckFailed;
}

}  // namespace

Action setup_capture(OptionTable& table) {
  auto options = std::make_shared<Options>();
  add_shared_options(table, options->shared, DemoCount::Any);
  const std::string group = "Picture";
  table
      .add("-o,--out", options->out,
           "File (.mp4 .mkv .webm with the demo's notes as chapters, .gif, .png for one picture, %06d.png "
           "for all) or folder/")
      .type("PATH")
      .group(group);
  table.add("--at", options->at, "One picture of this moment [s]").range(0, kLongestRun).group(group);
  table.add_flag("--small", options->small, "One picture: 256 colours in as few bytes as possible")
      .group(group);
  table.add("--fps", options->fps_given, "Frames a second (default 60)").whole(1, 240).group(group);
  table.add("--speed", options->speed, "World seconds in a second of video (default 1)")
      .range(1e-6, 1e6)
      .group(group);
  table.add_flag("--sharp", options->sink.sharp, "Full colour resolution (4:4:4)").group(group);
  table.add_flag("--lossless", options->sink.lossless, "Every bit of the picture").group(group);
  table.add("--encoder", options->sink.encoder, "Another encoder of FFmpeg, such as libx265 or mpeg4")
      .type("NAME")
      .group(group);
  add_picture_options(table, options->picture);
  return [options](const Io& io) { return capture(*options, io); };
}

}  // namespace skerry::sandbox
