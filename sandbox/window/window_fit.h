// SPDX-License-Identifier: MIT
//
// How large the words of a window are, and how many rows its toolbar has.
#pragma once

namespace skerry::sandbox {

inline constexpr double kToolbarPx = 54;     ///< height of the toolbar's first row [px of the style]
inline constexpr double kToolbarRowPx = 44;  ///< of each further one, in narrow windows

/// The size of text and the toolbar that fit a window: the scene counts for 720 lines.
struct WindowFit {
  int rows = 1;      ///< of the toolbar
  double scale = 1;  ///< pixels of the window per pixel of the style
  double toolbar_px() const { return kToolbarPx + (rows - 1) * kToolbarRowPx; }
};
WindowFit fit_window(int width, int height);

}  // namespace skerry::sandbox
