// SPDX-License-Identifier: MIT
#include "render/camera.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace skerry::render {

void Camera::zoom_at(Point pixel, double factor) {
  if (!(factor > 0) || !std::isfinite(factor)) {
    throw std::invalid_argument("zoom factor must be positive, got " + std::to_string(factor));
  }
  const Point fixed = to_world(pixel);
  height /= factor;
  const Point moved = to_world(pixel);
  centre.x += fixed.x - moved.x;
  centre.y += fixed.y - moved.y;
}

void Camera::pan(double dx_px, double dy_px) {
  centre.x -= dx_px / pixels_per_metre();
  centre.y += dy_px / pixels_per_metre();
}

void Camera::frame(Point low, Point high, double margin) {
  const double share = 1 - 2 * std::clamp(margin, 0.0, 0.45);
  const double wide = std::max(high.x - low.x, 0.0), tall = std::max(high.y - low.y, 0.0);
  centre = {0.5 * (low.x + high.x), 0.5 * (low.y + high.y)};
  height = std::max(tall, wide * height_px / width_px) / share;
  if (!(height > 0)) height = 1;
}

void Camera::validate() const {
  const bool sizes = width_px >= 1 && width_px <= 32768 && height_px >= 1 && height_px <= 32768;
  if (sizes && std::isfinite(centre.x) && std::isfinite(centre.y) && std::isfinite(height) && height > 0)
    return;
  std::ostringstream text;
  text << "camera: needs a finite centre, a positive height and 1 to 32768 pixels a side, got centre ("
       << centre.x << ", " << centre.y << ") m, height " << height << " m, " << width_px << " x " << height_px
       << " px";
  throw std::invalid_argument(text.str());
}

}  // namespace skerry::render
