// SPDX-License-Identifier: MIT
#include "render/shape_batch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "render/style.h"

namespace skerry::render {
namespace {

// Beyond these sizes float pixels lose the edge, so shapes are cut to the picture in double first.
constexpr double kLargeExtent = 8192;
constexpr double kLargeRadius = 1e5;
// Floats beyond have no finite square, and the rasteriser no distances.
constexpr float kMost = 1e18f;
// Corners so near one another are one point.
constexpr double kNoLength = 1e-6;

bool finite(Point p) {
  return std::isfinite(p.x) && std::isfinite(p.y);
}
double dot(Point a, Point b) {
  return a.x * b.x + a.y * b.y;
}
Point minus(Point a, Point b) {
  return {a.x - b.x, a.y - b.y};
}
Point along(Point a, double t, Point direction) {
  return {a.x + t * direction.x, a.y + t * direction.y};
}
float to_float(double value) {
  return static_cast<float>(value);
}

/// Whether the program `general` also draws the instances of `special`.
bool can_draw(Program general, Program special) {
  const bool boxes = special == Program::Rounded;
  return (general == Program::Convex4 && boxes) ||
         (general == Program::Convex8 && (boxes || special == Program::Convex4)) ||
         (general == Program::Polygon && boxes);
}

/// Keeps the side of a convex polygon where dot(normal, p) <= offset (Sutherland and Hodgman 1974).
void cut(std::vector<Point>& corners, Point normal, double offset) {
  std::vector<Point> kept;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Point a = corners[i], b = corners[(i + 1) % corners.size()];
    const double da = dot(normal, a) - offset, db = dot(normal, b) - offset;
    if (da <= 0) kept.push_back(a);
    if ((da < 0 && db > 0) || (da > 0 && db < 0)) kept.push_back(along(a, da / (da - db), minus(b, a)));
  }
  corners = std::move(kept);
}

}  // namespace

/// Whether a square around the shape is cheaper than two triangles. Points whose centre is outside of the
/// picture are not drawn at all.
bool ShapeBatches::is_point(Program program, const ShapeInstance& shape) const {
  if (program == Program::Arrow) return false;
  const double x = shape.centre[0], y = shape.centre[1], margin = margin_px(program) + shape.radius;
  if (x < 0 || x > width_ || y < 0 || y > height_) return false;
  if (program == Program::Spoke) return 2 * margin + 1 <= largest_point;
  const double hx = shape.half[0] + margin, hy = shape.half[1] + margin;
  const double ax = std::abs(shape.axis[0]), ay = std::abs(shape.axis[1]);
  const double side = 2 * std::max(hx * ax + hy * ay, hx * ay + hy * ax) + 1;
  // Two triangles shade the blocks along their common edge twice: a fifth of a large square.
  return side <= largest_point && side * side <= 1.2 * 4 * hx * hy + 100;
}

void ShapeBatches::push(Program program, const ShapeInstance& shape) {
  for (const float number : {shape.centre[0], shape.centre[1], shape.half[0], shape.half[1], shape.radius}) {
    if (!(std::abs(number) < kMost)) {
      ++culled;
      return;
    }
  }
  const auto index = static_cast<std::uint32_t>(shapes.size());
  shapes.push_back(shape);
  if (!batches.empty()) {
    Batch& last = batches.back();
    // A polygon program draws what simpler ones do, at a small cost, so runs are not broken up for a few of
    // them.
    const bool joins = last.program == program || can_draw(last.program, program);
    const bool turns = can_draw(program, last.program) && last.count < 256;
    if (joins || turns) {
      if (turns) last.program = program;
      ++last.count;
      return;
    }
  }
  batches.push_back({program, index, 1, false});
}

/// Cuts out runs of points that are long enough to pay for a call of the driver.
void ShapeBatches::split_points() {
  constexpr std::uint32_t kRun = 48;
  std::vector<Batch> split;
  for (const Batch& batch : batches) {
    if (batch.program == Program::Text || batch.count < kRun) {
      split.push_back(batch);
      continue;
    }
    const std::uint32_t end = batch.first + batch.count;
    std::uint32_t quads = batch.first;  // not yet in a batch
    for (std::uint32_t i = batch.first; i < end;) {
      std::uint32_t run = i;
      while (run < end && is_point(batch.program, shapes[run])) ++run;
      if (run - i >= kRun) {
        if (i > quads) split.push_back({batch.program, quads, i - quads, false});
        split.push_back({batch.program, i, run - i, true});
        quads = run;
      }
      i = run + 1;
    }
    if (end > quads) split.push_back({batch.program, quads, end - quads, false});
  }
  batches = std::move(split);
}

void ShapeBatches::add_box(Point centre, Point axis, double hx, double hy, double radius, double outline,
                           Color fill, Color line) {
  const double sum = centre.x + centre.y + axis.x + axis.y + hx + hy + radius;
  if (!std::isfinite(sum) || radius < 0) {
    ++culled;
    return;
  }
  // Outside of the picture?
  const double ex = std::abs(axis.x) * hx + std::abs(axis.y) * hy + radius + 1;
  const double ey = std::abs(axis.y) * hx + std::abs(axis.x) * hy + radius + 1;
  if (centre.x + ex < 0 || centre.x - ex > width_ || centre.y + ey < 0 || centre.y - ey > height_) {
    ++culled;
    return;
  }
  const Point side{-axis.y, axis.x};
  const Point view = minus(middle_, centre);
  double vx = dot(view, axis), vy = dot(view, side);
  if (radius > kLargeRadius) {
    // Seen from so near, the rim is a straight line: draw the half plane inside of it.
    const Point nearest{std::clamp(vx, -hx, hx), std::clamp(vy, -hy, hy)};
    const Point out{vx - nearest.x, vy - nearest.y};
    const double distance = std::hypot(out.x, out.y);
    const double depth = radius - distance;  // of the middle of the picture below the rim
    if (depth < -reach_ - 1) {
      ++culled;
      return;
    }
    const double far = reach_ + outline + 2;
    const double top = std::min(depth, far);
    if (distance > 0)
      axis = {(out.x * axis.x + out.y * side.x) / distance, (out.x * axis.y + out.y * side.y) / distance};
    centre = along(middle_, 0.5 * (top - far), axis);
    hx = 0.5 * (top + far);
    hy = far;
    radius = 0;
  } else if (hx > kLargeExtent || hy > kLargeExtent) {
    // Cut to the surroundings of the picture, in the frame of the box.
    const double margin = reach_ + radius + outline + 2;
    const double left = std::max(-hx, vx - margin), right = std::min(hx, vx + margin);
    const double bottom = std::max(-hy, vy - margin), top = std::min(hy, vy + margin);
    if (left > right || bottom > top) {
      ++culled;
      return;
    }
    centre = along(along(centre, 0.5 * (left + right), axis), 0.5 * (bottom + top), side);
    hx = 0.5 * (right - left);
    hy = 0.5 * (top - bottom);
  }
  push(Program::Rounded, {{to_float(centre.x), to_float(centre.y)},
                          {to_float(axis.x), to_float(axis.y)},
                          {to_float(hx), to_float(hy)},
                          to_float(radius),
                          to_float(outline),
                          fill,
                          line,
                          0,
                          0});
}

void ShapeBatches::add_line(Point from, Point to, double width, Color color, double dash) {
  // A line thinner than a pixel is a paler line of one pixel.
  if (width < 1) {
    color = faded(color, std::max(width, 0.0));
    width = 1;
  }
  const Point span = minus(to, from);
  const double length = std::hypot(span.x, span.y);
  const Point axis = length > 0 ? Point{span.x / length, span.y / length} : Point{1, 0};
  const auto piece = [&](double begin, double end) {
    add_box(along(from, 0.5 * (begin + end), axis), axis, 0.5 * (end - begin), 0, 0.5 * width, 0, color,
            color);
  };
  if (!(dash > 0) || !std::isfinite(length)) {
    piece(0, length);
    return;
  }
  // Dashes that can be seen only; their phase counts from `from`.
  const double near = dot(minus(middle_, from), axis);
  const double period = 2 * std::max(dash, 1.0);
  const double first = std::max(0.0, std::floor((near - reach_) / period));
  const double last = std::min(length / period, (near + reach_) / period + 1);
  // From so far away that numbers do not tell one dash from the next it looks like a plain line.
  if (first + 1 == first) {
    piece(0, length);
    return;
  }
  constexpr int kMostDashes = 4096;
  for (int i = 0; i < kMostDashes && first + i <= last; ++i) {
    const double begin = (first + i) * period;
    piece(begin, std::min(begin + 0.5 * period, length));
  }
}

void ShapeBatches::add_arrow(const Arrow& arrow) {
  Point from = to_px(arrow.from);
  const Point to = to_px(arrow.to);
  const Point span = minus(to, from);
  double length = std::hypot(span.x, span.y);
  if (!std::isfinite(length) || !(length > 0)) {
    ++culled;
    return;
  }
  const Point axis{span.x / length, span.y / length};
  double head = arrow.head_px * px_, width = arrow.width_px * px_;
  // Shorter than its head it shrinks as a whole.
  if (length < head) {
    width *= length / head;
    head = length;
  }
  const double half_head = std::max(0.42 * head, 0.5 * width);
  // The far end of a very long shaft is out of sight, or else the head is.
  const double near = dot(minus(middle_, from), axis);
  const double longest = 4 * reach_ + head;
  if (length > longest) {
    if (near < length - 2 * reach_ - head) {
      add_line(from, along(to, -head, axis), width, arrow.color, 0);
      return;
    }
    from = along(to, -longest, axis);
    length = longest;
  }
  const Point centre = along(from, 0.5 * length, axis);
  const double ex = std::abs(axis.x) * 0.5 * length + half_head + 1,
               ey = std::abs(axis.y) * 0.5 * length + half_head + 1;
  if (centre.x + ex < 0 || centre.x - ex > width_ || centre.y + ey < 0 || centre.y - ey > height_) {
    ++culled;
    return;
  }
  push(Program::Arrow, {{to_float(centre.x), to_float(centre.y)},
                        {to_float(axis.x), to_float(axis.y)},
                        {to_float(0.5 * length), to_float(half_head)},
                        to_float(0.5 * width),
                        to_float(head),
                        arrow.color,
                        arrow.color,
                        0,
                        0});
}

void ShapeBatches::add_polygon(const DrawLayer& layer, const Polygon& polygon) {
  const std::size_t count = polygon.count;
  if (count < 3 || polygon.first + count > layer.points.size()) {
    ++culled;
    return;
  }
  const double radius = polygon.rounding * scale_, outline = polygon.outline_px * px_;
  std::array<Point, 64> fixed;
  std::vector<Point> many;
  Point low{1e300, 1e300}, high{-1e300, -1e300};
  const std::size_t used = std::min<std::size_t>(count, fixed.size());
  bool good = std::isfinite(radius) && radius >= 0;
  for (std::size_t i = 0; i < used; ++i) {
    fixed[i] = to_px(layer.points[polygon.first + i]);
    good = good && finite(fixed[i]);
    low = {std::min(low.x, fixed[i].x), std::min(low.y, fixed[i].y)};
    high = {std::max(high.x, fixed[i].x), std::max(high.y, fixed[i].y)};
  }
  const double grow = radius + 1;
  if (!good || high.x < -grow || low.x > width_ + grow || high.y < -grow || low.y > height_ + grow) {
    ++culled;
    return;
  }
  // A rectangle (to a hundredth of a pixel) is the cheaper box.
  if (used == 4) {
    const Point e = minus(fixed[1], fixed[0]), f = minus(fixed[3], fixed[0]);
    const double le = std::hypot(e.x, e.y), lf = std::hypot(f.x, f.y);
    const Point gap{fixed[0].x + fixed[2].x - fixed[1].x - fixed[3].x,
                    fixed[0].y + fixed[2].y - fixed[1].y - fixed[3].y};
    if (le > 0 && lf > 0 && std::abs(dot(e, f)) <= 0.01 * std::max(le, lf) &&
        std::hypot(gap.x, gap.y) <= 0.01) {
      const Point centre{0.5 * (fixed[0].x + fixed[2].x), 0.5 * (fixed[0].y + fixed[2].y)};
      const Point axis = le >= lf ? Point{e.x / le, e.y / le} : Point{f.x / lf, f.y / lf};
      add_box(centre, axis, 0.5 * std::max(le, lf), 0.5 * std::min(le, lf), radius, outline, polygon.fill,
              polygon.outline);
      return;
    }
  }
  const Point* corner = fixed.data();
  std::size_t n = used;
  if (high.x - low.x > kLargeExtent || high.y - low.y > kLargeExtent) {
    many.assign(fixed.begin(), fixed.begin() + static_cast<std::ptrdiff_t>(used));
    const double margin = 2 * (radius + outline + 2);
    cut(many, {1, 0}, width_ + margin);
    cut(many, {-1, 0}, margin);
    cut(many, {0, 1}, height_ + margin);
    cut(many, {0, -1}, margin);
    if (many.size() < 3) {
      ++culled;
      return;
    }
    corner = many.data();
    n = many.size();
  }
  // The shader wants one orientation, whichever the caller has.
  double area = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Point a = minus(corner[i], corner[0]), b = minus(corner[(i + 1) % n], corner[0]);
    area += a.x * b.y - a.y * b.x;
  }
  // A quad along the longest edge covers little besides the polygon.
  Point axis{1, 0};
  double longest = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Point e = minus(corner[(i + 1) % n], corner[i]);
    const double length = std::hypot(e.x, e.y);
    if (length > longest * 1.0001) {
      longest = length;
      axis = {e.x / length, e.y / length};
    }
  }
  const bool sharp = radius == 0 && n <= 8;
  // Without an edge there is no side of one: a disc.
  if (!sharp && longest < kNoLength) {
    if (radius > 0)
      add_box(corner[0], {1, 0}, 0, 0, radius, outline, polygon.fill, polygon.outline);
    else
      ++culled;
    return;
  }
  const Point side{-axis.y, axis.x};
  low = {1e300, 1e300};
  high = {-1e300, -1e300};
  for (std::size_t i = 0; i < n; ++i) {
    const double x = dot(corner[i], axis), y = dot(corner[i], side);
    low = {std::min(low.x, x), std::min(low.y, y)};
    high = {std::max(high.x, x), std::max(high.y, y)};
  }
  const Point middle{0.5 * (low.x + high.x), 0.5 * (low.y + high.y)};
  const auto first = static_cast<std::uint32_t>(corners.size() / 4);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t from = area > 0 ? i : n - 1 - i, to = area > 0 ? (i + 1) % n : (2 * n - 2 - i) % n;
    const Point a = corner[from], e = minus(corner[to], a);
    const double x = dot(a, axis) - middle.x, y = dot(a, side) - middle.y;
    const double ex = dot(e, axis), ey = dot(e, side), length = std::sqrt(ex * ex + ey * ey);
    if (!sharp) {
      corners.insert(corners.end(), {to_float(x), to_float(y), to_float(ex), to_float(ey)});
    } else if (length > 0) {
      const double nx = ey / length, ny = -ex / length;
      corners.insert(corners.end(), {to_float(nx), to_float(ny), to_float(nx * x + ny * y), 0});
    }
  }
  const auto edges = static_cast<std::uint32_t>(corners.size() / 4) - first;
  const Program program = !sharp ? Program::Polygon : edges <= 4 ? Program::Convex4 : Program::Convex8;
  if (edges == 0) {
    ++culled;
    return;
  }
  const Point centre{middle.x * axis.x + middle.y * side.x, middle.x * axis.y + middle.y * side.y};
  push(program, {{to_float(centre.x), to_float(centre.y)},
                 {to_float(axis.x), to_float(axis.y)},
                 {to_float(0.5 * (high.x - low.x)), to_float(0.5 * (high.y - low.y))},
                 to_float(radius),
                 to_float(outline),
                 polygon.fill,
                 polygon.outline,
                 first,
                 edges});
}

void ShapeBatches::add_spoke(Point centre, double radius, const Disc& disc, double outline) {
  const double reach = radius + 1;
  if (!std::isfinite(disc.angle) || centre.x + reach < 0 || centre.x - reach > width_ ||
      centre.y + reach < 0 || centre.y - reach > height_) {
    ++culled;
    return;
  }
  push(Program::Spoke, {{to_float(centre.x), to_float(centre.y)},
                        {1, 0},
                        {to_float(std::cos(disc.angle)), to_float(-std::sin(disc.angle))},
                        to_float(radius),
                        to_float(outline),
                        disc.fill,
                        disc.outline,
                        0,
                        0});
}

void ShapeBatches::add_layer(const DrawLayer& layer) {
  for (const Polygon& polygon : layer.polygons) add_polygon(layer, polygon);
  for (const Capsule& capsule : layer.capsules) {
    const Point from = to_px(capsule.from), to = to_px(capsule.to), span = minus(to, from);
    const double length = std::hypot(span.x, span.y);
    const Point axis = length > 0 ? Point{span.x / length, span.y / length} : Point{1, 0};
    add_box({0.5 * (from.x + to.x), 0.5 * (from.y + to.y)}, axis, 0.5 * length, 0, capsule.radius * scale_,
            capsule.outline_px * px_, capsule.fill, capsule.outline);
  }
  for (const Disc& disc : layer.discs) {
    const Point centre = to_px(disc.centre);
    const double radius = disc.radius * scale_, outline = disc.outline_px * px_;
    const bool spoke = disc.spoke && radius > outline;
    if (spoke && radius < kLargeExtent && finite(centre)) {
      add_spoke(centre, radius, disc, outline);
      continue;
    }
    add_box(centre, {1, 0}, 0, 0, radius, outline, disc.fill, disc.outline);
    if (spoke) {
      const double reach = radius - outline;
      const Point rim{centre.x + reach * std::cos(disc.angle), centre.y - reach * std::sin(disc.angle)};
      add_line(centre, rim, outline, disc.outline, 0);
    }
  }
  for (const Line& line : layer.lines) {
    add_line(to_px(line.from), to_px(line.to), line.width_px * px_, line.color, line.dash_px * px_);
  }
  for (const Arrow& arrow : layer.arrows) add_arrow(arrow);
  for (const Marker& marker : layer.markers) {
    const double outline = marker.outline.a > 0 ? 1.25 * px_ : 0;
    add_box(to_px(marker.at), {1, 0}, 0, 0, marker.radius_px * px_, outline, marker.fill, marker.outline);
  }
}

/// @return whether the atlas had room for all letters
bool ShapeBatches::add_labels(const std::vector<Label>& labels, GlyphAtlas& atlas) {
  // Larger letters look the same at whole pixels, and take much room.
  constexpr double kQuarters = 128;
  bool fits = true;
  for (const Label& label : labels) {
    const Point at = to_px(label.at);
    const double size = std::min(label.size_px * px_, GlyphAtlas::kLargest), gap = label.offset_px * px_,
                 halo = label.halo.a > 0 ? 2.2 * px_ : 0;
    if (!finite(at) || !(size > 0) || std::abs(at.x) > 1e6 || std::abs(at.y) > 1e6) {
      ++culled;
      continue;
    }
    // Split into lines, then place the block around the anchor by the height of capitals.
    std::vector<std::string_view> lines;
    for (std::string_view rest = label.text;;) {
      const std::size_t end = rest.find('\n');
      lines.push_back(rest.substr(0, end));
      if (end == std::string_view::npos) break;
      rest.remove_prefix(end + 1);
    }
    const double cap = atlas.cap_height() * size;
    const double block = cap + (static_cast<double>(lines.size()) - 1) * kLineSpacing * size;
    double top = at.y - 0.5 * block;
    if (label.anchor == Anchor::Above) top = at.y - gap - block;
    if (label.anchor == Anchor::Below) top = at.y + gap;
    const std::size_t begin = glyphs.size();
    for (std::size_t row = 0; row < lines.size(); ++row) {
      double width = 0;
      for (std::size_t i = 0; i < lines[row].size();)
        width += atlas.advance(next_code_point(lines[row], i), size);
      double pen = at.x - 0.5 * width;
      if (label.anchor == Anchor::Left) pen = at.x - gap - width;
      if (label.anchor == Anchor::Right) pen = at.x + gap;
      const double baseline = std::floor(top + cap + static_cast<double>(row) * kLineSpacing * size + 0.5);
      for (std::size_t i = 0; i < lines[row].size();) {
        const char32_t code = next_code_point(lines[row], i);
        const double quarters = size > kQuarters ? 4 * std::floor(pen + 0.5) : std::floor(pen * 4 + 0.5);
        const double whole = std::floor(quarters / 4);
        const Glyph* glyph = atlas.glyph(code, size, static_cast<int>(quarters - whole * 4), halo);
        if (glyph == nullptr) {
          fits = false;
          ++culled;
        } else if (glyph->width > 0) {
          glyphs.push_back({{to_float(whole + glyph->left), to_float(baseline + glyph->top)},
                            {glyph->u, glyph->v},
                            {glyph->width, glyph->height},
                            label.color,
                            0});
        }
        pen += atlas.advance(code, size);
      }
    }
    // All halos of a label lie under all of its glyphs.
    const std::size_t end = glyphs.size();
    if (halo > 0 && end > begin) {
      glyphs.resize(2 * end - begin);
      std::copy(glyphs.begin() + static_cast<std::ptrdiff_t>(begin),
                glyphs.begin() + static_cast<std::ptrdiff_t>(end),
                glyphs.begin() + static_cast<std::ptrdiff_t>(end));
      for (std::size_t i = begin; i < end; ++i) {
        glyphs[i].color = label.halo;
        glyphs[i].channel = 1;
      }
    }
  }
  return fits;
}

void ShapeBatches::build(const DrawList& list, const Camera& camera, int ssaa, GlyphAtlas& atlas,
                         int first_layer, int last_layer) {
  camera_ = camera;
  scale_ = camera.pixels_per_metre() * ssaa;
  px_ = ui_scale(camera.height_px) * ssaa;
  width_ = static_cast<double>(camera.width_px) * ssaa;
  height_ = static_cast<double>(camera.height_px) * ssaa;
  reach_ = 0.5 * std::hypot(width_, height_);
  middle_ = {0.5 * width_, 0.5 * height_};
  // Another pass after the atlas overflowed: it has then grown and holds only what this frame shows.
  for (bool largest = false;;) {
    bool fits = true;
    shapes.clear();
    corners.clear();
    glyphs.clear();
    batches.clear();
    culled = 0;
    for (int k = first_layer; k < last_layer; ++k) {
      const DrawLayer& layer = list.layers[k];
      add_layer(layer);
      const auto first = static_cast<std::uint32_t>(glyphs.size());
      fits = add_labels(layer.labels, atlas) && fits;
      const auto count = static_cast<std::uint32_t>(glyphs.size()) - first;
      if (count > 0) batches.push_back({Program::Text, first, count, false});
    }
    if (fits || largest) break;
    atlas.clear();
    largest = atlas.height() == GlyphAtlas::kTallest;
  }
  split_points();
}

}  // namespace skerry::render
