// SPDX-License-Identifier: MIT
#include "sandbox/window/ghost_view.h"

#include "sandbox/scene_view.h"

namespace skerry::sandbox {
namespace {

void outline(const World& world, std::size_t body, render::Color color, float width_px,
             render::DrawLayer& layer) {
  const render::Color clear = render::faded(color, 0);
  const Transform pose = world.bodies().pose(body);
  for (const ShapeRecord& record : world.shapes()) {
    if (!record.alive || record.body.index != body) continue;
    const Shape& shape = record.shape;
    if (shape.kind == ShapeKind::Disc) {
      layer.discs.push_back({.centre = to_point(to_world(pose, shape.vertices.front())),
                             .radius = shape.radius,
                             .fill = clear,
                             .outline = color,
                             .outline_px = width_px,
                             .angle = world.bodies().angle[body],
                             .spoke = true});
    } else if (shape.kind == ShapeKind::Capsule) {
      layer.capsules.push_back({.from = to_point(to_world(pose, shape.vertices[0])),
                                .to = to_point(to_world(pose, shape.vertices[1])),
                                .radius = shape.radius,
                                .fill = clear,
                                .outline = color,
                                .outline_px = width_px});
    } else if (shape.kind == ShapeKind::Polygon) {
      std::vector<render::Point> corners;
      for (const Vec2 corner : shape.vertices) corners.push_back(to_point(to_world(pose, corner)));
      layer.polygon(corners.data(), corners.size(), clear, color, shape.radius, width_px);
    }
  }
}

}  // namespace

void draw_ghost(const World& world, const render::Style& style, render::DrawList& list) {
  const BodyArrays& bodies = world.bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies.alive[i] && bodies.type[i] == BodyType::Dynamic)
      outline(world, i, style.warning, 1.6f, list[render::Layer::Structure]);
  }
}

void draw_hand(const World& world, const Hand& hand, const render::Style& style, render::DrawList& list) {
  if (!hand.holds() || !world.alive(hand.body())) return;
  const render::Point grip = to_point(hand.grip(world)), target = to_point(hand.target());
  render::DrawLayer& layer = list[render::Layer::Contacts];
  layer.lines.push_back(
      {.from = grip, .to = target, .color = style.force, .width_px = 2.2f, .dash_px = 5.0f});
  layer.markers.push_back({.at = grip, .fill = style.force, .outline = style.background, .radius_px = 4.5f});
  layer.markers.push_back(
      {.at = target, .fill = render::faded(style.force, 0.25), .outline = style.force, .radius_px = 7.0f});
}

void draw_selection(const World& world, BodyId body, const render::Style& style, render::DrawList& list) {
  if (!body || !world.alive(body)) return;
  outline(world, body.index, style.selected.outline, 3.0f, list[render::Layer::Structure]);
}

}  // namespace skerry::sandbox
