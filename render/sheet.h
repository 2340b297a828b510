// SPDX-License-Identifier: MIT
//
// A flat picture as data, in pixels: panels, plots, tables. The sandbox fills it; ImGui draws it in captures
// and in the window, the SVG writer puts it into figures.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "render/draw_list.h"

struct ImDrawList;

namespace skerry::render {

class UiHost;

/// The fonts of panels.
enum class Face : std::uint8_t { Regular, Bold, Title, Mono };

/// Where a text stands relative to its point: the point is the upper left, upper middle or upper right
/// corner.
enum class Align : std::uint8_t { Left, Centre, Right };

enum class MarkKind : std::uint8_t { Rect, Fill, Stroke, Text };

/// One mark of a sheet. Rect: two corners; a width above 0 draws its frame only. Fill: a convex polygon.
/// Stroke: a polyline. Text: one point.
struct Mark {
  MarkKind kind{};
  Face face{};
  Align align{};
  Color color;
  float width = 0;                     ///< of the stroke, or height of the text's line [px]
  float rounding = 0;                  ///< of a rectangle's corners [px]
  std::uint32_t first = 0, count = 0;  ///< points; for texts the point and then `length` characters
  std::uint32_t begin = 0, length = 0;
  friend bool operator==(const Mark&, const Mark&) = default;
};

/// A point in pixels, y down.
struct Pixel {
  float x = 0, y = 0;
  friend bool operator==(Pixel, Pixel) = default;
};

/// Marks in drawing order. Equal sheets make equal pictures.
class Sheet {
 public:
  void clear();
  void rect(Pixel low, Pixel high, Color fill, float rounding = 0);
  void frame(Pixel low, Pixel high, Color color, float width, float rounding = 0);
  void line(Pixel from, Pixel to, Color color, float width);
  void polyline(const Pixel* points, std::size_t count, Color color, float width);
  /// @param points  convex, 3 or more
  void fill(const Pixel* points, std::size_t count, Color color);
  /// @param line_px  height of a line of text, ascent to descent
  void text(Pixel at, std::string_view words, Color color, float line_px, Face face = Face::Regular,
            Align align = Align::Left);

  std::size_t size() const { return marks_.size(); }
  const std::vector<Mark>& marks() const { return marks_; }
  const Pixel* points(const Mark& mark) const { return points_.data() + mark.first; }
  std::string_view words(const Mark& mark) const {
    return std::string_view(text_).substr(mark.begin, mark.length);
  }

  friend bool operator==(const Sheet&, const Sheet&) = default;

 private:
  Mark& add(MarkKind kind, const Pixel* points, std::size_t count, Color color, float width);

  std::vector<Mark> marks_;
  std::vector<Pixel> points_;
  std::string text_;
};

/// Height of capitals and of the line above the baseline, as shares of a line of text (DejaVu Sans).
inline constexpr double kSheetAscent = 0.7972;
/// Em size of a line of text, as a share of its height.
inline constexpr double kSheetEm = 0.8591;

/// Draws marks first..last with ImGui.
void draw_sheet(const Sheet& sheet, std::size_t first, std::size_t last, const UiHost& ui, ImDrawList& out);

}  // namespace skerry::render
