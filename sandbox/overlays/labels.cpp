// SPDX-License-Identifier: MIT
#include "sandbox/overlays/labels.h"

#include <algorithm>
#include <cmath>

#include "render/gl_renderer.h"

namespace skerry::sandbox {

bool LabelPlacer::covered(const PixelBox& box) const {
  if (box.left < 0 || box.top < 0 || box.right > camera_.width_px || box.bottom > camera_.height_px)
    return true;
  return std::any_of(taken_.begin(), taken_.end(), [&](const PixelBox& other) {
    return box.left < other.right && other.left < box.right && box.top < other.bottom &&
           other.top < box.bottom;
  });
}

void LabelPlacer::avoid(Vec2 from, Vec2 to) {
  // A chain of small boxes along the line.
  constexpr double kStep = 6, kHalf = 3;
  const render::Point a = camera_.to_pixels(to_point(from)), b = camera_.to_pixels(to_point(to));
  const double length = std::hypot(b.x - a.x, b.y - a.y);
  const int boxes = 1 + static_cast<int>(std::min(length / (kStep * scale_), 1000.0));
  for (int i = 0; i <= boxes; ++i) {
    const double x = a.x + (b.x - a.x) * i / boxes, y = a.y + (b.y - a.y) * i / boxes;
    const double half = kHalf * scale_;
    taken_.push_back({x - half, y - half, x + half, y + half});
  }
}

void LabelPlacer::shun(Vec2 from, Vec2 to) {
  lines_.emplace_back(camera_.to_pixels(to_point(from)), camera_.to_pixels(to_point(to)));
}

bool LabelPlacer::crossed(const PixelBox& box) const {
  // The part of the line within both pairs of sides [Liang and Barsky 1984].
  return std::any_of(lines_.begin(), lines_.end(), [&](const std::pair<render::Point, render::Point>& line) {
    const auto& [a, b] = line;
    double begin = 0, end = 1;
    const auto clip = [&](double from, double along, double low, double high) {
      if (along == 0) return from > low && from < high;
      const double t0 = (low - from) / along, t1 = (high - from) / along;
      begin = std::max(begin, std::min(t0, t1));
      end = std::min(end, std::max(t0, t1));
      return begin < end;
    };
    return clip(a.x, b.x - a.x, box.left, box.right) && clip(a.y, b.y - a.y, box.top, box.bottom);
  });
}

bool LabelPlacer::add(Vec2 at, const std::string& text, render::Color color,
                      std::initializer_list<render::Anchor> sides, float nearest) {
  std::vector<Place> places;
  for (const float offset : {nearest, nearest + 16})
    for (const render::Anchor side : sides) places.push_back({side, offset});
  return add(at, text, color, places);
}

bool LabelPlacer::add_off_edges(Vec2 at, const std::string& text, render::Color color) {
  using render::Anchor;
  std::vector<Place> places{{Anchor::Below, 8}, {Anchor::Above, 8}};
  // Under a slope there is room only farther off.
  for (const float down : {14.0f, -14.0f, 30.0f, -30.0f, 46.0f, -46.0f})
    for (const Anchor side : {Anchor::Right, Anchor::Left}) places.push_back({side, 8, down});
  for (const Anchor side : {Anchor::Right, Anchor::Left}) places.push_back({side, 10});
  return add(at, text, color, places);
}

bool LabelPlacer::add(Vec2 at, const std::string& text, render::Color color,
                      const std::vector<Place>& places) {
  const render::Point px = camera_.to_pixels(to_point(at));
  const double size = style_.small_text_px;
  const double width = render::text_width(text, size) * scale_, height = 1.1 * size * scale_;
  using render::Anchor;
  for (const bool strict : {true, false}) {
    for (const Place& place : places) {
      const double gap = static_cast<double>(place.offset) * scale_;
      const double middle = px.y + static_cast<double>(place.down) * scale_;
      double x = px.x - 0.5 * width, y = middle - 0.5 * height;
      if (place.anchor == Anchor::Right) x = px.x + gap;
      if (place.anchor == Anchor::Left) x = px.x - gap - width;
      if (place.anchor == Anchor::Above) y = middle - gap - height;
      if (place.anchor == Anchor::Below) y = middle + gap;
      const PixelBox box{x - 2, y - 2, x + width + 2, y + height + 2};
      if (covered(box) || (strict && crossed(box))) continue;
      taken_.push_back(box);
      layer_.labels.push_back({.at = place.down == 0 ? to_point(at) : camera_.to_world({px.x, middle}),
                               .text = text,
                               .color = color,
                               .halo = style_.halo,
                               .size_px = style_.small_text_px,
                               .anchor = place.anchor,
                               .offset_px = place.offset});
      return true;
    }
  }
  return false;
}

}  // namespace skerry::sandbox
