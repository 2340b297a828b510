// SPDX-License-Identifier: MIT
//
// A capture as a whole against its parts: 1000 bodies, 500 contacts with normals and impulses, two panels,
// H.264. What two cores allow is 2000 / (CPU milliseconds of a frame) frames a second; an encoder with
// nothing else to do and FFmpeg's own program fed through a pipe are the other measures.
//
// Then PNG sequences against stock stb, and 10 000 bodies drawn. See kUsage.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <stb_image_write.h>
#include <sys/resource.h>
#include <unistd.h>

#include "render/canvas.h"
#include "render/egl_context.h"
#include "render/frame_sink.h"
#include "render/gl_renderer.h"
#include "render/style.h"
#include "render/yuv.h"
#include "sandbox/painter.h"
#include "tests/bench/arguments.h"

namespace {

using namespace skerry;
using namespace skerry::sandbox;
namespace fs = std::filesystem;

// Ten shelves with fifty discs each that roll, and five hundred that fly between them.
constexpr const char* kScene = R"(
demo{ title = "A thousand bodies", lesson = "Five hundred contacts, five hundred flights.", seconds = 600,
      view = { x = 0, y = 5, height = 11, width = 13 } }
for row = 0, 9 do
  box{ at = {0, row}, size = {13, 0.1}, type = "static" }
  for i = 0, 49 do
    disc{ at = {-6.1 + i * 0.249, row + 0.15}, radius = 0.1, mass = 1, omega = (i % 7 - 3) * 2, group = -1,
          velocity = {(3 - i % 7) * 0.02, 0} }
    disc{ at = {-6.1 + i * 0.249, row + 0.55}, radius = 0.11, mass = 1, gravity_scale = 0, group = -1,
          velocity = {(i % 5 - 2) * 0.3, 0}, omega = i % 9 - 4 }
  end
end
show{ "contacts", "impulses", "energy", "matrix", force_scale = 50 }
)";

struct Cost {
  double wall = 0, cpu = 0;  ///< [ms a frame]
  double rate() const { return 1000 / wall; }
};

double cpu_seconds() {
  double total = 0;
  for (const int who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(who, &usage);
    for (const timeval& t : {usage.ru_utime, usage.ru_stime})
      total += static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  }
  return total;
}

Cost measure(int frames, const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  const double cpu = cpu_seconds();
  work();
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - start;
  return {1000 * wall.count() / frames, 1000 * (cpu_seconds() - cpu) / frames};
}

/// The demo on its way, frame by frame.
struct Stage {
  explicit Stage(const std::string& script, const PaintOptions& options)
      : demo(script, {}),
        names(demo.picture().overlays),
        painter(options),
        history(demo, true, kFlashSeconds) {
    demo.observe(needs_of(names));
    painter.start(demo, names);
    // Shaders are compiled with the first picture: once a program, not once a frame.
    simulate();
    draw();
  }
  void simulate() {
    demo.step();
    history.update(demo);
  }
  void draw() { painter.paint(demo, history, image); }

  Demo demo;
  std::vector<std::string> names;
  Painter painter;
  History history;
  render::Image image;
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

// What is inside of `draw` and `encode`.
void small_parts(const render::Image& picture, int frames) {
  const int width = picture.width, height = picture.height;
  const render::EglContext context;
  render::Target target(width, height);
  target.begin_scene();
  target.resolve();
  render::Image image;
  const Cost read = measure(frames, [&] {
    for (int i = 0; i < frames; ++i) target.read(image);
  });
  const auto side = static_cast<std::size_t>(width), rows = static_cast<std::size_t>(height);
  std::vector<std::uint8_t> y(side * rows), u(side * rows / 4), v(side * rows / 4);
  const Cost convert = measure(frames, [&] {
    for (int i = 0; i < frames; ++i)
      render::to_yuv420(picture, {{y.data(), u.data(), v.data()}, {width, width / 2, width / 2}});
  });
  std::printf("read back (in draw) %.2f ms, convert (in encode) %.2f ms\n", read.cpu, convert.cpu);
}

// 10 000 bodies of about 10 pixels, half discs, half boxes: time until the picture is finished, by the
// built-in rasteriser and by the driver.
void ten_thousand(int rounds, int frames) {
  render::Camera camera;
  camera.height = 7.2;
  const render::Style& style = render::style(render::Theme::Light);
  render::DrawList list;
  list.background = style.background;
  render::DrawLayer& layer = list[render::Layer::Bodies];
  constexpr double kPitch = 12.6 / 134, kRadius = 0.47 * kPitch;
  for (int i = 0; i < 10000; ++i) {
    const render::Point c{-6.3 + kPitch * (i % 134 + 0.5), -3.5 + kPitch * (i / 134 + 0.5)};
    const render::Paint& paint = render::body_paint(style, i);
    const auto corner = [&](double angle) {
      return render::Point{c.x + kRadius * std::cos(0.7 * i + angle),
                           c.y + kRadius * std::sin(0.7 * i + angle)};
    };
    if (i % 2 == 0) {
      layer.discs.push_back({c, kRadius, paint.fill, paint.outline, style.outline_px, 0.7 * i, true});
    } else {
      const render::Point corners[] = {corner(0.6), corner(2.54), corner(3.74), corner(5.68)};
      layer.polygon(corners, 4, paint.fill, paint.outline, 0, style.outline_px);
    }
  }
  render::EglContext context;
  render::GlRenderer renderer;
  render::Target target(1280, 720);
  render::Canvas canvas(1280, 720);
  const auto report = [&](const std::string& who, const std::function<void()>& draw) {
    std::printf("\n10 000 bodies, 1280 x 720, %s\n", who.c_str());
    std::vector<double> wall, cpu;
    for (int round = 0; round <= rounds; ++round) {
      const int few = std::max(frames / 4, 10);
      const Cost cost = measure(few, [&] {
        for (int i = 0; i < few; ++i) draw();
      });
      if (round == 0) continue;  // shaders are compiled
      wall.push_back(cost.wall);
      cpu.push_back(cost.cpu);
    }
    std::printf("draw [ms a frame]: wall least %.2f, median %.2f; CPU least %.2f\n",
                *std::min_element(wall.begin(), wall.end()), median(wall),
                *std::min_element(cpu.begin(), cpu.end()));
  };
  report("built-in rasteriser", [&] { canvas.draw(list, camera); });
  report(context.renderer(), [&] {
    renderer.draw(list, camera, target);
    context.finish();
  });
}

void video(const fs::path& folder, const std::string& script, int width, int height, int rounds, int frames) {
  PaintOptions options;
  options.width = width;
  options.height = height;
  const std::string path = (folder / "capture.mp4").string();
  constexpr int kKept = 60;  // pictures for the encoder alone
  std::vector<render::Image> pictures;
  {
    Stage stage(script, options);
    for (int i = 0; i < kKept; ++i) {
      stage.simulate();
      stage.draw();
      pictures.push_back(stage.image);
    }
  }
  std::printf("\n%d x %d, %d frames a row; CPU [ms a frame], rates [frames/s]\n", width, height, frames);
  small_parts(pictures.front(), frames);
  std::printf(
      "simulate  draw  encode | whole  CPU  rate | encode alone | ffmpeg pipe | of bound  of encoder  of "
      "pipe\n");
  std::vector<double> of_bound, of_encoder, of_pipe, pipe_cpu;
  for (int round = 0; round < rounds; ++round) {
    const auto sink = [&] {
      auto made = render::make_sink(path);
      made->begin({.width = width, .height = height, .fps = 60, .title = "", .comment = "", .chapters = {}});
      return made;
    };
    Cost simulate, draw, encode, whole, pipe;
    {
      Stage stage(script, options);
      simulate = measure(frames, [&] {
        for (int i = 0; i < frames; ++i) stage.simulate();
      });
    }
    {
      Stage stage(script, options);
      draw = measure(frames, [&] {
        for (int i = 0; i < frames; ++i) {
          stage.simulate();
          stage.draw();
        }
      });
      draw.cpu -= simulate.cpu;
    }
    encode = measure(frames, [&] {
      const auto to = sink();
      for (int i = 0; i < frames; ++i) to->frame(pictures[static_cast<std::size_t>(i % kKept)]);
      to->end();
    });
    {
      Stage stage(script, options);
      whole = measure(frames, [&] {
        const auto to = sink();
        for (int i = 0; i < frames; ++i) {
          stage.simulate();
          stage.draw();
          to->frame(stage.image);
        }
        to->end();
      });
    }
    {
      Stage stage(script, options);
      const std::string command = "ffmpeg -v error -y -f rawvideo -pix_fmt rgba -s " + std::to_string(width) +
                                  "x" + std::to_string(height) +
                                  " -r 60 -i - -c:v libx264 -preset veryfast -crf 18 -pix_fmt yuv420p " +
                                  path;
      pipe = measure(frames, [&] {
        FILE* to = popen(command.c_str(), "w");
        if (!to) std::abort();
        for (int i = 0; i < frames; ++i) {
          stage.simulate();
          stage.draw();
          if (fwrite(stage.image.rgba.data(), 1, stage.image.rgba.size(), to) != stage.image.rgba.size())
            break;
        }
        if (pclose(to) != 0) std::printf("  (no ffmpeg: the pipe column is void)\n");
      });
    }
    const double bound = 2000 / whole.cpu;
    of_bound.push_back(whole.rate() / bound);
    of_encoder.push_back(whole.rate() / encode.rate());
    of_pipe.push_back(whole.rate() / pipe.rate());
    pipe_cpu.push_back(pipe.cpu / whole.cpu);
    std::printf("%8.2f %5.2f %7.2f | %5.2f %5.2f %5.1f | %12.1f | %11.1f | %8.2f %11.2f %8.2f\n",
                simulate.cpu, draw.cpu, encode.cpu, whole.wall, whole.cpu, whole.rate(), encode.rate(),
                pipe.rate(), of_bound.back(), of_encoder.back(), of_pipe.back());
    std::fflush(stdout);
  }
  std::printf("median: %.2f of the bound of two cores, %.2f of the encoder alone, %.2f times the pipe\n",
              median(of_bound), median(of_encoder), median(of_pipe));
  // Work does not depend on who else uses the machine.
  std::printf("CPU time of the pipe over ours: %.2f\n", median(pipe_cpu));
}

void png(const fs::path& folder, const std::string& script, int rounds, int frames) {
  Stage stage(script, {});
  std::vector<render::Image> pictures;
  for (int i = 0; i < 30; ++i) {
    stage.simulate();
    stage.draw();
    pictures.push_back(stage.image);
  }
  std::printf("\nPNG sequence, 1280 x 720, %d frames a row\n", frames);
  std::printf("ours [ms a frame]  bytes | stock stb, one thread  bytes | times as fast\n");
  std::vector<double> ratios, cpu_ratios;
  for (int round = 0; round < rounds; ++round) {
    std::uint64_t bytes = 0, stock_bytes = 0;
    const Cost ours = measure(frames, [&] {
      const auto to = render::make_sink(folder / "f%05d.png");
      to->begin({.width = 1280, .height = 720, .fps = 60, .title = "", .comment = "", .chapters = {}});
      for (int i = 0; i < frames; ++i) to->frame(pictures[static_cast<std::size_t>(i) % pictures.size()]);
      bytes = to->end().bytes;
    });
    const int few = std::max(frames / 10, 3);
    const Cost stock = measure(few, [&] {
      for (int i = 0; i < few; ++i) {
        const render::Image& image = pictures[static_cast<std::size_t>(i) % pictures.size()];
        std::vector<std::uint8_t> rgb;
        rgb.reserve(image.rgba.size());
        for (std::size_t k = 0; k < image.rgba.size(); ++k)
          if (k % 4 != 3) rgb.push_back(image.rgba[k]);
        const std::string path = (folder / "stock.png").string();
        stbi_write_png(path.c_str(), 1280, 720, 3, rgb.data(), 1280 * 3);
        stock_bytes += fs::file_size(path);
      }
    });
    ratios.push_back(stock.wall / ours.wall);
    cpu_ratios.push_back(stock.cpu / ours.cpu);
    std::printf("%17.2f %6.0f | %22.2f %6.0f | %13.1f\n", ours.wall, static_cast<double>(bytes) / frames,
                stock.wall, static_cast<double>(stock_bytes) / few, ratios.back());
  }
  std::printf("median: %.1f times as fast, %.1f times less CPU time\n", median(ratios), median(cpu_ratios));
}

long resident_kib() {
  std::ifstream file("/proc/self/statm");
  long pages = 0, resident = 0;
  file >> pages >> resident;
  return resident * (sysconf(_SC_PAGESIZE) / 1024);
}

// A long capture: memory after each tenth of it.
void memory(const fs::path& folder, const std::string& script, int frames) {
  PaintOptions options;
  options.width = 320;
  options.height = 180;
  Stage stage(script, options);
  const auto to = render::make_sink((folder / "long.mp4").string());
  to->begin({.width = 320, .height = 180, .fps = 60, .title = "", .comment = "", .chapters = {}});
  std::printf("\nMemory over %d frames at 320 x 180 [MiB]:", frames);
  for (int i = 1; i <= frames; ++i) {
    stage.simulate();
    stage.draw();
    to->frame(stage.image);
    if (i % std::max(frames / 10, 1) == 0) std::printf(" %.1f", static_cast<double>(resident_kib()) / 1024);
    std::fflush(stdout);
  }
  to->end();
  std::printf("\n");
}

constexpr const char* kUsage =
    R"(usage: render_capture_bench [ROUNDS [FRAMES [LONG]]]

Times of captures and of their parts, so many rounds (5) of so many frames (180). With LONG a capture of so
many frames, too, that watches its memory.
)";

int run(int argc, char** argv) {
  if (argc > 4) throw bench::BadArgument(std::string(argv[4]) + ": expected at most ROUNDS FRAMES LONG");
  const int rounds = argc > 1 ? bench::count_of("ROUNDS", argv[1], 1) : 5;
  const int frames = argc > 2 ? bench::count_of("FRAMES", argv[2], 10) : 180;
  const int longest = argc > 3 ? bench::count_of("LONG", argv[3], 10) : 0;
  const fs::path folder = fs::temp_directory_path() / ("skerry_capture_bench_" + std::to_string(getpid()));
  fs::create_directories(folder);
  const std::string script = (folder / "thousand.lua").string();
  std::ofstream(script) << kScene;
  video(folder, script, 1280, 720, rounds, frames);
  video(folder, script, 1920, 1080, rounds, frames);
  png(folder, script, rounds, frames);
  ten_thousand(rounds, frames);
  if (longest > 0) memory(folder, script, longest);
  fs::remove_all(folder);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return bench::run_with_arguments("render_capture_bench", kUsage, argc, argv, run);
}
