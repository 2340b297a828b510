// SPDX-License-Identifier: MIT
#include "sandbox/window/window_fit.h"

#include <algorithm>

namespace skerry::sandbox {

WindowFit fit_window(int width, int height) {
  // What a row of all, and two rows, need.
  constexpr double kLeastWidth[] = {760, 440, 0};
  WindowFit fit;
  for (fit.rows = 1;; ++fit.rows) {
    fit.scale = std::max(0.6, height / (720 + fit.toolbar_px()));
    if (width >= kLeastWidth[fit.rows - 1] * fit.scale) return fit;
  }
}

}  // namespace skerry::sandbox
