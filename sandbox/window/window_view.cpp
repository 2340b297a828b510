// SPDX-License-Identifier: MIT
#include "sandbox/window/window_view.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "render/frame_sink.h"
#include "render/gl_renderer.h"
#include "render/ui_host.h"
#include "sandbox/names.h"
#include "sandbox/overlays/overlay.h"
#include "sandbox/painter.h"
#include "sandbox/scene_view.h"
#include "sandbox/window/actions.h"
#include "sandbox/window/ghost_view.h"
#include "sandbox/window/gui.h"
#include "sandbox/window/pointer.h"

namespace skerry::sandbox {
namespace {

constexpr int kVideoFps = 60;
constexpr int kSettlingFrames = 3;  // ImGui needs two until automatic sizes have settled

bool quiet(const render::WindowInput& input) {
  const render::UiInput& ui = input.ui;
  return input.keys.empty() && ui.text.empty() && ui.wheel == 0 && !input.resized && !ui.mouse_down[0] &&
         !ui.mouse_down[1] && !ui.mouse_down[2];
}

/// Keeps the upper left part.
void crop(render::Image& image, int width, int height) {
  const auto row = static_cast<std::size_t>(width) * 4, old = static_cast<std::size_t>(image.width) * 4;
  for (std::size_t y = 1; y < static_cast<std::size_t>(height) && row != old; ++y)
    std::copy_n(image.rgba.begin() + static_cast<std::ptrdiff_t>(y * old), row,
                image.rgba.begin() + static_cast<std::ptrdiff_t>(y * row));
  image.width = width;
  image.height = height;
  image.rgba.resize(row * static_cast<std::size_t>(height));
}

}  // namespace

struct WindowView::State {
  explicit State(Workbench& workbench)
      : bench(workbench), style(render::style(workbench.theme())), ui(style), composer(style, 16, 16) {}

  Workbench& bench;
  render::Style style;
  render::GlRenderer renderer;
  render::UiHost ui;
  Composer composer;
  std::unique_ptr<render::Target> scene, screen;  ///< all but the toolbar; the whole window
  render::DrawList list;
  Pointer pointer;
  int revision = -1;
  int quiet_frames = 0;
  float mouse_x = 0, mouse_y = 0;
  std::unique_ptr<render::FrameSink> video;
  std::string video_path;
  int video_width = 0, video_height = 0;
  render::Image image;

  void fit(int width, int height);
  void handle(const render::WindowInput& input);
  void draw_scene();
  void draw_panels();
  void try_to_draw(void (State::*part)());
  void write_files();
  void film();
  void end_video();
};

WindowView::WindowView(Workbench& workbench) : state_(std::make_unique<State>(workbench)) {}
WindowView::~WindowView() = default;

render::Target& WindowView::target() {
  return *state_->screen;
}

bool WindowView::idle() const {
  const State& s = *state_;
  const bool moves = s.bench.has_demo() && s.bench.time().playing();
  return !moves && !s.bench.message() && !s.video && s.quiet_frames > kSettlingFrames;
}

/// Targets of the window's size; the overlays' places when they or the size changed.
void WindowView::State::fit(int width, int height) {
  const WindowFit all = fit_window(width, height);
  const int bar = static_cast<int>(std::lround(all.toolbar_px() * all.scale));
  const int scene_height = std::max(1, height - bar);
  bool changed = revision != bench.revision();
  if (!screen || screen->width() != width || screen->height() != height) {
    screen = std::make_unique<render::Target>(width, height);
    scene = std::make_unique<render::Target>(width, scene_height);
    changed = true;
  }
  if (!changed && !bench.fit_view) return;
  revision = bench.revision();
  style = render::style(bench.theme());
  ui.set_style(style);
  composer.show(bench.overlays(), width, scene_height);
  if (!composer.left_out().empty())
    bench.say("no room for " + join(composer.left_out()) + ": close another panel or make the window larger");
  quiet_frames = 0;
  if (bench.fit_view && bench.has_demo()) {
    bench.camera = composer.camera(bench.player().demo());
    bench.fit_view = false;
  }
  bench.camera.width_px = width;
  bench.camera.height_px = scene_height;
}

void WindowView::State::handle(const render::WindowInput& input) {
  // While a field takes text its keys are letters; those that no field knows still count.
  const bool typing = ui.wants_text();
  for (const render::KeyPress& key : input.keys) {
    const bool letter = key.key < 256 || key.key == render::kKeyEnter || key.key == render::kKeyLeft ||
                        key.key == render::kKeyRight || key.key == render::kKeyHome ||
                        key.key == render::kKeyEnd || key.key == render::kKeyUp ||
                        key.key == render::kKeyDown || key.key == render::kKeyDelete;
    if (!(typing && letter)) press(bench, key);
  }
  const bool over_scene = !ui.wants_mouse() && input.ui.mouse_y < static_cast<float>(scene->height());
  pointer.frame(input.ui, over_scene, bench);
}

void WindowView::State::draw_scene() {
  list.clear();
  list.background = style.background;
  if (bench.has_demo()) {
    const Player& player = bench.player();
    composer.scene(player.demo(), player.history(), bench.camera, bench.selection, list);
    if (bench.has_ghost()) draw_ghost(bench.ghost().demo().world(), style, list);
    draw_hand(player.demo().world(), player.hand(), style, list);
    draw_selection(player.demo().world(), bench.selection.body, style, list);
  }
  renderer.draw(list, bench.camera, *scene);
}

void WindowView::State::draw_panels() {
  if (!bench.has_demo()) return;
  const Player& player = bench.player();
  composer.panels(player.demo(), player.history(), bench.camera, bench.selection, ui, bench.time().speed());
}

/// A part that cannot be drawn is told; the session goes on.
void WindowView::State::try_to_draw(void (State::*part)()) {
  try {
    (this->*part)();
  } catch (const std::exception& error) {
    bench.say(error.what(), true);
  }
}

void WindowView::frame(const render::WindowInput& input, int width, int height) {
  State& s = *state_;
  const bool still = quiet(input) && input.ui.mouse_x == s.mouse_x && input.ui.mouse_y == s.mouse_y;
  s.mouse_x = input.ui.mouse_x;
  s.mouse_y = input.ui.mouse_y;
  s.quiet_frames = still ? s.quiet_frames + 1 : 0;
  s.fit(width, height);
  const WindowFit fit = fit_window(width, height);
  const auto scale = static_cast<float>(fit.scale);
  // A video has a clock of its own, so that it does not stutter when frames take long.
  const double seconds = s.video ? 1.0 / kVideoFps : input.seconds;
  s.ui.begin_frame(width, height, scale, std::clamp(input.seconds, 1e-3, 0.25), input.ui);
  s.handle(input);
  s.bench.watch_file(input.seconds);
  s.bench.advance(seconds);
  s.bench.follow_selection();
  s.fit(width, height);
  s.try_to_draw(&State::draw_scene);
  s.try_to_draw(&State::draw_panels);
  show_gui({s.bench, s.ui, s.style, static_cast<float>(width), static_cast<float>(height), fit,
            s.bench.has_demo() ? s.composer.note_top() : static_cast<float>(height)});
  s.screen->paste(*s.scene);
  s.ui.end_frame(*s.screen, [&] { s.write_files(); });
}

/// Files that want the picture, without the message in front of it.
void WindowView::State::write_files() {
  if (bench.take_screenshot) {
    bench.take_screenshot = false;
    try {
      const std::string path = bench.free_name(".png");
      screen->read(image);
      render::write_png(path, image);
      bench.say(path + ": " + std::to_string(image.width) + " x " + std::to_string(image.height) + " pixels");
    } catch (const std::exception& error) {
      bench.say(error.what(), true);
    }
  }
  if (bench.record_video || video) film();
}

/// A film shows the scene and its panels, not the toolbar; it ends when the window changes its size.
void WindowView::State::film() {
  try {
    if (bench.record_video && !video) {
      video_path = bench.free_name(".mp4");
      video_width = screen->width() & ~1;
      video_height = scene->height() & ~1;
      video = render::make_sink(video_path);
      video->begin({.width = video_width,
                    .height = video_height,
                    .fps = kVideoFps,
                    .title = bench.has_demo() ? bench.player().demo().title() : "",
                    .comment = "skerry open",
                    .chapters = {}});
      bench.say("recording " + video_path + "; F9 ends it");
      return;
    }
    const bool same_size = video_width == (screen->width() & ~1) && video_height == (scene->height() & ~1);
    if (!bench.record_video || !same_size) {
      end_video();
      return;
    }
    screen->read(image);
    crop(image, video_width, video_height);
    video->frame(image);
  } catch (const std::exception& error) {
    video.reset();
    bench.record_video = false;
    bench.say(error.what(), true);
  }
}

void WindowView::State::end_video() {
  bench.record_video = false;
  if (!video) return;
  const std::unique_ptr<render::FrameSink> sink = std::move(video);
  const render::SinkReport report = sink->end();
  char length[32];
  std::snprintf(length, sizeof length, "%.1f s", static_cast<double>(report.frames) / kVideoFps);
  bench.say(video_path + ": " + length);
}

void WindowView::finish() {
  state_->end_video();
}

}  // namespace skerry::sandbox
