// SPDX-License-Identifier: MIT
//
// Arrows for what contacts transmit: the impulse of impacts [N s], which fade, and the mean force of the last
// step [N], normal and friction. Each pair of arrows is action and reaction; fixed bodies get none.
#include <cmath>

#include "sandbox/layout.h"
#include "sandbox/overlays/registry.h"
#include "sandbox/scene_view.h"

namespace skerry::sandbox {
namespace {

constexpr double kLongest = 0.16;  // length of the longest arrow, as a share of the picture's height

/// Metres of arrow per unit of `quantity`, and the round amount that the legend shows.
struct ArrowScale {
  double metres_per_unit = 0;
  double legend_amount = 0;
};

// Fixed scales come from the script; otherwise the longest arrow so far gives one that changes seldom.
ArrowScale arrow_scale(const OverlayContext& context, std::optional<double> units_per_metre, double largest) {
  if (largest <= 0) return {};
  const double room = kLongest * context.camera.height;  // [m]
  const double metres_per_unit = units_per_metre ? 1 / *units_per_metre : round_down(room / largest);
  return {metres_per_unit, round_down_125(largest)};
}

bool is_fixed(const World& world, BodyId body) {
  return world.bodies().type[body.index] != BodyType::Dynamic;
}

void add_arrow(render::DrawLayer& layer, const render::Style& style, Vec2 from, Vec2 along,
               render::Color color) {
  layer.arrows.push_back({.from = to_point(from),
                          .to = to_point(from + along),
                          .color = color,
                          .width_px = style.arrow_px,
                          .head_px = style.arrow_head_px});
}

void add_pair(const OverlayContext& context, const ContactReport& contact, Vec2 point, Vec2 on_b,
              render::Color color, render::DrawLayer& layer) {
  if (!is_fixed(context.world, contact.body_b)) add_arrow(layer, context.style, point, on_b, color);
  if (!is_fixed(context.world, contact.body_a)) add_arrow(layer, context.style, point, -on_b, color);
}

void add_legend(const OverlayContext& context, const ArrowScale& scale, render::Color color, const char* what,
                const char* unit) {
  const double length = scale.legend_amount * scale.metres_per_unit * context.camera.pixels_per_metre();
  context.legend.arrow(color, length, std::string(what) + " " + round_amount(scale.legend_amount, unit));
}

}  // namespace

void draw_impulses(const OverlayContext& context, render::DrawList& list) {
  render::DrawLayer& layer = list[render::Layer::Contacts];
  const render::Style& style = context.style;
  const History& history = context.history;
  const StepReport& report = context.world.report();

  const ArrowScale impulse =
      arrow_scale(context, context.demo.picture().impulse_scale, history.largest_impulse());
  for (const Flash& flash : history.flashes()) {
    const render::Color color = render::faded(style.impulse, history.brightness(flash));
    const Vec2 along = impulse.metres_per_unit * flash.impulse * flash.normal;
    if (!flash.fixed_b) add_arrow(layer, style, flash.point, along, color);
    if (!flash.fixed_a) add_arrow(layer, style, flash.point, -along, color);
  }
  if (history.largest_impulse() > 0) add_legend(context, impulse, style.impulse, "impact", "N s");

  const ArrowScale force = arrow_scale(context, context.demo.picture().force_scale, history.largest_force());
  if (history.largest_force() <= 0 || report.h <= 0) return;
  bool friction = false;
  for (const ContactReport& contact : report.contacts_list) {
    for (int i = 0; i < contact.count; ++i) {
      const ContactPointReport& point = contact.points[static_cast<std::size_t>(i)];
      const double normal_force = point.normal_impulse / report.h;
      if (normal_force <= history.force_floor(context.world)) continue;
      const Vec2 at = shown_point(context, contact, point.position);
      add_pair(context, contact, at, force.metres_per_unit * normal_force * contact.normal, style.force,
               layer);
      const double friction_force = point.friction_impulse / report.h;
      if (std::abs(friction_force) <= 1e-3 * history.largest_force()) continue;
      friction = true;
      add_pair(context, contact, at, force.metres_per_unit * friction_force * perp(contact.normal),
               style.friction, layer);
    }
  }
  add_legend(context, force, style.force, "force", "N");
  if (friction) add_legend(context, force, style.friction, "friction", "N");
}

}  // namespace skerry::sandbox
