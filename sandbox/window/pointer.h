// SPDX-License-Identifier: MIT
//
// The mouse over the scene: drags bodies, moves and zooms the view, picks, makes bodies.
#pragma once

#include "render/ui_host.h"
#include "sandbox/window/workbench.h"

namespace skerry::sandbox {

class Pointer {
 public:
  /// @param input of this frame. @param over_scene the mouse is over the scene and no control wants it
  void frame(const render::UiInput& input, bool over_scene, Workbench& workbench);

 private:
  enum class Doing { Nothing, Dragging, Panning, RightButton };

  Doing doing_ = Doing::Nothing;
  float start_x_ = 0, start_y_ = 0, last_x_ = 0, last_y_ = 0;
  bool moved_ = false;  ///< farther than a click
  bool was_down_[3] = {false, false, false};
};

}  // namespace skerry::sandbox
