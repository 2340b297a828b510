// SPDX-License-Identifier: MIT
//
// The window: events in, frames out, until it is closed.
#pragma once

#include <string>

#include "render/style.h"
#include "sandbox/demo.h"
#include "sandbox/io.h"

namespace skerry::sandbox {

struct WindowOptions {
  std::string demo;    ///< name or path; empty: the list of demos
  std::string folder;  ///< of --demos
  DemoOptions options;
  int width = 1280, height = 720;
  render::Theme theme = render::Theme::Light;
  double seconds = 0;      ///< closes by itself after so long [s]; 0: never
  std::string screenshot;  ///< file for the last frame; frames are 1/60 s apart then, whatever the machine
};

/// Opens a window and returns when it was closed or Ctrl-C was pressed.
/// @throws render::EnvironmentError without a display, with what to do
/// @throws ScriptError if there is no such demo
void run_window(const WindowOptions& options, const Io& io);

}  // namespace skerry::sandbox
