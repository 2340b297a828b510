// SPDX-License-Identifier: MIT
//
// Paints frames of a demo: scene, overlays, panels, without a window.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/draw_list.h"
#include "render/egl_context.h"
#include "render/image.h"
#include "render/style.h"
#include "sandbox/demo.h"
#include "sandbox/history.h"
#include "sandbox/overlays/overlay.h"

namespace skerry::sandbox {

struct PaintOptions {
  int width = 1280, height = 720;  ///< [px]
  int ssaa = 1;                    ///< the scene is drawn so many times finer in each direction
  render::Theme theme = render::Theme::Light;
  double fps = 60;
  double speed = 1;
  render::EglDevice device = render::EglDevice::Any;
  std::optional<render::Style> style{};  ///< in place of the theme's
  /// Sees each frame when all of it is there and nothing is drawn: the list, and the panels as ImGui windows.
  /// What it changes is drawn; the self-test of the golden images plants its regressions here.
  std::function<void(render::DrawList&)> edit{};
};

class Painter {
 public:
  /// @throws render::EnvironmentError without EGL or OpenGL 3.3
  explicit Painter(const PaintOptions& options);
  ~Painter();

  /// Prepares for a demo: camera and overlays. @param names rows of the overlay registry
  void start(const Demo& demo, const std::vector<std::string>& names);
  void paint(const Demo& demo, const History& history, render::Image& image);

  /// What draws, without what cannot show in a picture: "llvmpipe (LLVM 15.0.6), 4.5 (Core Profile)
  /// Mesa 22.3.6".
  std::string driver() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// What the overlays called `names` need from the world.
Observe needs_of(const std::vector<std::string>& names);

}  // namespace skerry::sandbox
