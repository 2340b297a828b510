// SPDX-License-Identifier: MIT
//
// Shapes pixel by pixel: the inside of canvas.cpp, compiled for each number of lanes (raster_kernels.h). See
// raster.h for what such files may use.
#pragma once

#include <cmath>
#include <type_traits>

#include "render/raster.h"
#include "render/shape_batch.h"
#include "render/style.h"

namespace skerry::render {
inline namespace SKERRY_LANES {

inline constexpr double kFar = 1e300;
inline constexpr int kRows = 16;  ///< spans of so many rows are made at once

/// The pixels of kRows rows that belong to something; low >= high: none.
struct Spans {
  int x0[kRows], x1[kRows];

  /// From `low` to `high` in the rows from number i on, by the rule of span_of.
  SKERRY_INLINE void set(int i, Doubles low, Doubles high, int width) {
    const Doubles first = -1.0, last = static_cast<double>(width - 1);
    store_ints(x0 + i, min(max(low - 0.5, first), last) + 1.0);
    store_ints(x1 + i, min(max(high - 0.5, first), last) + 1.0);
  }
};
inline constexpr int kDoubles = kLanes / 2;

/// The part of the plane where nx x + ny y <= offset for all that were added: what it has of each row.
class Convex {
 public:
  SKERRY_INLINE void add(double nx, double ny, double offset) {
    if (nx > 1e-9 || nx < -1e-9) {
      Bound& bound = nx > 0 ? right_[rights_++] : left_[lefts_++];
      bound = {offset / nx, -ny / nx};
    } else if (ny > 0) {
      bottom_ = lesser(bottom_, offset / ny);
    } else if (ny < 0) {
      top_ = greater(top_, offset / ny);
    }
  }
  /// The pixels of the rows from y on whose centres are inside.
  SKERRY_INLINE void rows(int y, int width, Spans& out) const {
    for (int i = 0; i < kRows; i += kDoubles) {
      const Doubles at = doubles_from(y + i + 0.5);
      Doubles low = where_between(at, top_, bottom_, -kFar, kFar), high = kFar;
      for (int k = 0; k < lefts_; ++k) low = max(low, Doubles(left_[k].base) + Doubles(left_[k].slope) * at);
      for (int k = 0; k < rights_; ++k)
        high = min(high, Doubles(right_[k].base) + Doubles(right_[k].slope) * at);
      out.set(i, low, high, width);
    }
  }

  static constexpr int kMost = 72;

 private:
  struct Bound {
    double base, slope;
  };
  Bound left_[kMost], right_[kMost];  // only as many as were added are written
  int lefts_ = 0, rights_ = 0;
  double top_ = -kFar, bottom_ = kFar;
};

/// A disc.
struct Round {
  double x, y, radius;
  SKERRY_INLINE void rows(int first, int width, Spans& out) const {
    const double reach = radius > 0 ? radius : 0;
    for (int i = 0; i < kRows; i += kDoubles) {
      const Doubles dy = doubles_from(first + i + 0.5) - y, square = Doubles(reach * reach) - dy * dy;
      const Doubles half = sqrt(max(square, 0.0));
      out.set(i, where_between(square, 1e-300, kFar, Doubles(x) - half, kFar), Doubles(x) + half, width);
    }
  }
};

/// The same pixels of each row: for shapes so small that one looks at all of the square around them.
struct Strip {
  double left, right;
  SKERRY_INLINE void rows(int, int width, Spans& out) const {
    const Span span = span_of(left, right, width);
    for (int i = 0; i < kRows; ++i) out.x0[i] = span.x0;
    for (int i = 0; i < kRows; ++i) out.x1[i] = span.x1;
  }
};
inline constexpr double kSmall = 7;  // [px], half of the side

struct Nothing {};

// Constants, so that the function itself is not compiled here (raster.h).
inline constexpr double kRoundMargin = margin_px(Program::Rounded),
                        kSharpMargin = margin_px(Program::Convex8);
static_assert(kRoundMargin == margin_px(Program::Polygon));

/// The box of a shape as numbers of its own frame: centre, axis.
struct Frame {
  double x, y, ax, ay;
  SKERRY_INLINE explicit Frame(const ShapeInstance& s)
      : x(static_cast<double>(s.centre[0])),
        y(static_cast<double>(s.centre[1])),
        ax(static_cast<double>(s.axis[0])),
        ay(static_cast<double>(s.axis[1])) {}
  /// Adds u x + v y <= offset, in this frame.
  SKERRY_INLINE void add(Convex& region, double u, double v, double offset) const {
    const double nx = u * ax - v * ay, ny = u * ay + v * ax;
    region.add(nx, ny, offset + nx * x + ny * y);
  }
  SKERRY_INLINE void add_box(Convex& region, double left, double right, double half_height) const {
    add(region, 1, 0, right);
    add(region, -1, 0, -left);
    add(region, 0, 1, half_height);
    add(region, 0, -1, half_height);
  }
};

/// Coordinates of pixels in the frame of a shape.
struct Local {
  Lanes x, y;
};

/// From where to where something goes, downwards [px].
struct Reach {
  double top, bottom;
};

/// The loops over rows and pixels that all shapes share. All that a group of pixels needs is made before them
/// and kept in local variables: bytes that are stored could be part of anything that is only referred to.
/// @param reach     the shape lies between these two, downwards [px]
/// @param whole     rows of what has to be looked at
/// @param core      rows of what is nothing but fill; Nothing: all is looked at
/// @param distance  of Local to the rim, negative inside [px]
/// @tparam kOneInk  no outline
template <bool kOneInk, class Whole, class Core, class Distance>
void paint_rows(const Surface surface, const ShapeInstance& shape, const Reach reach, const Whole& whole,
                const Core& core, const Distance distance) {
  constexpr bool kCore = !std::is_same_v<Core, Nothing>;
  const Span rows = span_of(reach.top, reach.bottom, surface.height);  // the same rule, downwards
  const Ink fill(shape.fill), line(shape.line);
  const Brush rim(kOneInk ? fill : line);
  const Brush more({fill.r - line.r, fill.g - line.g, fill.b - line.b, fill.a - line.a});
  const Lanes cx = shape.centre[0], ax = shape.axis[0], ay = shape.axis[1], outline = shape.outline;
  const float cy = shape.centre[1];
  // A pixel inside is the same bits by both ways if it is opaque. Else where the core ends must not depend on
  // the number of lanes.
  const int group = kOneInk || (shape.fill.a == 255 && shape.line.a == 255) ? kLanes : 4;
  for (int first = rows.x0; first < rows.x1; first += kRows) {
    const int count = lesser(kRows, rows.x1 - first);
    Spans all, inside;
    whole.rows(first, surface.width, all);
    if constexpr (kCore) core.rows(first, surface.width, inside);
    for (int i = 0; i < count; ++i) {
      const int x0 = all.x0[i], x1 = all.x1[i], y = first + i;
      if (x0 >= x1) continue;
      std::uint8_t* const row = row_of(surface, y);
      const Lanes dy = static_cast<float>(y) + 0.5f - cy;
      const Lanes along = dy * ay, across = dy * ax;
      // NOLINTNEXTLINE(clang-analyzer-optin.performance.Padding): it vanishes
      const auto paint_group = [=](int x, Lanes centres, const auto& mask) SKERRY_INLINE_LAMBDA {
        const Lanes dx = centres - cx;
        const Lanes d = Lanes(0.5f) - distance(Local{dx * ax + along, across - dx * ay});
        const Lanes cover = mask(max(min(d, 1.0f), 0.0f));
        if (none_positive(cover)) return;
        if constexpr (kOneInk)
          blend(row + 4 * x, cover, rim);
        else
          blend(row + 4 * x, cover, rim, mask(max(min(d - outline, 1.0f), 0.0f)), more);
      };
      if constexpr (kCore) {
        int c0 = inside.x0[i], c1 = inside.x1[i];
        // A few pixels are not worth two ends.
        if (c1 - c0 >= 2 * (group - 1)) {
          // Groups that end where the core begins: it gives up what they overlap.
          c0 += (x0 - c0) & (group - 1);
          c1 -= (c1 - x1) & (group - 1);
          by_lanes(x0, c0, surface.width, paint_group);
          fill_span(surface, y, c0, c1, fill);
          by_lanes(c1, x1, surface.width, paint_group);
          continue;
        }
      }
      by_lanes(x0, x1, surface.width, paint_group);
    }
  }
}

/// @param ey  the shape reaches so far from its centre, up and down [px]
template <class Whole, class Core, class Distance>
SKERRY_INLINE void paint(const Surface& surface, const ShapeInstance& shape, double ey, const Whole& whole,
                         const Core& core, const Distance& distance) {
  const double middle = static_cast<double>(shape.centre[1]);
  const Reach reach{middle - ey, middle + ey};
  if (shape.outline <= 0 || std::memcmp(&shape.fill, &shape.line, sizeof(Color)) == 0)
    paint_rows<true>(surface, shape, reach, whole, core, distance);
  else
    paint_rows<false>(surface, shape, reach, whole, core, distance);
}

SKERRY_INLINE double magnitude(float x) {
  return static_cast<double>(x < 0 ? -x : x);
}
SKERRY_INLINE double extent_x(const ShapeInstance& s, double margin) {
  return magnitude(s.axis[0]) * (static_cast<double>(s.half[0]) + margin) +
         magnitude(s.axis[1]) * (static_cast<double>(s.half[1]) + margin);
}
SKERRY_INLINE double extent_y(const ShapeInstance& s, double margin) {
  return magnitude(s.axis[1]) * (static_cast<double>(s.half[0]) + margin) +
         magnitude(s.axis[0]) * (static_cast<double>(s.half[1]) + margin);
}

inline void paint_disc(const Surface& surface, const ShapeInstance& shape) {
  const double x = static_cast<double>(shape.centre[0]), y = static_cast<double>(shape.centre[1]);
  const double radius = static_cast<double>(shape.radius), outline = static_cast<double>(shape.outline);
  const float r = shape.radius;
  const auto distance = [r](const Local& at)
                            SKERRY_INLINE_LAMBDA { return sqrt(at.x * at.x + at.y * at.y) - r; };
  const double reach = radius + 0.5;
  if (reach < (kLanes == 8 ? kSmall + 1 : kSmall))
    paint(surface, shape, reach, Strip{x - reach, x + reach}, Nothing{}, distance);
  else if (radius - outline < 2 * kLanes - 2)
    paint(surface, shape, reach, Round{x, y, reach}, Nothing{}, distance);
  else
    paint(surface, shape, reach, Round{x, y, reach}, Round{x, y, radius - outline - 0.501}, distance);
}

/// Boxes with round corners; lines are flat ones.
inline void paint_rounded(const Surface& surface, const ShapeInstance& shape) {
  const Frame frame(shape);
  const double hx = static_cast<double>(shape.half[0]), hy = static_cast<double>(shape.half[1]);
  const double radius = static_cast<double>(shape.radius), outline = static_cast<double>(shape.outline);
  if (hx == 0 && hy == 0) return paint_disc(surface, shape);
  const double margin = radius + kRoundMargin;
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
  Convex whole;
  frame.add_box(whole, -hx - margin, hx + margin, hy + margin);
  if (lesser(hx, hy) + inset > 2) {
    Convex core;
    frame.add_box(core, -hx - inset, hx + inset, hy + inset);
    paint(surface, shape, ey, whole, core, distance);
  } else {
    paint(surface, shape, ey, whole, Nothing{}, distance);
  }
}

/// The disc, then its radius line: nothing but a short line.
inline void paint_spoke(const Surface& surface, const ShapeInstance& shape) {
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
  line.radius = 0.5f * greater(shape.outline, 1.0f);
  line.fill = line.line = faded(shape.line, static_cast<double>(lesser(shape.outline, 1.0f)));
  paint_rounded(surface, line);
}

/// Sharp polygons of at most kEdges corners: the largest of the distances to the lines through the edges.
template <std::size_t kEdges>
void paint_convex(const Surface& surface, const ShapeInstance& shape, const float* edges) {
  const Frame frame(shape);
  const double outline = static_cast<double>(shape.outline), margin = kSharpMargin;
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
  Convex whole, core;
  frame.add_box(whole, -hx - margin, hx + margin, hy + margin);
  for (std::size_t i = 0; i < shape.count; ++i) {
    const double u = static_cast<double>(e.x[i]), v = static_cast<double>(e.y[i]),
                 offset = static_cast<double>(e.offset[i]);
    frame.add(whole, u, v, offset + 0.5);
    frame.add(core, u, v, offset - outline - 0.501);
  }
  paint(surface, shape, ey, whole, core, distance);
}

/// Rounded polygons: distance to the edges, inside by the side of all of them.
inline void paint_polygon(const Surface& surface, const ShapeInstance& shape, const float* edges) {
  const Frame frame(shape);
  const double margin = kRoundMargin + static_cast<double>(shape.radius);
  const double hx = static_cast<double>(shape.half[0]), hy = static_cast<double>(shape.half[1]);
  Convex whole, core;
  frame.add_box(whole, -hx - margin, hx + margin, hy + margin);
  // Where all edges are parallel they leave it open at the ends.
  frame.add_box(core, -hx, hx, hy);
  const double depth =
      lesser(static_cast<double>(shape.radius) - static_cast<double>(shape.outline) - 0.501, 0.0);
  struct Edge {
    float x, y, ex, ey, inverse;
  };
  Edge list[64];
  const std::uint32_t count = lesser<std::uint32_t>(shape.count, 64);
  for (std::uint32_t i = 0; i < count; ++i) {
    const float* e = edges + 4 * i;
    list[i] = {e[0], e[1], e[2], e[3], 1 / greater(e[2] * e[2] + e[3] * e[3], 1e-12f)};
    const double ex = static_cast<double>(e[2]), ey = static_cast<double>(e[3]), length = ::hypot(ex, ey);
    if (length > 0)
      frame.add(core, ey / length, -ex / length,
                (static_cast<double>(e[0]) * ey - static_cast<double>(e[1]) * ex) / length + depth);
  }
  const float r = shape.radius;
  const Edge* const edge = list;
  const auto distance = [edge, count, r](const Local& at) SKERRY_INLINE_LAMBDA {
    Lanes square(1e30f), side(-1e30f);
    for (std::uint32_t i = 0; i < count; ++i) {
      const Edge& e = edge[i];
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
inline void paint_arrow(const Surface& surface, const ShapeInstance& arrow) {
  ShapeInstance shape = arrow;
  shape.outline = 0;
  const Frame frame(shape);
  const float half = arrow.half[0], wide = arrow.half[1], head = arrow.outline, r = arrow.radius;
  const float back = half - head, left = lesser(-half + r, back), joint = back + 0.25f * head;
  const float slope = ::sqrtf(wide * wide + head * head), nx = wide / slope, ny = head / slope;
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
  // Rows of a box in the frame of the arrow, with a hair to spare.
  const auto rows_of = [&](double from, double to, double high) {
    const double a = frame.y + from * frame.ay, b = frame.y + to * frame.ay,
                 more = (frame.ax < 0 ? -high : high) * frame.ax + 0.01;
    return Reach{lesser(a, b) - more, greater(a, b) + more};
  };
  const double point = offset / u, base = (offset - u * seam) / v;
  const Reach head_rows = rows_of(seam, point, base);
  if (all_head) return paint_rows<true>(surface, shape, head_rows, triangle, Nothing{}, tip);
  const double tail = lesser(-static_cast<double>(half), static_cast<double>(back)) - 0.5625;
  const double thick = static_cast<double>(r) + 0.5625;
  Convex box;
  frame.add_box(box, tail, seam, thick);
  paint_rows<true>(surface, shape, rows_of(tail, seam, thick), box, Nothing{}, shaft);
  paint_rows<true>(surface, shape, head_rows, triangle, Nothing{},
                   [=](const Local& at) SKERRY_INLINE_LAMBDA { return min(shaft(at), tip(at)); });
}

/// One instance of any program but Text. @param corners of ShapeBatches
inline void paint_shape(const Surface& surface, Program program, const ShapeInstance& shape,
                        const float* corners) {
  const float* edges = corners + std::size_t{4} * shape.first;
  if (program == Program::Arrow) return paint_arrow(surface, shape);
  if (program == Program::Spoke) return paint_spoke(surface, shape);
  if (shape.count == 0) return paint_rounded(surface, shape);
  if (program == Program::Polygon) return paint_polygon(surface, shape, edges);
  shape.count <= 4 ? paint_convex<4>(surface, shape, edges) : paint_convex<8>(surface, shape, edges);
}

}  // namespace SKERRY_LANES
}  // namespace skerry::render
