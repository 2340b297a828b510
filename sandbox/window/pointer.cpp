// SPDX-License-Identifier: MIT
#include "sandbox/window/pointer.h"

#include <algorithm>
#include <cmath>

#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {
namespace {

constexpr float kClickPx = 4;       // a hand is never quite still
constexpr double kPickSlackPx = 6;  // small bodies can be hit
constexpr double kZoomPerNotch = 1.15;
constexpr double kLeastHeight = 1e-6, kMostHeight = 1e9;  // of the view [m]

}  // namespace

void Pointer::frame(const render::UiInput& input, bool over_scene, Workbench& bench) {
  const float x = input.mouse_x, y = input.mouse_y;
  if (x < -1e5f && doing_ == Doing::Nothing) return;  // no mouse
  const render::Point world = bench.camera.to_world({x, y});
  const Vec2 at{world.x, world.y};
  const bool pressed[2] = {input.mouse_down[0] && !was_down_[0], input.mouse_down[1] && !was_down_[1]};
  const bool pressed_middle = input.mouse_down[2] && !was_down_[2];
  if (doing_ == Doing::Nothing && over_scene && bench.has_demo() &&
      (pressed[0] || pressed[1] || pressed_middle)) {
    start_x_ = last_x_ = x;
    start_y_ = last_y_ = y;
    moved_ = false;
    doing_ = pressed[1] ? Doing::RightButton : Doing::Panning;
    const double slack = kPickSlackPx / bench.camera.pixels_per_metre();
    const Player& player = bench.player();
    // With the matrix open, contact points come before the bodies under them.
    if (pressed[0] && bench.shows("matrix") &&
        select_contact_at(player.demo(), player.history(), at, slack, bench.selection)) {
      doing_ = Doing::Nothing;
    } else if (pressed[0]) {
      const BodyId body = pick_body(player.demo().world(), at, slack, player.inputs());
      bench.selection = {};
      bench.selection.body = body;
      if (body) {
        bench.grab(body, at);
        doing_ = Doing::Dragging;
      }
    }
  }
  if (doing_ != Doing::Nothing) {
    moved_ = moved_ || std::max(std::abs(x - start_x_), std::abs(y - start_y_)) > kClickPx;
    const bool held = input.mouse_down[0] || input.mouse_down[1] || input.mouse_down[2];
    if (doing_ == Doing::Dragging) {
      bench.drag(at);
    } else if (moved_) {
      bench.camera.pan(x - last_x_, y - last_y_);
    }
    last_x_ = x;
    last_y_ = y;
    if (!held) {
      if (doing_ == Doing::Dragging) bench.release();
      if (doing_ == Doing::RightButton && !moved_) bench.spawn(at);
      doing_ = Doing::Nothing;
    }
  }
  if (over_scene && input.wheel != 0) {
    const double height = bench.camera.height;
    const double wanted = height / std::pow(kZoomPerNotch, static_cast<double>(input.wheel));
    // A demo may have a larger or smaller view of its own.
    bench.camera.zoom_at(
        {x, y}, height / std::clamp(wanted, std::min(height, kLeastHeight), std::max(height, kMostHeight)));
  }
  std::copy(std::begin(input.mouse_down), std::end(input.mouse_down), std::begin(was_down_));
}

}  // namespace skerry::sandbox
