// SPDX-License-Identifier: MIT
//
// The factor of W under the natural and a fill-reducing order, side by side: entries of W and, in another
// colour, the fill-in; size, nonzeros, fill ratio, condition estimate.
#include <algorithm>
#include <cstdio>
#include <vector>

#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"

namespace skerry::sandbox {
namespace {

constexpr double kMapPx = 182;
constexpr double kTopPx = 2 * kLinePx + 8;
static_assert(kTopPx + kMapPx + 2 * kLinePx + 20 <= kFactorPx);

/// Lower triangle in eliminated numbering: 0 empty, 1 an entry of W, 2 fill-in; in blocks where n is large.
struct FillMap {
  int cells = 0;
  int nonzeros = 0;  ///< of L, with the diagonal
  std::vector<char> kind;
};

FillMap fill_map(const FactorPattern& pattern, const IslandSystem& system) {
  const int n = system.size();
  FillMap map;
  map.cells = std::min(n, static_cast<int>(kMapPx / 1.3));
  map.kind.assign(static_cast<std::size_t>(map.cells) * static_cast<std::size_t>(map.cells), 0);
  map.nonzeros = static_cast<int>(pattern.row.size()) + n;
  const auto cell = [&](int i, int j) -> char& {
    const auto block = [&](int k) {
      return static_cast<std::size_t>(static_cast<long long>(k) * map.cells / n);
    };
    return map.kind[block(i) * static_cast<std::size_t>(map.cells) + block(j)];
  };
  const auto touches = [&](int i, int j) {
    const Row& a = system.rows[static_cast<std::size_t>(i)];
    const Row& b = system.rows[static_cast<std::size_t>(j)];
    return (a.a >= 0 && (a.a == b.a || a.a == b.b)) || (a.b >= 0 && (a.b == b.a || a.b == b.b));
  };
  for (std::size_t k = 0; k < pattern.row.size(); ++k) {
    const int i = pattern.row[k], j = pattern.column[k];
    const bool original =
        touches(pattern.order[static_cast<std::size_t>(i)], pattern.order[static_cast<std::size_t>(j)]);
    char& kind = cell(i, j);
    kind = std::max<char>(kind, original ? 1 : 2);
  }
  for (int i = 0; i < n; ++i) cell(i, i) = std::max<char>(cell(i, i), 1);
  return map;
}

void draw_map(const Panel& panel, const render::Style& style, const FillMap& map, double x, double y) {
  const double cell = kMapPx / map.cells;
  const double gap = cell > 6 ? 1 : 0;
  for (int i = 0; i < map.cells; ++i) {
    for (int j = 0; j <= i; ++j) {
      const char kind = map.kind[static_cast<std::size_t>(i) * static_cast<std::size_t>(map.cells) +
                                 static_cast<std::size_t>(j)];
      if (kind == 0) continue;
      panel.rect(x + j * cell, y + i * cell, cell - gap, cell - gap,
                 kind == 1 ? style.normal : style.impulse);
    }
  }
  panel.frame(x - 1, y - 1, kMapPx + 2, kMapPx + 2, style.panel_border);
}

}  // namespace

void show_factor(const PanelContext& context) {
  const char* title = "Factor L of W = L D L'";
  const render::Style& style = context.scene.style;
  const SystemRecord* record = context.scene.history.system();
  const int n = record ? record->system.size() : 0;
  if (n == 0 || n > kMostFactoredRows) {
    const Panel panel(context, title, 24);
    panel.text(0, 0, style.text_dim,
               n == 0 ? "nothing touches yet"
                      : std::to_string(n) + " rows: more than " + std::to_string(kMostFactoredRows) +
                            " are not drawn");
    return;
  }
  const FactorViews& views = record->factors();
  const Panel panel(context, title, kTopPx + kMapPx + 2 * kLinePx + 20);
  char text[160];
  std::snprintf(text, sizeof text, "n = %d, condition about %.1e", n, views.natural.condition);
  panel.text(0, 0, style.text_dim, text);
  const double second = panel.width() - kMapPx;
  const auto show = [&](const FactorPattern& pattern, const char* name, double x) {
    const FillMap map = fill_map(pattern, record->system);
    panel.text(x, kLinePx + 2, style.text, name, render::Face::Bold);
    draw_map(panel, style, map, x, kTopPx);
    std::snprintf(text, sizeof text, "%d nonzeros, fill %.2f", map.nonzeros, pattern.fill);
    panel.text(x, kTopPx + kMapPx + 4, style.text, text);
  };
  show(views.natural, "natural order", 0);
  show(views.reduced, "minimum degree", second);
  const double y = kTopPx + kMapPx + kLinePx + 12;
  panel.rect(0, y + 3, 10, 10, style.normal);
  panel.small(15, y, style.text_dim, "entry of W");
  panel.rect(110, y + 3, 10, 10, style.impulse);
  panel.small(125, y, style.text_dim, "fill-in (fill: entries of L over those of W)");
}

}  // namespace skerry::sandbox
