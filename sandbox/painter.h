// SPDX-License-Identifier: MIT
//
// Paints frames of a demo: scene, overlays, panels, without a window.
#pragma once

#include <memory>
#include <string>
#include <vector>

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
};

class Painter {
 public:
  /// @throws render::EnvironmentError without EGL or OpenGL 3.3
  explicit Painter(const PaintOptions& options);
  ~Painter();

  /// Prepares for a demo: camera and overlays. @param names rows of the overlay registry
  void start(const Demo& demo, const std::vector<std::string>& names);
  void paint(const Demo& demo, const History& history, render::Image& image);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// What the overlays called `names` need from the world.
Observe needs_of(const std::vector<std::string>& names);

}  // namespace skerry::sandbox
