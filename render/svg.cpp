// SPDX-License-Identifier: MIT
#include "render/svg.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "render/glyphs.h"
#include "render/shape_batch.h"
#include "render/style.h"
#include "render/utf8.h"

namespace skerry::render {
namespace {

// Numbers are rounded to one over so many: lengths [px], and the entries of a turn, which long shapes
// multiply.
constexpr double kSteps = 1e3, kTurnSteps = 1e8;

/// Appends elements; numbers are rounded and never depend on the locale.
class Writer {
 public:
  std::string text;

  Writer& raw(std::string_view piece) {
    text += piece;
    return *this;
  }
  Writer& number(double value, double steps = kSteps) {
    const double rounded = std::round(value * steps) / steps + 0.0;  // no "-0"
    char digits[32];
    const bool tiny = std::abs(rounded) < 1e-3;  // and not written with an exponent
    const auto end =
        tiny ? std::to_chars(digits, digits + sizeof digits, rounded, std::chars_format::fixed).ptr
             : std::to_chars(digits, digits + sizeof digits, rounded).ptr;
    text.append(digits, end);
    return *this;
  }
  Writer& pair(double x, double y, double steps = kSteps) {
    return number(x, steps).raw(" ").number(y, steps);
  }
  Writer& attribute(std::string_view name, double value) {
    return raw(" ").raw(name).raw("=\"").number(value).raw("\"");
  }
  Writer& color(std::string_view name, Color c) {
    static constexpr char kHex[] = "0123456789abcdef";
    raw(" ").raw(name).raw("=\"#");
    for (const int channel : {c.r, c.g, c.b}) text += {kHex[channel >> 4], kHex[channel & 15]};
    text += '"';
    if (c.a != 255) raw(" ").raw(name).raw("-opacity=\"").number(c.a / 255.0).raw("\"");
    return *this;
  }
  Writer& escaped(std::string_view plain) {
    for (const char c : valid_utf8(plain)) {
      switch (c) {
        case '&':
          raw("&amp;");
          break;
        case '<':
          raw("&lt;");
          break;
        case '>':
          raw("&gt;");
          break;
        case '"':
          raw("&quot;");
          break;
        default:
          // Control characters are not allowed in XML.
          text += static_cast<unsigned char>(c) < 32 ? ' ' : c;
      }
    }
    return *this;
  }
};

/// Strokes lie on both sides of a path and our outlines inside of the shape: paths go half a width further
/// in.
void write_paint(Writer& out, const ShapeInstance& shape, bool outlined) {
  out.color("fill", outlined || shape.outline <= 0 ? shape.fill : shape.line);
  if (outlined) out.color("stroke", shape.line).attribute("stroke-width", shape.outline);
}

void write_frame(Writer& out, const ShapeInstance& s) {
  out.raw(" transform=\"matrix(")
      .pair(s.axis[0], s.axis[1], kTurnSteps)
      .raw(" ")
      .pair(-s.axis[1], s.axis[0], kTurnSteps)
      .raw(" ");
  out.pair(s.centre[0], s.centre[1]).raw(")\"/>\n");
}

void write_disc(Writer& out, const ShapeInstance& s, double radius) {
  const bool outlined = s.outline > 0 && radius > s.outline;
  out.raw("<circle").attribute("cx", s.centre[0]).attribute("cy", s.centre[1]);
  out.attribute("r", outlined ? radius - 0.5 * s.outline : radius);
  write_paint(out, s, outlined);
  out.raw("/>\n");
}

void write_box(Writer& out, const ShapeInstance& s) {
  if (s.half[0] == 0 && s.half[1] == 0) {
    write_disc(out, s, s.radius);
    return;
  }
  const double radius = s.radius;
  const bool outlined = s.outline > 0 && std::min(s.half[0], s.half[1]) + radius > s.outline;
  const double inset = outlined ? 0.5 * s.outline : 0;
  const double hx = s.half[0] + radius - inset, hy = s.half[1] + radius - inset;
  out.raw("<rect")
      .attribute("x", -hx)
      .attribute("y", -hy)
      .attribute("width", 2 * hx)
      .attribute("height", 2 * hy);
  if (radius > inset) out.attribute("rx", radius - inset);
  write_paint(out, s, outlined);
  write_frame(out, s);
}

void write_spoke(Writer& out, const ShapeInstance& s) {
  write_disc(out, s, s.radius);
  const double reach = s.radius - s.outline;
  out.raw("<path d=\"M")
      .pair(s.centre[0], s.centre[1])
      .raw("l")
      .pair(reach * s.half[0], reach * s.half[1])
      .raw("\"");
  out.color("stroke", s.line).attribute("stroke-width", s.outline).raw(" stroke-linecap=\"round\"/>\n");
}

/// Edge of a polygon: where it begins and its outer normal.
struct Edge {
  Point at, normal;
};

/// Corners and normals from what the shaders get (see ShapeBatches::corners).
std::vector<Edge> edges_of(const ShapeInstance& s, Program program, const std::vector<float>& corners) {
  std::vector<Edge> edges;
  for (std::uint32_t i = s.first; i < s.first + s.count; ++i) {
    const float* c = &corners[4 * static_cast<std::size_t>(i)];
    if (program != Program::Polygon) {
      edges.push_back({{c[0] * static_cast<double>(c[2]), c[1] * static_cast<double>(c[2])}, {c[0], c[1]}});
      continue;
    }
    const double length = std::hypot(c[2], c[3]);
    if (length > 0) edges.push_back({{c[0], c[1]}, {c[3] / length, -c[2] / length}});
  }
  return edges;
}

/// Where two edges meet after both moved outwards by `grow`.
Point meet(const Edge& a, const Edge& b, double grow) {
  const double ca = a.normal.x * a.at.x + a.normal.y * a.at.y + grow;
  const double cb = b.normal.x * b.at.x + b.normal.y * b.at.y + grow;
  const double det = a.normal.x * b.normal.y - a.normal.y * b.normal.x;
  if (std::abs(det) < 1e-9) return {b.at.x + grow * b.normal.x, b.at.y + grow * b.normal.y};
  return {(ca * b.normal.y - cb * a.normal.y) / det, (a.normal.x * cb - b.normal.x * ca) / det};
}

void write_polygon(Writer& out, const ShapeInstance& s, Program program, const std::vector<float>& corners) {
  const std::vector<Edge> edges = edges_of(s, program, corners);
  const std::size_t n = edges.size();
  if (n < 3) return;
  const bool outlined = s.outline > 0 && std::min(s.half[0], s.half[1]) + s.radius > s.outline;
  const double grow = s.radius - (outlined ? 0.5 * s.outline : 0.0);
  out.raw("<path d=\"");
  for (std::size_t i = 0; i < n; ++i) {
    const Edge &before = edges[(i + n - 1) % n], &edge = edges[i];
    if (grow <= 0) {
      const Point corner = meet(before, edge, grow);
      out.raw(i == 0 ? "M" : "L").pair(corner.x, corner.y);
      continue;
    }
    // Round the corner from the normal of one edge to that of the next.
    const Point corner = meet(before, edge, 0);
    out.raw(i == 0 ? "M" : "L").pair(corner.x + grow * before.normal.x, corner.y + grow * before.normal.y);
    out.raw("A")
        .pair(grow, grow)
        .raw(" 0 0 1 ")
        .pair(corner.x + grow * edge.normal.x, corner.y + grow * edge.normal.y);
  }
  out.raw("Z\"");
  write_paint(out, s, outlined);
  write_frame(out, s);
}

void write_arrow(Writer& out, const ShapeInstance& s) {
  const double tip = s.half[0], neck = tip - s.outline, wide = s.half[1], thin = s.radius;
  out.raw("<path d=\"");
  if (neck > -tip + 0.01) {
    out.raw("M")
        .pair(-tip, -thin)
        .raw("L")
        .pair(neck, -thin)
        .raw("L")
        .pair(neck, -wide)
        .raw("L")
        .pair(tip, 0);
    out.raw("L").pair(neck, wide).raw("L").pair(neck, thin).raw("L").pair(-tip, thin);
  } else {
    out.raw("M").pair(neck, -wide).raw("L").pair(tip, 0).raw("L").pair(neck, wide);
  }
  out.raw("Z\"").color("fill", s.fill);
  write_frame(out, s);
}

void write_labels(Writer& out, const DrawLayer& layer, const Camera& camera, const GlyphAtlas& atlas) {
  const double scale = ui_scale(camera.height_px);
  for (const Label& label : layer.labels) {
    const Point at = camera.to_pixels(label.at);
    const double size = label.size_px * scale, gap = label.offset_px * scale, cap = atlas.cap_height() * size;
    if (!std::isfinite(at.x + at.y) || std::abs(at.x) > 1e6 || std::abs(at.y) > 1e6 || !(size > 0)) continue;
    const auto rows = static_cast<double>(std::count(label.text.begin(), label.text.end(), '\n'));
    const double block = cap + rows * kLineSpacing * size;
    double y = at.y - 0.5 * block + cap, x = at.x;
    const char* anchor = "middle";
    if (label.anchor == Anchor::Above) y = at.y - gap - block + cap;
    if (label.anchor == Anchor::Below) y = at.y + gap + cap;
    if (label.anchor == Anchor::Left) {
      x -= gap;
      anchor = "end";
    }
    if (label.anchor == Anchor::Right) {
      x += gap;
      anchor = "start";
    }
    for (std::string_view rest = label.text;; y += kLineSpacing * size) {
      const std::size_t end = rest.find('\n');
      const auto write = [&](bool halo) {
        out.raw("<text").attribute("x", x).attribute("y", y).attribute("font-size", size);
        out.raw(" text-anchor=\"").raw(anchor).raw("\"").color("fill", halo ? label.halo : label.color);
        if (halo)
          out.color("stroke", label.halo)
              .attribute("stroke-width", 4.4 * scale)
              .raw(" stroke-linejoin=\"round\"");
        out.raw(">").escaped(rest.substr(0, end)).raw("</text>\n");
      };
      if (label.halo.a > 0) write(true);
      write(false);
      if (end == std::string_view::npos) break;
      rest.remove_prefix(end + 1);
    }
  }
}

void write_mark(Writer& out, const Sheet& sheet, const Mark& mark) {
  const Pixel* p = sheet.points(mark);
  const auto path = [&](bool closed) {
    for (std::uint32_t i = 0; i < mark.count; ++i)
      out.raw(i == 0 ? "M" : "L").pair(static_cast<double>(p[i].x), static_cast<double>(p[i].y));
    out.raw(closed ? "Z\"" : "\"");
  };
  switch (mark.kind) {
    case MarkKind::Rect: {
      const double inset = 0.5 * static_cast<double>(mark.width);
      out.raw("<rect").attribute("x", static_cast<double>(p[0].x) + inset);
      out.attribute("y", static_cast<double>(p[0].y) + inset);
      out.attribute("width", static_cast<double>(p[1].x - p[0].x) - 2 * inset);
      out.attribute("height", static_cast<double>(p[1].y - p[0].y) - 2 * inset);
      if (mark.rounding > 0) out.attribute("rx", static_cast<double>(mark.rounding));
      if (mark.width > 0)
        out.raw(" fill=\"none\"").color("stroke", mark.color).attribute("stroke-width", 2 * inset);
      else
        out.color("fill", mark.color);
      out.raw("/>\n");
      return;
    }
    case MarkKind::Fill:
      out.raw("<path d=\"");
      path(true);
      out.color("fill", mark.color).raw("/>\n");
      return;
    case MarkKind::Stroke:
      out.raw("<path d=\"");
      path(false);
      out.raw(" fill=\"none\" stroke-linejoin=\"round\"").color("stroke", mark.color);
      out.attribute("stroke-width", static_cast<double>(mark.width)).raw("/>\n");
      return;
    case MarkKind::Text:
      const double line = static_cast<double>(mark.width);
      out.raw("<text").attribute("x", static_cast<double>(p[0].x));
      out.attribute("y", static_cast<double>(p[0].y) + kSheetAscent * line);
      out.attribute("font-size", kSheetEm * line);
      if (mark.face == Face::Bold || mark.face == Face::Title) out.raw(" font-weight=\"bold\"");
      if (mark.face == Face::Mono) out.raw(" font-family=\"DejaVu Sans Mono, monospace\"");
      if (mark.align == Align::Right) out.raw(" text-anchor=\"end\"");
      if (mark.align == Align::Centre) out.raw(" text-anchor=\"middle\"");
      out.color("fill", mark.color).raw(">").escaped(sheet.words(mark)).raw("</text>\n");
  }
}

void begin_svg(Writer& out, int width, int height, Color background, const std::string& title) {
  out.raw("<svg xmlns=\"http://www.w3.org/2000/svg\"").attribute("width", width);
  out.attribute("height", height).raw(" viewBox=\"0 0 ").pair(width, height);
  out.raw("\" font-family=\"DejaVu Sans, Verdana, sans-serif\" xml:space=\"preserve\">\n");
  if (!title.empty()) out.raw("<title>").escaped(title).raw("</title>\n");
  out.raw("<rect width=\"100%\" height=\"100%\"").color("fill", background).raw("/>\n");
}

void write_sheet(Writer& out, const Sheet& sheet) {
  for (const Mark& mark : sheet.marks()) write_mark(out, sheet, mark);
}

}  // namespace

std::string to_svg(const DrawList& list, const Camera& camera, const std::string& title,
                   const Sheet* panels) {
  camera.validate();
  Writer out;
  begin_svg(out, camera.width_px, camera.height_px, list.background, title);
  GlyphAtlas atlas;
  ShapeBatches batches;
  for (const DrawLayer& layer : list.layers) {
    // The instances of the renderer, cut to the picture; its labels are pictures, ours are text.
    DrawList single;
    single.layers[0] = layer;
    single.layers[0].labels.clear();
    batches.build(single, camera, 1, atlas);
    for (const Batch& batch : batches.batches) {
      for (std::uint32_t i = batch.first; i < batch.first + batch.count; ++i) {
        const ShapeInstance& shape = batches.shapes[i];
        if (batch.program == Program::Spoke) {
          write_spoke(out, shape);
        } else if (batch.program == Program::Arrow) {
          write_arrow(out, shape);
        } else if (shape.count == 0) {
          write_box(out, shape);
        } else {
          write_polygon(out, shape, batch.program, batches.corners);
        }
      }
    }
    write_labels(out, layer, camera, atlas);
  }
  if (panels) write_sheet(out, *panels);
  out.raw("</svg>\n");
  return std::move(out.text);
}

std::string to_svg(const Sheet& sheet, int width, int height, Color background, const std::string& title) {
  Writer out;
  begin_svg(out, width, height, background, title);
  write_sheet(out, sheet);
  out.raw("</svg>\n");
  return std::move(out.text);
}

}  // namespace skerry::render
