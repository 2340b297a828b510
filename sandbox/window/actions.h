// SPDX-License-Identifier: MIT
//
// The keys of the window, one table: the handler, the help panel and the README follow from it. Letters are
// left to the overlays (`Overlay::key`).
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "render/window_context.h"
#include "sandbox/window/workbench.h"

namespace skerry::sandbox {

struct KeyAction {
  int key = 0;  ///< as in render::KeyPress
  bool ctrl = false, shift = false;
  bool repeats = false;   ///< while the key is held
  std::string_view keys;  ///< for people: "Space"
  std::string_view what;  ///< "play or pause"
  void (*run)(Workbench&);
};

std::span<const KeyAction> actions();

/// Does what the key stands for. @return false for a key without a meaning
bool press(Workbench& workbench, const render::KeyPress& key);

/// The keys as a Markdown table, overlays included.
std::string keys_table();

}  // namespace skerry::sandbox
