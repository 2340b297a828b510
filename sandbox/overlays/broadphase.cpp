// SPDX-License-Identifier: MIT
//
// The structure of the broad phase over the scene: cells by level, tree boxes, axes with their intervals;
// and, as `compare`, all structures side by side on the boxes of this moment, with what they had to test.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <memory>

#include "render/gl_renderer.h"
#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"
#include "sandbox/scene_view.h"

namespace skerry::sandbox {
namespace {

constexpr std::size_t kMostIntervals = 400;  // per axis: more cannot be told apart
constexpr std::size_t kMostCells = 6000;
constexpr double kMostInk = 0.25;  // mean share of the structure's colours over the scene
constexpr double kEndless = 1e9;   // the box of a half-plane is larger [m]

bool endless(const Aabb& box) {
  return box.upper.x - box.lower.x > kEndless || box.upper.y - box.lower.y > kEndless;
}

struct Cell {
  Aabb box;
  int level, count;
};
struct ProjectionAxis {
  Vec2 origin, direction;
  std::vector<std::pair<double, double>> intervals;
};

/// Keeps what a structure shows of itself.
class Recorder final : public StructureVisitor {
 public:
  std::vector<Cell> cells;
  std::map<int, ProjectionAxis> axes;
  int levels = 0;
  std::size_t all_cells = 0;

  void cell(const Aabb& box, int level, int count) override {
    levels = std::max(levels, level + 1);
    if (++all_cells <= kMostCells) cells.push_back({box, level, count});
  }
  void axis(int index, Vec2 origin, Vec2 direction) override { axes[index] = {origin, direction, {}}; }
  void interval(int index, ProxyIndex, double lower, double upper) override {
    std::vector<std::pair<double, double>>& list = axes[index].intervals;
    if (list.size() < kMostIntervals) list.emplace_back(lower, upper);
  }
};

// Levels differ in hue; finer ones come first in the palette.
render::Color level_color(const render::Style& style, int level) {
  constexpr long kHues[] = {6, 1, 2, 4, 3, 0, 5, 7};
  return render::body_paint(style, kHues[level % 8]).outline;
}

void draw_box(render::DrawLayer& layer, const Aabb& box, render::Color fill, render::Color outline,
              float width) {
  const render::Point corners[] = {{box.lower.x, box.lower.y},
                                   {box.upper.x, box.lower.y},
                                   {box.upper.x, box.upper.y},
                                   {box.lower.x, box.upper.y}};
  layer.polygon(corners, 4, fill, outline, 0, width);
}

/// How much of its colour a cell has inside. @param most  boxes that the fullest one has
double fill_of(const Cell& cell, int most) {
  return endless(cell.box) ? 0 : 0.04 + 0.16 * cell.count / most;
}

/// What is to be left of the fills: where boxes lie in boxes, as those of a tree, they would hide the scene.
double thinned(const std::vector<Cell>& cells, int most) {
  double inked = 0;
  Aabb all{{kInfinity, kInfinity}, {-kInfinity, -kInfinity}};
  for (const Cell& cell : cells) {
    if (endless(cell.box)) continue;
    const Vec2 size = cell.box.upper - cell.box.lower;
    inked += size.x * size.y * fill_of(cell, most);
    all = united(all, cell.box);
  }
  const Vec2 size = all.upper - all.lower;
  return inked > 0 ? std::min(1.0, kMostInk * size.x * size.y / inked) : 1;
}

/// Intervals in lanes: each in the first lane whose last interval ended before it begins.
std::vector<int> lanes_of(const std::vector<std::pair<double, double>>& intervals) {
  std::vector<double> ends;
  std::vector<int> lanes;
  for (const auto& [lower, upper] : intervals) {
    std::size_t lane = 0;
    while (lane < ends.size() && ends[lane] > lower) ++lane;
    if (lane == ends.size()) ends.push_back(0);
    ends[lane] = upper;
    lanes.push_back(static_cast<int>(lane));
  }
  return lanes;
}

void draw_axis(const OverlayContext& context, const ProjectionAxis& axis, int index,
               render::DrawLayer& layer) {
  const render::Style& style = context.style;
  const render::Camera& camera = context.camera;
  const double pixel = render::ui_scale(camera.height_px) / camera.pixels_per_metre();
  const Vec2 d = axis.direction;
  // Beside the scene: through a point below the middle of the picture, on the lower side of the axis.
  Vec2 side = perp(d);
  if (side.y > 0) side = -side;
  const Vec2 centre{camera.centre.x, camera.centre.y};
  const Vec2 base = centre + 0.3 * camera.height * side;
  const double middle = dot(base - axis.origin, d);
  const auto at = [&](double along, double away) {
    return to_point(base + (along - middle) * d + away * side);
  };
  const double reach = camera.height + camera.width();
  const render::Color color = level_color(style, index);
  layer.lines.push_back(
      {.from = at(middle - reach, 0), .to = at(middle + reach, 0), .color = color, .width_px = 1.5f});
  std::vector<std::pair<double, double>> intervals = axis.intervals;
  std::sort(intervals.begin(), intervals.end());
  const std::vector<int> lanes = lanes_of(intervals);
  for (std::size_t i = 0; i < intervals.size(); ++i) {
    const double away = (5 + 5 * std::min(lanes[i], 11)) * pixel;
    layer.lines.push_back({.from = at(intervals[i].first, away),
                           .to = at(intervals[i].second, away),
                           .color = color,
                           .width_px = 3});
  }
}

const BroadPhaseEntry* entry_of(std::string_view name) {
  const auto rows = broad_phases();
  const auto row = std::find_if(rows.begin(), rows.end(), [&](const auto& r) { return r.name == name; });
  return row == rows.end() ? nullptr : &*row;
}

}  // namespace

void draw_broadphase(const OverlayContext& context, render::DrawList& list) {
  const render::Style& style = context.style;
  Recorder recorder;
  context.world.broad_phase().visit_structure(recorder);
  render::DrawLayer& layer = list[render::Layer::Structure];
  int most = 1;
  for (const Cell& cell : recorder.cells) most = std::max(most, cell.count);
  // Coarse cells below fine ones.
  std::stable_sort(recorder.cells.begin(), recorder.cells.end(),
                   [](const Cell& a, const Cell& b) { return a.level > b.level; });
  const double thin = thinned(recorder.cells, most);
  for (const Cell& cell : recorder.cells) {
    const render::Color color = level_color(style, cell.level);
    draw_box(layer, cell.box, render::faded(color, thin * fill_of(cell, most)), render::faded(color, 0.75),
             1.2f);
  }
  for (const auto& [index, axis] : recorder.axes) draw_axis(context, axis, index, layer);
  for (const ShapeRecord& shape : context.world.shapes()) {
    if (!shape.alive || !shape.in_broad_phase) continue;
    draw_box(layer, shape.box, {0, 0, 0, 0}, style.text_dim, 1.0f);
  }
  context.legend.swatch({{0, 0, 0, 0}, style.text_dim}, "bounding box");
  for (int level = 0; level < std::min(recorder.levels, 6); ++level) {
    const render::Color color = level_color(style, level);
    context.legend.swatch({render::faded(color, 0.2), color}, "level " + std::to_string(level));
  }
  if (!recorder.axes.empty())
    context.legend.swatch({level_color(style, 0), level_color(style, 0)}, "intervals on an axis");
}

void show_broadphase(const PanelContext& context) {
  const render::Style& style = context.scene.style;
  const BroadPhase& broad_phase = context.scene.world.broad_phase();
  const BroadPhaseStats stats = broad_phase.stats();
  const BroadPhaseChoice choice = broad_phase.choice();
  const std::string used(choice.name);
  // Why it was chosen, or what it is.
  std::string why;
  if (choice.reason != BroadPhaseReason::Named)
    why = reason_of(choice);
  else if (const BroadPhaseEntry* entry = entry_of(used))
    why = entry->summary;
  const bool fits = render::text_width(why, kLinePx * render::kSheetEm) < 0.98 * kPanelWidthPx;
  const Panel panel(context, "Broad phase", kBroadPhasePx - (fits ? kLinePx : 0));
  Recorder recorder;
  broad_phase.visit_structure(recorder);
  double y = 0;
  panel.fitted(0, y, panel.width(), style.text,
               broad_phase.name() == used ? used : std::string(broad_phase.name()) + " \xE2\x86\x92 " + used);
  y += kLinePx + 1;
  for (const std::string& line : panel.wrapped(why, panel.width(), fits ? 1 : 2)) {
    panel.text(0, y, style.text_dim, line);
    y += kLinePx;
  }
  y += 6;
  const std::pair<const char*, std::string> rows[] = {
      {"boxes", std::to_string(broad_phase.size())},
      {recorder.axes.empty() ? "cells or nodes in use" : "axes",
       std::to_string(recorder.axes.empty() ? recorder.all_cells : recorder.axes.size())},
      {"pairs found in this step", std::to_string(stats.pairs)},
      {"box tests", std::to_string(stats.box_tests)},
      {"of these no pair", std::to_string(stats.false_pairs)},
      {"memory", si(static_cast<double>(stats.bytes), "B")}};
  static_assert(3 * kLinePx + 7 + std::size(rows) * 18 <= kBroadPhasePx);
  for (const auto& [what, value] : rows) {
    panel.text(0, y, style.text_dim, what);
    panel.text(panel.width(), y, style.text, value, render::Face::Regular, render::Align::Right);
    y += 18;
  }
}

namespace {

/// A small map of the boxes and a structure.
struct Miniature {
  const Panel& panel;
  const render::Style& style;
  Aabb view;
  double x, y, width, height;

  double scale() const {
    return std::min(width / (view.upper.x - view.lower.x), height / (view.upper.y - view.lower.y));
  }
  double px(double world) const {
    return std::clamp(x + 0.5 * width + scale() * (world - 0.5 * (view.lower.x + view.upper.x)), x,
                      x + width);
  }
  double py(double world) const {
    return std::clamp(y + 0.5 * height - scale() * (world - 0.5 * (view.lower.y + view.upper.y)), y,
                      y + height);
  }
  void box(const Aabb& b, render::Color fill, render::Color line) const {
    const double left = px(b.lower.x), right = px(b.upper.x), top = py(b.upper.y), bottom = py(b.lower.y);
    if (right - left <= 0 || bottom - top <= 0) return;
    if (fill.a) panel.rect(left, top, right - left, bottom - top, fill);
    if (line.a) panel.frame(left, top, right - left, bottom - top, line, 1);
  }
};

// A structure with the world's boxes of this moment, made from nothing.
std::unique_ptr<BroadPhase> structure_of(const BroadPhaseEntry& entry, const World& world,
                                         std::vector<Pair>& pairs) {
  std::unique_ptr<BroadPhase> result = entry.make(world.config().broad_phase_options);
  for (std::size_t i = 0; i < world.shapes().size(); ++i) {
    const ShapeRecord& shape = world.shapes()[i];
    if (!shape.alive || !shape.in_broad_phase) continue;
    const bool moves = world.bodies().type[shape.body.index] != BodyType::Static;
    result->insert(static_cast<ProxyIndex>(i), shape.box, moves ? ProxyKind::Moving : ProxyKind::Fixed);
  }
  result->moved_pairs(pairs);
  return result;
}

void draw_axes(const Miniature& map, const Recorder& recorder) {
  // The axes cross in the middle of the map; the intervals lie on them.
  const Vec2 centre = 0.5 * (map.view.lower + map.view.upper);
  for (const auto& known : recorder.axes) {
    const auto& axis = known.second;
    const render::Color color = level_color(map.style, known.first);
    const double middle = dot(centre - axis.origin, axis.direction);
    const double reach = std::min(map.width, map.height) * 0.5 / map.scale();
    const auto at = [&](double along) { return centre + (along - middle) * axis.direction; };
    const auto line = [&](double from, double to, render::Color ink, double width) {
      const Vec2 a = at(std::clamp(from, middle - reach, middle + reach));
      const Vec2 b = at(std::clamp(to, middle - reach, middle + reach));
      map.panel.line(map.px(a.x), map.py(a.y), map.px(b.x), map.py(b.y), ink, width);
    };
    line(middle - reach, middle + reach, render::faded(color, 0.5), 1);
    for (const auto& [lower, upper] : axis.intervals) line(lower, upper, render::faded(color, 0.35), 4);
  }
}

}  // namespace

void show_compare(const PanelContext& context) {
  constexpr int kColumns = 2;
  constexpr double kGapPx = 12, kTextPx = 2 * kSmallLinePx + 3;
  const OverlayContext& scene = context.scene;
  const render::Style& style = scene.style;
  std::vector<const BroadPhaseEntry*> entries;
  for (const BroadPhaseEntry& entry : broad_phases())
    if (entry.name != "auto") entries.push_back(&entry);
  const int rows = (static_cast<int>(entries.size()) + kColumns - 1) / kColumns;
  const Panel panel(context, "Broad phases on the boxes of this moment", kComparePx);
  const double width = (panel.width() - kGapPx) / kColumns;
  const double height = kComparePx / rows - kTextPx - 8;

  // The part of the world that the boxes fill, at most what the picture shows.
  Aabb all{{HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL}};
  for (const ShapeRecord& shape : scene.world.shapes())
    if (shape.alive && shape.in_broad_phase && !endless(shape.box)) all = united(all, shape.box);
  const Vec2 centre{scene.camera.centre.x, scene.camera.centre.y};
  const Vec2 half{0.5 * scene.camera.width(), 0.5 * scene.camera.height};
  all.lower = {std::max(all.lower.x, centre.x - half.x), std::max(all.lower.y, centre.y - half.y)};
  all.upper = {std::min(all.upper.x, centre.x + half.x), std::min(all.upper.y, centre.y + half.y)};
  if (!(all.lower.x < all.upper.x && all.lower.y < all.upper.y)) {
    panel.text(0, 0, style.text_dim, "no boxes in the picture");
    return;
  }
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const std::unique_ptr<BroadPhase> broad_phase = structure_of(*entries[i], scene.world, pairs);
    const BroadPhaseStats stats = broad_phase->stats();
    Recorder recorder;
    broad_phase->visit_structure(recorder);
    const double x = static_cast<double>(i % kColumns) * (width + kGapPx);
    const double y = static_cast<double>(i / kColumns) * (height + kTextPx + 8);
    const Miniature map{panel, style, all, x, y + kTextPx, width, height};
    for (const ShapeRecord& shape : scene.world.shapes())
      if (shape.alive && shape.in_broad_phase)
        map.box(shape.box, render::faded(style.text_dim, endless(shape.box) ? 0.12 : 0.35), {0, 0, 0, 0});
    std::stable_sort(recorder.cells.begin(), recorder.cells.end(),
                     [](const Cell& a, const Cell& b) { return a.level > b.level; });
    for (const Cell& cell : recorder.cells)
      map.box(cell.box, {0, 0, 0, 0}, render::faded(level_color(style, cell.level), 0.8));
    draw_axes(map, recorder);
    panel.frame(x, y + kTextPx, width, height, style.panel_border);
    panel.small(x, y, style.text, std::string(entries[i]->name));
    char text[96];
    std::snprintf(text, sizeof text, "%llu tests, %llu false",
                  static_cast<unsigned long long>(stats.box_tests),
                  static_cast<unsigned long long>(stats.false_pairs));
    panel.small(x, y + kSmallLinePx, style.text_dim, text);
  }
}

}  // namespace skerry::sandbox
