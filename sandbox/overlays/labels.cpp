// SPDX-License-Identifier: MIT
#include "sandbox/overlays/labels.h"

#include <algorithm>
#include <cmath>

#include "render/gl_renderer.h"

namespace skerry::sandbox {

bool LabelPlacer::covered(const Box& box) const {
  return std::any_of(taken_.begin(), taken_.end(), [&](const Box& other) {
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

bool LabelPlacer::add(Vec2 at, const std::string& text, render::Color color,
                      std::initializer_list<render::Anchor> sides, float nearest) {
  const render::Point px = camera_.to_pixels(to_point(at));
  const double size = style_.small_text_px;
  const double width = render::text_width(text, size) * scale_, height = 1.1 * size * scale_;
  using render::Anchor;
  for (const float offset : {nearest, nearest + 16}) {
    const double gap = static_cast<double>(offset) * scale_;
    for (const Anchor anchor : sides) {
      double x = px.x - 0.5 * width, y = px.y - 0.5 * height;
      if (anchor == Anchor::Right) x = px.x + gap;
      if (anchor == Anchor::Left) x = px.x - gap - width;
      if (anchor == Anchor::Above) y = px.y - gap - height;
      if (anchor == Anchor::Below) y = px.y + gap;
      const Box box{x - 2, y - 2, x + width + 2, y + height + 2};
      if (covered(box)) continue;
      taken_.push_back(box);
      layer_.labels.push_back({.at = to_point(at),
                               .text = text,
                               .color = color,
                               .halo = style_.halo,
                               .size_px = style_.small_text_px,
                               .anchor = anchor,
                               .offset_px = offset});
      return true;
    }
  }
  return false;
}

}  // namespace skerry::sandbox
