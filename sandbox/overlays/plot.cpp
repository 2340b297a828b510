// SPDX-License-Identifier: MIT
#include "sandbox/overlays/plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "render/gl_renderer.h"

namespace skerry::sandbox {
namespace {

constexpr double kTextPx = 14;  // height of a line
constexpr double kCurvePx = 1.8;

std::string tick_text(double value) {
  return short_number(value + 0.0, 4);
}

std::string decade_text(int exponent) {
  char text[16];
  std::snprintf(text, sizeof text, "1e%d", exponent);
  return exponent == 0 ? "1" : text;
}

double width_of(const std::string& text) {
  return render::text_width(text, kTextPx * render::kSheetEm);
}

/// A vertical axis: from values to shares of its height, 0 at the bottom.
struct Axis {
  double low = 0, high = 1;  // of a logarithmic one: exponents
  bool logarithmic = false;
  double least = 0;
  std::vector<std::pair<double, std::string>> marks;  // share, text

  double share(double value) const {
    if (logarithmic) value = std::log10(std::max(value, least));
    return std::clamp((value - low) / (high - low), 0.0, 1.0);
  }
};

Axis vertical_axis(const Chart& chart) {
  Axis axis;
  axis.logarithmic = chart.logarithmic;
  axis.least = chart.least;
  double low = chart.low, high = chart.high;
  if (chart.logarithmic) low = HUGE_VAL;
  for (const Curve& curve : chart.curves) {
    for (const double value : curve.y) {
      if (!std::isfinite(value)) continue;
      low = std::min(low, value);
      high = std::max(high, value);
    }
  }
  if (chart.logarithmic) {
    low = std::floor(std::log10(std::max(std::min(low, high), chart.least)) + 1e-9);
    high = std::ceil(std::log10(std::max(high, chart.least)) - 1e-9);
    if (high <= low) high = low + 1;
    const int step = std::max(1, static_cast<int>(std::ceil((high - low) / 5)));
    for (int k = static_cast<int>(low); k <= static_cast<int>(high); k += step)
      axis.marks.emplace_back((k - low) / (high - low), decade_text(k));
  } else {
    // Rounding noise of a constant does not deserve an axis of its own.
    const double size = std::max(std::abs(low), std::abs(high));
    if (high - low <= 1e-12 * size) high = low + (size > 0 ? size : 1);
    for (const double tick : ticks(low, high, 4))
      axis.marks.emplace_back((tick - low) / (high - low), tick_text(tick));
  }
  axis.low = low;
  axis.high = high;
  return axis;
}

constexpr double kKeyPx = 14;    // stroke before a name of the legend
constexpr double kApartPx = 16;  // between its entries
constexpr double kRowPx = 1.4 * kTextPx;

/// The legend's words, with the last values in as many digits as the width has room for.
std::vector<std::string> legend_words(const Chart& chart, double width) {
  std::vector<std::string> words;
  for (int digits = chart.last_values ? 4 : 0;; --digits) {
    words.clear();
    double needs = -kApartPx;
    for (const Curve& curve : chart.curves) {
      const bool value = digits > 0 && !curve.name.empty() && !curve.y.empty();
      words.push_back(value ? curve.name + ' ' + short_number(curve.y.back(), digits) : curve.name);
      if (!words.back().empty()) needs += kKeyPx + width_of(words.back()) + kApartPx;
    }
    if (needs <= width || digits <= 0) return words;
  }
}

struct LegendEntry {
  std::size_t curve;
  double x;
  int row;
};

/// Where the names stand that are not empty; what finds no room in a row begins the next one.
std::vector<LegendEntry> legend_entries(const std::vector<std::string>& words, double width) {
  std::vector<LegendEntry> entries;
  double x = 0;
  int row = 0;
  for (std::size_t k = 0; k < words.size(); ++k) {
    if (words[k].empty()) continue;
    const double needs = kKeyPx + width_of(words[k]);
    if (x > 0 && x + needs > width) {
      x = 0;
      ++row;
    }
    entries.push_back({k, x, row});
    x += needs + kApartPx;
  }
  return entries;
}

/// Leaves so many of the first names that the rest is counted in the last row. @return the words for that
std::string cut_legend(std::vector<LegendEntry>& entries, const std::vector<std::string>& words, int rows,
                       double width) {
  std::size_t left_out = 0;
  const auto text = [&] { return "+ " + std::to_string(left_out) + " more"; };
  const auto has_room = [&] {
    const LegendEntry& last = entries.back();
    if (last.row >= rows) return false;
    return left_out == 0 || last.row + 1 < rows ||
           last.x + kKeyPx + width_of(words[last.curve]) + kApartPx + width_of(text()) <= width;
  };
  while (!entries.empty() && !has_room()) {
    entries.pop_back();
    ++left_out;
  }
  return left_out > 0 ? text() : std::string();
}

}  // namespace

double legend_extra_px(const Chart& chart, double width) {
  const std::vector<LegendEntry> entries = legend_entries(legend_words(chart, width), width);
  return entries.empty() ? 0 : kRowPx * entries.back().row;
}

std::string short_number(double value, int digits) {
  char text[32];
  const double size = std::abs(value);
  if (size >= std::pow(10.0, digits) && size < 999999.5) {
    std::snprintf(text, sizeof text, "%.0f", value);
    return text;
  }
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  // "e+07" says no more than "e7".
  std::string words = text;
  const std::size_t e = words.find('e');
  if (e == std::string::npos) return words;
  std::size_t from = e + 1;
  if (words[from] == '+')
    words.erase(from, 1);
  else
    ++from;
  while (from + 1 < words.size() && words[from] == '0') words.erase(from, 1);
  return words;
}

std::vector<double> ticks(double low, double high, int most) {
  std::vector<double> result;
  if (!(high > low) || most < 1 || !std::isfinite(high - low)) return result;
  const double least = (high - low) / most;
  const double power = std::pow(10.0, std::floor(std::log10(least)));
  double step = 10 * power;
  for (const double mantissa : {5.0, 2.0, 1.0})
    if (mantissa * power >= least * (1 - 1e-9)) step = mantissa * power;
  const double first = std::ceil(low / step - 1e-9), last = std::floor(high / step + 1e-9);
  // Beyond 2^52 steps from zero neighbouring ticks are the same number.
  if (std::max(std::abs(first), std::abs(last)) > 4e15) return result;
  for (int i = 0; i <= static_cast<int>(last - first); ++i) result.push_back((first + i) * step);
  return result;
}

std::vector<std::size_t> thinned(const std::vector<double>& values, std::size_t most) {
  std::vector<std::size_t> kept;
  const std::size_t n = values.size();
  if (n <= most || most < 4) {
    for (std::size_t i = 0; i < n; ++i) kept.push_back(i);
    return kept;
  }
  const std::size_t stretches = (most - 2) / 2;
  kept.push_back(0);
  for (std::size_t k = 0; k < stretches; ++k) {
    const std::size_t begin = 1 + k * (n - 2) / stretches, end = 1 + (k + 1) * (n - 2) / stretches;
    if (begin == end) continue;
    const auto from = values.begin() + static_cast<std::ptrdiff_t>(begin);
    const auto to = values.begin() + static_cast<std::ptrdiff_t>(end);
    const auto [low, high] = std::minmax_element(from, to);
    const auto first = static_cast<std::size_t>(std::min(low, high) - values.begin());
    const auto second = static_cast<std::size_t>(std::max(low, high) - values.begin());
    kept.push_back(first);
    if (second != first) kept.push_back(second);
  }
  kept.push_back(n - 1);
  return kept;
}

void draw_chart(const Chart& chart, const render::Style& style, render::Pixel origin, double width,
                double height, double scale, render::Sheet& sheet) {
  const auto at = [&](double x, double y) {
    return render::Pixel{origin.x + static_cast<float>(x * scale), origin.y + static_cast<float>(y * scale)};
  };
  const auto text = [&](double x, double y, render::Color color, const std::string& words,
                        render::Align align = render::Align::Left) {
    sheet.text(at(x, y), words, color, static_cast<float>(std::round(kTextPx * scale)), render::Face::Regular,
               align);
  };
  const auto line = [&](double x0, double y0, double x1, double y1, render::Color color) {
    sheet.line(at(x0, y0), at(x1, y1), color, static_cast<float>(scale));
  };

  const Axis axis = vertical_axis(chart);
  double left = 0;
  for (const auto& [share, words] : axis.marks) left = std::max(left, width_of(words) + 6);
  const double top = chart.y_name.empty() ? 0.5 * kTextPx : 1.6 * kTextPx;
  const std::vector<std::string> names = legend_words(chart, width);
  std::vector<LegendEntry> legend = legend_entries(names, width);
  // The curves keep half of the height.
  const int most_rows = std::max(1, static_cast<int>(0.5 * height / kRowPx) - 1);
  const std::string more = cut_legend(legend, names, most_rows, width);
  const int rows = legend.empty() ? 1 : legend.back().row + 1;
  const double below = 2.4 * kTextPx + 6 + (rows - 1) * kRowPx;
  const double right = width, bottom = height - below;
  if (!chart.y_name.empty()) text(0, 0, style.text_dim, chart.y_name);

  for (const auto& [share, words] : axis.marks) {
    const double y = bottom - share * (bottom - top);
    line(left, y, right, y, style.panel_border);
    text(left - 5, y - 0.55 * kTextPx, style.text_dim, words, render::Align::Right);
  }
  const double span = chart.x_high - chart.x_low;
  const auto to_x = [&](double x) {
    return left + (right - left) * std::clamp((x - chart.x_low) / span, 0.0, 1.0);
  };
  const double name_width = width_of(chart.x_name) + 8;
  for (const double tick : ticks(chart.x_low, chart.x_high, 5)) {
    const double x = to_x(tick);
    line(x, bottom, x, bottom + 3, style.text_dim);
    const std::string words = tick_text(tick);
    const double half = 0.5 * width_of(words);
    // The name of the axis has the right end.
    if (x + half < right - name_width && x - half >= 0)
      text(x, bottom + 3, style.text_dim, words, render::Align::Centre);
  }
  line(left, bottom, right, bottom, style.text_dim);
  text(right, bottom + 3, style.text_dim, chart.x_name, render::Align::Right);

  for (const Curve& curve : chart.curves) {
    std::vector<render::Pixel> points;
    for (const std::size_t i :
         thinned(curve.y, static_cast<std::size_t>(std::max(2 * (right - left), 8.0)))) {
      if (!std::isfinite(curve.y[i])) continue;
      points.push_back(at(to_x(curve.x[i]), bottom - axis.share(curve.y[i]) * (bottom - top)));
    }
    sheet.polyline(points.data(), points.size(), curve.color, static_cast<float>(kCurvePx * scale));
  }
  for (const LegendEntry& entry : legend) {
    const double y = height - kTextPx - (rows - 1 - entry.row) * kRowPx;
    sheet.line(at(entry.x, y + 0.5 * kTextPx), at(entry.x + 10, y + 0.5 * kTextPx),
               chart.curves[entry.curve].color, static_cast<float>(2.5 * scale));
    text(entry.x + kKeyPx, y, style.text, names[entry.curve]);
  }
  if (!more.empty()) text(width, height - kTextPx, style.text_dim, more, render::Align::Right);
}

}  // namespace skerry::sandbox
