// SPDX-License-Identifier: MIT
//
// A picture as data, in world units: what to draw, not how. The sandbox fills it; the GL renderer, the SVG
// writer, the hash and the golden tests read it. Later items are drawn over earlier ones, layer by layer.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace skerry::render {

/// World coordinates [m], y upwards, in double: the renderer subtracts the camera before it rounds to float.
struct Point {
  double x = 0;
  double y = 0;
  friend bool operator==(const Point&, const Point&) = default;
};

/// Straight (not premultiplied) sRGB colour.
struct Color {
  std::uint8_t r = 0, g = 0, b = 0, a = 255;
  friend bool operator==(Color, Color) = default;
};

enum class Layer : std::uint8_t { Background, Bodies, Structure, Contacts, Labels };
inline constexpr int kLayerCount = 5;

/// Filled and outlined shapes. Outline widths and the radii of markers are in pixels (of a 720-line picture;
/// the renderer scales them with the height), so that they read the same at every zoom.
struct Disc {
  Point centre;
  double radius = 0;  ///< [m]
  Color fill, outline;
  float outline_px = 1.5f;
  double angle = 0;    ///< of the spoke [rad]
  bool spoke = false;  ///< draw a radius line so that turning can be seen

  friend bool operator==(const Disc&, const Disc&) = default;
};

/// Convex polygon, 3 to 64 corners counter-clockwise, grown by `rounding`.
struct Polygon {
  std::uint32_t first = 0, count = 0;  ///< in DrawLayer::points
  double rounding = 0;                 ///< [m]
  Color fill, outline;
  float outline_px = 1.5f;
  friend bool operator==(const Polygon&, const Polygon&) = default;
};

/// A segment grown by a radius in world units.
struct Capsule {
  Point from, to;
  double radius = 0;  ///< [m]
  Color fill, outline;
  float outline_px = 1.5f;
  friend bool operator==(const Capsule&, const Capsule&) = default;
};

/// A line of constant width in pixels, round ends, optionally dashed.
struct Line {
  Point from, to;
  Color color;
  float width_px = 1.5f;
  float dash_px = 0;  ///< length of dash and gap; 0: solid
  friend bool operator==(const Line&, const Line&) = default;
};

/// A line with a head at `to`. Shorter than its head it shrinks as a whole.
struct Arrow {
  Point from, to;
  Color color;
  float width_px = 2.5f;
  float head_px = 10;
  friend bool operator==(const Arrow&, const Arrow&) = default;
};

/// A dot of constant size in pixels.
struct Marker {
  Point at;
  Color fill, outline;
  float radius_px = 4;
  friend bool operator==(const Marker&, const Marker&) = default;
};

enum class Anchor : std::uint8_t { Centre, Left, Right, Above, Below };

/// Text of constant size in pixels, on a halo of `halo` so that it reads over anything.
struct Label {
  Point at;
  std::string text;
  Color color, halo;
  float size_px = 15;
  Anchor anchor = Anchor::Centre;
  float offset_px = 6;  ///< distance from `at` in the direction of the anchor
  friend bool operator==(const Label&, const Label&) = default;
};

struct DrawLayer {
  std::vector<Disc> discs;
  std::vector<Polygon> polygons;
  std::vector<Point> points;  ///< corners of the polygons
  std::vector<Capsule> capsules;
  std::vector<Line> lines;
  std::vector<Arrow> arrows;
  std::vector<Marker> markers;
  std::vector<Label> labels;

  void clear();
  friend bool operator==(const DrawLayer&, const DrawLayer&) = default;

  void polygon(const Point* corners, std::size_t count, Color fill, Color outline, double rounding = 0,
               float outline_px = 1.5f);
};

/// Within a layer the order is: polygons, capsules, discs, lines, arrows, markers, labels.
struct DrawList {
  Color background{255, 255, 255, 255};
  DrawLayer layers[kLayerCount];

  DrawLayer& operator[](Layer layer) { return layers[static_cast<int>(layer)]; }
  const DrawLayer& operator[](Layer layer) const { return layers[static_cast<int>(layer)]; }
  void clear();

  /// Equal lists make equal pictures: a capture may repeat the last frame instead of drawing it again.
  friend bool operator==(const DrawList&, const DrawList&) = default;
};

}  // namespace skerry::render
