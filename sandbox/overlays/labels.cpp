// SPDX-License-Identifier: MIT
#include "sandbox/overlays/labels.h"

#include <algorithm>

#include "render/gl_renderer.h"

namespace skerry::sandbox {

bool LabelPlacer::add(Vec2 at, const std::string& text, render::Color color, render::Anchor first) {
  const render::Point px = camera_.to_pixels(to_point(at));
  const double size = style_.small_text_px;
  const double width = render::text_width(text, size) * scale_, height = 1.1 * size * scale_;
  using render::Anchor;
  for (const float offset : {10.0f, 26.0f}) {
    const double gap = static_cast<double>(offset) * scale_;
    for (const Anchor anchor : {first, Anchor::Right, Anchor::Left, Anchor::Above, Anchor::Below}) {
      double x = px.x - 0.5 * width, y = px.y - 0.5 * height;
      if (anchor == Anchor::Right) x = px.x + gap;
      if (anchor == Anchor::Left) x = px.x - gap - width;
      if (anchor == Anchor::Above) y = px.y - gap - height;
      if (anchor == Anchor::Below) y = px.y + gap;
      const Box box{x - 2, y - 2, x + width + 2, y + height + 2};
      const bool covered = std::any_of(taken_.begin(), taken_.end(), [&](const Box& other) {
        return box.left < other.right && other.left < box.right && box.top < other.bottom &&
               other.top < box.bottom;
      });
      if (covered) continue;
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
