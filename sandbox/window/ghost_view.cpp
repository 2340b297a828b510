// SPDX-License-Identifier: MIT
#include "sandbox/window/ghost_view.h"

#include "sandbox/scene_view.h"

namespace skerry::sandbox {
void draw_ghost(const World& world, const render::Style& style, render::DrawList& list) {
  const BodyArrays& bodies = world.bodies();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies.alive[i] && bodies.type[i] == BodyType::Dynamic)
      draw_outline(world, i, bodies.pose(i), bodies.angle[i], style.warning, 1.6f,
                   list[render::Layer::Structure]);
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
  draw_outline(world, body.index, world.pose(body), world.angle(body), style.selected.outline, 3.0f,
               list[render::Layer::Structure]);
}

}  // namespace skerry::sandbox
