// SPDX-License-Identifier: MIT
//
// The equations W lambda = b of an island as a picture: cells coloured by sign and, on a log scale, by
// magnitude; numbers while the cells are large enough; lambda, b and w = W lambda - b beside small systems.
// The selected cell lights up its two contacts in the scene, and a contact its row and column.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "render/gl_renderer.h"
#include "sandbox/delassus_cells.h"
#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"
#include "sandbox/scene_view.h"

namespace skerry::sandbox {
namespace {

constexpr double kDecades = 4;         // magnitudes below 1e-4 of the largest get the palest colour
constexpr int kVectorRows = 10;        // with more, there is no room for vectors beside the names
constexpr double kTextCellPx = 15;     // smallest cell beside which a line of text fits
constexpr double kLargestMapPx = 250;  // side of a matrix without vectors
constexpr double kPlainCellPx = 20;    // largest cell of it: leaves room for other panels
constexpr double kLargestCellPx = 46;
constexpr double kNumberCellPx = 34;  // smallest cell that holds "-0.33"
constexpr double kLeastNamePx = 60;   // column of row names
constexpr double kMostNamePx = 112;
constexpr double kVectorPx = 48;
constexpr double kHeadPx = 56;      // two summary lines and column heads
constexpr double kFootPx = 34;      // colour scale
constexpr double kRounded = 1e-10;  // share of the largest number beside it below which one is rounding
static_assert(kHeadPx + kLargestMapPx + kFootPx <= kMatrixPx);

// At most six characters, the width of a column: -.0082, 8e-7, -1.2e3.
std::string number(double value, int digits = 3) {
  char text[32];
  // Rounding noise of a cancelled sum is zero to people.
  const double size = std::abs(value);
  if (size >= 1e-12 && (size < 0.01 || size >= 1000)) digits = std::min(digits, size < 1e-3 ? 1 : 2);
  std::snprintf(text, sizeof text, "%.*g", digits, size < 1e-12 ? 0.0 : value);
  std::string result = text;
  if (result.rfind("0.", 0) == 0) result.erase(0, 1);
  if (result.rfind("-0.", 0) == 0) result.erase(1, 1);
  for (const char* padding : {"e+0", "e-0"})
    if (const std::size_t at = result.find(padding); at != std::string::npos)
      result.replace(at, 3, padding[1] == '+' ? "e" : "e-");
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

/// Where the cells are in the panel.
struct Map {
  const Panel& panel;
  const render::Style& style;
  const CellGrid& grid;
  double x, y, cell;
};

void draw_cells(const Map& map) {
  const double gap = map.cell > 6 ? 1 : 0;
  for (int row = 0; row < map.grid.size; ++row) {
    for (int column = 0; column < map.grid.size; ++column) {
      const double value = map.grid.at(row, column);
      if (value == 0) continue;
      map.panel.rect(map.x + column * map.cell, map.y + row * map.cell, map.cell - gap, map.cell - gap,
                     cell_color(map.style, value, map.grid.largest));
    }
  }
  const double side = map.cell * map.grid.size;
  map.panel.frame(map.x - 1, map.y - 1, side + 1, side + 1, map.style.panel_border);
}

void draw_numbers(const Map& map) {
  for (int row = 0; row < map.grid.size; ++row) {
    for (int column = 0; column < map.grid.size; ++column) {
      const double value = map.grid.at(row, column);
      if (value == 0) continue;
      const bool dark = strength(value, map.grid.largest) > 0.6 && map.style.theme == render::Theme::Light;
      map.panel.text(map.x + (column + 0.5) * map.cell, map.y + (row + 0.5) * map.cell - 0.5 * kLinePx,
                     dark ? map.style.background : map.style.text, number(value, 2), render::Face::Regular,
                     render::Align::Centre);
    }
  }
}

// The vectors that stand beside the matrix.
void draw_vectors(const Map& map, const SystemRecord& record) {
  // W lambda = (W lambda - b) + b
  std::vector<double> product = row_velocities(record.system, record.lambda);
  for (std::size_t i = 0; i < product.size(); ++i) product[i] += record.system.b[i];
  const auto draw = [&](const char* name, const std::vector<double>& values, double end) {
    map.panel.text(end, map.y - 1.2 * kLinePx, map.style.text_dim, name, render::Face::Regular,
                   render::Align::Right);
    double largest = 0;
    for (const double value : values) largest = std::max(largest, std::abs(value));
    for (std::size_t i = 0; i < values.size(); ++i) {
      // What rounding leaves beside the others says nothing.
      const double value = std::abs(values[i]) < kRounded * largest ? 0 : values[i];
      map.panel.text(end, map.y + (static_cast<double>(i) + 0.5) * map.cell - 0.5 * kLinePx, map.style.text,
                     number(value), render::Face::Regular, render::Align::Right);
    }
  };
  const double right = map.panel.width();
  draw("\xCE\xBB N s", record.lambda, right - 2 * kVectorPx);
  draw("W\xCE\xBB", product, right - kVectorPx);
  draw("b m/s", record.system.b, right);
}

void draw_scale(const Panel& panel, const render::Style& style, double largest) {
  const double y = panel.height() - kFootPx + 14;
  const double width = 0.42 * panel.width();
  const double x = 0.5 * (panel.width() - width);
  constexpr int kSteps = 24;
  const double step = width / (2 * kSteps + 1);
  for (int i = -kSteps; i <= kSteps; ++i) {
    const double share = std::abs(i) / static_cast<double>(kSteps);
    const double value = i == 0 ? 0 : std::copysign(largest * std::pow(10.0, kDecades * (share - 1)), i);
    panel.rect(x + (i + kSteps) * step, y, step + 0.5, 9, cell_color(style, value, largest));
  }
  panel.text(x - 6, y - 4, style.text_dim, number(-largest), render::Face::Regular, render::Align::Right);
  panel.text(x + width + 6, y - 4, style.text_dim, number(largest) + " /kg, log");
}

std::string summary(const SystemRecord& record, int nonzeros) {
  const int n = record.system.size();
  char text[200];
  std::snprintf(text, sizeof text, "%d x %d, %d nonzeros; %s at %.2f s", n, n, nonzeros,
                record.impact ? "impact" : "forces", record.time);
  return text;
}

bool has_row(const SystemRecord& record, int row) {
  return row >= 0 && row < record.system.size();
}

// The entry of W between two rows.
double entry(const SystemRecord& record, int row, int column) {
  double value = 0;
  const Row& i = record.system.rows[static_cast<std::size_t>(row)];
  const Row& j = record.system.rows[static_cast<std::size_t>(column)];
  for (const int body : {i.a, i.b}) {
    if (body < 0 || (j.a != body && j.b != body)) continue;
    const std::array<double, 3>& Ji = i.a == body ? i.Ja : i.Jb;
    const std::array<double, 3>& Jj = j.a == body ? j.Ja : j.Jb;
    std::array<double, 3> velocity{};
    push(record.system.bodies[static_cast<std::size_t>(body)], Jj, 1, velocity);
    value += along(Ji, velocity);
  }
  if (row == column && !record.system.compliance.empty())
    value += record.system.compliance[static_cast<std::size_t>(row)];
  return value;
}

std::string row_text(const SystemRecord& record, int row) {
  const auto at = static_cast<std::size_t>(row);
  return at < record.row_names.size() ? record.row_names[at] : "row " + std::to_string(row + 1);
}

std::string selection_text(const SystemRecord& record, const Selection& selection) {
  if (!has_row(record, selection.row)) return "";
  const std::string row = std::to_string(selection.row + 1);
  if (!has_row(record, selection.column))
    return "row and column " + row + ": " + row_text(record, selection.row);
  const double value = entry(record, selection.row, selection.column);
  const std::string cell = "W(" + row + ", " + std::to_string(selection.column + 1) + ") = " + number(value);
  return cell + ": " + row_text(record, selection.row) + " and " + row_text(record, selection.column);
}

// A bright frame around the selected row and column.
void draw_selection(const Map& map, int rows, const Selection& selection) {
  const double side = map.cell * map.grid.size;
  const double size = std::max(map.cell, 3.0);
  const auto place = [&](int row) {
    return map.cell * static_cast<double>(static_cast<long long>(row) * map.grid.size / rows);
  };
  const double row = place(selection.row);
  const double column = place(selection.column >= 0 ? selection.column : selection.row);
  const double line = 2;
  map.panel.frame(map.x - 1, map.y + row - 1, side + 1, size + 1, map.style.accent, line);
  map.panel.frame(map.x + column - 1, map.y - 1, size + 1, side + 1, map.style.accent, line);
}

// The mouse over a cell selects it until it leaves; a click keeps it, or drops what was kept.
void follow_mouse(const Map& map, int rows, Selection& selection) {
  double x = 0, y = 0;
  const double side = map.cell * map.grid.size;
  const bool inside =
      map.panel.hovered(x, y) && x >= map.x && y >= map.y && x < map.x + side && y < map.y + side;
  if (!inside) {
    if (selection.hovering) selection.row = selection.column = -1;
    selection.hovering = false;
    return;
  }
  const auto index = [&](double at) {
    return std::min(rows - 1, static_cast<int>(at / side * static_cast<double>(rows)));
  };
  if (map.panel.clicked())
    selection.hovering = !selection.hovering;
  else if (selection.row < 0)
    selection.hovering = true;
  if (!selection.hovering && !map.panel.clicked()) return;
  selection.row = index(y - map.y);
  selection.column = index(x - map.x);
}

}  // namespace

void show_matrix(const PanelContext& context) {
  const SystemRecord* record = context.scene.history.system();
  const render::Style& style = context.scene.style;
  std::string title = "Matrix W and impulses \xCE\xBB";
  if (!record || record->system.size() == 0) {
    const Panel panel(context, (title + "###matrix").c_str(), 24);
    panel.text(0, 0, style.text_dim, "nothing touches yet");
    return;
  }
  const int n = record->system.size();
  // Sizes before the panel: its height follows from them.
  const bool few = n <= kVectorRows;
  const CellGrid grid = delassus_cells(record->system, static_cast<int>(kLargestMapPx / 2));
  double name_px = kLeastNamePx;
  for (const std::string& name : record->row_names)
    name_px = std::max(name_px, render::text_width(name, kLinePx * render::kSheetEm) + 8);
  name_px = std::min(name_px, kMostNamePx);
  // The vectors stand beside the matrix only where its rows are as high as a line of text.
  const double beside = std::min(kPanelWidthPx - name_px - 3 * kVectorPx - 12, kLargestMapPx);
  const bool vectors = few && beside / n >= kTextCellPx;
  const double room = vectors ? beside : std::min({kLargestMapPx, kPlainCellPx * n, kPanelWidthPx - name_px});
  const double cell = std::min(kLargestCellPx, room / grid.size);
  const bool names = !record->row_names.empty() && cell >= kTextCellPx - 2;
  // The number that the islands overlay and the inspector show. Those of an earlier step may be others.
  const bool current =
      !record->impact && record->time > context.scene.demo.time() - 1.5 * context.scene.demo.dt();
  if (current && record->island >= 0) title += ", island " + std::to_string(record->island + 1);
  const Panel panel(context, (title + "###matrix").c_str(), kHeadPx + cell * grid.size + kFootPx);
  panel.small(panel.width(), 9 - kPanelTitlePx, style.text_dim, record->method, render::Align::Right);
  const Map map{panel,   style, grid, names ? name_px : 0.5 * (panel.width() - cell * grid.size),
                kHeadPx, cell};

  Selection& selection = context.scene.selection;
  follow_mouse(map, n, selection);
  panel.fitted(0, 0, panel.width(), style.text_dim, summary(*record, grid.nonzeros));
  panel.fitted(0, kLinePx + 1, panel.width(), style.accent, selection_text(*record, selection));
  draw_cells(map);
  if (cell >= kNumberCellPx) draw_numbers(map);
  for (std::size_t i = 0; names && i < record->row_names.size(); ++i)
    panel.squeezed(0, map.y + (static_cast<double>(i) + 0.5) * cell - 0.5 * kLinePx, name_px - 4, style.text,
                   record->row_names[i]);
  if (vectors) draw_vectors(map, *record);
  if (has_row(*record, selection.row)) draw_selection(map, n, selection);
  draw_scale(panel, style, grid.largest);
}

void draw_matrix_selection(const OverlayContext& context, render::DrawList& list) {
  const SystemRecord* record = context.history.system();
  const Selection& selection = context.selection;
  if (!record || !has_row(*record, selection.row) || record->anchors.empty()) return;
  const render::Style& style = context.style;
  render::DrawLayer& layer = list[render::Layer::Labels];
  const auto ring = [&](Vec2 at, const std::string& text) {
    layer.markers.push_back({.at = to_point(at),
                             .fill = render::faded(style.accent, 0.45),
                             .outline = style.accent,
                             .radius_px = 2.6f * style.contact_px});
    layer.labels.push_back({.at = to_point(at),
                            .text = text,
                            .color = style.accent,
                            .halo = style.halo,
                            .size_px = style.text_px,
                            .anchor = render::Anchor::Above,
                            .offset_px = 12});
  };
  const auto join = [&](Vec2 from, Vec2 to, float dash) {
    layer.lines.push_back({.from = to_point(from),
                           .to = to_point(to),
                           .color = style.accent,
                           .width_px = 2.5f,
                           .dash_px = dash});
  };
  const RowAnchor& first = record->anchors[static_cast<std::size_t>(selection.row)];
  const Vec2 from = anchor_point(context.demo, first);
  if (!has_row(*record, selection.column) || selection.column == selection.row) {
    ring(from, std::to_string(selection.row + 1));
    return;
  }
  // An entry of W is not zero because of the bodies that both rows act on: the line goes through them.
  const RowAnchor& second = record->anchors[static_cast<std::size_t>(selection.column)];
  const Vec2 to = anchor_point(context.demo, second);
  bool shared = false;
  for (const BodyId body : {first.a, first.b}) {
    if (!body || (body != second.a && body != second.b) || !context.world.alive(body)) continue;
    shared = true;
    const Vec2 centre = context.demo.shown(body.index).position;
    join(from, centre, 0);
    join(centre, to, 0);
  }
  if (!shared) join(from, to, 6);
  ring(from, std::to_string(selection.row + 1));
  if (length(to - from) * context.camera.pixels_per_metre() > 4)
    ring(to, std::to_string(selection.column + 1));
}

bool select_contact_at(const Demo& demo, const History& history, Vec2 point, double reach,
                       Selection& selection) {
  const SystemRecord* record = history.system();
  if (!record) return false;
  int best = -1;
  for (std::size_t i = 0; i < record->anchors.size(); ++i) {
    if (record->system.rows[i].kind != RowKind::Normal) continue;
    const double distance = length(anchor_point(demo, record->anchors[i]) - point);
    if (distance > reach) continue;
    reach = distance;
    best = static_cast<int>(i);
  }
  if (best < 0) return false;
  selection.row = best;
  selection.column = -1;
  selection.hovering = false;
  return true;
}

}  // namespace skerry::sandbox
