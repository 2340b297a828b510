// SPDX-License-Identifier: MIT
//
// What is skipped in the demos: every script with all skips and with one of them off at a time, and its
// frames with and without the pictures that need not be drawn again.
#include <cstdio>
#include <filesystem>

#include "render/frame_sink.h"
#include "sandbox/demo_files.h"
#include "sandbox/loop.h"
#include "sandbox/painter.h"
#include "tests/bench/accuracy/options.h"
#include "tests/bench/accuracy/skip_switches.h"
#include "tests/bench/arguments.h"

namespace skerry::bench {
namespace {

using namespace sandbox;

// Of dear demos only the beginning is run: so many seconds of processor time with all skips on.
constexpr double kStepSeconds = 0.2, kFrameSeconds = 2;

/// What a step of the demo costs, script and checks included. @return [s] for `steps` steps, which become
/// fewer where they take longer than `limit` [s]
double step_demo(const DemoFile& file, const SkipSwitch& way, double limit, std::uint64_t& steps,
                 SkipCounters& counters) {
  Demo demo(file.path, {});
  WorldConfig config = demo.world().config();
  way.off(config);
  demo.world_for_input().reconfigure(config);
  if (way.report_all) {
    demo.observe(everything());
    demo.keep_paths();
  }
  counters = {};
  double seconds = 0;
  for (std::uint64_t step = 0; step < steps; ++step) {
    const double start = thread_seconds();
    demo.step();
    seconds += thread_seconds() - start;
    counters.add(demo.world().report());
    if (seconds > limit) steps = step + 1;
  }
  return seconds;
}

struct Frames {
  std::uint64_t all = 0, unchanged = 0;
  double seconds = 0;  ///< processor time of a capture, encoder and steps included
};

/// A capture of the first frames into `file`, as `skerry capture --size 256x144` makes it: the scene alone,
/// since the clock of the header makes every picture a new one.
Frames capture(const DemoFile& script, const std::string& file, bool reuse, double limit,
               std::uint64_t most_frames) {
  PaintOptions options;
  options.width = 256;
  options.height = 144;
  options.reuse = reuse;
  Painter painter(options);
  Demo demo(script.path, {});
  const std::vector<std::string>& overlays = demo.picture().overlays;
  History history(demo, needs_of(overlays).systems, kFlashSeconds);
  demo.observe(needs_of(overlays));
  painter.start(demo, overlays);
  render::Image image;
  Frames frames;
  const double start = process_seconds();
  const std::unique_ptr<render::FrameSink> sink = render::make_sink(file);
  sink->begin({.width = options.width, .height = options.height, .title = "", .comment = "", .chapters = {}});
  for (;;) {
    history.show_at(demo.shown_time());
    if (painter.paint(demo, history, image)) {
      sink->frame(image);
    } else {
      sink->repeat();
      ++frames.unchanged;
    }
    ++frames.all;
    if (frames.all == most_frames || process_seconds() - start > limit ||
        demo.steps_done() >= demo.total_steps()) {
      break;
    }
    demo.step();
    history.update(demo);
  }
  sink->end();
  frames.seconds = process_seconds() - start;
  return frames;
}

std::vector<std::string> step_rows(const DemoFile& file, int runs) {
  std::uint64_t steps = Demo(file.path, {}).total_steps();
  SkipCounters counters;
  step_demo(file, skip_switches().front(), kStepSeconds, steps, counters);
  const std::span<const SkipSwitch> ways = skip_switches();
  std::vector<std::vector<double>> times(ways.size());
  std::vector<SkipCounters> counted(ways.size());
  // The ways take turns, so that a neighbour's load hits them all.
  for (int k = 0; k < runs; ++k) {
    for (std::size_t way = 0; way < ways.size(); ++way) {
      std::uint64_t same = steps;
      const double seconds = step_demo(file, ways[way], 1e9, same, counted[way]);
      times[way].push_back(1e6 * seconds / static_cast<double>(steps));
    }
  }
  std::vector<std::string> rows;
  for (std::size_t way = 0; way < ways.size(); ++way) {
    rows.push_back(joined({file.name, ways[way].name, number(median(times[way])),
                           number(*std::min_element(times[way].begin(), times[way].end())),
                           number(*std::max_element(times[way].begin(), times[way].end())),
                           counted[way].state_hash == counted[0].state_hash ? "same" : "differs",
                           counted[way].row(static_cast<double>(steps)), std::to_string(steps)}));
  }
  return rows;
}

std::vector<std::string> frame_rows(const DemoFile& file, const std::string& video, int runs) {
  const Frames first = capture(file, video, true, kFrameSeconds, 0);
  std::vector<std::string> rows;
  for (const bool reuse : {true, false}) {
    std::vector<double> times;
    for (int k = 0; k < runs; ++k)
      times.push_back(1e3 * capture(file, video, reuse, 1e9, first.all).seconds /
                      static_cast<double>(first.all));
    rows.push_back(joined({file.name, reuse ? "unchanged kept" : "all drawn", number(median(times)),
                           number(*std::min_element(times.begin(), times.end())),
                           number(*std::max_element(times.begin(), times.end())), std::to_string(first.all),
                           std::to_string(reuse ? first.unchanged : 0)}));
  }
  return rows;
}

}  // namespace

std::vector<std::string> demo_scenes() {
  return names_of(find_demos(demo_folder("")));
}

void run_demos(const Options& options) {
  const std::string video = options.out + "/frames.mp4";
  std::vector<std::string> steps, frames, names;
  const auto add = [](std::vector<std::string>& to, const std::vector<std::string>& rows) {
    to.insert(to.end(), rows.begin(), rows.end());
  };
  for (const DemoFile& file : find_demos(demo_folder(""))) {
    if (!options.wants_scene(file.name)) continue;
    names.push_back(file.name);
    add(steps, step_rows(file, options.runs));
    add(frames, frame_rows(file, video, options.runs));
    std::fprintf(stderr, "%s\n", file.name.c_str());
  }
  std::filesystem::remove(video);
  merge_csv(options, "demos.csv",
            std::string("scene,switch,median_us,min_us,max_us,bits,") + SkipCounters::columns() + ",steps",
            names, steps);
  merge_csv(options, "frames.csv", "scene,switch,median_ms,min_ms,max_ms,frames,unchanged", names, frames);
}

}  // namespace skerry::bench
