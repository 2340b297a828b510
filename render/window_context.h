// SPDX-License-Identifier: MIT
//
// A window with an OpenGL context of its own: GLFW, through EGL, so that one renderer serves it and the
// captures.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "render/target.h"
#include "render/ui_host.h"

namespace skerry::render {

/// Keys without a character; all others are reported as the capital or digit that is printed on them, e.g.
/// 'R', whatever the layout of the keyboard. '?' is reported where it was typed, with any keys.
enum SpecialKey : int {
  kKeyEscape = 256,
  kKeyEnter,
  kKeyTab,
  kKeyBackspace,
  kKeyDelete,
  kKeyLeft,
  kKeyRight,
  kKeyUp,
  kKeyDown,
  kKeyHome,
  kKeyEnd,
  kKeyPageUp,
  kKeyPageDown,
  kKeyF1,  ///< F1 to F12 follow each other
  kKeyF12 = kKeyF1 + 11,
};

/// The character of a key of GLFW. @param name  in the user's layout, as glfwGetKeyName says; may be null
/// @return 0 for keys that have none. Digits go by their place: some layouts have them with Shift only. Keys
/// with a letter that is not Latin go by their place, too.
int printed_on(int glfw_key, const char* name);

struct KeyPress {
  int key = 0;
  bool ctrl = false, shift = false, alt = false;
  bool repeated = false;  ///< held down
};

/// What happened since the last frame. Mouse positions are pixels of the picture, from the top left.
struct WindowInput {
  UiInput ui;                  ///< for UiHost::begin_frame
  std::vector<KeyPress> keys;  ///< pressed, in order
  bool close = false;          ///< the user wants the window to go
  bool resized = false;        ///< width() or height() changed
  double seconds = 0;          ///< since the last call; 0 at the first
};

/// The window's context is current on the thread that made it from construction to destruction. Everything is
/// drawn on a Target of the window's size; present() shows it.
class WindowContext {
 public:
  /// @param width, height  of the picture [px]
  /// @throws EnvironmentError with GLFW's reason: no display server, no OpenGL 3.3
  WindowContext(const std::string& title, int width, int height);
  ~WindowContext();
  WindowContext(const WindowContext&) = delete;
  WindowContext& operator=(const WindowContext&) = delete;

  /// Size of the picture [px]; never 0, also while the window is minimised.
  [[nodiscard]] int width() const;
  [[nodiscard]] int height() const;

  /// Handles what the display server has sent. A press and a release between two calls are reported in two
  /// calls, because ImGui must see them in different frames.
  /// @param wait  returns when something happened, after so many seconds at the latest
  WindowInput poll(double wait = 0);

  /// Shows the final picture of `target`, stretched if its size is not the window's; waits for the screen.
  void present(Target& target);

  void set_title(const std::string& title);

  /// Of the context, as in EglContext.
  [[nodiscard]] const std::string& renderer() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace skerry::render
