// SPDX-License-Identifier: MIT
//
// Small helpers for overlays that draw with ImGui.
#pragma once

#include <imgui.h>
#include <string>

#include "render/style.h"
#include "sandbox/layout.h"
#include "sandbox/overlays/overlay.h"

namespace skerry::sandbox {

inline ImU32 pack(render::Color color) {
  return IM_COL32(color.r, color.g, color.b, color.a);
}

/// A framed box in the column with a title line; lets the caller draw below it.
class Panel {
 public:
  /// @param height of the content below the title [px of the style]
  Panel(const PanelContext& context, const char* title, double height);
  ~Panel();
  Panel(const Panel&) = delete;
  Panel& operator=(const Panel&) = delete;

  ImDrawList* draw() const { return draw_; }
  /// Top left corner of the content, its width and height [px of the picture].
  float x() const { return x_; }
  float y() const { return y_; }
  float width() const { return width_; }
  float height() const { return height_; }

  void text(float x, float y, render::Color color, const std::string& text, ImFont* font = nullptr) const;
  /// Ends at `right`.
  void text_right(float right, float y, render::Color color, const std::string& text,
                  ImFont* font = nullptr) const;
  /// Middle at (x, y).
  void text_centred(float x, float y, render::Color color, const std::string& text,
                    ImFont* font = nullptr) const;

 private:
  ImFont* standard_;
  ImDrawList* draw_;
  float x_, y_, width_, height_;
};

}  // namespace skerry::sandbox
