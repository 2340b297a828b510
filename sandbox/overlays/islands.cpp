// SPDX-License-Identifier: MIT
//
// One hue for each island of bodies that are solved together, with its convex hull.
#include <algorithm>
#include <map>

#include "sandbox/layout.h"
#include "sandbox/overlays/labels.h"
#include "sandbox/overlays/registry.h"
#include "sandbox/scene_view.h"

namespace skerry::sandbox {
namespace {

// Andrew's monotone chain [Andrew 1979].
std::vector<Vec2> convex_hull(std::vector<Vec2> points) {
  std::sort(points.begin(), points.end(),
            [](Vec2 a, Vec2 b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  std::vector<Vec2> hull;
  const auto add = [&](Vec2 p, std::size_t floor) {
    while (hull.size() >= floor + 2 && cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0)
      hull.pop_back();
    hull.push_back(p);
  };
  for (const Vec2 p : points) add(p, 0);
  const std::size_t lower = hull.size() - 1;
  for (std::size_t i = points.size() - 1; i-- > 0;) add(points[i], lower);
  if (hull.size() > 1) hull.pop_back();
  return hull;
}

std::vector<Vec2> outline_points(const ShapeRecord& record, const Transform& pose) {
  const Shape& shape = record.shape;
  std::vector<Vec2> points;
  for (const Vec2 vertex : shape.vertices) {
    const Vec2 p = to_world(pose, vertex);
    if (shape.radius <= 0) {
      points.push_back(p);
      continue;
    }
    constexpr int kRound = 16;
    for (int k = 0; k < kRound; ++k) {
      const SinCos sc = sin_cos(2 * kPi * k / kRound);
      points.push_back(p + shape.radius * Vec2{sc.cos, sc.sin});
    }
  }
  return points;
}

}  // namespace

void draw_islands(const OverlayContext& context, render::DrawList& list) {
  const BodyArrays& bodies = context.world.bodies();
  std::map<int, std::vector<Vec2>> points;
  for (const ShapeRecord& shape : context.world.shapes()) {
    if (!shape.alive) continue;
    const std::size_t body = shape.body.index;
    if (bodies.island[body] < 0) continue;
    const std::vector<Vec2> outline = outline_points(shape, context.demo.shown(body).pose());
    std::vector<Vec2>& all = points[bodies.island[body]];
    all.insert(all.end(), outline.begin(), outline.end());
  }
  render::DrawLayer& layer = list[render::Layer::Structure];
  for (const auto& [island, all] : points) {
    const render::Paint& paint = render::body_paint(context.style, island + 1);
    std::vector<render::Point> corners;
    for (const Vec2 corner : convex_hull(all)) corners.push_back(to_point(corner));
    // More than 64 corners would be finer than a pixel at any size that fits into the picture.
    if (corners.size() < 3 || corners.size() > 64) continue;
    // The number that the inspector and the matrix call it by, above its highest side.
    double top = corners[0].y, left = corners[0].x, right = left;
    const double same = 1e-3 * context.camera.height;
    for (const render::Point p : corners) {
      if (p.y < top - same) continue;
      left = p.y > top + same ? p.x : std::min(left, p.x);
      right = p.y > top + same ? p.x : std::max(right, p.x);
      top = std::max(top, p.y);
    }
    context.labels.add(
        {0.5 * (left + right), top}, std::to_string(island + 1), paint.outline,
        {render::Anchor::Above, render::Anchor::Right, render::Anchor::Left, render::Anchor::Below});
    layer.polygon(corners.data(), corners.size(), render::faded(paint.fill, 0.35), paint.outline, 0,
                  1.5f * context.style.outline_px);
  }
  const render::Paint& sample = render::body_paint(context.style, 1);
  context.legend.swatch({render::faded(sample.fill, 0.35), sample.outline},
                        std::to_string(points.size()) + (points.size() == 1 ? " island" : " islands"));
}

}  // namespace skerry::sandbox
