// SPDX-License-Identifier: MIT
//
// From draw lists to instances in pixels: the part of the renderer that needs no GL.
#pragma once

#include <cstdint>
#include <vector>

#include "render/camera.h"
#include "render/draw_list.h"
#include "render/glyphs.h"

namespace skerry::render {

/// One quad: a box of half extents `half` around `centre`, turned by `axis`, grown by `radius`; all in
/// pixels, y down. Discs, capsules and lines are boxes whose extents vanish.
struct ShapeInstance {
  float centre[2];
  float axis[2];  ///< unit vector of the box's x
  float half[2];
  float radius;
  float outline;
  Color fill, line;
  std::uint32_t first, count;  ///< polygons: corners in the box's frame; else count is 0
};

struct GlyphInstance {
  float corner[2];         ///< top left [px]
  std::uint16_t texel[2];  ///< in the atlas
  std::uint16_t size[2];   ///< [px]
  Color color;
  std::uint32_t channel;  ///< 0: coverage, 1: halo
};

/// Rounded: boxes. Spoke: discs with a radius line, its direction in `half`. Convex4, Convex8: sharp polygons
/// with so many corners. Polygon: all others. Arrow: the length of the head in `outline`.
enum class Program : std::uint8_t { Rounded, Spoke, Convex4, Convex8, Polygon, Arrow, Text };
inline constexpr int kProgramCount = 7;

/// Distance of the lines of a label [em].
inline constexpr double kLineSpacing = 1.3;

/// How far from its box a shape is drawn [px]. Round rims are shaded half a pixel outside, here with room for
/// the rounding of corners; sharp corners of polygons reach farther.
constexpr double margin_px(Program program) {
  const bool sharp = program == Program::Convex4 || program == Program::Convex8;
  return sharp ? 1 : 0.5625;
}

/// Instances first..first+count of one program, in drawing order.
struct Batch {
  Program program;
  std::uint32_t first, count;
  bool points = false;  ///< each is one square; never for arrows and text
};

/// A frame's instances, in order. Reused from frame to frame.
struct ShapeBatches {
  std::vector<ShapeInstance> shapes;
  /// Four numbers for each edge of a polygon [px]. Convex4 and Convex8: the outer normal, its product with a
  /// corner, 0. Polygon: a corner, the edge to the next.
  std::vector<float> corners;
  std::vector<GlyphInstance> glyphs;
  std::vector<Batch> batches;
  int culled = 0;
  /// Side of the largest square that the driver draws as a point [px].
  double largest_point = 1;

  /// Fills all of the above.
  /// @param ssaa  pixels of the fine picture per pixel of the camera
  /// @param first_layer, last_layer  all of `first_layer` to before `last_layer`
  void build(const DrawList& list, const Camera& camera, int ssaa, GlyphAtlas& atlas, int first_layer = 0,
             int last_layer = kLayerCount);

 private:
  void add_layer(const DrawLayer& layer);
  void add_polygon(const DrawLayer& layer, const Polygon& polygon);
  void add_line(Point from, Point to, double width, Color color, double dash);
  void add_spoke(Point centre, double radius, const Disc& disc, double outline);
  void add_arrow(const Arrow& arrow);
  bool add_labels(const std::vector<Label>& labels, GlyphAtlas& atlas);
  void add_box(Point centre, Point axis, double hx, double hy, double radius, double outline, Color fill,
               Color line);
  void push(Program program, const ShapeInstance& shape);
  bool is_point(Program program, const ShapeInstance& shape) const;
  void split_points();

  Camera camera_;
  double scale_ = 1;                           // fine pixels per metre
  double px_ = 1;                              // fine pixels per pixel of the style
  double width_ = 0, height_ = 0, reach_ = 0;  // of the fine picture [px]; half of its diagonal
  Point middle_;                               // of the fine picture [px]
  Point to_px(Point world) const {
    return {middle_.x + (world.x - camera_.centre.x) * scale_,
            middle_.y - (world.y - camera_.centre.y) * scale_};
  }
};

}  // namespace skerry::render
