// SPDX-License-Identifier: MIT
//
// Small helpers for overlays that draw panels.
#pragma once

#include <string>

#include "render/style.h"
#include "sandbox/layout.h"
#include "sandbox/overlays/overlay.h"

struct ImDrawList;

namespace skerry::sandbox {

inline constexpr double kPanelTitlePx = 30;
inline constexpr double kPanelPadPx = 12;
/// Inner width of a panel.
inline constexpr double kPanelWidthPx = kColumnPx - 2 * kPanelPadPx;
inline constexpr double kLinePx = 16;       ///< height of a line of text
inline constexpr double kSmallLinePx = 14;  ///< the same, small

/// A framed box in its column with a title line. Coordinates of its functions are pixels of the style, from
/// the upper left corner of the content; what is drawn becomes visible when the panel ends.
class Panel {
 public:
  /// @param height of the content below the title [px of the style]
  Panel(const PanelContext& context, const char* title, double height);
  ~Panel();
  Panel(const Panel&) = delete;
  Panel& operator=(const Panel&) = delete;

  double width() const { return kPanelWidthPx; }
  double height() const { return height_; }

  void text(double x, double y, render::Color color, const std::string& words,
            render::Face face = render::Face::Regular, render::Align align = render::Align::Left,
            double line = kLinePx) const;
  /// The same, cut to `width`.
  void fitted(double x, double y, double width, render::Color color, const std::string& words) const;
  /// The same, cut before its last word, or in the middle of one: for names that differ at their ends.
  void squeezed(double x, double y, double width, render::Color color, const std::string& words) const;
  /// Small text.
  void small(double x, double y, render::Color color, const std::string& words,
             render::Align align = render::Align::Left) const {
    text(x, y, color, words, render::Face::Regular, align, kSmallLinePx);
  }
  double text_width(const std::string& words, double line = kLinePx) const;
  /// Lines of at most `width`, at most `lines` of them; the last ends in ".." when there is more.
  std::vector<std::string> wrapped(const std::string& words, double width, std::size_t lines) const;

  void rect(double x, double y, double width, double height, render::Color fill, double rounding = 0) const;
  void frame(double x, double y, double width, double height, render::Color color, double line = 1) const;
  void line(double x0, double y0, double x1, double y1, render::Color color, double width = 1) const;
  void triangle(double x0, double y0, double x1, double y1, double x2, double y2, render::Color fill) const;
  void curve(const std::vector<render::Pixel>& points, render::Color color, double width) const;
  render::Pixel at(double x, double y) const;

  /// Where the mouse is, if it is over this panel. @param x, y  [px of the style]
  bool hovered(double& x, double& y) const;
  bool clicked() const;

 private:
  const PanelContext& context_;
  double x_, y_, height_;
  std::size_t first_;
};

/// "1.5 kN", "230 mm": three digits with the usual prefixes; what is below 1e-13 is "0 N".
std::string si(double value, const char* unit);

}  // namespace skerry::sandbox
