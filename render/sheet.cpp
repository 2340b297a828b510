// SPDX-License-Identifier: MIT
#include "render/sheet.h"

#include <imgui.h>
#include <stdexcept>

#include "render/ui_host.h"

namespace skerry::render {
namespace {

ImU32 pack(Color c) {
  return IM_COL32(c.r, c.g, c.b, c.a);
}

ImFont* font_of(const UiHost& ui, Face face) {
  switch (face) {
    case Face::Bold:
      return ui.bold();
    case Face::Title:
      return ui.title();
    case Face::Mono:
      return ui.mono();
    default:
      return ui.regular();
  }
}

}  // namespace

void Sheet::clear() {
  marks_.clear();
  points_.clear();
  text_.clear();
}

Mark& Sheet::add(MarkKind kind, const Pixel* points, std::size_t count, Color color, float width) {
  Mark mark;
  mark.kind = kind;
  mark.color = color;
  mark.width = width;
  mark.first = static_cast<std::uint32_t>(points_.size());
  mark.count = static_cast<std::uint32_t>(count);
  points_.insert(points_.end(), points, points + count);
  return marks_.emplace_back(mark);
}

void Sheet::rect(Pixel low, Pixel high, Color fill, float rounding) {
  const Pixel corners[] = {low, high};
  add(MarkKind::Rect, corners, 2, fill, 0).rounding = rounding;
}

void Sheet::frame(Pixel low, Pixel high, Color color, float width, float rounding) {
  const Pixel corners[] = {low, high};
  add(MarkKind::Rect, corners, 2, color, width).rounding = rounding;
}

void Sheet::line(Pixel from, Pixel to, Color color, float width) {
  const Pixel ends[] = {from, to};
  add(MarkKind::Stroke, ends, 2, color, width);
}

void Sheet::polyline(const Pixel* points, std::size_t count, Color color, float width) {
  if (count > 1) add(MarkKind::Stroke, points, count, color, width);
}

void Sheet::fill(const Pixel* points, std::size_t count, Color color) {
  if (count < 3) throw std::invalid_argument("sheet: a polygon needs 3 points, got " + std::to_string(count));
  add(MarkKind::Fill, points, count, color, 0);
}

void Sheet::text(Pixel at, std::string_view words, Color color, float line_px, Face face, Align align) {
  Mark& mark = add(MarkKind::Text, &at, 1, color, line_px);
  mark.face = face;
  mark.align = align;
  mark.begin = static_cast<std::uint32_t>(text_.size());
  mark.length = static_cast<std::uint32_t>(words.size());
  text_ += words;
}

void draw_sheet(const Sheet& sheet, std::size_t first, std::size_t last, const UiHost& ui, ImDrawList& out) {
  for (std::size_t i = first; i < last; ++i) {
    const Mark& mark = sheet.marks()[i];
    const Pixel* p = sheet.points(mark);
    switch (mark.kind) {
      case MarkKind::Rect:
        if (mark.width > 0)
          out.AddRect({p[0].x, p[0].y}, {p[1].x, p[1].y}, pack(mark.color), mark.rounding, 0, mark.width);
        else
          out.AddRectFilled({p[0].x, p[0].y}, {p[1].x, p[1].y}, pack(mark.color), mark.rounding);
        break;
      case MarkKind::Fill:
        for (std::uint32_t k = 0; k < mark.count; ++k) out.PathLineTo({p[k].x, p[k].y});
        out.PathFillConvex(pack(mark.color));
        break;
      case MarkKind::Stroke:
        for (std::uint32_t k = 0; k < mark.count; ++k) out.PathLineTo({p[k].x, p[k].y});
        out.PathStroke(pack(mark.color), 0, mark.width);
        break;
      case MarkKind::Text: {
        ImFont* font = font_of(ui, mark.face);
        const std::string_view words = sheet.words(mark);
        const char* begin = words.data();
        const char* end = begin + words.size();
        ImVec2 at(p[0].x, p[0].y);
        if (mark.align != Align::Left) {
          const float width = font->CalcTextSizeA(mark.width, 1e6f, 0, begin, end).x;
          at.x -= mark.align == Align::Right ? width : 0.5f * width;
        }
        out.AddText(font, mark.width, at, pack(mark.color), begin, end);
        break;
      }
    }
  }
}

}  // namespace skerry::render
