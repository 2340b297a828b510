// SPDX-License-Identifier: MIT
//
// Contact points and normals. Full points carry an impulse, hollow ones only come near.
#include <algorithm>
#include <cmath>
#include <vector>

#include "sandbox/layout.h"
#include "sandbox/overlays/labels.h"
#include "sandbox/overlays/panel.h"
#include "sandbox/overlays/registry.h"
#include "sandbox/scene_view.h"

namespace skerry::sandbox {
namespace {

constexpr double kNormalPx = 26;  // long enough to show a direction, shorter than most bodies

/// Length of the arrows of normals [m].
double normal_length(const OverlayContext& context) {
  return kNormalPx * render::ui_scale(context.camera.height_px) / context.camera.pixels_per_metre();
}

void add_contact(const OverlayContext& context, Vec2 point, Vec2 normal, bool loaded, double brightness,
                 render::DrawLayer& layer) {
  const render::Style& style = context.style;
  layer.arrows.push_back({.from = to_point(point),
                          .to = to_point(point + normal_length(context) * normal),
                          .color = render::faded(style.normal, brightness),
                          .width_px = style.normal_px,
                          .head_px = 0.6f * style.arrow_head_px});
  layer.markers.push_back({.at = to_point(point),
                           .fill = render::faded(loaded ? style.contact : style.background, brightness),
                           .outline = render::faded(style.contact, brightness),
                           .radius_px = style.contact_px});
}

// "N 12.3 N, T 4 N": what acts at a contact point; impulses while an impact is in the step; else the gap.
std::string value_text(const OverlayContext& context, const ContactPointReport& point) {
  const double h = context.world.report().h;
  if (point.impact_impulse > 0) return si(point.impact_impulse, "N s");
  const double normal = h > 0 ? point.normal_impulse / h : 0,
               friction = h > 0 ? point.friction_impulse / h : 0;
  const double floor = context.history.force_floor(context.world);
  if (normal <= floor) return "gap " + si(point.separation, "m");
  std::string text = si(normal, "N");
  if (std::abs(friction) > floor) text += ", friction " + si(std::abs(friction), "N");
  return text;
}

bool is_selected(const Selection& selection, const ContactReport& contact) {
  const auto has = [&](BodyId body) { return contact.body_a == body || contact.body_b == body; };
  return selection.body && has(selection.body) && (!selection.other || has(selection.other));
}

// Values stay off the outlines of the bodies that touch, the surface they stand on among them.
void shun_outline(const OverlayContext& context, const ShapeRecord& record) {
  const Transform pose = context.demo.shown(record.body.index).pose();
  const Shape& shape = record.shape;
  const auto line = [&](Vec2 from, Vec2 to) {
    context.labels.shun(to_world(pose, from), to_world(pose, to));
  };
  const auto arc = [&](Vec2 centre, double radius) {
    constexpr int kSides = 24;
    Vec2 last = centre + Vec2{radius, 0};
    for (int k = 1; k <= kSides; ++k) {
      const SinCos sc = sin_cos(2 * kPi * k / kSides);
      const Vec2 next = centre + radius * Vec2{sc.cos, sc.sin};
      line(last, next);
      last = next;
    }
  };
  const std::size_t n = shape.vertices.size();
  switch (shape.kind) {
    case ShapeKind::Disc:
      return arc(shape.vertices[0], shape.radius);
    case ShapeKind::HalfPlane: {
      // As far as the picture goes.
      const double far = 2 * (context.camera.height + context.camera.width());
      const Vec2 along = perp(shape.normals[0]);
      const Vec2 centre = to_local(pose, Vec2{context.camera.centre.x, context.camera.centre.y});
      const Vec2 foot = shape.vertices[0] + dot(centre - shape.vertices[0], along) * along;
      return line(foot - far * along, foot + far * along);
    }
    case ShapeKind::Capsule:
    case ShapeKind::Polygon:
    case ShapeKind::Chain:
      for (std::size_t i = 0; i < shape.normals.size(); ++i) {
        const Vec2 out = shape.radius * shape.normals[i];
        line(shape.vertices[i] + out, shape.vertices[(i + 1) % n] + out);
      }
  }
}

void shun_outlines(const OverlayContext& context) {
  std::vector<BodyId> bodies;
  for (const ContactReport& contact : context.world.report().contacts_list) {
    if (!is_selected(context.selection, contact)) continue;
    bodies.push_back(contact.body_a);
    bodies.push_back(contact.body_b);
    // Nor on the point of another value, nor across normals.
    for (int i = 0; i < contact.count; ++i) {
      const Vec2 at = shown_point(context, contact, contact.points[static_cast<std::size_t>(i)].position);
      context.labels.avoid(at, at);
      context.labels.shun(at, at + normal_length(context) * contact.normal);
    }
  }
  for (const ShapeRecord& shape : context.world.shapes()) {
    if (shape.alive && std::find(bodies.begin(), bodies.end(), shape.body) != bodies.end())
      shun_outline(context, shape);
  }
}

}  // namespace

void draw_contacts(const OverlayContext& context, render::DrawList& list) {
  render::DrawLayer& layer = list[render::Layer::Contacts];
  if (context.selection.body) shun_outlines(context);
  for (const ContactReport& contact : context.world.report().contacts_list) {
    for (int i = 0; i < contact.count; ++i) {
      const ContactPointReport& point = contact.points[static_cast<std::size_t>(i)];
      const bool struck = point.impact_impulse > 0, loaded = point.normal_impulse > 0 || struck;
      const Vec2 at = shown_point(context, contact, point.position);
      add_contact(context, at, struck ? contact.impact_normal : contact.normal, loaded, 1, layer);
      if (is_selected(context.selection, contact))
        context.labels.add_off_edges(at, value_text(context, point), context.style.text);
    }
  }
  // Impacts last one step; where the contact has gone they fade.
  for (const Flash& flash : context.history.flashes()) {
    const double brightness = context.history.brightness(flash);
    if (flash.time < context.history.now())
      add_contact(context, flash.point, flash.normal, true, brightness, layer);
  }
  context.legend.marker(context.style.contact, context.style.contact, "contact");
  context.legend.arrow(context.style.normal, kNormalPx * render::ui_scale(context.camera.height_px),
                       "normal (direction only)");
}

}  // namespace skerry::sandbox
