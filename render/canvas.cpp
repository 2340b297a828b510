// SPDX-License-Identifier: MIT
#include "render/canvas.h"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "render/glyphs.h"
#include "render/lanes.h"
#include "render/shape_batch.h"
#include "render/style.h"

namespace skerry::render {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

/// The part of the plane where nx x + ny y <= offset for all that were added: what it has of each row.
class Convex {
 public:
  void add(double nx, double ny, double offset) {
    if (std::abs(nx) > 1e-9) {
      Bound& bound = nx > 0 ? right_[rights_++] : left_[lefts_++];
      bound = {offset / nx, -ny / nx};
    } else if (ny > 0) {
      bottom_ = std::min(bottom_, offset / ny);
    } else if (ny < 0) {
      top_ = std::max(top_, offset / ny);
    }
  }
  /// The pixels of row y whose centres are inside.
  [[nodiscard]] Span row(int y, int width) const {
    const double at = y + 0.5;
    if (at < top_ || at >= bottom_) return {};
    double low = -kInf, high = kInf;
    for (int i = 0; i < lefts_; ++i) low = std::max(low, left_[i].base + left_[i].slope * at);
    for (int i = 0; i < rights_; ++i) high = std::min(high, right_[i].base + right_[i].slope * at);
    return span_of(low, high, width);
  }

  static constexpr int kMost = 72;

 private:
  struct Bound {
    double base, slope;
  };
  Bound left_[kMost], right_[kMost];  // only as many as were added are written
  int lefts_ = 0, rights_ = 0;
  double top_ = -kInf, bottom_ = kInf;
};

/// A disc: what it has of each row.
struct Round {
  double x, y, radius;
  [[nodiscard]] Span row(int at, int width) const {
    const double dy = at + 0.5 - y, square = radius * radius - dy * dy;
    if (radius <= 0 || square <= 0) return {};
    const double half = std::sqrt(square);
    return span_of(x - half, x + half, width);
  }
};

/// The same pixels of each row: for shapes so small that one looks at all of the square around them.
struct Strip {
  double left, right;
  [[nodiscard]] Span row(int, int width) const { return span_of(left, right, width); }
};
constexpr double kSmall = 7;  // [px], half of the side

struct Nothing {
  [[nodiscard]] Span row(int, int) const { return {}; }
};

/// The box of a shape as numbers of its own frame: centre, axis.
struct Frame {
  double x, y, ax, ay;
  explicit Frame(const ShapeInstance& s)
      : x(static_cast<double>(s.centre[0])),
        y(static_cast<double>(s.centre[1])),
        ax(static_cast<double>(s.axis[0])),
        ay(static_cast<double>(s.axis[1])) {}
  /// Adds u x + v y <= offset, in this frame.
  void add(Convex& region, double u, double v, double offset) const {
    const double nx = u * ax - v * ay, ny = u * ay + v * ax;
    region.add(nx, ny, offset + nx * x + ny * y);
  }
  [[nodiscard]] Convex box(double left, double right, double half_height) const {
    Convex region;
    add(region, 1, 0, right);
    add(region, -1, 0, -left);
    add(region, 0, 1, half_height);
    add(region, 0, -1, half_height);
    return region;
  }
};

/// Coordinates of four pixels in the frame of a shape.
struct Local {
  Lanes x, y;
};

/// The loops over rows and pixels that all shapes share. All that a group of four needs is made before them
/// and kept in local variables: bytes that are stored could be part of anything that is only referred to.
/// @param ey        the shape reaches so far from its centre, up and down [px]
/// @param whole     rows of what has to be looked at
/// @param core      rows of what is nothing but fill
/// @param distance  of Local to the rim, negative inside [px]
/// @tparam kOneInk  no outline
template <bool kOneInk, class Whole, class Core, class Distance>
void paint_rows(const Surface surface, const ShapeInstance& shape, double ey, const Whole& whole,
                const Core& core, const Distance distance) {
  const double middle = static_cast<double>(shape.centre[1]);
  const Span rows = span_of(middle - ey, middle + ey, surface.height);  // the same rule, downwards
  const Ink fill(shape.fill), line(shape.line);
  const Brush rim(kOneInk ? fill : line);
  const Brush more({fill.r - line.r, fill.g - line.g, fill.b - line.b, fill.a - line.a});
  const Lanes cx = shape.centre[0], ax = shape.axis[0], ay = shape.axis[1], outline = shape.outline;
  const float cy = shape.centre[1];
  for (int y = rows.x0; y < rows.x1; ++y) {
    const Span all = whole.row(y, surface.width);
    if (all.empty()) continue;
    std::uint8_t* const row = surface.row(y);
    const Lanes dy = static_cast<float>(y) + 0.5f - cy;
    const Lanes along = dy * ay, across = dy * ax;
    const auto four = [&](int x, Lanes centres, const auto& mask) SKERRY_INLINE_LAMBDA {
      const Lanes dx = centres - cx;
      const Lanes d = Lanes(0.5f) - distance(Local{dx * ax + along, across - dx * ay});
      const Lanes cover = mask(max(min(d, 1.0f), 0.0f));
      if (none_positive(cover)) return;
      if constexpr (kOneInk)
        blend(row + 4 * x, cover, rim);
      else
        blend(row + 4 * x, cover, rim, mask(max(min(d - outline, 1.0f), 0.0f)), more);
    };
    Span inside = core.row(y, surface.width);
    // A few pixels are not worth two ends.
    if (inside.x1 - inside.x0 < 6) {
      by_four(all.x0, all.x1, surface.width, four);
      continue;
    }
    // Groups that end where the core begins: it gives up what they overlap.
    inside.x0 += (4 - (inside.x0 - all.x0) % 4) % 4;
    inside.x1 -= (4 - (all.x1 - inside.x1) % 4) % 4;
    by_four(all.x0, inside.x0, surface.width, four);
    fill_span(surface, y, inside.x0, inside.x1, fill);
    by_four(inside.x1, all.x1, surface.width, four);
  }
}

template <class Whole, class Core, class Distance>
void paint(const Surface& surface, const ShapeInstance& shape, double ey, const Whole& whole,
           const Core& core, const Distance& distance) {
  if (shape.outline <= 0 || shape.fill == shape.line)
    paint_rows<true>(surface, shape, ey, whole, core, distance);
  else
    paint_rows<false>(surface, shape, ey, whole, core, distance);
}

double extent_x(const ShapeInstance& s, double margin) {
  return std::abs(static_cast<double>(s.axis[0])) * (static_cast<double>(s.half[0]) + margin) +
         std::abs(static_cast<double>(s.axis[1])) * (static_cast<double>(s.half[1]) + margin);
}
double extent_y(const ShapeInstance& s, double margin) {
  return std::abs(static_cast<double>(s.axis[1])) * (static_cast<double>(s.half[0]) + margin) +
         std::abs(static_cast<double>(s.axis[0])) * (static_cast<double>(s.half[1]) + margin);
}

void paint_disc(const Surface& surface, const ShapeInstance& shape) {
  const double x = static_cast<double>(shape.centre[0]), y = static_cast<double>(shape.centre[1]);
  const double radius = static_cast<double>(shape.radius), outline = static_cast<double>(shape.outline);
  const float r = shape.radius;
  const auto distance = [r](const Local& at)
                            SKERRY_INLINE_LAMBDA { return sqrt(at.x * at.x + at.y * at.y) - r; };
  const double reach = radius + 0.5;
  if (reach < kSmall)
    paint(surface, shape, reach, Strip{x - reach, x + reach}, Nothing{}, distance);
  else
    paint(surface, shape, reach, Round{x, y, reach}, Round{x, y, radius - outline - 0.501}, distance);
}

/// Boxes with round corners; lines are flat ones.
void paint_rounded(const Surface& surface, const ShapeInstance& shape) {
  const Frame frame(shape);
  const double hx = static_cast<double>(shape.half[0]), hy = static_cast<double>(shape.half[1]);
  const double radius = static_cast<double>(shape.radius), outline = static_cast<double>(shape.outline);
  if (hx == 0 && hy == 0) return paint_disc(surface, shape);
  const double margin = radius + margin_px(Program::Rounded);
  // A box inside of the rim, to the corners of which the rounding leaves room.
  const double depth = radius - outline - 0.501, inset = depth > 0 ? 0.7071 * depth : depth;
  const float sx = shape.half[0], sy = shape.half[1], r = shape.radius;
  const auto distance = [sx, sy, r](const Local& at) SKERRY_INLINE_LAMBDA {
    const Lanes qx = abs(at.x) - sx, qy = abs(at.y) - sy;
    const Lanes ox = max(qx, 0.0f), oy = max(qy, 0.0f);
    return sqrt(ox * ox + oy * oy) + min(max(qx, qy), 0.0f) - r;
  };
  const double ex = extent_x(shape, margin), ey = extent_y(shape, margin);
  if (ex < kSmall) return paint(surface, shape, ey, Strip{frame.x - ex, frame.x + ex}, Nothing{}, distance);
  const Convex whole = frame.box(-hx - margin, hx + margin, hy + margin);
  if (std::min(hx, hy) + inset > 2)
    paint(surface, shape, ey, whole, frame.box(-hx - inset, hx + inset, hy + inset), distance);
  else
    paint(surface, shape, ey, whole, Nothing{}, distance);
}

/// The disc, then its radius line: nothing but a short line.
void paint_spoke(const Surface& surface, const ShapeInstance& shape) {
  ShapeInstance disc = shape;
  disc.half[0] = disc.half[1] = 0;
  paint_disc(surface, disc);
  ShapeInstance line = disc;
  const float length = shape.radius - shape.outline;
  line.axis[0] = shape.half[0];
  line.axis[1] = shape.half[1];
  line.centre[0] += 0.5f * length * line.axis[0];
  line.centre[1] += 0.5f * length * line.axis[1];
  line.half[0] = 0.5f * length;
  line.radius = 0.5f * std::max(shape.outline, 1.0f);
  line.fill = line.line = faded(shape.line, static_cast<double>(std::min(shape.outline, 1.0f)));
  paint_rounded(surface, line);
}

/// Sharp polygons of at most kEdges corners: the largest of the distances to the lines through the edges.
template <std::size_t kEdges>
void paint_convex(const Surface& surface, const ShapeInstance& shape, const float* edges) {
  const Frame frame(shape);
  const double outline = static_cast<double>(shape.outline), margin = margin_px(Program::Convex8);
  const double hx = static_cast<double>(shape.half[0]), hy = static_cast<double>(shape.half[1]);
  // Edges that the polygon does not have are the first once more.
  struct Edges {
    float x[kEdges], y[kEdges], offset[kEdges];
  } e;
  for (std::size_t i = 0; i < kEdges; ++i) {
    const float* from = edges + 4 * (i < shape.count ? i : 0);
    e.x[i] = from[0];
    e.y[i] = from[1];
    e.offset[i] = from[2];
  }
  const auto distance = [e](const Local& at) SKERRY_INLINE_LAMBDA {
    Lanes d = at.x * e.x[0] + at.y * e.y[0] - e.offset[0];
    for (std::size_t i = 1; i < kEdges; ++i) d = max(d, at.x * e.x[i] + at.y * e.y[i] - e.offset[i]);
    return d;
  };
  const double ex = extent_x(shape, margin), ey = extent_y(shape, margin);
  if (ex < kSmall) return paint(surface, shape, ey, Strip{frame.x - ex, frame.x + ex}, Nothing{}, distance);
  Convex whole = frame.box(-hx - margin, hx + margin, hy + margin), core;
  for (std::size_t i = 0; i < shape.count; ++i) {
    const double u = static_cast<double>(e.x[i]), v = static_cast<double>(e.y[i]),
                 offset = static_cast<double>(e.offset[i]);
    frame.add(whole, u, v, offset + 0.5);
    frame.add(core, u, v, offset - outline - 0.501);
  }
  paint(surface, shape, ey, whole, core, distance);
}

/// Rounded polygons: distance to the edges, inside by the side of all of them.
void paint_polygon(const Surface& surface, const ShapeInstance& shape, const float* edges) {
  const Frame frame(shape);
  const double margin = margin_px(Program::Polygon) + static_cast<double>(shape.radius);
  const double hx = static_cast<double>(shape.half[0]), hy = static_cast<double>(shape.half[1]);
  const Convex whole = frame.box(-hx - margin, hx + margin, hy + margin);
  const double depth =
      std::min(static_cast<double>(shape.radius) - static_cast<double>(shape.outline) - 0.501, 0.0);
  Convex core;
  struct Edge {
    float x, y, ex, ey, inverse;
  };
  Edge list[64];
  const std::uint32_t count = std::min<std::uint32_t>(shape.count, 64);
  for (std::uint32_t i = 0; i < count; ++i) {
    const float* e = edges + 4 * i;
    list[i] = {e[0], e[1], e[2], e[3], 1 / std::max(e[2] * e[2] + e[3] * e[3], 1e-12f)};
    const double ex = static_cast<double>(e[2]), ey = static_cast<double>(e[3]), length = std::hypot(ex, ey);
    if (length > 0)
      frame.add(core, ey / length, -ex / length,
                (static_cast<double>(e[0]) * ey - static_cast<double>(e[1]) * ex) / length + depth);
  }
  const float r = shape.radius;
  const auto distance = [&](const Local& at) {
    Lanes square(1e30f), side(-1e30f);
    for (std::uint32_t i = 0; i < count; ++i) {
      const Edge& e = list[i];
      const Lanes tx = at.x - e.x, ty = at.y - e.y;
      const Lanes share = max(min((tx * e.ex + ty * e.ey) * e.inverse, 1.0f), 0.0f);
      const Lanes gx = tx - share * e.ex, gy = ty - share * e.ey;
      square = min(square, gx * gx + gy * gy);
      side = max(side, tx * e.ey - ty * e.ex);
    }
    // The sign of `side`: scaled so that all but a hair of it is 1 or -1.
    const Lanes sign = max(min(side * 1e20f, 1.0f), -1.0f);
    return sqrt(square) * sign - r;
  };
  paint(surface, shape, extent_y(shape, margin), whole, core, distance);
}

/// A shaft with a round end, and a triangular head of length `outline` at the right. Each has the pixels on
/// its side of a line across the arrow, so that see-through arrows have no darker ones.
void paint_arrow(const Surface& surface, const ShapeInstance& arrow) {
  ShapeInstance shape = arrow;
  shape.outline = 0;
  const Frame frame(shape);
  const float half = arrow.half[0], wide = arrow.half[1], head = arrow.outline, r = arrow.radius;
  const float back = half - head, left = std::min(-half + r, back), joint = back + 0.25f * head;
  const float slope = std::sqrt(wide * wide + head * head), nx = wide / slope, ny = head / slope;
  const bool all_head = head >= 2 * half - 0.01f;
  const auto shaft = [=](const Local& at) SKERRY_INLINE_LAMBDA {
    const Lanes gap = at.x - max(min(at.x, joint), left);
    return sqrt(gap * gap + at.y * at.y) - r;
  };
  const auto tip = [=](const Local& at) SKERRY_INLINE_LAMBDA {
    return max((at.x - half) * nx + abs(at.y) * ny, Lanes(back) - at.x);
  };
  // The triangle with its half pixel of shade; the tip of a short one is cut as in the other renderer.
  const double seam = static_cast<double>(back) - 0.5, u = static_cast<double>(nx),
               v = static_cast<double>(ny);
  const double offset = u * static_cast<double>(half) + 0.5;
  Convex triangle;
  frame.add(triangle, u, v, offset);
  frame.add(triangle, u, -v, offset);
  frame.add(triangle, -1, 0, -seam);
  if (half < 20) frame.add(triangle, 1, 0, static_cast<double>(half) + 1);
  const double ey = extent_y(shape, 2);
  if (all_head) return paint(surface, shape, ey, triangle, Nothing{}, tip);
  const double tail = std::min(-static_cast<double>(half), static_cast<double>(back)) - 0.5625;
  paint(surface, shape, ey, frame.box(tail, seam, static_cast<double>(r) + 0.5625), Nothing{}, shaft);
  paint(surface, shape, ey, triangle, Nothing{},
        [=](const Local& at) SKERRY_INLINE_LAMBDA { return min(shaft(at), tip(at)); });
}

void paint_glyph(const Surface& surface, const GlyphInstance& glyph, const GlyphAtlas& atlas) {
  const Ink ink(glyph.color);
  const int left = static_cast<int>(glyph.corner[0]), top = static_cast<int>(glyph.corner[1]);
  const int x0 = std::max(left, 0), x1 = std::min(left + glyph.size[0], surface.width);
  const int y0 = std::max(top, 0), y1 = std::min(top + glyph.size[1], surface.height);
  for (int y = y0; y < y1; ++y) {
    const std::size_t v = static_cast<std::size_t>(glyph.texel[1] + y - top);
    const std::uint8_t* from = atlas.texels().data() +
                               2 * (v * GlyphAtlas::kWidth + static_cast<std::size_t>(glyph.texel[0])) +
                               glyph.channel;
    std::uint8_t* row = surface.row(y);
    for (int x = x0; x < x1; ++x) {
      const std::uint8_t cover = from[2 * (x - left)];
      if (cover > 0) blend_one(row + 4 * x, static_cast<float>(cover) / 255, ink);
    }
  }
}

}  // namespace

struct Canvas::State {
  int width, height, ssaa;
  std::vector<std::uint8_t> fine, final;  // `fine` is empty without ssaa
  GlyphAtlas atlas;
  ShapeBatches frame;
  // The background with its grid as it was drawn last: cameras rest most of the time.
  DrawLayer ground;
  Color ground_color;
  Camera ground_camera;
  DrawStats ground_stats;
  std::vector<std::uint8_t> ground_picture;  // empty: none yet

  // Rows of at least four pixels: groups of four never leave the picture.
  int stride() const { return std::max(width, 4); }
  Surface scene() {
    if (ssaa == 1) return {final.data(), stride(), height};
    return {fine.data(), std::max(width * ssaa, 4), height * ssaa};
  }
  void average();
  bool has_ground(const DrawList& list, const Camera& camera) const {
    return !ground_picture.empty() && list.background == ground_color &&
           camera.centre == ground_camera.centre && camera.height == ground_camera.height &&
           list[Layer::Background] == ground;
  }
  /// Paints what `frame` holds.
  DrawStats paint_frame(const Surface& surface) const;
};

Canvas::Canvas(int width, int height, int ssaa) {
  if (width < 1 || height < 1 || width > 16384 || height > 16384 || ssaa < 1 || ssaa > 4) {
    throw std::invalid_argument("canvas: sides must be 1 to 16384 px and ssaa 1 to 4, got " +
                                std::to_string(width) + " x " + std::to_string(height) + " px, ssaa " +
                                std::to_string(ssaa));
  }
  state_ = std::make_unique<State>();
  State& s = *state_;
  s.width = width;
  s.height = height;
  s.ssaa = ssaa;
  s.frame.largest_point = 0;  // squares instead of triangles mean nothing here
  s.final.resize(std::size_t{4} * s.stride() * height);
  if (ssaa > 1)
    s.fine.resize(std::size_t{4} * static_cast<std::size_t>(std::max(width * ssaa, 4)) * height * ssaa);
}

Canvas::~Canvas() = default;

int Canvas::width() const {
  return state_->width;
}
int Canvas::height() const {
  return state_->height;
}

Surface Canvas::surface() {
  return {state_->final.data(), state_->stride(), state_->height};
}

/// Mean of ssaa x ssaa pixels.
void Canvas::State::average() {
  const Surface from = scene();
  const int count = ssaa * ssaa;
  for (int y = 0; y < height; ++y) {
    std::uint8_t* to = final.data() + std::size_t{4} * y * stride();
    for (int x = 0; x < width; ++x, to += 4) {
      int sum[3] = {0, 0, 0};
      for (int v = 0; v < ssaa; ++v) {
        const std::uint8_t* p = from.row(y * ssaa + v) + 4 * x * ssaa;
        for (int u = 0; u < ssaa; ++u, p += 4)
          for (int k = 0; k < 3; ++k) sum[k] += p[k];
      }
      for (int k = 0; k < 3; ++k) to[k] = static_cast<std::uint8_t>((sum[k] + count / 2) / count);
      to[3] = 255;
    }
  }
}

DrawStats Canvas::draw(const DrawList& list, const Camera& camera) {
  State& s = *state_;
  camera.validate();
  if (camera.width_px != s.width || camera.height_px != s.height) {
    throw std::invalid_argument("canvas: the camera is for " + std::to_string(camera.width_px) + " x " +
                                std::to_string(camera.height_px) + " px, the canvas has " +
                                std::to_string(s.width) + " x " + std::to_string(s.height));
  }
  const Surface surface = s.scene();
  const int pixels = surface.width * surface.height;
  if (s.has_ground(list, camera)) {
    std::memcpy(surface.pixels, s.ground_picture.data(), s.ground_picture.size());
  } else {
    const Color c = list.background;
    fill_span({surface.pixels, pixels, 1}, 0, 0, pixels, Ink(Color{c.r, c.g, c.b, 255}));
    constexpr int kGround = static_cast<int>(Layer::Background);
    static_assert(kGround == 0);
    s.frame.build(list, camera, s.ssaa, s.atlas, kGround, kGround + 1);
    s.ground_stats = s.paint_frame(surface);
    s.ground = list[Layer::Background];
    s.ground_color = list.background;
    s.ground_camera = camera;
    s.ground_picture.assign(surface.pixels,
                            surface.pixels + std::size_t{4} * static_cast<std::size_t>(pixels));
  }
  s.frame.build(list, camera, s.ssaa, s.atlas, 1);
  const DrawStats rest = s.paint_frame(surface);
  if (s.ssaa > 1) s.average();
  return {s.ground_stats.shapes + rest.shapes, s.ground_stats.culled + rest.culled,
          s.ground_stats.draw_calls + rest.draw_calls};
}

DrawStats Canvas::State::paint_frame(const Surface& surface) const {
  for (const Batch& batch : frame.batches) {
    for (std::size_t i = batch.first; i < std::size_t{batch.first} + batch.count; ++i) {
      if (batch.program == Program::Text) {
        paint_glyph(surface, frame.glyphs[i], atlas);
        continue;
      }
      const ShapeInstance& shape = frame.shapes[i];
      const float* edges = frame.corners.data() + std::size_t{4} * shape.first;
      if (batch.program == Program::Arrow) {
        paint_arrow(surface, shape);
      } else if (batch.program == Program::Spoke) {
        paint_spoke(surface, shape);
      } else if (shape.count == 0) {
        paint_rounded(surface, shape);
      } else if (batch.program == Program::Polygon) {
        paint_polygon(surface, shape, edges);
      } else {
        shape.count <= 4 ? paint_convex<4>(surface, shape, edges) : paint_convex<8>(surface, shape, edges);
      }
    }
  }
  return {static_cast<int>(frame.shapes.size() + frame.glyphs.size()), frame.culled,
          static_cast<int>(frame.batches.size())};
}

void Canvas::take(Image& image) {
  State& s = *state_;
  image.width = s.width;
  image.height = s.height;
  if (s.width < s.stride()) {
    image.rgba.resize(std::size_t{4} * s.width * s.height);
    for (int y = 0; y < s.height; ++y)
      std::memcpy(image.rgba.data() + std::size_t{4} * y * s.width, surface().row(y),
                  std::size_t{4} * static_cast<std::size_t>(s.width));
    return;
  }
  image.rgba.resize(s.final.size());
  image.rgba.swap(s.final);
}

}  // namespace skerry::render
