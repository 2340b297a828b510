// SPDX-License-Identifier: MIT
#include "render/draw_list.h"

#include <stdexcept>

namespace skerry::render {

void DrawLayer::clear() {
  discs.clear();
  polygons.clear();
  points.clear();
  capsules.clear();
  lines.clear();
  arrows.clear();
  markers.clear();
  labels.clear();
}

void DrawLayer::polygon(const Point* corners, std::size_t count, Color fill, Color outline, double rounding,
                        float outline_px) {
  if (count < 3 || count > 64) {
    throw std::invalid_argument("polygon: expected 3 to 64 corners, got " + std::to_string(count));
  }
  const auto first = static_cast<std::uint32_t>(points.size());
  points.insert(points.end(), corners, corners + count);
  polygons.push_back({first, static_cast<std::uint32_t>(count), rounding, fill, outline, outline_px});
}

void DrawList::clear() {
  for (DrawLayer& layer : layers) layer.clear();
}

}  // namespace skerry::render
