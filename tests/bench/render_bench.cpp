// SPDX-License-Identifier: MIT
//
// What a captured frame costs, part by part: draw (by the built-in rasteriser and by OpenGL, on the graphics
// processor where there is one, else by the software driver), read back, convert, encode, PNG.
#include <benchmark/benchmark.h>
#include <cmath>
#include <filesystem>
#include <stb_image_write.h>

#include "render/canvas.h"
#include "render/egl_context.h"
#include "render/frame_sink.h"
#include "render/gl_renderer.h"
#include "render/style.h"
#include "render/yuv.h"

namespace skerry::render {
namespace {

constexpr int kWidth = 1280, kHeight = 720;

/// A heap of `bodies` boxes, discs and polygons, with a contact normal for every second one if `normals`.
void fill(DrawList& list, int bodies, double phase, bool normals = true) {
  const Style& s = style(Theme::Light);
  list.clear();
  list.background = s.background;
  const int columns = static_cast<int>(std::ceil(std::sqrt(bodies * 16.0 / 9)));
  const double pitch = 12.6 / columns;
  for (int i = 0; i < bodies; ++i) {
    const double x = -6.3 + pitch * (i % columns + 0.5), y = -3.5 + pitch * (i / columns + 0.5);
    const double r = 0.47 * pitch, a = 0.7 * i + phase;
    const Paint& p = body_paint(s, i);
    DrawLayer& layer = list[Layer::Bodies];
    const auto corner = [&](double angle) {
      return Point{x + r * std::cos(a + angle), y + r * std::sin(a + angle)};
    };
    if (i % 4 == 0) {
      layer.discs.push_back({{x, y}, r, p.fill, p.outline, s.outline_px, a, true});
    } else if (i % 4 == 3) {
      Point points[6];
      const int n = 3 + i / 4 % 4;
      for (int k = 0; k < n; ++k) points[k] = corner(6.283185307 * k / n);
      layer.polygon(points, static_cast<std::size_t>(n), p.fill, p.outline, 0, s.outline_px);
    } else {
      const Point points[] = {corner(0.6), corner(2.54), corner(3.74), corner(5.68)};
      layer.polygon(points, 4, p.fill, p.outline, 0, s.outline_px);
    }
    if (normals && i % 2 == 0) {
      list[Layer::Contacts].arrows.push_back(
          {{x, y}, {x + r * std::cos(2 * a), y + r * std::sin(2 * a)}, s.normal, s.normal_px, 8});
    }
  }
}

struct Scene {
  EglContext context;
  GlRenderer renderer;
  Target target{kWidth, kHeight};
  Canvas canvas{kWidth, kHeight};
  Camera camera;
  DrawList list;
  Image image;
  Scene() { camera.height = 7.2; }
  void draw(bool by_driver = false) {
    if (!by_driver) {
      canvas.draw(list, camera);
      return;
    }
    renderer.draw(list, camera, target);
    context.finish();
  }
  std::string name(bool by_driver) const { return by_driver ? context.renderer() : "built-in"; }
};

/// The CPU column counts all threads: llvmpipe draws in its own.
void Draw(benchmark::State& state) {
  Scene scene;
  fill(scene.list, static_cast<int>(state.range(0)), 0, state.range(1) != 0);
  const bool by_driver = state.range(2) != 0;
  for (auto _ : state) scene.draw(by_driver);
  state.SetLabel(scene.name(by_driver));
}
BENCHMARK(Draw)
    ->ArgNames({"bodies", "normals", "driver"})
    ->ArgsProduct({{0, 1000, 10000}, {0, 1}, {0, 1}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

/// 10 000 shapes of one kind, on a grid: what each costs.
void DrawKind(benchmark::State& state) {
  Scene scene;
  const Style& s = style(Theme::Light);
  DrawLayer& layer = scene.list[Layer::Bodies];
  constexpr double kPitch = 12.6 / 134, kRadius = 0.47 * kPitch;
  const char* const kinds[] = {"discs",         "boxes",         "hexagons",
                               "arrows, 26 px", "arrows, 80 px", "contact points"};
  const auto kind = static_cast<std::size_t>(state.range(0));
  for (int i = 0; i < 10000; ++i) {
    const Point c{-6.3 + kPitch * (i % 134 + 0.5), -3.5 + kPitch * (i / 134 + 0.5)};
    const double a = 0.7 * i;
    const Paint& p = body_paint(s, i);
    const auto at = [&](double radius, double angle) {
      return Point{c.x + radius * std::cos(a + angle), c.y + radius * std::sin(a + angle)};
    };
    if (kind == 0) layer.discs.push_back({c, kRadius, p.fill, p.outline, s.outline_px, a, true});
    if (kind == 1) {
      const Point corners[] = {at(kRadius, 0.6), at(kRadius, 2.54), at(kRadius, 3.74), at(kRadius, 5.68)};
      layer.polygon(corners, 4, p.fill, p.outline, 0, s.outline_px);
    }
    if (kind == 2) {
      Point corners[6];
      for (int k = 0; k < 6; ++k) corners[k] = at(kRadius, 6.283185307 * k / 6);
      layer.polygon(corners, 6, p.fill, p.outline, 0, s.outline_px);
    }
    if (kind == 3) layer.arrows.push_back({c, at(0.26, 0), s.normal, s.normal_px, 0.6f * s.arrow_head_px});
    if (kind == 4) layer.arrows.push_back({c, at(0.8, 0), s.force, s.arrow_px, s.arrow_head_px});
    if (kind == 5) layer.markers.push_back({c, s.contact, s.contact, s.contact_px});
  }
  const bool by_driver = state.range(1) != 0;
  for (auto _ : state) scene.draw(by_driver);
  state.SetLabel(kinds[kind] + (", " + scene.name(by_driver)));
}
BENCHMARK(DrawKind)
    ->ArgNames({"kind", "driver"})
    ->ArgsProduct({benchmark::CreateDenseRange(0, 5, 1), {0, 1}})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();

void DrawFine(benchmark::State& state) {
  Scene scene;
  fill(scene.list, 1000, 0);
  Target target(kWidth, kHeight, static_cast<int>(state.range(0)));
  for (auto _ : state) {
    scene.renderer.draw(scene.list, scene.camera, target);
    scene.context.finish();
  }
}
BENCHMARK(DrawFine)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime()->MeasureProcessCPUTime();

void ReadBack(benchmark::State& state) {
  Scene scene;
  fill(scene.list, 1000, 0);
  scene.draw(true);
  for (auto _ : state) scene.target.read(scene.image);
}
BENCHMARK(ReadBack)->Unit(benchmark::kMillisecond)->UseRealTime();

Image frame(Scene& scene, double phase) {
  fill(scene.list, 1000, phase);
  scene.draw();
  scene.canvas.take(scene.image);
  return scene.image;
}

void ConvertTo420(benchmark::State& state) {
  Scene scene;
  const Image image = frame(scene, 0);
  std::vector<std::uint8_t> y(kWidth * kHeight), u(y.size() / 4), v(y.size() / 4);
  for (auto _ : state) {
    to_yuv420(image, {{y.data(), u.data(), v.data()}, {kWidth, kWidth / 2, kWidth / 2}});
    benchmark::ClobberMemory();
  }
}
BENCHMARK(ConvertTo420)->Unit(benchmark::kMillisecond);

void EncodePng(benchmark::State& state) {
  Scene scene;
  const Image image = frame(scene, 0);
  std::size_t bytes = 0;
  for (auto _ : state) bytes = encode_png(image).size();
  state.counters["bytes"] = static_cast<double>(bytes);
}
BENCHMARK(EncodePng)->Unit(benchmark::kMillisecond);

void EncodePngByStb(benchmark::State& state) {
  Scene scene;
  const Image image = frame(scene, 0);
  std::vector<std::uint8_t> rgb;
  for (std::size_t i = 0; i < image.rgba.size(); ++i) {
    if (i % 4 != 3) rgb.push_back(image.rgba[i]);
  }
  std::size_t bytes = 0;
  const auto count = [](void* total, void*, int size) {
    *static_cast<std::size_t*>(total) += static_cast<std::size_t>(size);
  };
  for (auto _ : state) {
    bytes = 0;
    stbi_write_png_to_func(count, &bytes, kWidth, kHeight, 3, rgb.data(), kWidth * 3);
  }
  state.counters["bytes"] = static_cast<double>(bytes);
}
BENCHMARK(EncodePngByStb)->Unit(benchmark::kMillisecond);

/// Frames a second into a file, from pictures in memory; or drawn and read back in the loop.
void Capture(benchmark::State& state, const char* extension, bool draw) {
  Scene scene;
  constexpr int kFrames = 60;
  std::vector<Image> images;
  for (int i = 0; i < kFrames && !draw; ++i) images.push_back(frame(scene, 0.01 * i));
  const std::filesystem::path path =
      std::filesystem::temp_directory_path() / (std::string("skerry_bench") + extension);
  SinkReport report;
  for (auto _ : state) {
    const auto sink = make_sink(path);
    sink->begin({kWidth, kHeight, 60, "", "", {}});
    for (int i = 0; i < kFrames; ++i) {
      if (draw) {
        fill(scene.list, 1000, 0.01 * i);
        scene.draw();
        scene.canvas.take(scene.image);
      }
      sink->frame(draw ? scene.image : images[static_cast<std::size_t>(i)]);
    }
    report = sink->end();
  }
  state.counters["frames/s"] =
      benchmark::Counter(static_cast<double>(kFrames * state.iterations()), benchmark::Counter::kIsRate);
  state.counters["bytes"] = static_cast<double>(report.bytes);
  std::filesystem::remove(path);
}
BENCHMARK_CAPTURE(Capture, EncodeMp4, ".mp4", false)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(Capture, DrawAndEncodeMp4, ".mp4", true)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->MeasureProcessCPUTime();
BENCHMARK_CAPTURE(Capture, EncodeWebm, ".webm", false)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Iterations(1);
BENCHMARK_CAPTURE(Capture, EncodeGif, ".gif", false)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime()
    ->Iterations(1);

}  // namespace
}  // namespace skerry::render

BENCHMARK_MAIN();
