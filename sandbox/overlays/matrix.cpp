// SPDX-License-Identifier: MIT
//
// The equations W lambda = b of an island as a picture: cells coloured by sign and, on a log scale, by
// magnitude; numbers while the cells are large enough; lambda, b and w = W lambda - b beside small systems.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "render/ui_host.h"
#include "sandbox/delassus_cells.h"
#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {
namespace {

constexpr double kDecades = 4;         // magnitudes below 1e-4 of the largest get the palest colour
constexpr int kVectorRows = 10;        // with more, there is no room for vectors beside the names
constexpr double kTextCellPx = 15;     // smallest cell beside which a line of text fits
constexpr double kLargestMapPx = 270;  // side of a matrix without vectors
constexpr double kPlainCellPx = 20;    // largest cell of it: leaves room for other panels
constexpr double kLargestCellPx = 46;
constexpr double kNumberCellPx = 34;  // smallest cell that holds "-0.33"
constexpr double kLeastNamePx = 60;   // column of row names
constexpr double kMostNamePx = 112;
constexpr double kVectorPx = 48;
constexpr double kHeadPx = 40;  // summary line and column heads
constexpr double kFootPx = 34;  // colour scale

std::string number(double value, int digits = 3) {
  char text[32];
  // Rounding noise of a cancelled sum is zero to people.
  const double size = std::abs(value);
  if (size >= 1e-12 && size < 1e-3) digits = 1;
  std::snprintf(text, sizeof text, "%.*g", digits, size < 1e-12 ? 0.0 : value);
  std::string result = text;
  if (result.rfind("0.", 0) == 0) result.erase(0, 1);
  if (result.rfind("-0.", 0) == 0) result.erase(1, 1);
  return result;
}

// 0 for the palest, 1 for the strongest colour.
double strength(double value, double largest) {
  if (value == 0 || largest <= 0) return 0;
  return std::clamp(1 + std::log10(std::abs(value) / largest) / kDecades, 0.06, 1.0);
}

render::Color cell_color(const render::Style& style, double value, double largest) {
  const render::Color hue = value < 0 ? style.friction : style.impulse;
  return render::mixed(style.background, hue, 0.85 * strength(value, largest));
}

void draw_cells(const Panel& panel, const render::Style& style, const CellGrid& grid, float x, float y,
                float cell) {
  const float gap = cell > 6 ? 1.0f : 0.0f;
  for (int row = 0; row < grid.size; ++row) {
    for (int column = 0; column < grid.size; ++column) {
      const double value = grid.at(row, column);
      if (value == 0) continue;
      const float left = x + static_cast<float>(column) * cell;
      const float top = y + static_cast<float>(row) * cell;
      panel.draw()->AddRectFilled({left, top}, {left + cell - gap, top + cell - gap},
                                  pack(cell_color(style, value, grid.largest)));
    }
  }
  const float side = cell * static_cast<float>(grid.size);
  panel.draw()->AddRect({x - 1, y - 1}, {x + side, y + side}, pack(style.panel_border));
}

void draw_numbers(const Panel& panel, const render::Style& style, const CellGrid& grid, float x, float y,
                  float cell) {
  for (int row = 0; row < grid.size; ++row) {
    for (int column = 0; column < grid.size; ++column) {
      const double value = grid.at(row, column);
      if (value == 0) continue;
      const bool dark = strength(value, grid.largest) > 0.6 && style.theme == render::Theme::Light;
      panel.text_centred(x + (static_cast<float>(column) + 0.5f) * cell,
                         y + (static_cast<float>(row) + 0.5f) * cell, dark ? style.background : style.text,
                         number(value, 2));
    }
  }
}

// The vectors that stand beside the matrix.
void draw_vectors(const Panel& panel, const render::Style& style, const SystemRecord& record, float y,
                  float row_height, float column) {
  // W lambda = (W lambda - b) + b
  std::vector<double> product = row_velocities(record.system, record.lambda);
  for (std::size_t i = 0; i < product.size(); ++i) product[i] += record.system.b[i];
  const float right = panel.x() + panel.width();
  const float head = y - 1.35f * ImGui::GetFontSize();
  const auto draw = [&](const char* name, const std::vector<double>& values, float end) {
    panel.text_right(end, head, style.text_dim, name);
    for (std::size_t i = 0; i < values.size(); ++i) {
      const float middle = y + (static_cast<float>(i) + 0.5f) * row_height;
      panel.text_right(end, middle - 0.5f * ImGui::GetFontSize(), style.text, number(values[i]));
    }
  };
  draw("\xCE\xBB N s", record.lambda, right - 2 * column);
  draw("W\xCE\xBB", product, right - column);
  draw("b m/s", record.system.b, right);
}

void draw_scale(const Panel& panel, const render::Style& style, double largest, float scale) {
  const float y = panel.y() + panel.height() - static_cast<float>(kFootPx - 14) * scale;
  const float width = 0.42f * panel.width();
  const float x = panel.x() + 0.5f * (panel.width() - width);
  constexpr int kSteps = 24;
  const float step = width / (2 * kSteps + 1);
  for (int i = -kSteps; i <= kSteps; ++i) {
    const double share = std::abs(i) / static_cast<double>(kSteps);
    const double value = i == 0 ? 0 : std::copysign(largest * std::pow(10.0, kDecades * (share - 1)), i);
    const float left = x + static_cast<float>(i + kSteps) * step;
    panel.draw()->AddRectFilled({left, y}, {left + step, y + 9 * scale},
                                pack(cell_color(style, value, largest)));
  }
  const float text_y = y - 4 * scale;
  panel.text_right(x - 6 * scale, text_y, style.text_dim, number(-largest));
  panel.text(x + width + 6 * scale, text_y, style.text_dim, number(largest) + " /kg");
}

float text_width(const std::string& text) {
  return ImGui::CalcTextSize(text.c_str()).x;
}

// Cuts a name that is too wide. Names are ASCII or end in the bodies' own names; a cut letter does no harm.
std::string fitted(std::string text, float width) {
  if (text_width(text) <= width) return text;
  while (text.size() > 1 && text_width(text + "..") > width) text.pop_back();
  return text + "..";
}

double name_column(const SystemRecord& record, double scale) {
  double widest = kLeastNamePx;
  for (const std::string& name : record.row_names)
    widest = std::max(widest, static_cast<double>(text_width(name)) / scale + 8);
  return std::min(widest, kMostNamePx);
}

std::string summary(const SystemRecord& record, int nonzeros) {
  const int n = record.system.size();
  char text[200];
  std::snprintf(text, sizeof text, "%d x %d, %d nonzeros; %s at %.2f s (%s)", n, n, nonzeros,
                record.impact ? "impact" : "forces", record.time, record.method.c_str());
  return text;
}

}  // namespace

void show_matrix(const PanelContext& context) {
  const SystemRecord* record = context.scene.history.system();
  const render::Style& style = context.scene.style;
  const auto scale = static_cast<float>(context.scale);
  const char* title = "Island matrix W and impulses \xCE\xBB";
  if (!record || record->system.size() == 0) {
    const Panel panel(context, title, 24);
    panel.text(panel.x(), panel.y(), style.text_dim, "nothing touches yet");
    return;
  }
  const int n = record->system.size();
  const double inner = kColumnPx - 24;
  const double name_px = name_column(*record, context.scale);
  // The vectors stand beside the matrix only where its rows are as high as a line of text.
  const double beside = inner - name_px - 3 * kVectorPx - 12;
  const bool vectors = n <= kVectorRows && beside / n >= kTextCellPx;
  const double room = vectors ? beside : std::min({kLargestMapPx, kPlainCellPx * n, inner - name_px});
  const CellGrid grid = delassus_cells(record->system, static_cast<int>(kLargestMapPx / 2));
  const double cell_px = std::min(kLargestCellPx, room / grid.size);
  const bool names = !record->row_names.empty() && cell_px >= kTextCellPx - 2;
  const Panel panel(context, title, kHeadPx + cell_px * grid.size + kFootPx);
  const float cell = static_cast<float>(cell_px) * scale;
  const float x = panel.x() + (names ? static_cast<float>(name_px) * scale
                                     : 0.5f * (panel.width() - cell * static_cast<float>(grid.size)));
  const float y = panel.y() + static_cast<float>(kHeadPx) * scale;
  panel.text(panel.x(), panel.y(), style.text_dim, summary(*record, grid.nonzeros));
  draw_cells(panel, style, grid, x, y, cell);
  if (cell_px >= kNumberCellPx) draw_numbers(panel, style, grid, x, y, cell);
  for (std::size_t i = 0; names && i < record->row_names.size(); ++i)
    panel.text(panel.x(), y + (static_cast<float>(i) + 0.5f) * cell - 0.5f * ImGui::GetFontSize(), style.text,
               fitted(record->row_names[i], static_cast<float>(name_px - 4) * scale));
  if (vectors) draw_vectors(panel, style, *record, y, cell, static_cast<float>(kVectorPx) * scale);
  draw_scale(panel, style, grid.largest, scale);
}

}  // namespace skerry::sandbox
