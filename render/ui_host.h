// SPDX-License-Identifier: MIT
//
// Dear ImGui on an off-screen picture: panels, tables and plots, the same in captures and in the window.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "render/canvas.h"
#include "render/image.h"
#include "render/style.h"
#include "render/target.h"

struct ImFont;

namespace skerry::render {

struct UiPixels;

/// Input of one frame. In captures all of it stays at its default: no mouse, no keys.
struct UiInput {
  float mouse_x = -1e6f, mouse_y = -1e6f;  ///< [px], from the top left; far away: no mouse
  bool mouse_down[3] = {false, false, false};
  float wheel = 0;
  std::string text;            ///< UTF-8, typed in this frame
  std::vector<int> keys_down;  ///< ImGuiKey_ values
  bool ctrl = false, shift = false, alt = false;
};

/// Owns an ImGui context without .ini file, clipboard and platform windows, with DejaVu fonts that are part
/// of the binary. A GL context must be current; one UiHost at a time is ImGui's current context.
class UiHost {
 public:
  /// @throws EnvironmentError with the driver's log if a program does not compile
  explicit UiHost(const Style& style);
  ~UiHost();
  UiHost(const UiHost&) = delete;
  UiHost& operator=(const UiHost&) = delete;

  /// Starts a frame; then call ImGui functions.
  /// @param scale  of text and spacing, 1 for 720 lines (see ui_scale()); a new value rebuilds the font atlas
  /// @param dt     time since the last frame [s], positive; 1/fps in captures
  void begin_frame(int width, int height, double scale, double dt, const UiInput& input = {});

  /// Ends the frame and draws it over the final picture of `target`. Costs nothing when no window is open.
  /// @param before_front  called when all windows are drawn and what lies in front of them is not yet
  void end_frame(Target& target, const std::function<void()>& before_front = {});
  /// The same without the driver.
  void end_frame(Canvas& canvas);

  /// Ends the frame and draws nothing: ImGui needs two frames until automatic window sizes have settled.
  void end_frame();

  void set_style(const Style& style);

  /// ImGui wants the mouse or the keys for itself.
  [[nodiscard]] bool wants_mouse() const;
  [[nodiscard]] bool wants_keys() const;
  /// A text field has the keyboard: letters are not hotkeys.
  [[nodiscard]] bool wants_text() const;

  [[nodiscard]] ImFont* regular() const;  ///< DejaVu Sans
  [[nodiscard]] ImFont* bold() const;     ///< DejaVu Sans Bold
  [[nodiscard]] ImFont* title() const;    ///< DejaVu Sans Bold, larger
  [[nodiscard]] ImFont* mono() const;     ///< DejaVu Sans Mono

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A texture of RGBA pixels for ImGui::Image, e.g. the heat map of a matrix.
class UiTexture {
 public:
  /// @param smooth  interpolate when enlarged; a matrix is not smooth
  explicit UiTexture(bool smooth = false);
  ~UiTexture();
  UiTexture(const UiTexture&) = delete;
  UiTexture& operator=(const UiTexture&) = delete;

  void upload(const Image& image);
  /// To be passed as ImTextureID.
  [[nodiscard]] void* id() const;

 private:
  std::unique_ptr<UiPixels> pixels_;
};

}  // namespace skerry::render
