// SPDX-License-Identifier: MIT
//
// One frame of the window: input in, picture out. It draws on a Target and needs a current GL context, not a
// window, so tests drive it without a display.
#pragma once

#include <memory>

#include "render/target.h"
#include "render/window_context.h"
#include "sandbox/window/workbench.h"

namespace skerry::sandbox {

class WindowView {
 public:
  /// @throws render::EnvironmentError if the driver lacks what drawing needs
  explicit WindowView(Workbench& workbench);
  ~WindowView();

  /// Handles the input, makes the steps that are due and draws. The picture is `target()` afterwards.
  /// @param width, height of the window [px]
  void frame(const render::WindowInput& input, int width, int height);
  render::Target& target();
  /// Nothing moves and nothing was done for some frames: the picture need not be drawn again.
  bool idle() const;
  /// Ends a video that is being recorded.
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace skerry::sandbox
