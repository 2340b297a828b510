// SPDX-License-Identifier: MIT
#include "tests/sandbox/golden_plants.h"

#include <algorithm>
#include <cmath>
#include <imgui.h>
#include <imgui_internal.h>
#include <map>
#include <string>

namespace skerry::sandbox {
namespace {

using render::Color;
using render::DrawLayer;
using render::DrawList;
using render::Image;
using render::Layer;

// The item in the middle of a list: at the ends stand legends and things half outside.
template <class Item>
Item* middle(std::vector<Item>& items) {
  return items.empty() ? nullptr : &items[items.size() / 2];
}

template <class Item, class Change>
bool with(std::vector<Item>& items, Change&& change) {
  Item* item = middle(items);
  if (item) change(*item);
  return item != nullptr;
}

template <class Item>
bool drop(std::vector<Item>& items) {
  if (items.empty()) return false;
  items.erase(items.begin() + static_cast<std::ptrdiff_t>(items.size() / 2));
  return true;
}

// 12 of 255 towards the side where there is room.
void off_by_12(std::uint8_t& channel) {
  channel = static_cast<std::uint8_t>(channel < 128 ? channel + 12 : channel - 12);
}

// The half-plane of the ground is the largest polygon and leaves the picture; the others are bodies.
bool with_box(const Frame& frame, const std::function<void(render::Polygon&, render::Point*)>& change) {
  DrawLayer& layer = frame[Layer::Bodies];
  for (render::Polygon& polygon : layer.polygons) {
    render::Point* corners = &layer.points[polygon.first];
    if (std::hypot(corners[0].x - corners[2].x, corners[0].y - corners[2].y) > 1000 * frame.px) continue;
    change(polygon, corners);
    return true;
  }
  return false;
}

// Labels with a number in them.
render::Label* number_label(const Frame& frame) {
  for (DrawLayer& layer : frame.list.layers)
    for (render::Label& label : layer.labels)
      if (label.text.find_first_of("0123456789") != std::string::npos) return &label;
  return nullptr;
}

render::Label* any_label(const Frame& frame) {
  return middle(frame[Layer::Labels].labels);
}

// Panels are ImGui windows with a draw list of their own; the header is on the background.
std::vector<ImDrawList*> panels() {
  std::vector<ImDrawList*> lists;
  for (ImGuiWindow* window : ImGui::GetCurrentContext()->Windows)
    if (window->Active && !window->IsFallbackWindow && window->DrawList->VtxBuffer.Size > 8)
      lists.push_back(window->DrawList);
  return lists;
}

// A quad of a draw list: four vertices that six indices use.
struct Quad {
  ImDrawVert* corner[4];
  bool glyph;  // takes its shape from the font, not from the white pixel

  void hide() const {
    for (ImDrawVert* vertex : corner) vertex->col &= ~IM_COL32_A_MASK;
  }
};

std::vector<Quad> quads(ImDrawList* list) {
  std::vector<Quad> found;
  const ImVec2 white = ImGui::GetIO().Fonts->TexUvWhitePixel;
  for (int i = 0; i + 6 <= list->IdxBuffer.Size; i += 3) {
    const ImDrawIdx* index = &list->IdxBuffer[i];
    if (index[1] != index[0] + 1 || index[2] != index[0] + 2 || index[3] != index[0] ||
        index[4] != index[2] || index[5] != index[0] + 3)
      continue;
    Quad quad{{}, false};
    for (int k = 0; k < 4; ++k) quad.corner[k] = &list->VtxBuffer[index[0] + k];
    quad.glyph = quad.corner[0]->uv.x != white.x || quad.corner[0]->uv.y != white.y;
    found.push_back(quad);
    i += 3;
  }
  return found;
}

std::vector<Quad> glyphs(ImDrawList* list) {
  std::vector<Quad> all = quads(list);
  // Letters and digits; a full stop has fewer pixels than another driver may move.
  std::erase_if(
      all, [](const Quad& quad) { return !quad.glyph || quad.corner[2]->pos.y - quad.corner[0]->pos.y < 6; });
  return all;
}

// Small filled rectangles: the cells of the matrix.
std::vector<Quad> cells(ImDrawList* list) {
  std::vector<Quad> all = quads(list);
  std::erase_if(all, [](const Quad& quad) {
    const float width = quad.corner[2]->pos.x - quad.corner[0]->pos.x;
    const float height = quad.corner[2]->pos.y - quad.corner[0]->pos.y;
    return quad.glyph || width < 2 || width > 60 || std::abs(width - height) > 1;
  });
  return all;
}

// A glyph takes the shape of the next different one.
bool exchange_glyph(ImDrawList* list) {
  const std::vector<Quad> all = glyphs(list);
  for (std::size_t i = all.size() / 2; i + 1 < all.size(); ++i) {
    if (all[i].corner[0]->uv.x == all[i + 1].corner[0]->uv.x) continue;
    for (int k = 0; k < 4; ++k) all[i].corner[k]->uv = all[i + 1].corner[k]->uv;
    return true;
  }
  return false;
}

template <class Change>
bool in_panel(Change&& change) {
  for (ImDrawList* list : panels())
    if (change(list)) return true;
  return false;
}

void shift(ImDrawList* list, float dx, float dy) {
  for (ImDrawVert& vertex : list->VtxBuffer) {
    vertex.pos.x += dx;
    vertex.pos.y += dy;
  }
}

// Every pixel becomes the most frequent colour that is near it: edges without intermediate colours.
void without_antialiasing(Image& image) {
  std::map<std::uint32_t, int> counts;
  const auto key = [](Color c) { return static_cast<std::uint32_t>(c.r << 16 | c.g << 8 | c.b); };
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) ++counts[key(image.at(x, y))];
  std::vector<std::pair<int, std::uint32_t>> ranked;
  for (const auto& [color, count] : counts) ranked.emplace_back(count, color);
  std::sort(ranked.rbegin(), ranked.rend());
  ranked.resize(std::min<std::size_t>(ranked.size(), 12));
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Color c = image.at(x, y);
      Color best = c;
      int nearest = 1 << 30;
      for (const auto& [count, color] : ranked) {
        const Color flat{static_cast<std::uint8_t>(color >> 16), static_cast<std::uint8_t>(color >> 8),
                         static_cast<std::uint8_t>(color), 255};
        const int distance = std::abs(flat.r - c.r) + std::abs(flat.g - c.g) + std::abs(flat.b - c.b);
        if (distance < nearest) nearest = distance, best = flat;
      }
      image.set(x, y, best);
    }
  }
}

}  // namespace

std::vector<Plant> body_plants() {
  return {
      {"a disc moved by 0.1 px to the right",
       [](const Frame& f) {
         return with(f[Layer::Bodies].discs, [&](render::Disc& d) { d.centre.x += 0.1 * f.px; });
       }},
      {"a disc moved by 0.1 px upwards",
       [](const Frame& f) {
         return with(f[Layer::Bodies].discs, [&](render::Disc& d) { d.centre.y += 0.1 * f.px; });
       }},
      {"a disc grew by 0.1 px",
       [](const Frame& f) {
         return with(f[Layer::Bodies].discs, [&](render::Disc& d) { d.radius += 0.1 * f.px; });
       }},
      {"a disc turned by a degree",
       [](const Frame& f) {
         return with(f[Layer::Bodies].discs, [&](render::Disc& d) { d.angle += 0.0175; });
       }},
      {"a disc is missing", [](const Frame& f) { return drop(f[Layer::Bodies].discs); }},
      {"a disc's red is off by 12",
       [](const Frame& f) {
         return with(f[Layer::Bodies].discs, [](render::Disc& d) { off_by_12(d.fill.r); });
       }},
      {"a disc's green is off by 12",
       [](const Frame& f) {
         return with(f[Layer::Bodies].discs, [](render::Disc& d) { off_by_12(d.fill.g); });
       }},
      {"a disc's blue is off by 12",
       [](const Frame& f) {
         return with(f[Layer::Bodies].discs, [](render::Disc& d) { off_by_12(d.fill.b); });
       }},
      {"a disc's outline is off by 12",
       [](const Frame& f) {
         return with(f[Layer::Bodies].discs, [](render::Disc& d) { off_by_12(d.outline.g); });
       }},
      {"a disc's outline is thicker by 0.2 px",
       [](const Frame& f) {
         return with(f[Layer::Bodies].discs, [](render::Disc& d) { d.outline_px += 0.2f; });
       }},
      {"a disc has no outline",
       [](const Frame& f) {
         return with(f[Layer::Bodies].discs, [](render::Disc& d) { d.outline_px = 0; });
       }},
      {"a disc has no spoke",
       [](const Frame& f) {
         return with(f[Layer::Bodies].discs, [](render::Disc& d) { d.spoke = !d.spoke; });
       }},
      {"a box moved by 0.1 px",
       [](const Frame& f) {
         return with_box(f, [&](render::Polygon& p, render::Point* c) {
           for (std::uint32_t i = 0; i < p.count; ++i) c[i].x += 0.1 * f.px, c[i].y += 0.1 * f.px;
         });
       }},
      {"a corner moved by half a pixel",
       [](const Frame& f) {
         return with_box(f, [&](render::Polygon&, render::Point* c) { c[1].x += 0.5 * f.px; });
       }},
      {"a box grew a rounding of 0.2 px",
       [](const Frame& f) {
         return with_box(f, [&](render::Polygon& p, render::Point*) { p.rounding += 0.2 * f.px; });
       }},
      {"a box is missing",
       [](const Frame& f) {
         return with_box(f, [](render::Polygon& p, render::Point*) { p.fill.a = p.outline.a = 0; });
       }},
      {"a box's red is off by 12",
       [](const Frame& f) {
         return with_box(f, [](render::Polygon& p, render::Point*) { off_by_12(p.fill.r); });
       }},
      {"a box's blue is off by 12",
       [](const Frame& f) {
         return with_box(f, [](render::Polygon& p, render::Point*) { off_by_12(p.fill.b); });
       }},
      {"a box's outline is off by 12",
       [](const Frame& f) {
         return with_box(f, [](render::Polygon& p, render::Point*) { off_by_12(p.outline.g); });
       }},
      {"a box's outline is thicker by 0.2 px",
       [](const Frame& f) {
         return with_box(f, [](render::Polygon& p, render::Point*) { p.outline_px += 0.2f; });
       }},
      {"fill and outline are exchanged",
       [](const Frame& f) {
         return with_box(f, [](render::Polygon& p, render::Point*) { std::swap(p.fill, p.outline); });
       }},
      {"two discs have each other's colours",
       [](const Frame& f) {
         std::vector<render::Disc>& discs = f[Layer::Bodies].discs;
         if (discs.size() < 2 || discs.front().fill == discs.back().fill) return false;
         std::swap(discs.front().fill, discs.back().fill);
         return true;
       }},
      {"the background is off by 3",
       [](const Frame& f) {
         f.list.background.b = static_cast<std::uint8_t>(f.list.background.b < 128 ? f.list.background.b + 3
                                                                                   : f.list.background.b - 3);
         return true;
       }},
      {"a line of the grid is missing", [](const Frame& f) { return drop(f[Layer::Background].lines); }},
      {"the grid moved by a third of a pixel",
       [](const Frame& f) {
         for (render::Line& line : f[Layer::Background].lines) line.from.x += f.px / 3, line.to.x += f.px / 3;
         return !f[Layer::Background].lines.empty();
       }},
      {"the grid is off by 12",
       [](const Frame& f) {
         for (render::Line& line : f[Layer::Background].lines) off_by_12(line.color.r);
         return !f[Layer::Background].lines.empty();
       }},
  };
}

// Rods, ropes and pins of joints are lines and markers of the layer they were drawn on.
std::vector<Plant> joint_plants() {
  const auto lines = [](const Frame& f) -> std::vector<render::Line>& {
    return f[Layer::Structure].lines.empty() ? f[Layer::Bodies].lines : f[Layer::Structure].lines;
  };
  return {
      {"a rod is missing", [=](const Frame& f) { return drop(lines(f)); }},
      {"a rod's end moved by half a pixel",
       [=](const Frame& f) { return with(lines(f), [&](render::Line& l) { l.to.x += 0.5 * f.px; }); }},
      {"a rod is thinner by 0.3 px",
       [=](const Frame& f) { return with(lines(f), [](render::Line& l) { l.width_px -= 0.3f; }); }},
      {"a rod is off by 12",
       [=](const Frame& f) { return with(lines(f), [](render::Line& l) { off_by_12(l.color.r); }); }},
      {"a rod is dashed",
       [=](const Frame& f) { return with(lines(f), [](render::Line& l) { l.dash_px = 6; }); }},
  };
}

std::vector<Plant> contact_plants() {
  const auto arrows = [](const Frame& f) -> std::vector<render::Arrow>& { return f[Layer::Contacts].arrows; };
  const auto markers = [](const Frame& f) -> std::vector<render::Marker>& {
    return f[Layer::Contacts].markers;
  };
  return {
      {"an arrow is missing", [=](const Frame& f) { return drop(arrows(f)); }},
      {"an arrow is shorter by 1 px",
       [=](const Frame& f) {
         return with(arrows(f), [&](render::Arrow& a) {
           const double length = std::hypot(a.to.x - a.from.x, a.to.y - a.from.y);
           a.to.x -= (a.to.x - a.from.x) / length * f.px;
           a.to.y -= (a.to.y - a.from.y) / length * f.px;
         });
       }},
      {"an arrow points the other way",
       [=](const Frame& f) { return with(arrows(f), [](render::Arrow& a) { std::swap(a.from, a.to); }); }},
      {"an arrow moved by half a pixel",
       [=](const Frame& f) {
         return with(arrows(f), [&](render::Arrow& a) { a.from.y += 0.5 * f.px, a.to.y += 0.5 * f.px; });
       }},
      {"an arrow is thinner by 0.5 px",
       [=](const Frame& f) { return with(arrows(f), [](render::Arrow& a) { a.width_px -= 0.5f; }); }},
      {"an arrow has no head",
       [=](const Frame& f) { return with(arrows(f), [](render::Arrow& a) { a.head_px = 0; }); }},
      {"all arrows are off by 12",
       [=](const Frame& f) {
         for (render::Arrow& arrow : arrows(f)) off_by_12(arrow.color.r), off_by_12(arrow.color.b);
         return !arrows(f).empty();
       }},
      {"a contact point is missing", [=](const Frame& f) { return drop(markers(f)); }},
      {"a contact point is larger by 0.4 px",
       [=](const Frame& f) { return with(markers(f), [](render::Marker& m) { m.radius_px += 0.4f; }); }},
      {"a contact point moved by half a pixel",
       [=](const Frame& f) { return with(markers(f), [&](render::Marker& m) { m.at.x += 0.5 * f.px; }); }},
      {"a contact point has another colour",
       [=](const Frame& f) {
         return with(markers(f), [](render::Marker& m) { m.fill = {200, 60, 60, 255}; });
       }},
  };
}

std::vector<Plant> label_plants() {
  return {
      {"a digit of the legend changed",
       [](const Frame& f) {
         render::Label* label = number_label(f);
         if (!label) return false;
         char& digit = label->text[label->text.find_first_of("0123456789")];
         digit = digit == '8' ? '3' : '8';
         return true;
       }},
      {"the legend lost its unit",
       [](const Frame& f) {
         render::Label* label = number_label(f);
         if (!label) return false;
         label->text = label->text.substr(0, label->text.rfind(' '));
         return true;
       }},
      {"a label is missing", [](const Frame& f) { return drop(f[Layer::Labels].labels); }},
      {"a label shifted by 1 px to the right",
       [](const Frame& f) { return any_label(f) && (any_label(f)->at.x += f.px, true); }},
      {"a label shifted by 1 px downwards",
       [](const Frame& f) { return any_label(f) && (any_label(f)->at.y -= f.px, true); }},
      {"a label is larger by 1 px",
       [](const Frame& f) { return any_label(f) && (any_label(f)->size_px += 1, true); }},
      {"a label is in another colour",
       [](const Frame& f) {
         return any_label(f) && (any_label(f)->color = {120, 60, 60, 255}, true);
       }},
      {"two entries of the legend are swapped",
       [](const Frame& f) {
         std::vector<render::Label>& labels = f[Layer::Labels].labels;
         if (labels.size() < 2) return false;
         std::swap(labels[0].text, labels[1].text);
         return true;
       }},
      {"the legend's arrow is longer by 1 px",
       [](const Frame& f) {
         return with(f[Layer::Labels].arrows, [&](render::Arrow& a) { a.to.x += f.px; });
       }},
      {"the length bar is longer by 12 px",
       [](const Frame& f) {
         std::vector<render::Line>& lines = f[Layer::Labels].lines;
         for (render::Line& line : lines)
           if (line.from.y == line.to.y) return line.from.x -= 12 * f.px, true;
         return false;
       }},
      {"the length bar has no tick", [](const Frame& f) { return drop(f[Layer::Labels].lines); }},
      {"a swatch of the legend is off by 12",
       [](const Frame& f) {
         return with(f[Layer::Labels].polygons,
                     [](render::Polygon& p) { off_by_12(p.fill.r), off_by_12(p.fill.b); });
       }},
  };
}

std::vector<Plant> panel_plants() {
  return {
      {"a character of a panel is another one", [](const Frame&) { return in_panel(exchange_glyph); }},
      {"a character of a panel is missing",
       [](const Frame&) {
         return in_panel([](ImDrawList* list) {
           const std::vector<Quad> all = glyphs(list);
           if (all.empty()) return false;
           all[all.size() / 2].hide();
           return true;
         });
       }},
      {"a panel moved by 1 px",
       [](const Frame&) { return in_panel([](ImDrawList* list) { return shift(list, 1, 0), true; }); }},
      {"a panel is missing",
       [](const Frame&) {
         return in_panel([](ImDrawList* list) {
           for (ImDrawVert& vertex : list->VtxBuffer) vertex.col &= ~IM_COL32_A_MASK;
           return true;
         });
       }},
      {"the text of a panel is fainter",
       [](const Frame&) {
         return in_panel([](ImDrawList* list) {
           for (const Quad& quad : glyphs(list))
             for (ImDrawVert* vertex : quad.corner)
               vertex->col = (vertex->col & ~IM_COL32_A_MASK) | 235u << IM_COL32_A_SHIFT;
           return !glyphs(list).empty();
         });
       }},
      {"a row of the matrix is missing",
       [](const Frame&) {
         return in_panel([](ImDrawList* list) {
           std::map<float, std::vector<Quad>> rows;
           for (const Quad& cell : cells(list)) rows[cell.corner[0]->pos.y].push_back(cell);
           if (rows.size() < 3) return false;
           for (const Quad& cell : std::next(rows.begin(), 1)->second) cell.hide();
           return true;
         });
       }},
      {"a cell of the matrix is missing",
       [](const Frame&) {
         return in_panel([](ImDrawList* list) {
           const std::vector<Quad> all = cells(list);
           if (all.size() < 4) return false;
           all[0].hide();
           return true;
         });
       }},
      {"a cell of the matrix is off by 12",
       [](const Frame&) {
         return in_panel([](ImDrawList* list) {
           const std::vector<Quad> all = cells(list);
           if (all.size() < 4) return false;
           for (ImDrawVert* vertex : all[0].corner) vertex->col ^= 0x0c;
           return true;
         });
       }},
      {"the title moved by 1 px",
       [](const Frame&) {
         for (const Quad& quad : glyphs(ImGui::GetBackgroundDrawList()))
           for (ImDrawVert* vertex : quad.corner) vertex->pos.x += 1;
         return true;
       }},
      {"a character of the header is missing",
       [](const Frame&) {
         const std::vector<Quad> all = glyphs(ImGui::GetBackgroundDrawList());
         all[all.size() / 2].hide();
         return true;
       }},
      {"a character of the header is another one",
       [](const Frame&) { return exchange_glyph(ImGui::GetBackgroundDrawList()); }},
      {"the clock is missing its last digit",
       [](const Frame&) {
         // "t = 1.05 s" comes first in the list; without '=' and '.' its last digit is the fourth glyph.
         glyphs(ImGui::GetBackgroundDrawList())[3].hide();
         return true;
       }},
      {"the header has no veil",
       [](const Frame&) {
         for (const Quad& quad : quads(ImGui::GetBackgroundDrawList()))
           if (!quad.glyph) return quad.hide(), true;
         return false;
       }},
  };
}

std::vector<ImagePlant> image_plants() {
  return {
      {"edges are not antialiased", without_antialiasing},
      {"the picture moved by a pixel",
       [](Image& image) { std::rotate(image.rgba.begin(), image.rgba.end() - 4, image.rgba.end()); }},
      {"the picture stands on its head",
       [](Image& image) {
         for (int y = 0; y < image.height / 2; ++y)
           for (int x = 0; x < image.width; ++x) {
             const Color c = image.at(x, y);
             image.set(x, y, image.at(x, image.height - 1 - y));
             image.set(x, image.height - 1 - y, c);
           }
       }},
      {"red and blue are exchanged",
       [](Image& image) {
         for (std::size_t i = 0; i < image.rgba.size(); i += 4) std::swap(image.rgba[i], image.rgba[i + 2]);
       }},
      {"everything is darker by 3",
       [](Image& image) {
         for (std::size_t i = 0; i < image.rgba.size(); ++i)
           if (i % 4 != 3) image.rgba[i] = static_cast<std::uint8_t>(std::max(0, image.rgba[i] - 3));
       }},
      {"the last line is not drawn",
       [](Image& image) {
         for (int x = 0; x < image.width; ++x) image.set(x, image.height - 1, {0, 0, 0, 255});
       }},
      {"the picture is empty",
       [](Image& image) {
         const Color background = image.at(image.width / 2, image.height - 2);
         for (int y = 0; y < image.height; ++y)
           for (int x = 0; x < image.width; ++x) image.set(x, y, background);
       }},
  };
}

}  // namespace skerry::sandbox
