// SPDX-License-Identifier: MIT
//
// From a world to a picture: the only place, with the overlays, where physics and drawing meet.
#pragma once

#include "render/draw_list.h"
#include "sandbox/overlays/overlay.h"

namespace skerry::sandbox {

/// Draws a metre grid, all shapes and all joints.
void draw_world(const OverlayContext& context, render::DrawList& list);

/// The outlines of a body's bounded shapes at a pose. @param angle  of the spoke [rad]
void draw_outline(const World& world, std::size_t body, const Transform& pose, double angle,
                  render::Color color, float width_px, render::DrawLayer& layer);

inline render::Point to_point(Vec2 v) {
  return {v.x, v.y};
}

/// Where a contact point of the last step's end is at the moment that is shown: it goes with the body that
/// moves.
Vec2 shown_point(const OverlayContext& context, const ContactReport& contact, Vec2 point);

/// Colours of a body: static ones are ground, others as the script says.
render::Paint paint_of(const OverlayContext& context, std::size_t body);

}  // namespace skerry::sandbox
