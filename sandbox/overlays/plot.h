// SPDX-License-Identifier: MIT
//
// Curves over an axis, in panels and in figures.
#pragma once

#include <string>
#include <vector>

#include "render/sheet.h"
#include "render/style.h"

namespace skerry::sandbox {

/// A curve with its name and, for the legend, the last value.
struct Curve {
  std::string name;
  render::Color color;
  std::vector<double> x, y;
};

struct Chart {
  std::string x_name, y_name;    ///< with units; may be empty
  double x_low = 0, x_high = 1;  ///< range of the horizontal axis
  bool logarithmic = false;      ///< the vertical axis, by decades
  double least = 1e-16;          ///< of a logarithmic axis: smaller values stand at its lower end
  double low = 0, high = 0;      ///< the vertical axis shows at least these
  bool last_values = true;       ///< in the legend
  std::vector<Curve> curves;
};

/// Height that the legend's rows after the first need [px of the style].
double legend_extra_px(const Chart& chart, double width);

/// Draws axes, ticks, curves and below the legend into the box at `origin`; where its names fill more than
/// half of it, it says how many more there are.
/// @param width, height  of all of it [px of the style]
/// @param scale          pixels of the sheet per pixel of the style
void draw_chart(const Chart& chart, const render::Style& style, render::Pixel origin, double width,
                double height, double scale, render::Sheet& sheet);

/// A number in few characters: 17341, 1.734e7, -2.1e-12.
/// @param digits that count, at least
std::string short_number(double value, int digits);

/// Positions of ticks at 1, 2 or 5 times a power of ten within [low, high], at most about `most` of them.
std::vector<double> ticks(double low, double high, int most);

/// Which of n samples to draw: at most `most`, the first and the last among them, and in each stretch the
/// lowest and the highest, so that a peak never vanishes.
std::vector<std::size_t> thinned(const std::vector<double>& values, std::size_t most);

}  // namespace skerry::sandbox
